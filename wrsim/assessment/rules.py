"""Rule sets: what a standard or a law limits, how that is evaluated and where the limit comes from; one file a set.

``data`` holds the sets; quantities and laws of limits: ``assessment.limits``. Marks of sources: [read] in the text
itself, [pub] in a published source about it, [mem] from memory, to be confirmed against the text.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache, cached_property
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from annotated_types import Predicate
from pydantic import BeforeValidator, Field

from wrsim.assessment import limits
from wrsim.errors import InputError
from wrsim.inputs.checking import check_section, opened
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import List, Two, choice, number, positive, text
from wrsim.results.channels import SHOWN

FOLDER = Path(__file__).parent / "data"
NAMES = tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))
"""Rule sets that come with wrsim."""
USUAL = "en14363"

Percent = Annotated[float, number(0, 100, "%")]
Percents = Annotated[
    tuple[Percent, ...],
    Field(strict=False, min_length=1, max_length=2, description="a percentile from 0 to 100, or a list of two"),
    BeforeValidator(lambda value: value if isinstance(value, list | tuple) else (value,)),
]
Hz = Annotated[float, positive(1000, "Hz")]
Length = Annotated[float, positive(1000, "m")]


class ClauseSection(Section, header="[[clauses]]"):
    """One clause: a quantity, how it is evaluated, its limit."""

    together = ("window_m step_m",)
    goes_with: ClassVar[dict[str, str]] = {"over": "window_m", "classes": "limit"}

    id: Annotated[str, text("a name of the clause")]
    """Name of the clause in this set."""
    quantity: limits.QUANTITY_NAMES.key()  # type: ignore[valid-type]
    """What is judged."""
    evaluation_source: Annotated[str, text("where the evaluation stands, with its mark")] | None = None
    """Where it stands how the quantity is evaluated."""
    low_pass_Hz: Hz | None = None
    """Low-pass of the signal."""
    band_Hz: Annotated[Two[Hz], Predicate(lambda band: band[0] < band[1])] | None = None
    """Band-pass of the signal, two rising frequencies."""
    half_band_Hz: Hz | None = None
    """Half the width of the band about the frequency of an instability."""
    least_rate_Hz: Hz | None = None
    """Least number of samples a second."""
    window_m: Length | None = None
    """Length of sliding windows."""
    step_m: Length | None = None
    """Distance of sliding windows."""
    over: Literal["mean", "held"] = "mean"
    """What counts of a window: its mean, or the value that is exceeded all over it."""
    window_s: Annotated[float, positive(100, "s")] | None = None
    """Duration of sliding windows, over which an rms is taken."""
    percentile: Percents | None = None
    """Percentile of the values in a section; of two the larger magnitude. 100: the largest, 0: the least value."""
    friction: Annotated[float, number(0.01, 2)] | None = None
    """Coefficient for Nadal's limit; that of the run unless given."""
    lean: Annotated[float, number(0, 2)] | None = None
    """Mean Y/Q of the inner wheel from which the guiding force is reduced."""
    lean_force_kN: limits.Force | None = None
    """By how much for one of Y/Q."""
    part: Annotated[float, number(0, 2)] | None = None
    """Part of Q_qst in B_qst."""
    limit: limits.AnyLimit | None = None
    """The limit; of quantities for information none is needed."""
    classes: List[str] = ()
    """Classes of track in which the limit holds; all unless given."""

    def consistency(self) -> Iterator[Fault]:
        known = limits.QUANTITIES[self.quantity]
        takes = known.takes.split()
        taken = {key.rstrip("?") for key in takes}
        for key in {key for take in limits.QUANTITIES.values() for key in take.takes.replace("?", "").split()} - taken:
            if key in self.model_fields_set:
                allowed = f"takes {', '.join(sorted(taken))}" if taken else "takes no key of evaluation"
                yield Fault(key, f'quantity "{self.quantity}" {allowed}')
        for key in takes:
            if not key.endswith("?") and getattr(self, key) is None:
                yield Fault(key, f'quantity "{self.quantity}" needs it', missing=True)
        unit = next(name for name, shown in SHOWN.items() if shown == known.shown)
        if self.limit is None:
            if known.group != limits.INFORMATION:
                yield Fault("limit", f'quantity "{self.quantity}" is judged ({known.group})', missing=True)
        elif unit not in (units := (self.limit.unit,) if isinstance(self.limit, limits.Constant) else self.limit.units):
            key, law = ("unit", "") if isinstance(self.limit, limits.Constant) else ("law", f', this law "{units[0]}"')
            yield Fault(("limit", key), f'quantity "{self.quantity}" has the unit "{unit}"{law}')

    def limit_at(self, about: limits.LimitContext) -> limits.Limit | None:
        """The limit there; None where there is none."""
        if self.limit is None or (self.classes and about.zone not in self.classes):
            return None
        return self.limit.limit(about)

    @cached_property
    def judged(self) -> limits.Quantity:
        """The quantity with this evaluation."""
        known = limits.QUANTITIES[self.quantity]
        evaluation = known.evaluation.replace("{}", ", ".join(self._evaluation()))
        return replace(known, evaluation=evaluation, source=self.evaluation_source or "")

    def _evaluation(self) -> Iterator[str]:
        if self.low_pass_Hz is not None:
            yield f"low-pass {self.low_pass_Hz:g} Hz"
        if self.band_Hz is not None:
            yield f"band-pass {self.band_Hz[0]:g} to {self.band_Hz[1]:g} Hz"
        if self.half_band_Hz is not None:
            yield f"band-pass f0 - {self.half_band_Hz:g} Hz to f0 + {self.half_band_Hz:g} Hz"
        if self.window_m is not None:
            how = "rms" if self.half_band_Hz is not None else self.over
            yield f"{how} over {self.window_m:g} m every {self.step_m:g} m"
        if self.window_s is not None:
            yield f"mean removed, rms over {self.window_s:g} s, at least {self.least_rate_Hz:g} samples a second"
        if self.percentile is not None and len(self.percentile) == 2:
            yield f"percentiles {self.percentile[0]:g} and {self.percentile[1]:g} %, the larger magnitude"
        elif self.percentile is not None:
            names = {100.0: "largest", 0.0: "least"}
            yield names.get(self.percentile[0], f"percentile {self.percentile[0]:g} %")


class ClassSection(Section, header="[[classes]]"):
    """A class of track by its radius, and the length of its sections."""

    name: Annotated[str, text("a name")]
    """Its name; the first class is "straight"."""
    from_radius_m: limits.Radius
    """The radius down to which it reaches."""
    lengths: Annotated[List[Two[Annotated[float, number(1, 1e5)]]], Field(min_length=1)]
    """Rows of a speed [km/h] and the length of sections [m] up to it; the last length holds beyond, too."""
    sections_needed: Annotated[int, number(1, 10_000)] | None = None
    """How many sections a test needs."""


class HistorySection(Section, header="[history]"):
    """How forces are shown over the distance."""

    low_pass_Hz: Hz
    """Low-pass of the forces."""
    window_m: Length
    """Length of the sliding mean of ΣY and Y/Q."""
    step_m: Length
    """Distance of its places."""


class StatisticsSection(Section, header="[statistics]"):
    """Estimated maxima over the sections of a class."""

    sections: Annotated[int, number(2, 10_000)]
    """Least number of sections of a class for an estimate."""
    safety: Annotated[float, number(0, 10)]
    """Standard deviations above the mean, of running safety."""
    others: Annotated[float, number(0, 10)]
    """The same of all other groups."""
    tested: Two[Annotated[float, number(0, 10)]]
    """Cant deficiency of full curves that count, from and to, over the admissible one."""
    mark: Literal["read", "pub", "mem"]
    """Read in the text itself, in a published source about it, or from memory."""


class RulesFile(Section, header="a rule set"):
    """A rule set."""

    title: Annotated[str, text("a title")]
    """What these rules are."""
    name: Annotated[str, text("a short name")]
    """The short name in verdicts."""
    history: HistorySection | None = None
    """How forces are shown over the distance; for clauses about runs."""
    statistics: StatisticsSection | None = None
    """Estimated maxima over the sections of a class; none unless given."""
    straight_deficiency_mm: Annotated[float, number(0, 200, "mm")] | None = None
    """Cant deficiency up to which curves of the second class count as straight track."""
    classes: List[ClassSection] = ()
    """Classes of track, large radii first; for clauses about runs."""
    clauses: Annotated[List[ClauseSection], Field(min_length=1)]
    """The clauses, in the order of tables."""

    def consistency(self) -> Iterator[Fault]:
        if len(self.judging("rest")) < len(self.clauses):
            for key in ("history", "classes"):
                if not getattr(self, key):
                    yield Fault(key, "must be given: some clauses are about runs", missing=True)
        if self.classes and self.classes[0].name != "straight":
            yield Fault(("classes", 0, "name"), 'the first class is "straight"')
        for i, each in enumerate(self.classes[1:], 1):
            if not each.from_radius_m < (before := self.classes[i - 1].from_radius_m):
                yield Fault(("classes", i, "from_radius_m"), f"must be below that of the class before ({before:g})")
        if self.classes and (last := self.classes[-1].from_radius_m) > 0.0:
            yield Fault(("classes", len(self.classes) - 1, "from_radius_m"), f"{last:g}: must be 0 in the last class")
        names = (*(each.name for each in self.classes), "transition")
        for key in ("id", "quantity"):
            values = [getattr(each, key) for each in self.clauses]
            for i, value in enumerate(values):
                if value in values[:i]:
                    yield Fault(("clauses", i, key), f'"{value}": is that of clauses[{values.index(value)}] already')
        for i, clause in enumerate(self.clauses):
            for word in clause.classes:
                if word not in names:
                    yield Fault(("clauses", i, "classes"), f'"{word}": must be {choice(names, word)}')

    def about(self, quantity: str) -> ClauseSection | None:
        """The clause about a quantity; None without one."""
        return next((each for each in self.clauses if each.quantity == quantity), None)

    def judging(self, *levels: str) -> list[ClauseSection]:
        """The clauses about what belongs to these."""
        return [each for each in self.clauses if limits.QUANTITIES[each.quantity].level in levels]

    @property
    def needed(self) -> Mapping[str, int]:
        """How many sections of a class a test needs, where the set says."""
        return {each.name: each.sections_needed for each in self.classes if each.sections_needed is not None}


def rule_set(name: str | Path = USUAL) -> RulesFile:
    """A rule set by its name, or from a file of the user's (``.toml``).

    Raises InputError with all faults of a file, and for a name that is none of ``NAMES``.
    """
    known = str(name).lower()
    if known in NAMES:
        return _shipped(known)
    if Path(name).suffix != ".toml":
        raise InputError(f'rules = "{name}": must be {choice(NAMES, known)}; or a file of your own, such as my.toml')
    return _read(Path(name))


@cache
def _shipped(name: str) -> RulesFile:
    return _read(FOLDER / f"{name}.toml")


def _read(path: Path) -> RulesFile:
    return check_section(RulesFile, *opened(path, "rule set"))
