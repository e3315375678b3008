"""Curved reference surface of a patch and the exact gap of wheel and rail over it.

The reference is the middle of the rail profile and the wheel's outline (core.contact.search.locus), swept along the
rail: rows at equal steps of the curved axis s, columns at equal steps of x. A row's normal is the bisector of the two
profiles' normals. Along the axis points of rail and wheel are kept opposite each other: half of any tangential offset
goes to either profile, so that the pairs stay true far from the main point too. CONTACT pairs them by arclength from
two points of the same lateral place instead (``level``); on a flank of angle a these are offset by the approach times
tan(a) and the normals err by a quarter of that times the difference of the curvatures. Offered for comparison only.

The gap is measured along the row's normal from the rail to the surface of revolution itself, not to a parabola: yaw
needs no shift of rows, the true surface of a yawed flange lies skewed on the grid.
"""

from math import sqrt

from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.patch import pair
from wrsim.core.contact.profile import profile_point
from wrsim.core.contact.search.locus import locus_point

# a row of the axis: s, centre (o, b), normal from rail to wheel (o, b), arclengths on wheel and rail, gap along the
# normal of the true position (negative: interpenetration), x of the outline
AT_S, AT_O, AT_B, AT_NO, AT_NB, AT_WHEEL, AT_RAIL, AT_GAP, AT_X, AT_RADIUS = range(10)
AXIS_COLUMNS = 10

NO_SURFACE = -1.0  # interpenetration where the normal meets no wheel or no rail [m]
ACCURACY = 2e-10  # of the gap [m]
REACH = 0.02  # farthest surface looked for [m]
LEAST_FACING = 0.05  # cosine of the angle between a row's normal and a surface's


@inlined
def _offset(wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q, wheel_arc, rail_arc):
    """How far the wheel's point lies ahead of the rail's, along the mean tangent [m], and the wheel's shrink."""
    _x, wo, wb, no, nb, shrink, _rt, _k = locus_point(wheel, wheel_step, radius, ox, oo, ob, et, eo, eb, q, wheel_arc)
    ro, rb, tu, tw, _kr = profile_point(rail, rail_step, rail_arc)
    to = 0.5 * (tu - nb)
    tb = 0.5 * (tw + no)
    inverse = 1.0 / max(sqrt(to * to + tb * tb), 0.1)
    return ((wo - ro) * to + (wb - rb) * tb) * inverse, shrink


@kernel
def lay_axis(wheel, wheel_step, radius, rail, rail_step, pose, wheel_arc, rail_arc, level, start, step, n, axis):
    """Rows at s = start, start + step, ... (n of them) from a pair of opposite points at s = 0.

    pose: see core.contact.layout; level: pair as CONTACT does, see above; start may lie on either side of zero;
    axis: (>= n, AXIS_COLUMNS). The way to the first row and between rows is walked in pieces of at most 0.25 mm.
    """
    ox, oo, ob, et, eo, eb = pose[0], pose[1], pose[2], pose[3], pose[4], pose[5]
    q = sqrt(1.0 - et * et)
    if level:
        u, _w, _tu, _tw, _k = profile_point(rail, rail_step, rail_arc)
        for _ in range(20):
            _x, wo, _wb, _no, nb, shrink, _rt, _k = locus_point(
                wheel, wheel_step, radius, ox, oo, ob, et, eo, eb, q, wheel_arc
            )
            wheel_arc -= (wo - u) / min(nb, -LEAST_FACING) * -shrink
    _e, shrink = _offset(wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q, wheel_arc, rail_arc)
    at = 0.0
    for i in range(n):
        goal = start + i * step
        pieces = int(abs(goal - at) / 2.5e-4) + 1
        piece = (goal - at) / pieces
        for _ in range(pieces):
            wheel_arc += piece * shrink
            rail_arc += piece
            for _again in range(2):
                e, shrink = _offset(
                    wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q, wheel_arc, rail_arc
                )
                if not level:
                    wheel_arc -= 0.5 * e * shrink
                    rail_arc += 0.5 * e
        at = goal
        gap, x, o, b, mo, mb, _sh, rt = pair(
            wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q, wheel_arc, rail_arc, 0.0, 0.0, 1.0
        )
        row = axis[i]
        row[AT_S] = goal
        row[AT_O] = o
        row[AT_B] = b
        row[AT_NO] = mo
        row[AT_NB] = mb
        row[AT_WHEEL] = wheel_arc
        row[AT_RAIL] = rail_arc
        row[AT_GAP] = gap
        row[AT_X] = x
        row[AT_RADIUS] = rt


@inlined
def _meet_rail(rail, rail_step, o, b, no, nb, arc, t):
    """Distance t along the normal from (o, b) to the rail; and whether there is one."""
    for _ in range(6):
        po = o + t * no
        pb = b + t * nb
        u, w, tu, tw, k = profile_point(rail, rail_step, arc)
        d = tu * (pb - w) - tw * (po - u)
        arc += ((po - u) * tu + (pb - w) * tw) / max(1.0 - k * d, 0.2)
        u, w, tu, tw, k = profile_point(rail, rail_step, arc)
        d = tu * (pb - w) - tw * (po - u)
        rate = tu * nb - tw * no
        if rate < LEAST_FACING:
            return t, False
        t -= d / rate
        if abs(d) < ACCURACY:
            break
    return t, abs(t) < REACH


@inlined
def _meet_wheel(wheel, wheel_step, radius, eo, eb, ne, et, px, po, pb, no, nb, arc, t):
    """Distance t along the normal from (px, po, pb), relative to the wheel's origin, to the surface of revolution.

    ne: normal times axle. Returns (t, arclength on the profile, whether there is one).
    """
    axial = px * et + po * eo + pb * eb
    for _ in range(12):
        along = axial + t * ne
        rx = px - along * et
        ro = po + t * no - along * eo
        rb = pb + t * nb - along * eb
        rad = sqrt(rx * rx + ro * ro + rb * rb)
        f = radius - rad
        u, w, tu, tw, k = profile_point(wheel, wheel_step, arc)
        d = tu * (f - w) - tw * (along - u)
        arc += ((along - u) * tu + (f - w) * tw) / max(1.0 - k * d, 0.2)
        u, w, tu, tw, k = profile_point(wheel, wheel_step, arc)
        d = tu * (f - w) - tw * (along - u)
        rate = -tu * (ro * no + rb * nb) / rad - tw * ne
        if rate < LEAST_FACING:
            return t, arc, False
        t -= d / rate
        if abs(d) < ACCURACY:
            return t, arc, abs(t) < REACH
    return t, arc, False


@kernel
def fill_gap(wheel, wheel_step, radius, rail, rail_step, pose, axis, rows, x0, dx, pen, place):
    """Interpenetration of the undeformed bodies along the rows' normals.

    axis: from lay_axis; columns at x0 + i dx; pen: (rows, columns) [m], negative where a gap is open; place: the same
    shape, distance along the normal from the reference to the wheel's surface [m].
    Returns the number of points whose normal meets no wheel or no rail.
    """
    ox, oo, ob, et, eo, eb = pose[0], pose[1], pose[2], pose[3], pose[4], pose[5]
    columns = pen.shape[1]
    lost = 0
    for j in range(rows):
        row = axis[j]
        o, b, no, nb = row[AT_O], row[AT_B], row[AT_NO], row[AT_NB]
        ne = no * eo + nb * eb
        rail_t, met = _meet_rail(rail, rail_step, o, b, no, nb, row[AT_RAIL], -0.5 * row[AT_GAP])
        # from the outline's column to either side, each point foretold by the two before it
        middle = min(max(int((row[AT_X] - x0) / dx + 0.5), 0), columns - 1)
        for side in range(2):
            t = 0.5 * row[AT_GAP] if side == 0 else place[j, middle]
            arc = row[AT_WHEEL]
            last_t = t
            last_arc = arc
            i = middle if side == 0 else middle - 1
            found = met
            while 0 <= i < columns:
                if found:
                    t, arc, found = _meet_wheel(
                        wheel, wheel_step, radius, eo, eb, ne, et, x0 + i * dx - ox, o - oo, b - ob, no, nb, arc, t
                    )
                if found:
                    pen[j, i] = rail_t - t
                    place[j, i] = t
                    guess = 2.0 * t - last_t
                    last_t = t
                    t = guess
                    guess = 2.0 * arc - last_arc
                    last_arc = arc
                    arc = guess
                else:
                    lost += 1
                    pen[j, i] = NO_SURFACE
                    place[j, i] = 0.0
                i += 1 if side == 0 else -1
    return lost
