"""A recording: its columns in SI units and our signs, at even distances that rise."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from wrsim.errors import InputError, suggest
from wrsim.inputs.checking import check_section, opened
from wrsim.recording.columns import LENGTHS, SIGNS, ChannelSection, ColumnsFile
from wrsim.recording.dropouts import Mask, bridged, codes, runs, spikes
from wrsim.recording.layout import EMPTY, STATION, RecordedTable, read_table
from wrsim.recording.names import FINEST, guessed, is_us_chord, known, stated_unit
from wrsim.track.piecewise import Array

GAP = 1.5  # A distance between rows that is so many times the usual one is a gap
FEWEST = 40  # rows that a recording has at least
OFF_GAUGE = 0.05  # [m]; no curve widens the gauge so far (35 mm), no other gauge is so near (1372 mm: 63 mm)
MOST_NAMED = 5  # places of dropouts and spikes that are named
Records = list[tuple[ChannelSection, Array]]


@dataclass(frozen=True, eq=False)
class TrackRecording:
    """start: distance of the first row [m]; step: between rows [m]; records: channels with their values (n,) in SI
    units and our signs (`docs/user/recording.md`), with rising distance; guessed: whether columns' meaning comes from
    their names; unused: the other columns; notes: what was assumed, turned round and bridged, for the user.
    """

    path: Path
    columns: ColumnsFile
    start: float
    step: float
    records: tuple[tuple[ChannelSection, Array], ...]
    guessed: bool
    unused: tuple[str, ...]
    notes: tuple[str, ...] = ()

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
    bridge: float = 3.0,
) -> TrackRecording:
    """Read a recording (`layout.read_table`).

    columns: the column map; without one the columns' names decide. chord, band: see `names.guessed`. part: from
    and to which distance of the file [m]; bridge: longest dropout that is bridged [m]; longer ones split the recording.
    Raises InputError that names file, line and column: for cells that are no numbers, distances that repeat or run to
    and fro, columns that are not there, and a gauge that is none.
    """
    mapped = None if columns is None else check_section(ColumnsFile, *opened(columns, "column map"))
    table = read_table(path, known if mapped is None else {c.column for c in mapped.channels}.__contains__)
    notes = list(table.notes)
    chosen = _by_names(path, table, chord, band, notes) if mapped is None else mapped
    chosen = chosen.model_copy(update={"channels": tuple(_in_stated_unit(c, table) for c in chosen.channels)})
    for c in chosen.channels:
        if c.column not in table.header:
            hint = suggest(c.column, table.header) or f"; its columns are {', '.join(table.header)}"
            raise InputError(f"{columns}: channels: column '{c.column}' is not in {path}{hint}")
    along = [c for c in chosen.channels if c.quantity == "distance"]
    measured = [c for c in chosen.channels if c.quantity != "distance"]
    distance = np.sum([c.si(_numbers(path, table, c)) for c in along], axis=0)
    order = np.arange(distance.size)
    if falls := distance.size > 1 and bool(np.nanmedian(np.diff(distance)) < 0.0):
        order = order[::-1]
    low, high = (end if limit is None else limit for limit, end in zip(part, (-np.inf, np.inf), strict=True))
    inside = np.flatnonzero((distance[order] >= low) & (distance[order] <= high))
    if inside.size < FEWEST:
        within = "" if part == (None, None) else f" from {low:g} to {high:g} m"
        few = f"the table ends after {inside.size} rows{within}; needs at least {FEWEST}"
        raise InputError(f"{path}:{table.lines[-1]}: {few}")
    order = order[inside[0] : inside[-1] + 1]
    _check_distance(path, along[0].column, distance[order], np.array(table.lines)[order])
    values = [_numbers(path, table, c)[order] for c in measured]
    for c, column in zip(measured, values, strict=True):
        column[codes(column)] = np.nan
        _check_values(path, table.where, chosen, c, column)
        column[(c.quantity == "gauge") & (column == 0.0)] = np.nan
    distance, values = _with_missing_rows(distance[order], values, bridge)
    exchanged = falls and chosen.sides == "car"
    channels = [c.turned() if exchanged else c for c in measured]
    records = [(c, c.si(column)) for c, column in zip(channels, values, strict=True)]
    if falls:
        exchange = "rails and signs are exchanged" if exchanged else "rails and signs are those of the line"
        notes.append(f'distances fall: the recording is reversed, {exchange} (sides = "{chosen.sides}")')
    if chosen.spikes == "bridge":
        records = _without_spikes(distance, records, notes)
    distance, records = _longest_part(distance, records, bridge, notes)
    step = (distance[-1] - distance[0]) / (distance.size - 1)
    even = distance[0] + step * np.arange(distance.size)
    if np.abs(even - distance).max() > 1e-3 * step:
        records = [(c, np.asarray(CubicSpline(distance, r)(even))) for c, r in records]
    if exchanged:  # the base of twist lies behind the car
        records = [(c, np.interp(even - c.base, even, r) if c.kind == "twist" else r) for c, r in records]
    used = {c.column for c in chosen.channels}
    unused = tuple(name for name in table.header if name and name not in used)
    start = float(distance[0])
    return TrackRecording(path, chosen, start, float(step), tuple(records), mapped is None, unused, tuple(notes))


def _in_stated_unit(channel: ChannelSection, table: RecordedTable) -> ChannelSection:
    """A channel of a map; where that has no unit, with the one that the table states."""
    stated = stated_unit(channel.column, table.units)
    return channel if channel.unit or stated not in channel.units else channel.model_copy(update={"unit": stated})


def _by_names(
    path: Path, table: RecordedTable, chord: Sequence[float] | None, band: str | None, notes: list[str]
) -> ColumnsFile:
    """The columns as their names and units tell, with what is assumed written out and noted."""
    channels = guessed(table.header, table.where, chord, band, table.units)
    along = [c for c in channels if c["quantity"] == "distance"]
    if not along:
        hint = f"write a column map ({path.stem}.toml beside it, or --columns) for: {', '.join(table.header)}"
        raise InputError(f"{table.where}: no column looks like a distance; {hint}")
    kept = _along(path, table, along)
    channels = [c for c in channels if c["quantity"] != "distance" or c in kept]
    assumed: dict[str, list[str]] = {}
    signs: list[str] = []
    for c in channels:
        if c["quantity"].startswith(("alignment", "level")) and not {"band", "band_m", "chord_m"} & set(c):
            hint = "give --chord-m BEHIND AHEAD or --band D1, or write a column map"
            raise InputError(f"{table.where}: column '{c['column']}': measured by a chord or inertially? {hint}")
        section = ChannelSection.model_validate(c)
        if "unit" not in c:
            c["unit"] = "in" if is_us_chord(c.get("chord_m", (0.0,))[0]) else next(iter(section.units))
            if c["quantity"] == "distance" and _step(_numbers(path, table, section)) < FINEST:
                c["unit"] = "km"
            assumed.setdefault(c["unit"], []).append(c["column"])
        if section.kind in SIGNS:
            c["positive"] = SIGNS[section.kind][0]
            signs.append(c["positive"])
        if c["quantity"] == "twist" and "base_m" not in c:
            c["base_m"] = section.base
            assumed.setdefault(f"base {section.base:g} m", []).append(c["column"])
    texts = [f"{assumption} of {', '.join(columns)}" for assumption, columns in assumed.items()]
    texts += [f"positive is {', '.join(dict.fromkeys(signs))}"] * bool(signs)
    if middle := [c["column"] for c in channels if "chord_m" in c and c["chord_m"] != list(chord or ())]:
        texts.append(f"the middle of the chord is measured: {', '.join(middle)}")
    if texts:
        notes.append(f"assumed, as the file does not say: {'; '.join(texts)} (a column map says otherwise)")

    def place(key: tuple[str | int, ...]) -> str:
        number = next((k for k in key if isinstance(k, int)), None)
        return table.where if number is None else f"{table.where}: column '{channels[number]['column']}'"

    return check_section(ColumnsFile, {"channels": channels}, place)


def _along(path: Path, table: RecordedTable, channels: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The first of several columns of distance, or whole kilometres or miles and what lies beyond them."""
    sections = [ChannelSection.model_validate(c) for c in channels]
    values = [_numbers(path, table, s) for s in sections]
    for i, coarse in enumerate(sections):
        for j, fine in enumerate(sections):
            size = coarse.units[coarse.unit or "m"]
            whole = size > fine.units[fine.unit or "m"] and bool((values[i] % 1.0 == 0.0).all())
            if whole and np.abs(fine.si(values[j])).max() <= 1.2 * size:  # some kilometres are longer than others
                return [channels[i], channels[j]]
    return channels[:1]


def _step(distance: Array) -> float:
    """Usual distance of the rows, whatever its direction."""
    return float(np.nanmedian(np.abs(np.diff(distance)))) if distance.size > 1 else 1.0


def _numbers(path: Path, table: RecordedTable, channel: ChannelSection) -> Array:
    """A column in its own unit; see `column_numbers`."""
    return column_numbers(path, table, channel.column, channel.quantity == "distance", channel.unit)


def column_numbers(
    path: Path, table: RecordedTable, name: str, distance: bool = False, unit: str | None = None
) -> Array:
    """A column in its own unit; not-a-number where a cell has none. distance: may have stations. Raises InputError."""
    i = table.header.index(name)
    values, far = np.empty(len(table.rows)), []
    whole = np.zeros(values.size)
    for row, cells in enumerate(table.rows):
        cell, where = cells[i], f"{path}:{table.lines[row]}: column '{name}' = '{cells[i]}'"
        text = cell if table.decimal == "." else cell.replace(",", ".")
        if distance and (station := STATION.fullmatch(text)):
            whole[row], text = float(station[1]), station[2]
            far.append(float(text))
        try:
            values[row] = float(text)
        except ValueError:
            if not EMPTY.fullmatch(cell):
                raise InputError(f"{where}: must be a number") from None
            values[row] = np.nan
        if np.isinf(values[row]):
            raise InputError(f"{where}: must be a finite number")
    if not far:
        return values
    hundreds = max(far) < 100.0
    if unit != "ft" and hundreds and np.ptp(whole) > 0.0:
        stations = f"stations of 100 ('{table.rows[0][i]}'), no kilometres: needs the unit ft"
        raise InputError(f"{table.where}: column '{name}': has {stations}")
    size = (100.0 if hundreds else 5280.0) if unit == "ft" else 1.0 if unit == "km" else 1e3
    return size * whole + (1e-3 * values if unit == "km" else values)


def _check_distance(path: Path, name: str, distance: Array, lines: Array) -> None:
    """Raises InputError unless the distances rise."""
    missing = np.flatnonzero(~np.isfinite(distance))
    if missing.size:
        raise InputError(f"{path}:{lines[int(missing[0])]}: column '{name}': is empty; every row needs its distance")
    steps = np.diff(distance)
    for bad, fault in (
        (steps == 0.0, "repeats: every row needs a distance of its own"),
        (steps < 0.0, "runs backward: distances must rise or fall all along"),
    ):
        if bad.any():
            i = int(np.argmax(bad))
            where = f"{path}:{lines[i + 1]}: column '{name}' = {distance[i + 1]:.10g} m after {distance[i]:.10g} m"
            raise InputError(f"{where} {fault}")


def _check_values(path: Path, where: str, chosen: ColumnsFile, channel: ChannelSection, values: Array) -> None:
    """Raises InputError for a column without numbers, and for a gauge that is none, with what it may be."""
    if not np.isfinite(values).any():
        raise InputError(f"{where}: column '{channel.column}': has no numbers")
    if not channel.quantity.startswith("gauge"):
        return
    nominal, median = chosen.gauge_mm / 1e3, float(np.nanmedian(values))
    size = abs(float(channel.si(np.array(median))))
    deviates = channel.quantity == "gauge_deviation"
    if abs(size - (0.0 if deviates else nominal)) <= OFF_GAUGE:
        return
    fits = [unit for unit in LENGTHS if abs(median * LENGTHS[unit] - nominal) <= OFF_GAUGE]
    hint = f"gauge_mm = {1e3 * size:.0f}" if 0.4 < size < 2.0 else "another unit"
    if deviates and abs(size - nominal) <= OFF_GAUGE:
        hint = 'quantity = "gauge"'
    elif size <= OFF_GAUGE and not fits:
        hint = 'quantity = "gauge_deviation"'
    elif fits:
        hint = f'unit = "{fits[0]}"'
    line = f"no deviation of a gauge of {1e3 * nominal:g} mm" if deviates else f"no gauge of {1e3 * nominal:g} mm"
    unit: str = channel.unit or next(iter(channel.units))
    median_is = f"its median, {round(median, 3):g} {unit}, is {line}; {hint}?"
    raise InputError(f"{where}: column '{channel.column}': {median_is} Say so in a column map ({path.stem}.toml)")


def _with_missing_rows(distance: Array, values: list[Array], bridge: float) -> tuple[Array, list[Array]]:
    """Rows without numbers where some are missing, so many that they are bridged or no more."""
    usual = _step(distance)
    gaps = np.flatnonzero(np.diff(distance) > GAP * usual)
    counts = np.minimum(np.round(np.diff(distance)[gaps] / usual).astype(int) - 1, int(bridge / usual) + 3)
    counts = np.maximum(counts, 1)
    places = np.repeat(gaps + 1, counts)
    between = [np.linspace(distance[i], distance[i + 1], n + 2)[1:-1] for i, n in zip(gaps, counts, strict=True)]
    inserted = np.insert(distance, places, np.concatenate(between)) if between else distance
    return inserted, [np.insert(column, places, np.nan) for column in values]


def _without_spikes(distance: Array, records: Records, notes: list[str]) -> Records:
    """The records with not-a-number in place of spikes, which a note names."""
    masks = [spikes(record, _step(distance), c.kind) for c, record in records]
    if places := _places(distance, records, masks):
        notes.append(f'spikes are bridged (spikes = "keep" leaves them): {places}')
    return [(c, np.where(mask, np.nan, record)) for (c, record), mask in zip(records, masks, strict=True)]


def _places(distance: Array, records: Records, masks: Sequence[Mask]) -> str:
    """Where masks of the records begin, with their columns: the first places, and how many more there are."""
    columns: dict[int, list[str]] = {}
    for (c, _), mask in zip(records, masks, strict=True):
        for begin, _ in runs(mask):
            columns.setdefault(int(begin), []).append(c.column)
    texts = [f"{distance[i]:.10g} m ({', '.join(columns[i])})" for i in sorted(columns)]
    return _first(texts)


def _first(texts: list[str]) -> str:
    return ", ".join(texts[:MOST_NAMED]) + (f" and {len(texts) - MOST_NAMED} more" if texts[MOST_NAMED:] else "")


def _longest_part(distance: Array, records: Records, bridge: float, notes: list[str]) -> tuple[Array, Records]:
    """The longest part without dropouts longer than those that are bridged. Raises InputError if it is too short."""
    filled = [(c, bridged(distance, r, bridge)) for c, r in records]
    whole = np.all([np.isfinite(r) for _, r in filled], axis=0)
    parts = runs(whole)
    if not len(parts):
        raise InputError(f"no part of the recording has all of {', '.join(c.column for c, _ in records)}")
    begin, end = parts[int(np.argmax(parts[:, 1] - parts[:, 0]))]
    inner = [(c, r[begin:end]) for c, r in records]
    if places := _places(distance[begin:end], inner, [~np.isfinite(r) for _, r in inner]):
        notes.append(f"dropouts and spikes of at most {bridge:g} m are bridged: {places}")
    if end - begin < distance.size:
        ends = [f"{distance[i]:.10g} to {distance[j - 1]:.10g} m" for i, j in parts if j - i >= FEWEST]
        taken = f"{distance[begin]:.10g} to {distance[end - 1]:.10g} m is taken"
        message = f"dropouts of more than {bridge:g} m split the recording ({_first(ends)}): {taken}"
        notes.append(f"{message}; the other parts come with --from-m and --to-m")
    return distance[begin:end], [(c, r[begin:end]) for c, r in filled]
