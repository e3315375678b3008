"""A recording: its columns in SI units and our signs, at even distances."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from wrsim.errors import InputError, suggest
from wrsim.geometry.piecewise import Array
from wrsim.inputs.checking import check_section, opened
from wrsim.inputs.csv_tables import csv_cells, table_lines
from wrsim.recording.columns import ChannelSection, ColumnsFile, guessed

GAP = 1.5  # A distance between rows that is so many times the usual one is a gap
FEWEST = 40  # rows that a recording has at least


@dataclass(frozen=True, eq=False)
class TrackRecording:
    """start: distance of the first row [m]; step: between rows [m]; records: channels with their values (n,) in SI
    units and our signs (`docs/user/recording.md`); guessed: whether columns' meaning comes from their names; unused:
    the other columns.
    """

    path: Path
    columns: ColumnsFile
    start: float
    step: float
    records: tuple[tuple[ChannelSection, Array], ...]
    guessed: bool
    unused: tuple[str, ...]

    @property
    def distance(self) -> Array:
        """From the first row on [m]."""
        return np.asarray(self.step * np.arange(self.records[0][1].size))

    @property
    def length(self) -> float:
        return float(self.distance[-1])

    def of(self, quantity: str) -> list[tuple[ChannelSection, Array]]:
        """Records of a quantity: several where they are of several bands."""
        return [(c, r) for c, r in self.records if c.quantity == quantity]


def recording_from(
    path: Path,
    columns: Path | None = None,
    *,
    chord: Sequence[float] | None = None,
    band: str | None = None,
    part: tuple[float | None, float | None] = (None, None),
) -> TrackRecording:
    """Read a recording (CSV: commas, or semicolons with decimal points or commas).

    columns: the column map; without one the columns' names decide. chord, band: see `columns.guessed`. part: from
    and to which distance of the file [m]. Raises InputError that names file, line and column: for cells that are no
    numbers, gaps, distances that repeat or run backward, and columns that are not there.
    """
    header, rows, numbers, decimal = _table(path)
    where = f"{path}:{numbers[0]}"
    if columns is not None:
        chosen = check_section(ColumnsFile, *opened(columns, "column map"))
        for c in chosen.channels:
            if c.column not in header:
                hint = suggest(c.column, header) or f"; its columns are {', '.join(header)}"
                raise InputError(f"{columns}: channels: column '{c.column}' is not in {path}{hint}")
    else:
        found = guessed(header, where, chord, band)
        if not any(c["quantity"] == "distance" for c in found):
            hint = f"write a column map ({path.stem}.toml beside it, or --columns) for: {', '.join(header)}"
            raise InputError(f"{where}: no column looks like a distance; {hint}")
        for guess in found:
            if guess["quantity"].startswith(("alignment", "level")) and not {"band", "chord_m"} & set(guess):
                hint = "give --chord-m BEHIND AHEAD or --band D1, or write a column map"
                raise InputError(f"{where}: column '{guess['column']}': measured by a chord or inertially? {hint}")

        def place(key: tuple[str | int, ...]) -> str:
            number = next((k for k in key if isinstance(k, int)), None)
            return where if number is None else f"{where}: column '{found[number]['column']}'"

        chosen = check_section(ColumnsFile, {"channels": found}, place)
    values = {
        c.column: _numbers(path, header.index(c.column), c.column, rows, numbers, decimal) for c in chosen.channels
    }
    along = next(c for c in chosen.channels if c.quantity == "distance")
    distance = values[along.column] * along.factor
    low, high = (end if own is None else own for own, end in zip(part, (-np.inf, np.inf), strict=True))
    inside = np.flatnonzero((distance >= low) & (distance <= high))
    if inside.size < FEWEST:
        within = "" if part == (None, None) else f" from {low:g} to {high:g} m"
        few = f"the table ends after {inside.size} rows{within}; needs at least {FEWEST}"
        raise InputError(f"{path}:{numbers[-1]}: {few}")
    first, last = int(inside[0]), int(inside[-1]) + 1
    distance, lines = distance[first:last], numbers[1:][first:last]
    _check_distance(path, along.column, distance, lines)
    measured = [c for c in chosen.channels if c.quantity != "distance"]
    for c in measured:
        bad = np.flatnonzero(~np.isfinite(values[c.column][first:last]))
        if bad.size:
            at, hint = bad[0], _longest(distance, values, measured, first, last)
            gap = f"is empty, a gap at {distance[at]:g} m: filters need every row; take a part without gaps{hint}"
            raise InputError(f"{path}:{lines[at]}: column '{c.column}': {gap}")
    step = (distance[-1] - distance[0]) / (distance.size - 1)
    even = distance[0] + step * np.arange(distance.size)
    uneven = np.abs(even - distance).max() > 1e-3 * step
    si = [(c, values[c.column][first:last] * c.factor) for c in measured]
    records = tuple((c, np.asarray(CubicSpline(distance, r)(even)) if uneven else r) for c, r in si)
    unused = tuple(name for name in header if name not in values)
    return TrackRecording(path, chosen, float(distance[0]), float(step), records, columns is None, unused)


def _table(path: Path) -> tuple[list[str], list[list[str]], list[int], str]:
    """Header, cells of the rows, numbers of the lines (the header's first), and the decimal sign."""
    lines = table_lines(path, "recording", latin=True)
    if len(lines) < 2:
        raise InputError(f"{path}: has no rows; its first line must name the columns, rows of numbers follow")
    separator = max(";\t,", key=lambda sign: (lines[0][1].count(sign), sign == ";"))
    decimal = "," if separator != "," and any("," in line for _, line in lines[1:50]) else "."
    cells = [csv_cells(path, *line, separator)[1] for line in lines]
    header = cells[0]
    for name, times in Counter(header).items():
        if times > 1:
            raise InputError(f"{path}:{lines[0][0]}: column '{name}': duplicate")
    for (i, _), row in zip(lines, cells, strict=True):
        if len(row) != len(header):
            raise InputError(f"{path}:{i}: has {len(row)} cells; must have {len(header)} like the header")
    return header, cells[1:], [i for i, _ in lines], decimal


EMPTY = ("", "nan", "-", "na", "n/a", "null")  # cells without a number


def _numbers(path: Path, column: int, name: str, rows: list[list[str]], lines: list[int], decimal: str) -> Array:
    """A column; not-a-number where a cell is empty."""
    found = np.empty(len(rows))
    for i, row in enumerate(rows):
        cell, where = row[column], f"{path}:{lines[i + 1]}: column '{name}' = '{row[column]}'"
        try:
            found[i] = float(cell if decimal == "." else cell.replace(",", "."))
        except ValueError:
            if cell.lower() not in EMPTY:
                raise InputError(f"{where}: must be a number") from None
            found[i] = np.nan
        if np.isinf(found[i]):
            raise InputError(f"{where}: must be a finite number")
    return found


def _check_distance(path: Path, name: str, distance: Array, lines: list[int]) -> None:
    """Raises InputError unless the distances rise evenly enough."""
    missing = np.flatnonzero(~np.isfinite(distance))
    if missing.size:
        raise InputError(f"{path}:{lines[int(missing[0])]}: column '{name}': is empty; every row needs its distance")
    steps = np.diff(distance)
    usual = float(np.median(np.abs(steps)))
    for bad, words in (
        (steps == 0.0, "repeats: every row needs a distance of its own"),
        (steps < 0.0, "runs backward: distances must rise; turn a recording of the other direction round"),
    ):
        if bad.any():
            i = int(np.argmax(bad))
            where = f"{path}:{lines[i + 1]}: column '{name}' = {distance[i + 1]:.10g} m after {distance[i]:.10g} m"
            raise InputError(f"{where} {words}")
    wide = steps > GAP * usual
    if wide.any():
        i = int(np.argmax(wide))
        longest = max(np.split(distance, np.flatnonzero(wide) + 1), key=len)
        raise InputError(
            f"{path}:{lines[i + 1]}: column '{name}' = {distance[i + 1]:.10g} m after {distance[i]:.10g} m: a gap; "
            f"rows are {usual:.4g} m apart and filters need every one; take a part without gaps: "
            f"--from-m {longest[0]:.10g} --to-m {longest[-1]:.10g}"
        )


def _longest(distance: Array, values: dict[str, Array], measured: list[ChannelSection], first: int, last: int) -> str:
    """A hint at the longest part in which every cell is filled."""
    filled = np.all([np.isfinite(values[c.column][first:last]) for c in measured], axis=0)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], filled.astype(int), [0])))).reshape(-1, 2)
    if not len(edges):
        return " (--from-m, --to-m)"
    begin, end = edges[int(np.argmax(edges[:, 1] - edges[:, 0]))]
    return f": --from-m {distance[begin]:.10g} --to-m {distance[end - 1]:.10g} is the longest"
