"""The curved contact patch: strips across, gap along the bisector of the normals.

The curved axis s starts at the main contact point, where the profiles are moved apart by the approach until they
touch. Points of equal arclength on the rail and on the outline of the wheel belong together [S 21]; their gap is
measured along the bisector of the two normals [S 22]; the strip's centre is their middle [S 26]. The middle line's
tangent is the mean of the two unit tangents, because each curve is followed at unit speed, so the strip's normal is
the bisector itself: [S 27] without a difference quotient.

A strip is in contact where h(s) = eps delta c(s) - g(s) > 0, with c = 1 for the paper's constant approach and
c = cos(theta(s) - theta0) for a rigid approach delta along the main normal ("projected"). Written with the
penetration delta c - g of the undeformed profiles this is h = (delta c - g) - recess c, recess = (1 - eps) delta; a
lobe beside a deeper one takes part of that one's recess (see core.contact.search.lobes).
"""

from math import sqrt

from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.layout import DS, NB, NO, PENETRATION, RADIUS_T, A, B, O, S, X
from wrsim.core.contact.profile import profile_point
from wrsim.core.contact.search.locus import locus_point


@inlined
def pair(wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q, wheel_arc, rail_arc, delta, n0o, n0b):
    """A pair of points of equal arclength.

    delta and (n0o, n0b): approach and normal (rail to wheel) at the main point.
    Returns (gap, x, o, b, normal_o, normal_b, shrink, r_t): gap [m] with the wheel moved out by the approach; strip
    centre in rail axes at the true position; unit normal of the strip from rail to wheel.
    """
    x, wo, wb, no, nb, shrink, rt, _k = locus_point(wheel, wheel_step, radius, ox, oo, ob, et, eo, eb, q, wheel_arc)
    ro, rb, tu, tw, _kr = profile_point(rail, rail_step, rail_arc)
    # |n_r - n_w|^2 = 4 - |n_r + n_w|^2 and the sum is small: a series replaces root and division
    po = no - tw
    pb = nb + tu
    t = 0.25 * (po * po + pb * pb)
    if t < 1e-3:
        inverse = 0.5 + t * (0.25 + t * (0.1875 + t * (0.15625 + t * 0.13671875)))
    else:
        inverse = 0.5 / sqrt(1.0 - t)
    mo = (-tw - no) * inverse
    mb = (tu - nb) * inverse
    gap = (wo + delta * n0o - ro) * mo + (wb + delta * n0b - rb) * mb
    return gap, x, 0.5 * (wo + ro), 0.5 * (wb + rb), mo, mb, shrink, rt


@kernel
def find_edge(
    wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q,
    wheel_arc, rail_arc, delta, n0o, n0b, recess, projected, first, direction, limit,
):  # fmt: skip
    """Edge of the patch on one side of the main point: the first zero of h(s).

    recess: how far the deformed surface lies behind the undeformed one [m]; first: first step along s [m];
    direction: +1 outward, -1 towards the flange; limit: largest |s|, where a neighbouring lobe begins.
    Returns (s, status): status 0, or 1 when the end of a profile was reached before h vanished.
    """
    inner = 0.0
    inner_arc = wheel_arc
    inner_h = delta - recess
    step = first
    wheel_end = (wheel.shape[0] - 1) * wheel_step
    rail_end = (rail.shape[0] - 1) * rail_step
    # the wheel's arclength follows that of its outline by extrapolated midpoint steps of the shrink
    shrink = 1.0
    if et != 0.0:
        _x, _o, _b, _no, _nb, shrink, _rt, _k = locus_point(
            wheel, wheel_step, radius, ox, oo, ob, et, eo, eb, q, wheel_arc
        )
    last_shrink = shrink
    outer = 0.0
    outer_h = 0.0
    while True:
        outer = min(inner + step, limit)
        mid = 1.5 * shrink - 0.5 * last_shrink
        outer_arc = inner_arc + direction * step * mid
        gap, _x, _o, _b, mo, mb, new_shrink, _rt = pair(
            wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q,
            outer_arc, rail_arc + direction * outer, delta, n0o, n0b,
        )  # fmt: skip
        c = mo * n0o + mb * n0b if projected else 1.0
        outer_h = (delta - recess) * c - gap
        if outer_h <= 0.0:
            break
        if outer >= limit:
            return direction * limit, 0
        if (
            outer_arc <= 0.0
            or outer_arc >= wheel_end
            or rail_arc + direction * outer <= 0.0
            or rail_arc + direction * outer >= rail_end
        ):
            return direction * outer, 1
        inner = outer
        inner_arc = outer_arc
        inner_h = outer_h
        last_shrink = shrink
        shrink = new_shrink
    # Illinois' regula falsi between inner (h > 0) and outer (h <= 0), in s^2, where h is nearly linear
    lo = inner
    hi = outer
    lo_h = inner_h
    hi_h = outer_h
    s = hi
    side = 0
    mid = 1.5 * shrink - 0.5 * last_shrink
    for _ in range(60):
        s = sqrt((lo * lo * hi_h - hi * hi * lo_h) / (hi_h - lo_h))
        arc = inner_arc + direction * (s - inner) * mid
        gap, _x, _o, _b, mo, mb, _sh, _rt = pair(
            wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q,
            arc, rail_arc + direction * s, delta, n0o, n0b,
        )  # fmt: skip
        c = mo * n0o + mb * n0b if projected else 1.0
        h = (delta - recess) * c - gap
        if abs(h) < 1e-7 * delta or hi - lo < 1e-12:
            break
        if h > 0.0:
            lo = s
            lo_h = h
            if side == 1:
                hi_h *= 0.5
            side = 1
        else:
            hi = s
            hi_h = h
            if side == -1:
                lo_h *= 0.5
            side = -1
    return direction * s, 0


@kernel
def lay_strips(
    wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q,
    wheel_arc, rail_arc, delta, n0o, n0b, recess, projected, start, end, n, strips,
):  # fmt: skip
    """Fill ``n`` strips of equal width between the edges ``start`` < 0 < ``end``.

    Writes per strip S (centre), DS (width), X, O, B (centre in rail axes), NO, NB (normal), RADIUS_T (radius of
    curvature along t) and, as A, the half length sqrt(2 h r_t) of [S 25] with R_w^x = r_t [S 19, 20].
    Returns the half length at the main point.
    """
    width = (end - start) / n
    _x, _o, _b, _no, _nb, shrink0, rt0, _k = locus_point(
        wheel, wheel_step, radius, ox, oo, ob, et, eo, eb, q, wheel_arc
    )
    main = int(-start / width)  # the strip that holds s = 0
    for sweep in range(2):
        direction = 1 if sweep == 0 else -1
        i = main if sweep == 0 else main - 1
        arc = wheel_arc
        at = 0.0
        shrink = shrink0
        last = shrink0
        while 0 <= i < n:
            s = start + (i + 0.5) * width
            # Adams-Bashforth over the shrink: second order with one evaluation a strip
            arc += (s - at) * (1.5 * shrink - 0.5 * last)
            at = s
            gap, x, o, b, mo, mb, new_shrink, rt = pair(
                wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q,
                arc, rail_arc + s, delta, n0o, n0b,
            )  # fmt: skip
            last = shrink
            shrink = new_shrink
            c = mo * n0o + mb * n0b if projected else 1.0
            h = (delta - recess) * c - gap
            row = strips[i]
            row[PENETRATION] = delta * c - gap
            row[S] = s
            row[DS] = width
            row[X] = x
            row[A] = sqrt(2.0 * h * rt) if h > 0.0 else 0.0
            row[O] = o
            row[B] = b
            row[NO] = mo
            row[NB] = mb
            row[RADIUS_T] = rt
            i += direction
    return sqrt(2.0 * (delta - recess) * rt0)
