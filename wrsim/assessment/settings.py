"""[assessment]: what an assessment rests on besides the result."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal, get_args

from wrsim.assessment.limits import Kind
from wrsim.assessment.outcome import Influence
from wrsim.assessment.rules import NAMES, USUAL
from wrsim.inputs.section import Fault
from wrsim.inputs.values import List, number
from wrsim.scenario.sections.table import AnalysisTable


@dataclass(frozen=True)
class AssessmentSettings:
    """What an assessment rests on: keys of `AssessmentSection` in SI units; None is taken from the result where it can
    be. estimate_at: places of the influences, the largest of the sections unless given."""

    rules: str = USUAL
    kind: Kind = "passenger"
    axle_load: float | None = None
    friction: float | None = None
    flange_angle: float | None = None
    flange_length: float | None = None
    instability_frequency: float | None = None
    section_length: float | None = None
    straight_deficiency: float | None = None
    admissible_deficiency: float | None = None
    estimate_over: tuple[Influence, ...] = ()
    estimate_at: Mapping[Influence, float] = field(default_factory=dict)


class AssessmentSection(AnalysisTable, header="[assessment]"):
    """What an assessment rests on, where that is not to come from the result."""

    rules: Literal[*NAMES] = USUAL  # type: ignore[valid-type]
    """Rule set by which runs are assessed."""
    vehicle_kind: Kind = "passenger"
    """Kind of vehicle, which decides on limits."""
    axle_load_kN: Annotated[float, number(1, 500, "kN, 2 Q0 of one wheelset")] | None = None
    """Static load of one wheelset, for the limit of the track shifting force; from the result unless given."""
    friction: Annotated[float, number(0.01, 2, "for Nadal's limit; dry steel 0.3 to 0.5")] | None = None
    """Coefficient for Nadal's limit; from the scenario unless given."""
    flange_angle_deg: Annotated[float, number(45, 89, "degrees, S1002 70")] | None = None
    """Largest angle of the flange, for Nadal's limit; from the wheel profile unless given."""
    flange_length_mm: Annotated[float, number(8, 30, "mm; TCRP 71: 10 to 25")] | None = None
    """Length of the flange's steepest part, for the distance to climb of TCRP Report 71; not judged unless given."""
    instability_frequency_Hz: Annotated[float, number(0.5, 30, "Hz")] | None = None
    """Frequency about which instability is looked for; found in the result unless given."""
    section_length_m: Annotated[float, number(5, 10_000, "m")] | None = None
    """Length of a track section of every class; that of the rule set unless given."""
    straight_deficiency_mm: Annotated[float, number(0, 200, "mm; UIC 518: 40")] | None = None
    """Cant deficiency up to which curves from R 600 m count as straight track; none do unless given."""
    admissible_deficiency_mm: Annotated[float, number(10, 400, "mm of cant deficiency")] | None = None
    """Admissible cant deficiency: full curves count in statistics from 0.75 to 1.10 of it; all unless given."""
    estimate_over: List[Influence] = ()
    """Influences by which estimated values are found (two-dimensional method); mean and deviation unless given."""
    estimate_cant_deficiency_mm: Annotated[float, number(-300, 400, "mm")] | None = None
    """Cant deficiency at which values are estimated; the largest of the sections of a class unless given."""
    estimate_radius_m: Annotated[float, number(10, 100_000, "m")] | None = None
    """Radius at which values are estimated; the smallest of the sections of a class unless given."""
    estimate_speed_kmh: Annotated[float, number(1, 500, "km/h")] | None = None
    """Speed at which values are estimated; the largest of the sections of a class unless given."""

    def consistency(self) -> Iterator[Fault]:
        if len(set(self.estimate_over)) < len(self.estimate_over):
            allowed = f"some of {', '.join(get_args(Influence))}, each once"
            yield Fault("estimate_over", f"has a duplicate: must be {allowed}")
        for name, key, _ in self._places():
            if name not in self.estimate_over:
                yield Fault(key, f'goes with "{name}" in estimate_over')

    def _places(self) -> Iterator[tuple[Influence, str, float]]:
        """Influences that have a place given, their keys and the places in SI units."""
        if self.estimate_cant_deficiency_mm is not None:
            yield "cant_deficiency", "estimate_cant_deficiency_mm", 1e-3 * self.estimate_cant_deficiency_mm
        if self.estimate_radius_m is not None:
            yield "curvature", "estimate_radius_m", 1.0 / self.estimate_radius_m
        if self.estimate_speed_kmh is not None:
            yield "speed", "estimate_speed_kmh", self.estimate_speed_kmh / 3.6

    def settings(self) -> AssessmentSettings:
        places = {name: place for name, _, place in self._places()}
        return self.to_si(AssessmentSettings, kind=self.vehicle_kind, estimate_at=places)
