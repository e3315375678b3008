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

Of a wheel out of round (surfaces.wheel_shape) the same in terms of its second form II, with r_u and r_theta along
profile and circumference, t = a r_u + b r_theta, K the Gaussian curvature:

- k_t = II(t, t), of the outline K / k_t
- arclength of the outline per arclength of the profile   (du/dL) |r_u - (r_u . t) t| k_t / (b II(t, r_theta))
"""

from math import sqrt
from typing import NamedTuple

from wrsim.contact.records import PlacedWheel, ProfileTable, Shape, WheelPose, read_pose
from wrsim.contact.surfaces.profile_table import ProfilePoint, profile_point
from wrsim.contact.surfaces.wheel_shape import (
    LEAST,
    Touch,
    find_branches,
    mean_curvature,
    second_form,
    slope_across,
    touch,
)
from wrsim.jit import Array, inlined, kernel

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
def placed(profile: ProfileTable, radius: float, pose: WheelPose, shape: Shape) -> PlacedWheel:
    """The wheel of that profile, radius and shape in that pose."""
    e_t = pose.axle.x
    lean = e_t if shape.depth.shape[0] == 0 else 0.0
    return PlacedWheel(profile, radius, pose.origin, pose.axle, sqrt(1.0 - e_t * e_t), lean, shape)


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
    if wheel.lean == 0.0:
        if wheel.shape.depth.shape[0] > 0:
            return _out_of_round_point(wheel, at)
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
    if wheel.shape.depth.shape[0] > 0:
        return _out_of_round_node(wheel, at)
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
def _out_of_round_point(wheel: PlacedWheel, at: ProfilePoint) -> Locus:
    """As ``locus_point``."""
    e_t, q = wheel.axle.x, wheel.q
    on = touch(wheel, at.u, at.w, slope_across(at))
    form = second_form(at, on)
    o, b, no, nb = _seen_along(wheel, at, on)
    a, c = e_t, q * on.cosine / on.p
    k_t = (a * a * form.uu + 2.0 * a * c * form.ua + c * c * form.aa) / form.size
    least = LEAST / (on.p * form.size)
    mixed = c * q * on.rate / form.size  # b II(t, r_theta)
    dot = e_t + on.p_u * q * on.sine
    across = at.tu * sqrt(max(1.0 + on.p_u * on.p_u - dot * dot, 1e-6))
    size2 = form.size * form.size
    gauss = (form.uu * form.aa - form.ua * form.ua) / (on.p * on.p * size2 * size2)
    x = wheel.origin.x + at.u * e_t + on.p * on.sine * q
    k_mean = max(k_t, least)
    if wheel.shape.averaged > 0.0:
        k_mean, ahead = mean_curvature(wheel, at, on, form.size)
        x += ahead
    out = (no * wheel.axle.z - nb * wheel.axle.y) / q
    return Locus(
        x, o, b, no, nb, mixed / max(across * max(k_t, least), 1e-9), 1.0 / k_mean, on.p * on.cosine / max(out, 1e-3),
        across * gauss / mixed,
    )  # fmt: skip


@inlined
def _seen_along(wheel: PlacedWheel, at: ProfilePoint, on: Touch) -> tuple[float, float, float, float]:
    """Point and normal of the outline (o, b, no, nb)."""
    origin, e = wheel.origin, wheel.axle
    iq = 1.0 / wheel.q
    axial, down = at.u - on.p * on.sine * e.x * iq, on.p * on.cosine * iq
    ne, nd = -on.p_u * iq, on.cosine + on.turn * on.sine
    unit = iq / sqrt(ne * ne + nd * nd)
    ne, nd = ne * unit, nd * unit
    return (
        origin.y + axial * e.y + down * e.z, origin.z + axial * e.z - down * e.y, ne * e.y + nd * e.z,
        ne * e.z - nd * e.y,
    )  # fmt: skip


@kernel
def _out_of_round_node(wheel: PlacedWheel, at: ProfilePoint) -> Node:
    """As ``locus_node``; the sine is that of a round wheel."""
    on = touch(wheel, at.u, at.w, slope_across(at))
    o, b, no, nb = _seen_along(wheel, at, on)
    return Node(o, b, no, nb, -at.tw * wheel.axle.x / (wheel.q * max(at.tu, 1e-3)))


@kernel
def outline(
    table: Array, step: float, radius: float, pose: Array, depth: Array, branches: Array, numbers: Array, arc: Array,
    out: Array,
) -> None:  # fmt: skip
    """Outline of a wheel seen along its rail, for drawing: (o, b) at the arclengths ``arc`` to ``out`` (2, m). pose:
    (POSE,); depth, branches, numbers: of ``Shape``, (0, 0) and its numbers from rows to angle (5,)."""
    shape = Shape(depth, branches, int(numbers[0]), numbers[1], numbers[2], numbers[3], numbers[4], 0.0)
    wheel = placed(ProfileTable(table, step), radius, read_pose(pose), shape)
    if depth.shape[0] > 0:
        find_branches(wheel)
    for i in range(arc.shape[0]):
        at = locus_node(wheel, profile_point(wheel.profile, arc[i]), DRAWN_SINE)
        out[0, i] = at.o
        out[1, i] = at.b
