"""The arrays of a vehicle on its track for its kernel, in the order of ``dynamics.vehicle_forces``, and the places of
all unknowns in its state."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.arrays import TABLES as TABLES_OF_A_WHEEL
from wrsim.contact.arrays import Arrays
from wrsim.contact.model import ContactModel
from wrsim.jit.frames import BODY
from wrsim.simulation.bodies import bodies_of, inertia_table
from wrsim.simulation.flexible_arrays import Attachments, mode_records
from wrsim.simulation.force_law import Array, ForceLaw
from wrsim.track.bridge import Bridge
from wrsim.track.sleepers import SleeperTrack
from wrsim.track.track import RailElasticity, Track
from wrsim.vehicle.bogies import holders_of
from wrsim.vehicle.dynamics import deck as deck_kernel
from wrsim.vehicle.dynamics import friction, outputs, suspension, vehicle_forces
from wrsim.vehicle.dynamics import loads as load_kernel
from wrsim.vehicle.dynamics import rigid_body as body_kernel
from wrsim.vehicle.dynamics import stepper as step_kernel
from wrsim.vehicle.dynamics import wagons as wagon_kernel
from wrsim.vehicle.dynamics import wheel_forces as wheel_kernel
from wrsim.vehicle.dynamics.suspension import ELEMENT
from wrsim.vehicle.elements import Tables
from wrsim.vehicle.loads import Drive, LoadAxes, Over
from wrsim.vehicle.preload import Preload, normal_loads, preloads
from wrsim.vehicle.speed import SpeedProfile
from wrsim.vehicle.vehicle import Vehicle
from wrsim.vehicle.wheelset import Wheelset

RAIL_COORDINATES = vehicle_forces.RAIL_COORDINATES
"""Displacements of the rails under one wheelset."""


class Layout(ForceLaw):
    """Places of the unknowns in the state of a vehicle: six coordinates a body, wheelsets first, then ``dampers``
    unknowns, ``size`` in all.

    The last ``positions`` of them are positions: the pitch of the axle boxes, mass times way of
    vehicles that move along the track alone (``wagons``), the twist of axles whose wheels turn
    against each other (``twists``, by wheelset), the elastic modes (``modes``: where they are) of parts and of the
    bridge ``deck`` (``of_deck``; ``pushed`` where wheels push it themselves), and ``rails`` displacements of the rails
    under the wheels on what is ``beneath`` them. ``attachments``: where elastic parts are held. ``sliders``: places of
    the unknowns of friction. ``gears``: by wheelset the place of the twist of its geared motor's hollow axle, ahead of
    that of its rate.
    """

    def __init__(self, vehicle: Vehicle, track: Track, on_rails: bool) -> None:
        """on_rails: whether rails carry the vehicle."""
        self.track, self.tables = track, Tables()
        self.attachments = Attachments(vehicle)
        self.elements, self.preloads = element_records(vehicle, self.tables, self.attachments)
        self.vehicle, self.bodies, self.units = vehicle, bodies_of(vehicle), len(vehicle.units)
        twisting = [i for i, mounted in enumerate(vehicle.wheelsets) if mounted.wheelset.torsion is not None]
        structure = track.structure if on_rails else None
        self.deck = track.bridge if on_rails else None
        self.beneath = None if isinstance(structure, Bridge) else structure
        self.rails = 0 if self.beneath is None else RAIL_COORDINATES * len(vehicle.wheelsets)
        elastic = self.attachments.count + (0 if self.deck is None else len(self.deck.frequencies))
        self.boxes = box_records(vehicle, self.attachments)
        self.masses = np.array([wagon.mass for wagon in vehicle.wagons.values()])
        self.positions = len(vehicle.boxes) + len(self.masses) + len(twisting) + elastic + self.rails
        self.dampers = self.tables.unknowns + 2 * len(vehicle.drives) + self.positions
        self.size = size = 6 * len(self.bodies) + self.dampers
        first = size - self.positions - 2 * len(vehicle.drives)
        self.sliders = 6 * len(self.bodies) + np.array(self.tables.slips, dtype=np.intp)
        self.gears = {vehicle.index(d.wheelset): first + 2 * j for j, d in enumerate(vehicle.drives)}
        self.modes = range(size - self.rails - elastic, size - self.rails)
        self.of_deck = self.modes[self.attachments.count :]
        self.pushed = self.of_deck[: None if self.beneath is None else 0]
        self.twists = {wheelset: self.modes.start - len(twisting) + j for j, wheelset in enumerate(twisting)}
        self.boxes["coordinate"] = size - self.positions + np.arange(len(vehicle.boxes))
        self.wagons = size - self.positions + len(vehicle.boxes) + np.arange(len(self.masses))

    def coordinates_of_units(self, alone: bool = False) -> list[NDArray[np.intp]]:
        """Places of the unknowns of every vehicle of a train, those of couplings with the vehicle ahead, without rails;
        alone: as in a law of that vehicle alone, with its rails, without couplings.
        """
        bodies = len(self.bodies)
        boxes = [wheelset for wheelset, _ in self.vehicle.boxes.values()]
        held = self.attachments.owners
        behind = bodies + vehicle_forces.FRAMES + len(boxes)
        unit_of = np.zeros(behind + len(self.wagons) + len(held), dtype=int)
        for k, unit in enumerate(self.vehicle.units):
            unit_of[list(unit.parts) or unit.reference] = k
        unit_of[behind - len(boxes) : behind] = unit_of[boxes]
        unit_of[behind + len(self.wagons) :] = unit_of[held]
        owner = np.full(self.size, -1)
        owner[: 6 * bodies] = np.repeat(unit_of[:bodies], 6)
        for row in self.elements:
            if alone and unit_of[row.first] != unit_of[row.second]:
                continue
            places = [row.state] if row.state >= 0 else []
            if row.slider != friction.NO_SLIDER:
                count = 3 if row.slider == friction.BERG else 2 if row.kind == suspension.PLANE else 1
                places += range(row.slip, row.slip + count)
            owner[6 * bodies + np.array(places, dtype=int)] = unit_of[row.first]
        first = self.size - self.positions
        owner[first : first + len(boxes)] = unit_of[boxes]
        owner[self.wagons] = unit_of[behind : behind + len(self.wagons)]
        for wheelset, place in self.twists.items():
            owner[place] = unit_of[wheelset]
        for wheelset, place in self.gears.items():
            owner[place : place + 2] = unit_of[wheelset]
        for part in self.attachments.modes:
            owner[self.modes_of(part)] = unit_of[part]
        owner[self.of_deck.start : self.of_deck.stop] = -1 if alone else 0  # a bridge acts on itself alone
        if alone and self.rails:
            owner[self.size - self.rails :] = np.repeat(unit_of[: len(self.vehicle.wheelsets)], RAIL_COORDINATES)
        return [np.flatnonzero(owner == k) for k in range(len(self.vehicle.units))]

    def modes_of(self, part: int) -> NDArray[np.intp]:
        """Places of the modes of a part in the state; none of a rigid one."""
        if part not in self.attachments.modes:
            return np.zeros(0, dtype=np.intp)
        first = self.modes.start + self.attachments.first[part]
        return first + np.arange(len(self.attachments.modes[part].frequencies))


def element_records(
    vehicle: Vehicle, tables: Tables, attachments: Attachments
) -> tuple[NDArray[np.record], list[Preload]]:
    """Records of all elements, and the preloads that hold the vehicle in its design position; fills the tables."""
    elements = (*vehicle.elements, *vehicle.chain)
    rows = np.zeros(len(elements), ELEMENT)
    rows["state"] = rows["normal"] = -1
    held = [*preloads(vehicle), *(Preload(np.array(element.preload), np.zeros(3)) for element in vehicle.chain)]
    normals = normal_loads(replace(vehicle, elements=elements), held)
    for row, element, preload, normal in zip(rows, elements, held, normals, strict=True):
        start, end = (
            tuple(np.subtract(point, vehicle.place(name)).tolist())
            for name, point in zip((element.first, element.second), element.points, strict=True)
        )
        row.first, row.point_1 = attachments.hold(vehicle.index(element.first), start)
        row.second, row.point_2 = attachments.hold(vehicle.index(element.second), end)
        row.turning_preload = tuple(preload.moment)
        element.write(row, preload.force, tables)
        if normal is not None:
            row.normal, row.load = normal
    return rows, held


def box_records(vehicle: Vehicle, attachments: Attachments) -> NDArray[np.record]:
    """Records of all axle boxes but for their coordinates; on an elastic axle each sits at an attachment."""
    rows = np.zeros(len(vehicle.boxes), body_kernel.AXLE_BOX)
    for row, (w, box) in zip(rows, vehicle.boxes.values(), strict=True):
        row.inertia = box.inertia[1]
        row.wheelset, (_, row.lateral, _) = attachments.hold(w, (0.0, box.y, 0.0))
    return rows


DRIVES, LOAD_AXES, OVER = map(get_args, (Drive, LoadAxes, Over))
"""In the order of their numbers in ``dynamics.loads``."""


def vehicle_arrays(
    layout: Layout, *, drive: Drive, gravity: float, turns: int, motion: NDArray[np.record]
) -> list[Any]:
    """All arrays but those of the wheels, which follow them.

    gravity [m/s2]; turns: how the wheels take their turns (a stage of ``dynamics.wheel_forces``); motion: see
    ``pieces_of_motion``.
    """
    vehicle = layout.vehicle
    held = len(vehicle.boxes) + len(vehicle.wagons) + len(layout.attachments.owners)
    frames = len(layout.bodies) + vehicle_forces.FRAMES + held
    loads, load_tables = _loads(vehicle)
    efforts, effort_tables = _efforts(vehicle)
    axles, units = _axles_and_units(layout)
    carried = [(c.mass, c.height, vehicle.index(c.body)) for c in vehicle.carried]
    return [
        _whole(layout, drive, gravity, turns),
        _parts(layout),
        np.zeros(frames, BODY),
        np.zeros(frames, suspension.WRENCH),
        layout.elements,
        np.array(layout.tables.rows or [(0.0, 0.0)]),
        np.zeros(len(layout.elements), suspension.READING),
        loads,
        load_tables,
        np.array(carried, load_kernel.CARRIED),
        axles,
        layout.track.centre.curve.nodes,
        layout.boxes,
        motion,
        efforts,
        effort_tables,
        units,
        *_modes(layout),
        *_wagons(layout, float(motion["distance"][0])),
    ]


def _wagons(layout: Layout, start: float) -> list[Any]:
    """Records of the vehicles that move along the track alone, from their start [m] on, and the steps of the brakes."""
    vehicle, rows, pipe = layout.vehicle, np.zeros(len(layout.wagons), wagon_kernel.WAGON), layout.vehicle.brakes
    members = (member for member in vehicle.members if member.wagon is not None)
    for row, wagon, member, place in zip(rows, vehicle.wagons.values(), members, layout.wagons, strict=True):
        row.mass, row.place, row.half, row.coordinate = wagon.mass, start + wagon.x, 0.5 * wagon.pivots, place
        (row.constant, row.linear, row.square), row.curve = wagon.resistance, wagon.curve_resistance
        row.brake, row.delay, row.filling = member.brake, member.delay, 1.0 if pipe is None else pipe.filling
    return [rows, np.array(() if pipe is None else pipe.changes, dtype=float).reshape(-1, 2)]


def _modes(layout: Layout) -> list[Any]:
    """The arrays of elastic parts, and of the bridge, whose modes follow theirs."""
    rows, points, shapes, gyroscopic = layout.attachments.arrays(layout.modes.start, layout.preloads)
    deck = layout.deck
    if deck is None:
        return [rows, points, shapes, gyroscopic, np.zeros(0, deck_kernel.DECK), np.zeros((0, 2))]
    modes, deck_shapes = mode_records(deck, layout.of_deck.start), deck.shapes.reshape(len(deck.shapes), -1)
    decks = np.array([(deck.start, deck.step, len(rows), len(modes))], deck_kernel.DECK)[: layout.beneath is None]
    gyroscopic = np.pad(gyroscopic, ((0, len(modes)), (0, 0)))
    return [np.concatenate([rows, modes]), points, shapes, gyroscopic, decks, deck_shapes]


def stepper_arrays(layout: Layout, wheelsets: int) -> list[Any]:
    """The arrays of ``dynamics.stepper`` ahead of all others."""
    size, bodies = layout.size, layout.bodies
    return [
        np.zeros(1, step_kernel.STEP),
        np.zeros((step_kernel.ROWS, size)),
        np.zeros((size, size)),
        inertia_table(bodies),
        np.zeros((6, 6)),
        np.zeros(len(bodies), outputs.BODY_SEEN),
        np.zeros(2 * wheelsets, outputs.WHEEL_SEEN),
    ]


def arrays_of_wheels(wheelset: Wheelset, track: Track, contacts: tuple[ContactModel, ContactModel]) -> list[Any]:
    """The arrays of both wheels of a wheelset in the order of ``dynamics.wheel_forces``."""
    arrays: list[Any] = []
    for rail, model, side in zip((track.left, track.right), contacts, (1.0, -1.0), strict=True):
        wheel = np.zeros(1, wheel_kernel.WHEEL)
        wheel["side"], wheel["half_spacing"], wheel["step"] = side, 0.5 * wheelset.profile_spacing, rail.step
        # a wheelset's middle is over the tops of its rollers, whatever its yaw
        wheel["beside"] = wheel["half_spacing"] if model.roller is None else 0.0
        arrays += [wheel, rail.curve.nodes, *model.inputs]
    return arrays


def read_only(count: int) -> set[int]:
    """Numbers of the ``count`` arrays that no call changes: tables, which may be large; and of the matrix of the strip
    model, of which an inverse in its first rows is of use."""
    in_contact = {*TABLES_OF_A_WHEEL, Arrays._fields.index("matrix")}
    of_a_wheel = {wheel_kernel.IN_CONTACT + k for k in in_contact} | {wheel_kernel.RAIL}
    first, each = vehicle_forces.FIRST_WHEEL, wheel_kernel.ARRAYS
    return {vehicle_forces.CENTRE} | {i for i in range(first, count) if (i - first) % each in of_a_wheel}


def pieces_of_motion(profile: SpeedProfile, start: float) -> NDArray[np.record]:
    """The pieces of the frame's motion, from its start [m] on."""
    pieces = [(t, start + way, speed, rate) for t, way, speed, rate in profile.pieces]
    return np.array(pieces, vehicle_forces.PIECE)


def _whole(layout: Layout, drive: Drive, gravity: float, turns: int) -> NDArray[np.record]:
    records = np.zeros(1, vehicle_forces.VEHICLE)
    record, vehicle, track = records[0], layout.vehicle, layout.track
    record.gravity, record.drive = gravity, DRIVES.index(drive)
    record.step = track.centre.step
    record.guide_ahead = vehicle.guide_ahead
    record.rails, record.turns = -1, turns
    e = layout.beneath
    if layout.rails:
        record.rails = layout.size - layout.rails
        record.sleepers = isinstance(e, SleeperTrack)
    if isinstance(e, RailElasticity):
        record.rail_n, record.rail_b = zip(e.mass, e.stiffness, e.damping, strict=True)
    if vehicle.slip_control is not None:
        record.slip_speed, record.slip_creepage = vehicle.slip_control.speed, vehicle.slip_control.creepage
    return records


def _parts(layout: Layout) -> NDArray[np.record]:
    records = np.zeros(len(layout.bodies), vehicle_forces.PART)
    wheelsets = layout.vehicle.wheelsets
    for i, (row, body) in enumerate(zip(records, layout.bodies, strict=True)):
        row.mass, row.wheelset, row.twist = body.mass, i if i < len(wheelsets) else -1, layout.twists.get(i, -1)
        row.wheels = layout.attachments.wheels.get(i, -1)
        if i < len(wheelsets) and (torsion := wheelsets[i].wheelset.torsion) is not None:
            row.twist_inertia, row.twist_stiffness, row.twist_damping = (
                0.25 * body.inertia[1], torsion.stiffness, torsion.damping,
            )  # fmt: skip
    return records


def _axles_and_units(layout: Layout) -> tuple[NDArray[np.record], NDArray[np.record]]:
    """Records of the wheelsets' axles with their drives, and of the vehicles of a train."""
    vehicle = layout.vehicle
    axles = np.zeros(len(vehicle.wheelsets), load_kernel.AXLE)
    for i, (m, holder) in enumerate(zip(vehicle.wheelsets, holders_of(vehicle), strict=True)):
        axles[i].radius, axles[i].body = m.wheelset.mean_radius, i
        axles[i].holder = -1 if holder is None else vehicle.index(holder)
        axles[i].gear = -1
    for d in vehicle.drives:
        w = vehicle.index(d.wheelset)
        row = axles[w]
        row.holder, row.motor, row.gear = vehicle.index(d.case), vehicle.index(d.motor), layout.gears[w]
        row.ratio, row.rotor, row.turning = d.ratio, d.rotor_inertia, d.inertia
        row.stiffness, row.damping = d.stiffness, d.damping
    units = np.zeros(len(vehicle.pulled), load_kernel.UNIT)
    for k, (row, unit) in enumerate(zip(units, vehicle.pulled, strict=True)):
        row.mass, row.inertia, row.driven = unit.pulled_mass, unit.pulled_inertia, unit.driven
        row.body, row.ahead = unit.reference, unit.x
        row.axles = len(unit.wheelsets)
        for i in unit.wheelsets:
            axles[i].unit = k
    return axles, units


def _loads(vehicle: Vehicle) -> tuple[NDArray[np.record], Array]:
    """Records of the loads and of the forces of the payloads, behind them, and their tables."""
    acting = (*vehicle.loads, *(payload.as_load() for payload in vehicle.payloads))
    records = np.zeros(len(acting), load_kernel.LOAD)
    for row, load in zip(records, acting, strict=True):
        row.body, row.axes, row.over = vehicle.index(load.body), LOAD_AXES.index(load.axes), OVER.index(load.over)
        row.point = tuple(np.array(load.at) - np.array(vehicle.parts[row.body].centre))
    return records, _stacked(records, [load.table for load in acting], 4)


def _efforts(vehicle: Vehicle) -> tuple[NDArray[np.record], Array]:
    records = np.zeros(len(vehicle.efforts), load_kernel.EFFORT)
    for row, effort in zip(records, vehicle.efforts, strict=True):
        row.axle, row.over = vehicle.index(effort.wheelset), OVER.index(effort.over)
        row.side = {"left": 1.0, "right": -1.0, "both": 0.0}[effort.wheel]
    return records, _stacked(records, [effort.table for effort in vehicle.efforts], 2)


def _stacked(records: NDArray[np.record], tables: Sequence[Sequence[tuple[float, ...]]], width: int) -> Array:
    """All tables in one, at least one row of zeros; each record gets its first row and its number of rows."""
    records["rows"] = [len(table) for table in tables]
    records["start"] = np.cumsum(records["rows"]) - records["rows"]
    return np.array([row for table in tables for row in table] or [(0.0,) * width])
