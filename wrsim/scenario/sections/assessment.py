"""[assessment]: what an assessment rests on besides the result."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from typing import Annotated, ClassVar, Literal

from wrsim.inputs.values import number
from wrsim.scenario.sections.table import Table

Kind = Literal["passenger", "locomotive", "freight"]


@dataclass(frozen=True)
class AssessmentSettings:
    """What an assessment rests on; None is taken from the result where it can be.

    kind of vehicle; axle_load 2Q0 of every wheelset [N]; friction: coefficient for Nadal's limit; flange_angle [rad];
    instability_frequency f0 [Hz]; section_length of every class of track [m]; straight_deficiency: cant deficiency [m]
    up to which curves of large radius belong to straight track.
    """

    kind: Kind = "passenger"
    axle_load: float | None = None
    friction: float | None = None
    flange_angle: float | None = None
    instability_frequency: float | None = None
    section_length: float | None = None
    straight_deficiency: float | None = None


class AssessmentSection(Table):
    """What an assessment rests on, where that is not to come from the result."""

    header: ClassVar[str] = "[assessment]"
    aliases: ClassVar[dict[str, str]] = {
        "vehicle_kind": "kind type",
        "friction": "mu",
        "flange_angle_deg": "flange_deg",
        "instability_frequency_Hz": "f0_Hz",
        "section_length_m": "section_m",
        "straight_deficiency_mm": "cant_deficiency_mm",
    }

    vehicle_kind: Kind = "passenger"
    """Kind of vehicle, which decides on limits."""
    axle_load_kN: Annotated[float, number(1, 500, "kN, 2 Q0 of one wheelset")] | None = None
    """Static load of one wheelset, for the limit of the track shifting force; from the result unless given."""
    friction: Annotated[float, number(0.01, 2, "for Nadal's limit; dry steel 0.3 to 0.5")] | None = None
    """Coefficient for Nadal's limit; from the scenario unless given."""
    flange_angle_deg: Annotated[float, number(45, 89, "degrees, S1002 70")] | None = None
    """Largest angle of the flange, for Nadal's limit; from the wheel profile unless given."""
    instability_frequency_Hz: Annotated[float, number(0.5, 30, "Hz")] | None = None
    """Frequency about which instability is looked for; found in the result unless given."""
    section_length_m: Annotated[float, number(5, 10_000, "m")] | None = None
    """Length of a track section of every class; that of EN 14363 unless given."""
    straight_deficiency_mm: Annotated[float, number(0, 200, "mm; UIC 518: 40")] | None = None
    """Cant deficiency up to which curves from R 600 m count as straight track; none do unless given."""

    def settings(self) -> AssessmentSettings:
        """The same in SI units."""
        return AssessmentSettings(
            kind=self.vehicle_kind,
            axle_load=None if self.axle_load_kN is None else self.axle_load_kN * 1e3,
            friction=self.friction,
            flange_angle=None if self.flange_angle_deg is None else radians(self.flange_angle_deg),
            instability_frequency=self.instability_frequency_Hz,
            section_length=self.section_length_m,
            straight_deficiency=None if self.straight_deficiency_mm is None else 1e-3 * self.straight_deficiency_mm,
        )
