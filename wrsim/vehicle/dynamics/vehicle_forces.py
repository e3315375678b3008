"""All forces on a vehicle in one call: suspension, gravity, loads, drive, and the contacts of all wheelsets.

One workspace (jit.arena): the arrays named below, then those of each wheel as in ``dynamics.wheel_forces``,
wheelset after wheelset. The coordinates are, in this order:

- six a body as in ``dynamics.kinematics``, with pitch in the place of spin for bodies that are no wheelset;
- one for every damper in series with a spring and every unknown of a slider or of a geared motor (dynamics.loads): its
  rate is the unknown, its "force" the rate of that, on a mass of 1; the coordinate itself means nothing;
- the pitch of every axle box (dynamics.rigid_body), on an inertia of 1;
- mass times way of every vehicle of a train that moves along the track alone (dynamics.wagons);
- the twist of every axle whose wheels may turn against each other: theta_t is the spin of the left wheel less that of
  the right one. With half of the wheelset's inertia J about the axle at each of them and the moments M about the axle
  of what acts on left and right wheel

      J/4 theta_tt = (M_left - M_right)/2 - k theta - c theta_t,

  while the body's spin is the mean of both and takes their sum. Without stiffness and damping the wheels are
  independent. The spin counts about the axle itself, heading_t sin(roll) and all, so that nothing is left out; also
  gyroscopic moments know the sum alone;
- the elastic modes of bodies and axles (dynamics.flexible), and of a bridge (dynamics.deck);
- on elastic rails the displacements of the rail under every wheel, moving along with it: left rail along n and b, right
  rail along n and b, wheelset after wheelset. The wheel meets the rail where it has moved to, with the velocity that is
  left between them. Either a piece of rail moves along,

      m u_tt + c u_t + k u = force of the wheel on the rail along n or b,

  written with a mass of 1 (its "force" is the acceleration), and the pieces of two wheels do not act on each other. Or
  it lies on sleepers, and its "force" leads to the displacement that ``dynamics.sleepers`` foretells for the wheel's
  force at the end of the step.

Two frames follow the last body, and behind these the axle boxes, the vehicles that move along the track alone and the
attachments of elastic bodies; springs may be fixed to all of them. The track frame
follows the centre line at the run's speed (`motion_at`): it is evaluated, not integrated. The guide frame is the bogie
that the vehicle's wheelset leads: it goes with the track frame, but lies along the chord of a curve, turned about b by
-a kappa for an axle at a distance a ahead of the bogie's centre. Its springs turn with it; how fast the angle changes
in a transition is left out of its velocity.
"""

from math import cos, hypot, sin

from wrsim.jit import Array, Ints, Record, Records, block, kernel, matrix, record, records, stages
from wrsim.jit.frames import BODY, BodyMotion, CurveNodes, get_body, put, put_body, vec
from wrsim.jit.linalg import ZERO, Vec, add, cross, dot, mixed, scale, shifted, sub
from wrsim.jit.root import neighbours
from wrsim.track.path_kernel import NODE, frame_at, frame_rates
from wrsim.vehicle.dynamics import loads
from wrsim.vehicle.dynamics.deck import DECK, deck_motion, push_deck
from wrsim.vehicle.dynamics.flexible import (
    ATTACHMENT,
    MODE,
    at_wheel,
    attached,
    deform,
    hand_over_forces,
    push_modes,
    vibrate,
    wheel_on_axle,
)
from wrsim.vehicle.dynamics.kinematics import SPIN, add_generalised_forces, kinematics
from wrsim.vehicle.dynamics.rigid_body import AXLE_BOX, PITCH, hand_over, on_axle, pitched
from wrsim.vehicle.dynamics.suspension import ELEMENT, READING, WRENCH, Suspension, suspension_forces
from wrsim.vehicle.dynamics.wagons import WAGON, add_forces_on_wagons, place_wagons
from wrsim.vehicle.dynamics.wheel_forces import ARRAYS, OFF_TRACK, place_on_rail, wheel_record, wheel_total

# arrays before those of the wheels
(
    WHOLE, PARTS, BODIES, WRENCHES, ELEMENTS, TABLES, READINGS, LOADS, LOAD_TABLES, CARRIED_MASSES, AXLES, CENTRE,
    AXLE_BOXES, MOTION, EFFORTS, EFFORT_TABLES, UNITS, MODES, ATTACHMENTS, SHAPES, GYROSCOPIC, DECKS,
    DECK_SHAPES, WAGONS, BRAKE_STEPS,
) = range(25)  # fmt: skip
FIRST_WHEEL = 25

RAIL = record("""
    mass      [kg]    mass
    stiffness [N/m]   stiffness
    damping   [N s/m] damping
""")
"""A piece of rail under a wheel, in one direction."""

VEHICLE = record(
    """
    gravity       [m/s2] acceleration of gravity
    step          [m]    step of the centre line
    guide_ahead   [m]    distance of the axle in the guide frame ahead of the bogie's centre
    slip_speed    [m/s]  limit of the slip control, 0 without
    slip_creepage [1]    growth of that limit with the speed, 0 without
    drive         [int]  kind of drive
    rails         [int]  number of the rails' first coordinate, -1 on rigid ones
    sleepers      [int]  1: the rails lie on sleepers
    turns         [int]  stage that evaluates all wheels
    relaxed       [int]  1: geared motors have come to rest
    rail_n        [-]    piece of rail under a wheel, along n
    rail_b        [-]    piece of rail along b
    """,
    rail_n=RAIL,
    rail_b=RAIL,
)
"""A vehicle or train on its track."""

PART = record("""
    mass            [kg]        mass
    twist_inertia   [kg m2]     inertia of the twist of the axle
    twist_stiffness [N m/rad]   stiffness of the twist
    twist_damping   [N m s/rad] damping of the twist
    wheelset        [int]       number of the wheelset, or -1
    twist           [int]       number of the twist among the coordinates, or -1
    wheels          [int]       number of the left wheel's attachment on an elastic axle (the right one follows), or -1
""")
"""A body of the vehicle."""

PIECE = record("""
    time         [s]    beginning
    distance     [m]    distance along the centre line there
    speed        [m/s]  speed there
    acceleration [m/s2] acceleration in the piece
""")
"""A piece of the run's motion."""

FRAMES = 2  # behind the bodies: track frame, guide frame
RAIL_COORDINATES = 4  # of a wheelset


@kernel
def vehicle_forces(t: float, q: Array, q_t: Array, out: Array, buffer: Array, index: Ints) -> int:
    """Generalised forces on a vehicle at time t, (6 n + m,) for n bodies and m coordinates behind theirs. Returns a
    status: 0, or the sum of the contacts' STATUS bits, or OFF_TRACK when a body has no place on the track."""
    out[:] = 0.0
    status = add_forces_on_bodies(t, q, q_t, out, buffer, index)
    return status | add_forces_on_wheels(q, q_t, out, buffer, index)


@kernel
def add_forces_on_bodies(t: float, q: Array, q_t: Array, out: Array, buffer: Array, index: Ints) -> int:
    """Add everything but the contacts; writes the rates of the dampers' extensions. Returns 0 or OFF_TRACK."""
    vehicle = records(buffer, index, WHOLE, VEHICLE)[0]
    parts = records(buffer, index, PARTS, PART)
    bodies = records(buffer, index, BODIES, BODY)
    wrenches = records(buffer, index, WRENCHES, WRENCH)
    centre = CurveNodes(records(buffer, index, CENTRE, NODE), vehicle.step)
    n: int = parts.shape[0]
    for i in range(n):
        body = kinematics(q[6 * i : 6 * i + 6], q_t[6 * i : 6 * i + 6])
        if parts[i].wheelset >= 0:
            put_body(bodies[i], _turned(body, -q_t[6 * i + SPIN]))  # springs see a wheelset that does not spin
        else:
            put_body(bodies[i], pitched(body, q[6 * i + PITCH]))
        put(wrenches[i].force, Vec(0.0, 0.0, -vehicle.gravity * parts[i].mass))
        put(wrenches[i].moment, ZERO)
    s, speed, acceleration = motion_at(t, records(buffer, index, MOTION, PIECE))
    track, guide = _frames(s, speed, vehicle, centre)
    put_body(bodies[n], track)
    put_body(bodies[n + 1], guide)
    boxes = records(buffer, index, AXLE_BOXES, AXLE_BOX)
    modes, attachments = records(buffer, index, MODES, MODE), records(buffer, index, ATTACHMENTS, ATTACHMENT)
    wagons, first_wagon = records(buffer, index, WAGONS, WAGON), n + FRAMES + boxes.shape[0]
    shapes, behind = block(buffer, index, SHAPES), first_wagon + wagons.shape[0]
    place_wagons(q, q_t, wagons, centre, bodies, first_wagon)
    deform(q, q_t, modes, attachments, shapes, bodies, behind)
    for j in range(boxes.shape[0]):
        coordinate, wheelset = boxes[j].coordinate, get_body(bodies[boxes[j].wheelset])
        put_body(bodies[n + FRAMES + j], on_axle(boxes[j], wheelset, q[coordinate], q_t[coordinate]))
    for i in range(n, wrenches.shape[0]):
        put(wrenches[i].force, ZERO)
        put(wrenches[i].moment, ZERO)
    tables, readings = matrix(buffer, index, TABLES), records(buffer, index, READINGS, READING)
    on = Suspension(bodies, tables, q_t[6 * n :], out[6 * n :], wrenches, readings)
    suspension_forces(on, records(buffer, index, ELEMENTS, ELEMENT))
    for j in range(boxes.shape[0]):
        box, w = boxes[j], boxes[j].wheelset
        out[box.coordinate] = hand_over(box, get_body(bodies[w]), wrenches[n + FRAMES + j], wrenches[w])
    vibrate(q, q_t, modes, matrix(buffer, index, GYROSCOPIC), bodies, wrenches, out)
    hand_over_forces(modes, attachments, shapes, bodies, wrenches, behind, out)
    loads.add_carried(track, records(buffer, index, CARRIED_MASSES, loads.CARRIED), vehicle.gravity, wrenches)
    load_records, load_tables = records(buffer, index, LOADS, loads.LOAD), matrix(buffer, index, LOAD_TABLES)
    lost = loads.add_loads(t, bodies, load_records, load_tables, centre, wrenches)
    axles, units = records(buffer, index, AXLES, loads.AXLE), records(buffer, index, UNITS, loads.UNIT)
    reference = loads.ReferenceMotion(s, speed, acceleration)
    lost |= loads.add_drive(reference, vehicle.drive, units, bodies, axles, centre, wrenches)
    efforts = loads.Efforts(records(buffer, index, EFFORTS, loads.EFFORT), matrix(buffer, index, EFFORT_TABLES))
    steps = matrix(buffer, index, BRAKE_STEPS)
    add_forces_on_wagons(t, q_t, vehicle.gravity, wagons, steps, wrenches, first_wagon, out)
    origin = units[0].s - units[0].ahead
    loads.add_efforts(t, q_t, vehicle, origin, parts, bodies, efforts, axles, wrenches, out)
    for j in range(axles.shape[0]):
        part = parts[axles[j].body]
        if part.twist >= 0:
            held = part.twist_stiffness * q[part.twist] + part.twist_damping * q_t[part.twist]
            out[part.twist] = (axles[j].twisting - held) / part.twist_inertia
    for i in range(n):
        body = kinematics(q[6 * i : 6 * i + 6], q_t[6 * i : 6 * i + 6])
        force, moment = vec(wrenches[i].force), vec(wrenches[i].moment)
        add_generalised_forces(body, force, moment, out[6 * i : 6 * i + 6])
    return OFF_TRACK if lost else 0


@kernel
def add_forces_on_wheels(q: Array, q_t: Array, out: Array, buffer: Array, index: Ints) -> int:
    """Add the contacts of all wheelsets, and on elastic rails write the accelerations of the pieces under the wheels.
    Those of a wheelset depend on its own coordinates and those of the twist and of the rails under it alone. Returns a
    status."""
    vehicle = records(buffer, index, WHOLE, VEHICLE)[0]
    parts = records(buffer, index, PARTS, PART)
    wheel_arrays = index[FIRST_WHEEL:]
    modes, attachments = records(buffer, index, MODES, MODE), records(buffer, index, ATTACHMENTS, ATTACHMENT)
    shapes = block(buffer, index, SHAPES)
    decks, deck_shapes = records(buffer, index, DECKS, DECK), matrix(buffer, index, DECK_SHAPES)
    wheels = wheel_arrays.shape[0] // ARRAYS
    place_wheels(q, q_t, buffer, index)
    stages.run(vehicle.turns, buffer, wheel_arrays)
    status = 0
    for i in range(parts.shape[0]):
        first = 2 * parts[i].wheelset
        if first < 0 or first >= wheels:
            continue
        left, right = wheel_record(buffer, wheel_arrays, first), wheel_record(buffer, wheel_arrays, first + 1)
        status |= left.status | right.status
        of_body = out[6 * i : 6 * i + 6]
        if parts[i].wheels >= 0:
            body = kinematics(q[6 * i : 6 * i + 6], q_t[6 * i : 6 * i + 6])
            for k in range(first, first + 2):
                wheel, j = wheel_record(buffer, wheel_arrays, k), parts[i].wheels + k - first
                disc, force = get_body(wheel.body), vec(wheel.force)
                place, moment = at_wheel(disc, wheel.side * wheel.half_spacing, force, vec(wheel.moment))
                turn = add(moment, cross(sub(place, body.position), force))
                add_generalised_forces(body, force, turn, of_body)
                of_body[SPIN] += dot(moment, disc.left) - dot(turn, body.left)  # it spins about its own axis
                push_modes(j, body, force, moment, modes, attachments, shapes, out)
        else:
            push, turn = add(vec(left.force), vec(right.force)), add(vec(left.moment), vec(right.moment))
            add_generalised_forces(get_body(left.body), push, turn, of_body)
        if parts[i].twist >= 0:
            axis_left, axis_right = vec(left.body.left), vec(right.body.left)
            apart = dot(vec(left.moment), axis_left) - dot(vec(right.moment), axis_right)
            out[parts[i].twist] += 0.5 * apart / parts[i].twist_inertia
        if decks.shape[0] > 0:
            push_deck(left.s, -wheel_total(buffer, wheel_arrays, first).Fb, decks[0], deck_shapes, modes, out)
            push_deck(right.s, -wheel_total(buffer, wheel_arrays, first + 1).Fb, decks[0], deck_shapes, modes, out)
        if vehicle.rails >= 0:
            for k in range(first, first + 2):
                rail, total = vehicle.rails + 2 * k, wheel_total(buffer, wheel_arrays, k)
                wheel = wheel_record(buffer, wheel_arrays, k)
                push_n, push_b = -wheel.side * total.Fo, -total.Fb
                if vehicle.sleepers != 0:
                    n = wheel.yield_nn * push_n + wheel.yield_nb * push_b + wheel.free_n
                    b = wheel.yield_nb * push_n + wheel.yield_bb * push_b + wheel.free_b
                    out[rail] = wheel.rate_n * (n - wheel.held_n * q[rail])
                    out[rail + 1] = wheel.rate_b * (b - wheel.held_b * q[rail + 1])
                else:
                    out[rail] = _rail_acceleration(vehicle.rail_n, push_n, q[rail], q_t[rail])
                    out[rail + 1] = _rail_acceleration(vehicle.rail_b, push_b, q[rail + 1], q_t[rail + 1])
    return status


@kernel
def place_wheels(q: Array, q_t: Array, buffer: Array, index: Ints) -> None:
    """Write the motion of every wheel, and of the rail under it, to its record."""
    vehicle = records(buffer, index, WHOLE, VEHICLE)[0]
    parts = records(buffer, index, PARTS, PART)
    wheel_arrays = index[FIRST_WHEEL:]
    modes, attachments = records(buffer, index, MODES, MODE), records(buffer, index, ATTACHMENTS, ATTACHMENT)
    shapes = block(buffer, index, SHAPES)
    decks, deck_shapes = records(buffer, index, DECKS, DECK), matrix(buffer, index, DECK_SHAPES)
    wheels = wheel_arrays.shape[0] // ARRAYS
    for i in range(parts.shape[0]):
        first = 2 * parts[i].wheelset
        if first < 0 or first >= wheels:
            continue
        body = kinematics(q[6 * i : 6 * i + 6], q_t[6 * i : 6 * i + 6])
        twist = parts[i].twist
        ahead = 0.5 * q_t[twist] if twist >= 0 else 0.0
        turned = 0.5 * q[twist] if twist >= 0 else 0.0
        for k in range(first, first + 2):
            wheel = wheel_record(buffer, wheel_arrays, k)
            if parts[i].wheels >= 0:
                spin, j = q_t[6 * i + SPIN], parts[i].wheels + k - first
                seat = attached(_turned(body, -spin), j, q, q_t, modes, attachments, shapes)
                put_body(wheel.body, wheel_on_axle(seat, wheel.side * wheel.half_spacing, spin + wheel.side * ahead))
            else:
                put_body(wheel.body, _turned(body, wheel.side * ahead))
            wheel.angle = q[6 * i + SPIN] + wheel.side * turned
            if vehicle.rails >= 0:
                rail = vehicle.rails + 2 * k
                wheel.rail_n, wheel.rail_b = q[rail], q[rail + 1]
                wheel.rail_n_t, wheel.rail_b_t = q_t[rail], q_t[rail + 1]
            if decks.shape[0] > 0:
                s, speed = place_on_rail(buffer, wheel_arrays, k), hypot(body.velocity.x, body.velocity.y)
                of_deck = deck_motion(s, speed, decks[0], deck_shapes, modes, q, q_t)
                wheel.rail_b, wheel.rail_b_t, wheel.slope_b = of_deck


@kernel
def motion_at(t: float, pieces: Records) -> tuple[float, float, float]:
    """Distance [m], speed [m/s] and acceleration [m/s2] of the track frame at time t. pieces: records PIECE in the
    order of time, each from its beginning to that of the next; the last has no end."""
    low, _high, _part = neighbours(pieces["time"], t)
    piece = pieces[low]
    since = t - piece.time
    speed = piece.speed + piece.acceleration * since
    return piece.distance + since * (piece.speed + 0.5 * piece.acceleration * since), speed, piece.acceleration


@kernel
def _turned(body: BodyMotion, spin: float) -> BodyMotion:
    """A body that turns faster about its axle [rad/s]."""
    omega = shifted(body.omega, spin, body.left)
    return BodyMotion(body.position, body.velocity, body.forward, body.left, body.up, omega)


@kernel
def _frames(s: float, speed: float, vehicle: Record, centre: CurveNodes) -> tuple[BodyMotion, BodyMotion]:
    """The track frame at the distance s [m] and the guide frame, as bodies; speed [m/s]."""
    frame = frame_at(centre, s)
    turning, _roll = frame_rates(centre, s)
    velocity, omega = scale(speed, frame.t), scale(speed, turning)
    attack = -vehicle.guide_ahead * dot(turning, frame.b)
    forward = mixed(cos(attack), frame.t, sin(attack), frame.n)
    left = mixed(cos(attack), frame.n, -sin(attack), frame.t)
    track = BodyMotion(frame.origin, velocity, frame.t, frame.n, frame.b, omega)
    return track, BodyMotion(frame.origin, velocity, forward, left, frame.b, omega)


@kernel
def _rail_acceleration(rail: Record, force: float, u: float, u_t: float) -> float:
    """Acceleration of a piece of rail on its spring and damper."""
    return (force - rail.stiffness * u - rail.damping * u_t) / rail.mass
