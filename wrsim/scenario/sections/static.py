"""[static]: poses of one wheel or of a wheelset, every combination of a grid or the rows of a CSV table."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from wrsim.contact.pose import Pose
from wrsim.errors import InputError
from wrsim.inputs.csv_tables import read_columns
from wrsim.inputs.section import Fault
from wrsim.inputs.toml_files import shown_value
from wrsim.inputs.values import Series, number, positive, requirement, text
from wrsim.scenario.sections.table import PlanContext, PlanTable

Lateral = Annotated[float, number(-100, 100, "mm, positive to the left")]
Yaw = Annotated[float, number(-200, 200, "mrad, positive to the left")]
Load = Annotated[float, positive(1000, "kN, downwards")]
Roll = Annotated[float, number(-200, 200, "mrad, positive lifts the left wheel")]
WheelAngle = Annotated[float, number(-720, 720, "degrees, rolling forward")]

COLUMNS: dict[str, Any] = {"id": str, "lateral_mm": Lateral, "yaw_mrad": Yaw, "load_kN": Load, "roll_mrad": Roll,
                            "wheel_angle_deg": WheelAngle}  # fmt: skip
FACTORS = {"lateral_mm": 1e-3, "yaw_mrad": 1e-3, "load_kN": 1e3, "roll_mrad": 1e-3, "wheel_angle_deg": np.pi / 180.0}
"""Keys of a grid and their factors to SI units, in the order of a pose."""
MOST_POSES = 1_000_000


@dataclass(frozen=True)
class StaticPlan:
    """Poses to solve: of one wheel (that of ``side``) or of the wheelset; rolling or frictionless."""

    target: Literal["wheel", "wheelset"]
    side: Literal["left", "right"]
    rolling: bool
    poses: tuple[Pose, ...]

    def facts(self) -> dict[str, Any]:
        return {"poses": len(self.poses)}


class StaticSection(PlanTable, header="[static]"):
    """Poses of one wheel or of a wheelset at a prescribed vertical load.

    The poses are every combination of lateral_mm, yaw_mrad, load_kN, roll_mrad and wheel_angle_deg, or the rows of the
    CSV table ``cases``. The load is that of the one wheel, or of the whole wheelset, which finds its own roll.
    """

    target: Literal["wheel", "wheelset"]
    """One wheel in a prescribed pose, or a wheelset that finds its own roll."""
    side: Literal["left", "right"] = "left"
    """Which wheel."""
    lateral_mm: Series[Lateral] = (0.0,)
    """Lateral shift of the wheelset, positive to the left."""
    yaw_mrad: Series[Yaw] = (0.0,)
    """Angle of yaw, positive turns the front to the left."""
    load_kN: Series[Load] | None = None
    """Vertical load of the wheel, or of the whole wheelset."""
    roll_mrad: Series[Roll] = (0.0,)
    """Roll of a single wheel about the track's axis."""
    wheel_angle_deg: Series[WheelAngle] = (0.0,)
    """Angle by which wheels out of round have rolled."""
    cases: Annotated[str, text('a CSV file such as "poses.csv"')] | None = None
    """Table of poses, one a row, in place of all combinations."""
    rolling: bool = True
    """Whether the wheels roll and creep, or rest without friction."""

    @classmethod
    def raw_faults(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        grid = [key for key in FACTORS if key in raw]
        if "cases" in raw and grid:
            yield Fault("cases", f"cannot be given with {', '.join(grid)}: the poses come from one place")
        elif "cases" not in raw and "load_kN" not in raw:
            yield Fault("load_kN", f"must be {requirement(Series[Load])} (or give cases)", missing=True)
        if raw.get("target") == "wheelset":
            if "side" in raw:
                yield Fault("side", 'is for target = "wheel" only')
            if "roll_mrad" in raw:
                yield Fault("roll_mrad", 'is for target = "wheel" only: a wheelset finds its own roll')

    def consistency(self) -> Iterator[Fault]:
        count = len(self.lateral_mm) * len(self.yaw_mrad) * len(self.load_kN or ()) * len(self.roll_mrad)
        count *= len(self.wheel_angle_deg)
        if count > MOST_POSES:
            yield Fault((), f"describes {count} poses; must be at most {MOST_POSES}")

    def plan(self, context: PlanContext) -> StaticPlan:
        if self.cases is None:
            grid = product(*(getattr(self, key) or () for key in FACTORS))
            poses = named([Pose("", *(v * f for v, f in zip(row, FACTORS.values(), strict=True))) for row in grid])
        else:
            poses = read_cases(context.find(("static", "cases"), self.cases), with_roll=self.target == "wheel")
        return StaticPlan(self.target, self.side, self.rolling, poses)


def named(poses: Sequence[Pose]) -> tuple[Pose, ...]:
    """The poses, those without a name called by what varies (mm, mrad, kN). Raises InputError for a duplicate name."""
    values = [
        {"y": 1e3 * p.lateral, "yaw": 1e3 * p.yaw, "load": 1e-3 * p.load, "roll": 1e3 * p.roll,
         "angle": np.degrees(p.wheel_angle)}
        for p in poses
    ]  # fmt: skip
    varied = [name for name in values[0] if name == "y" or len({v[name] for v in values}) > 1] if values else []
    seen: dict[str, int] = {}
    for name in (p.name for p in poses if p.name):
        if name in seen:
            raise InputError(f"pose '{name}': there are two of this name")
        seen[name] = 1

    def free_name(numbers: dict[str, float]) -> str:
        parts = (f"{numbers[k]:.10g}kN" if k == "load" else f"{k}{numbers[k] + 0.0:+.10g}" for k in varied)
        name = "_".join(parts)
        seen[name] = seen.get(name, 0) + 1
        return name if seen[name] == 1 else f"{name}_{seen[name]}"

    return tuple(p if p.name else replace(p, name=free_name(numbers)) for p, numbers in zip(poses, values, strict=True))


def read_cases(path: Path, with_roll: bool = True) -> tuple[Pose, ...]:
    """Read a CSV table of poses.

    Columns ``id, lateral_mm, load_kN`` and, where they are not zero, ``yaw_mrad, roll_mrad, wheel_angle_deg``, in any
    order.
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
