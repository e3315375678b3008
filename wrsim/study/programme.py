"""The file of a type test: vehicle states, runs on track that is made for them, stationary tests, a rule set."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from wrsim.assessment.rules import USUAL, RulesFile, rule_set
from wrsim.assessment.sections import cant_deficiency, section_length, zone_of
from wrsim.errors import InputError
from wrsim.inputs.checking import fault_line
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.toml_files import noting_reads
from wrsim.inputs.values import List, number, positive, repeated, text
from wrsim.scenario.sections.irregularities import IrregularitySection
from wrsim.scenario.sections.steady import SHARPEST
from wrsim.scenario.sections.track import Cant
from wrsim.study.axes import AxisPoints
from wrsim.study.plan import Plan, StudyInput, with_cases
from wrsim.study.spec import CasesSection, Key, OutputsSection
from wrsim.track.cant import CANT_BASE
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

AHEAD = 60.0  # straight track before and behind a curve: a vehicle with its ends, and even track to start on [m]
MOST_DEFICIENCY = 400  # of cant [mm]
STATE, RUN = "state", "run"
Word = Annotated[str, text("a name")]


class StateSection(Section, header="[[states]]"):
    """A state of the vehicle: empty, laden, with worn wheels, with deflated springs, on wet rails."""

    name: Word
    """Name of the state."""
    set: dict[Key, Any] = {}
    """Keys of the scenario and their values in this state; all states set the same keys."""


class ProgrammeRun(Section, header="[[runs]]"):
    """Runs in one test zone: full curves of a radius, or straight track, at a speed."""

    former = {"hands": "directions"}
    one_of = ("speed_kmh cant_deficiency_mm",)
    goes_with = {"cant_deficiency_mm": "radius_m", "cant_mm": "radius_m"}

    name: Word
    """Name of the run."""
    radius_m: Annotated[float, number(SHARPEST, 1e6, "m")] | None = None
    """Radius of the curve; straight track unless given."""
    directions: Literal["left", "right", "both"] = "both"
    """Curves to one side, or one run to either."""
    cant_mm: Cant = 0.0
    """Cant of the curve."""
    speed_kmh: Annotated[float, number(1, 500)] | None = None
    """Speed of the run."""
    cant_deficiency_mm: Annotated[float, number(-200, MOST_DEFICIENCY, "mm")] | None = None
    """Cant deficiency of the run, which gives its speed."""
    sections: Annotated[int, number(1, 1000)]
    """Number of sections, each as long as the rule set asks for."""
    transition_m: Annotated[float, number(1, 1000, "m")] = 100.0
    """Length of the transitions, clothoids."""
    uneven: bool = True
    """Whether the track is uneven, where [irregularities] are given."""
    irregularities: List[Annotated[IrregularitySection, Field(discriminator="kind")]] = ()
    """Irregularities of this run besides, as in [[track.irregularities]]: defects, waves of 49 CFR 213 (mcat)."""

    def consistency(self) -> Iterator[Fault]:
        if self.cant_deficiency_mm is not None and self.cant_deficiency_mm + self.cant_mm <= 0.0:
            yield Fault("cant_deficiency_mm", f"must be above {-self.cant_mm:g}: there is no such speed")

    @property
    def speed(self) -> float:
        """Speed [m/s]."""
        if self.speed_kmh is not None:
            return self.speed_kmh / 3.6
        missing = ((self.cant_deficiency_mm or 0.0) + self.cant_mm) / 1e3
        return float((missing / CANT_BASE * STANDARD_GRAVITY * (self.radius_m or 0.0)) ** 0.5)

    @property
    def deficiency(self) -> float:
        """Cant deficiency [mm]; none on straight track."""
        if self.radius_m is None:
            return 0.0
        return float(1e3 * cant_deficiency(self.speed, 1.0 / self.radius_m, self.cant_mm / 1e3))

    def track(self, sign: float, rules: RulesFile) -> list[dict[str, Any]]:
        """Segments of the track: a curve to the left (sign 1) or to the right, or straight track."""
        zone = zone_of(0.0 if self.radius_m is None else 1.0 / self.radius_m, rules.classes)
        length = self.sections * section_length(zone, self.speed, rules.classes)
        if self.radius_m is None:
            return [_straight(AHEAD + length + AHEAD)]
        arc = {"kind": "arc", "radius_m": sign * self.radius_m, "length_m": length, "cant_mm": self.cant_mm}
        transition = {"kind": "transition", "length_m": self.transition_m}
        return [_straight(AHEAD), transition, arc, dict(transition), _straight(AHEAD)]


def _straight(length: float) -> dict[str, Any]:
    return {"kind": "straight", "length_m": length}


class ProgrammeIrregularities(Section, header="[irregularities]"):
    """Uneven track of all runs: another realisation of one spectrum for every run."""

    spectrum: Annotated[str, text('a spectrum such as "ERRI-low"')]
    """Its name, as in [[track.irregularities]]."""
    seed: Annotated[int, number(0, 2**31 - 1)] = 1
    """Seed of the first run; the others follow."""
    scale: Annotated[float, number(0.01, 100)] = 1.0
    """Factor on all amplitudes."""


class ProgrammeFile(Section, header="a type test"):
    """A type test: the scenario it starts from, states of the vehicle, runs, stationary tests, rules."""

    title: Annotated[str, text("a title")] | None = None
    """Title of the test; that of its scenario unless given."""
    base: Annotated[str, text('a scenario file such as "coach.toml"')]
    """Scenario of a run with vehicle, rails and contact; its segments and irregularities are replaced."""
    rules: Annotated[str, text("a rule set or a file of your own")] = USUAL
    """Rule set of the runs."""
    stationary: List[Literal["twist", "rotation", "cant", "weighing", "settling", "conicity"]] = ()
    """Stationary tests of every state: twist and rotation by EN 14363; at rest on the largest cant deficiency of the
    runs by 49 CFR 213.57, with the flexibility coefficient; wheel loads; sinking under payload_kg; equivalent conicity
    at the highest speed of the runs."""
    payload_kg: Annotated[float, positive(1e6, "kg")] | None = None
    """Payload on the car body, for the test "settling"."""
    flexibility_coefficient: Annotated[float, positive(1)] | None = None
    """That of the design, with which the gauge is calculated: limit of s in the test "cant"; 0.4 unless given."""
    states: Annotated[List[StateSection], Field(min_length=1)]
    """States of the vehicle."""
    runs: Annotated[List[ProgrammeRun], Field(min_length=1)]
    """Runs of every state."""
    irregularities: ProgrammeIrregularities | None = None
    """Uneven track; even unless given."""
    cases: CasesSection = CasesSection()
    """Limits of a run."""

    def consistency(self) -> Iterator[Fault]:
        for key in ("states", "runs"):
            for name in repeated(each.name for each in getattr(self, key)):
                yield Fault(key, f'two of them are called "{name}"')
        first = self.states[0]
        for i, state in enumerate(self.states[1:], 1):
            if odd := sorted(set(state.set) ^ set(first.set)):
                message = f"{odd[0]}: must be set in every state: one of '{first.name}' and '{state.name}' lacks it"
                yield Fault(("states", i, "set"), message)
        if "cant" in self.stationary and not 0.0 < self.deficiency <= MOST_DEFICIENCY:
            largest = f"the largest is {self.deficiency:.0f} mm"
            yield Fault(
                "stationary", f'"cant" needs a cant deficiency of the runs up to {MOST_DEFICIENCY:g} mm: {largest}'
            )
        if "settling" in self.stationary and self.payload_kg is None:
            yield Fault("payload_kg", 'stationary = ["settling"] needs it', missing=True)
        if self.cases.keep != "results":
            yield Fault(("cases", "keep"), 'must be "results": they are assessed together')

    @property
    def deficiency(self) -> float:
        """Largest cant deficiency of the runs [mm]."""
        return max(run.deficiency for run in self.runs)

    @property
    def speed(self) -> float:
        """Highest speed of the runs [m/s]."""
        return max(run.speed for run in self.runs)


@dataclass(frozen=True)
class Programme:
    """A type test: its file, its plan, the rules of its runs; reads: files that were read; names: of the runs."""

    spec: ProgrammeFile
    plan: Plan
    rules: RulesFile
    reads: tuple[Path, ...]
    names: tuple[str, ...]


def read_programme(file: Path, folder: Path, models: Sequence[str | Path] = ()) -> Programme:
    """The type test of a file, every case checked. Raises InputError with all faults, one line each."""
    with noting_reads() as seen:
        test = StudyInput(file, "type test", ProgrammeFile, models)
        spec: ProgrammeFile = test.spec
        with test.naming("rules", value=spec.rules):
            rules = rule_set(spec.rules if not spec.rules.endswith(".toml") else test.finder.find(spec.rules))
            if rules.history is None:
                raise InputError(f"{rules.title}: has no clause about runs")
        if test.base.analysis != "curving":
            raise InputError(
                fault_line(("base",), 'must be a scenario of analysis = "curving"', test.locate, spec.base)
            )
        keys = tuple(spec.states[0].set)
        states = AxisPoints(
            STATE, tuple((key,) for key in keys), tuple(tuple(s.set[key] for key in keys) for s in spec.states),
            tuple(test.locate(("states", i)) for i in range(len(spec.states))), tuple(s.name for s in spec.states),
            listed=True,
        )  # fmt: skip
        runs = _runs(spec, rules, test)
        plan = test.plan_of(test.base, test.title, folder, (states, runs), OutputsSection(), spec.cases)
    plan, read = with_cases(plan, test.base)
    return Programme(spec, plan, rules, tuple(dict.fromkeys((*seen, *read))), runs.labels)


def _runs(spec: ProgrammeFile, rules: RulesFile, test: StudyInput) -> AxisPoints:
    """Every run, to either side, with its speed, track and irregularities."""
    values: list[tuple[Any, ...]] = []
    places: list[str] = []
    labels: list[str] = []
    for i, each in enumerate(spec.runs):
        two_sided = each.radius_m is not None and each.directions == "both"
        directions = ("left", "right") if two_sided else (each.directions if each.radius_m is not None else "",)
        for direction in directions:
            uneven: list[dict[str, Any]] = []
            if spec.irregularities is not None and each.uneven:
                rough = spec.irregularities
                uneven = [
                    {"kind": "spectrum", "spectrum": rough.spectrum, "seed": rough.seed + len(values)}
                    | {"scale": rough.scale, "from_m": 0.5 * AHEAD}
                ]
            uneven += [table.model_dump(exclude_unset=True) for table in each.irregularities]
            values.append((3.6 * each.speed, each.track(-1.0 if direction == "right" else 1.0, rules), uneven))
            places.append(test.locate(("runs", i)))
            labels.append(f"{each.name} {direction}".strip() if two_sided else each.name)
    keys = (("vehicle.speed_kmh",), ("track.segments",), ("track.irregularities",))
    return AxisPoints(RUN, keys, tuple(values), tuple(places), tuple(labels), listed=True)
