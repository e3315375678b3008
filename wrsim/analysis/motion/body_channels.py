"""Channels from sampled states: bodies, points, frames, the track under a wheelset, energies, couplings."""

from collections.abc import Mapping, Sequence
from operator import itemgetter
from typing import Any

import numpy as np

from wrsim.inputs.section import SIDES
from wrsim.jit.frames import BODY
from wrsim.results.netcdf import parts_of
from wrsim.simulation.bodies import accelerations, inertia_table
from wrsim.simulation.integrate import Motion
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import poses_on_track
from wrsim.simulation.sampled_forces import SampledForces
from wrsim.simulation.system import COORDINATES, Array
from wrsim.track.track import Track
from wrsim.vehicle.axle import AxleModes
from wrsim.vehicle.dynamics import vehicle_forces
from wrsim.vehicle.dynamics.rigid_body import kinetic_energies
from wrsim.vehicle.dynamics.wagons import place_wagons
from wrsim.vehicle.elements import GUIDE, TRACK
from wrsim.vehicle.vehicle import MeasuringPoint, Vehicle


def body_channels(law: VehicleOnTrack, q: Array, q_t: Array, near: Array) -> dict[str, Array]:
    """Displacements and angles of the bodies against the track where they are, each (samples, bodies).

    near: distance (bodies,) at which each is looked for at the first sample [m]; becomes that of the last.
    """
    vehicle = law.vehicle
    first, n = len(vehicle.wheelsets), len(q)
    names = ("body_lateral", "body_vertical", "body_yaw", "body_pitch", "body_roll")
    channels = {name: np.zeros((n, len(vehicle.bodies))) for name in names}
    path = law.track.centre
    for b, body in enumerate(vehicle.bodies):
        coordinates = slice(6 * (first + b), 6 * (first + b) + 6)
        poses = poses_on_track(path, q[:, coordinates], q_t[:, coordinates], near[b])
        near[b] = poses.distance[-1]
        channels["body_lateral"][:, b] = poses.lateral - body.centre[1]
        channels["body_vertical"][:, b] = poses.height - body.centre[2]
        channels["body_yaw"][:, b] = poses.yaw
        channels["body_roll"][:, b] = poses.roll
        forward = body_axes(q[:, coordinates])[:, 0]
        up = path.frame(poses.distance)[:, 3]
        channels["body_pitch"][:, b] = -np.arcsin(np.clip(_along(forward, up), -1.0, 1.0))
    return channels


def wheel_seats(vehicle: Vehicle) -> list[MeasuringPoint]:
    """Where the wheels sit on their axles, left and right of each in turn."""
    seats = []
    for mounted in vehicle.wheelsets:
        (x, y, z), half = mounted.centre, 0.5 * mounted.wheelset.profile_spacing
        seats += [MeasuringPoint("", mounted.name, (x, y + side * half, z)) for side in (1.0, -1.0)]
    return seats


def body_axes(q: Array) -> Array:
    """Axes of a body in states (samples, 6) of it: (samples, 3, 3), forward, left and up in the rows
    (``dynamics.rigid_body``)."""
    (sh, sr, sp), (ch, cr, cp) = np.sin(q[:, 3:6].T), np.cos(q[:, 3:6].T)
    level, left = np.array([ch, sh, 0.0 * sh]), np.array([-sh * cr, ch * cr, sr])
    up = np.array([sh * sr, -ch * sr, cr])
    return np.moveaxis(np.array([cp * level - sp * up, left, sp * level + cp * up]), -1, 0)


def point_accelerations(
    law: VehicleOnTrack, q: Array, q_t: Array, forces: Array, points: Sequence[MeasuringPoint]
) -> Array:
    """Accelerations (samples, points, 3) of points of the vehicle along their bodies' axes [m/s2] at states under
    generalised forces (samples, size).

    They contain gravity as an accelerometer fixed to the body does, less its share at rest on level track: zero there;
    on canted track the lateral one shows the plane's component of gravity against the centrifugal acceleration.
    """
    vehicle, names = law.vehicle, law.vehicle.names
    q_tt = accelerations(law.bodies, q, q_t, forces)
    values, moving = np.zeros((len(q), len(points), 3)), dict[int, tuple[Array, Array, Array]]()
    for j, point in enumerate(points):
        i = names.index(point.body)
        arm = np.array(point.at) - np.array(vehicle.parts[i].centre)
        if i not in moving:
            coordinates, rates, changes = q[:, 6 * i : 6 * i + 6], q_t[:, 6 * i : 6 * i + 6], q_tt[:, i]
            if i < len(vehicle.wheelsets):  # an axle box does not spin
                coordinates, rates, changes = (
                    state * (1.0, 1.0, 1.0, 1.0, 1.0, 0.0) for state in (coordinates, rates, changes)
                )
            acceleration = changes[:, [1, 2, 0]] + (0.0, 0.0, vehicle.gravity)
            along = np.einsum("nij,nj->ni", body_axes(coordinates), acceleration)
            moving[i] = along, *_turning(coordinates, rates, changes)
        along, omega, alpha = moving[i]
        values[:, j] = along + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
        if len(modes := law.modes_of(i)):
            values[:, j] += forces[:, modes] @ law.attachments.modes[i].shapes(np.array([point.at]))[:, 0, :3]
    values[:, :, 2] -= vehicle.gravity
    return values


def _turning(q: Array, q_t: Array, q_tt: Array) -> tuple[Array, Array]:
    """Angular velocity [rad/s] in body axes, G theta_t, and its rate, G theta_tt + G_t theta_t, each (samples, 3), of a
    body in states (samples, 6) (``dynamics.rigid_body``)."""
    (sr, sp), (cr, cp) = np.sin(q[:, 4:6].T), np.cos(q[:, 4:6].T)
    h, r, p = q_t[:, 3:6].T
    a, b, c = q_tt[:, 3:6].T
    omega = [r * cp - h * cr * sp, h * sr + p, r * sp + h * cr * cp]
    rate = [
        b * cp - a * cr * sp + h * (sr * sp * r - cr * cp * p) - r * sp * p,
        a * sr + c + h * cr * r,
        b * sp + a * cr * cp - h * (sr * cp * r + cr * sp * p) + r * cp * p,
    ]
    return np.stack(omega, axis=1), np.stack(rate, axis=1)


def twist_channels(law: VehicleOnTrack, q: Array, q_t: Array) -> dict[str, Array]:
    """How fast the wheels of every axle turn against each other, and the twist of axles that have a stiffness
    (samples, wheelsets); nothing where they are rigid."""
    twists = np.zeros((2, len(q), len(law.vehicle.wheelsets)))
    for i, coordinate in law.twists.items():
        torsion = law.vehicle.wheelsets[i].wheelset.torsion
        twists[0, :, i] = q_t[:, coordinate]
        twists[1, :, i] = 0.0 if torsion is None or torsion.independent else q[:, coordinate]
    return {"spin_difference": twists[0], "axle_twist": twists[1]}


def deck_channels(law: VehicleOnTrack, q: Array, accelerations: Array) -> dict[str, Array]:
    """Deflection, bending moment where it is known, and acceleration of a bridge in the middle of its spans (samples,
    spans), downward, as the deck sags, and up; accelerations: of its modes (samples, modes)."""
    deck = law.deck
    if deck is None:
        return {}
    eta = q[:, law.of_deck]
    channels = {"deck_deflection": -eta @ deck.values.T, "deck_acceleration": accelerations @ deck.values.T}
    if deck.moments is not None:
        channels["deck_moment"] = eta @ deck.moments.T
    return channels


AXLE_POINTS = 41  # at which the shape of an axle is given


def bent_channels(
    law: VehicleOnTrack, motion: Motion, channels: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, float | str]]:
    """The shapes of rails on sleepers or of a bridge and of elastic axles at the instant of the largest vertical force
    of a wheel, of all steps on sleepers, else of the samples with these channels; and that wheel and its place as
    attributes. Nothing where nothing bends."""
    vehicle, rails, deck = law.vehicle, law.on_sleepers, law.deck
    deflections: dict[str, Any] = {}
    axles = {i: modes for i, modes in law.attachments.modes.items() if isinstance(modes, AxleModes)}
    if not (rails or deck or axles):
        return {}, {}
    if rails is not None and rails.peak[0] > 0.0:
        (_, number, place), q = rails.peak[:3], rails.peak[3 : 3 + law.size]
        nodes, left, right = rails.peak[3 + law.size :].reshape(3, -1)
        deflections |= {"bent_place": nodes, "bent_rail": np.stack([left, right], axis=1)}
    else:
        each = ((begin, int(np.argmax(part)), part) for begin, part in parts_of(channels["Q"]))
        largest = ((part.flat[index], begin, *divmod(index, part[0].size)) for begin, index, part in each)
        _, begin, row, number = max(largest, key=itemgetter(0))
        place, q = np.asarray(channels["wheelset_distance"][begin + row])[number // 2], motion.q[begin + row]
    if deck is not None and rails is None:
        down = deck.shapes[..., 0] @ q[law.of_deck]
        along = deck.start + deck.step * np.arange(len(down))
        deflections |= {"bent_place": along, "bent_rail": np.stack([down, down], axis=1)}
    bent = np.full((3, len(vehicle.wheelsets), AXLE_POINTS), np.nan)
    for i, modes in axles.items():
        y = np.linspace(modes.nodes[0], modes.nodes[-1], AXLE_POINTS)
        moved = np.tensordot(q[law.modes_of(i)], modes.shapes(np.stack([0.0 * y, y, 0.0 * y], axis=1)), 1)
        bent[:, i] = y, moved[:, 0], moved[:, 2]
    if axles:
        deflections |= dict(zip(("bent_axle_y", "bent_axle_x", "bent_axle_z"), bent, strict=True))
    if not deflections:  # of rails whose run was cut off nothing is known
        return {}, {}
    wheelset, side = divmod(int(number), 2)
    return deflections, {"bent_by": f"{vehicle.wheelsets[wheelset].name} {SIDES[side]}", "bent_at_m": float(place)}


def guide_channels(law: VehicleOnTrack, times: Array, records: Array) -> dict[str, Array]:
    """What the track frame and the guide frame do to each wheelset by their springs and dampers, (samples, wheelsets).

    Forces forward and to the left along the axes of the track, moment about its normal at the axle's middle. records:
    forces of all elements (samples, elements, 6). Empty where no frame holds a wheelset.
    """
    vehicle = law.vehicle
    wheelsets = {mounted.name for mounted in vehicle.wheelsets}
    if not any(e.first in (TRACK, GUIDE) and e.second in wheelsets for e in vehicle.elements):
        return {}
    attack = -vehicle.guide_ahead * law.track.curvature(law.start + law.profile.way(times))
    forces = np.zeros((3, len(times), len(vehicle.wheelsets)))
    for record, element in zip(np.moveaxis(records, 1, 0), vehicle.elements, strict=True):
        if element.first not in (TRACK, GUIDE) or element.second not in wheelsets:
            continue
        w = vehicle.index(element.second)
        x, y, _ = np.array(element.points[1]) - vehicle.parts[w].centre
        fx, fy, _ = element.force_on_second(record).T
        moment = x * fy - y * fx
        if element.first == GUIDE:
            c, s = np.cos(attack), np.sin(attack)
            fx, fy = c * fx - s * fy, s * fx + c * fy
        forces[:, :, w] += fx, fy, moment
    return dict(zip(("guide_force_x", "guide_force_y", "guide_moment"), forces, strict=True))


def track_channels(track: Track, distance: Array, rails: Array) -> dict[str, Array]:
    """Curvature, cant, gauge, grade (n,) at distances [m], and irregularities (n, 2) of the rails of uneven track, of
    which ``rails`` holds both."""
    channels = {
        "curvature": track.curvature(distance),
        "cant": track.cant(distance),
        "gauge": track.gauge(distance),
        "grade": track.grade(distance),
    }
    if track.is_uneven:
        left, up = np.moveaxis(rails, -1, 0)
        channels |= {"rail_lateral": left, "rail_vertical": up}
    return channels


def uneven(track: Track, distance: Array) -> Array:
    """Irregularities under the left and the right wheel, to the left and up (n, 2, 2) [m]."""
    return np.stack([np.stack(track.irregularity(side, distance), axis=-1) for side in SIDES], axis=1)


Z = COORDINATES.index("z")


def energy_channels(law: VehicleOnTrack, q: Array, q_t: Array) -> dict[str, Array]:
    """Kinetic energy of all bodies with their modes, axle boxes and geared motors, and m g z of all bodies, with the
    vehicles of a train that move along the track alone, (samples,) [J]."""
    vehicle, n = law.vehicle, 6 * len(law.bodies)
    mass = np.array([body.mass for body in law.bodies])
    kinetic = np.zeros(len(q))
    kinetic_energies(q, q_t, inertia_table(law.bodies), len(vehicle.wheelsets), kinetic)
    first = law.size - law.positions
    for j, (_, box) in enumerate(vehicle.boxes.values()):
        kinetic += 0.5 * box.inertia[1] * q_t[:, first + j] ** 2
    kinetic += 0.5 * q_t[:, law.wagons] ** 2 @ (1.0 / law.masses)
    for drive, place in zip(vehicle.drives, law.gears.values(), strict=True):
        kinetic += 0.5 * drive.inertia * q_t[:, place + 1] ** 2
    for wheelset, twist in law.twists.items():
        kinetic += 0.125 * law.bodies[wheelset].inertia[1] * q_t[:, twist] ** 2
    for part, modes in law.attachments.modes.items():
        kinetic += 0.5 * q_t[:, law.modes_of(part)] ** 2 @ modes.masses
    heights = [_Moved(law, q, name).position[:, 2] for name in vehicle.wagons]
    potential = q[:, Z:n:6] @ mass + law.masses @ np.reshape(heights, (-1, len(q)))
    return {"kinetic_energy": kinetic, "potential_energy": vehicle.gravity * potential}


def power_channels(law: VehicleOnTrack, q_t: Array, known: SampledForces, n: int) -> dict[str, Array]:
    """Power that creep takes; that dampers and friction of the suspension and of axles take, and brakes, resistance and
    gears of vehicles along the track alone; and that of the pull along the track (samples,) [W], of the first n samples
    that are known; q_t: their rates."""
    creep, pull = np.zeros(n), np.zeros(n)
    for i in range(2 * len(law.wheels)):
        creep += known.of(f"total {i}", n)["wear"][:, 0] * known.of(f"pose {i}", n)[:, 6]
    speeds = q_t[:, law.wagons] / law.masses
    dampers = known.of("loss", n).sum(axis=1) + known.of("axle", n)["loss"].sum(axis=1)
    if speeds.size:
        dampers += known.of("wagon", n).sum(axis=1)
    for wheelset, twist in law.twists.items():
        torsion = law.vehicle.wheelsets[wheelset].wheelset.torsion
        dampers += 0.0 if torsion is None else torsion.damping * q_t[:, twist] ** 2
    for part, modes in law.attachments.modes.items():
        rates = 4.0 * np.pi * modes.frequencies * modes.damping * modes.masses
        dampers += q_t[:, law.modes_of(part)] ** 2 @ rates
    if law.drive == "train":
        for force, unit in zip(known.of("unit", n)["force"].T, law.vehicle.pulled, strict=True):
            alone = unit.reference - len(law.bodies) - vehicle_forces.FRAMES - len(law.vehicle.boxes)
            ways = q_t[:, 6 * unit.reference : 6 * unit.reference + 3] if unit.parts else speeds[:, [alone]]
            pull += force * np.linalg.norm(ways, axis=1)
    return {"creep_power": creep, "damper_power": dampers, "pull_power": pull}


def coupling_channels(law: VehicleOnTrack, q: Array, records: Array) -> dict[str, Array]:
    """Forces of the couplings and how the ends of their vehicles lie to each other, each (samples, couplings).

    q: states (samples, .); records: readings of all elements (samples, elements, 6), those between vehicles that move
    along the track alone behind the others. Forward, left and up are those in the middle between both bodies, but for
    the lateral forces: each is along the left of the body that it acts on.
    """
    vehicle = law.vehicle
    names = ("force", "fy_ahead", "fy_behind", "fz", "extension", "offset", "yaw")
    channels = {f"coupling_{name}": np.zeros((len(q), len(vehicle.couplings))) for name in names}
    elements = (*vehicle.elements, *vehicle.chain)
    numbers = {element.name: i for i, element in enumerate(elements)}
    for c, coupling in enumerate(vehicle.couplings):
        ahead, behind = _Moved(law, q, coupling.ahead), _Moved(law, q, coupling.behind)
        force = np.zeros((len(q), 3))  # on the vehicle behind
        for i in (numbers[name] for name in coupling.elements):
            element = elements[i]
            if not element.turns_with_first:  # along its line
                line = behind.point(element.points[1]) - ahead.point(element.points[0])
                force -= records[:, i, :1] * line / np.linalg.norm(line, axis=1, keepdims=True)
            else:
                force += np.einsum("nk,nkj->nj", records[:, i, :3], ahead.axes)
        middle = ahead.axes + behind.axes
        forward, left, up = np.moveaxis(middle / np.linalg.norm(middle, axis=2, keepdims=True), 1, 0)
        apart = ahead.point(coupling.at) - behind.point(coupling.at)
        turned = np.cross(behind.axes[:, 0], ahead.axes[:, 0])
        values = (
            _along(force, forward), -_along(force, ahead.axes[:, 1]), _along(force, behind.axes[:, 1]),
            _along(force, up), _along(apart, forward), _along(apart, left), np.arcsin(_along(turned, up)),
        )  # fmt: skip
        for name, value in zip(names, values, strict=True):
            channels[f"coupling_{name}"][:, c] = value
    return channels


class _Moved:
    """A body in sampled states: its axes, see `body_axes`, and where it is."""

    def __init__(self, law: VehicleOnTrack, q: Array, name: str) -> None:
        i = law.vehicle.index(name)
        self.centre = np.array(law.vehicle.place(name))
        if name in law.vehicle.wagons:
            k, n, moved = list(law.vehicle.wagons).index(name), len(q), np.zeros(len(q), BODY)
            samples = np.repeat(law.workspace.views[vehicle_forces.WAGONS][k], n)  # one after the other, as if wagons
            samples["coordinate"] = np.arange(n)
            place_wagons(q[:, law.wagons[k]].copy(), np.zeros(n), samples, law.track.centre.curve, moved, 0)
            vectors = moved.view(np.float64).reshape(len(q), 6, 3)
            self.position, self.axes = vectors[:, 0], vectors[:, 2:5]
            return
        coordinates = q[:, 6 * i : 6 * i + 6]
        self.position, self.axes = coordinates[:, [1, 2, 0]], body_axes(coordinates)

    def point(self, place: tuple[float, float, float]) -> Array:
        """Where a point of the design position has moved to, (samples, 3)."""
        return np.asarray(self.position + np.einsum("k,nkj->nj", np.array(place) - self.centre, self.axes))


def _along(vectors: Array, direction: Array) -> Array:
    return np.asarray(np.einsum("nj,nj->n", vectors, direction))
