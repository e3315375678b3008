"""The force law of a vehicle on its track: suspension, gravity, drive and all contacts in one numba call."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.arena import pack
from wrsim.contact.channels import ElementField, WheelOnRail
from wrsim.contact.model import ContactModel
from wrsim.core.body import friction, vehicle_forces
from wrsim.core.body import wheel_forces as wheel_kernel
from wrsim.core.jit.compiling import use_threads
from wrsim.core.jit.stages import make_ready
from wrsim.errors import SimulationError
from wrsim.simulation.force_law import Array, Block, groups_in_a_row
from wrsim.simulation.vehicle_arrays import (
    RAIL_COORDINATES,
    Layout,
    arrays_of_wheels,
    only_read,
    pieces_of_motion,
    vehicle_arrays,
)
from wrsim.vehicle.loads import Drive
from wrsim.vehicle.speed import SpeedProfile

if TYPE_CHECKING:
    from wrsim.geometry.track.track import Track
    from wrsim.vehicle.vehicle import Vehicle
    from wrsim.vehicle.wheelset import Wheelset

Contacts = tuple[ContactModel, ContactModel]
"""Contact models of the left and the right wheel."""

UNBOUNDED = 1e15
"""Added to the bound of a slider's force [N], one that no force reaches."""

SIDES: tuple[Literal["left", "right"], ...] = ("left", "right")


class VehicleOnTrack(Layout):
    """Generalised forces on a vehicle at any state.

    After a call ``wheels[i]`` holds the contacts of wheelset i, ``records`` (elements, 6) force on the second body
    and travel of every element in the axes of its first body (of a strut along a line: tension and extension, in the
    places of x), ``axles`` what drive and brakes do to each wheelset (records AXLE of ``core.body.loads``),
    ``distance`` the place of the reference body along the centre line.
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
        gravity: float | None = None,
        threads: int = 1,
        profile: SpeedProfile | None = None,
    ) -> None:
        """contacts: of every wheelset, or none at all: no rails carry the vehicle then.

        speed [m/s] of the vehicle's origin, which is at ``start`` [m] at t = 0. profile: how it goes on from there,
        constant unless given. drive, gravity [m/s2]: the vehicle's own unless given. threads: that compute the contacts
        side by side; they change no bit. Raises InputError for more than there are.
        """
        drive = drive or vehicle.drive
        self.elastic = track.elasticity if contacts else None
        super().__init__(vehicle, track, self.elastic is not None)
        self.speed, self.start, self.drive = speed, start, drive
        self.profile = profile or SpeedProfile.constant(speed)
        use_threads(threads)
        self._turns = wheel_kernel.IN_TURN if threads == 1 else wheel_kernel.SIDE_BY_SIDE
        make_ready(wheel_kernel.ONE_WHEEL, wheel_kernel.one_wheel)
        make_ready(self._turns, wheel_kernel.STAGES[self._turns])
        arrays = vehicle_arrays(
            self, drive=drive, gravity=vehicle.gravity if gravity is None else gravity, turns=self._turns,
            motion=pieces_of_motion(self.profile, start),
        )  # fmt: skip
        for mounted, models in zip(vehicle.wheelsets, contacts, strict=bool(contacts)):
            arrays += arrays_of_wheels(mounted.wheelset, track, models)
        self.arena = pack(arrays)
        views = self.arena.views
        self._units = views[vehicle_forces.UNITS]
        self.elements = views[vehicle_forces.ELEMENTS]
        self.records = views[vehicle_forces.READINGS].view(np.float64).reshape(-1, 6)
        self._loads = views[vehicle_forces.LOADS]
        self.axles = views[vehicle_forces.AXLES]
        first, count = vehicle_forces.FIRST_WHEEL, wheel_kernel.ARRAYS
        self._changing = self.arena.stretches_but(only_read(len(views)))
        of_wheels = [self.arena.part(place, count) for place in range(first, len(views), count)]
        own = [part.views[wheel_kernel.OWN] for part in of_wheels]
        self._records_of_wheels = [records[0] for records in own]
        self._found_at = [records["s"] for records in (self._units, self._loads, *own)]
        placed = [
            model.within(part.part(wheel_kernel.IN_CONTACT, wheel_kernel.ARRAYS_OF_A_CONTACT))
            for model, part in zip((model for pair in contacts for model in pair), of_wheels, strict=True)
        ]
        self.wheels = tuple(
            placed_on_rails(mounted.wheelset, pair, track)
            for mounted, pair in zip(vehicle.wheelsets, zip(placed[::2], placed[1::2], strict=True), strict=False)
        )
        self._asked, self._asked_at = np.zeros((2, self.size)), np.nan
        self.look_near(start)

    def __call__(self, t: float, q: Array, q_t: Array, out: Array) -> None:
        """See ``ForceLaw``. Raises SimulationError off the track."""
        self._asked_at = np.nan
        self.forces(t, q, q_t, out)
        self._asked_at, self._asked[0], self._asked[1] = t, q, q_t

    def at(self, t: float, q: Array, q_t: Array, within: float = 0.0) -> None:
        """Make the contacts and everything else that the law keeps those of this state.

        Nothing is computed where the law has been asked last for this time and for this very state, or for one whose
        positions differ from it by no more than ``within`` [m, rad].
        """
        if self._asked_at == t:
            if np.array_equal(self._asked[0], q) and np.array_equal(self._asked[1], q_t):
                return
            bodies = 6 * len(self.bodies)
            if within > 0.0 and np.abs(self._asked[0, :bodies] - q[:bodies]).max() <= within:
                return
        self(t, q, q_t, np.zeros(self.size))

    def forces(self, t: float, q: Array, q_t: Array, out: Array) -> None:
        """What a call computes. Messages of the contacts are in their models (`wrsim.contact.status`)."""
        status = int(vehicle_forces.vehicle_forces(t, q, q_t, out, self.arena.buffer, self.arena.index))
        if status & wheel_kernel.OFF_TRACK:
            raise SimulationError(f"the vehicle has left the track's neighbourhood at t = {t:.6g} s")

    def on_bodies(self, t: float, q: Array, q_t: Array, out: Array) -> None:
        """Everything but the contacts, which act on wheelsets alone."""
        self._asked_at = np.nan
        out[:] = 0.0
        if vehicle_forces.add_forces_on_bodies(t, q, q_t, out, self.arena.buffer, self.arena.index):
            raise SimulationError(f"the vehicle has left the track's neighbourhood at t = {t:.6g} s")

    def blocks(self) -> list[Block]:
        """See ``ForceLaw``: everything but the contacts, and the contacts, each of them of one wheelset."""
        buffer, index, on_bodies = self.arena.buffer, self.arena.index, self.on_bodies

        def on_wheels(t: float, q: Array, q_t: Array, out: Array) -> None:
            out[:] = 0.0
            vehicle_forces.add_forces_on_wheels(q, q_t, out, buffer, index)

        units = self.coordinates_of_units()
        found = [Block.full(on_bodies, self.size)]
        if len(units) > 1:
            columns, rows = zip(*groups_in_a_row(units), strict=True)
            found = [Block(on_bodies, columns, rows)]
        if self.wheels:
            count = len(self.wheels)
            own = np.arange(6 * count).reshape(count, 6)
            if self.rails:
                rails = np.arange(self.size - self.rails, self.size).reshape(count, RAIL_COORDINATES)
                own = np.hstack([own, rails])
            twisting = list(self.twists)
            if twisting:
                with_twist = np.column_stack([own[twisting], list(self.twists.values())])
                found.append(Block.apart(on_wheels, with_twist))
                own = np.delete(own, twisting, axis=0)
            if len(own):
                found.append(Block.apart(on_wheels, own))
        return found

    @contextmanager
    def undisturbed(self) -> Iterator[None]:
        """See ``ForceLaw``."""
        before = [view.copy() for view in self._changing]
        asked, at = self._asked.copy(), self._asked_at
        try:
            yield
        finally:
            for view, kept in zip(self._changing, before, strict=True):
                view[...] = kept
            self._asked[:], self._asked_at = asked, at

    def elements_of_contacts(self) -> list[list[list[ElementField]]]:
        """Elements of the patches of every wheel at the state asked for last, where the contact model has any."""
        return [[] for _ in self.wheels]

    @property
    def distance(self) -> float:
        """Distance of the (first) vehicle's reference body along the centre line at the state asked for last [m]."""
        return float(self._units["s"][0])

    @property
    def drive_force(self) -> float:
        """Force that holds the speed at the state asked for last, of all vehicles, positive forward [N]."""
        return float(self._units["force"].sum())

    @property
    def driven(self) -> bool:
        """Whether any axle is driven or braked."""
        return self.drive == "wheels" or bool(self.vehicle.efforts)

    @property
    def load_forces(self) -> Array:
        """Forces of the vehicle's loads (loads, 3) along their axes at the state asked for last [N]."""
        forces = self._loads["force"][: len(self.vehicle.loads)]
        return np.stack([forces[axis] for axis in "xyz"], axis=-1)

    def places(self, distances: Array) -> Array:
        """Rows for ``look_near`` (n, wheelsets, 3): distances of the wheelsets (n, wheelsets), and along both rails."""
        flat = np.asarray(distances, dtype=float).ravel()
        columns = [flat, *(self.track.rail_distance(side, flat) for side in SIDES)]
        return np.stack(columns, axis=-1).reshape(*np.shape(distances), 3)

    def set_speed(self, speed: float) -> None:
        """Change the constant speed [m/s] that the drive holds and at which the frame of the track runs on from its
        start."""
        self.speed, self.profile = speed, SpeedProfile.constant(speed)
        self.arena.views[vehicle_forces.MOTION][:] = pieces_of_motion(self.profile, self.start)
        self._asked_at = np.nan

    def own(self, wheelset: int) -> list[Any]:
        """The records WHEEL of both wheels of a wheelset (``core.body.wheel_forces``)."""
        return self._records_of_wheels[2 * wheelset : 2 * wheelset + 2]

    def look_near(self, origin: float | Array) -> None:
        """Tell where to look for the vehicle first: the distance of its origin [m], or a row of ``places``.

        Needed before a state far from the last one.
        """
        self._asked_at = np.nan
        vehicle = self.vehicle
        if np.ndim(origin) == 0:
            rows = self.places(float(origin) + np.array([mounted.x for mounted in vehicle.wheelsets]))
        else:
            rows = np.asarray(origin)
        at = float(rows[0, 0]) - vehicle.wheelsets[0].x
        if self._records_of_wheels:
            for wheel, s in zip(self._records_of_wheels, rows[:, 1:].ravel(), strict=True):
                wheel.s = s
        for row, unit in zip(self._units, vehicle.units, strict=True):
            row.s = at + vehicle.parts[unit.reference].centre[0]
        for load in self._loads:
            load.s = at + vehicle.parts[load.body].centre[0] + load.at.x

    def follow(self, on: bool) -> None:
        """From now on contacts start from those of the last state (in a run), or cold."""
        for wheels in self.wheels:
            for wheel in wheels:
                wheel.model.arrays.follow(on)

    def kept(self) -> list[NDArray[Any]]:
        """See ``ForceLaw``: where the vehicle was found last, and its contacts."""
        return self._found_at + [view for wheels in self.wheels for w in wheels for view in w.model.arrays.kept()]

    def set_state(self, state: Array) -> None:
        """See ``ForceLaw``. What follows is the same to the bit wherever it is done: inverses are given up."""
        self._asked_at = np.nan
        super().set_state(state)
        for wheels in self.wheels:
            for wheel in wheels:
                wheel.model.arrays.rows.memo["inverted"] = 0

    @contextmanager
    def settled(self, slips: Array | None = None) -> Iterator[None]:
        """While this lasts, dampers in series with springs carry nothing, they have had time to give way, and sliders
        what they do after a straight way from the design position, or from their slips where these are not 0;
        hollow axles of geared motors turn with their wheelsets and carry what the motors give."""
        how = friction.FRESH if slips is None or not np.any(slips) else friction.HELD
        whole = self.arena.views[vehicle_forces.WHOLE][0]
        before, whole["settled"] = int(whole["settled"]), 1
        try:
            with self._elements_with("settled", how):
                yield
        finally:
            whole["settled"] = before

    def settled_rates(self, q: Array, q_t: Array) -> Array:
        """The rates q_t with the unknowns that dampers in series with springs and sliders have once settled there."""
        q_t, out = np.array(q_t, dtype=float), np.zeros(self.size)
        with self.settled(q_t[self.sliders]):
            self(0.0, q, q_t, out)
        inner = slice(6 * len(self.bodies), self.size - self.positions)
        q_t[inner] = out[inner]
        return q_t

    def stuck(self) -> AbstractContextManager[None]:
        """While this lasts, no slider slips."""
        return self._elements_with("bound", self.elements["bound"] + UNBOUNDED)

    @contextmanager
    def _elements_with(self, name: str, values: Any) -> Iterator[None]:
        """While this lasts, a field of all elements has other values."""
        before = self.elements[name].copy()
        try:
            self.elements[name] = values
            self._asked_at = np.nan
            yield
        finally:
            self.elements[name] = before
            self._asked_at = np.nan


def placed_on_rails(wheelset: Wheelset, models: Contacts, track: Track) -> tuple[WheelOnRail, WheelOnRail]:
    """Models of both wheels with their places: on the wheelset and in the track's cross-section at nominal gauge."""
    left, right = (
        WheelOnRail(model, side, 0.5 * wheelset.profile_spacing, origin)
        for model, side, origin in zip(models, (1, -1), track.rail_origins, strict=True)
    )
    return left, right
