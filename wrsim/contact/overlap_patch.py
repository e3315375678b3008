"""The curved contact patch: strips across, gap along the bisector of the normals.

The curved axis s starts at the main contact point, where the profiles are moved apart by the approach until they
touch. Points of equal arclength on the rail and on the outline of the wheel belong together [S 21]; their gap is
measured along the bisector of the two normals [S 22]; the strip's centre is their middle [S 26]. The middle line's
tangent is the mean of the two unit tangents, because each curve is followed at unit speed, so the strip's normal is
the bisector itself: [S 27] without a difference quotient.

A strip is in contact where h(s) > 0 (norm-h), for the approach of (norm-c). Written with the penetration delta c - g of
the undeformed profiles this is h = (delta c - g) - recess c, recess = (1 - eps) delta; a lobe beside a deeper one takes
part of that one's recess (see contact.search.lobes).
"""

from math import sqrt
from typing import NamedTuple

from wrsim.contact.records import PlacedWheel, Rail
from wrsim.contact.search.locus import Locus, locus_point
from wrsim.contact.surfaces.profile_table import ProfilePoint, length
from wrsim.contact.surfaces.rail import along, parting, rail_and_envelope, rail_length
from wrsim.jit import Record, Records, inlined, kernel
from wrsim.jit.root import Bracket, crossing, narrowed


class Pair(NamedTuple):
    """A pair of opposite points: gap [m]; strip centre (x, o, b) in rail axes; unit normal of the strip from rail to
    wheel; the wheel's shrink (`search.locus`); radius of the curvature with which both part along t [m]; slope of the
    rail along the track."""

    gap: float
    x: float
    o: float
    b: float
    no: float
    nb: float
    shrink: float
    r_t: float
    slope: float


@inlined
def bisector(w: Locus, r: ProfilePoint) -> tuple[float, float]:
    """Unit normal (no, nb) from rail to wheel that bisects those of two points, a Locus and one of the rail's profile.

    |n_r - n_w|^2 = 4 - |n_r + n_w|^2 and the sum is small: a series replaces root and division.
    """
    po = w.no - r.tw
    pb = w.nb + r.tu
    t = 0.25 * (po * po + pb * pb)
    if t < 1e-3:
        inverse = 0.5 + t * (0.25 + t * (0.1875 + t * (0.15625 + t * 0.13671875)))
    else:
        inverse = 0.5 / sqrt(max(1.0 - t, 1e-6))
    return (-r.tw - w.no) * inverse, (r.tu - w.nb) * inverse


@inlined
def first_step(depth: float, curvature: float) -> float:
    """First step towards an edge [m]: half of the half width that the relative curvature at the main point promises."""
    return min(max(0.55 * sqrt(2.0 * depth / max(curvature, 0.5)), 2e-5), 4e-3)


@inlined
def pair(wheel: PlacedWheel, rail: Rail, arc_wheel: float, arc_rail: float, out_o: float, out_b: float) -> Pair:
    """The pair of points at these arclengths; the gap with the wheel moved out by (out_o, out_b), else as it is."""
    w = locus_point(wheel, arc_wheel)
    r, envelope = rail_and_envelope(rail, arc_rail)
    no, nb = bisector(w, r)
    gap = (w.o + out_o - r.u) * no + (w.b + out_b - r.w) * nb
    at = along(rail, envelope, r, w.x, w.to_axle)
    r_t, farther = parting(w.r_t, envelope, out_o * no + out_b * nb - gap)
    return Pair(
        gap, w.x + at.ahead + farther, 0.5 * (w.o + r.u), 0.5 * (w.b + r.w) + at.drop, no, nb, w.shrink,
        r_t, at.slope,
    )  # fmt: skip


@inlined
def _share(lobe: Record, projected: int, pair: Pair) -> float:
    """c (norm-c): share of the approach that closes the gap at a pair of points."""
    return pair.no * lobe.no + pair.nb * lobe.nb if projected else 1.0


@inlined
def _opposite(wheel: PlacedWheel, rail: Rail, lobe: Record, arc_wheel: float, s: float) -> Pair:
    """The pair at s along the curved axis, with the wheel moved out by the approach."""
    return pair(wheel, rail, arc_wheel, lobe.arc_rail + s, lobe.approach * lobe.no, lobe.approach * lobe.nb)


@kernel
def find_edge(
    wheel: PlacedWheel, rail: Rail, lobe: Record, projected: int, first: float, direction: float, limit: float
) -> tuple[float, int]:
    """Edge of the patch on one side of the main point: the first zero of h(s) (norm-h).

    lobe: its main point, approach and recess; first: first step along s [m]; direction: +1.0 outward, -1.0 towards the
    flange; limit: largest |s|, where a neighbouring lobe begins.
    Returns (s, status): status 0, or 1 when the end of a profile was reached before h vanished.
    """
    delta = lobe.approach
    inner = 0.0
    inner_arc = lobe.arc_wheel
    inner_h = delta - lobe.recess
    step = first
    wheel_end = length(wheel.profile)
    rail_end = rail_length(rail)
    # the wheel's arclength follows that of its outline by extrapolated midpoint steps of the shrink
    shrink = 1.0
    if wheel.axle.x != 0.0 or wheel.shape.depth.shape[0] > 0:
        shrink = locus_point(wheel, lobe.arc_wheel).shrink
    last_shrink = shrink
    while True:
        outer = min(inner + step, limit)
        outer_arc = inner_arc + direction * step * (1.5 * shrink - 0.5 * last_shrink)
        at = _opposite(wheel, rail, lobe, outer_arc, direction * outer)
        outer_h = (delta - lobe.recess) * _share(lobe, projected, at) - at.gap
        if outer_h <= 0.0:
            break
        if outer >= limit:
            return direction * limit, 0
        on_rail = lobe.arc_rail + direction * outer
        if outer_arc <= 0.0 or outer_arc >= wheel_end or on_rail <= 0.0 or on_rail >= rail_end:
            return direction * outer, 1
        inner = outer
        inner_arc = outer_arc
        inner_h = outer_h
        last_shrink = shrink
        shrink = at.shrink
    bracket = Bracket(inner, inner_h, outer, outer_h, 0)
    s = outer
    mid = 1.5 * shrink - 0.5 * last_shrink
    for _ in range(60):
        s = crossing(bracket)
        at = _opposite(wheel, rail, lobe, inner_arc + direction * (s - inner) * mid, direction * s)
        h = (delta - lobe.recess) * _share(lobe, projected, at) - at.gap
        if abs(h) < 1e-7 * delta or bracket.hi - bracket.lo < 1e-12:
            break
        bracket = narrowed(bracket, s, h)
    return direction * s, 0


@kernel
def fill_strips(wheel: PlacedWheel, rail: Rail, lobe: Record, projected: int, n: int, strips: Records) -> float:
    """Fill ``n`` strips of equal width between the lobe's edges, start < 0 < end. Writes per strip s, ds, x, o, b, no,
    nb, r_t, penetration and, as a, the half length sqrt(2 h r_t) of [S 25] with R_w^x = r_t [S 19, 20]. Returns the
    half length at the main point."""
    delta = lobe.approach
    width = (lobe.end - lobe.start) / n
    main_point = locus_point(wheel, lobe.arc_wheel)
    main = int(-lobe.start / width)  # the strip that holds s = 0
    for sweep in range(2):
        direction = 1 if sweep == 0 else -1
        i = main if sweep == 0 else main - 1
        arc = lobe.arc_wheel
        at_s = 0.0
        shrink = last = main_point.shrink
        while 0 <= i < n:
            s = lobe.start + (i + 0.5) * width
            # Adams-Bashforth over the shrink: second order with one evaluation a strip
            arc += (s - at_s) * (1.5 * shrink - 0.5 * last)
            at_s = s
            at = _opposite(wheel, rail, lobe, arc, s)
            last = shrink
            shrink = at.shrink
            c = _share(lobe, projected, at)
            h = (delta - lobe.recess) * c - at.gap
            strip = strips[i]
            strip.penetration = delta * c - at.gap
            strip.s = s
            strip.ds = width
            strip.x = at.x
            strip.a = sqrt(2.0 * h * at.r_t) if h > 0.0 else 0.0
            strip.o = at.o
            strip.b = at.b
            strip.no = at.no
            strip.nb = at.nb
            strip.slope = at.slope
            strip.r_t = at.r_t
            i += direction
    envelope = rail_and_envelope(rail, lobe.arc_rail)[1]
    return sqrt(2.0 * (delta - lobe.recess) * parting(main_point.r_t, envelope, delta)[0])
