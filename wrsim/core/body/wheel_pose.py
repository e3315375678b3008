"""Between a wheelset in space and the kernel of one wheel on one rail.

The kernel works in the axes (t, o, b) of its rail, o outward. On the left side o = n and the axes are right-handed; on
the right side o = -n. Vectors keep their geometry; the components of angular velocities and moments change sign once
more there (they are pseudovectors), so the kernel's formulae hold on both sides and mirrored states give mirrored
forces to round-off.
"""

from wrsim.core.body.kinematics import point_velocity
from wrsim.core.compiling import kernel


@kernel
def wheel_origin(body, side, half_spacing):
    """Wheel profile origin on the axle, global (x, y, z). side: +1 left, -1 right; half_spacing: H/2 [m]."""
    d = side * half_spacing
    return body[0] + d * body[9], body[1] + d * body[10], body[2] + d * body[11]


@kernel
def set_pose(body, frame, side, half_spacing, pose):
    """Write the pose and motion of one wheel in its rail's axes to ``pose`` (POSE,), see core.contact.records.

    body: from core.body.kinematics.kinematics; frame: of the rail at the section beside the wheel
    (core.track.path.frame).
    """
    rx, ry, rz, tx, ty, tz, nx, ny, nz, bx, by, bz = frame
    x, y, z = wheel_origin(body, side, half_spacing)
    dx, dy, dz = x - rx, y - ry, z - rz
    pose[0] = dx * tx + dy * ty + dz * tz
    pose[1] = side * (dx * nx + dy * ny + dz * nz)
    pose[2] = dx * bx + dy * by + dz * bz
    ax, ay, az = body[9], body[10], body[11]
    pose[3] = side * (ax * tx + ay * ty + az * tz)
    pose[4] = ax * nx + ay * ny + az * nz
    pose[5] = side * (ax * bx + ay * by + az * bz)
    vx, vy, vz = point_velocity(body, x, y, z)
    pose[6] = vx * tx + vy * ty + vz * tz
    pose[7] = side * (vx * nx + vy * ny + vz * nz)
    pose[8] = vx * bx + vy * by + vz * bz
    wx, wy, wz = body[15], body[16], body[17]
    pose[9] = side * (wx * tx + wy * ty + wz * tz)
    pose[10] = wx * nx + wy * ny + wz * nz
    pose[11] = side * (wx * bx + wy * by + wz * bz)


@kernel
def add_forces(body, frame, side, half_spacing, total, force, moment):
    """Add one wheel's contact force and moment to ``force`` and ``moment`` (3,) at the centre of mass, global axes."""
    _rx, _ry, _rz, tx, ty, tz, nx, ny, nz, bx, by, bz = frame
    ft, fn, fb = total.Ft, side * total.Fo, total.Fb
    mt, mn, mb = side * total.Mt, total.Mo, side * total.Mb
    fx = ft * tx + fn * nx + fb * bx
    fy = ft * ty + fn * ny + fb * by
    fz = ft * tz + fn * nz + fb * bz
    d = side * half_spacing
    ax, ay, az = d * body[9], d * body[10], d * body[11]
    force[0] += fx
    force[1] += fy
    force[2] += fz
    moment[0] += mt * tx + mn * nx + mb * bx + ay * fz - az * fy
    moment[1] += mt * ty + mn * ny + mb * by + az * fx - ax * fz
    moment[2] += mt * tz + mn * nz + mb * bz + ax * fy - ay * fx
