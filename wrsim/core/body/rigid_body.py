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

from wrsim.core.compiling import kernel


@kernel
def turned_axes(body, pitch, row):
    """Write position, velocity, axes and angular velocity of a body to ``row`` (18,), its axes turned by the pitch.

    body: 18 numbers of ``core.body.kinematics.kinematics``, whose axes do not know the third angle.
    """
    c = cos(pitch)
    s = sin(pitch)
    for k in range(18):
        row[k] = body[k]
    for k in range(3):
        forward = body[6 + k]
        up = body[12 + k]
        row[6 + k] = c * forward - s * up
        row[12 + k] = s * forward + c * up


@kernel
def mass_block(q, mass, ixx, iyy, izz, out):
    """Mass matrix (6, 6) of one body at its coordinates q (6,); mass [kg], principal inertia [kg m2]."""
    for i in range(6):
        for j in range(6):
            out[i, j] = 0.0
    for i in range(3):
        out[i, i] = mass
    sr, cr = sin(q[4]), cos(q[4])
    sp, cp = sin(q[5]), cos(q[5])
    out[3, 3] = ixx * cr * cr * sp * sp + iyy * sr * sr + izz * cr * cr * cp * cp
    out[4, 4] = ixx * cp * cp + izz * sp * sp
    out[5, 5] = iyy
    out[3, 4] = out[4, 3] = (izz - ixx) * cr * sp * cp
    out[3, 5] = out[5, 3] = iyy * sr


@kernel
def velocity_forces(q, q_t, ixx, iyy, izz, out):
    """Quadratic velocity forces (6,): the generalised forces of a motion whose coordinates do not accelerate."""
    sr, cr = sin(q[4]), cos(q[4])
    sp, cp = sin(q[5]), cos(q[5])
    h, r, p = q_t[3], q_t[4], q_t[5]
    wx = r * cp - h * cr * sp
    wy = h * sr + p
    wz = r * sp + h * cr * cp
    # G_t theta_t
    bx = h * (sr * sp * r - cr * cp * p) - r * sp * p
    by = h * cr * r
    bz = -h * (sr * cp * r + cr * sp * p) + r * cp * p
    mx = ixx * bx + (izz - iyy) * wy * wz
    my = iyy * by + (ixx - izz) * wz * wx
    mz = izz * bz + (iyy - ixx) * wx * wy
    out[0] = out[1] = out[2] = 0.0
    out[3] = -cr * sp * mx + sr * my + cr * cp * mz
    out[4] = cp * mx + sp * mz
    out[5] = my


@kernel
def rates_of(q, wx, wy, wz, q_t):
    """Write the rates of the three angles, q_t[3:6], of a body that turns with a global angular velocity w [rad/s].

    Of a wheelset the third rate is the one that its spin adds to.
    """
    sa, ca = sin(q[3]), cos(q[3])
    sb, cb = sin(q[4]), cos(q[4])
    ax, ay = -sa * cb, ca * cb
    about_axle = wx * ax + wy * ay + wz * sb
    heading_t = (wz - about_axle * sb) / (cb * cb)
    q_t[3] = heading_t
    q_t[4] = wx * ca + wy * sa
    q_t[5] = about_axle - heading_t * sb
