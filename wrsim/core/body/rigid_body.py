"""A rigid body that does not spin for long: orientation with pitch, mass matrix, quadratic velocity forces.

The coordinates are those of ``core.body.kinematics``: heading about the vertical, then roll about the heading
direction, then pitch about the body's lateral axis, in the place of a wheelset's spin. In body axes (principal axes x
forward, y left, z up) the angular velocity is omega = G (heading_t, roll_t, pitch_t) with

    G = | -cos(roll) sin(pitch)   cos(pitch)   0 |
        |  sin(roll)              0            1 |
        |  cos(roll) cos(pitch)   sin(pitch)   0 |

so the rotational block of the mass matrix is G^T I G, and what a motion without angular acceleration of the coordinates
takes is G^T (I G_t theta_t + omega x I omega).
"""

from math import cos, sin

from wrsim.core.body.kinematics import HEADING, ROLL, SPIN, X, Y, Z
from wrsim.core.jit.arena import Array, Records, record
from wrsim.core.jit.compiling import inlined, kernel
from wrsim.core.linalg import BodyMotion, Vec, dot, mixed

PITCH = SPIN

INERTIA = record("mass xx yy zz")
"""Mass [kg] and principal inertia [kg m2] of a body."""


@inlined
def pitched(body: BodyMotion, pitch: float) -> BodyMotion:
    """A body whose axes are turned by the pitch; those of ``core.body.kinematics`` do not know the third angle."""
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
    """Kinetic energy (samples,) [J] of all bodies at states (samples, 6 n or more).

    inertia: (n,) records INERTIA; wheelsets: bodies before this number have axes that do not spin with them.
    """
    for i in range(q.shape[0]):
        twice = 0.0
        for k in range(inertia.shape[0]):
            own = q[i, 6 * k : 6 * k + 6]
            rates = q_t[i, 6 * k : 6 * k + 6]
            about = inertia[k]
            w = turning(own[ROLL], own[PITCH] if k >= wheelsets else 0.0, rates)
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
def rates_of(q: Array, omega: Vec, q_t: Array) -> None:
    """Write the rates of the three angles of a body that turns with a global angular velocity [rad/s] to q_t.

    Of a wheelset the third rate is the one that its spin adds to.
    """
    sa, ca = sin(q[HEADING]), cos(q[HEADING])
    sb, cb = sin(q[ROLL]), cos(q[ROLL])
    about_axle = dot(omega, Vec(-sa * cb, ca * cb, sb))
    heading_t = (omega.z - about_axle * sb) / (cb * cb)
    q_t[HEADING] = heading_t
    q_t[ROLL] = omega.x * ca + omega.y * sa
    q_t[SPIN] = about_axle - heading_t * sb
