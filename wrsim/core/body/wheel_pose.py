"""Between a wheelset in space and the kernel of one wheel on one rail.

The kernel works in the axes (t, o, b) of its rail, o outward. On the left side o = n and the axes are right-handed; on
the right side o = -n. Vectors keep their geometry; the components of angular velocities and moments change sign once
more there (they are pseudovectors), so the kernel's formulae hold on both sides and mirrored states give mirrored
forces to round-off.
"""

from wrsim.core.jit.arena import Array, Record
from wrsim.core.jit.compiling import inlined, kernel
from wrsim.core.linalg import (
    BodyMotion,
    Frame,
    Vec,
    add,
    components,
    cross,
    from_components,
    point_velocity,
    put_at,
    scale,
    shifted,
    sub,
)


@inlined
def wheel_origin(body: BodyMotion, side: float, half_spacing: float) -> Vec:
    """Wheel profile origin on the axle, global. side: +1 left, -1 right; half_spacing: H/2 [m]."""
    return shifted(body.position, side * half_spacing, body.left)


@inlined
def _in_rail(a: Vec, rail: Frame, side: float) -> Vec:
    """Components of a vector in the rail's axes (t, o, b)."""
    own = components(a, rail.t, rail.n, rail.b)
    return Vec(own.x, side * own.y, own.z)


@inlined
def _turning_in_rail(a: Vec, rail: Frame, side: float) -> Vec:
    """Components of a pseudovector in the rail's axes (t, o, b)."""
    own = components(a, rail.t, rail.n, rail.b)
    return Vec(side * own.x, own.y, side * own.z)


@kernel
def set_pose(body: BodyMotion, rail: Frame, side: float, half_spacing: float, pose: Array) -> None:
    """Write the pose and motion of one wheel in its rail's axes to ``pose`` (POSE,), see core.contact.records.

    rail: frame of the rail at the section beside the wheel (core.track.path.frame).
    """
    origin = wheel_origin(body, side, half_spacing)
    put_at(pose, 0, _in_rail(sub(origin, rail.origin), rail, side))
    put_at(pose, 3, _in_rail(scale(side, body.left), rail, side))
    put_at(pose, 6, _in_rail(point_velocity(body, origin), rail, side))
    put_at(pose, 9, _turning_in_rail(body.omega, rail, side))


@kernel
def wheel_wrench(body: BodyMotion, rail: Frame, side: float, half_spacing: float, total: Record) -> tuple[Vec, Vec]:
    """Force and moment at the centre of mass, in global axes, of one wheel's contact; total: a record TOTAL."""
    f = Vec(total.Ft, side * total.Fo, total.Fb)
    m = Vec(side * total.Mt, total.Mo, side * total.Mb)
    force = from_components(f, rail.t, rail.n, rail.b)
    arm = scale(side * half_spacing, body.left)
    return force, add(from_components(m, rail.t, rail.n, rail.b), cross(arm, force))
