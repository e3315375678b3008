"""Tables of a vehicle file: bodies, wheelsets, elements, parts and their places, in the user's units."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, ValidationError

from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import (
    Annotation,
    Choice,
    Numbers,
    Quantity,
    Switch,
    TableList,
    Text,
    as_float,
    faults_at,
    refuse,
)

Metre = Quantity(-200_000, 200_000, example="mm")
Name = Text("a name")
NOTHING = (0.0, 0.0, 0.0)


class Three(Annotation):
    """Three numbers along or about x (forward), y (left), z (up), each in a range."""

    def __init__(self, each: Quantity) -> None:
        self.each = each

    def words(self) -> str:
        return f"three numbers for x (forward), y (left), z (up), each {self.each.words()}"

    def check(self, value: Any) -> tuple[float, ...]:
        if not isinstance(value, (list, tuple)) or len(value) != 3:
            raise self.refusal()
        return Numbers(self.each).check(value)


class Names(Annotation):
    """A name, or a list of names; the check returns a tuple."""

    def __init__(self, meaning: str) -> None:
        self.meaning = meaning

    def words(self) -> str:
        return f"{self.meaning}, or a list of such names"

    def check(self, value: Any) -> tuple[str, ...]:
        names = value if isinstance(value, (list, tuple)) else (value,)
        if not names or not all(isinstance(n, str) and n.strip() for n in names):
            raise self.refusal()
        return tuple(names)


class Tables(Annotation):
    """A list of tables of one kind; the check returns a tuple of sections."""

    def __init__(self, section: type[Section]) -> None:
        self.section = section

    def words(self) -> str:
        return f"a list of tables ({self.section.header})"

    def check(self, value: Any) -> tuple[Section, ...]:
        if not isinstance(value, (list, tuple)):
            raise self.refusal()
        kept, faults = [], []
        for position, entry in enumerate(value):
            try:
                kept.append(self.section.model_validate(entry))
            except ValidationError as error:
                faults += faults_at((position,), error)
        if faults:
            raise ValidationError.from_exception_data("tables", faults)
        return tuple(kept)


class Axes(Annotation):
    """A list of the axes ``"x"`` and ``"y"`` that change their sign."""

    def words(self) -> str:
        return 'a list of "x" (front to rear) and "y" (left to right)'

    def check(self, value: Any) -> tuple[str, ...]:
        if not isinstance(value, (list, tuple)) or not set(map(str, value)) <= {"x", "y"}:
            raise self.refusal()
        return tuple(value)


class Pairs(Annotation):
    """A table of rows [x, y] with rising x, y that does not fall."""

    def __init__(self, columns: str) -> None:
        self.columns = columns

    def words(self) -> str:
        return f"a list of at least two rows [{self.columns}], both rising"

    def check(self, value: Any) -> tuple[tuple[float, float], ...]:
        if not isinstance(value, (list, tuple)) or len(value) < 2:
            raise self.refusal()
        rows = []
        for position, row in enumerate(value):
            numbers = [as_float(v) for v in row] if isinstance(row, (list, tuple)) else []
            if len(numbers) != 2 or None in numbers:
                raise refuse(f"row [{position}] must be two numbers [{self.columns}]")
            rows.append((float(numbers[0] or 0.0), float(numbers[1] or 0.0)))
        for position in range(1, len(rows)):
            if rows[position][0] <= rows[position - 1][0] or rows[position][1] < rows[position - 1][1]:
                raise refuse(f"row [{position}] must not lie below the row before it, and further on: both rise")
        return tuple(rows)


Place = Three(Metre)
Stiffness = Three(Quantity(0, 1e7, example="kN/m"))
Damping = Three(Quantity(0, 1e5, example="kN s/m"))
Turning = Three(Quantity(0, 1e8, example="kN m/rad"))
TurningDamping = Three(Quantity(0, 1e6, example="kN m s/rad"))
Along = Annotated[Literal["x", "y", "z"], Choice(("x", "y", "z"))]


class BodyTable(Section):
    """[bodies.NAME]: a rigid body."""

    header: ClassVar[str] = "[bodies.NAME]"
    aliases: ClassVar[dict[str, str]] = {"center_mm": "centre_mm", "position_mm": "centre_mm"}

    mass_kg: Annotated[float, Quantity(above=0, high=1e6, example="kg")]
    inertia_kg_m2: Annotated[tuple[float, float, float], Three(Quantity(above=0, high=1e9, example="kg m2"))]
    centre_mm: Annotated[tuple[float, float, float], Place]

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

    x_mm: Annotated[float, Metre]
    type: Annotated[str, Name] | None = None


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
    name: Annotated[str, Name]
    body: Annotated[str, Text("the name of a body")]
    to: Annotated[tuple[str, ...], Names("the name of a body or wheelset")]
    origin: Annotated[Literal["part", "body", "to"], Choice(("part", "body", "to"))] = "part"
    both_sides: Annotated[bool, Switch()] = False


class SpringTable(ElementTable):
    """kind = "spring": springs and dampers along and about three axes at one point."""

    header: ClassVar[str] = "[[elements]] with kind = spring"

    at_mm: Annotated[tuple[float, float, float], Place]
    stiffness_kN_per_m: Annotated[tuple[float, float, float], Stiffness] = NOTHING
    damping_kNs_per_m: Annotated[tuple[float, float, float], Damping] = NOTHING
    rotational_stiffness_kNm_per_rad: Annotated[tuple[float, float, float], Turning] = NOTHING
    rotational_damping_kNms_per_rad: Annotated[tuple[float, float, float], TurningDamping] = NOTHING
    preload_kN: Annotated[tuple[float, float, float], Three(Quantity(-1e4, 1e4, example="kN"))] | None = None


class ShearSpringTable(ElementTable):
    """kind = "shear-spring": a flexible column between two heights, with shear and bending stiffness."""

    header: ClassVar[str] = "[[elements]] with kind = shear-spring"
    POINTS: ClassVar[tuple[str, ...]] = ("body_mm", "to_mm")

    body_mm: Annotated[tuple[float, float, float], Place]
    to_mm: Annotated[tuple[float, float, float], Place]
    stiffness_kN_per_m: Annotated[tuple[float, float, float], Stiffness]
    bending_stiffness_kNm_per_rad: Annotated[float, Quantity(0, 1e6, example="kN m/rad, of either axis")] = 0.0
    torsional_stiffness_kNm_per_rad: Annotated[float, Quantity(0, 1e6, example="kN m/rad")] = 0.0
    damping_kNs_per_m: Annotated[tuple[float, float, float], Damping] = NOTHING

    def consistency(self) -> Iterator[Fault]:
        """Its axis is vertical."""
        if self.body_mm[:2] != self.to_mm[:2] or self.body_mm[2] == self.to_mm[2]:
            yield Fault("to_mm", "must lie straight above or below body_mm: the column stands upright")


class TabulatedSpringTable(ElementTable):
    """kind = "tabulated-spring": force against travel in one direction."""

    header: ClassVar[str] = "[[elements]] with kind = tabulated-spring"

    at_mm: Annotated[tuple[float, float, float], Place]
    direction: Along
    travel_mm_force_kN: Annotated[tuple[tuple[float, float], ...], Pairs("travel mm, force kN")]
    damping_kNs_per_m: Annotated[float, Quantity(0, 1e5, example="kN s/m")] = 0.0


class BumpStopTable(ElementTable):
    """kind = "bump-stop": a stop of a given travel; force against travel, the same in both directions or in one."""

    header: ClassVar[str] = "[[elements]] with kind = bump-stop"
    aliases: ClassVar[dict[str, str]] = {**ElementTable.aliases, "gap_mm_force_N": "travel_mm_force_kN"}

    at_mm: Annotated[tuple[float, float, float], Place]
    direction: Along
    travel_mm_force_kN: Annotated[tuple[tuple[float, float], ...], Pairs("travel mm, force kN")]
    both_ways: Annotated[bool, Switch()] = True

    def consistency(self) -> Iterator[Fault]:
        """The table begins where the stop is met."""
        travel, force = self.travel_mm_force_kN[0]
        if travel < 0.0 or force != 0.0:
            yield Fault("travel_mm_force_kN", "must begin at a travel not below 0, with a force of 0")


class DamperTable(ElementTable):
    """kind = "damper": viscous, along an axis (at_mm, direction) or along its line (body_mm, to_mm)."""

    header: ClassVar[str] = "[[elements]] with kind = damper"
    POINTS: ClassVar[tuple[str, ...]] = ("at_mm", "body_mm", "to_mm")

    at_mm: Annotated[tuple[float, float, float], Place] | None = None
    direction: Along | None = None
    body_mm: Annotated[tuple[float, float, float], Place] | None = None
    to_mm: Annotated[tuple[float, float, float], Place] | None = None
    damping_kNs_per_m: Annotated[float, Quantity(above=0, high=1e5, example="kN s/m")] | None = None
    velocity_m_per_s_force_kN: Annotated[tuple[tuple[float, float], ...], Pairs("velocity m/s, force kN")] | None = None
    series_stiffness_kN_per_m: Annotated[float, Quantity(above=0, high=1e7, example="kN/m")] | None = None

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

    body_mm: Annotated[tuple[float, float, float], Place]
    to_mm: Annotated[tuple[float, float, float], Place]
    stiffness_kN_per_m: Annotated[float, Quantity(above=0, high=1e7, example="kN/m")]
    damping_kNs_per_m: Annotated[float, Quantity(0, 1e5, example="kN s/m")] = 0.0

    def consistency(self) -> Iterator[Fault]:
        """A rod has a length."""
        if self.body_mm == self.to_mm:
            yield Fault("to_mm", "is the same point as body_mm: a rod needs a length")


class AntiRollBarTable(ElementTable):
    """kind = "anti-roll-bar": a torsion spring between two bodies about the x axis."""

    header: ClassVar[str] = "[[elements]] with kind = anti-roll-bar"
    POINTS: ClassVar[tuple[str, ...]] = ()

    stiffness_kNm_per_rad: Annotated[float, Quantity(above=0, high=1e6, example="kN m/rad")]


ELEMENTS: dict[str, type[ElementTable]] = {
    "spring": SpringTable,
    "shear-spring": ShearSpringTable,
    "tabulated-spring": TabulatedSpringTable,
    "bump-stop": BumpStopTable,
    "damper": DamperTable,
    "traction-rod": RodTable,
    "anti-roll-bar": AntiRollBarTable,
}


class LoadTable(Section):
    """[[loads]]: a constant force on a body, along the track's axes."""

    header: ClassVar[str] = "[[loads]]"

    name: Annotated[str, Name]
    on: Annotated[str, Text("the name of a body")]
    at_mm: Annotated[tuple[float, float, float], Place]
    force_kN: Annotated[tuple[float, float, float], Three(Quantity(-1e4, 1e4, example="kN"))]


class PointTable(Section):
    """[[points]]: a point of a body whose acceleration is kept in results."""

    header: ClassVar[str] = "[[points]]"

    name: Annotated[str, Name]
    on: Annotated[str, Text("the name of a body")]
    at_mm: Annotated[tuple[float, float, float], Place]


class PlaceTable(Section):
    """[[places]]: a part put at a place of the vehicle, or of a larger part; perhaps mirrored."""

    header: ClassVar[str] = "[[places]]"

    part: Annotated[str, Text("the name of a part, as in [parts.NAME]")]
    name: Annotated[str, Name]
    at_mm: Annotated[tuple[float, float, float], Place]
    mirror: Annotated[tuple[str, ...], Axes()] = ()


class PartTable(Section):
    """[parts.NAME]: bodies, wheelsets and elements described once and placed as often as needed."""

    header: ClassVar[str] = "[parts.NAME]"

    bodies: dict[str, BodyTable] = Field(default_factory=dict)
    wheelsets: dict[str, MountTable] = Field(default_factory=dict)
    elements: Annotated[tuple[Any, ...], TableList("kind", lambda: ELEMENTS, "[[elements]]")] = ()
    loads: Annotated[tuple[LoadTable, ...], Tables(LoadTable)] = ()
    points: Annotated[tuple[PointTable, ...], Tables(PointTable)] = ()
    places: Annotated[tuple[PlaceTable, ...], Tables(PlaceTable)] = ()
