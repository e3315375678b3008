"""The force law of a vehicle on its track: suspension, gravity, drive and all contacts in one numba call."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.arena import Arena, pack
from wrsim.contact.channels import ElementField, WheelOnRail
from wrsim.contact.model import ContactModel
from wrsim.core.body import suspension, vehicle_forces
from wrsim.core.body import wheelset_forces as wheelset_kernel
from wrsim.errors import SimulationError
from wrsim.simulation.bodies import RigidBody, Solid, SolidBody
from wrsim.simulation.suspension_table import suspension_table
from wrsim.simulation.system import Array
from wrsim.vehicle.vehicle import Drive
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

if TYPE_CHECKING:
    from wrsim.geometry.track.track import Track
    from wrsim.vehicle.vehicle import Vehicle
    from wrsim.vehicle.wheelset import Wheelset

Contacts = tuple[ContactModel, ContactModel]
"""Contact models of the left and the right wheel."""

DRIVES: tuple[Drive, ...] = ("free", "train", "wheels")
"""In the order of their numbers in ``core.body.vehicle_forces``."""

PLACES = [wheelset_kernel.S_LEFT, wheelset_kernel.S_RIGHT]
"""Distances along the rails among a wheelset's scalars."""

RAIL_COORDINATES = vehicle_forces.RAIL_COORDINATES
"""Displacements of the rails under one wheelset."""

SIDES: tuple[Literal["left", "right"], ...] = ("left", "right")


def _wheelset_arrays(wheelset: Wheelset, track: Track, contacts: Contacts) -> list[Array]:
    """The arrays of one wheelset in the order of ``core.body.wheelset_forces``."""
    scalars = np.zeros(wheelset_kernel.SCALAR_COUNT)
    scalars[[wheelset_kernel.STEP_LEFT, wheelset_kernel.STEP_RIGHT]] = track.left.step, track.right.step
    scalars[wheelset_kernel.HALF_SPACING] = 0.5 * wheelset.profile_spacing
    left, right = (model.inputs for model in contacts)
    return [scalars, track.left.table, track.right.table, np.zeros(3), np.zeros(3), *left, *right]


def _wheels(arena: Arena, wheelset: Wheelset, track: Track, contacts: Contacts) -> tuple[WheelOnRail, ...]:
    """The two wheels of a wheelset, whose models compute in its arena."""
    count = wheelset_kernel.RIGHT - wheelset_kernel.LEFT
    return tuple(
        WheelOnRail(
            contact.within(arena.part(first, count)),
            side,
            0.5 * wheelset.profile_spacing,
            origin,
        )
        for contact, side, first, origin in zip(
            contacts, (1, -1), (wheelset_kernel.LEFT, wheelset_kernel.RIGHT), track.rail_origins, strict=True
        )
    )


class VehicleOnTrack:
    """Generalised forces on a vehicle at any state; a ``ForceLaw``.

    ``bodies``: for ``System``, wheelsets first; ``dampers``: how many unknowns stand behind their coordinates,
    ``rails`` of them, the last ones, displacements of the rails under the wheels (``core.body.vehicle_forces``).
    After a call ``wheels[i]`` holds the contacts of wheelset i, ``records`` (elements, 6) force on the second body
    and travel of every element in the axes of its first body (of a strut along a line: tension and extension, in the
    places of x), ``distance`` the place of the reference body along the centre line.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        track: Track,
        contacts: Sequence[Contacts],
        *,
        speed: float,
        start: float = 0.0,
        drive: Drive | None = None,
        gravity: float = STANDARD_GRAVITY,
    ) -> None:
        """contacts: of every wheelset, or none at all: no rails carry the vehicle then.

        speed [m/s] of the vehicle's origin, which is at ``start`` [m] at t = 0. drive: the vehicle's own unless given.
        """
        drive = drive or vehicle.drive
        self.vehicle, self.track, self.speed, self.start, self.drive = vehicle, track, speed, start, drive
        self.bodies: tuple[Solid, ...] = (
            *(RigidBody.of(mounted.wheelset) for mounted in vehicle.wheelsets),
            *(SolidBody(body.mass, body.inertia) for body in vehicle.bodies),
        )
        table = suspension_table(vehicle)
        self.elastic = track.elasticity if contacts else None
        self.rails = RAIL_COORDINATES * len(vehicle.wheelsets) if self.elastic else 0
        self.dampers = table.states + self.rails
        self.size = 6 * len(self.bodies) + self.dampers
        own = self._arrays(table.elements, table.tables, speed, start, drive, gravity)
        whole = list(own)
        for mounted, models in zip(vehicle.wheelsets, contacts, strict=bool(contacts)):
            whole += _wheelset_arrays(mounted.wheelset, track, models)
        self.arena = pack(whole)
        views = self.arena.views
        self.scalars = views[vehicle_forces.V_SCALARS]
        self.elements = views[vehicle_forces.ELEMENTS]
        self.records = views[vehicle_forces.RECORDS]
        self._loads = views[vehicle_forces.LOADS]
        own_parts = [
            self.arena.part(first, wheelset_kernel.ARRAYS)
            for first in range(vehicle_forces.FIRST_WHEELSET, len(views), wheelset_kernel.ARRAYS)
        ]
        self.wheelset_views = [part.views for part in own_parts]
        self.wheels: tuple[tuple[WheelOnRail, ...], ...] = tuple(
            _wheels(part, mounted.wheelset, track, models)
            for part, mounted, models in zip(own_parts, vehicle.wheelsets, contacts, strict=bool(contacts))
        )
        self.look_near(start)

    def __call__(self, t: float, q: Array, q_t: Array, out: Array) -> int:
        """See ``ForceLaw``. Returns the status of the contacts; raises SimulationError off the track."""
        status = int(vehicle_forces.vehicle_forces(t, q, q_t, out, self.arena.buffer, self.arena.index))
        if status & wheelset_kernel.OFF_TRACK:
            raise SimulationError(f"the vehicle has left the track's neighbourhood at t = {t:.6g} s")
        return status

    def elements_of_contacts(self) -> list[list[list[ElementField]]]:
        """Elements of the patches of every wheel at the state asked for last, where the contact model has any."""
        return [[] for _ in self.wheels]

    @property
    def distance(self) -> float:
        """Distance of the reference body along the centre line at the state asked for last [m]."""
        return float(self.scalars[vehicle_forces.S_REFERENCE])

    @property
    def drive_force(self) -> float:
        """Force that holds the speed at the state asked for last, positive forward [N]."""
        return float(self.scalars[vehicle_forces.DRIVE_FORCE])

    def places(self, distances: Array) -> Array:
        """Rows for ``look_near`` (n, wheelsets, 3): distances of the wheelsets (n, wheelsets), and along both rails."""
        flat = np.asarray(distances, dtype=float).ravel()
        columns = [flat, *(self.track.rail_distance(side, flat) for side in SIDES)]
        return np.stack(columns, axis=-1).reshape(*np.shape(distances), 3)

    def set_speed(self, speed: float) -> None:
        """Change the speed [m/s] that the drive holds and at which the frame of the track runs on from its start."""
        self.speed = speed
        self.scalars[vehicle_forces.SPEED] = speed

    def look_near(self, origin: float | Array) -> None:
        """Tell where to look for the vehicle first: the distance of its origin [m], or a row of ``places``.

        Needed before a state far from the last one.
        """
        vehicle = self.vehicle
        if np.ndim(origin) == 0:
            rows = self.places(float(origin) + np.array([mounted.x for mounted in vehicle.wheelsets]))
        else:
            rows = np.asarray(origin)
        at = float(rows[0, 0]) - vehicle.wheelsets[0].x
        for view, row in zip(self.wheelset_views, rows, strict=bool(self.wheelset_views)):
            view[wheelset_kernel.SCALARS][PLACES] = row[1:]
        self.scalars[vehicle_forces.S_REFERENCE] = at + vehicle.parts[vehicle.reference].centre[0]
        for load in self._loads:
            load[vehicle_forces.S_LOAD] = at + vehicle.parts[int(load[0])].centre[0]

    def follow(self, on: bool, sharp: bool = False) -> None:
        """From now on contacts start from those of the last state (in a run), or afresh. See ``Follows``."""
        for wheels in self.wheels:
            for wheel in wheels:
                wheel.model.arrays.follow(on, sharp)

    def memory(self) -> Array:
        """What the next call starts from: it decides the last bits of the answer. See ``tape.Remembers``."""
        return np.concatenate(
            [self.scalars[[vehicle_forces.S_REFERENCE]], self._loads[:, vehicle_forces.S_LOAD]]
            + [view[wheelset_kernel.SCALARS][PLACES] for view in self.wheelset_views]
            + [wheel.model.arrays.memory() for wheels in self.wheels for wheel in wheels]
        )

    def recall(self, memory: Array) -> None:
        """Put back what ``memory`` gave."""
        loads = len(self._loads)
        self.scalars[vehicle_forces.S_REFERENCE] = memory[0]
        self._loads[:, vehicle_forces.S_LOAD] = memory[1 : 1 + loads]
        place = 1 + loads
        for view in self.wheelset_views:
            view[wheelset_kernel.SCALARS][PLACES] = memory[place : place + len(PLACES)]
            place += len(PLACES)
        for wheels in self.wheels:
            for wheel in wheels:
                place += wheel.model.arrays.recall(memory[place:])

    @contextmanager
    def dampers_at_rest(self) -> Iterator[None]:
        """While this lasts, dampers in series with springs carry nothing: they have had time to give way."""
        series = self.elements[:, suspension.SERIES].copy()
        own = self._with_unknown()
        try:
            self.elements[own, suspension.SERIES] = 0.0
            yield
        finally:
            self.elements[:, suspension.SERIES] = series

    def at_rest_in_series(self, q: Array, q_t: Array) -> Array:
        """The rates q_t with the extensions at which the dampers in series with springs carry nothing."""
        q_t = np.array(q_t, dtype=float)
        self(0.0, q, q_t, np.zeros(self.size))
        for i in self._with_unknown():
            row = self.elements[i]
            line = int(row[suspension.KIND]) == suspension.LINE
            travel = self.records[i, 3 + (0 if line else int(row[suspension.DIRECTION]))]
            q_t[6 * len(self.bodies) + int(row[suspension.STATE])] = travel
        return q_t

    def _with_unknown(self) -> NDArray[np.intp]:
        """Numbers of the elements with an unknown of their own."""
        struts = self.elements[:, suspension.KIND] >= suspension.AXIS
        return np.flatnonzero(struts & (self.elements[:, suspension.STATE] >= 0.0))

    def _arrays(
        self, elements: Array, tables: Array, speed: float, start: float, drive: Drive, gravity: float
    ) -> list[Array]:
        """The vehicle's own arrays in the order of ``core.body.vehicle_forces``."""
        vehicle, n = self.vehicle, len(self.bodies)
        scalars = np.zeros(vehicle_forces.VEHICLE_SCALARS)
        scalars[vehicle_forces.GRAVITY] = gravity
        scalars[vehicle_forces.START] = start
        scalars[vehicle_forces.SPEED] = speed
        scalars[vehicle_forces.VEHICLE_MASS] = vehicle.mass
        scalars[vehicle_forces.DRIVE] = DRIVES.index(drive)
        scalars[vehicle_forces.REFERENCE] = vehicle.reference
        scalars[vehicle_forces.AHEAD] = vehicle.parts[vehicle.reference].centre[0]
        scalars[vehicle_forces.STEP] = self.track.centre.step
        scalars[vehicle_forces.GUIDE_AHEAD] = vehicle.guide_ahead
        scalars[vehicle_forces.RAILS] = -1.0
        if self.elastic is not None:
            scalars[vehicle_forces.RAILS] = self.size - self.rails
            for place, pair in (
                (vehicle_forces.RAIL_MASS, self.elastic.mass),
                (vehicle_forces.RAIL_STIFFNESS, self.elastic.stiffness),
                (vehicle_forces.RAIL_DAMPING, self.elastic.damping),
            ):
                scalars[place : place + 2] = pair
        bodies = np.array(
            [(body.mass, i if i < len(vehicle.wheelsets) else -1.0) for i, body in enumerate(self.bodies)]
        )
        loads = np.zeros((len(vehicle.loads), vehicle_forces.LOAD_COLUMNS))
        for row, load in zip(loads, vehicle.loads, strict=True):
            row[0] = vehicle.index(load.body)
            row[1:4] = np.array(load.at) - np.array(vehicle.parts[int(row[0])].centre)
            row[4:7] = load.force
        carried = np.array([(vehicle.index(c.body), c.mass, c.height) for c in vehicle.carried]).reshape(-1, 3)
        axles = np.array([(i, self._holder(m.name), m.wheelset.mean_radius) for i, m in enumerate(vehicle.wheelsets)])
        return [
            scalars,
            bodies,
            np.zeros((n + vehicle_forces.FRAMES, 18)),
            np.zeros((n + vehicle_forces.FRAMES, 3)),
            np.zeros((n + vehicle_forces.FRAMES, 3)),
            elements,
            tables,
            np.zeros((len(elements), suspension.RECORD)),
            loads,
            carried,
            axles,
            self.track.centre.table,
        ]

    def _holder(self, wheelset: str) -> int:
        """The body that takes the reaction of a moment on a wheelset: the first that an element joins to it."""
        vehicle = self.vehicle
        ends = [e.first for e in vehicle.elements if e.second == wheelset]
        ends += [e.second for e in vehicle.elements if e.first == wheelset]
        bodies = [name for name in ends if vehicle.index(name) < len(vehicle.parts)]
        return vehicle.index(bodies[0]) if bodies else -1
