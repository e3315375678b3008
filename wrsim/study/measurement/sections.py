"""[[scenario]] and [[measured]] of a validation and of a calibration."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import List, Two, number, positive, repeated, text
from wrsim.study.spec import REDUCTIONS, CasesSection, ChannelOutput, Name

Place = Annotated[float, number(-1e7, 1e7)]
Hz = Annotated[float, positive(1000, "Hz")]


class RecordSection(Section, header="[[scenario]]"):
    """The measured file that belongs to a scenario, and how its rows lie along the run."""

    at_most_one = ("distance time",)
    goes_with: ClassVar[dict[str, str]] = {
        "distance": "file", "time": "file", "unit": "distance time",
        "shift_m": "distance", "search_m": "distance", "shift_s": "time", "search_s": "time",
    }  # fmt: skip

    file: Annotated[str, text('a measured file such as "run_12.csv"')] | None = None
    """Measured series: CSV, NetCDF (.nc) or MDF (.mf4, .mdf, .dat)."""
    distance: Annotated[str, text("the name of a series")] | None = None
    """Series of the file that holds the distance; without it and time, rows are the poses of the scenario in order."""
    time: Annotated[str, text("the name of a series")] | None = None
    """Series of the file that holds the time."""
    unit: Annotated[str, text("a unit such as km or ms")] | None = None
    """Unit of distance or time; that in the file, else m or s."""
    shift_m: Place = 0.0
    """What is added to the measured distance, so that it is that of the run."""
    shift_s: Place = 0.0
    """The same of the time."""
    search_m: Annotated[float, positive(1e5, "m")] | None = None
    """How far about this shift a better one is looked for, by the cross-correlation of the series."""
    search_s: Annotated[float, positive(1e5, "s")] | None = None
    """The same of the time."""


class SeriesSection(ChannelOutput, header="[[measured]]"):
    """A measured series, and the channel of the model that it stands beside."""

    at_most_one = ("low_pass_Hz band_Hz",)

    series: Annotated[str, text("the name of a column, variable or signal")]
    """Name of the series in the measured files."""
    unit: Annotated[str, text("a unit such as kN or m/s2")] | None = None
    """Unit of the series; that in the file unless given."""
    scenario: Name | None = None
    """The scenario that it belongs to; all that have a file unless given."""
    offset: Annotated[float, number()] = 0.0
    """What is added to the series, in its unit."""
    reversed: bool = False
    """Whether the series has the opposite sign of the channel."""
    low_pass_Hz: Hz | None = None
    """Low-pass of series and channel."""
    band_Hz: Two[Hz] | None = None
    """Band-pass of both, two rising frequencies."""
    noise: Annotated[float, positive()] | None = None
    """Standard deviation of what is measured besides the signal, behind the filter, in the unit of the series; from the
    residual unless given."""
    reduce: Literal[*REDUCTIONS] | None = None  # type: ignore[assignment,valid-type]
    """What is compared in place of the samples: a number of them."""
    fit: Literal["series", "spectrum"] = "series"
    """Whether samples are fitted, or power spectral densities."""

    @classmethod
    def raw_faults(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        yield from super().raw_faults(raw)
        if raw.get("fit") == "spectrum" and "reduce" in raw:
            yield Fault("reduce", 'cannot be given with fit = "spectrum"')

    def consistency(self) -> Iterator[Fault]:
        if self.band_Hz is not None and not self.band_Hz[0] < self.band_Hz[1]:
            yield Fault("band_Hz", "must be two rising frequencies")

    @property
    def label(self) -> str:
        """Channel and labels, for people."""
        return " ".join((self.channel, *self.chosen().values(), self.reduce or "")).strip()


class ComparedScenario(RecordSection, header="[[scenario]]"):
    """A run, or a scenario that is run, and the measured file beside it."""

    one_of = ("base result",)

    name: Name
    """Name of the scenario."""
    base: Annotated[str, text('a scenario file such as "curve.toml"')] | None = None
    """Scenario that is run."""
    result: Annotated[str, text('a result such as "results/curve"')] | None = None
    """Result of a run, in place of a scenario."""


class ValidationFile(Section, header="a validation"):
    """A validation: runs, and what was measured on the line."""

    title: Annotated[str, text("a title")]
    """Title of the validation."""
    scenario: Annotated[List[ComparedScenario], Field(min_length=1)]
    """Runs with their measured files."""
    measured: Annotated[List[SeriesSection], Field(min_length=1)]
    """Series of these files, each with its channel."""
    cases: CasesSection = CasesSection()
    """Limits of a run, and what is stored of it."""

    def consistency(self) -> Iterator[Fault]:
        yield from faults_of_records(self.scenario, self.measured)


def faults_of_records(scenarios: Any, measured: Any) -> Iterator[Fault]:
    """Names that stand twice, series of no scenario, and scenarios without a file."""
    names = [each.name for each in scenarios]
    for name in repeated(names):
        yield Fault("scenario", f'two scenarios are called "{name}": give one of them another name')
    for i, each in enumerate(measured):
        if each.scenario is not None and each.scenario not in names:
            yield Fault(
                ("measured", i, "scenario"), f'there is no scenario "{each.scenario}"; there is {", ".join(names)}'
            )
        elif not any(s.file for s in scenarios if each.scenario in (None, s.name)):
            yield Fault(("measured", i), "no scenario has a measured file for it: [[scenario]] needs file")
