"""[static]: poses of one wheel or of a wheelset."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from wrsim.contact.pose import Pose
from wrsim.inputs.section import Fault
from wrsim.inputs.values import Series, Switch, text, words
from wrsim.scenario.cases import MOST_POSES, Lateral, Load, Roll, Yaw, grid_of_poses, read_cases
from wrsim.scenario.sections.table import Given, PlanTable

GRID = ("lateral_mm", "yaw_mrad", "load_kN", "roll_mrad")


@dataclass(frozen=True)
class StaticPlan:
    """Poses to solve: of one wheel (then ``side`` says which) or of the wheelset; rolling or frictionless.

    files: what they were read from.
    """

    target: Literal["wheel", "wheelset"]
    side: Literal["left", "right"]
    rolling: bool
    poses: tuple[Pose, ...]
    files: tuple[Path, ...] = ()

    def facts(self) -> dict[str, Any]:
        """What a user checks."""
        return {"poses": len(self.poses)}


class StaticSection(PlanTable, header="[static]"):
    """Poses of one wheel or of a wheelset at a prescribed vertical load.

    The poses are every combination of lateral_mm, yaw_mrad, load_kN and roll_mrad, or the rows of the CSV
    table ``cases``. The load is that of the one wheel, or of the whole wheelset, which finds its own roll.
    """

    aliases: ClassVar[dict[str, str]] = {
        "lateral_mm": "y_mm shift_mm lateral_shift_mm", "yaw_mrad": "attack_mrad angle_of_attack_mrad",
        "load_kN": "force_kN Q_kN wheel_load_kN axle_load_kN", "cases": "file csv table", "side": "wheel",
    }  # fmt: skip

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
    cases: Annotated[str, text('a CSV file such as "poses.csv"')] | None = None
    """Table of poses, one a row, in place of all combinations."""
    rolling: Switch = True
    """Whether the wheels roll and creep, or stand without friction."""

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """A grid or a table; side and roll for a single wheel only."""
        grid = [key for key in GRID if key in raw]
        if "cases" in raw and grid:
            yield Fault("cases", f"cannot stand next to {', '.join(grid)}: the poses come from one place")
        elif "cases" not in raw and "load_kN" not in raw:
            yield Fault("load_kN", f"must be {words(Series[Load])} (or give cases)", missing=True)
        if raw.get("target") == "wheelset":
            if "side" in raw:
                yield Fault("side", 'is for target = "wheel" only')
            if "roll_mrad" in raw:
                yield Fault("roll_mrad", 'is for target = "wheel" only: a wheelset finds its own roll')

    def consistency(self) -> Iterator[Fault]:
        """The grid must stay countable."""
        count = len(self.lateral_mm) * len(self.yaw_mrad) * len(self.load_kN or ()) * len(self.roll_mrad)
        if count > MOST_POSES:
            yield Fault((), f"describes {count} poses; must be at most {MOST_POSES}")

    def plan(self, given: Given) -> StaticPlan:
        """The poses in the order of the file."""
        if self.cases is None:
            axes = {"y": self.lateral_mm, "yaw": self.yaw_mrad, "load": self.load_kN or (), "roll": self.roll_mrad}
            return StaticPlan(self.target, self.side, self.rolling, tuple(grid_of_poses(axes)))
        file = given.find(("static", "cases"), self.cases)
        poses = read_cases(file, with_roll=self.target == "wheel")
        return StaticPlan(self.target, self.side, self.rolling, poses, (file,))
