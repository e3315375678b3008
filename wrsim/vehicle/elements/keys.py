"""Keys that the tables of a vehicle file share: places, and what every [[elements]] has."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, NamedTuple, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field

from wrsim.inputs.section import Choice
from wrsim.inputs.values import Switch, Three, Two, number, refuse, text
from wrsim.vehicle.elements.element import ZERO, Table, Triple

if TYPE_CHECKING:
    from wrsim.vehicle.elements.element import Element


def _rising(rows: Table) -> Table:
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

    origin: Triple = ZERO
    signs: Triple = (1.0, 1.0, 1.0)

    def point(self, point_mm: Triple) -> Triple:
        """A point of the part in the vehicle's axes [m]."""
        x, y, z = (o + s * p / 1000.0 for o, s, p in zip(self.origin, self.signs, point_mm, strict=True))
        return x, y, z

    def vector(self, values: Triple) -> Triple:
        """A vector of the part, in kilo-units, in the vehicle's axes and plain ones."""
        x, y, z = (1e3 * s * v for s, v in zip(self.signs, values, strict=True))
        return x, y, z


VEHICLE_AXES = Axes()


def scaled(values: Triple) -> Triple:
    """Values in kilo-units as plain ones."""
    x, y, z = values
    return 1e3 * x, 1e3 * y, 1e3 * z


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

    aliases: ClassVar[dict[str, str]] = {"kind": "type", "body": "from", "both_sides": "mirror", "body_mm": "from_mm"}
    glyph: ClassVar[Glyph | None] = None
    """How its kind is drawn; None: not at all."""

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
    both_sides: Switch = False
    """Whether the element has a twin at -y."""

    def points(self) -> Iterator[Triple]:
        """The points that are given [mm]."""
        for key in ("at_mm", "body_mm", "to_mm"):
            point = getattr(self, key, None)
            if point is not None:
                yield point

    def element(self, joint: Joint, axes: Axes) -> Element:
        """The element in SI units, its points in these axes."""
        raise NotImplementedError


class AxialTable(ElementTable):
    """An element that acts at a point along an axis of the body."""

    at_mm: Place
    """Point at which it acts."""
    direction: Along
    """Axis of the body along which it acts."""

    def placed(self, joint: Joint, axes: Axes) -> tuple[str, str, str, str, tuple[Triple, Triple], Literal[0, 1, 2]]:
        """What a `Strut` begins with: the joint, its ends, its axis."""
        at = axes.point(self.at_mm)
        return (*joint, (at, at), AXIS[self.direction])
