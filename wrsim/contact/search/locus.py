"""The contact locus (search-locus): the curve on a yawed wheel that can touch a straight rail.

Seen along t the locus is the outline of the wheel: a plane curve in (o, b) that meets the rail profile as an unyawed
wheel would; its t-coordinate is the longitudinal shift of each strip. Its curvatures are (search-curvature), with
k1 = (du/dL) / rho around and k2 along the profile. The arclength of the profile per arclength of the outline is
k1 cos(alpha) / k_t ("shrink"), so the curvature of the outline is also shrink k2 / cos(alpha).

A concave flange root at a large yaw can make k_t vanish: the wheel then touches at two places, ahead and behind, and
the outline has a cusp. k_t is held at ``LEAST_ROLLING_CURVATURE`` k1 there; no wheelset in service gets near.

A wheel out of round (surfaces.wheel_shape) has the curvatures (oor-curvature); with r_u and r_theta along profile and
circumference, t = a r_u + b r_theta, the arclength of its outline per arclength of the profile is
(du/dL) |r_u - (r_u . t) t| k_t / (b II(t, r_theta)).

On a roller, a body of revolution about an axle parallel to o, the outline is that of the wheel seen along circles about
this axle, turned into the section over it: the roller's profile is met there as that of a rail. The wheel's normal is
across to the circle's tangent t (roller-locus), which is linear in sine and cosine of theta, and curvatures of both
bodies along t add up (roller-curvature).
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
def placed(profile: ProfileTable, radius: float, pose: WheelPose, shape: Shape, roller: float) -> PlacedWheel:
    """The wheel of that profile, radius and shape in that pose; roller: inverse of its radius [1/m]."""
    e_t = pose.axle.x
    lean = e_t if shape.depth.shape[0] == 0 else 0.0
    return PlacedWheel(profile, radius, pose.origin, pose.axle, sqrt(1.0 - e_t * e_t), lean, roller, shape)


@inlined
def _cosine(s2: float) -> float:
    """Cosine of the angle whose sine has this square; the series is exact to 1e-15 where it is used."""
    return 1.0 - s2 * (0.5 + s2 * (0.125 + s2 * 0.0625)) if s2 < 4e-4 else sqrt(1.0 - s2)


@inlined
def locus_point(wheel: PlacedWheel, arc: float) -> Locus:
    """Point of the locus (search-locus, search-curvature) at profile arclength ``arc``."""
    origin, e = wheel.origin, wheel.axle
    profile = profile_point(wheel.profile, arc)
    if wheel.roller > 0.0:
        return _roller_point(wheel, profile)
    if wheel.lean == 0.0:
        if wheel.shape.depth.shape[0] > 0:
            return _out_of_round_point(wheel, profile)
        rho = wheel.radius - profile.w
        to_axle = rho / max(profile.tu, 1e-3)
        return Locus(
            origin.x,
            origin.y + profile.u * e.y + rho * e.z,
            origin.z + profile.u * e.z - rho * e.y,
            profile.tw * e.y + profile.tu * e.z,
            profile.tw * e.z - profile.tu * e.y,
            1.0,
            to_axle,
            to_axle,
            profile.k,
        )
    return yawed_point(wheel, profile)


@inlined
def yawed_point(wheel: PlacedWheel, profile: ProfilePoint) -> Locus:
    """The same of a round wheel on a rail."""
    origin, e, q, u, rho = wheel.origin, wheel.axle, wheel.q, profile.u, wheel.radius - profile.w
    iq = 1.0 / q
    inverse_c = 1.0 / max(profile.tu, 1e-3)
    sin_alpha = e.x * inverse_c
    sine = -profile.tw * sin_alpha * iq
    if abs(sine) > LARGEST_SINE or abs(sin_alpha) > LARGEST_SINE:
        sine = min(max(sine, -LARGEST_SINE), LARGEST_SINE)
        sin_alpha = min(max(sin_alpha, -LARGEST_SINE), LARGEST_SINE)
    s2 = sine * sine
    cosine = _cosine(s2)
    do = (cosine * e.z - sine * e.x * e.y) * iq
    db = (-cosine * e.y - sine * e.x * e.z) * iq
    r1 = rho * inverse_c
    sin2 = sin_alpha * sin_alpha
    inverse_ratio = 1.0 / max(1.0 - sin2 + sin2 * profile.k * r1, LEAST_ROLLING_CURVATURE)  # k1 / k_t
    # the normal has no t-component, so its other two make a unit vector as they stand;
    # t . circumference = cos(theta) q = cos(alpha)
    return Locus(
        origin.x + u * e.x + rho * sine * q,
        origin.y + u * e.y + rho * do,
        origin.z + u * e.z + rho * db,
        profile.tw * e.y + profile.tu * do,
        profile.tw * e.z + profile.tu * db,
        cosine * q * inverse_ratio,
        r1 * inverse_ratio,
        r1,
        profile.k,
    )


@inlined
def locus_node(wheel: PlacedWheel, profile: ProfilePoint, largest: float) -> Node:
    """The outline at a point of the profile, without its curvature. Where abs(sine) is not below ``largest`` the locus
    has no point (a nearly vertical flank of a yawed wheel touches nowhere) or climbs around the wheel, and the plain
    section is returned."""
    origin, e, q = wheel.origin, wheel.axle, wheel.q
    if wheel.shape.depth.shape[0] > 0:
        return _out_of_round_node(wheel, profile)
    if wheel.roller > 0.0:
        return _roller_node(wheel, profile, largest)
    rho = wheel.radius - profile.w
    iq = 1.0 / q
    sine = -profile.tw * e.x * iq / max(profile.tu, 1e-3)
    angle = sine if abs(sine) < largest else 0.0
    cosine = _cosine(angle * angle)
    do = (cosine * e.z - angle * e.x * e.y) * iq
    db = (-cosine * e.y - angle * e.x * e.z) * iq
    return Node(
        origin.y + profile.u * e.y + rho * do,
        origin.z + profile.u * e.z + rho * db,
        profile.tw * e.y + profile.tu * do,
        profile.tw * e.z + profile.tu * db,
        sine,
    )


class _OnRoller(NamedTuple):
    """Point of a wheel over a roller (x, o, b) in rail axes; its normal in the roller's section; tangent and secant of
    the angle about the roller's axle; height in that section over b [m]; b over the roller's axle, of its radius."""

    x: float
    o: float
    b: float
    no: float
    nb: float
    tangent: float
    secant: float
    lift: float
    size: float


@inlined
def _roller_sine(wheel: PlacedWheel, profile: ProfilePoint) -> float:
    """Sine of theta at which the wheel is met along the roller (roller-locus), beyond 1 where nowhere."""
    origin, e, q, k = wheel.origin, wheel.axle, wheel.q, wheel.roller
    tu, tw, rho = max(profile.tu, 1e-3), profile.tw, (wheel.radius - profile.w) * k
    ahead, above = (origin.x + profile.u * e.x) * k, 1.0 + (origin.z + profile.u * e.z) * k
    mixed = (tw * e.x * rho - tu * ahead) / q
    of_sine = q * (tu * above - tw * e.z * rho) - e.x * e.z * mixed
    of_cosine, constant = -e.y * mixed, tw * (e.x * above - e.z * ahead)
    size = of_sine * of_sine + of_cosine * of_cosine
    root = sqrt(max(size - constant * constant, 0.0))
    return -(of_sine * constant + of_cosine * root) / max(size, 1e-12)


@inlined
def _over_roller(wheel: PlacedWheel, profile: ProfilePoint, sine: float) -> _OnRoller:
    """The wheel's point at theta, and where the roller has it."""
    origin, e, q, u = wheel.origin, wheel.axle, wheel.q, profile.u
    rho, cosine = wheel.radius - profile.w, _cosine(sine * sine)
    do, db = (cosine * e.z - sine * e.x * e.y) / q, (-cosine * e.y - sine * e.x * e.z) / q
    x, b = origin.x + u * e.x + rho * sine * q, origin.z + u * e.z + rho * db
    size = 1.0 + b * wheel.roller
    tangent = x * wheel.roller / size
    secant = sqrt(1.0 + tangent * tangent)
    return _OnRoller(
        x, origin.y + u * e.y + rho * do, b, profile.tw * e.y + profile.tu * do,
        (profile.tw * e.z + profile.tu * db) * secant, tangent, secant, x * tangent / (1.0 + secant), size,
    )  # fmt: skip


@kernel
def _roller_point(wheel: PlacedWheel, profile: ProfilePoint) -> Locus:
    """As ``locus_point``."""
    sine = min(max(_roller_sine(wheel, profile), -LARGEST_SINE), LARGEST_SINE)
    on = _over_roller(wheel, profile, sine)
    inverse_c = 1.0 / max(profile.tu, 1e-3)
    sin_alpha = (wheel.axle.x - wheel.axle.z * on.tangent) / on.secant * inverse_c
    sin2 = min(sin_alpha * sin_alpha, LARGEST_SINE * LARGEST_SINE)
    r1 = (wheel.radius - profile.w) * inverse_c
    bend = max(-on.nb, 0.0) * wheel.roller / (on.size * on.secant)  # of the roller along t
    radius = r1 / (1.0 + bend * r1)
    inverse_ratio = 1.0 / max(1.0 - sin2 + sin2 * (profile.k + bend) * radius, LEAST_ROLLING_CURVATURE)
    k = profile.k + sin2 * bend * radius * (1.0 / r1 - profile.k)
    return Locus(on.x, on.o, on.b + on.lift, on.no, on.nb, _cosine(sin2) * inverse_ratio, radius * inverse_ratio, r1, k)


@kernel
def _roller_node(wheel: PlacedWheel, profile: ProfilePoint, largest: float) -> Node:
    """As ``locus_node``."""
    sine = _roller_sine(wheel, profile)
    on = _over_roller(wheel, profile, sine if abs(sine) < largest else 0.0)
    return Node(on.o, on.b + on.lift, on.no, on.nb, sine)


@kernel
def _out_of_round_point(wheel: PlacedWheel, profile: ProfilePoint) -> Locus:
    """As ``locus_point``."""
    e_t, q = wheel.axle.x, wheel.q
    on = touch(wheel, profile.u, profile.w, slope_across(profile))
    form = second_form(profile, on)
    o, b, no, nb = _seen_along(wheel, profile, on)
    a, c = e_t, q * on.cosine / on.p
    k_t = (a * a * form.uu + 2.0 * a * c * form.ua + c * c * form.aa) / form.size
    least = LEAST / (on.p * form.size)
    mixed = c * q * on.rate / form.size  # b II(t, r_theta)
    dot = e_t + on.p_u * q * on.sine
    across = profile.tu * sqrt(max(1.0 + on.p_u * on.p_u - dot * dot, 1e-6))
    size2 = form.size * form.size
    gauss = (form.uu * form.aa - form.ua * form.ua) / (on.p * on.p * size2 * size2)
    x = wheel.origin.x + profile.u * e_t + on.p * on.sine * q
    k_mean = max(k_t, least)
    if wheel.shape.averaged > 0.0:
        k_mean, ahead = mean_curvature(wheel, profile, on, form.size)
        x += ahead
    out = (no * wheel.axle.z - nb * wheel.axle.y) / q
    return Locus(
        x, o, b, no, nb, mixed / max(across * max(k_t, least), 1e-9), 1.0 / k_mean, on.p * on.cosine / max(out, 1e-3),
        across * gauss / mixed,
    )  # fmt: skip


@inlined
def _seen_along(wheel: PlacedWheel, profile: ProfilePoint, on: Touch) -> tuple[float, float, float, float]:
    """Point and normal of the outline (o, b, no, nb)."""
    origin, e = wheel.origin, wheel.axle
    iq = 1.0 / wheel.q
    axial, down = profile.u - on.p * on.sine * e.x * iq, on.p * on.cosine * iq
    ne, nd = -on.p_u * iq, on.cosine + on.turn * on.sine
    unit = iq / sqrt(ne * ne + nd * nd)
    ne, nd = ne * unit, nd * unit
    return (
        origin.y + axial * e.y + down * e.z, origin.z + axial * e.z - down * e.y, ne * e.y + nd * e.z,
        ne * e.z - nd * e.y,
    )  # fmt: skip


@kernel
def _out_of_round_node(wheel: PlacedWheel, profile: ProfilePoint) -> Node:
    """As ``locus_node``; the sine is that of a round wheel."""
    on = touch(wheel, profile.u, profile.w, slope_across(profile))
    o, b, no, nb = _seen_along(wheel, profile, on)
    return Node(o, b, no, nb, -profile.tw * wheel.axle.x / (wheel.q * max(profile.tu, 1e-3)))


@kernel
def outline(
    table: Array, step: float, radius: float, pose: Array, depth: Array, branches: Array, numbers: Array, arc: Array,
    out: Array,
) -> None:  # fmt: skip
    """Outline of a wheel seen along its rail, for drawing: (o, b) at the arclengths ``arc`` to ``out`` (2, m). pose:
    (POSE,); depth, branches, numbers: of ``Shape``, (0, 0) and its numbers from rows to angle (5,)."""
    shape = Shape(depth, branches, int(numbers[0]), numbers[1], numbers[2], numbers[3], numbers[4], 0.0)
    wheel = placed(ProfileTable(table, step), radius, read_pose(pose), shape, 0.0)
    if depth.shape[0] > 0:
        find_branches(wheel)
    for i in range(arc.shape[0]):
        drawn = locus_node(wheel, profile_point(wheel.profile, arc[i]), DRAWN_SINE)
        out[0, i] = drawn.o
        out[1, i] = drawn.b
