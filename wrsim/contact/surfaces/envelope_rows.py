"""Rows of the effective profile (surf-envelope) of a rail that changes along the track, from the cubics of its pieces:
where a wheel touches each row, how steep and how bent the rail is there along the track, and which rows it never meets.

`surfaces.rolled_rail` makes the tables of these, which `surfaces.rail` reads.
"""

from math import atan2, inf, sqrt
from typing import NamedTuple

from wrsim.contact.surfaces.rail import DEPTHS, LEAST_PARTING, MEAN_GAP
from wrsim.jit import Array, Bools, Ints, inlined, kernel
from wrsim.jit.root import Bracket, crossing, interval, narrowed

PLACES = 61  # at least, at which a contact is looked for before it is found to round-off
FALL = 3.0  # slope with which a piece falls off behind its ends
LONGEST = 0.03  # half length of contact [m]
BESIDE = 1e-4  # half the distance of rows [m]
ENVELOPE = ("u", "w", "tu", "tw", "ahead", "slope", "bend", "bend_deep", "lean", "within_reach")  # of `envelope_rows`
WITHIN_REACH = len(ENVELOPE) - 1
LONGEST_LOOP = 100  # rows that run backwards where two branches cross


class Heading(NamedTuple):
    """A direction in plan: sine and cosine of its angle to the track, outward."""

    sine: float
    cosine: float


class Row(NamedTuple):
    """State of a row at some distance ahead, in axes turned by a heading: place ahead; point (u, w) lowered by the
    wheel's drop, tangent; along the track the rates of place and point without the drop's; how fast the lowered point
    still rises along its normal."""

    ahead: float
    u: float
    w: float
    tu: float
    tw: float
    da: float
    du: float
    dw: float
    miss: float


@inlined
def _cubic(c: Array, i: int, row: int, column: int, x: float) -> tuple[float, float]:
    """Value and slope of a cubic of interval i."""
    c3, c2, c1, c0 = c[0, i, row, column], c[1, i, row, column], c[2, i, row, column], c[3, i, row, column]
    return c0 + x * (c1 + x * (c2 + x * c3)), c1 + x * (2.0 * c2 + 3.0 * x * c3)


@inlined
def _lowered_row(
    c: Array, knots: Array, ends: Array, row: int, s: float, x: float, radius: float, i: int, heading: Heading
) -> Row:
    """A row at s + x, which lies in interval i."""
    at = s + x
    inside = min(max(at, knots[0]), knots[knots.size - 1])
    beyond = at - inside
    y = inside - knots[i]
    u, du = _cubic(c, i, row, 0, y)
    w, dw = _cubic(c, i, row, 1, y)
    tu, tw = _cubic(c, i, row, 2, y)[0], _cubic(c, i, row, 3, y)[0]
    if beyond != 0.0:
        du = dw = 0.0
        if (beyond < 0.0 and ends[0] > 0.0) or (beyond > 0.0 and ends[1] > 0.0):
            w -= FALL * abs(beyond)
            dw = -FALL if beyond > 0.0 else FALL
    ahead, da = x * heading.cosine + u * heading.sine, heading.cosine + du * heading.sine
    u, du = u * heading.cosine - x * heading.sine, du * heading.cosine - heading.sine
    tu *= heading.cosine
    length = sqrt(tu * tu + tw * tw)
    tu, tw = tu / length, tw / length
    root = sqrt(radius * radius - ahead * ahead)
    miss = -tw * du + tu * (dw - ahead / root * da)
    return Row(ahead, u, w - (radius - root), tu, tw, da, du, dw, miss)


@inlined
def _own_curvature(c: Array, row: int, y: float, i: int, cosine: float) -> float:
    """Curvature at a row of the section at y in interval i [1/m]: how its tangent turns from the row before to the one
    behind, over their distance."""
    p, q = max(row - 1, 0), min(row + 1, c.shape[2] - 1)
    pu, pw = cosine * _cubic(c, i, p, 2, y)[0], _cubic(c, i, p, 3, y)[0]
    qu, qw = cosine * _cubic(c, i, q, 2, y)[0], _cubic(c, i, q, 3, y)[0]
    du = cosine * (_cubic(c, i, q, 0, y)[0] - _cubic(c, i, p, 0, y)[0])
    dw = _cubic(c, i, q, 1, y)[0] - _cubic(c, i, p, 1, y)[0]
    return atan2(pu * qw - pw * qu, pu * qu + pw * qw) / max(sqrt(du * du + dw * dw), 1e-9)


@kernel
def _rise(
    c: Array, knots: Array, ends: Array, row: int, s: float, x: float, radius: float, i: int, heading: Heading, at: Row
) -> float:  # fmt: skip
    """How far the rail at x rises over the tangent along the track at a row, over the square of the way to there
    [1/m]."""
    i = interval(knots, s + x, i)
    step, best, height, ahead = 0, inf, 0.0, 1.0
    while 0 <= row + step < c.shape[2] and best > BESIDE:
        there = _lowered_row(c, knots, ends, row + step, s, x, radius, i, heading)
        drop = sqrt(radius * radius - at.ahead * at.ahead) - sqrt(radius * radius - there.ahead * there.ahead)
        du, dw = there.u - at.u, there.w + drop - at.w
        aside = du * at.tu + dw * at.tw
        if abs(aside) >= best:
            break
        y = min(max(s + x, knots[0]), knots[knots.size - 1]) - knots[i]
        leans = (at.tu * there.tw - at.tw * there.tu) / max(at.tu * there.tu + at.tw * there.tw, LEAST_PARTING)
        bow = 0.5 * _own_curvature(c, row + step, y, i, heading.cosine)
        best, height, ahead = (
            abs(aside),
            at.tu * dw - at.tw * du - aside * (leans - aside * bow),
            there.ahead - at.ahead,
        )
        step += 1 if aside < 0.0 else -1
    return (height - (at.tu * at.dw - at.tw * at.du) / at.da * ahead) / (ahead * ahead)


@kernel
def _mean_bend(
    c: Array, knots: Array, ends: Array, row: int, s: float, x: float, depth: float, radius: float, i: int,
    heading: Heading, at: Row,
) -> tuple[float, float]:  # fmt: skip
    """Curvature along the track over a contact this deep about a row that is touched at x [1/m], and the slope between
    the ends of that (surf-parting)."""
    k, goal = max(at.tu, LEAST_PARTING) / radius, MEAN_GAP * depth
    bracket = Bracket(0.0, goal, LONGEST, -inf, 0)
    b, ahead, behind = sqrt(goal / k), 0.0, 0.0
    for _ in range(8):
        ahead = _rise(c, knots, ends, row, s, x + b, radius, i, heading, at)
        behind = _rise(c, knots, ends, row, s, x - b, radius, i, heading, at)
        left = goal - b * b * (k - ahead - behind)
        if abs(left) < 0.01 * goal or b == LONGEST:
            break
        bracket = narrowed(bracket, b, left)
        b = min(1.5 * b, LONGEST) if bracket.hi_h == -inf else crossing(bracket)
    return ahead + behind, 0.5 * b * (ahead - behind)


@inlined
def _next(knots: Array, s: float, i: int, step: float) -> float:
    """The next place to look at: every knot and the middle between two of them are among these."""
    if s < knots[0] or s >= knots[knots.size - 1]:
        return min(s + step, knots[0]) if s < knots[0] - 1e-9 else s + step
    half = 0.5 * (knots[i + 1] - knots[i])
    end = knots[i] + half if s < knots[i] + half - 1e-9 else knots[i + 1]
    return min(s + step, end) if end > s + 1e-9 else s + 1e-9


@kernel
def envelope_rows(
    c: Array, knots: Array, ends: Array, s: float, radius: float, reach: float, heading: Heading, rows: Ints, out: Array
) -> None:
    """The effective profile of a piece at s in axes turned by a heading, one row of ``out``, ENVELOPE, for each of its
    rows from the first to before the last of ``rows`` (2,): u, w, tu, tw, how far ahead it is touched, slope,
    curvatures and lean of ``Envelope`` along the axes, along its normal; whether it was found within reach.

    c, knots: of the cubics (4, m, n, 4), (m + 1,); ends: (2,), above 0 where the piece falls off.
    """
    step = 2.0 * reach / (PLACES - 1)
    for row in range(rows[0], rows[1]):
        i = interval(knots, s, 0)
        axle = _lowered_row(c, knots, ends, row, s, 0.0, radius, i, heading)
        best, low, high, within_reach = -inf, 0.0, 0.0, 0.0
        farthest, place = -inf, 0.0
        before = out_before = 0.0
        i = interval(knots, s - reach, i)
        x = last = -reach
        while x <= reach:
            i = interval(knots, s + x, i)
            at = _lowered_row(c, knots, ends, row, s, x, radius, i, heading)
            height = axle.tu * at.w - axle.tw * at.u
            if height > farthest:
                farthest, place = height, x
            if before > 0.0 and at.miss <= 0.0 and max(height, out_before) > best:
                best, low, high, within_reach = max(height, out_before), last, x, 1.0
            before, out_before, last = at.miss, height, x
            x = _next(knots, s + x, i, step) - s
        x = place
        if within_reach > 0.0:
            for _ in range(50):
                x = 0.5 * (low + high)
                i = interval(knots, s + x, i)
                if _lowered_row(c, knots, ends, row, s, x, radius, i, heading).miss > 0.0:
                    low = x
                else:
                    high = x
        i = interval(knots, s + x, i)
        at = _lowered_row(c, knots, ends, row, s, x, radius, i, heading)
        envelope = out[row]
        envelope[0], envelope[1], envelope[2], envelope[3], envelope[4] = at.u, at.w, at.tu, at.tw, at.ahead
        envelope[5] = (at.tu * at.dw - at.tw * at.du) / at.da
        for k in range(2):
            envelope[6 + k], lean = _mean_bend(c, knots, ends, row, s, x, DEPTHS[k], radius, i, heading, at)
        envelope[8], envelope[WITHIN_REACH] = lean / DEPTHS[1], within_reach


@kernel
def unfold(rows: Array, anchor: int, lowest: float, keep: Bools) -> None:
    """Mark in ``keep`` (n,) the rows that follow each other from the anchor to both sides, down to a height. Where two
    branches of the effective profile cross, rows run on beneath the other branch, backwards, and forwards again on that
    one: what lies beyond the crossing on the first and before it on the second is left out."""
    keep[:] = False
    keep[anchor] = True
    for way in (1, -1):
        last, i = anchor, anchor + way
        while 0 <= i < rows.shape[0] and rows[i, 1] > lowest:
            du, dw = way * (rows[i, 0] - rows[last, 0]), way * (rows[i, 1] - rows[last, 1])
            forward = du * rows[last, 2] + dw * rows[last, 3]
            if forward > 1e-6 and du * rows[i, 2] + dw * rows[i, 3] > 1e-6:
                keep[i] = True
                last = i
            elif (i - last) * way <= LONGEST_LOOP:
                back = _crossed(rows, i, way, anchor, keep)
                if back != i:
                    k = last
                    while k != back:
                        keep[k] = False
                        k -= way
                    last = back
            i += way


@kernel
def _crossed(rows: Array, i: int, way: int, anchor: int, keep: Bools) -> int:
    """The last row that is kept before the way from row i to the next crosses what is kept; i if it does not."""
    if not 0 <= i + way < rows.shape[0]:
        return i
    au, aw, bu, bw = rows[i, 0], rows[i, 1], rows[i + way, 0], rows[i + way, 1]
    before = i
    k, steps = i - way, 0
    while (k - anchor) * way >= 0 and steps < 2 * LONGEST_LOOP:
        if keep[k]:
            if before != i:
                cu, cw, du, dw = rows[k, 0], rows[k, 1], rows[before, 0], rows[before, 1]
                one = (bu - au) * (cw - aw) - (bw - aw) * (cu - au)
                other = (bu - au) * (dw - aw) - (bw - aw) * (du - au)
                third = (du - cu) * (aw - cw) - (dw - cw) * (au - cu)
                fourth = (du - cu) * (bw - cw) - (dw - cw) * (bu - cu)
                if one * other < 0.0 and third * fourth <= 0.0:
                    return k
            before = k
        k -= way
        steps += 1
    return i
