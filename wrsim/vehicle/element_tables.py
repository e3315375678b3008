"""The kinds of suspension elements that a vehicle file may name: keys, glyph in drawings, and law in SI units.

A new kind is a subclass of `ElementTable` and an entry in ``AnyElementTable``. Its ``element`` gives one of the laws of
``vehicle.elements`` (`Spring`: along and about three axes; `Strut`: in one direction), or an `Element` with a
function in ``dynamics.suspension``.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, TypeVar

import numpy as np
from pydantic import AfterValidator, BeforeValidator, Field

from wrsim.inputs.section import Choice, Fault, kinds_in
from wrsim.inputs.values import Three, Two, number, positive, refuse, text
from wrsim.vehicle import elements


def _rising(rows: elements.Table) -> elements.Table:
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
Metre = Annotated[float, number(-200_000, 200_000, "mm")]
Place = Three[Metre]
Stiffness = Three[Annotated[float, number(0, 1e7, "kN/m")]]
Damping = Three[Annotated[float, number(0, 1e5, "kN s/m")]]
Name = Annotated[str, text("a name")]
Names = Annotated[
    tuple[Annotated[str, text("a name")], ...],
    Field(strict=False, min_length=1, description="the name of a body or wheelset, or a list of such names"),
    BeforeValidator(lambda value: value if isinstance(value, (list, tuple)) else (value,)),
]
Along = Literal["x", "y", "z"]
AXIS: dict[Along, Literal[0, 1, 2]] = {"x": 0, "y": 1, "z": 2}


@dataclass(frozen=True)
class Axes:
    """Axes of a part in the vehicle's: origin [m], signs of x, y, z."""

    origin: elements.Triple = elements.ZERO
    signs: elements.Triple = (1.0, 1.0, 1.0)

    def point(self, point_mm: elements.Triple) -> elements.Triple:
        """A point of the part in the vehicle's axes [m]."""
        x, y, z = (o + s * p / 1000.0 for o, s, p in zip(self.origin, self.signs, point_mm, strict=True))
        return x, y, z

    def vector(self, values: elements.Triple) -> elements.Triple:
        """A vector of the part, in kilo-units, in the vehicle's axes and plain ones."""
        x, y, z = (1e3 * s * v for s, v in zip(self.signs, values, strict=True))
        return x, y, z


VEHICLE_AXES = Axes()


class Joint(NamedTuple):
    """What every element has, in the order of `Element`: its full name, its kind, the names of its two bodies."""

    name: str
    kind: str
    first: str
    second: str


class Glyph(NamedTuple):
    """How an element is drawn: matplotlib's mark, colour, and whether the mark is hollow."""

    mark: str
    colour: str
    hollow: bool = False


class ElementTable(Choice, header="[[elements]]"):
    """What all elements have: a name, the body whose axes they follow, the one (or each of those) they lead to."""

    glyph: ClassVar[Glyph | None] = None
    """Mark of its kind in drawings; None: not drawn."""

    kind: str
    """Kind of element."""
    name: Name
    """Name of the element; inside of parts it follows those of the places."""
    body: Annotated[str, text("the name of a body")]
    """Body whose axes the element follows."""
    to: Names
    """Body or bodies that it leads to; forces in results are those on it."""
    origin: Literal["part", "body", "to"] = "part"
    """What the points of the element are measured from: the part's origin or the centre of a body."""
    both_sides: bool = False
    """Whether the element has a twin at -y."""

    def __init_subclass__(cls, glyph: Glyph | None = None, **rest: Any) -> None:
        super().__init_subclass__(**rest)
        cls.glyph = glyph

    def points(self) -> Iterator[elements.Triple]:
        """The points that are given [mm]."""
        for key in ("at_mm", "body_mm", "to_mm"):
            point = getattr(self, key, None)
            if point is not None:
                yield point

    def element(self, joint: Joint, axes: Axes) -> elements.Element:
        """The element in SI units, its points in these axes."""
        raise NotImplementedError


class AxialTable(ElementTable):
    """An element that acts at a point along an axis of the body."""

    at_mm: Place
    """Point at which it acts."""
    direction: Along
    """Axis of the body along which it acts."""

    law: ClassVar[type[elements.Strut]] = elements.Strut

    def element(self, joint: Joint, axes: Axes) -> elements.Strut:
        point = axes.point(self.at_mm)
        more = self.more(axes.signs[AXIS[self.direction]])
        return self.to_si(self.law, **joint._asdict(), ends=(point, point), axis=AXIS[self.direction], **more)

    def more(self, sign: float) -> dict[str, Any]:
        """What its law has besides the keys of its own names; sign: of its direction in the vehicle's axes."""
        return {}


BLUE = "#0072B2"

SLOWEST, FASTEST, PER_DECADE = 1e-4, 3.0, 20
"""Velocities between which an orifice's force is tabulated [m/s], and how densely: within 0.2 % of the power law."""
FRICTION_PART = "friction_force_kN friction_travel_mm"
"""Keys that go together."""

ACROSS: dict[str, Literal[0, 1, 2]] = {"yz": 0, "xz": 1, "xy": 2}


class SpringTable(ElementTable, kind="spring", glyph=Glyph("o", BLUE, hollow=True)):
    """Springs and dampers along and about three axes at one point."""

    at_mm: Place
    """Point at which it acts."""
    stiffness_kN_per_m: Stiffness = elements.ZERO
    """Stiffness along the three axes."""
    damping_kNs_per_m: Damping = elements.ZERO
    """Damping along the three axes."""
    rotational_stiffness_kNm_per_rad: Three[Annotated[float, number(0, 1e8, "kN m/rad")]] = elements.ZERO
    """Stiffness about the three axes."""
    rotational_damping_kNms_per_rad: Three[Annotated[float, number(0, 1e6, "kN m s/rad")]] = elements.ZERO
    """Damping about the three axes."""
    preload_kN: Three[Annotated[float, number(-1e4, 1e4, "kN")]] | None = None
    """Force on the body at rest; solved for unless given."""

    def element(self, joint: Joint, axes: Axes) -> elements.Spring:
        return self.to_si(
            elements.Spring, **joint._asdict(), at=axes.point(self.at_mm),
            turning_stiffness=VEHICLE_AXES.vector(self.rotational_stiffness_kNm_per_rad),
            turning_damping=VEHICLE_AXES.vector(self.rotational_damping_kNms_per_rad),
            preload=None if self.preload_kN is None else axes.vector(self.preload_kN),
        )  # fmt: skip


class ShearSpringTable(ElementTable, kind="shear-spring", glyph=Glyph("D", BLUE, hollow=True)):
    """A flexible column between two heights, with shear and bending stiffness."""

    body_mm: Place
    """Its end on the body."""
    to_mm: Place
    """Its end on the body that it leads to."""
    stiffness_kN_per_m: Stiffness
    """Stiffness along the three axes; across the column it is the shear stiffness."""
    bending_stiffness_kNm_per_rad: Annotated[float, number(0, 1e6, "kN m/rad, of either axis")] = 0.0
    """Stiffness against bending, about either axis across the column."""
    torsional_stiffness_kNm_per_rad: Annotated[float, number(0, 1e6, "kN m/rad")] = 0.0
    """Stiffness against twisting about the column."""
    damping_kNs_per_m: Damping = elements.ZERO
    """Damping along the three axes."""

    def consistency(self) -> Iterator[Fault]:
        if self.body_mm[:2] != self.to_mm[:2] or self.body_mm[2] == self.to_mm[2]:
            yield Fault("to_mm", "must lie straight above or below body_mm: the column is vertical")

    def element(self, joint: Joint, axes: Axes) -> elements.Spring:
        x, y, z = (0.5 * (a + b) for a, b in zip(self.body_mm, self.to_mm, strict=True))
        bending, torsion = 1e3 * self.bending_stiffness_kNm_per_rad, 1e3 * self.torsional_stiffness_kNm_per_rad
        turning = (bending, bending, torsion)
        return self.to_si(
            elements.Spring, **joint._asdict(), at=axes.point((x, y, z)), turning_stiffness=turning, column=True
        )


class TabulatedSpringTable(AxialTable, kind="tabulated-spring", glyph=Glyph("h", BLUE, hollow=True)):
    """Force against travel in one direction."""

    travel_mm_force_kN: ForceOfTravel
    """Force over travel, row by row."""
    damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0
    """Damping along the same axis."""

    def more(self, sign: float) -> dict[str, Any]:
        return {"spring_table": along_axis(self.travel_mm_force_kN, sign)}


class BumpStopTable(AxialTable, kind="bump-stop", glyph=Glyph("X", "#B00020")):
    """A stop of a given travel; force against travel, the same in both directions or in one."""

    travel_mm_force_kN: ForceOfTravel
    """Force over travel, row by row; the free travel has no force."""
    both_ways: bool = True
    """Whether it stops both directions alike, or the positive one alone."""

    def consistency(self) -> Iterator[Fault]:
        travel, force = self.travel_mm_force_kN[0]
        if travel < 0.0 or force != 0.0:
            yield Fault("travel_mm_force_kN", "must begin at a travel not below 0, with a force of 0")

    def more(self, sign: float) -> dict[str, Any]:
        rows = self.travel_mm_force_kN
        free = ((rows[0][0] - 1.0, 0.0), *rows)  # nothing before the stop is met
        table = along_axis(both_ways(rows) if self.both_ways else free, sign)
        low, high = table[0][0], table[-1][0]
        if not self.both_ways:  # the other way it is free as far as anything goes
            low, high = (low, math.inf) if sign < 0.0 else (-math.inf, high)
        return {"spring_table": table, "limits": (low, high)}


class DamperTable(ElementTable, kind="damper", glyph=Glyph("s", "#D55E00")):
    """Viscous, along an axis (at_mm, direction) or along its line (body_mm, to_mm)."""

    one_of: ClassVar[tuple[str, ...]] = ("at_mm body_mm", "damping_kNs_per_m velocity_m_per_s_force_kN")
    at_most_one: ClassVar[tuple[str, ...]] = ("direction to_mm",)
    together: ClassVar[tuple[str, ...]] = ("at_mm direction", "body_mm to_mm")

    at_mm: Place | None = None
    """Point at which it acts along an axis."""
    direction: Along | None = None
    """Axis of the body along which it acts."""
    body_mm: Place | None = None
    """Its end on the body, where it acts along its own line."""
    to_mm: Place | None = None
    """Its end on the body that it leads to."""
    damping_kNs_per_m: Annotated[float, positive(1e5, "kN s/m")] | None = None
    """Force over velocity; or give a table."""
    velocity_m_per_s_force_kN: ForceOfVelocity | None = None
    """Force over velocity, row by row."""
    series_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")] | None = None
    """Stiffness of its mounting, in series with it; rigid unless given."""

    def consistency(self) -> Iterator[Fault]:
        if self.body_mm is not None and self.to_mm is not None and math.dist(self.body_mm, self.to_mm) < 1e-3:
            yield Fault("to_mm", "is the same point as body_mm: a damper along a line needs a length")
        table = self.velocity_m_per_s_force_kN or ()
        flat = any(b[1] <= a[1] for a, b in pairwise(table))
        if self.series_stiffness_kN_per_m is not None and flat:
            yield Fault("velocity_m_per_s_force_kN", "must rise everywhere next to series_stiffness_kN_per_m")

    def element(self, joint: Joint, axes: Axes) -> elements.Strut:
        points = [axes.point(point) for point in self.points()]  # one on an axis, two on a line
        rows = tuple((v, 1e3 * f) for v, f in self.velocity_m_per_s_force_kN or ())
        table = both_ways(rows) if rows and rows[0][0] >= 0.0 else rows
        axis = None if self.direction is None else AXIS[self.direction]
        return self.to_si(
            elements.Strut, **joint._asdict(), ends=(points[0], points[-1]), axis=axis, damper_table=table
        )


class TractionRodTable(ElementTable, kind="traction-rod", glyph=Glyph("_", "#222222")):
    """A spring and damper along the line between two points."""

    body_mm: Place
    """Its end on the body."""
    to_mm: Place
    """Its end on the body that it leads to."""
    stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Stiffness along its line."""
    damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0
    """Damping along its line."""
    clearance_mm: Annotated[float, number(0, 1000, "mm")] = 0.0
    """Play of its ends: how far its line shortens or grows without a force of its stiffness."""

    def consistency(self) -> Iterator[Fault]:
        if math.dist(self.body_mm, self.to_mm) < 1e-3:
            yield Fault("to_mm", "is the same point as body_mm: a rod needs a length")

    def element(self, joint: Joint, axes: Axes) -> elements.Strut:
        rod = self.to_si(elements.Strut, **joint._asdict(), ends=(axes.point(self.body_mm), axes.point(self.to_mm)))
        play = 1e-3 * self.clearance_mm
        table = both_ways(((play, 0.0), (play + 1.0, rod.stiffness)))
        return replace(rod, stiffness=0.0, spring_table=table) if play else rod


class AntiRollBarTable(ElementTable, kind="anti-roll-bar"):
    """A torsion spring between two bodies about the x axis."""

    stiffness_kNm_per_rad: Annotated[float, positive(1e6, "kN m/rad")]
    """Moment over the difference of the roll of both bodies."""

    def element(self, joint: Joint, axes: Axes) -> elements.Spring:
        return elements.Spring(
            *joint, axes.point(elements.ZERO), turning_stiffness=(1e3 * self.stiffness_kNm_per_rad, 0.0, 0.0)
        )


class FrictionTable(ElementTable, kind="friction", glyph=Glyph("D", "#CC79A7", hollow=True)):
    """Coulomb friction along an axis (direction) or in a plane (plane), behind a stiffness where it sticks."""

    one_of: ClassVar[tuple[str, ...]] = ("direction plane", "normal_force_kN normal_spring")
    goes_with: ClassVar[dict[str, str]] = {"normal_spring_axis": "normal_spring", "normal_factor": "normal_spring"}

    at_mm: Place
    """Point at which it acts."""
    direction: Along | None = None
    """Axis of the body along which it slides; or give the plane."""
    plane: Literal["xy", "xz", "yz"] | None = None
    """Plane of the body's axes in which it slides; the force is bounded by a circle."""
    friction: Annotated[float, positive(2, "")]
    """Coefficient of friction, sliding and sticking."""
    normal_force_kN: Annotated[float, positive(1e4, "kN")] | None = None
    """Constant normal force; or name a spring that gives it."""
    normal_spring: Annotated[str, text("the name of an element")] | None = None
    """Element whose force presses the surfaces together, by its name in the file."""
    normal_spring_axis: Along = "z"
    """Component of that force where the element is a spring with three."""
    normal_factor: Annotated[float, number(1e-3, 100)] = 1.0
    """Normal force over that force: of a Lenoir link the tangent of its angle to the vertical."""
    stick_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Stiffness where it sticks."""
    stick_damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0
    """Damping where it sticks."""

    def element(self, joint: Joint, axes: Axes) -> elements.Element:
        point = axes.point(self.at_mm)
        normal = None
        if self.normal_spring is not None:
            normal = elements.Normal(self.normal_spring, self.normal_factor, AXIS[self.normal_spring_axis])
        slider = elements.Slider(
            "coulomb", 1e3 * self.stick_stiffness_kN_per_m, 1e3 * self.friction * (self.normal_force_kN or 0.0),
            1e3 * self.stick_damping_kNs_per_m, self.friction, normal,
        )  # fmt: skip
        if self.plane is not None:
            return elements.PlaneFriction(*joint, point, ACROSS[self.plane], slider=slider)
        return elements.Strut(*joint, (point, point), AXIS[self.direction or "x"], slider=slider)


class LeafSpringTable(AxialTable, kind="leaf-spring", glyph=Glyph("v", BLUE, hollow=True)):
    """An elastic spring and the friction of its leaves, which builds up over a distance (Fancher)."""

    one_of: ClassVar[tuple[str, ...]] = ("friction_force_kN friction_share",)

    stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Stiffness of the middle line of its loop."""
    friction_force_kN: Annotated[float, positive(1e4, "kN")] | None = None
    """Half of the height of its loop; or give the share."""
    friction_share: Annotated[float, positive(1, "")] | None = None
    """The same over the force of its middle line: friction that follows the load."""
    friction_travel_mm: Annotated[float, positive(1000, "mm")]
    """Distance over which friction comes within 1/e of its limit after a return."""
    damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0
    """Damping along the same axis."""

    def more(self, sign: float) -> dict[str, Any]:
        distance, force = 1e-3 * self.friction_travel_mm, 1e3 * (self.friction_force_kN or 0.0)
        normal = None if self.friction_share is None else elements.Normal("")
        share = self.friction_share or 0.0
        return {"slider": elements.Slider("fancher", distance=distance, bound=force, friction=share, normal=normal)}


class RubberSpringTable(AxialTable, kind="rubber-spring", glyph=Glyph("H", BLUE)):
    """Rubber in one direction: stiffer at small strokes (friction) and at high frequencies (viscous part)."""

    together: ClassVar[tuple[str, ...]] = (FRICTION_PART, "series_stiffness_kN_per_m damping_kNs_per_m")

    stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Elastic part: stiffness of slow, large strokes."""
    friction_force_kN: Annotated[float, positive(1e4, "kN")] | None = None
    """Largest force of the friction part; goes with friction_travel_mm."""
    friction_travel_mm: Annotated[float, positive(1000, "mm")] | None = None
    """Travel from rest over which friction comes to half of its largest force (Berg's x2)."""
    series_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")] | None = None
    """Viscous part: what it adds to the stiffness at high frequencies, in series with its damping."""
    damping_kNs_per_m: Annotated[float, positive(1e5, "kN s/m")] | None = None
    """Viscous part: its damping; goes with series_stiffness_kN_per_m."""

    def more(self, sign: float) -> dict[str, Any]:
        return {"slider": friction_part(self.friction_force_kN, self.friction_travel_mm)}


class AirSpringTable(AxialTable, kind="air-spring", glyph=Glyph("8", BLUE)):
    """An air spring with its reservoir in one direction; the mass of the air in the pipe is left out."""

    together: ClassVar[tuple[str, ...]] = (FRICTION_PART, "series_stiffness_kN_per_m orifice_damping")

    stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Stiffness of slow strokes: bellows and reservoir together."""
    series_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")] | None = None
    """What fast strokes add to it, the pipe as good as closed; goes with orifice_damping."""
    orifice_damping: Annotated[float, positive(1e6, "kN (s/m)^n")] | None = None
    """Force of pipe or orifice at 1 m/s [kN]; goes with series_stiffness_kN_per_m."""
    orifice_exponent: Annotated[float, number(1, 2)] = 1.8
    """Exponent n of the velocity in that force."""
    friction_force_kN: Annotated[float, positive(1e4, "kN")] | None = None
    """Largest friction of the bellows; goes with friction_travel_mm."""
    friction_travel_mm: Annotated[float, positive(1000, "mm")] | None = None
    """Travel from rest over which friction comes to half of its largest force (Berg's x2)."""

    def more(self, sign: float) -> dict[str, Any]:
        force = self.orifice_damping
        table = () if force is None else orifice(1e3 * force, self.orifice_exponent)
        return {"damper_table": table, "slider": friction_part(self.friction_force_kN, self.friction_travel_mm)}


def friction_part(force_kN: float | None, travel_mm: float | None) -> elements.Slider | None:
    """Berg's friction, where it is given."""
    if force_kN is None or travel_mm is None:
        return None
    return elements.Slider("berg", bound=1e3 * force_kN, distance=1e-3 * travel_mm)


def orifice(force: float, exponent: float) -> elements.Table:
    """Rows (velocity [m/s], force [N]) of force |v|^exponent, both ways."""
    count = int(np.ceil(PER_DECADE * np.log10(FASTEST / SLOWEST)))
    velocities = np.geomspace(SLOWEST, FASTEST, count + 1)
    return both_ways(tuple((float(v), float(force * v**exponent)) for v in velocities))


class BilinearSpringTable(AxialTable, kind="bilinear-spring", glyph=Glyph("p", BLUE, hollow=True)):
    """A nest of springs that only pushes, the inner one touched from a certain load on: of freight wagons."""

    law = elements.BilinearSpring

    direction: Along = "z"
    """Axis of the body along which it acts."""
    stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Stiffness of the outer spring."""
    second_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Stiffness of the inner spring."""
    second_from_kN: Annotated[float, positive(1e4, "kN")]
    """Load from which on the inner spring carries as well."""
    damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0
    """Damping along the same axis."""


def both_ways(rows: elements.Table) -> elements.Table:
    """The odd continuation of a table that begins at or above 0."""
    positive = tuple(row for row in rows if row[0] > 0.0)
    middle: elements.Table = ((0.0, 0.0),)
    if rows[0][0] > 0.0 and rows[0][1] == 0.0:
        middle = ()  # free travel between the two stops
    return (*((-t, -f) for t, f in reversed(positive)), *middle, *positive)


def along_axis(rows: elements.Table, sign: float) -> elements.Table:
    """A table of force against travel, rows in mm and kN, along an axis that may be turned round; in SI units."""
    if sign < 0.0:
        return tuple((-t / 1e3, -1e3 * f) for t, f in reversed(rows))
    return tuple((t / 1e3, 1e3 * f) for t, f in rows)


AnyElementTable = Annotated[
    SpringTable
    | ShearSpringTable
    | TabulatedSpringTable
    | BumpStopTable
    | DamperTable
    | TractionRodTable
    | AntiRollBarTable
    | FrictionTable
    | LeafSpringTable
    | RubberSpringTable
    | AirSpringTable
    | BilinearSpringTable,
    Field(discriminator="kind"),
]
"""The kinds that a vehicle file may name, in the order of messages."""
KINDS: dict[str, type[ElementTable]] = kinds_in(AnyElementTable)
