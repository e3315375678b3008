"""The poses of a static analysis in SI units: every combination of a grid, or the rows of a CSV table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from wrsim.errors import InputError
from wrsim.inputs.csv_tables import read_columns
from wrsim.inputs.toml_files import shown
from wrsim.inputs.values import number, positive

Lateral = Annotated[float, number(-100, 100, "mm, positive to the left")]
Yaw = Annotated[float, number(-200, 200, "mrad, positive to the left")]
Load = Annotated[float, positive(1000, "kN, downwards")]
Roll = Annotated[float, number(-200, 200, "mrad, positive lifts the left wheel")]

MOST_POSES = 1_000_000

COLUMNS: dict[str, Any] = {"id": str, "lateral_mm": Lateral, "yaw_mrad": Yaw, "load_kN": Load, "roll_mrad": Roll}
FACTORS = {"lateral_mm": 1e-3, "yaw_mrad": 1e-3, "load_kN": 1e3, "roll_mrad": 1e-3}
"""To SI units, in the order of a pose."""


@dataclass(frozen=True)
class StaticPose:
    """What is prescribed: lateral shift [m], yaw [rad], vertical load [N], roll [rad] (one wheel only)."""

    name: str
    lateral: float
    yaw: float
    load: float
    roll: float = 0.0


def grid_of_poses(axes: Mapping[str, Sequence[float]]) -> Iterator[StaticPose]:
    """Every combination of ``y`` [mm], ``yaw`` [mrad], ``load`` [kN] and ``roll`` [mrad]; names are unique."""
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
            raise InputError(f"{path}:{line}: id = {shown(name)}: is taken by line {taken[name]} already")
        taken[str(name)] = int(line)
    nothing = np.zeros(lines.size)
    columns = (table.get(name, nothing) * factor for name, factor in FACTORS.items())
    return tuple(StaticPose(name, *map(float, row)) for name, *row in zip(taken, *columns, strict=True))
