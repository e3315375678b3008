"""[conicity]: at which amplitudes, and how the wheelset's shift is counted."""

from dataclasses import dataclass
from math import degrees, radians
from typing import Annotated, Any, Literal

from wrsim.contact.profiles.flange import FLANGE_FROM
from wrsim.inputs.values import Series, number, positive
from wrsim.scenario.sections.table import PlanContext, PlanTable

Roll = Literal["none", "rail-top", "centre"]

CurveRadius = Annotated[float, number(10, 100_000, "m")]
FlangeAngle = Annotated[float, number(1, 89, "degrees of contact angle")]

Amplitude = Annotated[float, positive(30, "mm")]
AMPLITUDES = tuple(round(1.0 + 0.1 * i, 1) for i in range(61))
"""1 to 7 mm in steps of 0.1 mm."""


@dataclass(frozen=True)
class ConicityPlan:
    """Keys of `ConicitySection` in SI units.

    roll = "none": the wheelset does not roll, as in EN 15302. "rail-top": it rolls until both wheels touch, the shift
    is that of its point at the height of the rail tops, which makes the kinematics of rolling exact. "centre": it
    rolls, the shift is that of its centre of mass, the ``lateral_shift`` of a run.
    """

    amplitudes: tuple[float, ...]
    roll: Roll = "none"
    curves: tuple[float, ...] = ()
    flange_from: float = FLANGE_FROM

    def facts(self) -> dict[str, Any]:
        return {"amplitudes": len(self.amplitudes)}


class ConicitySection(PlanTable, header="[conicity]"):
    """Amplitudes of the equivalent conicity, and how the wheelset's shift is counted."""

    amplitude_mm: Series[Amplitude] = AMPLITUDES
    """Amplitudes of the lateral motion for which the conicity is found."""
    roll: Roll = "none"
    """What the lateral shift is: without roll as in EN 15302, at the rail tops, or at the wheelset's centre."""

    curve_radius_m: Series[CurveRadius] = ()
    """Radii of curves for which the radial steering index is given."""
    flange_from_deg: FlangeAngle = degrees(FLANGE_FROM)
    """Contact angle of the outer wheel from which it counts as on its flange, for the radial steering index."""

    def plan(self, context: PlanContext) -> ConicityPlan:
        amplitudes = tuple(a / 1000.0 for a in self.amplitude_mm)
        return ConicityPlan(amplitudes, self.roll, self.curve_radius_m, radians(self.flange_from_deg))
