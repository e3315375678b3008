"""Steady motion of a whole vehicle along a track: all bodies turn together about the axis of the curve, poses held.

At the place of the reference body the track frame moves at V t and turns at w = V (rotation per metre). A body at r
then moves at v = V t + w x (r - r_0), turns at w (a wheelset in addition about its axle), and takes the force m w x v
and the moment w x L. On straight track nothing accelerates. How fast w itself changes in a transition is left out.
"""

from wrsim.core.body.kinematics import generalised_forces, kinematics
from wrsim.core.body.rigid_body import rates_of, turned_axes
from wrsim.core.compiling import kernel
from wrsim.core.track.path import frame, frame_rates, locate


@kernel
def follow_together(q, spins, wheelsets, path, step, reference, guess, speed, q_t):
    """Write the rates of all bodies in steady motion with the poses q.

    spins: angular velocity of each wheelset about its axle [rad/s], beyond that of the turning; wheelsets: bodies
    before this number spin; reference: body whose place counts; guess [m]: where to look for it.
    q_t: (6 n,) to fill. Returns (wx, wy, wz [rad/s], distance, status of ``locate``).
    """
    n = q_t.shape[0] // 6
    i = 6 * reference
    s, status = locate(path, step, q[i + 1], q[i + 2], q[i], guess)
    own = frame(path, step, s)
    rx, ry, rz, _roll = frame_rates(path, step, s)
    wx, wy, wz = speed * rx, speed * ry, speed * rz
    for k in range(n):
        dx = q[6 * k + 1] - own[0]
        dy = q[6 * k + 2] - own[1]
        dz = q[6 * k] - own[2]
        rates = q_t[6 * k : 6 * k + 6]
        rates[0] = speed * own[5] + wx * dy - wy * dx
        rates[1] = speed * own[3] + wy * dz - wz * dy
        rates[2] = speed * own[4] + wz * dx - wx * dz
        rates_of(q[6 * k : 6 * k + 6], wx, wy, wz, rates)
        if k < wheelsets:
            rates[5] += spins[k]
    return wx, wy, wz, s, status


@kernel
def together_inertia(q, q_t, wx, wy, wz, inertia, wheelsets, states, out):
    """Generalised forces (6 n,) that the steady motion takes.

    inertia: rows (mass, Ixx, Iyy, Izz) of the n bodies; w: the turning of all [rad/s]; wheelsets: bodies before this
    number have axes that do not spin with them; states: scratch, (n, 18) or more.
    """
    n = inertia.shape[0]
    for k in range(n):
        body = kinematics(q[6 * k : 6 * k + 6], q_t[6 * k : 6 * k + 6])
        m, ixx, iyy, izz = inertia[k, 0], inertia[k, 1], inertia[k, 2], inertia[k, 3]
        lx = ly = lz = 0.0
        turned_axes(body, q[6 * k + 5] if k >= wheelsets else 0.0, states[k])
        axes = states[k, 6:15]
        for j in range(3):
            moment_of_inertia = ixx if j == 0 else (iyy if j == 1 else izz)
            ex, ey, ez = axes[3 * j], axes[3 * j + 1], axes[3 * j + 2]
            along = moment_of_inertia * (body[15] * ex + body[16] * ey + body[17] * ez)
            lx += along * ex
            ly += along * ey
            lz += along * ez
        force = (
            m * (wy * body[5] - wz * body[4]),
            m * (wz * body[3] - wx * body[5]),
            m * (wx * body[4] - wy * body[3]),
        )
        moment = (wy * lz - wz * ly, wz * lx - wx * lz, wx * ly - wy * lx)
        generalised_forces(body, force, moment, out[6 * k : 6 * k + 6])
