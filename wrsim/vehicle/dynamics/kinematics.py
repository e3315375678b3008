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

from math import atan2, cos, hypot, isfinite, sin
from typing import NamedTuple

from wrsim.jit import Array, Records, kernel, record
from wrsim.jit.frames import BodyMotion, CurveNodes, Frame
from wrsim.jit.linalg import Vec, add, components, cross, dot, from_components, scale, shifted, sub
from wrsim.track.path_kernel import frame_at, locate

Z, X, Y, HEADING, ROLL, SPIN = range(6)
"""Places in q and q_t."""


class TrackPose(NamedTuple):
    """Pose against a track frame: shift along n, height along b [m], yaw, roll [rad]."""

    lateral: float
    height: float
    yaw: float
    roll: float


PLACED = record("""
    distance  [m]     distance along the track
    lateral   [m]     shift to the left
    height    [m]     height above the track
    yaw       [rad]   angle about the vertical
    roll      [rad]   angle about the tangent
    spin_rate [rad/s] angular velocity about the axle, positive when rolling on
""")
"""A `TrackPose`, its place and its spin."""


@kernel
def kinematics(q: Array, q_t: Array) -> BodyMotion:
    """Position, velocity and orientation of a wheelset: a ``BodyMotion``, whose axes do not spin and whose omega does.
    q, q_t: (6,) coordinates [m, rad] and their rates."""
    sa, ca = sin(q[HEADING]), cos(q[HEADING])
    sb, cb = sin(q[ROLL]), cos(q[ROLL])
    forward = Vec(ca, sa, 0.0)
    axle = Vec(-sa * cb, ca * cb, sb)
    return BodyMotion(
        position=Vec(q[X], q[Y], q[Z]),
        velocity=Vec(q_t[X], q_t[Y], q_t[Z]),
        forward=forward,
        left=axle,
        up=Vec(sa * sb, -ca * sb, cb),
        omega=add(Vec(0.0, 0.0, q_t[HEADING]), shifted(scale(q_t[ROLL], forward), q_t[SPIN], axle)),
    )


@kernel
def add_generalised_forces(body: BodyMotion, force: Vec, moment: Vec, out: Array) -> None:
    """Add the generalised forces (6,) of a force [N] and a moment [N m] at the centre of mass to ``out``. They are the
    forces along z, x, y, then the moment's components along the vertical, forward and the axle."""
    out[Z] += force.z
    out[X] += force.x
    out[Y] += force.y
    out[HEADING] += moment.z
    out[ROLL] += dot(moment, body.forward)
    out[SPIN] += dot(moment, body.left)


@kernel
def pose_in_track(body: BodyMotion, track: Frame) -> TrackPose:
    """Pose of a wheelset against the track frame at the projection of its centre of mass."""
    d = sub(body.position, track.origin)
    axle = components(body.left, track.t, track.n, track.b)
    return TrackPose(dot(d, track.n), dot(d, track.b), atan2(-axle.x, axle.y), atan2(axle.z, hypot(axle.x, axle.y)))


@kernel
def place_on_track(
    track: Frame, turning: Vec, speed: float, pose: TrackPose, spin: float, q: Array, q_t: Array
) -> None:
    """Write the state of a wheelset that follows a track frame at a given pose: the inverse of
    ``pose_in_track``.

    track: track frame; turning: its rotation per metre (``track.path_kernel.frame_rates``); speed [m/s]; pose: held;
    spin: angular velocity about the axle [rad/s].
    q, q_t: (6,) to fill; heading within +-pi, spin angle zero.
    """
    turned = Vec(-sin(pose.yaw) * cos(pose.roll), cos(pose.yaw) * cos(pose.roll), sin(pose.roll))
    axle = from_components(turned, track.t, track.n, track.b)
    d = shifted(scale(pose.lateral, track.n), pose.height, track.b)
    omega = scale(speed, turning)
    position = add(track.origin, d)
    velocity = add(scale(speed, track.t), cross(omega, d))
    q[Z], q[X], q[Y] = position.z, position.x, position.y
    q[HEADING] = atan2(-axle.x, axle.y)
    q[ROLL] = atan2(axle.z, hypot(axle.x, axle.y))
    q[SPIN] = 0.0
    q_t[Z], q_t[X], q_t[Y] = velocity.z, velocity.x, velocity.y
    # omega = heading_t z + roll_t forward + spin_t axle, with omega.axle = spin
    heading_t = (omega.z - dot(omega, axle) * axle.z) / (1.0 - axle.z * axle.z)
    q_t[HEADING] = heading_t
    q_t[ROLL] = omega.x * cos(q[HEADING]) + omega.y * sin(q[HEADING])
    q_t[SPIN] = spin - heading_t * axle.z


@kernel
def poses_along(q: Array, q_t: Array, curve: CurveNodes, guess: float, out: Records) -> int:
    """Poses of a motion against a track. q, q_t: (n, 6); curve: centre line; guess: distance of the first row [m], each
    row starts from the last; out: (n,) records PLACED. Returns the first row that cannot be placed on the track, or
    -1."""
    s = guess
    for i in range(q.shape[0]):
        body = kinematics(q[i], q_t[i])
        s, status = locate(curve, body.position, s)
        if status != 0:
            return i
        pose = pose_in_track(body, frame_at(curve, s))
        row = out[i]
        row.distance = s
        row.lateral, row.height, row.yaw, row.roll = pose.lateral, pose.height, pose.yaw, pose.roll
        row.spin_rate = q_t[i, SPIN] + q_t[i, HEADING] * sin(q[i, ROLL])
    return -1


@kernel
def is_near(known: Array, q: Array, q_t: Array, count: int, within: float) -> bool:
    """Whether a known state (2, n) is this one, or none of its first positions differs by more than ``within`` > 0."""
    farthest, same = 0.0, True
    for i in range(q.shape[0]):
        same = same and known[0, i] == q[i] and known[1, i] == q_t[i]
        if i < count:
            farthest = max(farthest, abs(known[0, i] - q[i]))
    return same or 0.0 < within >= farthest


@kernel
def first_not_finite(q: Array, q_t: Array) -> int:
    """Index of the first coordinate (or, counted on, rate) that is not a finite number; -1 if all are."""
    n = q.shape[0]
    for i in range(2 * n):
        if not isfinite(q[i] if i < n else q_t[i - n]):
            return i
    return -1
