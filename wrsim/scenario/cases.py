"""The poses of a static analysis in SI units: every combination of a grid, or the rows of a CSV table."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from wrsim.errors import InputError
from wrsim.inputs.toml_files import read_text, shown
from wrsim.inputs.values import Quantity, nearest
from wrsim.scenario.loading import Scenario
from wrsim.scenario.sections.analysis import MOST_POSES, Lateral, Load, Roll, StaticSection, Yaw

COLUMNS: dict[str, Quantity] = {"lateral_mm": Lateral, "yaw_mrad": Yaw, "load_kN": Load, "roll_mrad": Roll}
NEEDED = ("id", "lateral_mm", "load_kN")
MOST_FAULTS = 20
"""Faults of one table that are told before the rest is only counted."""


@dataclass(frozen=True)
class StaticPose:
    """What is prescribed: lateral shift [m], yaw [rad], vertical load [N], roll [rad] (one wheel only)."""

    name: str
    lateral: float
    yaw: float
    load: float
    roll: float = 0.0


def static_poses(scenario: Scenario) -> tuple[StaticPose, ...]:
    """Return the poses of [static] in the order of the file; names are unique.

    Raises InputError for a table that is missing or has faults, one line each with its line number.
    """
    section = scenario.spec.static
    if section is None:
        return ()
    if section.cases is not None:
        path = scenario.find(("static", "cases"), section.cases)
        return read_cases(path, with_roll=section.target == "wheel")
    return tuple(_grid(section))


def _grid(section: StaticSection) -> Iterator[StaticPose]:
    axes = {
        "y": section.lateral_mm,
        "yaw": section.yaw_mrad,
        "load": section.load_kN or (),
        "roll": section.roll_mrad,
    }
    seen: dict[str, int] = {}
    for values in product(*axes.values()):
        varied = [
            f"{name}{value:+.10g}" if name != "load" else f"{value:.10g}kN"
            for (name, axis), value in zip(axes.items(), values, strict=True)
            if len(axis) > 1 or name == "y"
        ]
        name = "_".join(varied)
        seen[name] = seen.get(name, 0) + 1
        if seen[name] > 1:
            name += f"_{seen[name]}"
        y, yaw, load, roll = values
        yield StaticPose(name, y / 1e3, yaw / 1e3, load * 1e3, roll / 1e3)


def read_cases(path: Path, with_roll: bool = True) -> tuple[StaticPose, ...]:
    """Read a CSV table of poses.

    Columns ``id, lateral_mm, load_kN`` and, where they are not zero, ``yaw_mrad, roll_mrad``, in any order;
    separated by commas or semicolons, decimals with a point. Empty lines and lines that start with # are
    left out.
    Raises InputError with every fault: file, line, column, value, what is allowed.
    """
    rows = _rows(read_text(path, "table of poses"), path)
    try:
        header_line, header = next(rows)
    except StopIteration:
        raise InputError(f"{path}: is empty; must have a line with the columns {', '.join(_all_columns())}") from None
    faults = list(_header_faults(header, f"{path}:{header_line}", with_roll))
    if faults:
        raise InputError("\n".join(faults))
    poses: list[StaticPose] = []
    lines: dict[str, int] = {}
    for line, cells in rows:
        where = f"{path}:{line}"
        if len(cells) != len(header):
            faults.append(f"{where}: has {len(cells)} cells; must have {len(header)} like the header")
            continue
        values, wrong = _values(dict(zip(header, cells, strict=True)), where)
        name = cells[header.index("id")]
        if not name:
            wrong.append(f"{where}: id is empty; must be a name of this pose")
        elif name in lines:
            wrong.append(f"{where}: id = {shown(name)}: is taken by line {lines[name]} already")
        faults += wrong
        if not wrong:
            lines[name] = line
            y, yaw, load, roll = (values[column] for column in COLUMNS)
            poses.append(StaticPose(name, y / 1e3, yaw / 1e3, load * 1e3, roll / 1e3))
        if len(poses) > MOST_POSES:
            raise InputError(f"{where}: more than {MOST_POSES} poses")
    if faults:
        more = [f"{path}: and {len(faults) - MOST_FAULTS} more faults"] if len(faults) > MOST_FAULTS else []
        raise InputError("\n".join(faults[:MOST_FAULTS] + more))
    if not poses:
        raise InputError(f"{path}: has no poses below its header")
    return tuple(poses)


def _rows(text: str, path: Path) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of every line that is not empty and no comment."""
    kept = [
        (number, line)
        for number, line in enumerate(text.split("\n"), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not kept:
        return
    separator = ";" if ";" in kept[0][1] and "," not in kept[0][1] else ","
    for number, line in kept:
        try:
            cells = next(csv.reader([line.rstrip("\r")], delimiter=separator, strict=True))
        except csv.Error as error:
            raise InputError(f"{path}:{number}: no line of a CSV table: {error}") from None
        yield number, [cell.strip() for cell in cells]


def _all_columns() -> tuple[str, ...]:
    return ("id", *COLUMNS)


def _header_faults(header: list[str], where: str, with_roll: bool) -> Iterator[str]:
    guessed: set[str] = set()
    for column in header:
        if column in _all_columns():
            continue
        near = nearest(column, _all_columns())
        guessed.update([near] if near else [])
        hint = f"did you mean '{near}'?" if near else f"the columns are {', '.join(_all_columns())}"
        yield f"{where}: column {shown(column)}: unknown; {hint}"
    for column in sorted({c for c in header if header.count(c) > 1}):
        yield f"{where}: column {shown(column)}: stands there twice"
    for column in NEEDED:
        if column not in header and column not in guessed:
            yield f"{where}: column '{column}' is missing; the columns are {', '.join(_all_columns())}"
    if "roll_mrad" in header and not with_roll:
        yield f"{where}: column 'roll_mrad': is for target = \"wheel\" only: a wheelset finds its own roll"


def _values(cells: dict[str, str], where: str) -> tuple[dict[str, float], list[str]]:
    values: dict[str, float] = {}
    faults: list[str] = []
    for column, quantity in COLUMNS.items():
        text = cells.get(column, "0")
        try:
            number = float(text)
        except ValueError:
            hint = f"; decimals need a point: {text.replace(',', '.')}" if _has_decimal_comma(text) else ""
            faults.append(f"{where}: {column} = {shown(text)}: must be {quantity.words()}{hint}")
            continue
        if not quantity.holds(number):
            faults.append(f"{where}: {column} = {text}: must be {quantity.words()}")
        values[column] = number
    return values, faults


def _has_decimal_comma(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return "," in text
