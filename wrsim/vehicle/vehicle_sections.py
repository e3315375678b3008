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
    """Mass of the body."""
    inertia_kg_m2: Three[Annotated[float, positive(1e9, "kg m2")]]
    """Principal moments of inertia about its centre."""
    centre_mm: Place
    """Its centre of mass in the design position, above the rails."""

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
    """Where its axle lies along the vehicle; positive is forward."""
    type: Name | None = None
    """Which of [wheelset_types] it is; that of [wheelset] unless given."""


class AxleBoxTable(Section):
    """[axle_boxes.NAME]: the two bodies that turn freely about an axle at +-y, NAME left and NAME right."""

    header: ClassVar[str] = "[axle_boxes.NAME]"
    aliases: ClassVar[dict[str, str]] = {"wheelset": "on", "y_mm": "half_spacing_mm"}

    wheelset: Annotated[str, text("the name of a wheelset of the same part")]
    """Wheelset that it sits on."""
    y_mm: Annotated[float, positive(2000, "mm from the middle of the axle")]
    """Distance of each box from the middle of the axle."""
    mass_kg: Annotated[float, number(0, 10_000, "kg, of each, counted on the axle")]
    """Mass of each box."""
    inertia_kg_m2: Three[Annotated[float, positive(1e5, "kg m2")]]
    """Moments of inertia of each box; that about y is of its own pitch."""


class DriveTable(Section):
    """[[drives]]: a motor that drives a wheelset through a gear and a hollow axle."""

    header: ClassVar[str] = "[[drives]]"
    aliases: ClassVar[dict[str, str]] = {
        "on": "wheelset axle",
        "case": "gear gearbox gear_case",
        "ratio": "gear_ratio i",
    }

    on: Annotated[str, text("the name of a wheelset of the same part")]
    """Wheelset that is driven."""
    motor: Annotated[str, text("the name of a body")]
    """Body that the motor's stator is part of: the motor itself, or the frame that it sits in."""
    case: Annotated[str, text("the name of a body")] | None = None
    """Body that the case of the gear is part of; that of the motor unless given."""
    ratio: Annotated[float, number(0.1, 50, "turns of the rotor for one of the axle")]
    """Gear ratio."""
    rotor_turns: Literal["backward", "forward"] = "backward"
    """Which way the rotor turns as the vehicle runs forward: one pair of gear wheels turns it against the axle."""
    rotor_inertia_kg_m2: Annotated[float, number(0, 1000, "kg m2")]
    """Inertia of the rotor about its own axis; not part of that of the motor about the lateral axis."""
    hollow_axle_inertia_kg_m2: Annotated[float, positive(1000, "kg m2")]
    """Inertia of hollow axle and large gear wheel about the axle; not part of that of wheelset or case."""
    stiffness_kNm_per_rad: Annotated[float, positive(1e6, "kN m/rad")]
    """Torsional stiffness of hollow axle and couplings, between gear and wheelset."""
    damping_kNms_per_rad: Annotated[float, number(0, 1e4, "kN m s/rad")] = 0.0
    """Torsional damping beside it."""


class PointTable(Section):
    """[[points]]: a point of a body whose acceleration is kept in results."""

    header: ClassVar[str] = "[[points]]"

    name: Name
    """Name of the point in results."""
    on: Annotated[str, text("the name of a body")]
    """Body that it belongs to."""
    at_mm: Place
    """Where it is."""


class PlaceTable(Section):
    """[[places]]: a part put at a place of the vehicle, or of a larger part; perhaps mirrored."""

    header: ClassVar[str] = "[[places]]"

    part: Annotated[str, text("the name of a part, as in [parts.NAME]")]
    """Which part."""
    name: Name
    """Name of the part at this place; names inside of it follow behind a dot."""
    at_mm: Place
    """Where its origin goes."""
    mirror: Mirror = ()
    """Whether it is turned round front to rear, left to right, or both."""


class PartTable(Section):
    """[parts.NAME]: bodies, wheelsets and elements described once and placed as often as needed."""

    header: ClassVar[str] = "[parts.NAME]"

    bodies: dict[str, BodyTable] = Field(default_factory=dict)
    """Rigid bodies, by their names."""
    wheelsets: dict[str, MountTable] = Field(default_factory=dict)
    """Wheelsets, by their names."""
    axle_boxes: dict[str, AxleBoxTable] = Field(default_factory=dict)
    """Pairs of axle boxes, by their names."""
    elements: List[AnyElementTable] = ()
    """Springs, dampers, stops and rods."""
    drives: List[DriveTable] = ()
    """Motors that drive wheelsets through gears and hollow axles."""
    loads: List[LoadTable] = ()
    """Forces that act on the vehicle: it moves under them."""
    payloads: List[PayloadTable] = ()
    """Masses and forces that the vehicle is trimmed with."""
    points: List[PointTable] = ()
    """Points at which accelerations are kept."""
    places: List[PlaceTable] = ()
    """Parts put at their places."""
