"""Tables of a vehicle file: bodies, wheelsets, elements, parts and their places, in the user's units."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field

from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import List, Switch, Three, Two, number, positive, refuse, text

Metre = Annotated[float, number(-200_000, 200_000, "mm")]
Name = Annotated[str, text("a name")]
NOTHING = (0.0, 0.0, 0.0)


def _rising(rows: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    for position, (before, row) in enumerate(pairwise(rows), 1):
        if row[0] <= before[0] or row[1] < before[1]:
            raise refuse(f"row [{position}] must not lie below the row before it, and further on: both rise")
    return rows


Row = TypeVar("Row")
Rising = Annotated[
    tuple[Row, ...],
    Field(strict=False, min_length=2, description="a list of at least two rows, both rising; each {each}"),
    AfterValidator(_rising),
]
"""A table of rows [x, y] with rising x, y that does not fall."""
ForceOfTravel = Rising[Annotated[Two[float], Field(description="two numbers [travel mm, force kN]")]]
ForceOfVelocity = Rising[Annotated[Two[float], Field(description="two numbers [velocity m/s, force kN]")]]
Names = Annotated[
    tuple[Annotated[str, text("a name")], ...],
    Field(strict=False, min_length=1, description="the name of a body or wheelset, or a list of such names"),
    BeforeValidator(lambda value: value if isinstance(value, (list, tuple)) else (value,)),
]
Place = Three[Metre]
Stiffness = Three[Annotated[float, number(0, 1e7, "kN/m")]]
Damping = Three[Annotated[float, number(0, 1e5, "kN s/m")]]
Turning = Three[Annotated[float, number(0, 1e8, "kN m/rad")]]
TurningDamping = Three[Annotated[float, number(0, 1e6, "kN m s/rad")]]
Mirror = Annotated[List[Literal["x", "y"]], Field(description='a list of "x" (front to rear) and "y" (left to right)')]
Along = Literal["x", "y", "z"]


class BodyTable(Section):
    """[bodies.NAME]: a rigid body."""

    header: ClassVar[str] = "[bodies.NAME]"
    aliases: ClassVar[dict[str, str]] = {"center_mm": "centre_mm", "position_mm": "centre_mm"}

    mass_kg: Annotated[float, positive(1e6, "kg")]
    inertia_kg_m2: Three[Annotated[float, positive(1e9, "kg m2")]]
    centre_mm: Place

    def consistency(self) -> Iterator[Fault]:
        """No principal inertia of a solid is larger than the sum of the other two."""
        for i, name in enumerate("xyz"):
            others = sum(self.inertia_kg_m2) - self.inertia_kg_m2[i]
            if self.inertia_kg_m2[i] > others * (1.0 + 1e-9):
                yield Fault(
                    "inertia_kg_m2", f"the one about {name} is larger than the other two together: no solid has it"
                )


class MountTable(Section):
    """[wheelsets.NAME]: where a wheelset sits; what it is stands in [wheelset] or [wheelset_types.TYPE]."""

    header: ClassVar[str] = "[wheelsets.NAME]"

    x_mm: Metre
    type: Name | None = None


class ElementTable(Section):
    """What all elements have: a name, the body whose axes they follow, the one (or each of those) they lead to.

    origin: what the element's points are measured from: the part's origin, or the centre of one of the two bodies.
    both_sides: the element has a twin at -y.
    """

    header: ClassVar[str] = "[[elements]]"
    aliases: ClassVar[dict[str, str]] = {"type": "kind", "from": "body", "mirror": "both_sides", "from_mm": "body_mm"}
    POINTS: ClassVar[tuple[str, ...]] = ("at_mm",)
    """Keys that hold points."""

    kind: str
    name: Name
    body: Annotated[str, text("the name of a body")]
    to: Names
    origin: Literal["part", "body", "to"] = "part"
    both_sides: Switch = False


class SpringTable(ElementTable):
    """kind = "spring": springs and dampers along and about three axes at one point."""

    header: ClassVar[str] = "[[elements]] with kind = spring"

    kind: Literal["spring"]
    at_mm: Place
    stiffness_kN_per_m: Stiffness = NOTHING
    damping_kNs_per_m: Damping = NOTHING
    rotational_stiffness_kNm_per_rad: Turning = NOTHING
    rotational_damping_kNms_per_rad: TurningDamping = NOTHING
    preload_kN: Three[Annotated[float, number(-1e4, 1e4, "kN")]] | None = None


class ShearSpringTable(ElementTable):
    """kind = "shear-spring": a flexible column between two heights, with shear and bending stiffness."""

    header: ClassVar[str] = "[[elements]] with kind = shear-spring"
    POINTS: ClassVar[tuple[str, ...]] = ("body_mm", "to_mm")

    kind: Literal["shear-spring"]
    body_mm: Place
    to_mm: Place
    stiffness_kN_per_m: Stiffness
    bending_stiffness_kNm_per_rad: Annotated[float, number(0, 1e6, "kN m/rad, of either axis")] = 0.0
    torsional_stiffness_kNm_per_rad: Annotated[float, number(0, 1e6, "kN m/rad")] = 0.0
    damping_kNs_per_m: Damping = NOTHING

    def consistency(self) -> Iterator[Fault]:
        """Its axis is vertical."""
        if self.body_mm[:2] != self.to_mm[:2] or self.body_mm[2] == self.to_mm[2]:
            yield Fault("to_mm", "must lie straight above or below body_mm: the column stands upright")


class TabulatedSpringTable(ElementTable):
    """kind = "tabulated-spring": force against travel in one direction."""

    header: ClassVar[str] = "[[elements]] with kind = tabulated-spring"

    kind: Literal["tabulated-spring"]
    at_mm: Place
    direction: Along
    travel_mm_force_kN: ForceOfTravel
    damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0


class BumpStopTable(ElementTable):
    """kind = "bump-stop": a stop of a given travel; force against travel, the same in both directions or in one."""

    header: ClassVar[str] = "[[elements]] with kind = bump-stop"
    aliases: ClassVar[dict[str, str]] = {**ElementTable.aliases, "gap_mm_force_N": "travel_mm_force_kN"}

    kind: Literal["bump-stop"]
    at_mm: Place
    direction: Along
    travel_mm_force_kN: ForceOfTravel
    both_ways: Switch = True

    def consistency(self) -> Iterator[Fault]:
        """The table begins where the stop is met."""
        travel, force = self.travel_mm_force_kN[0]
        if travel < 0.0 or force != 0.0:
            yield Fault("travel_mm_force_kN", "must begin at a travel not below 0, with a force of 0")


class DamperTable(ElementTable):
    """kind = "damper": viscous, along an axis (at_mm, direction) or along its line (body_mm, to_mm)."""

    header: ClassVar[str] = "[[elements]] with kind = damper"
    POINTS: ClassVar[tuple[str, ...]] = ("at_mm", "body_mm", "to_mm")

    kind: Literal["damper"]
    at_mm: Place | None = None
    direction: Along | None = None
    body_mm: Place | None = None
    to_mm: Place | None = None
    damping_kNs_per_m: Annotated[float, positive(1e5, "kN s/m")] | None = None
    velocity_m_per_s_force_kN: ForceOfVelocity | None = None
    series_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")] | None = None

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Where it is in one of two ways, its law in one of two ways."""
        line = [key for key in ("body_mm", "to_mm") if key in raw]
        axis = [key for key in ("at_mm", "direction") if key in raw]
        if line and axis:
            yield Fault(line[0], f"cannot stand next to {' and '.join(axis)}: along a line or along an axis")
        elif len(line) == 1 or len(axis) == 1 or not (line or axis):
            yield Fault(
                "at_mm", "goes with direction (along an axis); or give body_mm and to_mm (a line)", missing=True
            )
        laws = [key for key in ("damping_kNs_per_m", "velocity_m_per_s_force_kN") if key in raw]
        if len(laws) != 1:
            yield Fault(
                "damping_kNs_per_m", "or velocity_m_per_s_force_kN must be given, one of them", missing=not laws
            )

    def consistency(self) -> Iterator[Fault]:
        """A table of a damper behind a spring is read backwards."""
        table = self.velocity_m_per_s_force_kN or ()
        flat = any(b[1] <= a[1] for a, b in pairwise(table))
        if self.series_stiffness_kN_per_m is not None and flat:
            yield Fault("velocity_m_per_s_force_kN", "must rise everywhere next to series_stiffness_kN_per_m")


class RodTable(ElementTable):
    """kind = "traction-rod": a spring and damper along the line between two points."""

    header: ClassVar[str] = "[[elements]] with kind = traction-rod"
    POINTS: ClassVar[tuple[str, ...]] = ("body_mm", "to_mm")

    kind: Literal["traction-rod"]
    body_mm: Place
    to_mm: Place
    stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0

    def consistency(self) -> Iterator[Fault]:
        """A rod has a length."""
        if self.body_mm == self.to_mm:
            yield Fault("to_mm", "is the same point as body_mm: a rod needs a length")


class AntiRollBarTable(ElementTable):
    """kind = "anti-roll-bar": a torsion spring between two bodies about the x axis."""

    header: ClassVar[str] = "[[elements]] with kind = anti-roll-bar"
    POINTS: ClassVar[tuple[str, ...]] = ()

    kind: Literal["anti-roll-bar"]
    stiffness_kNm_per_rad: Annotated[float, positive(1e6, "kN m/rad")]


Element = Annotated[
    SpringTable | ShearSpringTable | TabulatedSpringTable | BumpStopTable | DamperTable | RodTable | AntiRollBarTable,
    Field(discriminator="kind"),
]


class LoadTable(Section):
    """[[loads]]: a constant force on a body, along the track's axes."""

    header: ClassVar[str] = "[[loads]]"

    name: Name
    on: Annotated[str, text("the name of a body")]
    at_mm: Place
    force_kN: Three[Annotated[float, number(-1e4, 1e4, "kN")]]


class PointTable(Section):
    """[[points]]: a point of a body whose acceleration is kept in results."""

    header: ClassVar[str] = "[[points]]"

    name: Name
    on: Annotated[str, text("the name of a body")]
    at_mm: Place


class PlaceTable(Section):
    """[[places]]: a part put at a place of the vehicle, or of a larger part; perhaps mirrored."""

    header: ClassVar[str] = "[[places]]"

    part: Annotated[str, text("the name of a part, as in [parts.NAME]")]
    name: Name
    at_mm: Place
    mirror: Mirror = ()


class PartTable(Section):
    """[parts.NAME]: bodies, wheelsets and elements described once and placed as often as needed."""

    header: ClassVar[str] = "[parts.NAME]"

    bodies: dict[str, BodyTable] = Field(default_factory=dict)
    wheelsets: dict[str, MountTable] = Field(default_factory=dict)
    elements: List[Element] = ()
    loads: List[LoadTable] = ()
    points: List[PointTable] = ()
    places: List[PlaceTable] = ()
