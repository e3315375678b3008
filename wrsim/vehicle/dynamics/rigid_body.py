"""Rigid bodies: orientation with pitch, mass matrix, quadratic velocity forces, axle boxes, steady motion.

Coordinates as in ``dynamics.kinematics``: heading, roll, then pitch about the body's lateral axis, in the place of a
wheelset's spin. In body axes (principal axes x forward, y left, z up) the angular velocity is omega = G (heading_t,
roll_t, pitch_t) with

    G = | -cos(roll) sin(pitch)   cos(pitch)   0 |
        |  sin(roll)              0            1 |
        |  cos(roll) cos(pitch)   sin(pitch)   0 |

so the rotational block of the mass matrix is G^T I G, and what a motion without angular acceleration of the coordinates
takes is G^T (I G_t theta_t + omega x I omega).

Axle boxes turn freely about the axle of their wheelset, as the arms of a primary suspension do. A box sits on the axle
at the lateral place y; its one coordinate is its pitch a about the axle. It moves with the wheelset but for the spin.
What suspension elements do to it, the force F and the moment M at its middle on the axle, goes to the wheelset but for
the part of M along the axle e, which turns the box:

    wheelset: F,  y e x F + M - (M.e) e;      box: I (a_t + heading_t sin(roll))_t = M.e

with the box's inertia I about the axle; heading_t sin(roll), which changes with the track alone, is left out of the
acceleration. The bearing has no friction. Mass and the other inertias of the box count among those of the wheelset: its
centre lies on the axle. What lies further out on an arm is to be shared between axle and frame by the lever.

In steady motion along a track all bodies turn together about the axis of the curve, poses held. At the place of the
reference body the track frame moves at V t and turns at w = V (rotation per metre). A body at r then moves at v = V t +
w x (r - r_0), turns at w (a wheelset in addition about its axle), and takes the force m w x v and the moment w x L.
How fast w itself changes in a transition is left out.
"""

from math import cos, sin

from wrsim.jit import Array, Record, Records, inlined, kernel, record
from wrsim.jit.frames import BodyMotion, CurveNodes, accumulate, point_velocity, vec
from wrsim.jit.linalg import Vec, add, components, cross, dot, from_components, mixed, scale, shifted, sub
from wrsim.track.path_kernel import frame_at, frame_rates, locate
from wrsim.vehicle.dynamics.kinematics import HEADING, ROLL, SPIN, X, Y, Z, add_generalised_forces, kinematics

PITCH = SPIN

INERTIA = record("""
    mass [kg]    mass
    xx   [kg m2] principal inertia about the axis forward, ...
    yy   [kg m2] ... to the left ...
    zz   [kg m2] ... and up
""")

AXLE_BOX = record("""
    inertia    [kg m2] inertia about the axle
    lateral    [m]     place on the axle
    wheelset   [int]   number of the wheelset
    coordinate [int]   number of the pitch among the coordinates
""")


@inlined
def pitched(body: BodyMotion, pitch: float) -> BodyMotion:
    """A body whose axes are turned by the pitch; those of ``dynamics.kinematics`` do not know the third angle."""
    c = cos(pitch)
    s = sin(pitch)
    forward = mixed(c, body.forward, -s, body.up)
    up = mixed(s, body.forward, c, body.up)
    return BodyMotion(body.position, body.velocity, forward, body.left, up, body.omega)


@inlined
def turning(roll: float, pitch: float, rates: Array) -> Vec:
    """Angular velocity in body axes [rad/s] at a roll and a pitch [rad] with the rates (6,) of the coordinates."""
    sr, cr = sin(roll), cos(roll)
    sp, cp = sin(pitch), cos(pitch)
    h, r, p = rates[HEADING], rates[ROLL], rates[PITCH]
    return Vec(r * cp - h * cr * sp, h * sr + p, r * sp + h * cr * cp)


@kernel
def kinetic_energies(q: Array, q_t: Array, inertia: Records, wheelsets: int, out: Array) -> None:
    """Kinetic energy (samples,) [J] of all bodies at states (samples, 6 n or more). inertia: (n,) records INERTIA;
    wheelsets: bodies before this number have axes that do not spin with them."""
    for i in range(q.shape[0]):
        twice = 0.0
        for k in range(inertia.shape[0]):
            coordinates = q[i, 6 * k : 6 * k + 6]
            rates = q_t[i, 6 * k : 6 * k + 6]
            about = inertia[k]
            w = turning(coordinates[ROLL], coordinates[PITCH] if k >= wheelsets else 0.0, rates)
            twice += about.mass * (rates[X] * rates[X] + rates[Y] * rates[Y] + rates[Z] * rates[Z])
            twice += about.xx * w.x * w.x + about.yy * w.y * w.y + about.zz * w.z * w.z
        out[i] = 0.5 * twice


@kernel
def mass_block(q: Array, mass: float, ixx: float, iyy: float, izz: float, out: Array) -> None:
    """Mass matrix (6, 6) of one body at its coordinates q (6,); mass [kg], principal inertia [kg m2]."""
    out[:] = 0.0
    for i in range(3):
        out[i, i] = mass
    sr, cr = sin(q[ROLL]), cos(q[ROLL])
    sp, cp = sin(q[PITCH]), cos(q[PITCH])
    out[HEADING, HEADING] = ixx * cr * cr * sp * sp + iyy * sr * sr + izz * cr * cr * cp * cp
    out[ROLL, ROLL] = ixx * cp * cp + izz * sp * sp
    out[PITCH, PITCH] = iyy
    out[HEADING, ROLL] = out[ROLL, HEADING] = (izz - ixx) * cr * sp * cp
    out[HEADING, PITCH] = out[PITCH, HEADING] = iyy * sr


@kernel
def quadratic_forces(q: Array, q_t: Array, ixx: float, iyy: float, izz: float, out: Array) -> None:
    """Quadratic velocity forces (6,): the generalised forces of a motion whose coordinates do not accelerate."""
    sr, cr = sin(q[ROLL]), cos(q[ROLL])
    sp, cp = sin(q[PITCH]), cos(q[PITCH])
    h, r, p = q_t[HEADING], q_t[ROLL], q_t[PITCH]
    w = turning(q[ROLL], q[PITCH], q_t)
    # G_t theta_t
    b = Vec(
        h * (sr * sp * r - cr * cp * p) - r * sp * p,
        h * cr * r,
        -h * (sr * cp * r + cr * sp * p) + r * cp * p,
    )
    m = Vec(
        ixx * b.x + (izz - iyy) * w.y * w.z,
        iyy * b.y + (ixx - izz) * w.z * w.x,
        izz * b.z + (iyy - ixx) * w.x * w.y,
    )
    out[:] = 0.0
    out[HEADING] = -cr * sp * m.x + sr * m.y + cr * cp * m.z
    out[ROLL] = cp * m.x + sp * m.z
    out[PITCH] = m.y


@kernel
def equations_of_motion(q: Array, q_t: Array, inertia: Records, blocks: Array, quadratic: Array) -> None:
    """Mass matrices (n, bodies, 6, 6) of all bodies at states (n, size) and their quadratic velocity forces (n, bodies,
    6). inertia: (bodies,) records INERTIA."""
    for i in range(q.shape[0]):
        for k in range(inertia.shape[0]):
            first, about = 6 * k, inertia[k]
            coordinates, rates = q[i, first : first + 6], q_t[i, first : first + 6]
            mass_block(coordinates, about.mass, about.xx, about.yy, about.zz, blocks[i, k])
            quadratic_forces(coordinates, rates, about.xx, about.yy, about.zz, quadratic[i, k])


@kernel
def rates_of(q: Array, omega: Vec, q_t: Array) -> None:
    """Write the rates of the three angles of a body that turns with a global angular velocity [rad/s] to q_t. Of a
    wheelset the third rate is the one that its spin adds to."""
    sa, ca = sin(q[HEADING]), cos(q[HEADING])
    sb, cb = sin(q[ROLL]), cos(q[ROLL])
    about_axle = dot(omega, Vec(-sa * cb, ca * cb, sb))
    heading_t = (omega.z - about_axle * sb) / (cb * cb)
    q_t[HEADING] = heading_t
    q_t[ROLL] = omega.x * ca + omega.y * sa
    q_t[SPIN] = about_axle - heading_t * sb


@kernel
def on_axle(box: Record, wheelset: BodyMotion, pitch: float, rate: float) -> BodyMotion:
    """The box as a body; wheelset: a body that does not spin; pitch [rad] and its rate."""
    arm = scale(box.lateral, wheelset.left)
    middle = add(wheelset.position, arm)
    turning = shifted(wheelset.omega, rate, wheelset.left)
    whole = BodyMotion(middle, point_velocity(wheelset, middle), wheelset.forward, wheelset.left, wheelset.up, turning)
    return pitched(whole, pitch)


@kernel
def hand_over(box: Record, wheelset: BodyMotion, wrench: Record, onto: Record) -> float:
    """Add what acts on the box, but for the moment about the axle, to the wrench ``onto`` of its wheelset. Returns the
    acceleration of its pitch [rad/s2]."""
    force, moment = vec(wrench.force), vec(wrench.moment)
    about = dot(moment, wheelset.left)
    accumulate(onto.force, force)
    accumulate(onto.moment, cross(scale(box.lateral, wheelset.left), force))
    accumulate(onto.moment, shifted(moment, -about, wheelset.left))
    return about / box.inertia


@kernel
def follow_together(
    q: Array, spins: Array, curve: CurveNodes, reference: int, guess: float, speed: float, q_t: Array
) -> tuple[Vec, float, int]:
    """Write the rates of all bodies in steady motion with the poses q.

    spins: angular velocity about its axle of each wheelset [rad/s], beyond that of the turning; wheelsets come first
    among the bodies. reference: body whose place counts; guess [m]: where to look for it.
    q_t: (6 n,) to fill. Returns (angular velocity w [rad/s], distance [m], status of ``locate``).
    """
    coordinates = q[6 * reference : 6 * reference + 6]
    s, status = locate(curve, Vec(coordinates[X], coordinates[Y], coordinates[Z]), guess)
    track = frame_at(curve, s)
    turning, _roll = frame_rates(curve, s)
    omega = scale(speed, turning)
    for k in range(q_t.shape[0] // 6):
        coordinates = q[6 * k : 6 * k + 6]
        rates = q_t[6 * k : 6 * k + 6]
        arm = sub(Vec(coordinates[X], coordinates[Y], coordinates[Z]), track.origin)
        velocity = add(scale(speed, track.t), cross(omega, arm))
        rates[Z], rates[X], rates[Y] = velocity.z, velocity.x, velocity.y
        rates_of(coordinates, omega, rates)
        if k < spins.shape[0]:
            rates[SPIN] += spins[k]
    return omega, s, status


@kernel
def together_inertia(q: Array, q_t: Array, omega: Vec, inertia: Records, wheelsets: int, out: Array) -> None:
    """Generalised forces (6 n,) that the steady motion takes. omega: the turning of all [rad/s]; inertia: (n,) records
    INERTIA; wheelsets: bodies before this number have axes that do not spin with them."""
    out[:] = 0.0
    for k in range(inertia.shape[0]):
        coordinates = q[6 * k : 6 * k + 6]
        body = kinematics(coordinates, q_t[6 * k : 6 * k + 6])
        axes = pitched(body, coordinates[PITCH] if k >= wheelsets else 0.0)
        turn = components(body.omega, axes.forward, axes.left, axes.up)
        about = inertia[k]
        momentum = from_components(
            Vec(about.xx * turn.x, about.yy * turn.y, about.zz * turn.z), axes.forward, axes.left, axes.up
        )
        force = scale(about.mass, cross(omega, body.velocity))
        add_generalised_forces(body, force, cross(omega, momentum), out[6 * k : 6 * k + 6])
