"""What others read of a vehicle that moves on step by step: motions of its bodies, forces of its wheels.

The workspace is that of ``dynamics.stepper``. A body is placed against the frame of the centre line beside it.
"""

from wrsim.dynamics.kinematics import X, Y, Z, kinematics, pose_in_track
from wrsim.dynamics.rigid_body import PITCH, pitched
from wrsim.dynamics.stepper import OF_VEHICLE, Q_T, Q_TT, SEEN, STATE, WHEELS, Q
from wrsim.dynamics.vehicle_forces import CENTRE, FIRST_WHEEL, PART, PARTS, VEHICLE, WHOLE
from wrsim.dynamics.wheel_forces import OFF_TRACK, wheel_total
from wrsim.jit import Array, Ints, kernel, matrix, record, records
from wrsim.jit.frames import CurveNodes
from wrsim.jit.linalg import Vec, dot
from wrsim.track.path_kernel import NODE, frame_at, locate

BODY_SEEN = record(
    "distance speed lateral height yaw roll yaw_rate rotation acceleration_x acceleration_y acceleration_z"
)
"""Distance of the centre of mass along the centre line (a guess, updated) [m] and speed along it [m/s]; shift to the
left and height against it [m], yaw and roll against its frame [rad]; angular velocity about the body's vertical axis,
and about its axle or its lateral axis [rad/s]; acceleration of the centre of mass along the body's axes [m/s2]."""

WHEEL_SEEN = record("X Y Q")
"""Forces of a wheel on its rail: forward, outward, down [N]."""


@kernel
def observe(buffer: Array, index: Ints) -> int:
    """Fill the records of bodies and wheels from the state and the last contacts. Returns 0 or OFF_TRACK."""
    own, rows = index[OF_VEHICLE:], matrix(buffer, index, STATE)
    parts, seen = records(buffer, own, PARTS, PART), records(buffer, index, SEEN, BODY_SEEN)
    centre = CurveNodes(records(buffer, own, CENTRE, NODE), records(buffer, own, WHOLE, VEHICLE)[0].step)
    for i in range(seen.shape[0]):
        q, q_t, q_tt = rows[Q, 6 * i : 6 * i + 6], rows[Q_T, 6 * i : 6 * i + 6], rows[Q_TT, 6 * i : 6 * i + 6]
        body, row = kinematics(q, q_t), seen[i]
        s, bad = locate(centre, body.position, row.distance)
        if bad != 0:
            return OFF_TRACK
        track = frame_at(centre, s)
        pose = pose_in_track(body, track)
        row.distance, row.speed = s, dot(body.velocity, track.t)
        row.lateral, row.height, row.yaw, row.roll = pose.lateral, pose.height, pose.yaw, pose.roll
        row.rotation = dot(body.omega, body.left)
        if parts[i].wheelset < 0:
            body = pitched(body, q[PITCH])
        row.yaw_rate = dot(body.omega, body.up)
        faster = Vec(q_tt[X], q_tt[Y], q_tt[Z])
        row.acceleration_x, row.acceleration_y = dot(faster, body.forward), dot(faster, body.left)
        row.acceleration_z = dot(faster, body.up)
    wheels = records(buffer, index, WHEELS, WHEEL_SEEN)
    for k in range(wheels.shape[0]):
        total = wheel_total(buffer, own[FIRST_WHEEL:], k)
        wheels[k].X, wheels[k].Y, wheels[k].Q = -total.Ft, -total.Fo, total.Fb
    return 0
