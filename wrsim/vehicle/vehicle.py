"""A vehicle or a train: bodies, wheelsets, suspension, loads. Plain data, SI units, in the vehicle's axes.

The origin is at the height of the rails, anywhere along the vehicle; x forward, y left, z up. All places are those of
the design position: the vehicle at rest on level track. A train is a `Vehicle` with the bodies, wheelsets and elements
of all its vehicles, from front to rear, and the elements of the couplings; its origin is that of its first vehicle.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from wrsim.inputs.notebook import card
from wrsim.vehicle.axle import AxleModes, Disc
from wrsim.vehicle.elements import GUIDE, TRACK, ZERO, Array, Element, Spring, Triple
from wrsim.vehicle.flexible import Modes
from wrsim.vehicle.loads import CarriedMass, Drive, Effort, GearedMotor, Load, Payload, SlipControl
from wrsim.vehicle.wheelset import STANDARD_GRAVITY, Wheelset


@dataclass(frozen=True)
class Member:
    """A vehicle of a train: its name, numbers of its wheelsets and bodies, whether a drive of its own holds its speed
    (if not, its couplings alone pull it), largest force of its brakes [N], and the delay of a command to them [s].
    wagon: one that moves along the track alone, without wheelsets and bodies."""

    name: str
    wheelsets: int
    bodies: int
    driven: bool = True
    brake: float = 0.0
    delay: float = 0.0
    wagon: Wagon | None = None


@dataclass(frozen=True)
class Wagon:
    """A vehicle that moves along the track alone (``dynamics.wagons``): mass [kg], place x of its middle, distance of
    its pivots [m]; resistance a + b v + c v^2 (a, b, c) [N, N s/m, N s2/m2], in a curve m g k / R more, k [m]."""

    name: str
    mass: float
    x: float
    pivots: float
    resistance: Triple = ZERO
    curve_resistance: float = 0.0


@dataclass(frozen=True)
class BrakePipe:
    """How brakes of a train follow a command: it runs along the pipe at a speed [m/s], and where it arrives the force
    goes to its new value with a time constant [s]. steps: rows (time [s], share of the largest force)."""

    propagation: float
    filling: float
    steps: tuple[tuple[float, float], ...] = ()

    @property
    def changes(self) -> tuple[tuple[float, float], ...]:
        """Rows (time [s], change of the share)."""
        before = (0.0, *(share for _, share in self.steps))
        return tuple((t, share - last) for (t, share), last in zip(self.steps, before, strict=False))

    def share(self, times: Array) -> Array:
        """Share of the largest force at times (n,) [s] less the delay of the vehicle."""
        since = [np.maximum(times - t, 0.0) for t, _ in self.changes]
        return sum(
            (c * -np.expm1(-s / self.filling) for s, (_, c) in zip(since, self.changes, strict=True)), 0.0 * times
        )


@dataclass(frozen=True)
class Coupling:
    """What joins two neighbours: the bodies ahead and behind, the middle of the gap in the design position [m], and the
    names of its elements."""

    name: str
    ahead: str
    behind: str
    at: Triple
    elements: tuple[str, ...]


@dataclass(frozen=True)
class Unit:
    """A vehicle of a train, or one on its own: places of its wheelsets and bodies in the state, its reference part,
    whether it is driven, and the mass that its drive moves, without and with the inertia of what turns [kg]; x: of
    its reference part in the design position [m]. One that moves along the track alone has no parts."""

    wheelsets: range
    bodies: range
    reference: int
    driven: bool
    pulled_mass: float
    pulled_inertia: float
    x: float

    @property
    def parts(self) -> tuple[int, ...]:
        return (*self.wheelsets, *self.bodies)


@dataclass(frozen=True)
class Body:
    """A body: mass [kg], principal inertia about x, y, z [kg m2], centre of mass [m]; elastic modes, None: rigid;
    payload: what of its mass it carries [kg]."""

    name: str
    mass: float
    inertia: Triple
    centre: Triple
    modes: Modes | None = None
    payload: float = 0.0

    @property
    def box(self) -> Triple:
        """Edges of the box that has its mass and inertia [m], for drawings; never thinner than 0.1 m."""
        total = sum(self.inertia)
        x, y, z = (max(6.0 * (total - 2.0 * i) / self.mass, 0.01) ** 0.5 for i in self.inertia)
        return (x, y, z)


@dataclass(frozen=True)
class AxleBox:
    """A body that turns freely about the axle of its wheelset, its centre on the axle at y [m]: the arm of a primary
    suspension. Mass [kg], inertia about x, y (the axle), z [kg m2]. See ``dynamics.rigid_body``."""

    name: str
    y: float
    mass: float
    inertia: Triple


@dataclass(frozen=True)
class MountedWheelset:
    """A wheelset at its place x [m] along the vehicle, its axle ``height`` [m] above the rails, and its axle boxes.

    With smaller wheels than those of the file the whole vehicle is lower; the design position stays.
    """

    name: str
    wheelset: Wheelset
    x: float
    height: float
    boxes: tuple[AxleBox, ...] = ()

    @property
    def centre(self) -> Triple:
        return (self.x, 0.0, self.height)

    @property
    def mass(self) -> float:
        """Mass with that of the axle boxes [kg]."""
        return self.wheelset.mass + sum(box.mass for box in self.boxes)

    @property
    def inertia(self) -> Triple:
        """Inertia about x, y, z through the centre [kg m2]; of the axle boxes without that about the axle."""
        roll, spin, yaw = self.wheelset.inertia
        across = sum(box.mass * box.y**2 + 0.5 * (box.inertia[0] + box.inertia[2]) for box in self.boxes)
        return (roll + across, spin, yaw + across)

    @cached_property
    def modes(self) -> AxleModes | None:
        """Bending modes of its elastic axle with its axle boxes; None: rigid."""
        wheelset, axle, half = self.wheelset, self.wheelset.axle, 0.5 * self.wheelset.profile_spacing
        if axle is None:
            return None
        boxes = [Disc(box.y, box.mass, 0.0, 0.5 * (box.inertia[0] + box.inertia[2])) for box in self.boxes]
        wheels = axle.wheels(wheelset.mass, wheelset.inertia[1], wheelset.inertia[0], half)
        return axle.modes((*wheels, *boxes))


@dataclass(frozen=True)
class MeasuringPoint:
    """A point [m] of a body whose motion is among the results."""

    name: str
    body: str
    at: Triple


@dataclass(frozen=True)
class Vehicle:
    """A vehicle. The wheelsets come first in the state, from front to rear as in the file, then the bodies.

    carried: masses that press on bodies without moving by themselves. guide_ahead: where the wheelset that the guide
    frame holds sits in its bogie, ahead of the centre [m]: in a curve of curvature kappa the frame is turned by
    -guide_ahead kappa. drive: what holds the speed unless a scenario gives another. gravity: acceleration [m/s2].
    efforts, slip_control: of motors and brakes, in runs; drives: motors with gears, which these go through.
    members, couplings: of a train, from front to rear; its bodies and elements are those of all of its vehicles; chain:
    elements between two vehicles that move along the track alone; brakes: how its brakes follow a command.
    """

    name: str
    wheelsets: tuple[MountedWheelset, ...]
    bodies: tuple[Body, ...]
    elements: tuple[Element, ...]
    loads: tuple[Load, ...] = ()
    payloads: tuple[Payload, ...] = ()
    points: tuple[MeasuringPoint, ...] = ()
    source: str = ""
    carried: tuple[CarriedMass, ...] = ()
    guide_ahead: float = 0.0
    drive: Drive = "train"
    gravity: float = STANDARD_GRAVITY
    efforts: tuple[Effort, ...] = ()
    slip_control: SlipControl | None = None
    drives: tuple[GearedMotor, ...] = ()
    members: tuple[Member, ...] = ()
    couplings: tuple[Coupling, ...] = ()
    chain: tuple[Element, ...] = ()
    brakes: BrakePipe | None = None

    def __repr__(self) -> str:
        counted = f"{len(self.wheelsets)} wheelsets, {len(self.bodies)} bodies, {len(self.elements)} elements"
        return f"Vehicle({self.name!r}, {counted}, {self.mass / 1e3:.4g} t)"

    def _repr_html_(self) -> str:
        rows = [
            (part.name, f"{part.mass:.5g} kg, centre at x {part.centre[0]:.4g}, z {part.centre[2]:.4g} m")
            for part in self.parts
        ]
        kinds = [type(element).__name__ for element in self.elements]
        counted = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
        whole = (("mass", f"{self.mass / 1e3:.4g} t"), ("elements", counted or "none"), ("file", self.source or "none"))
        return card(self.name, (*rows, *whole))

    @property
    def parts(self) -> tuple[MountedWheelset | Body, ...]:
        """Everything with mass, in the order of the state."""
        return (*self.wheelsets, *self.bodies)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the parts."""
        return tuple(part.name for part in self.parts)

    def index(self, name: str) -> int:
        """Place of a part in the state; behind the last one come the track frame, the guide frame, the axle boxes, and
        vehicles that move along the track alone."""
        return (*self.names, TRACK, GUIDE, *self.boxes, *self.wagons).index(name)

    @property
    def foremost(self) -> float:
        """Place of the first wheelset, or of the middle of a vehicle along the track alone ahead of it [m]."""
        return max([*(mounted.x for mounted in self.wheelsets), *(wagon.x for wagon in self.wagons.values())])

    @property
    def assumptions(self) -> str:
        """What is assumed of the vehicles of a train that move along the track alone, in a line; else nothing."""
        wagons, pipe = self.wagons.values(), self.brakes
        if not wagons:
            return ""
        mass = sum(wagon.mass for wagon in wagons) / 1e3
        resistances = any(any(wagon.resistance) for wagon in wagons), any(wagon.curve_resistance for wagon in wagons)
        running, curve = ("given" if each else "none" for each in resistances)
        brakes = "none" if pipe is None else f"command at {pipe.propagation:g} m/s, time constant {pipe.filling:g} s"
        along = f"{len(wagons)} of {len(self.members)} vehicles along the track alone, {mass:.6g} t"
        return f"{along}; running resistance {running}, curve resistance {curve}; brakes {brakes}"

    @cached_property
    def wagons(self) -> dict[str, Wagon]:
        """The vehicles of a train that move along the track alone, by their names, from front to rear."""
        return {member.name: member.wagon for member in self.members if member.wagon is not None}

    @cached_property
    def boxes(self) -> dict[str, tuple[int, AxleBox]]:
        """Axle boxes by their names, each with the number of its wheelset, in the order of the state."""
        return {box.name: (w, box) for w, mounted in enumerate(self.wheelsets) for box in mounted.boxes}

    def carrier(self, name: str) -> str:
        """The wheelset on which an axle box sits; any other name as it is."""
        return self.wheelsets[self.boxes[name][0]].name if name in self.boxes else name

    def place(self, name: str) -> Triple:
        """Origin of the axes of a part, a frame or an axle box in the design position [m]."""
        if name in self.boxes:
            w, box = self.boxes[name]
            return (self.wheelsets[w].x, box.y, self.wheelsets[w].height)
        if name in self.wagons:
            return (self.wagons[name].x, 0.0, 0.0)
        return ZERO if name in (TRACK, GUIDE) else self.parts[self.index(name)].centre

    @property
    def mass(self) -> float:
        """Mass of all parts [kg], without what is carried."""
        return sum(part.mass for part in self.parts)

    @property
    def weight(self) -> float:
        """Force of all wheels on level rails at rest without loads [N], if no spring to a frame carries a share."""
        mass = self.mass + sum(load.mass for load in self.carried)
        return mass * self.gravity - sum(payload.force[2] for payload in self.payloads)

    @property
    def centre(self) -> Array:
        """Centre of mass (3,) [m]."""
        return np.average([part.centre for part in self.parts], axis=0, weights=[part.mass for part in self.parts])

    @property
    def reference(self) -> int:
        """Place of the reference part of the (first) vehicle: its heaviest body, or its first wheelset; its distance is
        that of the vehicle."""
        return self.pulled[0].reference

    @property
    def pulled(self) -> tuple[Unit, ...]:
        """The vehicles that a drive may pull: those in full, then those along the track alone that are driven."""
        full = tuple(unit for unit in self.units if unit.parts)
        return (*full, *(unit for unit in self.units if unit.driven and not unit.parts))

    @cached_property
    def units(self) -> tuple[Unit, ...]:
        """The vehicles of a train, from front to rear, else this one; driven ones share the masses of the others."""
        masses, turning = [part.mass for part in self.parts], self._turning
        first, body, wagons = 0, len(turning), self.index(GUIDE) + 1 + len(self.boxes)
        units: list[Unit] = []
        for member in self.members or (Member(self.name, len(self.wheelsets), len(self.bodies)),):
            if (wagon := member.wagon) is not None:
                units.append(Unit(range(0), range(0), wagons, member.driven, wagon.mass, wagon.mass, wagon.x))
                wagons += 1
                continue
            wheelsets, bodies = range(first, first + member.wheelsets), range(body, body + member.bodies)
            reference = max(bodies, key=masses.__getitem__, default=first)
            mass = sum(masses[i] for i in (*wheelsets, *bodies))
            moved = mass + sum(turning[i] for i in wheelsets)
            x = self.parts[reference].centre[0]
            units.append(Unit(wheelsets, bodies, reference, member.driven, mass, moved, x))
            first, body = wheelsets.stop, bodies.stop
        driven = [unit for unit in units if unit.driven]
        if len(driven) == len(units) or not driven:
            return tuple(units)
        share = sum(unit.pulled_mass for unit in units) / sum(unit.pulled_mass for unit in driven)
        inertia = sum(unit.pulled_inertia for unit in units) / sum(unit.pulled_inertia for unit in driven)
        return tuple(
            replace(unit, pulled_mass=share * unit.pulled_mass, pulled_inertia=inertia * unit.pulled_inertia)
            for unit in units
        )

    @property
    def runs_with_frame(self) -> bool:
        """True if springs or dampers to a frame of constant speed hold it along the track."""
        to_frame = (e for e in self.elements if isinstance(e, Spring) and e.first in (TRACK, GUIDE))
        return any(e.stiffness[0] > 0.0 or e.damping[0] > 0.0 for e in to_frame)

    @property
    def centre_of_load(self) -> Array:
        """Centre of all parts and of what they carry (3,) [m]: where weight and centrifugal force act."""
        places = [part.centre for part in self.parts]
        for carried in self.carried:
            x, y, z = places[self.index(carried.body)]
            places.append((x, y, z + carried.height))
        return np.average(places, axis=0, weights=[load.mass for load in (*self.parts, *self.carried)])

    def loaded_as(self, force: Callable[[Load], Triple]) -> Vehicle:
        """The vehicle with constant loads in the place of its own; force: of each of them, along its axes [N]."""
        held = (Load.constant(each.name, each.body, force(each), each.at, each.axes) for each in self.loads)
        return replace(self, loads=tuple(held))

    @property
    def braked_wheelsets(self) -> list[Effort]:
        """The brakes of the vehicles in full as moments, alike on the wheelsets of each. The exponential lag has ten
        rows a time constant: lines between them are within 1/8 (1/10)^2, 0.13 % of the largest force."""
        efforts: list[Effort] = []
        pipe = self.brakes
        for member, unit in zip(self.members, self.units, strict=True):
            if pipe is None or member.brake == 0.0 or not pipe.steps:
                continue
            behind = np.concatenate([t + pipe.filling * np.arange(0.0, 10.05, 0.1) for t, _ in pipe.steps])
            shares = pipe.share(times := np.unique(behind))
            for wheelset in (self.wheelsets[i] for i in unit.wheelsets):
                largest = member.brake * wheelset.wheelset.mean_radius / len(unit.wheelsets)
                rows = zip((times + member.delay).tolist(), (-largest * shares).tolist(), strict=True)
                efforts.append(Effort(wheelset.name, tuple(rows)))
        return efforts

    @property
    def moved_mass(self) -> float:
        """Mass with that of what turns, its inertia over the square of the radius [kg]."""
        return self.mass + sum(self._turning) + sum(wagon.mass for wagon in self.wagons.values())

    @property
    def _turning(self) -> list[float]:
        """Inertia about the axle of every wheelset, with that of its geared motor, over its radius squared [kg]."""
        geared = {drive.wheelset: drive.inertia for drive in self.drives}
        radii = [mounted.wheelset.mean_radius for mounted in self.wheelsets]
        return [(m.inertia[1] + geared.get(m.name, 0.0)) / r**2 for m, r in zip(self.wheelsets, radii, strict=True)]

    def acceleration(self, time: float, distance: float) -> float:
        """Acceleration by the efforts at a time [s], the vehicle's origin at a distance [m], without losses [m/s2]."""
        radii = {mounted.name: mounted.wheelset.mean_radius for mounted in self.wheelsets}
        force = sum(e.moment(time, distance) / radii[e.wheelset] for e in self.efforts)
        if self.brakes is not None:
            brakes, delays = np.array(
                [(m.brake, m.delay) for m in self.members if m.wagon is not None] or [(0.0, 0.0)]
            ).T
            force -= float(brakes @ self.brakes.share(time - delays))
        return force / self.moved_mass

    def loaded_as_at(self, distance: float) -> Vehicle:
        """The vehicle with the loads that it has at time 0 with its origin at a distance [m], as constant ones."""
        return self.loaded_as(lambda load: load.force(0.0, distance + load.at[0]))

    def alone(self, k: int) -> Vehicle:
        """The k-th vehicle of a train without its couplings, in its place in the train; without efforts."""
        unit = self.units[k]
        names = {self.names[i] for i in unit.parts}
        on_bodies = ("loads", "payloads", "points")
        attached: dict[str, Any] = {key: tuple(p for p in getattr(self, key) if p.body in names) for key in on_bodies}
        of_unit = [e for e in self.elements if {self.carrier(e.first), self.carrier(e.second)} <= names]
        return replace(
            self,
            name=self.members[k].name,
            wheelsets=tuple(self.wheelsets[i] for i in unit.wheelsets),
            bodies=tuple(body for body in self.bodies if body.name in names),
            elements=tuple(of_unit),
            **attached,
            drives=tuple(drive for drive in self.drives if drive.wheelset in names),
            efforts=(),
            slip_control=None,
            members=(),
            couplings=(),
            chain=(),
            brakes=None,
        )

    def with_wheelsets(self, change: Callable[[Wheelset], Wheelset]) -> Vehicle:
        """The vehicle with every wheelset changed; the guide frame holds its own at the height of the new wheels."""
        wheelsets, elements = [], list(self.elements)
        for mounted in self.wheelsets:
            new = replace(mounted, wheelset=change(mounted.wheelset))
            for i, e in enumerate(elements):
                if isinstance(e, Spring) and (e.first, e.second) == (GUIDE, mounted.name):
                    new = replace(new, height=new.wheelset.mean_radius)
                    elements[i] = replace(e, at=(e.at[0], e.at[1], new.height))
            wheelsets.append(new)
        return replace(self, wheelsets=tuple(wheelsets), elements=tuple(elements))


def single_wheelset(
    wheelset: Wheelset,
    *,
    stiffness: Triple = ZERO,
    damping: Triple = ZERO,
    half_spacing: float = 1.0,
    ahead: float = 0.0,
    carried_mass: float = 0.0,
    carried_height: float = 0.0,
) -> Vehicle:
    """A wheelset on its own, held to the guide frame by one set of springs and dampers on each side.

    stiffness [N/m], damping [N s/m]: along x, y, z of each side, at +-half_spacing [m] from the middle of the axle. Yaw
    and roll stiffness follow from it, 2 kx half_spacing^2 and 2 kz half_spacing^2.
    ahead: of the centre of the bogie [m], 0 for one that steers itself. In a curve of curvature kappa the axle is held
    at an angle of attack of -ahead kappa.
    carried_mass [kg] at carried_height above the axle [m].
    """
    name, height = "wheelset", wheelset.mean_radius
    springs: tuple[Element, ...] = ()
    if any(stiffness) or any(damping):
        sides = (("left", half_spacing), ("right", -half_spacing))
        springs = tuple(
            Spring(f"guide {side}", "spring", GUIDE, name, (0.0, y, height), stiffness, damping) for side, y in sides
        )
    return Vehicle(
        wheelset.name,
        (MountedWheelset(name, wheelset, 0.0, height),),
        (),
        springs,
        source=wheelset.source,
        carried=(CarriedMass(name, carried_mass, carried_height),) if carried_mass else (),
        guide_ahead=ahead,
        drive="free",
    )
