"""Candidates: points in the space of some varied keys, each evaluated in several scenarios.

What searches for a point (`wrsim.study.optimisation`, `wrsim.study.calibration`) hands over points and is given the
outputs of their cases. Cases are those of a study in ``scenarios/<name>`` of the folder: named by their content, run by
the same workers, known again by their markers. So every case runs once, and a search that was killed and is started
again meets the same numbers.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from math import exp, log
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

import xarray as xr
from pydantic import Field

from wrsim.errors import InputError
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import List, number, positive, repeated, text
from wrsim.results import Result
from wrsim.scenario.loading import Scenario, load
from wrsim.scenario.vehicle_build import given_value, vehicle_of
from wrsim.study.axes import AxisPoints
from wrsim.study.plan import FileInput, Plan, Refused, value_text, with_cases
from wrsim.study.spec import CasesSection, Keys, Name, OutputsSection, short_name
from wrsim.study.task import COMPLETED, RESULT, Marker, Work, missing, read_marker

SCENARIOS, ONLY = "scenarios", "scenario"
"""Folder of the scenarios; name of a scenario that is the only one."""
REFUSED = "refused"
"""Status of a candidate whose values do not go together: no case of it runs."""


class VariedKey(Section, header="[[vary]]"):
    """A key of the scenarios that is varied between bounds, or among choices."""

    one_of = ("low choices",)
    together: ClassVar[tuple[str, ...]] = ("low high",)
    above = {"high": "low"}

    key: Keys
    """Key of the scenario that is varied, or several that take the same value."""
    low: Annotated[float, number()] | None = None
    """Lower bound."""
    high: Annotated[float, number()] | None = None
    """Upper bound."""
    start: Annotated[float | str | bool, Field(description="a value of that key")] | None = None
    """Value at the start; that of the first scenario unless given."""
    spacing: Literal["linear", "log"] = "linear"
    """Whether steps are even in the value, or in its logarithm."""
    whole: bool = False
    """Whether values are rounded to whole numbers."""
    choices: Annotated[List[Any], Field(description="a list of two or more values for that key")] = ()
    """Values among which one is chosen, in place of bounds."""

    def consistency(self) -> Iterator[Fault]:
        if self.spacing == "log" and self.low is not None and self.low <= 0.0:
            yield Fault("low", 'must be above 0 with spacing = "log"')
        if self.choices and (len(self.choices) < 2 or self.whole or self.spacing == "log"):
            yield Fault("choices", "must be two or more values, without whole and spacing")


class CandidateScenario(Section, header="[[scenario]]"):
    """A scenario in which every candidate is evaluated."""

    name: Name
    """Name of the scenario."""
    base: Annotated[str, text('a scenario file such as "curve_r300.toml"')]
    """The scenario."""
    weight: Annotated[float, positive(1e6)] = 1.0
    """Factor of its objectives."""


class CandidatesFile(Section):
    """What files of searches have in common."""

    one_of = ("base scenario",)

    title: Annotated[str, text("a title")] | None = None
    """Title; that of the first scenario unless given."""
    base: Annotated[str, text('a scenario file such as "curve_r300.toml"')] | None = None
    """The scenario, where it is one."""
    scenario: List[CandidateScenario] = ()
    """Scenarios in which every candidate is evaluated."""
    vary: Annotated[List[VariedKey], Field(min_length=1)]
    """Keys that are varied."""
    cases: CasesSection = CasesSection()
    """Limits of a case, and what is stored of it."""

    def consistency(self) -> Iterator[Fault]:
        for name in repeated(entry.name for entry in self.scenario):
            yield Fault("scenario", f'two of them are called "{name}"')
        for key in repeated(chain.from_iterable(entry.key for entry in self.vary)):
            yield Fault("vary", f"{key}: is varied twice")

    def named_bases(self) -> list[tuple[str, str, float, tuple[str | int, ...]]]:
        """Name, file, weight and key of every scenario."""
        if self.base is not None:
            return [(ONLY, self.base, 1.0, ("base",))]
        return [(row.name, row.base, row.weight, ("scenario", i, "base")) for i, row in enumerate(self.scenario)]


@dataclass(frozen=True)
class Varied:
    """A varied key with its bounds. A number of it is the value in the file's unit, or counts the choices from 0.

    keys: that take the value; name: for tables; start: number at the start."""

    keys: tuple[str, ...]
    name: str
    low: float
    high: float
    start: float
    log: bool = False
    whole: bool = False
    choices: tuple[Any, ...] = ()

    @property
    def stepped(self) -> bool:
        """Whether there is nothing between two of its numbers."""
        return self.whole or bool(self.choices)

    @property
    def range_text(self) -> str:
        """Bounds or choices, for sentences."""
        return " or ".join(map(value_text, self.choices)) or f"{self.low:g} to {self.high:g}, start {self.start:g}"

    def value(self, x: float) -> Any:
        """The value in the file for a number: within the bounds, rounded or chosen."""
        x = min(max(float(x), self.low), self.high)
        return self.choices[round(x)] if self.choices else round(x) if self.whole else x

    def share(self, x: float) -> float:
        """Where a number lies between the bounds, 0 to 1, by the spacing."""
        low, high, x = (log(v) for v in (self.low, self.high, x)) if self.log else (self.low, self.high, x)
        return (x - low) / (high - low)

    def number(self, share: float) -> float:
        """The number that lies there between the bounds."""
        if self.log:
            return exp(log(self.low) + share * (log(self.high) - log(self.low)))
        return self.low + share * (self.high - self.low)


@dataclass(frozen=True)
class OneScenario:
    """A scenario of the candidates. outputs: of its cases; hook: file of its hook, or empty."""

    name: str
    base: Scenario
    weight: float
    outputs: OutputsSection
    hook: str = ""


class Evaluated(NamedTuple):
    """What became of a candidate in a scenario: a status of a case, or REFUSED; folder: of the case."""

    status: str
    message: str
    numbers: Mapping[str, float | None] = {}
    units: Mapping[str, str] = {}
    folder: Path | None = None

    @property
    def name(self) -> str:
        """Name of the case."""
        return "" if self.folder is None else self.folder.name

    def dataset(self) -> xr.Dataset:
        """The whole result, where results are kept."""
        if self.folder is None:
            raise InputError(f"there is no result: {self.message}")
        return Result.load(self.folder / RESULT).dataset


@dataclass(frozen=True)
class Candidate:
    """A candidate: its values as in the file, and what became of it by scenario."""

    values: tuple[Any, ...]
    cases: Mapping[str, Evaluated]

    @property
    def completed(self) -> bool:
        """Whether all of its cases came to their ends."""
        return all(case.status == COMPLETED for case in self.cases.values())

    @property
    def status(self) -> str:
        """Status of the first case that did not come to its end, else that of all."""
        return next((case.status for case in self.cases.values() if case.status != COMPLETED), COMPLETED)

    @property
    def message(self) -> str:
        """Messages of the cases that did not come to their ends."""
        bad = {name: case for name, case in self.cases.items() if case.status != COMPLETED}
        return "; ".join(f"{name}: {case.status}: {case.message}".replace("\n", "; ") for name, case in bad.items())


@dataclass(frozen=True)
class Candidates:
    """The space of the varied keys, and the scenarios in which its points are evaluated.

    source: the file; folder: of the search; limits: of cases."""

    source: FileInput
    title: str
    folder: Path
    varied: tuple[Varied, ...]
    scenarios: tuple[OneScenario, ...]
    limits: CasesSection

    @property
    def start(self) -> tuple[float, ...]:
        """Numbers of the varied keys at the start."""
        return tuple(var.start for var in self.varied)

    def values(self, point: Sequence[float]) -> tuple[Any, ...]:
        """Values in the file at a point."""
        return tuple(var.value(x) for var, x in zip(self.varied, point, strict=True))

    def changes(self, values: Sequence[Any]) -> dict[str, Any]:
        """Values by key."""
        return {key: value for var, value in zip(self.varied, values, strict=True) for key in var.keys}

    def plan(self, scenario: OneScenario, rows: Sequence[tuple[Any, ...]]) -> tuple[Plan, list[Refused]]:
        """The cases of some rows of values in a scenario, without those that are refused."""
        keys = tuple(var.keys for var in self.varied)
        axis = AxisPoints("candidate", keys, tuple(rows), (str(self.source.file),) * len(rows), listed=True)
        folder = self.folder / SCENARIOS / scenario.name
        title = self.title if len(self.scenarios) == 1 else f"{self.title}, {scenario.name}"
        empty = self.source.plan_of(scenario.base, title, folder, (axis,), scenario.outputs, self.limits, scenario.hook)
        refused: list[Refused] = []
        return with_cases(empty, scenario.base, refused)[0], refused

    def evaluated(self, points: Sequence[Sequence[float]], work: Work) -> list[Candidate]:
        """What the candidates at these points come to, in their order; what is known already does not run again.

        Raises InputError where an output cannot be had of a case that is completed."""
        rows = [self.values(point) for point in points]
        todo = list(dict.fromkeys(rows))
        plans = {scenario.name: self.plan(scenario, todo) for scenario in self.scenarios}
        cases: dict[tuple[Any, ...], dict[str, Evaluated]] = {}
        for name, (_, refused) in plans.items():
            for (i,), message in refused:
                cases.setdefault(todo[i], {})[name] = Evaluated(REFUSED, message)
        if runs := [row for row in todo if row not in cases]:
            cases |= {row: {} for row in runs}
            for scenario in self.scenarios:
                plan = self.plan(scenario, runs)[0] if len(runs) < len(todo) else plans[scenario.name][0]
                if left := missing(plan):
                    work(plan, left)
                for row, case in zip(runs, plan.cases, strict=True):
                    cases[row][scenario.name] = _evaluated(read_marker(plan.folder_of(case)), plan.folder_of(case))
        return [Candidate(row, cases[row]) for row in rows]


def _evaluated(marker: Marker | None, folder: Path) -> Evaluated:
    """What a marker says. Raises InputError where it lacks outputs that no case can have."""
    if marker is None:
        raise InputError(f"{folder}: has no result: it was removed while the search was running")
    if marker.status == COMPLETED and marker.faults:
        raise InputError("\n".join(marker.faults))
    return Evaluated(marker.status, marker.message, marker.numbers, marker.units, folder)


def read_candidates(
    file: FileInput, folder: Path, outputs: Mapping[str, OutputsSection], hooks: Mapping[str, str] | None = None
) -> Candidates:
    """The space and the scenarios of a file that is a `CandidatesFile`, with the candidate at the start checked.

    outputs, hooks: by the name of the scenario. Raises InputError with all faults of the start: unknown keys, values
    that are not allowed, a start outside of the bounds."""
    spec: CandidatesFile = file.spec
    scenarios = []
    for name, base, weight, key in spec.named_bases():
        loaded = load(file.file_of(*key, name=base), file.models)
        scenarios.append(OneScenario(name, loaded, weight, outputs[name], (hooks or {}).get(name, "")))
    first = scenarios[0].base
    varied = [_varied(file, i, var, first) for i, var in enumerate(spec.vary)]
    shared = repeated(var.name for var in varied)
    varied = [replace(var, name=var.keys[0]) if var.name in shared else var for var in varied]
    candidates = Candidates(file, spec.title or first.title, folder, tuple(varied), tuple(scenarios), spec.cases)
    start, faults = candidates.values(candidates.start), list[str]()
    for scenario in candidates.scenarios:
        before = len(faults)
        for i, (var, value) in enumerate(zip(varied, start, strict=True)):
            try:
                scenario.base.with_values(dict.fromkeys(var.keys, value), file.locate(("vary", i)))
            except InputError as error:
                faults.append(str(error))
        if len(faults) == before:
            faults += [message for _, message in candidates.plan(scenario, [start])[1]]
    if faults:
        raise InputError("\n".join(dict.fromkeys(faults)))
    return candidates


def _varied(file: FileInput, i: int, var: VariedKey, scenario: Scenario) -> Varied:
    """A varied key with its start. Raises InputError."""
    value = var.start
    if value is None:
        value = given_value(scenario, var.key[0])
    if value is None:  # an unknown key is told first
        some = var.choices[0] if var.choices else var.low
        vehicle_of(scenario.with_values(dict.fromkeys(var.key, some), file.locate(("vary", i))))
        with file.naming("vary", i, "start"):
            raise InputError(f"is missing: neither the scenario nor its vehicle gives {var.key[0]}")
    named = short_name(var.key[0])
    with file.naming("vary", i, "start", value=value):
        if var.choices:
            if value not in var.choices:
                raise InputError(f"must be one of the choices: {', '.join(map(value_text, var.choices))}")
            return Varied(
                var.key, named, 0.0, len(var.choices) - 1.0, float(var.choices.index(value)), choices=var.choices
            )
        low, high = float(var.low or 0.0), float(var.high or 0.0)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{var.key[0]} is no number there; take choices, or a key of a number")
        if not low <= value <= high:
            raise InputError(f"is outside of the bounds {low:g} to {high:g}; widen them, or start between them")
    return Varied(var.key, named, low, high, float(value), var.spacing == "log", var.whole)
