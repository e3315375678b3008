"""[conicity]: at which amplitudes, and how the wheelset's shift is counted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

from wrsim.inputs.values import Series, positive
from wrsim.scenario.sections.table import Given, PlanTable

Roll = Literal["none", "rail-top", "centre"]

Amplitude = Annotated[float, positive(30, "mm")]
AMPLITUDES = tuple(round(1.0 + 0.1 * i, 1) for i in range(61))
"""1 to 7 mm in steps of 0.1 mm."""


@dataclass(frozen=True)
class ConicityPlan:
    """Amplitudes [m] and what the lateral shift is.

    roll = "none": the wheelset does not roll, as in EN 15302. "rail-top": it rolls until both wheels touch, the shift
    is that of its point at the height of the rail tops, which makes the kinematics of rolling exact. "centre": it
    rolls, the shift is that of its centre of mass, the ``lateral_shift`` of a run.
    """

    amplitudes: tuple[float, ...]
    roll: Roll = "none"

    def facts(self) -> dict[str, Any]:
        """What a user checks."""
        return {"amplitudes": len(self.amplitudes)}


class ConicitySection(PlanTable):
    """Amplitudes of the equivalent conicity, and how the wheelset's shift is counted."""

    header: ClassVar[str] = "[conicity]"
    aliases: ClassVar[dict[str, str]] = {"amplitude_mm": "amplitudes_mm y_mm"}

    amplitude_mm: Series[Amplitude] = AMPLITUDES
    """Amplitudes of the lateral motion for which the conicity is found."""
    roll: Roll = "none"
    """What the lateral shift is: without roll as in EN 15302, at the rail tops, or at the wheelset's centre."""

    def plan(self, given: Given) -> ConicityPlan:
        """The same in SI units."""
        return ConicityPlan(tuple(a / 1000.0 for a in self.amplitude_mm), self.roll)
