"""The contact locus: the curve on a yawed wheel that can touch a straight rail.

A wheel is a surface of revolution of radius rho(u) about its axle. A straight rail along t can touch it only where
the wheel's normal has no t-component. With d the radial direction of the point,
d . t = -(dw/dL) / (du/dL) e_t, which is sin(theta) = rho'(u) e_t / sqrt(1 - e_t^2) in the angle theta around the
axle from the lowest point. Seen along t the locus is the outline of the wheel: a plane curve in (o, b) that meets
the rail profile as an unyawed wheel would; its t-coordinate is the longitudinal shift of each strip.

Curvatures follow Euler and the shape operator: with the principal curvatures k1 = (du/dL) / rho (around) and k2
(along the profile), alpha the angle between t and the circumference (sin alpha = e_t / (du/dL)):

- along the rail           k_t = cos^2(alpha) k1 + sin^2(alpha) k2
- of the outline           k1 k2 / k_t
- arclength of the profile per arclength of the outline   k1 cos(alpha) / k_t  ("shrink")
  (so the curvature of the outline is also shrink k2 / cos(alpha))

A concave flange root at a large yaw can make k_t vanish: the wheel then touches at two places, ahead and behind, and
the outline has a cusp. k_t is held at ``LEAST_ROLLING_CURVATURE`` k1 there; no wheelset in service gets near.
"""

from math import sqrt
from typing import NamedTuple

from wrsim.core.contact.profile import ProfilePoint, profile_point
from wrsim.core.contact.records import PlacedWheel, ProfileTable, WheelPose, read_pose
from wrsim.core.jit import Array, inlined, kernel

LEAST_ROLLING_CURVATURE = 0.1
DRAWN_SINE = 0.25  # of theta: beyond, the outline is drawn as the plain section
LARGEST_SINE = 0.7  # of theta and alpha: beyond, the point is no candidate for contact


class Locus(NamedTuple):
    """Point of the locus (x, o, b) [m]; unit normal out of the wheel (towards the rail); the profile's arclength per
    arclength of the outline; radius of curvature along t [m]; distance to the axle along the normal [m]; curvature of
    the profile [1/m]."""

    x: float
    o: float
    b: float
    no: float
    nb: float
    shrink: float
    r_t: float
    to_axle: float
    k: float


class Node(NamedTuple):
    """Point of the outline (o, b) [m], its normal, and the sine of theta."""

    o: float
    b: float
    no: float
    nb: float
    sine: float


@inlined
def placed(profile: ProfileTable, radius: float, pose: WheelPose) -> PlacedWheel:
    """The wheel of that profile and radius in that pose."""
    e_t = pose.axle.x
    return PlacedWheel(profile, radius, pose.origin, pose.axle, sqrt(1.0 - e_t * e_t))


@inlined
def _cosine(s2: float) -> float:
    """Cosine of the angle whose sine has this square; the series is exact to 1e-15 where it is used."""
    return 1.0 - s2 * (0.5 + s2 * (0.125 + s2 * 0.0625)) if s2 < 4e-4 else sqrt(1.0 - s2)


@inlined
def locus_point(wheel: PlacedWheel, arc: float) -> Locus:
    """Point of the locus at profile arclength ``arc``."""
    origin, e, q = wheel.origin, wheel.axle, wheel.q
    at = profile_point(wheel.profile, arc)
    u = at.u
    rho = wheel.radius - at.w
    if e.x == 0.0:
        to_axle = rho / max(at.tu, 1e-3)
        return Locus(
            origin.x,
            origin.y + u * e.y + rho * e.z,
            origin.z + u * e.z - rho * e.y,
            at.tw * e.y + at.tu * e.z,
            at.tw * e.z - at.tu * e.y,
            1.0,
            to_axle,
            to_axle,
            at.k,
        )
    iq = 1.0 / q
    inverse_c = 1.0 / max(at.tu, 1e-3)
    sin_alpha = e.x * inverse_c
    sine = -at.tw * sin_alpha * iq
    if abs(sine) > LARGEST_SINE or abs(sin_alpha) > LARGEST_SINE:
        sine = min(max(sine, -LARGEST_SINE), LARGEST_SINE)
        sin_alpha = min(max(sin_alpha, -LARGEST_SINE), LARGEST_SINE)
    s2 = sine * sine
    cosine = _cosine(s2)
    do = (cosine * e.z - sine * e.x * e.y) * iq
    db = (-cosine * e.y - sine * e.x * e.z) * iq
    r1 = rho * inverse_c
    sin2 = sin_alpha * sin_alpha
    inverse_ratio = 1.0 / max(1.0 - sin2 + sin2 * at.k * r1, LEAST_ROLLING_CURVATURE)  # k1 / k_t
    # the normal has no t-component, so its other two make a unit vector as they stand;
    # t . circumference = cos(theta) q = cos(alpha)
    return Locus(
        origin.x + u * e.x + rho * sine * q,
        origin.y + u * e.y + rho * do,
        origin.z + u * e.z + rho * db,
        at.tw * e.y + at.tu * do,
        at.tw * e.z + at.tu * db,
        cosine * q * inverse_ratio,
        r1 * inverse_ratio,
        r1,
        at.k,
    )


@inlined
def locus_node(wheel: PlacedWheel, at: ProfilePoint, largest: float) -> Node:
    """The outline at a point of the profile, without its curvature. Where abs(sine) is not below ``largest`` the locus
    has no point (a nearly vertical flank of a yawed wheel touches nowhere) or climbs around the wheel, and the plain
    section is returned."""
    origin, e, q = wheel.origin, wheel.axle, wheel.q
    rho = wheel.radius - at.w
    iq = 1.0 / q
    sine = -at.tw * e.x * iq / max(at.tu, 1e-3)
    angle = sine if abs(sine) < largest else 0.0
    cosine = _cosine(angle * angle)
    do = (cosine * e.z - angle * e.x * e.y) * iq
    db = (-cosine * e.y - angle * e.x * e.z) * iq
    return Node(
        origin.y + at.u * e.y + rho * do,
        origin.z + at.u * e.z + rho * db,
        at.tw * e.y + at.tu * do,
        at.tw * e.z + at.tu * db,
        sine,
    )


@kernel
def outline(table: Array, step: float, radius: float, pose: Array, arc: Array, out: Array) -> None:
    """Outline of a wheel seen along its rail, for drawing: (o, b) at the arclengths ``arc`` to ``out`` (2, m). pose:
    (POSE,)."""
    wheel = placed(ProfileTable(table, step), radius, read_pose(pose))
    for i in range(arc.shape[0]):
        at = locus_node(wheel, profile_point(wheel.profile, arc[i]), DRAWN_SINE)
        out[0, i] = at.o
        out[1, i] = at.b
