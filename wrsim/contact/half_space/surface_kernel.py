"""Curved reference surface of a patch and the exact gap of wheel and rail over it.

The reference is the middle of the rail profile and the wheel's outline (contact.search.locus), swept along the
rail: rows at equal steps of the curved axis s, columns at equal steps of x. A row's normal is the bisector of the two
profiles' normals. Along the axis points of rail and wheel are kept opposite each other: half of any tangential offset
goes to either profile, so that the pairs stay true far from the main point too. CONTACT pairs them by arclength from
two points of the same lateral place instead (``level``); on a flank of angle a these are offset by the approach times
tan(a) and the normals err by a quarter of that times the difference of the curvatures. Offered for comparison only.

The gap is measured along the row's normal from the rail to the surface of revolution itself, not to a parabola: yaw
needs no shift of rows, the true surface of a yawed flange lies skewed on the grid.

Of a rail that changes along the track every column has the section at its own place. The reference is inclined as the
rail is at the main point; a gap along the normal of a section that rises by ``slope`` counts 1/sqrt(1 + slope^2) of
itself, which is the distance of the inclined surfaces.
"""

from math import atan2, inf, sqrt
from typing import Any, NamedTuple

from wrsim.contact.overlap_patch import pair
from wrsim.contact.records import PlacedWheel, Rail
from wrsim.contact.search.locus import locus_point
from wrsim.contact.surfaces.profile_table import profile_point
from wrsim.contact.surfaces.rail import rail_point
from wrsim.contact.surfaces.wheel_shape import depth_at
from wrsim.jit import Array, Ints, Record, Records, inlined, kernel, record
from wrsim.jit.linalg import Vec, dot, norm, shifted, sub

AXIS = record("""
    s         [m]  place along the curved axis
    x         [m]  centre along the track, that of the wheel's outline
    o         [m]  centre, outward
    b         [m]  centre, up
    no        [1]  outward component of the normal from rail to wheel
    nb        [1]  upward component of the normal
    arc_wheel [m]  arclength on the wheel
    arc_rail  [m]  arclength on the rail
    gap       [m]  along the normal of the true position, negative where the bodies interpenetrate
    r_t       [m]  radius of curvature along the rail
    slope     [1]  of the rail along the track
""")
"""A row of the curved axis."""

NO_SURFACE = -1.0  # interpenetration where the normal meets no wheel or no rail [m]
ACCURACY = 2e-10  # of the gap [m]
REACH = 0.02  # farthest surface looked for [m]
LEAST_FACING = 0.05  # cosine of the angle between a row's normal and a surface's
LONGEST_STEP = 2.5e-4  # of the walk along the axis [m]


@inlined
def _offset(wheel: PlacedWheel, rail: Rail, arc_wheel: float, arc_rail: float) -> tuple[float, float]:
    """How far the wheel's point lies ahead of the rail's, along the mean tangent [m], and the wheel's shrink."""
    w, r = locus_point(wheel, arc_wheel), rail_point(rail, arc_rail)
    to = 0.5 * (r.tu - w.nb)
    tb = 0.5 * (r.tw + w.no)
    inverse = 1.0 / max(sqrt(to * to + tb * tb), 0.1)
    return ((w.o - r.u) * to + (w.b - r.w) * tb) * inverse, w.shrink


@kernel
def _beside(wheel: PlacedWheel, rail: Rail, arc_wheel: float, arc_rail: float) -> float:
    """Arclength on the wheel of the outline's point at the same lateral place as the rail's."""
    u = rail_point(rail, arc_rail).u
    for _ in range(20):
        w = locus_point(wheel, arc_wheel)
        arc_wheel -= (w.o - u) / min(w.nb, -LEAST_FACING) * -w.shrink
    return arc_wheel


@kernel
def build_axis(
    wheel: PlacedWheel, rail: Rail, arc_wheel: float, arc_rail: float, level: bool, start: float, step: float,
    axis: Records,
) -> None:  # fmt: skip
    """Rows at s = start, start + step, ... from a pair of opposite points at s = 0. level: pair as CONTACT does, see
    above; start may lie on either side of zero; axis: (rows,) of AXIS."""
    if level:
        arc_wheel = _beside(wheel, rail, arc_wheel, arc_rail)
    _e, shrink = _offset(wheel, rail, arc_wheel, arc_rail)
    position = 0.0
    for i in range(axis.size):
        goal = start + i * step
        pieces = int(abs(goal - position) / LONGEST_STEP) + 1
        piece = (goal - position) / pieces
        for _ in range(pieces):
            arc_wheel += piece * shrink
            arc_rail += piece
            for _again in range(2):
                e, shrink = _offset(wheel, rail, arc_wheel, arc_rail)
                if not level:
                    arc_wheel -= 0.5 * e * shrink
                    arc_rail += 0.5 * e
        position = goal
        row = axis[i]
        row.s = goal
        row.arc_wheel = arc_wheel
        row.arc_rail = arc_rail
        row.gap, row.x, row.o, row.b, row.no, row.nb, _sh, row.r_t, row.slope = pair(
            wheel, rail, arc_wheel, arc_rail, 0.0, 0.0
        )


@inlined
def _foot(profile: Any, u: float, w: float, arc: float) -> tuple[float, float, float, float]:
    """One Newton step to the foot of the point (u, w): its arclength, the tangent there, the height over it [m]."""
    p = profile_point(profile, arc)
    height = p.tu * (w - p.w) - p.tw * (u - p.u)
    arc += ((u - p.u) * p.tu + (w - p.w) * p.tw) / max(1.0 - p.k * height, 0.2)
    p = profile_point(profile, arc)
    return arc, p.tu, p.tw, p.tu * (w - p.w) - p.tw * (u - p.u)


@inlined
def _meet_rail(rail: Rail, row: Record) -> tuple[float, bool]:
    """Distance along a row's normal from its centre to the rail; and whether it gets there."""
    t = -0.5 * row.gap
    arc = row.arc_rail
    for _ in range(6):
        arc, tu, tw, height = _foot(rail, row.o + t * row.no, row.b + t * row.nb, arc)
        rate = tu * row.nb - tw * row.no
        if rate < LEAST_FACING:
            return t, False
        t -= height / rate
        if abs(height) < ACCURACY:
            break
    return t, abs(t) < REACH


@inlined
def _meet_wheel(wheel: PlacedWheel, point: Vec, normal: Vec, arc: float, t: float) -> tuple[float, float, bool]:
    """Distance along a normal from a point, relative to the wheel's origin, to the surface of revolution. Returns it,
    the arclength on the profile, and whether the normal gets there."""
    axial = dot(point, wheel.axle)
    facing = dot(normal, wheel.axle)
    for _ in range(12):
        along = axial + t * facing
        radial = shifted(shifted(point, t, normal), -along, wheel.axle)
        rho = norm(radial)
        out = wheel.radius - rho
        if wheel.shape.depth.shape[0] > 0:
            # theta of the point, with d0 = (0, e_z, -e_y) / q and d1 = (t - e_t e) / q
            ahead, down = radial.x, radial.y * wheel.axle.z - radial.z * wheel.axle.y
            out -= depth_at(wheel.shape, along, atan2(ahead, down) + wheel.shape.angle).d
        arc, tu, tw, height = _foot(wheel.profile, along, out, arc)
        rate = -tu * dot(radial, normal) / rho - tw * facing
        if rate < LEAST_FACING:
            return t, arc, False
        t -= height / rate
        if abs(height) < ACCURACY:
            return t, arc, abs(t) < REACH
    return t, arc, False


class Incline(NamedTuple):
    """Slope of the reference along the track, and the direction in the section in which it rises."""

    slope: float
    no: float
    nb: float


@inlined
def _centre(row: Record, incline: Incline, x: float) -> Vec:
    """Centre of a row in the section at x."""
    rise = (x - row.x) * incline.slope
    return Vec(x, row.o + rise * incline.no, row.b + rise * incline.nb)


@inlined
def _meet_section(section: Array, parts: Ints, centre: Vec, no: float, nb: float, near: float) -> tuple[float, bool]:
    """Distance along a normal from a centre to a section, of several the one nearest to ``near``; whether it gets
    there. section: (n, 4) points and tangents of any length; parts: first row of every piece, and n."""
    best, has_met = 0.0, False
    for k in range(parts.size - 1):
        u, w = section[parts[k], 0] - centre.y, section[parts[k], 1] - centre.z
        before = u * nb - w * no
        for i in range(parts[k], parts[k + 1] - 1):
            u, w = section[i + 1, 0] - centre.y, section[i + 1, 1] - centre.z
            behind = u * nb - w * no
            if before <= 0.0 < behind:
                t, facing = _within(section, i, centre, no, nb, before / (before - behind))
                if facing and abs(t) < REACH and (not has_met or abs(t - near) < abs(best - near)):
                    best, has_met = t, True
            before = behind
    return best, has_met


@inlined
def _within(section: Array, i: int, centre: Vec, no: float, nb: float, share: float) -> tuple[float, bool]:
    """Distance along a normal to the cubic between two rows, which it meets near ``share`` of the way."""
    du, dw = section[i + 1, 0] - section[i, 0], section[i + 1, 1] - section[i, 1]
    chord = sqrt(du * du + dw * dw)
    a = chord / sqrt(section[i, 2] * section[i, 2] + section[i, 3] * section[i, 3])
    b = chord / sqrt(section[i + 1, 2] * section[i + 1, 2] + section[i + 1, 3] * section[i + 1, 3])
    u = w = along = across = 0.0
    for _ in range(4):
        f, g = share, 1.0 - share
        rise, first, last = f * f * (3.0 - 2.0 * f), f * g * g * a, -f * f * g * b
        u = section[i, 0] + rise * du + first * section[i, 2] + last * section[i + 1, 2] - centre.y
        w = section[i, 1] + rise * dw + first * section[i, 3] + last * section[i + 1, 3] - centre.z
        rise, first, last = 6.0 * f * g, g * (1.0 - 3.0 * f) * a, f * (3.0 * f - 2.0) * b
        su = rise * du + first * section[i, 2] + last * section[i + 1, 2]
        sw = rise * dw + first * section[i, 3] + last * section[i + 1, 3]
        along, across = su * nb - sw * no, u * nb - w * no
        share = min(max(share - across / max(along, 1e-3 * chord), 0.0), 1.0)
    return u * no + w * nb, along > LEAST_FACING * chord


@inlined
def _meet_along(wheel: PlacedWheel, row: Record, incline: Incline, x0: float, dx: float, place: Array) -> None:
    """Distance along a row's normal from the reference to the wheel at columns x0 + i dx, to ``place``; infinite where
    the normal does not get there."""
    normal = Vec(0.0, row.no, row.nb)
    columns = place.size
    # from the outline's column to either side, each point predicted from the two before it
    middle = min(max(int((row.x - x0) / dx + 0.5), 0), columns - 1)
    for side in range(2):
        step = 1 - 2 * side
        i = middle - side
        has_met = True
        t = 0.5 * row.gap
        if side == 1:
            t = place[middle] if place[middle] < inf else 0.0
        last_t = t
        arc = last_arc = row.arc_wheel
        while 0 <= i < columns:
            if has_met:
                point = sub(_centre(row, incline, x0 + i * dx), wheel.origin)
                t, arc, has_met = _meet_wheel(wheel, point, normal, arc, t)
            place[i] = t if has_met else inf
            t, last_t = 2.0 * t - last_t, t
            arc, last_arc = 2.0 * arc - last_arc, arc
            i += step


@kernel
def fill_gap_along(
    wheel: PlacedWheel, sections: Array, parts: Ints, incline: Incline, axis: Records, x0: float, dx: float, pen: Array,
    place: Array,
) -> None:  # fmt: skip
    """As ``fill_gap`` on a rail that changes along the track. sections: (columns, n, 4), see ``_meet_section``; the
    reference is inclined, see ``Incline``."""
    for j in range(axis.size):
        row = axis[j]
        upright = 1.0 / sqrt(1.0 + row.slope * row.slope)
        _meet_along(wheel, row, incline, x0, dx, place[j])
        for i in range(pen.shape[1]):
            pen[j, i] = NO_SURFACE
            if place[j, i] == inf:
                place[j, i] = 0.0
                continue
            centre = _centre(row, incline, x0 + i * dx)
            rail_t, on_rail = _meet_section(sections[i], parts, centre, row.no, row.nb, place[j, i])
            if on_rail:
                pen[j, i] = (rail_t - place[j, i]) * upright


@kernel
def fill_gap(wheel: PlacedWheel, rail: Rail, axis: Records, x0: float, dx: float, pen: Array, place: Array) -> None:
    """Interpenetration of the undeformed bodies along the rows' normals. axis: from build_axis; columns at x0 + i dx;
    pen: (rows, columns) [m], negative where a gap is open; place: the same shape, distance along the normal from the
    reference to the wheel's surface [m]."""
    level = Incline(0.0, 0.0, 0.0)
    for j in range(axis.size):
        row = axis[j]
        rail_t, on_rail = _meet_rail(rail, row)
        if on_rail:
            _meet_along(wheel, row, level, x0, dx, place[j])
        for i in range(pen.shape[1]):
            met = on_rail and place[j, i] < inf
            pen[j, i] = rail_t - place[j, i] if met else NO_SURFACE
            place[j, i] = place[j, i] if met else 0.0
