"""Force laws of a vehicle on its track: suspension, gravity, drive and all contacts in one compiled call; the same on
conical wheels with a prescribed creep law. With the exact contact solver: ``half_space_law``."""

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wrsim.contact.channels import ElementField, WheelOnRail
from wrsim.contact.model import ContactModel
from wrsim.contact.settings import ConicalWheels
from wrsim.contact.workspace import WARM_TOLERANCE, pack
from wrsim.errors import SimulationError
from wrsim.inputs.section import SIDES
from wrsim.jit.compiling import use_threads
from wrsim.jit.stages import make_ready
from wrsim.simulation.force_law import DIFFERENCE_TOLERANCE, Array, Block, Groups, all_on_all, groups_in_a_row
from wrsim.simulation.rails import RailsOnSleepers
from wrsim.simulation.vehicle_arrays import (
    RAIL_COORDINATES,
    Layout,
    arrays_of_wheels,
    pieces_of_motion,
    read_only,
    stepper_arrays,
    vehicle_arrays,
)
from wrsim.track.sleepers import SleeperTrack
from wrsim.track.track import Track
from wrsim.vehicle.dynamics import conical, friction, vehicle_forces
from wrsim.vehicle.dynamics import derivative as differences
from wrsim.vehicle.dynamics import wheel_forces as wheel_kernel
from wrsim.vehicle.dynamics.kinematics import is_near
from wrsim.vehicle.equivalent import Stroke, equivalent_elements
from wrsim.vehicle.loads import Drive
from wrsim.vehicle.speed import SpeedProfile
from wrsim.vehicle.vehicle import Vehicle
from wrsim.vehicle.wheelset import Wheelset

Contacts = tuple[ContactModel, ContactModel]
"""Contact models of the left and the right wheel."""

SUPPORT, SUPPORT_DAMPING = 1e9, 1e5
"""Stiffness [N/m] and damping [N s/m] of rigid rails under each conical wheel."""

OFF_TRACK = "derailed: the vehicle is no longer near its track at t = {:.6g} s"


def _on_rails(track: Track, distances: ArrayLike) -> Array:
    """Distances along the centre line, and those on both rails beside them: (..., 3) [m]."""
    flat = np.ravel(distances)
    columns = flat, *(track.rail_distance(side, flat) for side in SIDES)
    return np.stack(columns, axis=-1).reshape(*np.shape(distances), 3)


@lru_cache(maxsize=8)
def _start_places(track: Track, distances: tuple[float, ...]) -> Array:
    """The same for wheelsets at a start: those of one track begin at one place again and again."""
    return _on_rails(track, distances)


class VehicleOnTrack(Layout):
    """Generalised forces on a vehicle at any state.

    After a call ``wheels[i]`` holds the contacts of wheelset i, ``records`` (elements, 6) force on the second body
    and travel of every element in the axes of its first body (of a strut along a line: tension and extension, in the
    places of x), ``readings`` those between vehicles that move along the track alone as well, ``axles`` moments and
    slip of drive and brakes on each wheelset (records AXLE of ``dynamics.loads``), ``distance`` that of the reference
    body along the centre line.
    """

    compiled = True
    """Whether the kernel gives all forces, so that `forces_in_turn` may take many states."""

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
        stepped: bool = False,
    ) -> None:
        """contacts: of every wheelset; none: no rails carry the vehicle.

        speed [m/s] of the vehicle's origin, which is at ``start`` [m] at t = 0. profile: its speed from there on,
        constant unless given. drive, gravity [m/s2]: the vehicle's own unless given. threads: that compute the contacts
        side by side, with the same bits. Raises InputError for more than there are. stepped: for a `Stepper`, whose
        arrays lie ahead of the law's in ``whole``.
        """
        drive = drive or vehicle.drive
        super().__init__(vehicle, track, bool(contacts))
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
        ahead = stepper_arrays(self, len(contacts)) if stepped else []
        self.whole = pack([*ahead, *arrays])
        self.workspace = self.whole.part(len(ahead), len(arrays))
        views = self.workspace.views
        self._units = views[vehicle_forces.UNITS]
        self.elements = views[vehicle_forces.ELEMENTS]
        self.readings = views[vehicle_forces.READINGS].view(np.float64).reshape(-1, 6)
        self.records = self.readings[: len(vehicle.elements)]
        self._loads = views[vehicle_forces.LOADS]
        self.axles = views[vehicle_forces.AXLES]
        first, count = vehicle_forces.FIRST_WHEEL, wheel_kernel.ARRAYS
        self._changing = self.workspace.mutable_slices(read_only(len(views)))
        of_wheels = [self.workspace.part(place, count) for place in range(first, len(views), count)]
        records_of_wheels = [part.views[wheel_kernel.WHEEL_RECORD] for part in of_wheels]
        self._records_of_wheels = [records[0] for records in records_of_wheels]
        self._search_starts = [records["s"] for records in (self._units, self._loads, *records_of_wheels)]
        self.seeds = np.concatenate([self.workspace.places(view) for view in self._search_starts])
        """Places in the buffer of the distances at which searches on the track begin."""
        placed = [
            model.within(part.part(wheel_kernel.IN_CONTACT, wheel_kernel.ARRAYS_OF_A_CONTACT))
            for model, part in zip((model for pair in contacts for model in pair), of_wheels, strict=True)
        ]
        self.wheels = tuple(
            placed_on_rails(mounted.wheelset, pair, track)
            for mounted, pair in zip(vehicle.wheelsets, zip(placed[::2], placed[1::2], strict=True), strict=False)
        )
        self.on_sleepers: RailsOnSleepers | None = None
        """Rails on sleepers, if they lie on any; else elastic ones are pieces that move along."""
        elasticity = self.beneath
        if isinstance(elasticity, SleeperTrack):
            places = np.repeat([start + mounted.x for mounted in vehicle.wheelsets], 2)
            memory = self.workspace.buffer, self.workspace.index[first:]
            self.on_sleepers = RailsOnSleepers(
                elasticity, track, memory, self._records_of_wheels, places, vehicle.weight, self.size,
                views[vehicle_forces.MODES][self.attachments.count :],
            )  # fmt: skip
            self._search_starts += [records[slope] for records in records_of_wheels for slope in ("slope_n", "slope_b")]
            elasticity = self.on_sleepers.static
            self.explicit = False
        self.elastic = elasticity
        """Springs and masses of the rails under the wheels, of those on sleepers at the start."""
        self._state, self._evaluated = np.zeros((2, self.size)), np.nan
        """Coordinates and rates that the contacts belong to, and their time, nan where unknown."""
        self._blocks: list[Block] = []
        self.set_search_start(start)

    def __call__(self, t: float, q: Array, q_t: Array, out: Array) -> None:
        """See ``ForceLaw``. Raises SimulationError off the track."""
        self._evaluated = np.nan
        self.forces(t, q, q_t, out)
        self._state[0], self._state[1], self._evaluated = q, q_t, t

    def at(self, t: float, q: Array, q_t: Array, within: float = 0.0) -> None:
        """Evaluate the law at this state, unless the last evaluation was at this time and state, or at one whose
        positions differ from it by no more than ``within`` [m, rad]."""
        if self._evaluated == t and is_near(self._state, q, q_t, 6 * len(self.bodies), within):
            return
        self(t, q, q_t, np.zeros(self.size))

    def forces(self, t: float, q: Array, q_t: Array, out: Array) -> None:
        """Fill ``out`` by the kernel. Status of the contacts: in their models (`wrsim.contact.status`)."""
        status = int(vehicle_forces.vehicle_forces(t, q, q_t, out, self.workspace.buffer, self.workspace.index))
        if status & wheel_kernel.OFF_TRACK:
            raise SimulationError(OFF_TRACK.format(t))

    def on_bodies(self, t: float, q: Array, q_t: Array, out: Array) -> None:
        """All forces but those of the contacts, which act on wheelsets alone."""
        self._evaluated = np.nan
        out[:] = 0.0
        if vehicle_forces.add_forces_on_bodies(t, q, q_t, out, self.workspace.buffer, self.workspace.index):
            raise SimulationError(OFF_TRACK.format(t))

    def blocks(self) -> list[Block]:
        """See ``ForceLaw``: forces on all bodies, and contacts, each of which acts on one wheelset."""
        if not self._blocks:
            units = self.coordinates_of_units()
            groups = groups_in_a_row(units) if len(units) > 1 else all_on_all(self.size)
            self._blocks = [CompiledBlock(self, differences.ON_BODIES, groups)]
            alike: dict[int, list[NDArray[np.intp]]] = {}
            for w in range(len(self.wheels)):
                rails = self.size - self.rails + RAIL_COORDINATES * w + np.arange(RAIL_COORDINATES if self.rails else 0)
                twist = [self.twists[w]] if w in self.twists else []
                body = np.arange(6 * w, 6 * w + 6)
                coordinates = np.concatenate([body, rails, np.array(twist, int), self.modes_of(w)])
                alike.setdefault(len(coordinates), []).append(coordinates)
            for length in sorted(alike, reverse=True):
                wheelsets = np.array(alike[length])
                groups = [(c, wheelsets) for c in wheelsets.T]
                if self.pushed:  # every wheelset acts on them, and they on every wheelset
                    wide = [np.append(coordinates, self.pushed) for coordinates in alike[length]]
                    groups = [(columns[k : k + 1], columns[None]) for columns in wide for k in range(length)]
                self._blocks.append(CompiledBlock(self, differences.ON_WHEELS, groups))
            if self.pushed:
                on_all = np.r_[0 : 6 * len(self.wheels), self.pushed][None]
                by_deck = [(np.array([k]), on_all) for k in self.pushed]
                self._blocks.append(CompiledBlock(self, differences.ON_WHEELS, by_deck))
        return self._blocks

    @contextmanager
    def preserve_state(self) -> Iterator[None]:
        rows = [wheel.model.arrays.rows for wheels in self.wheels for wheel in wheels]
        changing = self._changing + [arrays.matrix[: (n := arrays.memo["unknowns"][0]), :n] for arrays in rows]
        before, state, evaluated = [view.copy() for view in changing], self._state.copy(), self._evaluated
        contacts = [arrays.state[0] for arrays in rows]
        tolerances = [contact.tolerance for contact in contacts]
        for contact in contacts:
            contact.tolerance = max(DIFFERENCE_TOLERANCE * contact.tolerance, WARM_TOLERANCE)
        try:
            yield
        finally:
            for contact, tolerance in zip(contacts, tolerances, strict=True):
                contact.tolerance = tolerance
            for view, values in zip(changing, before, strict=True):
                view[...] = values
            self._state[:], self._evaluated = state, evaluated

    def elements_of_contacts(self) -> list[list[list[ElementField]]]:
        """Elements of the patches of every wheel at the last evaluation, where the contact model has any."""
        return [[] for _ in self.wheels]

    @property
    def distance(self) -> float:
        """Distance of the (first) vehicle's reference body along the centre line at the last evaluation [m]."""
        return float(self._units["s"][0])

    @property
    def driven(self) -> bool:
        """Whether any axle is driven or braked."""
        return self.drive == "wheels" or bool(self.vehicle.efforts)

    def places(self, distances: Array) -> Array:
        """Rows for ``set_search_start`` (n, wheelsets, 3): distances of wheelsets (n, wheelsets) and on both rails."""
        return _on_rails(self.track, distances)

    def set_speed(self, speed: float) -> None:
        """Change the constant speed [m/s] of the drive and of the frame of the track."""
        self.speed, self.profile = speed, SpeedProfile.constant(speed)
        self.workspace.views[vehicle_forces.MOTION][:] = pieces_of_motion(self.profile, self.start)
        self._evaluated = np.nan

    def wheel_records(self, wheelset: int) -> list[Any]:
        """The records WHEEL of both wheels of a wheelset (``dynamics.wheel_forces``)."""
        return self._records_of_wheels[2 * wheelset : 2 * wheelset + 2]

    def set_search_start(self, origin: float | Array) -> None:
        """Start the searches on the track near a place: distance of the vehicle's origin [m], or a row of ``places``.

        Needed ahead of a state far from the last one.
        """
        self._evaluated = np.nan
        self.workspace.buffer[self.seeds] = self.search_starts(self._near(origin)[None])[0]

    def _near(self, origin: float | Array) -> Array:
        """The row of ``places`` for a place as ``set_search_start`` takes it."""
        if np.ndim(origin) == 0:
            return _start_places(self.track, tuple(float(origin) + m.x for m in self.vehicle.wheelsets))  # type: ignore[arg-type]
        return np.asarray(origin)

    def search_starts(self, places: Array) -> Array:
        """Where searches on the track begin (n, seeds), for ``places`` (n, wheelsets, 3)."""
        parts, distance = self.vehicle.parts, places[:, 0, :1] - self.vehicle.wheelsets[0].x
        units = np.array([unit.x for unit in self.vehicle.pulled])
        loads = np.array([parts[load.body].centre[0] for load in self._loads])
        wheels = places[:, :, 1:].reshape(len(places), -1)[:, : len(self._records_of_wheels)]
        return np.hstack([distance + units, distance + loads + self._loads["point"]["x"], wheels])

    def follow(self, on: bool, tolerance: float = WARM_TOLERANCE) -> None:
        """See ``ForceLaw``: a warm start of every contact, or a cold one."""
        for wheels in self.wheels:
            for wheel in wheels:
                wheel.model.arrays.follow(on, tolerance)

    def memory(self) -> list[NDArray[Any]]:
        """See ``ForceLaw``: places on the track, and contacts."""
        views = self._search_starts + [view for wheels in self.wheels for w in wheels for view in w.model.arrays.kept()]
        return views if self.on_sleepers is None else views + self.on_sleepers.memory()

    def set_state(self, state: Array) -> None:
        """See ``ForceLaw``. Inverses of the contacts are dropped, for they are no part of the state."""
        self._evaluated = np.nan
        super().set_state(state)
        if self.on_sleepers is not None:
            self.on_sleepers.resume()
        for wheels in self.wheels:
            for wheel in wheels:
                wheel.model.arrays.rows.memo["inverted"] = 0

    def begin_step(self, step: float, q: Array, q_t: Array, q_tt: Array, again: bool) -> None:
        if self.on_sleepers is None:
            return
        rails = slice(self.size - self.rails, self.size)
        if again:
            q[rails], q_t[rails], q_tt[rails] = self.on_sleepers.guess
        else:
            self.on_sleepers.deck[:] = q[self.of_deck], q_t[self.of_deck]
            self.on_sleepers.begin(step, q[rails], q_t[rails], q_tt[rails])
            vehicle_forces.place_wheels(q, q_t, self.workspace.buffer, self.workspace.index)
            self.on_sleepers.look_at_wheels(q[rails], q_t[rails], q_tt[rails])
            self._evaluated = np.nan

    def hold(self, first: bool, tolerance: float, last: Array, q: Array, q_t: Array, q_tt: Array) -> bool:
        if self.on_sleepers is None:
            return False
        rails = slice(self.size - self.rails, self.size)
        return self.on_sleepers.hold(first, tolerance, last[rails], q[rails], q_t[rails], q_tt[rails])

    def end_step(self, q: Array, q_t: Array) -> None:
        if self.on_sleepers is not None:
            self.on_sleepers.end(q[self.size - self.rails :])
            self.on_sleepers.strike(q)

    @contextmanager
    def relaxed_dampers(self, slips: Array | None = None) -> Iterator[None]:
        """While this lasts, the inner unknowns have their static values: dampers in series with springs carry nothing,
        sliders the force after a straight way from the design position, or from their slips where these are not 0;
        hollow axles of geared motors turn with their wheelsets and carry the moments of the motors."""
        how = friction.FRESH if slips is None or not np.any(slips) else friction.HELD
        whole = self.workspace.views[vehicle_forces.WHOLE][0]
        before, whole["relaxed"] = int(whole["relaxed"]), 1
        try:
            elements = self.elements.copy()
            elements["relaxed"] = how
            with self._elements_as(elements):
                yield
        finally:
            whole["relaxed"] = before

    def relaxed_rates(self, q: Array, q_t: Array) -> Array:
        """The rates q_t with the static values of the unknowns of dampers in series with springs and of sliders."""
        q_t, out = np.array(q_t, dtype=float), np.zeros(self.size)
        with self.relaxed_dampers(q_t[self.sliders]):
            self(0.0, q, q_t, out)
        inner = slice(6 * len(self.bodies), self.size - self.positions)
        q_t[inner] = out[inner]
        return q_t

    def equivalent(self, stroke: Stroke, t: float, q: Array, q_t: Array) -> AbstractContextManager[None]:
        self.at(t, q, q_t)
        tables = self.workspace.views[vehicle_forces.TABLES]
        return self._elements_as(equivalent_elements(self.elements, self.readings, tables, stroke))

    @contextmanager
    def _elements_as(self, elements: Any) -> Iterator[None]:
        """While this lasts, all elements are these records."""
        before = self.elements.copy()
        try:
            self.elements[:] = elements
            self._evaluated = np.nan
            yield
        finally:
            self.elements[:] = before
            self._evaluated = np.nan


class CompiledBlock(Block):
    """A part of a vehicle's forces, all differences of which are one compiled call."""

    def __init__(self, law: VehicleOnTrack, part: int, groups: Groups) -> None:
        """part: ON_BODIES or ON_WHEELS of ``dynamics.derivative``."""
        self.workspace, self.part, self.groups = law.workspace, part, groups
        widest, longest = max(len(columns) for columns, _ in groups), max(rows.shape[1] for _, rows in groups)
        self._columns, self._rows = np.full((len(groups), widest), -1), np.zeros((len(groups), widest, longest), int)
        for g, (columns, rows) in enumerate(groups):
            self._columns[g, : len(columns)] = columns
            self._rows[g, : len(columns)] = rows[:, :1]
            self._rows[g, : len(columns), : rows.shape[1]] = rows

    def add_differences(self, t: float, central: bool, work: Array, matrix: Array) -> None:
        places, memory = (self._columns, self._rows), (self.workspace.buffer, self.workspace.index)
        if differences.add_differences(t, self.part, central, *places, work, matrix, *memory):
            raise SimulationError(OFF_TRACK.format(t))


def placed_on_rails(wheelset: Wheelset, models: Contacts, track: Track) -> tuple[WheelOnRail, WheelOnRail]:
    """Models of both wheels with their places: on the wheelset and in the track's cross-section at nominal gauge."""
    left, right = (
        WheelOnRail(model, side, 0.5 * wheelset.profile_spacing, origin)
        for model, side, origin in zip(models, (1, -1), track.rail_origins, strict=True)
    )
    return left, right


class ConicalVehicleOnTrack(VehicleOnTrack):
    """A vehicle on conical wheels with a prescribed creep law; a ``ForceLaw``. ``wheels`` is empty."""

    def __init__(
        self,
        vehicle: Vehicle,
        track: Track,
        cones: ConicalWheels,
        *,
        speed: float,
        start: float = 0.0,
        drive: Drive | None = None,
    ) -> None:
        """As ``VehicleOnTrack``; speed [m/s] must not be 0: creepages are velocities over the speed."""
        self.radii = np.array([mounted.wheelset.mean_radius for mounted in vehicle.wheelsets])
        self.distances = np.zeros(len(self.radii))
        self.law = np.zeros(1, conical.CONICAL)
        law = self.law[0]
        law.conicity, law.half = cones.conicity, cones.half_spacing
        law.creep_x, law.creep_y = cones.creep_longitudinal, cones.creep_lateral
        law.friction = cones.friction or 0.0
        law.clearance = np.inf if cones.flange_clearance is None else cones.flange_clearance
        law.flange = 0.0 if cones.flange_clearance is None else cones.flange_stiffness
        law.support, law.support_damping = SUPPORT, SUPPORT_DAMPING
        super().__init__(vehicle, track, (), speed=speed, start=start, drive=drive)

    def forces(self, t: float, q: Array, q_t: Array, out: Array) -> None:
        super().forces(t, q, q_t, out)
        if self._add_conical(q, q_t, self.distances, out):
            raise SimulationError(OFF_TRACK.format(t))

    def _add_conical(self, q: Array, q_t: Array, places: Array, out: Array) -> int:
        return conical.conical_forces(q, q_t, self.radii, places, self.track.centre.curve, self.speed, self.law, out)

    def blocks(self) -> list[Block]:
        def on_cones(t: float, q: Array, q_t: Array, out: Array) -> None:
            out[:] = 0.0
            self._add_conical(q, q_t, self.distances.copy(), out)

        coordinates = np.arange(6 * len(self.radii)).reshape(-1, 6)
        return [*super().blocks(), Block(on_cones, [(column, coordinates) for column in coordinates.T])]

    def set_search_start(self, origin: float | Array) -> None:
        super().set_search_start(origin)
        self.distances[:] = self._near(origin)[:, 0]

    def memory(self) -> list[NDArray[Any]]:
        return [self.distances, *super().memory()]
