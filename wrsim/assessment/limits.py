"""What rule sets limit, and the laws by which limits go: a constant, or one with parameters of a clause.

``data/quantities.csv`` names what may be judged; ``LimitContext`` is what laws depend on.
"""

from dataclasses import dataclass
from math import inf
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from wrsim.inputs.section import Choice, Section
from wrsim.inputs.terms import Names
from wrsim.inputs.values import List, OrTable, Two, number, positive, text
from wrsim.results.channels import SHOWN, Shown, table

SAFETY, LOADING, RIDE, INFORMATION = "running safety", "track loading", "ride characteristics", "information"

Kind = Literal["passenger", "locomotive", "freight"]


@dataclass(frozen=True)
class Quantity:
    """What is judged: its symbol, its meaning, its group, how it is evaluated, and from where that comes.

    level: what it belongs to: "axle", "bogie", "stop", "frame", "body" or "rest" (a vehicle at rest); takes: keys of a
    clause about it, with ? where it may lack; lowest: small values are the bad ones.
    """

    key: str
    symbol: str
    meaning: str
    group: str
    shown: Shown
    level: str
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
    for row in table("wrsim.assessment", "data/quantities.csv")
}
"""By their keys, in the order of the tables."""
QUANTITY_NAMES = Names({key: (quantity.symbol, *quantity.meaning.split(",")) for key, quantity in QUANTITIES.items()})
"""With other terms for them."""
RUN_QUANTITIES = tuple(key for key, quantity in QUANTITIES.items() if quantity.level != "rest")
"""What may be judged of runs."""


@dataclass(frozen=True)
class Limit:
    """The largest value allowed, of a quantity whose small values are bad the least one, and its source; ``mark``:
    "read", "pub", "mem" as in the rule set, or "file"."""

    value: float
    source: str
    mark: str

    @property
    def reference(self) -> str:
        """Source and mark."""
        return f"{self.source} [{self.mark}]"

    @property
    def star(self) -> str:
        """A mark for what comes from memory of the standard."""
        return "*" if self.mark == "mem" else ""


@dataclass(frozen=True)
class LimitContext:
    """What limits depend on, SI units: kind of vehicle; static load of a wheelset [N]; class of track, radius [m] and
    speed [m/s]; mass of a bogie [kg]; Nadal's limit of Y/Q with its derivation, where it is known."""

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
    """Value for coaches and multiple units."""
    locomotive: Annotated[float, number()]
    """Value for locomotives."""
    freight: Annotated[float, number()]
    """Value for freight wagons."""


Number = OrTable[Annotated[float, number()], ByKind]
Radius = Annotated[float, number(0, 1e5, "m")]
Force = Annotated[float, number(0, 1e4, "kN")]


def _of_kind(value: float | ByKind, kind: Kind) -> float:
    return getattr(value, kind) if isinstance(value, ByKind) else value  # type: ignore[no-any-return]


class LimitLaw(Choice, header="limit"):
    """A limit and its source."""

    tag = "law"
    units: ClassVar[tuple[str, ...]] = ("1",)
    """Units of the quantities that it may limit."""

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

    def limit(self, about: LimitContext) -> Limit | None:
        """The limit there; None where it does not hold or something that it depends on is unknown."""
        if self.from_radius_m is not None and abs(about.radius) < self.from_radius_m * (1.0 - 1e-6):
            return None
        valued = self.value_at(about)
        if valued is None:
            return None
        value, derivation = valued
        ahead = self.source if self.from_radius_m is None else f"{self.source}, R >= {self.from_radius_m:g} m"
        return Limit(value, ": ".join(filter(None, (ahead, self.words or "", derivation))), self.mark)

    def value_at(self, about: LimitContext) -> tuple[float, str] | None:
        """The value in SI units and what there is to say about it."""
        raise NotImplementedError


class Constant(LimitLaw, kind="constant"):
    """A number, or one for every kind of vehicle."""

    value: Number
    """The largest value allowed; the least one of a quantity whose small values are bad."""
    unit: Literal[*SHOWN]  # type: ignore[valid-type]
    """Unit of the value, that of the quantity."""

    def value_at(self, about: LimitContext) -> tuple[float, str]:
        value = _of_kind(self.value, about.kind) * (1.0 / SHOWN[self.unit].factor)
        return value, about.kind * isinstance(self.value, ByKind)


class Prudhomme(LimitLaw, kind="prudhomme"):
    """A part of k1 (a + 2Q0/n): Prud'homme's limit of the force that shifts the track."""

    units: ClassVar[tuple[str, ...]] = ("kN",)

    k1: Number
    """Factor of the kind of vehicle."""
    constant_kN: Force
    """The force a."""
    divisor: Annotated[float, positive(100)]
    """The number n."""
    part: Annotated[float, positive(1)] = 1.0
    """Part of it that is allowed."""

    def value_at(self, about: LimitContext) -> tuple[float, str]:
        k1, part = _of_kind(self.k1, about.kind), f"{self.part:g} " * (self.part != 1.0)
        derivation = f"{part}k1 ({self.constant_kN:g} kN + 2Q0/{self.divisor:g}), k1 = {k1:g} (Prud'homme)"
        return self.part * (k1 * (1e3 * self.constant_kN + about.axle_load / self.divisor)), derivation


class AxleShare(LimitLaw, kind="axle-share"):
    """Limit of a force over the static load of a wheelset: share + a/2Q0."""

    share: Annotated[float, number(0, 2)]
    """Part of the load."""
    constant_kN: Force
    """The force a."""

    def value_at(self, about: LimitContext) -> tuple[float, str]:
        derivation = f"{self.share:g} + {self.constant_kN:g} kN/2Q0"
        return self.share + 1e3 * self.constant_kN / about.axle_load, derivation


class WheelForce(LimitLaw, kind="wheel-force"):
    """a + Q0, at most a force that falls with the speed."""

    units: ClassVar[tuple[str, ...]] = ("kN",)

    constant_kN: Force
    """The force a."""
    most: Annotated[List[Two[Annotated[float, number(0, 1e4)]]], Field(min_length=1)]
    """Rows of a speed [km/h] and the largest limit [kN] up to it."""
    beyond_kN: Force
    """The largest limit at higher speeds."""

    def value_at(self, about: LimitContext) -> tuple[float, str]:
        kmh = 3.6 * about.speed - 1e-6
        most = next((1e3 * force for speed, force in self.most if kmh <= speed), 1e3 * self.beyond_kN)
        derivation = f"{self.constant_kN:g} kN + Q0, at most {most / 1e3:g} kN at this speed"
        return min(1e3 * self.constant_kN + 0.5 * about.axle_load, most), derivation


class BySpeed(LimitLaw, kind="speed"):
    """A number without unit that falls with the highest speed."""

    most: Annotated[List[Two[Annotated[float, number(0, 1e4)]]], Field(min_length=1)]
    """Rows of a speed [km/h] and the limit up to it."""
    beyond: Annotated[float, number(0, 1e4)]
    """The limit at higher speeds."""

    def value_at(self, about: LimitContext) -> tuple[float, str]:
        value = next((value for speed, value in self.most if 3.6 * about.speed - 1e-6 <= speed), self.beyond)
        return value, f"{3.6 * about.speed:.4g} km/h"


class ByRadius(LimitLaw, kind="radius"):
    """a + b/Rm below a radius, a constant above; Rm: mean radius of the sections of a class of curves."""

    units: ClassVar[tuple[str, ...]] = ("kN",)

    constant_kN: Force
    """The force a."""
    slope_kNm: Annotated[float, number(0, 1e6, "kN m")]
    """The factor b."""
    to_radius_m: Radius
    """Radius from which the limit is constant."""
    beyond_kN: Force
    """The limit from there on."""

    def value_at(self, about: LimitContext) -> tuple[float, str]:
        if about.radius >= self.to_radius_m:
            return 1e3 * self.beyond_kN, ""
        derivation = f"{self.constant_kN:g} kN + {self.slope_kNm:g} kN m/Rm, Rm = {about.radius:.0f} m"
        return 1e3 * self.constant_kN + 1e3 * self.slope_kNm / about.radius, derivation


class Nadal(LimitLaw, kind="nadal"):
    """(tan g - mu)/(1 + mu tan g) (Nadal 1896): g from the run, mu from the run or from `friction` of the clause."""

    def value_at(self, about: LimitContext) -> tuple[float, str] | None:
        return about.nadal


class BogieMass(LimitLaw, kind="bogie-mass"):
    """A part of a - m/b, m: mass of the bogie with its wheelsets."""

    units: ClassVar[tuple[str, ...]] = ("m/s2", "g")

    constant: Annotated[float, number(0, 100, "m/s2")]
    """The acceleration a."""
    divisor: Annotated[float, positive(1000, "t per m/s2")]
    """The mass b."""
    part: Annotated[float, positive(1)]
    """Part of it that is allowed."""

    def value_at(self, about: LimitContext) -> tuple[float, str]:
        derivation = f"{self.part:g} ({self.constant:g} - m/{self.divisor:g}), bogie of {about.bogie_mass / 1e3:.3g} t"
        return self.part * (self.constant - about.bogie_mass / (1e3 * self.divisor)), derivation


AnyLimit = Annotated[
    Constant | Prudhomme | AxleShare | WheelForce | BySpeed | ByRadius | Nadal | BogieMass, Field(discriminator="law")
]
