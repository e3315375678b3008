"""Rule sets: what a standard or a law limits, how that is evaluated and where the limit comes from; one file a set.

``data/quantities.csv`` names what may be judged, ``data/rules`` holds the sets. A limit is a constant or goes by a law
of this module with parameters of the file; ``About`` is what laws depend on. Marks of sources: [read] in the text
itself, [pub] in a published source about it, [mem] from memory, to be confirmed against the text.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import inf
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from annotated_types import Predicate
from pydantic import BeforeValidator, Field

from wrsim.errors import InputError
from wrsim.inputs.checking import check_section, opened
from wrsim.inputs.section import Choice, Fault, Section
from wrsim.inputs.values import List, OrTable, Two, choice, number, positive, text
from wrsim.results.channels import SHOWN, Shown, table

FOLDER = Path(__file__).parent / "data" / "rules"
NAMES = tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))
"""Rule sets that come with wrsim."""
USUAL = "en14363"

SAFETY, LOADING, RIDE, INFORMATION = "running safety", "track loading", "ride characteristics", "information"

Kind = Literal["passenger", "locomotive", "freight"]


@dataclass(frozen=True)
class Quantity:
    """What is judged: its symbol, its meaning, its group, how it is evaluated, and from where that comes.

    of: what it belongs to: "axle", "bogie", "stop", "frame", "body" or "rest" (a vehicle at rest); takes: keys of a
    clause about it, with ? where it may lack; lowest: small values are the bad ones.
    """

    key: str
    symbol: str
    words: str
    group: str
    shown: Shown
    of: str
    evaluation: str
    takes: str
    source: str = ""
    quasi_static: bool = False
    lowest: bool = False

    def within(self, value: float, limit: float) -> bool:
        """Whether a value keeps to a limit; not a number does not."""
        return value >= limit if self.lowest else value <= limit

    def margin(self, value: float, limit: float) -> float:
        """What is left to a limit, as a part of it; negative beyond it. Of a share of a static load, whose small values
        are bad: what is left of the way from 1 to the limit."""
        return (value - limit) / (1.0 - limit) if self.lowest else 1.0 - value / limit


QUANTITIES: dict[str, Quantity] = {
    row["key"]: Quantity(
        **row | {"shown": SHOWN[row["shown"]]} | {flag: row[flag] == "yes" for flag in ("quasi_static", "lowest")}
    )
    for row in table("wrsim.results", "data/quantities.csv")
}
"""By their keys, in the order of the tables."""
OF_RUNS = tuple(key for key, own in QUANTITIES.items() if own.of != "rest")
"""What may be judged of runs."""


@dataclass(frozen=True)
class Limit:
    """The largest value allowed, of a quantity whose small values are bad the least one, and its source; ``mark``:
    "read", "pub", "mem" as in the rule set, or "file"."""

    value: float
    source: str
    mark: str

    @property
    def words(self) -> str:
        """Source and mark."""
        return f"{self.source} [{self.mark}]"

    @property
    def star(self) -> str:
        """A mark for what comes from memory of the standard."""
        return "*" if self.mark == "mem" else ""


@dataclass(frozen=True)
class About:
    """What limits depend on, SI units: kind of vehicle; static load of a wheelset [N]; class of track, radius [m] and
    speed [m/s]; mass of a bogie [kg]; Nadal's limit of Y/Q with its words, where it is known."""

    kind: Kind = "passenger"
    axle_load: float = 0.0
    zone: str = ""
    radius: float = inf
    speed: float = 0.0
    bogie_mass: float = 0.0
    nadal: tuple[float, str] | None = None


class ByKind(Section, header="{passenger = .., locomotive = .., freight = ..}"):
    """A number for every kind of vehicle."""

    passenger: Annotated[float, number()]
    """Of coaches and multiple units."""
    locomotive: Annotated[float, number()]
    """Of locomotives."""
    freight: Annotated[float, number()]
    """Of freight wagons."""


Number = OrTable[Annotated[float, number()], ByKind]
Radius = Annotated[float, number(0, 1e5, "m")]
Force = Annotated[float, number(0, 1e4, "kN")]


def _of_kind(given: float | ByKind, kind: Kind) -> float:
    return getattr(given, kind) if isinstance(given, ByKind) else given  # type: ignore[no-any-return]


class LimitLaw(Choice, header="limit"):
    """A limit and its source."""

    tag = "law"

    law: str
    """How the limit is found."""
    source: Annotated[str, text("where the limit stands, such as EN 14363")]
    """Where the limit stands."""
    mark: Literal["read", "pub", "mem"]
    """Read in the text itself, in a published source about it, or from memory."""
    from_radius_m: Radius | None = None
    """Least radius of curves in which it holds; in all of them unless given."""
    words: Annotated[str, text("a few words")] | None = None
    """What the limit is, for tables."""

    def limit(self, about: About, shown: Shown) -> Limit | None:
        """The limit there; None where it does not hold or something that it depends on is unknown."""
        if self.from_radius_m is not None and abs(about.radius) < self.from_radius_m * (1.0 - 1e-6):
            return None
        found = self.value_at(about, shown)
        if found is None:
            return None
        value, words = found
        ahead = self.source if self.from_radius_m is None else f"{self.source}, R >= {self.from_radius_m:g} m"
        return Limit(value, ": ".join(filter(None, (ahead, self.words or "", words))), self.mark)

    def value_at(self, about: About, shown: Shown) -> tuple[float, str] | None:
        """The value in SI units and what there is to say about it. shown: the unit of constants."""
        raise NotImplementedError


class Constant(LimitLaw, kind="constant"):
    """A number, or one for every kind of vehicle."""

    value: Number
    """The largest value allowed; the least one of a quantity whose small values are bad."""
    unit: Literal[*SHOWN]  # type: ignore[valid-type]
    """Unit of the value, that of the quantity."""

    def value_at(self, about: About, shown: Shown) -> tuple[float, str]:
        return _of_kind(self.value, about.kind) * (1.0 / shown.factor), about.kind * isinstance(self.value, ByKind)


class Prudhomme(LimitLaw, kind="prudhomme"):
    """A part of k1 (a + 2Q0/n): Prud'homme's limit of the force that shifts the track."""

    k1: Number
    """Factor of the kind of vehicle."""
    constant_kN: Force
    """The force a."""
    divisor: Annotated[float, positive(100)]
    """The number n."""
    part: Annotated[float, positive(1)] = 1.0
    """Part of it that is allowed."""

    def value_at(self, about: About, shown: Shown) -> tuple[float, str]:
        k1, part = _of_kind(self.k1, about.kind), f"{self.part:g} " * (self.part != 1.0)
        words = f"{part}k1 ({self.constant_kN:g} kN + 2Q0/{self.divisor:g}), k1 = {k1:g} (Prud'homme)"
        return self.part * (k1 * (1e3 * self.constant_kN + about.axle_load / self.divisor)), words


class AxleShare(LimitLaw, kind="axle-share"):
    """Of a force over the static load of a wheelset: share + a/2Q0."""

    share: Annotated[float, number(0, 2)]
    """Part of the load."""
    constant_kN: Force
    """The force a."""

    def value_at(self, about: About, shown: Shown) -> tuple[float, str]:
        words = f"{self.share:g} + {self.constant_kN:g} kN/2Q0"
        return self.share + 1e3 * self.constant_kN / about.axle_load, words


class WheelForce(LimitLaw, kind="wheel-force"):
    """a + Q0, at most a force that falls with the speed."""

    constant_kN: Force
    """The force a."""
    most: Annotated[List[Two[Annotated[float, number(0, 1e4)]]], Field(min_length=1)]
    """Rows of a speed [km/h] and the largest limit [kN] up to it."""
    beyond_kN: Force
    """The largest limit at higher speeds."""

    def value_at(self, about: About, shown: Shown) -> tuple[float, str]:
        kmh = 3.6 * about.speed - 1e-6
        most = next((1e3 * force for speed, force in self.most if kmh <= speed), 1e3 * self.beyond_kN)
        words = f"{self.constant_kN:g} kN + Q0, at most {most / 1e3:g} kN at this speed"
        return min(1e3 * self.constant_kN + 0.5 * about.axle_load, most), words


class BySpeed(LimitLaw, kind="speed"):
    """A number without unit that falls with the highest speed."""

    most: Annotated[List[Two[Annotated[float, number(0, 1e4)]]], Field(min_length=1)]
    """Rows of a speed [km/h] and the limit up to it."""
    beyond: Annotated[float, number(0, 1e4)]
    """The limit at higher speeds."""

    def value_at(self, about: About, shown: Shown) -> tuple[float, str]:
        value = next((value for speed, value in self.most if 3.6 * about.speed - 1e-6 <= speed), self.beyond)
        return value, f"{3.6 * about.speed:.4g} km/h"


class ByRadius(LimitLaw, kind="radius"):
    """a + b/Rm below a radius, a constant above; Rm: mean radius of the sections of a class of curves."""

    constant_kN: Force
    """The force a."""
    slope_kNm: Annotated[float, number(0, 1e6, "kN m")]
    """The factor b."""
    to_radius_m: Radius
    """Radius from which the limit is constant."""
    beyond_kN: Force
    """The limit from there on."""

    def value_at(self, about: About, shown: Shown) -> tuple[float, str]:
        if about.radius >= self.to_radius_m:
            return 1e3 * self.beyond_kN, ""
        words = f"{self.constant_kN:g} kN + {self.slope_kNm:g} kN m/Rm, Rm = {about.radius:.0f} m"
        return 1e3 * self.constant_kN + 1e3 * self.slope_kNm / about.radius, words


class Nadal(LimitLaw, kind="nadal"):
    """(tan g - mu)/(1 + mu tan g) (Nadal 1896): g from the run, mu from the run or from `friction` of the clause."""

    def value_at(self, about: About, shown: Shown) -> tuple[float, str] | None:
        return about.nadal


class BogieMass(LimitLaw, kind="bogie-mass"):
    """A part of a - m/b, m: mass of the bogie with its wheelsets."""

    constant: Annotated[float, number(0, 100, "m/s2")]
    """The acceleration a."""
    divisor: Annotated[float, positive(1000, "t per m/s2")]
    """The mass b."""
    part: Annotated[float, positive(1)]
    """Part of it that is allowed."""

    def value_at(self, about: About, shown: Shown) -> tuple[float, str]:
        words = f"{self.part:g} ({self.constant:g} - m/{self.divisor:g}), bogie of {about.bogie_mass / 1e3:.3g} t"
        return self.part * (self.constant - about.bogie_mass / (1e3 * self.divisor)), words


AnyLimit = Annotated[
    Constant | Prudhomme | AxleShare | WheelForce | BySpeed | ByRadius | Nadal | BogieMass, Field(discriminator="law")
]
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

    aliases: ClassVar[dict[str, str]] = {
        "low_pass_Hz": "filter_Hz cut_off_Hz",
        "id": "clause name",
        "percentile": "percentiles",
    }
    together = ("window_m step_m",)
    goes_with: ClassVar[dict[str, str]] = {"over": "window_m", "classes": "limit"}

    id: Annotated[str, text("a name of the clause")]
    """Name of the clause in this set."""
    quantity: Literal[*QUANTITIES]  # type: ignore[valid-type]
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
    lean_force_kN: Force | None = None
    """By how much for one of Y/Q."""
    part: Annotated[float, number(0, 2)] | None = None
    """Part of Q_qst in B_qst."""
    limit: AnyLimit | None = None
    """The limit; a value without one is told for information."""
    classes: List[str] = ()
    """Classes of track in which the limit holds; all unless given."""

    def consistency(self) -> Iterator[Fault]:
        own = QUANTITIES[self.quantity]
        takes = own.takes.split()
        taken = {key.rstrip("?") for key in takes}
        for key in {key for take in QUANTITIES.values() for key in take.takes.replace("?", "").split()} - taken:
            if key in self.model_fields_set:
                allowed = f"takes {', '.join(sorted(taken))}" if taken else "takes no key of evaluation"
                yield Fault(key, f'quantity "{self.quantity}" {allowed}')
        for key in takes:
            if not key.endswith("?") and getattr(self, key) is None:
                yield Fault(key, f'quantity "{self.quantity}" needs it', missing=True)
        if isinstance(self.limit, Constant) and SHOWN[self.limit.unit] != own.shown:
            unit = next(name for name, shown in SHOWN.items() if shown == own.shown)
            yield Fault(("limit", "unit"), f'quantity "{self.quantity}" has the unit "{unit}"')

    def limit_at(self, about: About) -> Limit | None:
        """The limit there; None where there is none."""
        if self.limit is None or (self.classes and about.zone not in self.classes):
            return None
        return self.limit.limit(about, self.judged.shown)

    @cached_property
    def judged(self) -> Quantity:
        """The quantity with this evaluation in words."""
        own = QUANTITIES[self.quantity]
        words = own.evaluation.replace("{}", ", ".join(self._evaluation()))
        return replace(own, evaluation=words, source=self.evaluation_source or "")

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
            words = {100.0: "largest", 0.0: "least"}
            yield words.get(self.percentile[0], f"percentile {self.percentile[0]:g} %")


class ClassSection(Section, header="[[classes]]"):
    """A class of track by its radius, and the length of its sections."""

    name: Annotated[str, text("a name")]
    """Its name; the first class is "straight"."""
    from_radius_m: Radius
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
            own = [getattr(each, key) for each in self.clauses]
            for i, value in enumerate(own):
                if value in own[:i]:
                    yield Fault(("clauses", i, key), f'"{value}": is that of clauses[{own.index(value)}] already')
        for i, clause in enumerate(self.clauses):
            for word in clause.classes:
                if word not in names:
                    yield Fault(("clauses", i, "classes"), f'"{word}": must be {choice(names, word)}')

    def about(self, quantity: str) -> ClauseSection | None:
        """The clause about a quantity; None without one."""
        return next((each for each in self.clauses if each.quantity == quantity), None)

    def judging(self, *of: str) -> list[ClauseSection]:
        """The clauses about what belongs to these."""
        return [each for each in self.clauses if QUANTITIES[each.quantity].of in of]

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
