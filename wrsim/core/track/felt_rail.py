"""Where a wheel touches a rail whose profile changes along the track: see `wrsim.geometry.track.rolled_rail`."""

from math import atan2, inf, sqrt
from typing import NamedTuple

from wrsim.core.compiling import inlined, kernel
from wrsim.core.root import interval

PLACES = 61  # at least, at which a contact is looked for before it is found to round-off
FALL = 3.0  # slope with which a piece falls off behind its ends
LONGEST_LOOP = 100  # rows that run backwards where two branches cross


class Felt(NamedTuple):
    """Of a row at some distance ahead: point (u, w) lowered by the wheel's drop, tangent, their rates along the track
    without the drop's, second derivative of the point; how fast the lowered point still rises along its normal."""

    u: float
    w: float
    tu: float
    tw: float
    du: float
    dw: float
    ddu: float
    ddw: float
    dtu: float
    dtw: float
    miss: float


@inlined
def _cubic(c, i, row, column, x):
    """Value and two derivatives of a cubic of interval i."""
    c3, c2, c1, c0 = c[0, i, row, column], c[1, i, row, column], c[2, i, row, column], c[3, i, row, column]
    return c0 + x * (c1 + x * (c2 + x * c3)), c1 + x * (2.0 * c2 + 3.0 * x * c3), 2.0 * c2 + 6.0 * x * c3


@inlined
def _felt(c, knots, ends, row, s, x, radius, i):
    """A row at s + x, which lies in interval i."""
    at = s + x
    inside = min(max(at, knots[0]), knots[knots.size - 1])
    beyond = at - inside
    y = inside - knots[i]
    u, du, ddu = _cubic(c, i, row, 0, y)
    w, dw, ddw = _cubic(c, i, row, 1, y)
    tu, dtu, _ = _cubic(c, i, row, 2, y)
    tw, dtw, _ = _cubic(c, i, row, 3, y)
    if beyond != 0.0:
        du = dw = ddu = ddw = dtu = dtw = 0.0
        if (beyond < 0.0 and ends[0] > 0.0) or (beyond > 0.0 and ends[1] > 0.0):
            w -= FALL * abs(beyond)
            dw = -FALL if beyond > 0.0 else FALL
    length = sqrt(tu * tu + tw * tw)
    tu, tw = tu / length, tw / length
    root = sqrt(radius * radius - x * x)
    miss = -tw * du + tu * (dw - x / root)
    return Felt(u, w - (radius - root), tu, tw, du, dw, ddu, ddw, dtu / length, dtw / length, miss)


@inlined
def _own_curvature(c, row, y, i):
    """Curvature at a row of the section at y in interval i [1/m]: how its tangent turns from the row before to the one
    behind, over their distance."""
    p, q = max(row - 1, 0), min(row + 1, c.shape[2] - 1)
    pu, pw = _cubic(c, i, p, 2, y)[0], _cubic(c, i, p, 3, y)[0]
    qu, qw = _cubic(c, i, q, 2, y)[0], _cubic(c, i, q, 3, y)[0]
    du = _cubic(c, i, q, 0, y)[0] - _cubic(c, i, p, 0, y)[0]
    dw = _cubic(c, i, q, 1, y)[0] - _cubic(c, i, p, 1, y)[0]
    return atan2(pu * qw - pw * qu, pu * qu + pw * qw) / max(sqrt(du * du + dw * dw), 1e-9)


@inlined
def _next(knots, s, i, step):
    """The next place to look at: every knot and the middle between two of them are among these."""
    if s < knots[0] or s >= knots[knots.size - 1]:
        return min(s + step, knots[0]) if s < knots[0] - 1e-9 else s + step
    half = 0.5 * (knots[i + 1] - knots[i])
    end = knots[i] + half if s < knots[i] + half - 1e-9 else knots[i + 1]
    return min(s + step, end) if end > s + 1e-9 else s + 1e-9


@kernel
def felt_rows(c, knots, ends, s, radius, reach, out):
    """The felt section of a piece at s, one row of ``out`` (n, 8) for each of its rows: u, w, tu, tw, how far ahead it
    is touched, slope and curvature along the track, along its normal; whether it was found within reach.

    A row slips past: along the track, across to nothing, its section's own curvature is felt, too.

    c, knots: of the cubics (4, m, n, 4), (m + 1,); ends: (2,), above 0 where the piece falls off.
    """
    n = c.shape[2]
    step = 2.0 * reach / (PLACES - 1)
    for row in range(n):
        i = interval(knots, s, 0)
        axle = _felt(c, knots, ends, row, s, 0.0, radius, i)
        best, low, high, found = -inf, 0.0, 0.0, 0.0
        farthest, place = -inf, 0.0
        before = out_before = 0.0
        i = interval(knots, s - reach, i)
        x = last = -reach
        while x <= reach:
            i = interval(knots, s + x, i)
            at = _felt(c, knots, ends, row, s, x, radius, i)
            stands = axle.tu * at.w - axle.tw * at.u
            if stands > farthest:
                farthest, place = stands, x
            if before > 0.0 and at.miss <= 0.0 and max(stands, out_before) > best:
                best, low, high, found = max(stands, out_before), last, x, 1.0
            before, out_before, last = at.miss, stands, x
            x = _next(knots, s + x, i, step) - s
        x = place
        if found > 0.0:
            for _ in range(50):
                x = 0.5 * (low + high)
                i = interval(knots, s + x, i)
                if _felt(c, knots, ends, row, s, x, radius, i).miss > 0.0:
                    low = x
                else:
                    high = x
        i = interval(knots, s + x, i)
        at = _felt(c, knots, ends, row, s, x, radius, i)
        past = at.du * at.tu + at.dw * at.tw
        own = out[row]
        own[0], own[1], own[2], own[3], own[4] = at.u, at.w, at.tu, at.tw, x
        own[5] = at.tu * at.dw - at.tw * at.du
        y = min(max(s + x, knots[0]), knots[knots.size - 1]) - knots[i]
        own[6] = at.tu * (at.ddw - 2.0 * past * at.dtw) - at.tw * (at.ddu - 2.0 * past * at.dtu)
        own[6] += past * past * _own_curvature(c, row, y, i)
        own[7] = found


@kernel
def unfold(rows, anchor, lowest, keep):
    """Mark in ``keep`` (n,) the rows that follow each other from the anchor to both sides, down to a height.

    Where two branches of the felt section cross, rows run on beneath the other branch, backwards, and forwards again
    on that one: what lies beyond the crossing on the first and before it on the second is left out.
    """
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
def _crossed(rows, i, way, anchor, keep):
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
