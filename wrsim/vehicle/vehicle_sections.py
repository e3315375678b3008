"""Tables of vehicle and train files: bodies, wheelsets, elements, parts and their places, in the user's units."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from wrsim.inputs.section import Fault, Section, both_or_sides, given
from wrsim.inputs.values import Day, List, RisingRows, Row, Source, Three, number, positive, requirement, text, within
from wrsim.vehicle.axle import AxleTable
from wrsim.vehicle.couplings import AnyCouplingTable
from wrsim.vehicle.element_tables import AnyElementTable, Axes, Metre, Name, Place
from wrsim.vehicle.elements import ZERO
from wrsim.vehicle.flexible import FlexibleTable
from wrsim.vehicle.loads import Load, LoadAxes, Over, Payload
from wrsim.vehicle.out_of_round import AnyOutOfRoundTable
from wrsim.vehicle.preload import Ballast
from wrsim.vehicle.wheelset import STANDARD_GRAVITY, Torsion

LEAST = 1e-3
"""Least mass [kg] and moment of inertia [kg m2] of a part: over those of a car body, 1e5 and 1e6, the root of the
accuracy of numbers, of which eigenvalues are left over."""
Radius = Annotated[float, number(100, 1500, "radius at the tape circle in mm, such as 460")]
WheelName = Annotated[str, text('a wheel profile file such as "wheels/S1002.toml"')]
Springs = Annotated[
    Three[Annotated[float, number(0, 1e9)]],
    Field(description="three numbers not below 0: along x (forward), y (lateral), z (vertical)"),
]


class ModelFile(Section, header="a vehicle file"):
    """Keys of all vehicle files."""

    name: Annotated[str, text("the vehicle's name")]
    """Name of the vehicle."""
    source: Source
    """Where the numbers come from."""
    date: Day
    """Day on which the file was written."""


class WheelsetTable(Section, header="[wheelset]"):
    """[wheelset]: the body and its two wheels, rigid, independent or on an axle that twists.

    Wheels that turn against each other have half of spin_inertia_kg_m2 each.
    """

    one_of: ClassVar[tuple[str, ...]] = ("profile_spacing_mm flange_back_mm",)
    goes_with: ClassVar[dict[str, str]] = {
        "torsional_damping_kNms_per_rad": "torsional_stiffness_kNm_per_rad",
        "back_to_tape_circle_mm": "flange_back_mm",
    }

    mass_kg: Annotated[float, number(LEAST, 20_000, "kg")]
    """Mass of the wheelset."""
    roll_inertia_kg_m2: Annotated[float, number(LEAST, 1e5, "about the x axis")]
    """Moment of inertia about the track's direction."""
    spin_inertia_kg_m2: Annotated[float, number(LEAST, 1e5, "about the axle")]
    """Moment of inertia about the axle."""
    yaw_inertia_kg_m2: Annotated[float, number(LEAST, 1e5, "about the z axis")]
    """Moment of inertia about the vertical; equal to that of roll."""
    profile_spacing_mm: Annotated[float, number(400, 2500, "mm between the tape circles")] | None = None
    """Distance between the tape circles, on which the wheel profiles have their origins."""
    flange_back_mm: Annotated[float, number(300, 2400, "mm between the flange backs")] | None = None
    """Distance between the flange backs, in place of profile_spacing_mm."""
    back_to_tape_circle_mm: Annotated[float, number(20, 120, "mm, 70 in Europe")] = 70.0
    """Distance of the tape circle from the flange back."""
    wheel: WheelName | None = None
    """Profile of both wheels."""
    wheel_left: WheelName | None = None
    """Profile of the left wheel."""
    wheel_right: WheelName | None = None
    """Profile of the right wheel."""
    radius_mm: Radius | None = None
    """Rolling radius of both wheels at the tape circle."""
    radius_left_mm: Radius | None = None
    """Rolling radius of the left wheel."""
    radius_right_mm: Radius | None = None
    """Rolling radius of the right wheel."""
    independent_wheels: bool = False
    """Whether each wheel turns on its own, with half of the spin inertia."""
    torsional_stiffness_kNm_per_rad: Annotated[float, positive(1e7, "between the wheels, some 5000")] | None = None
    """Stiffness of the axle between its two wheels in spin; rigid where it is not given."""
    torsional_damping_kNms_per_rad: Annotated[float, number(0, 1e5, "beside the stiffness")] | None = None
    """Damping of the axle between its two wheels in spin."""
    out_of_round: List[AnyOutOfRoundTable] = ()
    """How the wheels are out of round: polygons, flats, measured radii; what is given sums up."""
    axle: AxleTable | None = None
    """Shaft of an elastic axle; rigid where it is not given."""

    @classmethod
    def raw_faults(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        yield from both_or_sides(raw, "wheel", needed=requirement(WheelName))
        yield from both_or_sides(raw, "radius_mm", needed=requirement(Radius))
        if raw.get("independent_wheels") and "torsional_stiffness_kNm_per_rad" in raw:
            message = "cannot be given with independent_wheels = true, which have no axle between them"
            yield Fault("torsional_stiffness_kNm_per_rad", message)

    def consistency(self) -> Iterator[Fault]:
        for i, table in enumerate(self.out_of_round):
            if table.on:
                yield Fault(("out_of_round", i, "on"), "belongs in a scenario, [[vehicle.out_of_round]]")
        roll, spin, yaw = self.roll_inertia_kg_m2, self.spin_inertia_kg_m2, self.yaw_inertia_kg_m2
        if abs(roll - yaw) > 1e-6 * yaw:
            message = f"must equal yaw_inertia_kg_m2 = {yaw:g}, for a wheelset spins about its axle (take their mean)"
            yield Fault("roll_inertia_kg_m2", message)
        elif spin > 2.0 * yaw:
            message = f"must be at most twice yaw_inertia_kg_m2 = {yaw:g}: no solid has more"
            yield Fault("spin_inertia_kg_m2", message)

    @property
    def torsion(self) -> Torsion | None:
        """How the wheels turn against each other; None if they do not."""
        if self.independent_wheels:
            return Torsion()
        if self.torsional_stiffness_kNm_per_rad is None:
            if self.axle is None:
                return None
            inertia = 0.25 * self.spin_inertia_kg_m2
            stiffness = self.axle.axle().torsional_stiffness(0.5 * self.spacing)
            return Torsion(stiffness, 2.0 * self.axle.damping * (stiffness * inertia) ** 0.5)
        return Torsion(1e3 * self.torsional_stiffness_kNm_per_rad, 1e3 * (self.torsional_damping_kNms_per_rad or 0.0))

    @property
    def back(self) -> float | None:
        """Distance of the tape circle from the flange back that goes into the spacing [m]."""
        return None if self.flange_back_mm is None else self.back_to_tape_circle_mm / 1000.0

    @property
    def spacing(self) -> float:
        if self.flange_back_mm is not None:
            return (self.flange_back_mm + 2.0 * self.back_to_tape_circle_mm) / 1000.0
        return given(self.profile_spacing_mm) / 1000.0


class SuspensionTable(Section, header="[suspension]"):
    """[suspension]: springs and dampers of each side to the frame that follows the track."""

    stiffness_kN_per_m: Springs = (0.0, 0.0, 0.0)
    """Stiffness of each side along x, y, z."""
    damping_kNs_per_m: Springs = (0.0, 0.0, 0.0)
    """Damping of each side along x, y, z."""
    half_spacing_mm: Annotated[float, positive(2000, "mm from the middle")] = 1000.0
    """Distance of the springs from the middle of the axle."""
    ahead_of_bogie_centre_mm: Annotated[
        float, number(-5000, 5000, "mm, half the wheelbase for a leading axle, negative for a trailing one")
    ] = 0.0
    """How far the wheelset is ahead of its bogie's centre: the frame turns so much in curves."""


class SprungTable(Section, header="[sprung]"):
    """[sprung]: the share of the vehicle that this wheelset carries."""

    mass_kg: Annotated[float, number(0, 50_000, "kg")] = 0.0
    """Mass that presses on the axle without moving by itself."""
    height_above_axle_mm: Annotated[float, number(-1000, 5000, "mm of its centre above the axle")] = 0.0
    """Height of its centre, at which weight and centrifugal force act."""


Mirror = Annotated[List[Literal["x", "y"]], Field(description='a list of "x" (front to rear) and "y" (left to right)')]


class BodyTable(Section, header="[bodies.NAME]"):
    """[bodies.NAME]: a body, rigid or with elastic modes."""

    mass_kg: Annotated[float, number(LEAST, 1e6, "kg")]
    """Mass of the body."""
    inertia_kg_m2: Three[Annotated[float, number(LEAST, 1e9, "kg m2")]]
    """Principal moments of inertia about its centre."""
    centre_mm: Place
    """Its centre of mass in the design position, above the rails."""

    flexible: FlexibleTable | None = None
    """Its elastic modes; rigid where it is not given."""

    def consistency(self) -> Iterator[Fault]:
        for i, name in enumerate("xyz"):
            rest = sum(self.inertia_kg_m2) - self.inertia_kg_m2[i]
            if self.inertia_kg_m2[i] > rest * (1.0 + 1e-9):
                message = f"the one about {name} is larger than the other two together: no solid has it"
                yield Fault("inertia_kg_m2", message)


class MountTable(Section, header="[wheelsets.NAME]"):
    """[wheelsets.NAME]: where a wheelset sits; its properties are in [wheelset] or [wheelset_types.TYPE]."""

    x_mm: Metre
    """Where its axle lies along the vehicle; positive is forward."""
    type: Name | None = None
    """Which of [wheelset_types] it is; that of [wheelset] unless given."""


class AxleBoxTable(Section, header="[axle_boxes.NAME]"):
    """[axle_boxes.NAME]: the two bodies that turn freely about an axle at +-y, NAME left and NAME right."""

    wheelset: Annotated[str, text("the name of a wheelset of the same part")]
    """Wheelset that it sits on."""
    y_mm: Annotated[float, positive(2000, "mm from the middle of the axle")]
    """Distance of each box from the middle of the axle."""
    mass_kg: Annotated[float, number(0, 10_000, "kg, of each, counted on the axle")]
    """Mass of each box."""
    inertia_kg_m2: Three[Annotated[float, number(LEAST, 1e5, "kg m2")]]
    """Moments of inertia of each box; that about y is of its own pitch."""


class DriveTable(Section, header="[[drives]]"):
    """[[drives]]: a motor that drives a wheelset through a gear and a hollow axle."""

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


LARGEST = 1e4
"""Largest component of a force [kN]."""

_Four = Annotated[tuple[float, float, float, float], Field(strict=False)]
_Forces = Annotated[RisingRows[Row], within(-LARGEST, LARGEST, "kN")]
OverTime = _Forces[Annotated[_Four, Field(description="four numbers [time s, x kN, y kN, z kN]")]]
OverDistance = _Forces[Annotated[_Four, Field(description="four numbers [distance m, x kN, y kN, z kN]")]]
Force = Three[Annotated[float, number(-LARGEST, LARGEST, "kN")]]

NO_BALLAST = "is a wheelset, which spins: no mass is put on it; a force_kN may be"
NEEDS_AXES = (
    'must be "track" or "body", the axes that the force keeps to. A load acts beside the preload: the vehicle tilts '
    "under it on its springs. A force that the vehicle is trimmed with, as [[loads]] of older files, belongs in "
    "[[payloads]]"
)


class LoadTable(Section, header="[[loads]]"):
    """[[loads]]: a force at a point of a body, constant or over the time or the distance, at rest and in runs."""

    one_of: ClassVar[tuple[str, ...]] = ("force_kN time_s_force_kN distance_m_force_kN",)

    name: Name
    """Name of the load."""
    on: Annotated[str, text("the name of a body")]
    """Body on which it acts."""
    at_mm: Place
    """Point of the body at which it acts."""
    axes: LoadAxes | None = None
    """Axes that the force keeps to: those of the track, or of the body."""
    force_kN: Force | None = None
    """The force, where it is constant."""
    time_s_force_kN: OverTime | None = None
    """The force over the time of the run, row by row; linear between rows."""
    distance_m_force_kN: OverDistance | None = None
    """The force over the distance of its point along the track, row by row."""

    @classmethod
    def raw_faults(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        if "axes" not in raw:
            yield Fault("axes", NEEDS_AXES, missing=True)

    def load(self, name: str, body: str, axes: Axes) -> Load:
        """The load in SI units, of this name on this body; axes: of the part that it belongs to."""
        over: Over = "time" if self.distance_m_force_kN is None else "distance"
        rows = self.time_s_force_kN or self.distance_m_force_kN or ((0.0, *(self.force_kN or ZERO)),)
        table = tuple((x, *axes.vector((fx, fy, fz))) for x, fx, fy, fz in rows)
        return Load(name, body, axes.point(self.at_mm), table, over, self.axes or "track")


class PayloadTable(Section, header="[[payloads]]"):
    """[[payloads]]: a mass that is part of a body, or a constant force, with which the vehicle is trimmed."""

    one_of: ClassVar[tuple[str, ...]] = ("mass_kg force_kN",)
    goes_with: ClassVar[dict[str, str]] = {"inertia_kg_m2": "mass_kg"}

    name: Name
    """Name of the payload."""
    on: Annotated[str, text("the name of a body")]
    """Body that it is part of."""
    at_mm: Place
    """Its centre."""
    mass_kg: Annotated[float, positive(1e6, "kg")] | None = None
    """Its mass."""
    inertia_kg_m2: Three[Annotated[float, number(0, 1e9, "kg m2")]] | None = None
    """Moments of inertia about its own centre; none unless given."""
    force_kN: Force | None = None
    """A force in place of a mass, along the axes of the track at rest."""

    def payload(self, name: str, body: str, axes: Axes) -> Payload | Ballast:
        """The payload in SI units, of this name on this body; axes: of the part that it belongs to."""
        point = axes.point(self.at_mm)
        if self.mass_kg is None:
            return Payload(name, body, axes.vector(self.force_kN or ZERO), point)
        return Ballast(body, self.mass_kg, point, self.inertia_kg_m2 or ZERO)


class PointTable(Section, header="[[points]]"):
    """[[points]]: a point of a body whose acceleration is among the results."""

    name: Name
    """Name of the point in results."""
    on: Annotated[str, text("the name of a body")]
    """Body that it belongs to."""
    at_mm: Place
    """Where it is."""


class PlaceTable(Section, header="[[places]]"):
    """[[places]]: a part put at a place of the vehicle, or of a larger part; perhaps mirrored."""

    part: Annotated[str, text("the name of a part, as in [parts.NAME]")]
    """Which part."""
    name: Name
    """Name of the part at this place; names inside of it follow behind a dot."""
    at_mm: Place
    """Where its origin goes."""
    mirror: Mirror = ()
    """Whether it is turned round front to rear, left to right, or both."""


class PartTable(Section, header="[parts.NAME]"):
    """[parts.NAME]: bodies, wheelsets and elements described once and placed as often as needed."""

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
    """Points at which accelerations are recorded."""
    places: List[PlaceTable] = ()
    """Parts put at their places."""


class WheelsetFile(ModelFile):
    """The file of a single wheelset."""

    wheelset: WheelsetTable
    """The rigid body and its wheels."""
    suspension: SuspensionTable = SuspensionTable()
    """Springs and dampers to the frame that follows the track."""
    sprung: SprungTable = SprungTable()
    """The share of the vehicle that the wheelset carries."""


class VehicleFile(ModelFile, PartTable):
    """The file of a vehicle of parts: the outermost one, and what the parts share."""

    gravity_m_per_s2: Annotated[float, number(9, 10)] = STANDARD_GRAVITY
    """Gravity with which the source has its loads from."""
    wheelset: WheelsetTable | None = None
    """The wheelset of all mounts that name no type."""
    wheelset_types: dict[str, WheelsetTable] = Field(default_factory=dict)
    """Other wheelsets, by the names of their types."""
    parts: dict[str, PartTable] = Field(default_factory=dict)
    """Parts that are described once and placed as often as needed."""


class MemberTable(Section, header="[[vehicles]]"):
    """[[vehicles]]: a vehicle of a train, or several alike, one behind the other: in full, or along the track alone."""

    one_of: ClassVar[tuple[str, ...]] = ("model mass_t",)
    together: ClassVar[tuple[str, ...]] = ("mass_t pivot_spacing_mm",)
    goes_with: ClassVar[dict[str, str]] = {
        "middle_mm": "model", "body": "model", "reversed": "model", "resistance_N": "mass_t",
        "curve_resistance_m": "mass_t",
    }  # fmt: skip

    model: Annotated[str, text('a vehicle file such as "vehicles/manchester_1.toml"')] | None = None
    """File of the vehicle, which is modelled in full."""
    mass_t: Annotated[float, positive(1000, "t")] | None = None
    """Mass of a vehicle that moves along the track alone, with one degree of freedom, in place of a file."""
    pivot_spacing_mm: Annotated[float, positive(100_000, "mm between the pivots of its bogies")] | None = None
    """Distance of its pivots, which stay on the centre line; its ends swing with them."""
    resistance_N: (
        Annotated[Three[Annotated[float, number(0, 1e6)]], Field(description="three numbers a, b, c not below 0")]
        | None
    ) = None
    """Running resistance a + b V + c V2 in N, V in km/h; none unless given."""
    curve_resistance_m: Annotated[float, number(0, 10, "m, some 0.7")] | None = None
    """k of the curve resistance, weight times k over the radius; none unless given."""
    brake_force_kN: Annotated[float, positive(1e4, "kN at the rails")] | None = None
    """Largest force of its brakes; goes with [brakes] of the train, and none unless given."""
    name: Name
    """Its name; names of its bodies follow behind a dot, and several alike are numbered: coach1, coach2."""
    count: Annotated[int, number(1, 1000)] = 1
    """How many of them run one behind the other."""
    length_mm: Annotated[float, positive(200_000, "mm over buffers or couplers, as coupled")]
    """Its length between the planes in which it meets its neighbours."""
    middle_mm: Annotated[float, number(-100_000, 100_000, "mm, positive forward")] = 0.0
    """Where the middle of that length lies, from the origin of its file."""
    body: Name | None = None
    """Body that its couplings hold on to; the heaviest unless given."""
    reversed: bool = False
    """Whether it runs the other way round."""
    driven: bool | None = None
    """Whether a drive of its own holds its speed; if not, its couplings alone take it along. Unless given a vehicle in
    full is driven, and one along the track alone is not."""

    @property
    def names(self) -> list[str]:
        return [self.name] if self.count == 1 else [f"{self.name}{k + 1}" for k in range(self.count)]


class BrakesTable(Section, header="[brakes]"):
    """[brakes]: how the brakes of a train follow a command from the middle of its first vehicle."""

    propagation_m_per_s: Annotated[float, positive(2000, "m/s, some 250 to 280")]
    """Speed at which a command runs along the brake pipe."""
    filling_s: Annotated[float, positive(100, "s")]
    """Time constant with which the force of a vehicle goes to its new value, up and down."""


class TrainFile(ModelFile, header="a train file"):
    """The file of a train: vehicles from front to rear, and what couples them."""

    name: Annotated[str, text("the train's name")]
    """Name of the train."""
    vehicles: Annotated[List[MemberTable], Field(min_length=1)]
    """Its vehicles, from front to rear."""
    couplings: Annotated[List[AnyCouplingTable], Field(min_length=1)]
    """One for all gaps between them, or one for each gap from front to rear."""
    brakes: BrakesTable | None = None
    """Brake pipe; a train without one does not brake by itself."""
