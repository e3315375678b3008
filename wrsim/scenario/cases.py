"""The poses of a static analysis in SI units: every combination of a grid, or the rows of a CSV table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from wrsim.contact.pose import Pose
from wrsim.errors import InputError
from wrsim.inputs.csv_tables import read_columns
from wrsim.inputs.toml_files import shown_value
from wrsim.inputs.values import number, positive

Lateral = Annotated[float, number(-100, 100, "mm, positive to the left")]
Yaw = Annotated[float, number(-200, 200, "mrad, positive to the left")]
Load = Annotated[float, positive(1000, "kN, downwards")]
Roll = Annotated[float, number(-200, 200, "mrad, positive lifts the left wheel")]

MOST_POSES = 1_000_000

COLUMNS: dict[str, Any] = {"id": str, "lateral_mm": Lateral, "yaw_mrad": Yaw, "load_kN": Load, "roll_mrad": Roll}
FACTORS = {"lateral_mm": 1e-3, "yaw_mrad": 1e-3, "load_kN": 1e3, "roll_mrad": 1e-3}
"""To SI units, in the order of a pose."""


def grid_of_poses(axes: Mapping[str, Sequence[float]]) -> Iterator[Pose]:
    """Every combination of ``y`` [mm], ``yaw`` [mrad], ``load`` [kN] and ``roll`` [mrad]; names are unique."""
    varied = [name for name, axis in axes.items() if len(axis) > 1 or name == "y"]
    seen: dict[str, int] = {}
    for values in product(*axes.values()):
        y, yaw, load, roll = values
        name = _name(dict(zip(axes, values, strict=True)), varied, seen)
        yield Pose(name, y / 1e3, yaw / 1e3, load * 1e3, roll / 1e3)


def named(poses: Sequence[Pose]) -> tuple[Pose, ...]:
    """The poses, those without a name called as in a grid. Raises InputError for a name that is taken twice."""
    values = [{"y": 1e3 * p.lateral, "yaw": 1e3 * p.yaw, "load": 1e-3 * p.load, "roll": 1e3 * p.roll} for p in poses]
    varied = [name for name in ("y", "yaw", "load", "roll") if name == "y" or len({v[name] for v in values}) > 1]
    seen: dict[str, int] = {}
    for name in (p.name for p in poses if p.name):
        if name in seen:
            raise InputError(f"pose '{name}': there are two of this name")
        seen[name] = 1
    return tuple(p if p.name else replace(p, name=_name(v, varied, seen)) for p, v in zip(poses, values, strict=True))


def _name(values: Mapping[str, float], varied: Sequence[str], seen: dict[str, int]) -> str:
    """The name of a pose by those of its values (mm, mrad, kN) that vary, no name twice."""
    parts = (f"{values[k]:.10g}kN" if k == "load" else f"{k}{values[k] + 0.0:+.10g}" for k in varied)
    name = "_".join(parts)
    seen[name] = seen.get(name, 0) + 1
    return name if seen[name] == 1 else f"{name}_{seen[name]}"


def read_cases(path: Path, with_roll: bool = True) -> tuple[Pose, ...]:
    """Read a CSV table of poses.

    Columns ``id, lateral_mm, load_kN`` and, where they are not zero, ``yaw_mrad, roll_mrad``, in any order.
    Raises InputError with every fault: file, line, column, value, what is allowed.
    """
    table, lines = read_columns(path, COLUMNS, ("id", "lateral_mm", "load_kN"), "poses")
    if "roll_mrad" in table and not with_roll:
        raise InputError(f"{path}: column 'roll_mrad' is for target = \"wheel\" only: a wheelset finds its own roll")
    if lines.size > MOST_POSES:
        raise InputError(f"{path}: {lines.size} poses; allowed: {MOST_POSES}")
    taken: dict[str, int] = {}
    for name, line in zip(table["id"], lines, strict=True):
        if not name:
            raise InputError(f"{path}:{line}: id is empty; must be a name of this pose")
        if name in taken:
            raise InputError(f"{path}:{line}: id = {shown_value(name)}: is taken by line {taken[name]} already")
        taken[str(name)] = int(line)
    nothing = np.zeros(lines.size)
    columns = (table.get(name, nothing) * factor for name, factor in FACTORS.items())
    return tuple(Pose(name, *map(float, row)) for name, *row in zip(taken, *columns, strict=True))
