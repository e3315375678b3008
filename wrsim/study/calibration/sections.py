"""The file of a calibration."""

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import List, number, positive, text
from wrsim.study.candidates import CandidateScenario, CandidatesFile, VariedKey
from wrsim.study.measurement.sections import RecordSection, SeriesSection, faults_of_records
from wrsim.study.spec import Name


class CalibratedKey(VariedKey, header="[[vary]]"):
    """A key that is calibrated, between bounds; prior: what the data sheet says of it."""

    together: ClassVar[tuple[str, ...]] = ("low high", "prior tolerance")

    prior: Annotated[float, number()] | None = None
    """Value of the data sheet."""
    tolerance: Annotated[float, positive()] | None = None
    """Its tolerance to either side, taken for two standard deviations."""

    def consistency(self) -> Iterator[Fault]:
        yield from super().consistency()
        for key in ("whole", "choices"):
            if getattr(self, key):
                yield Fault(key, "a calibration varies numbers alone: derivatives are taken")


class CalibratedScenario(CandidateScenario, RecordSection, header="[[scenario]]"):
    """A scenario in which the model is fitted, and its measured file."""

    weight: Annotated[float, positive(1e6)] = 1.0
    """Factor of the squares of its residuals."""


class ValueSection(Section, header="[[value]]"):
    """A measured number: natural frequencies, or what the summary of the scenario has."""

    one_of = ("frequencies_Hz summary",)
    together = ("summary value",)
    goes_with: ClassVar[dict[str, str]] = {"modes": "frequencies_Hz"}

    scenario: Name | None = None
    """The scenario that it belongs to; needed where there are several."""
    frequencies_Hz: List[Annotated[float, positive(1e4, "Hz")]] = ()
    """Natural frequencies, each beside the nearest mode at the first speed of analysis = "stability"."""
    modes: List[Annotated[str, text('the name of a mode such as "carbody vertical"')]] = ()
    """Names of these modes in the result; without them the nearest ones are taken: safe where modes are few."""
    summary: Annotated[str, text('a place in summary.json such as "linear_critical_speed_kmh"')] | None = None
    """Number of summary.json, by its place with dots between."""
    value: Annotated[float, number()] | None = None
    """What was measured of it."""
    noise: Annotated[float, positive()]
    """Standard deviation of what was measured."""

    def consistency(self) -> Iterator[Fault]:
        if self.modes and len(self.modes) != len(self.frequencies_Hz):
            yield Fault("modes", f"has {len(self.modes)} names for {len(self.frequencies_Hz)} frequencies")


class CalibrationFile(CandidatesFile, header="a calibration"):
    """A calibration: scenarios, keys that are varied, and what was measured."""

    scenario: List[CalibratedScenario] = ()
    """Scenarios in which the model is fitted."""
    vary: Annotated[List[CalibratedKey], Field(min_length=1)]
    """Keys that are calibrated."""
    measured: List[SeriesSection] = ()
    """Series of the measured files, each with its channel."""
    value: List[ValueSection] = ()
    """Measured numbers."""
    confidence_percent: Annotated[float, number(50, 99.9, "%")] = 90.0
    """Confidence of the intervals."""
    intervals: Literal["linear", "profile"] = "linear"
    """Intervals by the derivatives at the optimum, or by the profile of the likelihood: a few fits for each end."""
    iterations: Annotated[int, number(1, 200)] = 20
    """Most steps of the least squares in each round of weights."""

    def consistency(self) -> Iterator[Fault]:
        yield from super().consistency()
        names = [each.name for each in self.scenario]
        yield from faults_of_records(self.scenario, self.measured)
        if not self.measured and not self.value:
            yield Fault("measured", "nothing was measured: needs [[measured]] or [[value]]", missing=True)
        for i, each in enumerate(self.measured):
            if each.reduce is not None and each.noise is None:
                yield Fault(("measured", i, "noise"), "a number needs its standard deviation", missing=True)
        for i, row in enumerate(self.value):
            if (row.scenario is None and len(names) > 1) or (row.scenario is not None and row.scenario not in names):
                yield Fault(
                    ("value", i, "scenario"), f"must be one of {', '.join(names)}", missing=row.scenario is None
                )
        if self.cases.keep != "results":
            yield Fault(("cases", "keep"), 'a calibration reads series of its cases: must be "results"')
