"""The wheelset as a rigid body in numbers: kinematics, generalised forces, pose in the track frame.

Coordinates (those of the Exudyn node ``NodeRigidBodyRxyz`` with the global axes permuted to X = z up, Y = x
forward, Z = y left; (z, x, y) is a cyclic permutation, hence right-handed)::

    q = (z, x, y, heading, roll, spin)

The body is turned by heading about the global vertical, then by roll about the heading direction, then by
spin about its axle. With ca = cos(heading), cb = cos(roll) and so on, in global components (x, y, z):

- forward = (ca, sa, 0)
- axle = (-sa cb, ca cb, sb), towards the left wheel
- up = forward x axle = (sa sb, -ca sb, cb)
- angular velocity = heading_t (0, 0, 1) + roll_t forward + spin_t axle

so the generalised forces of a moment M about the centre of mass are its components along the vertical, along
forward and along the axle (the columns of the Jacobian of the angular velocity). The description is singular
only at a roll of +-90 degrees; heading and spin count any number of turns. Only sines and cosines of the
angles enter: a mirrored or turned state gives mirrored or turned forces to round-off.

All vectors are in global axes: x forward at the start of the track, y left, z up.
"""

from math import atan2, cos, isfinite, sin, sqrt

from numba import njit

from wrsim.core.track.path import frame, locate

Z, X, Y, HEADING, ROLL, SPIN = 0, 1, 2, 3, 4, 5  # places in q and q_t


@njit(cache=True)
def kinematics(q, q_t):
    """Position, velocity and orientation of a wheelset.

    q, q_t: (6,) coordinates [m, rad] and their rates. Returns 18 numbers, called ``body`` hereafter:
    position (x, y, z) of the centre of mass [m], its velocity [m/s], unit vectors forward, axle and up of
    the frame that does not spin, angular velocity [rad/s] (with the spin).
    """
    sa = sin(q[3])
    ca = cos(q[3])
    sb = sin(q[4])
    cb = cos(q[4])
    ax = -sa * cb
    ay = ca * cb
    return (
        q[1],
        q[2],
        q[0],
        q_t[1],
        q_t[2],
        q_t[0],
        ca,
        sa,
        0.0,
        ax,
        ay,
        sb,
        sa * sb,
        -ca * sb,
        cb,
        q_t[4] * ca + q_t[5] * ax,
        q_t[4] * sa + q_t[5] * ay,
        q_t[3] + q_t[5] * sb,
    )


@njit(cache=True)
def spin_rate(q, q_t):
    """Angular velocity about the axle [rad/s], positive when rolling forward."""
    return q_t[5] + q_t[3] * sin(q[4])


@njit(cache=True)
def generalised_forces(body, force, moment, out):
    """Write the generalised forces of a force and a moment at the centre of mass to ``out`` (6,).

    force [N], moment [N m]: (x, y, z) in global axes. out: forces along z, x, y [N], then the moment's
    components along the vertical, forward and the axle [N m].
    """
    out[0] = force[2]
    out[1] = force[0]
    out[2] = force[1]
    out[3] = moment[2]
    out[4] = moment[0] * body[6] + moment[1] * body[7]
    out[5] = moment[0] * body[9] + moment[1] * body[10] + moment[2] * body[11]


@njit(cache=True)
def pose_in_track(body, track):
    """Pose of a wheelset against a track frame.

    frame: 12 numbers, origin and unit vectors t, n, b (``core.track.path.frame`` at the projection of the centre
    of mass). Returns (lateral shift, height above the frame's origin along b [m], yaw, roll [rad]).
    """
    rx, ry, rz, tx, ty, tz, nx, ny, nz, bx, by, bz = track
    dx = body[0] - rx
    dy = body[1] - ry
    dz = body[2] - rz
    at = body[9] * tx + body[10] * ty + body[11] * tz
    an = body[9] * nx + body[10] * ny + body[11] * nz
    ab = body[9] * bx + body[10] * by + body[11] * bz
    return (
        dx * nx + dy * ny + dz * nz,
        dx * bx + dy * by + dz * bz,
        atan2(-at, an),
        atan2(ab, sqrt(at * at + an * an)),
    )


@njit(cache=True)
def place(track, rates, speed, lateral, height, yaw, roll, spin, q, q_t):
    """Write the state of a wheelset that follows a track frame at a given pose: the inverse of
    ``pose_in_track``.

    track: track frame; rates: its rotation per metre (``core.track.path.frame_rates``); speed [m/s]; lateral,
    height [m], yaw, roll [rad] against the frame, held; spin: angular velocity about the axle [rad/s].
    q, q_t: (6,) to fill; heading within +-pi, spin angle zero.
    """
    rx, ry, rz, tx, ty, tz, nx, ny, nz, bx, by, bz = track
    ct = -sin(yaw) * cos(roll)
    cn = cos(yaw) * cos(roll)
    cb = sin(roll)
    ax = ct * tx + cn * nx + cb * bx
    ay = ct * ty + cn * ny + cb * by
    az = ct * tz + cn * nz + cb * bz
    dx = lateral * nx + height * bx
    dy = lateral * ny + height * by
    dz = lateral * nz + height * bz
    wx = speed * rates[0]
    wy = speed * rates[1]
    wz = speed * rates[2]
    q[0] = rz + dz
    q[1] = rx + dx
    q[2] = ry + dy
    q[3] = atan2(-ax, ay)
    q[4] = atan2(az, sqrt(ax * ax + ay * ay))
    q[5] = 0.0
    q_t[0] = speed * tz + wx * dy - wy * dx
    q_t[1] = speed * tx + wy * dz - wz * dy
    q_t[2] = speed * ty + wz * dx - wx * dz
    # omega = heading_t z + roll_t forward + spin_t axle, with omega.axle = spin
    about_axle = wx * ax + wy * ay + wz * az
    heading_t = (wz - about_axle * az) / (1.0 - az * az)
    q_t[3] = heading_t
    q_t[4] = wx * cos(q[3]) + wy * sin(q[3])
    q_t[5] = spin - heading_t * az


@njit(cache=True)
def poses_along(q, q_t, path, step, guess, out):
    """Poses of a motion against a track.

    q, q_t: (n, 6); path, step: centre line; guess: distance of the first row [m], each row starts from the
    last.
    out: (n, 6), rows (distance, lateral shift, height [m], yaw, roll [rad], spin rate [rad/s]).
    Returns the first row that cannot be placed on the track, or -1.
    """
    s = guess
    for i in range(q.shape[0]):
        body = kinematics(q[i], q_t[i])
        s, status = locate(path, step, body[0], body[1], body[2], s)
        if status != 0:
            return i
        lateral, height, yaw, roll = pose_in_track(body, frame(path, step, s))
        out[i, 0] = s
        out[i, 1] = lateral
        out[i, 2] = height
        out[i, 3] = yaw
        out[i, 4] = roll
        out[i, 5] = spin_rate(q[i], q_t[i])
    return -1


@njit(cache=True)
def point_velocity(body, x, y, z):
    """Velocity [m/s] of the wheelset's material at the global point (x, y, z): v + omega x r."""
    rx = x - body[0]
    ry = y - body[1]
    rz = z - body[2]
    return (
        body[3] + body[16] * rz - body[17] * ry,
        body[4] + body[17] * rx - body[15] * rz,
        body[5] + body[15] * ry - body[16] * rx,
    )


@njit(cache=True)
def first_not_finite(q, q_t):
    """Index of the first coordinate (or, counted on, rate) that is not a finite number; -1 if all are."""
    n = q.shape[0]
    for i in range(n):
        if not isfinite(q[i]):
            return i
    for i in range(n):
        if not isfinite(q_t[i]):
            return n + i
    return -1
