"""Tables of a vehicle file: bodies, wheelsets, elements, parts and their places, in the user's units."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import List, Three, number, positive, text
from wrsim.vehicle.elements import AnyElementTable
from wrsim.vehicle.elements.keys import Metre, Name, Place
from wrsim.vehicle.load_tables import LoadTable, PayloadTable

Mirror = Annotated[List[Literal["x", "y"]], Field(description='a list of "x" (front to rear) and "y" (left to right)')]


class BodyTable(Section):
    """[bodies.NAME]: a rigid body."""

    header: ClassVar[str] = "[bodies.NAME]"
    aliases: ClassVar[dict[str, str]] = {"centre_mm": "center_mm position_mm"}

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


class AxleBoxTable(Section):
    """[axle_boxes.NAME]: the two bodies that turn freely about an axle at +-y, NAME left and NAME right."""

    header: ClassVar[str] = "[axle_boxes.NAME]"
    aliases: ClassVar[dict[str, str]] = {"wheelset": "on", "y_mm": "half_spacing_mm"}

    wheelset: Annotated[str, text("the name of a wheelset of the same part")]
    y_mm: Annotated[float, positive(2000, "mm from the middle of the axle")]
    mass_kg: Annotated[float, number(0, 10_000, "kg, of each, counted on the axle")]
    inertia_kg_m2: Three[Annotated[float, positive(1e5, "kg m2")]]


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
    axle_boxes: dict[str, AxleBoxTable] = Field(default_factory=dict)
    elements: List[AnyElementTable] = ()
    loads: List[LoadTable] = ()
    payloads: List[PayloadTable] = ()
    points: List[PointTable] = ()
    places: List[PlaceTable] = ()
