"""The files of a study and of profile evolution: a base scenario, its cases, what is stored of them."""

import re
from collections.abc import Callable, Iterator
from math import log10
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field

from wrsim.assessment.limits import QUANTITY_NAMES, RUN_QUANTITIES
from wrsim.contact.wear.laws import LawName
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import List, number, positive, refuse, repeated, spread, text
from wrsim.results import CHANNELS
from wrsim.results.channels import NAMES
from wrsim.vehicle.vehicle_sections import WheelName

MOST_CASES = 1_000_000
MOST_SAMPLES = 65_536

KEY = 'a dotted key of the scenario such as "vehicle.speed_kmh" or "track.segments[2].radius_m"'
Key = Annotated[str, text(KEY)]
Name = Annotated[
    str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$", description="a name of letters, digits and _ in quotes")
]


Keys = Annotated[
    tuple[Key, ...],
    Field(strict=False, min_length=1, description=f"{KEY}, or a list of keys that all take the same value"),
    BeforeValidator(lambda value: value if isinstance(value, list | tuple) else (value,)),
]


VALUES = "a list of values for that key, or {from = .., to = .., step = ..}"


def _values(value: Any) -> Any:
    if not isinstance(value, list | tuple | dict):
        raise refuse(f"must be {VALUES}")
    if isinstance(value, dict):  # 0.3 and not 0.30000000000000004, so that it is the same case as one of a list
        whole = all(isinstance(v, int) for v in value.values())
        return tuple(round(v) if whole else float(f"{v:.12g}") for v in spread(value))
    return value


Values = Annotated[tuple[Any, ...], Field(strict=False, min_length=1, description=VALUES), BeforeValidator(_values)]


TimeLimit = Annotated[float, number(1, 1e7, "s of one case")]


class GridAxis(Section, header='[[vary]] with kind = "grid"'):
    """Every value of a list; axes of several tables are combined with each other."""

    kind: Literal["grid"]
    """Every value of a list; several axes are combined with each other."""
    key: Keys
    """Key of the scenario that is varied, or several that take the same value."""
    values: Values
    """Values that it takes."""
    name: Name | None = None
    """Name of the axis in the results; the last part of the key unless given."""


class CsvAxis(Section, header='[[vary]] with kind = "csv"'):
    """Rows of a table: the header holds dotted keys, a column ``id`` names the rows."""

    kind: Literal["csv"]
    """A row of a table for every case."""
    file: Annotated[str, text('a CSV file such as "variants.csv"')]
    """The table; its header holds keys of the scenario."""
    name: Name = "case"
    """Name of the axis in the results."""


MOST_DECADES = 15
"""Digits of a number: of values farther apart none is seen beside the other."""


class SampledKey(Section, header="[[vary.over]]"):
    """One key that is sampled: evenly from low to high, or normally about a mean."""

    one_of = ("low mean",)
    together = ("low high", "mean deviation")
    goes_with = {"spacing": "low"}
    above = {"high": "low"}

    key: Keys
    """Key of the scenario that is sampled, or several that take the same value."""
    low: Annotated[float, number()] | None = None
    """Least value, of samples spread evenly."""
    high: Annotated[float, number()] | None = None
    """Largest value, of samples spread evenly."""
    spacing: Literal["linear", "log"] = "linear"
    """Even in the value, or in its logarithm."""
    mean: Annotated[float, number()] | None = None
    """Mean of a normal distribution, in place of low and high."""
    deviation: Annotated[float, positive()] | None = None
    """Standard deviation of a normal distribution."""
    whole: bool = False
    """Whether values are rounded to whole numbers."""

    def consistency(self) -> Iterator[Fault]:
        if self.low is not None and self.high is not None:
            if self.spacing == "log" and self.low <= 0.0:
                yield Fault("low", 'must be above 0 with spacing = "log"')
            elif (
                self.spacing == "log" and (decades := log10(max(self.high, self.low)) - log10(self.low)) > MOST_DECADES
            ):
                yield Fault("high", f"is {decades:.0f} decades above low; must be at most {MOST_DECADES}")


class _Sampled(Section):
    """What all samples have in common."""

    samples: Annotated[int, number(1, MOST_SAMPLES)]
    """How many cases are drawn."""
    seed: Annotated[int, number(0, 2**31 - 1)] = 0
    """Number that decides which samples are drawn; the same seed gives the same ones."""
    over: Annotated[List[SampledKey], Field(min_length=1)]
    """Keys that are sampled and their ranges."""
    name: Name = "case"
    """Name of the axis in the results."""


class SobolAxis(_Sampled, header='[[vary]] with kind = "sobol"'):
    """Scrambled Sobol points: even in every projection; their number is a power of 2."""

    kind: Literal["sobol"]
    """Scrambled Sobol points, even in every projection."""

    def consistency(self) -> Iterator[Fault]:
        if self.samples & (self.samples - 1):
            yield Fault("samples", f'{_power_of_2(self.samples)}; kind = "latin-hypercube" takes any number')


class LatinHypercubeAxis(_Sampled, header='[[vary]] with kind = "latin-hypercube"'):
    """A Latin hypercube: every key takes a value in each of as many equal parts of its range as there are samples."""

    kind: Literal["latin-hypercube"]
    """A Latin hypercube."""


def _power_of_2(samples: int) -> str:
    below = 1 << (samples.bit_length() - 1)
    return f"must be a power of 2 ({below} or {2 * below}): only so many Sobol points are even"


class SensitivitySection(_Sampled, header="[sensitivity]"):
    """A design of cases that finds which keys decide on the outputs; in place of [[vary]]."""

    method: Literal["sobol", "morris", "regression"]
    """Sobol's indices, effects of Morris (needs SALib), or a linear fit on a Latin hypercube."""
    outputs: List[str] = ()
    """Names of the outputs; all numbers of the cases unless given."""

    def consistency(self) -> Iterator[Fault]:
        cases = self.samples * {"sobol": len(self.over) + 2, "morris": len(self.over) + 1}.get(self.method, 1)
        if self.method == "sobol" and self.samples & (self.samples - 1):
            yield Fault("samples", f'{_power_of_2(self.samples)}; method = "regression" takes any number')
        elif self.method == "regression" and self.samples < len(self.over) + 3:
            yield Fault("samples", f"must be {len(self.over) + 3} or more: the keys and 3")
        elif cases > MOST_CASES:
            yield Fault("samples", f"describes {cases} cases; must be at most {MOST_CASES}")
        elif self.samples < 2:
            yield Fault("samples", "must be 2 or more")
        for i, key in enumerate(self.over if self.method == "morris" else ()):
            if key.low is None:
                yield Fault(("over", i, "low"), 'method = "morris" needs bounds: low and high', missing=True)


Axis = GridAxis | CsvAxis | SobolAxis | LatinHypercubeAxis

REDUCTIONS: dict[str, Callable[..., Any]] = {
    "max": np.max, "min": np.min, "peak": lambda values: values[np.argmax(np.abs(values))],
    "mean": np.mean, "median": np.median, "rms": lambda values: np.sqrt(np.mean(values**2)), "deviation": np.std,
    "range": np.ptp, "percentile": np.percentile, "last": lambda values: values[-1],
}  # fmt: skip
"""How the finite samples (n,) of a channel become one number; a percentile takes its number as well."""
NUMBERS = tuple(name for name, c in CHANNELS.items() if c.kind != "text" and not c.coordinate)
LABELS = ("wheelset", "wheel", "body", "point", "suspension", "coupling", "external_load")
"""Dimensions of a channel of which one may be chosen by its name."""


class ChannelOutput(Section, header="[[outputs.channels]]"):
    """A channel, reduced to one number; of several wheels or wheelsets the largest counts (with min the smallest)."""

    above = {"to_m": "from_m"}

    channel: NAMES.among(NUMBERS).key()  # type: ignore[valid-type]
    """Channel of the result."""
    reduce: Literal[*REDUCTIONS]  # type: ignore[valid-type]
    """How its samples become one number."""
    percentile: Annotated[float, number(0, 100)] | None = None
    """Which one, for reduce = "percentile"."""
    wheelset: Annotated[str, text("the name of a wheelset")] | None = None
    """The wheelset that counts; the worst of all unless given."""
    wheel: Literal["left", "right"] | None = None
    """The wheel that counts; the worse one unless given."""
    body: Annotated[str, text("the name of a body")] | None = None
    """The body that counts; the worst of all unless given."""
    point: Annotated[str, text("the name of a point")] | None = None
    """The point that counts; the worst of all unless given."""
    suspension: Annotated[str, text("the name of a suspension element")] | None = None
    """The suspension element that counts; the worst of all unless given."""
    coupling: Annotated[str, text("the name of a coupling")] | None = None
    """The coupling that counts; the worst of all unless given."""
    external_load: Annotated[str, text("the name of a load")] | None = None
    """The load that counts; the worst of all unless given."""
    from_m: Annotated[float, number(0, 1e6, "m along the centre line")] | None = None
    """Where the part of the way begins that counts."""
    to_m: Annotated[float, number(0, 1e6, "m along the centre line")] | None = None
    """Where the part of the way ends that counts."""
    low_pass_Hz: Annotated[float, positive(1e5, "Hz")] | None = None
    """Cut-off of a low-pass of the whole run before it is reduced (-3 dB, 24 dB an octave, without a shift)."""
    name: Name | None = None
    """Name of the column; made of channel, labels, reduction and unit unless given."""

    @classmethod
    def raw_faults(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        if raw.get("reduce") == "percentile" and "percentile" not in raw:
            yield Fault("percentile", "must be a number from 0 to 100", missing=True)
        elif raw.get("reduce") != "percentile" and "percentile" in raw:
            yield Fault("percentile", 'is for reduce = "percentile"')
        if (name := NAMES.understood(str(raw.get("channel")))) is not None:
            channel = CHANNELS[name]
            for label in LABELS:
                if label in raw and label not in channel.dims:
                    yield Fault(label, f'channel "{channel.name}" has none: it belongs to ({", ".join(channel.dims)})')

    def chosen(self) -> dict[str, str]:
        """The chosen labels by dimension."""
        return {label: getattr(self, label) for label in LABELS if getattr(self, label) is not None}

    @property
    def column(self) -> str:
        """Name of the output with its unit at the end."""
        channel = CHANNELS[self.channel]
        if self.name is not None:
            return self.name
        how = f"p{self.percentile:g}" if self.percentile is not None else self.reduce
        parts = (self.channel, *self.chosen().values(), how, channel.shown.suffix)
        return "_".join(word.replace(" ", "_").replace(".", "_") for word in parts if word)


HOOK = 'a file and a function in it, such as "outputs.py:numbers", in quotes'
Hook = Annotated[str, Field(pattern=r"^[^\x00]*\.py:[A-Za-z_]\w*$", description=HOOK)]


class OutputsSection(Section, header="[outputs]"):
    """Numbers that are stored of every case; without this table, those that people ask for first.

    hook: ``"file.py:function"``, which takes a Result and returns a dict of numbers.
    """

    summary: List[Annotated[str, text('a place in summary.json such as "linear_critical_speed_kmh"')]] = ()
    """Numbers of summary.json, by their places with dots between."""
    assessment: List[QUANTITY_NAMES.among(RUN_QUANTITIES).key()] = ()  # type: ignore[valid-type]
    """Quantities of the rule set of the scenario, the worst of all sections."""
    channels: List[ChannelOutput] = ()
    """Channels of the result, each reduced to one number."""
    hook: Hook | None = None
    """Your own function of a result, which gives a dict of numbers."""

    def consistency(self) -> Iterator[Fault]:
        for name in repeated(output.column for output in self.channels):
            yield Fault(("channels",), f'two outputs are called "{name}": give one of them another name')


class CasesSection(Section, header="[cases]"):
    """Limits of a case, and what is stored of it."""

    time_limit_s: TimeLimit = 3600.0
    """Longest time of one case."""
    keep: Literal["results", "numbers"] = "results"
    """Whole results of the cases, or their numbers alone."""


class StudyFile(Section, header="a study"):
    """A study: the scenario it starts from, what is varied, what is stored."""

    one_of = ("vary sensitivity",)

    title: Annotated[str, text("a title")] | None = None
    """Title of the study; that of its scenario unless given."""
    base: Annotated[str, text('a scenario file such as "../curve_r300.toml"')]
    """Scenario that all cases start from."""
    vary: Annotated[List[Annotated[Axis, Field(discriminator="kind")]], Field(min_length=1)] = ()
    """What is varied, axis by axis."""
    sensitivity: SensitivitySection | None = None
    """A design that finds which keys decide on the outputs, in place of axes."""
    outputs: OutputsSection = OutputsSection()
    """Numbers that are stored of every case."""
    cases: CasesSection = CasesSection()
    """Limits of a case, and what is stored of it."""

    def consistency(self) -> Iterator[Fault]:
        for name in repeated(map(axis_name, self.vary)):
            yield Fault("vary", f'two axes are called "{name}": give one of them another name')


def axis_name(axis: Axis) -> str:
    """Name of the dimension of an axis: its own, or the last part of its key."""
    if isinstance(axis, GridAxis) and axis.name is None:
        return short_name(axis.key[0])
    return str(axis.name)


def short_name(key: str) -> str:
    """The last part of a dotted key, with the numbers behind it: ``stiffness_kN_per_m_2``."""
    return re.sub(r"[.\[](\d+)\]?", r"_\1", key).rpartition(".")[2]


class EvolutionFile(Section, header="a profile evolution"):
    """A profile evolution: the scenario its cases start from, their table, the mileage, and the steps of wear."""

    title: Annotated[str, text("a title")] | None = None
    """Title; that of its scenario unless given."""
    base: Annotated[str, text('a scenario file such as "curve.toml"')]
    """Scenario that all cases start from."""
    cases: Annotated[str, text('a CSV file such as "cases.csv"')]
    """Table of the cases: keys of the scenario in its header, a column share of the mileage, a column id of names."""
    wheel: WheelName
    """Profile of all wheels before the first kilometre."""
    law: LawName = "usfd"
    """Law of wear."""
    mileage_km: Annotated[float, positive(1e7)]
    """How far the vehicle runs."""
    largest_depth_mm: Annotated[float, number(0.001, 1)] = 0.1
    """Largest depth of one step; then the profile is made anew."""
    largest_step_km: Annotated[float, positive(1e7)] = 1500.0
    """Largest mileage of one step."""
    smoothing_mm: Annotated[float, number(0.5, 50)] = 5.0
    """Wavelength along the profile at which smoothing halves what was worn off."""
    conicity_amplitude_mm: Annotated[float, number(0.5, 10)] = 3.0
    """Amplitude of the equivalent conicity that is reported against the mileage."""
    flange_back_mm: Annotated[float, number(20, 150)] = 70.0
    """Distance of the flange back from the tape circle, for the flange's thickness Sd."""
    time_limit_s: TimeLimit = 3600.0
    """Longest time of one case."""
