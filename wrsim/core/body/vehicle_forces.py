"""All forces on a vehicle in one call: suspension, gravity, loads, drive, and the contacts of all wheelsets.

One arena (core.arena): first the arrays named below, then those of each wheelset as ``core.body.wheelset_forces``
orders them. Coordinates are six a body as in ``core.body.kinematics`` (pitch in the place of spin for bodies that are
no wheelset), then one for every damper in series with a spring: its rate is the extension of the damping part, so
that its "force" is the rate of that extension, on a mass of 1; the coordinate itself means nothing.

Behind these, on elastic rails, stand the displacements of a piece of rail under every wheel, moving along with it: left
rail along n and b, right rail along n and b, wheelset after wheelset. Each follows

    m u_tt + c u_t + k u = force of the wheel on the rail along n or b,

and is written with a mass of 1 (its "force" is the acceleration). The wheel meets the rail where it has moved to, with
the velocity that is left between them. The pieces of two wheels know nothing of each other.

Two frames stand behind the last body; springs may be fixed to either. The track frame follows the centre line at
constant speed, s(t) = s_0 + V t: it is evaluated, not integrated. The guide frame is the bogie that the vehicle's
wheelset leads: it goes with the track frame, but stands along the chord of a curve, turned about b by -a kappa for an
axle at a distance a ahead of the bogie's centre. Its springs turn with it; how fast the angle changes in a transition
is left out of its velocity.

Carried loads. A mass that follows the track frame without oscillating presses on its body with m (g - a_f), a_f = V^2
dt/ds: the part along t is left to the train that moves it, the other two act at the centre of mass of the body, with
the moment of the lateral part at its height above. The speed at which the cant changes adds no force.

Drive. What holds the vehicle's speed acts like a spring and damper to a point that runs along the track at constant
speed: with the distance s of the reference body and e = s_0 + V t - s, the force is M (w^2 e + 2 w (V - s_t)),
w = ``DRIVE_RATE``, M the mass of the vehicle. Either it pulls the reference body along the track, as the coupler of a
train does, or it comes as equal moments on the axles, with the reaction on the bodies that hold them.
"""

from math import cos, sin

from wrsim.core.arena import matrix, vector
from wrsim.core.body.kinematics import generalised_forces, kinematics
from wrsim.core.body.rigid_body import turned_axes
from wrsim.core.body.suspension import suspension_forces
from wrsim.core.body.wheelset_forces import (
    ARRAYS,
    FORCE,
    LEFT,
    MOMENT,
    OFF_TRACK,
    RAIL_MOTION,
    RAIL_NUMBERS,
    RIGHT,
    SCALARS,
    contact_forces,
)
from wrsim.core.compiling import kernel
from wrsim.core.contact.wheel_rail import results
from wrsim.core.track.path import frame, frame_rates, locate

# arrays of the arena before those of the wheelsets
V_SCALARS, BODIES, STATES, FORCES, MOMENTS, ELEMENTS, TABLES, RECORDS, LOADS, CARRIED, AXLES, PATH = range(12)
FIRST_WHEELSET = 12

# scalars: acceleration of gravity; the track frame's start and speed; mass of the vehicle; drive: kind, reference body,
# what lies between it and the track frame along the track, its distance (a guess, updated); step of the centre line
GRAVITY, START, SPEED, VEHICLE_MASS, DRIVE, REFERENCE, AHEAD, S_REFERENCE, STEP, DRIVE_FORCE = range(10)
# rails under the wheels: first of their coordinates or -1 on rigid ones; mass, stiffness, damping, along n and b each
RAILS, RAIL_MASS, RAIL_STIFFNESS, RAIL_DAMPING = 10, 11, 13, 15
GUIDE_AHEAD = 17  # of the bogie's centre that the guide frame stands for
VEHICLE_SCALARS = 18

FRAMES = 2  # behind the bodies: track frame, guide frame

FREE, TRAIN, WHEELS = 0, 1, 2  # kinds of drive
DRIVE_RATE = 1.0  # [1/s]

# a body: mass, number of its wheelset or -1; a load: body, point in its axes, force along t, n, b of its place;
# a carried load: body, mass, height above its centre; an axle: body, body that takes the reaction or -1, radius
MASS, WHEELSET = 0, 1
LOAD_COLUMNS = 8
RAIL_COORDINATES = 4  # of a wheelset
S_LOAD = 7  # column of a load: its distance, a guess


@kernel
def vehicle_forces(t, q, q_t, out, buffer, index):
    """Generalised forces on a vehicle at time t, (6 n + m,) for n bodies and m dampers in series with springs.

    Returns a status: 0, or the sum of the contacts' STATUS bits, or OFF_TRACK when a body has no place on the track.
    """
    scalars = vector(buffer, index, V_SCALARS)
    bodies = matrix(buffer, index, BODIES)
    states = matrix(buffer, index, STATES)
    force = matrix(buffer, index, FORCES)
    moment = matrix(buffer, index, MOMENTS)
    path = matrix(buffer, index, PATH)
    n = bodies.shape[0]
    out[:] = 0.0
    for i in range(n):
        body = kinematics(q[6 * i : 6 * i + 6], q_t[6 * i : 6 * i + 6])
        if bodies[i, WHEELSET] >= 0.0:
            # seen from its springs a wheelset does not spin
            for k in range(15):
                states[i, k] = body[k]
            spin = q_t[6 * i + 5]
            for k in range(3):
                states[i, 15 + k] = body[15 + k] - spin * body[9 + k]
        else:
            turned_axes(body, q[6 * i + 5], states[i])
        force[i, 0] = force[i, 1] = 0.0
        force[i, 2] = -scalars[GRAVITY] * bodies[i, MASS]
        moment[i, 0] = moment[i, 1] = moment[i, 2] = 0.0
    force[n:, :] = 0.0
    moment[n:, :] = 0.0
    _frames(t, scalars, path, states[n], states[n + 1])
    suspension_forces(
        states,
        matrix(buffer, index, ELEMENTS),
        matrix(buffer, index, TABLES),
        q_t[6 * n :],
        out[6 * n :],
        force,
        moment,
        matrix(buffer, index, RECORDS),
    )
    status = _loads(states, matrix(buffer, index, LOADS), path, scalars[STEP], force, moment)
    _carried(states[n], matrix(buffer, index, CARRIED), scalars[GRAVITY], force, moment)
    status |= _drive(t, states, scalars, matrix(buffer, index, AXLES), path, force, moment)
    size = (index.shape[0] - FIRST_WHEELSET) // ARRAYS
    for i in range(n):
        body = kinematics(q[6 * i : 6 * i + 6], q_t[6 * i : 6 * i + 6])
        w = int(bodies[i, WHEELSET])
        if 0 <= w < size:
            first = FIRST_WHEELSET + w * ARRAYS
            own = index[first : first + ARRAYS]
            total_force = vector(buffer, own, FORCE)
            total_moment = vector(buffer, own, MOMENT)
            for k in range(3):
                total_force[k] = force[i, k]
                total_moment[k] = moment[i, k]
            rails = int(scalars[RAILS])
            if rails >= 0:
                place = rails + RAIL_COORDINATES * w
                _tell_rails(q, q_t, place, vector(buffer, own, SCALARS))
                status |= contact_forces(body, buffer, own)
                _move_rail(q, q_t, place, 1.0, results(buffer, own[LEFT:RIGHT])[0], scalars, out)
                _move_rail(q, q_t, place + 2, -1.0, results(buffer, own[RIGHT:ARRAYS])[0], scalars, out)
            else:
                status |= contact_forces(body, buffer, own)
            generalised_forces(body, total_force, total_moment, out[6 * i : 6 * i + 6])
        else:
            generalised_forces(body, force[i], moment[i], out[6 * i : 6 * i + 6])
    return status


@kernel
def _tell_rails(q, q_t, place, scalars):
    """Write the motion of both rails under a wheelset to its scalars."""
    for side in range(2):
        for k in range(2):
            at = RAIL_MOTION + side * RAIL_NUMBERS + k
            scalars[at] = q[place + 2 * side + k]
            scalars[at + 2] = q_t[place + 2 * side + k]


@kernel
def _move_rail(q, q_t, place, side, total, scalars, out):
    """Accelerations of one rail's piece, along n and b, under the force of its wheel."""
    out[place] = -side * total.Fo
    out[place + 1] = -total.Fb
    for k in range(2):
        i = place + k
        springs = scalars[RAIL_STIFFNESS + k] * q[i] + scalars[RAIL_DAMPING + k] * q_t[i]
        out[i] = (out[i] - springs) / scalars[RAIL_MASS + k]


@kernel
def _frames(t, scalars, path, track, guide):
    """States of the track frame and of the guide frame."""
    speed = scalars[SPEED]
    s = scalars[START] + speed * t
    place = frame(path, scalars[STEP], s)
    wx, wy, wz, _roll = frame_rates(path, scalars[STEP], s)
    for k in range(3):
        track[k] = place[k]
        track[3 + k] = speed * place[3 + k]
        track[6 + k] = place[3 + k]
        track[9 + k] = place[6 + k]
        track[12 + k] = place[9 + k]
    track[15], track[16], track[17] = speed * wx, speed * wy, speed * wz
    attack = -scalars[GUIDE_AHEAD] * (wx * place[9] + wy * place[10] + wz * place[11])
    ca, sa = cos(attack), sin(attack)
    guide[:] = track
    for k in range(3):
        guide[6 + k] = ca * track[6 + k] + sa * track[9 + k]
        guide[9 + k] = ca * track[9 + k] - sa * track[6 + k]


@kernel
def _carried(track, carried, gravity, force, moment):
    """Add what masses that follow the track frame press on their bodies with."""
    # gravity less the acceleration of the frame, omega x v
    gx = track[17] * track[4] - track[16] * track[5]
    gy = track[15] * track[5] - track[17] * track[3]
    gz = track[16] * track[3] - track[15] * track[4] - gravity
    along_n = gx * track[9] + gy * track[10] + gz * track[11]
    along_b = gx * track[12] + gy * track[13] + gz * track[14]
    for j in range(carried.shape[0]):
        i = int(carried[j, 0])
        mass, height = carried[j, 1], carried[j, 2]
        for k in range(3):
            force[i, k] += mass * (along_n * track[9 + k] + along_b * track[12 + k])
            moment[i, k] -= height * mass * along_n * track[6 + k]  # b x n = -t


@kernel
def _loads(states, loads, path, step, force, moment):
    """Add constant forces, along the track's axes where their bodies are; returns a status."""
    for j in range(loads.shape[0]):
        row = loads[j]
        i = int(row[0])
        s, bad = locate(path, step, states[i, 0], states[i, 1], states[i, 2], row[S_LOAD])
        if bad != 0:
            return OFF_TRACK
        row[S_LOAD] = s
        own = frame(path, step, s)
        fx = row[4] * own[3] + row[5] * own[6] + row[6] * own[9]
        fy = row[4] * own[4] + row[5] * own[7] + row[6] * own[10]
        fz = row[4] * own[5] + row[5] * own[8] + row[6] * own[11]
        x = row[1] * states[i, 6] + row[2] * states[i, 9] + row[3] * states[i, 12]
        y = row[1] * states[i, 7] + row[2] * states[i, 10] + row[3] * states[i, 13]
        z = row[1] * states[i, 8] + row[2] * states[i, 11] + row[3] * states[i, 14]
        force[i, 0] += fx
        force[i, 1] += fy
        force[i, 2] += fz
        moment[i, 0] += y * fz - z * fy
        moment[i, 1] += z * fx - x * fz
        moment[i, 2] += x * fy - y * fx
    return 0


@kernel
def _drive(t, states, scalars, axles, path, force, moment):
    """Add what holds the vehicle's speed; returns a status. Keeps the distance of the reference body."""
    i = int(scalars[REFERENCE])
    s, bad = locate(path, scalars[STEP], states[i, 0], states[i, 1], states[i, 2], scalars[S_REFERENCE])
    if bad != 0:
        return OFF_TRACK
    scalars[S_REFERENCE] = s
    kind = int(scalars[DRIVE])
    scalars[DRIVE_FORCE] = 0.0
    if kind == FREE:
        return 0
    own = frame(path, scalars[STEP], s)
    along = states[i, 3] * own[3] + states[i, 4] * own[4] + states[i, 5] * own[5]
    speed = scalars[SPEED]
    behind = scalars[START] + scalars[AHEAD] + speed * t - s
    pull = scalars[VEHICLE_MASS] * DRIVE_RATE * (DRIVE_RATE * behind + 2.0 * (speed - along))
    scalars[DRIVE_FORCE] = pull
    if kind == TRAIN:
        for k in range(3):
            force[i, k] += pull * own[3 + k]
        return 0
    for j in range(axles.shape[0]):
        a = int(axles[j, 0])
        b = int(axles[j, 1])
        torque = pull * axles[j, 2] / axles.shape[0]
        for k in range(3):
            moment[a, k] += torque * states[a, 9 + k]
            if b >= 0:
                moment[b, k] -= torque * states[a, 9 + k]
    return 0
