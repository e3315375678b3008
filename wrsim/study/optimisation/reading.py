"""The file of an optimisation: what is varied, what is sought, what is allowed."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from math import log
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import Field

from wrsim.analysis import run
from wrsim.assessment.limits import QUANTITY_NAMES, RUN_QUANTITIES
from wrsim.errors import InputError, SimulationError
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.toml_files import noting_reads
from wrsim.inputs.values import List, number, positive, repeated, text
from wrsim.register import ANALYSES
from wrsim.results.channels import NAMES
from wrsim.results.table import finite
from wrsim.scenario.build import build
from wrsim.study.candidates import Candidate, Candidates, CandidatesFile, OneScenario, read_candidates
from wrsim.study.outputs import assessment_name, case_outputs, check_place, margin_name, place_name
from wrsim.study.plan import FileInput
from wrsim.study.spec import NUMBERS, REDUCTIONS, CasesSection, ChannelOutput, Hook, Name, OutputsSection
from wrsim.study.task import begun, missing


class SoughtOutput(ChannelOutput):
    """An output of scenarios: a channel reduced to a number, a place of the summary, a quantity, or of a hook."""

    one_of: ClassVar[tuple[str, ...]] = ("channel summary assessment hook",)
    together = ("channel reduce", "hook output")

    channel: NAMES.among(NUMBERS).key() | None = None  # type: ignore[valid-type, assignment]
    """Channel of the result."""
    reduce: Literal[*REDUCTIONS] | None = None  # type: ignore[valid-type, assignment]
    """How its samples become one number."""
    summary: Annotated[str, text('a place in summary.json such as "linear_critical_speed_kmh"')] | None = None
    """Number of summary.json, by its place with dots between."""
    assessment: QUANTITY_NAMES.among(RUN_QUANTITIES).key() | None = None  # type: ignore[valid-type]
    """Quantity of the rule set of the scenario, the worst of all sections."""
    hook: Hook | None = None
    """Your own function of a result, which gives a dict of numbers."""
    output: Name | None = None
    """Name of the number of the hook."""
    scenario: Name | None = None
    """Scenario whose output it is; all of them unless given."""

    def channel_output(self) -> ChannelOutput:
        """The channel as an output of a study."""
        values = {key: getattr(self, key) for key in ChannelOutput.model_fields}
        return ChannelOutput(**{key: value for key, value in values.items() if value is not None})

    def outputs(self) -> OutputsSection:
        """The outputs section of this output alone."""
        return OutputsSection(
            channels=() if self.channel is None else (self.channel_output(),),
            summary=() if self.summary is None else (self.summary,),
            assessment=() if self.assessment is None else (self.assessment,),
            hook=self.hook,
        )

    @property
    def number_name(self) -> str:
        """Its name among the numbers of a case."""
        if self.channel is not None:
            return self.channel_output().column
        return str(self.output or (place_name(self.summary) if self.summary else assessment_name(str(self.assessment))))


class ObjectiveSection(SoughtOutput, header="[[objective]]"):
    """What is made as small, as large or as near to a target as can be; sums over scenarios and objectives."""

    one_of = (*SoughtOutput.one_of, "aim target")

    aim: Literal["minimise", "maximise"] | None = None
    """Direction in which the output is better."""
    target: Annotated[float, number()] | None = None
    """Value that the output comes near to: the square of the difference is minimised."""
    weight: Annotated[float, positive(1e12)] = 1.0
    """Factor in the sum of several objectives."""

    def cost(self, value: float) -> float:
        """What is minimised, of a value of the output."""
        if self.target is not None:
            return self.weight * (value - self.target) ** 2
        return self.weight * (value if self.aim == "minimise" else -value)


class ConstraintSection(SoughtOutput, header="[[constraint]]"):
    """What an output has to be; a quantity without numbers keeps the limit of the scenario's rule set."""

    at_least: Annotated[float, number()] | None = None
    """Smallest value that is allowed."""
    at_most: Annotated[float, number()] | None = None
    """Largest value that is allowed."""

    def consistency(self) -> Iterator[Fault]:
        if self.at_least is None and self.at_most is None and self.assessment is None:
            yield Fault("at_most", "must be a number (or at_least); an assessment has its own limit", missing=True)
        if self.at_least is not None and self.at_most is not None and self.at_most < self.at_least:
            yield Fault("at_most", f"must not be below at_least = {self.at_least:g}")

    @property
    def number_name(self) -> str:
        if self.assessment is not None and self.at_least is None and self.at_most is None:
            return margin_name(self.assessment)
        return super().number_name

    def margins(self, value: float) -> Iterator[float]:
        """How far it is kept, as a part of the limit; negative: how far it is exceeded."""
        if self.at_least is None and self.at_most is None:
            yield value
        if self.at_least is not None:
            yield (value - self.at_least) / (abs(self.at_least) or 1.0)
        if self.at_most is not None:
            yield (self.at_most - value) / (abs(self.at_most) or 1.0)

    @property
    def labels(self) -> list[str]:
        """What is allowed, for each of its margins."""
        bounds = (("at least", self.at_least), ("at most", self.at_most))
        return [f"{word} {bound:g}" for word, bound in bounds if bound is not None] or ["at least 0"]


Sought = tuple[str, int, SoughtOutput]
"""An objective or a constraint with its place in the file."""


class SearchSection(Section, header="[search]"):
    """How the best candidate is sought."""

    method: Literal["cma", "bounded"] | None = None
    """Covariance matrix adaptation, for several keys (needs cma), or Brent's bounded method, for one key."""
    evaluations: Annotated[int, number(3, 1_000_000)] = 200
    """Largest number of candidates."""
    seed: Annotated[int, number(0, 2**31 - 1)] = 1
    """Number that decides on the samples; the same seed gives the same ones."""
    step: Annotated[float, number(1e-3, 1)] = 0.25
    """First standard deviation of the samples, as a part of the distance between the bounds."""
    population: Annotated[int, number(4, 10_000)] | None = None
    """Candidates of a generation; 4 + 3 ln(keys) unless given. More for outputs with noise."""
    tolerance: Annotated[float, number(1e-9, 0.1)] = 1e-3
    """Part of the distance between the bounds at which the search ends."""
    restarts: Annotated[int, number(0, 20)] = 0
    """How often the search begins again at another place, with twice the population, while evaluations are left."""
    front: Annotated[int, number(3, 100)] | None = None
    """Points of the Pareto front of two objectives; one best candidate unless given."""

    def generation(self, keys: int) -> int:
        """Candidates that are evaluated together."""
        return 1 if keys == 1 else self.population or 4 + int(3 * log(keys))


class CasesOfCandidates(CasesSection, header="[cases]"):
    """Limits of a case, and what is stored of it."""

    keep: Literal["results", "numbers"] = "numbers"
    """Whole results of the cases, or their numbers alone."""


class OptimisationFile(CandidatesFile, header="an optimisation"):
    """An optimisation: scenarios, what is varied, objectives, constraints, how the best candidate is sought."""

    objective: Annotated[List[ObjectiveSection], Field(min_length=1)]
    """What is made as good as can be."""
    constraint: List[ConstraintSection] = ()
    """What is allowed."""
    search: SearchSection = SearchSection()
    """How the best candidate is sought."""
    cases: CasesOfCandidates = CasesOfCandidates()
    """Limits of a case, and what is stored of it."""

    def consistency(self) -> Iterator[Fault]:
        yield from super().consistency()
        known = [name for name, *_ in self.named_bases()]
        for key in ("objective", "constraint"):
            for i, entry in enumerate(getattr(self, key)):
                if entry.scenario is not None and entry.scenario not in known:
                    yield Fault((key, i, "scenario"), f"there is {', '.join(known)}")
        if self.search.front is not None and len(self.objective) != 2:
            yield Fault(("search", "front"), f"needs two objectives, not {len(self.objective)}")
        if (several := len(self.vary) > 1) and self.search.method == "bounded":
            yield Fault(("search", "method"), '"bounded" is for one key; "cma" takes several')
        if not several and self.search.method == "cma":
            yield Fault(("search", "method"), '"cma" is for several keys; "bounded" takes one')
        if not several and (self.vary[0].choices or self.vary[0].whole):
            yield Fault(("vary", 0), "one key of few values needs no search: wrsim study runs all of them")


class Output(NamedTuple):
    """An output of a scenario that is sought: name and weight of the scenario, name of the number, its section."""

    scenario: str
    weight: float
    number: str
    section: Any

    def label(self, several: bool) -> str:
        """Its name, with that of the scenario where there are several."""
        return f"{self.number} ({self.scenario})" if several else self.number

    def value(self, candidate: Candidate) -> float:
        """Its number; not-a-number where the case has none."""
        value = candidate.cases[self.scenario].numbers.get(self.number)
        return float("nan") if value is None else value


@dataclass(frozen=True)
class Judged:
    """A candidate as the search has it.

    number: in the order of evaluation, from 1; costs: one, or two of a front, both minimised; margins: of every
    constraint; both not-a-number where a case has no value."""

    number: int
    candidate: Candidate
    costs: tuple[float, ...]
    margins: tuple[float, ...]

    @property
    def complete(self) -> bool:
        """Whether all numbers are there."""
        return all(value == value for value in (*self.costs, *self.margins))

    @property
    def violation(self) -> float:
        """By how much all constraints together are exceeded, as parts of their limits; 0 where they are kept."""
        return sum(max(-margin, 0.0) for margin in self.margins)

    @property
    def feasible(self) -> bool:
        return self.complete and self.violation == 0.0


@dataclass(frozen=True)
class Optimisation:
    """An optimisation, read and checked; objectives, constraints: by scenario; reads: files that were read."""

    spec: OptimisationFile
    candidates: Candidates
    objectives: tuple[Output, ...]
    constraints: tuple[Output, ...]
    reads: tuple[Path, ...]

    @property
    def several(self) -> bool:
        """Whether there are several scenarios."""
        return len(self.candidates.scenarios) > 1

    @property
    def summary(self) -> str:
        """What is varied, sought and allowed, in sentences."""
        candidates = self.candidates
        varied = [f"{', '.join(entry.keys)} ({entry.range_text})" for entry in candidates.varied]
        aims = [f"{entry.aim or f'target {entry.target:g}'}: {entry.number_name}" for entry in self.spec.objective]
        allowed = f" Constraints: {'; '.join(self.margin_names)}." if self.constraints else ""
        scenarios = f" Scenarios: {', '.join(entry.base.title for entry in candidates.scenarios)}."
        return f"Varied: {'; '.join(varied)}. Objective: {'; '.join(aims)}.{allowed}{scenarios}"

    @property
    def shown_costs(self) -> list[tuple[str, float]]:
        """Names of the costs and factors with which they are shown: what is maximised as it is, not its negative."""
        sections = self.spec.objective
        if self.spec.search.front is None and len(sections) > 1:
            return [("cost", 1.0)]
        signs = [-1.0 if aim.aim == "maximise" else 1.0 for aim in sections]
        names = [f"squared deviation of {aim.number_name}" if aim.aim is None else aim.number_name for aim in sections]
        return list(zip(names, signs, strict=True))

    def shown(self, judged: Judged) -> dict[str, float | None]:
        """Costs of a candidate as they are shown, by name; None where it has none."""
        pairs = zip(self.shown_costs, judged.costs, strict=True)
        return {name: finite(sign * cost) for (name, sign), cost in pairs}

    @property
    def margin_names(self) -> list[str]:
        """What each of the margins is of."""
        return [f"{each.label(self.several)} {label}" for each in self.constraints for label in each.section.labels]

    def judged(self, number: int, candidate: Candidate) -> Judged:
        """Costs and margins of a candidate."""
        costs = [each.weight * each.section.cost(each.value(candidate)) for each in self.objectives]
        if self.spec.search.front is None:
            costs = [sum(costs)]
        else:
            pairs = list(zip(self.objectives, costs, strict=True))
            costs = [sum(cost for each, cost in pairs if each.section is section) for section in self.spec.objective]
        margins = chain.from_iterable(each.section.margins(each.value(candidate)) for each in self.constraints)
        return Judged(number, candidate, tuple(costs), tuple(margins))


def read_optimisation(file: Path, folder: Path, models: Sequence[str | Path] = ()) -> Optimisation:
    """The optimisation of a file, everything checked that can be before a case runs. Raises InputError."""
    with noting_reads() as seen:
        source = FileInput(file, "optimisation file", OptimisationFile, models)
        spec: OptimisationFile = source.spec
        names = [name for name, *_ in spec.named_bases()]
        sought: list[Sought] = [
            (key, i, row) for key in ("objective", "constraint") for i, row in enumerate(getattr(spec, key))
        ]
        hooks: dict[str, str] = {}
        for key, i, row in sought:
            for name in names:
                if row.hook and row.scenario in (None, name) and hooks.setdefault(name, row.hook) != row.hook:
                    with source.naming(key, i, "hook", value=row.hook):
                        raise InputError(f"must be one hook a scenario: '{name}' has {hooks[name]}")
        files = {name: source.hook_file(hook, "objective") for name, hook in hooks.items()}
        outputs = {name: _united(row for _, _, row in sought if row.scenario in (None, name)) for name in names}
        candidates = read_candidates(source, folder, outputs, files)
    for scenario in candidates.scenarios:
        _probe(candidates, scenario, [each for each in sought if each[2].scenario in (None, scenario.name)])
    weights = {scenario.name: scenario.weight for scenario in candidates.scenarios}

    def of_scenarios(sections: Sequence[SoughtOutput]) -> tuple[Output, ...]:
        return tuple(
            Output(name, weights[name], row.number_name, row)
            for row in sections
            for name in names
            if row.scenario in (None, name)
        )

    return Optimisation(spec, candidates, of_scenarios(spec.objective), of_scenarios(spec.constraint), tuple(seen))


def _united(sought: Iterable[SoughtOutput]) -> OutputsSection:
    """All outputs of a scenario. Raises InputError where two of them share a name."""
    parts = [row.outputs() for row in sought]
    channels = tuple(dict.fromkeys(chain.from_iterable(part.channels for part in parts)))
    for name in repeated(row.column for row in channels):
        raise InputError(f'two outputs are called "{name}": give one of them another name')
    return OutputsSection(
        channels=channels,
        summary=tuple(dict.fromkeys(chain.from_iterable(part.summary for part in parts))),
        assessment=tuple(dict.fromkeys(chain.from_iterable(part.assessment for part in parts))),
        hook=next((part.hook for part in parts if part.hook), None),
    )


def _probe(candidates: Candidates, scenario: OneScenario, sought: Sequence[Sought]) -> None:
    """Refuse outputs that no case of a scenario can have, by its start: the first steps of a run, whose channels are
    those of the whole, or the case itself where it takes seconds. Raises InputError."""
    values = candidates.values(candidates.start)
    moves = ANALYSES[scenario.base.analysis].moves
    early = [(key, i, row) for key, i, row in sought if not moves or row.channel or row.summary]
    if not early or not missing(candidates.plan(scenario, [values])[0]):
        return
    start = scenario.base.with_values(candidates.changes(values))
    hook = Path(scenario.hook) if scenario.hook else None
    with suppress(SimulationError):  # a start that fails is told with the others
        result = begun(start) if moves else run(start, setup=build(start), threads=1)
        for key, i, row in early:
            if moves and row.summary:
                with candidates.source.naming(key, i, "summary"):
                    check_place(result, row.summary)
            elif faults := case_outputs(result, row.outputs(), hook).faults:
                with candidates.source.naming(key, i):
                    raise InputError(faults[0].removeprefix("outputs."))
