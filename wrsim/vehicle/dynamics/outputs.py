"""What others read of a vehicle that moves on step by step: motions of its bodies, forces of its wheels.

The workspace is that of ``dynamics.stepper``. A body is placed against the frame of the centre line beside it.
"""

from wrsim.jit import Array, Ints, kernel, matrix, record, records
from wrsim.jit.frames import CurveNodes
from wrsim.jit.linalg import Vec, dot
from wrsim.track.path_kernel import NODE, frame_at, locate
from wrsim.vehicle.dynamics.kinematics import X, Y, Z, kinematics, pose_in_track
from wrsim.vehicle.dynamics.loads import UNIT
from wrsim.vehicle.dynamics.rigid_body import PITCH, pitched
from wrsim.vehicle.dynamics.stepper import Q_T, Q_TT, SEEN, STATE, VEHICLE_ARRAYS, WHEELS, Q
from wrsim.vehicle.dynamics.vehicle_forces import CENTRE, FIRST_WHEEL, PART, PARTS, UNITS, VEHICLE, WHOLE
from wrsim.vehicle.dynamics.wheel_forces import OFF_TRACK, wheel_total

BODY_SEEN = record("""
    distance       [m]     distance of the centre of mass along the centre line (a guess, updated)
    speed          [m/s]   speed along the centre line
    lateral        [m]     shift to the left of the centre line
    height         [m]     height above it
    yaw            [rad]   yaw against its frame
    roll           [rad]   roll against its frame
    yaw_rate       [rad/s] angular velocity about the body's vertical axis
    rotation       [rad/s] angular velocity about the axle or the lateral axis
    acceleration_x [m/s2]  acceleration of the centre of mass along the body, ...
    acceleration_y [m/s2]  ... to its left ...
    acceleration_z [m/s2]  ... and up
""")

WHEEL_SEEN = record("""
    X [N] force of the wheel on its rail, forward
    Y [N] outward
    Q [N] down
""")


@kernel
def observe(buffer: Array, index: Ints) -> int:
    """Fill the records of bodies and wheels from the state and the last contacts. Returns 0 or OFF_TRACK."""
    arrays, rows = index[VEHICLE_ARRAYS:], matrix(buffer, index, STATE)
    parts, seen = records(buffer, arrays, PARTS, PART), records(buffer, index, SEEN, BODY_SEEN)
    centre = CurveNodes(records(buffer, arrays, CENTRE, NODE), records(buffer, arrays, WHOLE, VEHICLE)[0].step)
    wheels = records(buffer, index, WHEELS, WHEEL_SEEN)
    units, way = records(buffer, arrays, UNITS, UNIT), 0.0
    for k in range(units.shape[0]):
        if units[k].body < seen.shape[0]:  # since the last call: a reference body is placed at every evaluation
            way = units[k].s - seen[units[k].body].distance
            break
    for i in range(seen.shape[0]):
        q, q_t, q_tt = rows[Q, 6 * i : 6 * i + 6], rows[Q_T, 6 * i : 6 * i + 6], rows[Q_TT, 6 * i : 6 * i + 6]
        body, row = kinematics(q, q_t), seen[i]
        s, bad = locate(centre, body.position, row.distance + way)
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
    for k in range(wheels.shape[0]):
        total = wheel_total(buffer, arrays[FIRST_WHEEL:], k)
        wheels[k].X, wheels[k].Y, wheels[k].Q = -total.Ft, -total.Fo, total.Fb
    return 0
