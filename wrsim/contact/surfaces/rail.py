"""A rail at a wheel: its profile, or the effective profile (envelope) of sections that change along the track.

A rail that turns about itself, as it does on a ramp of cant, and one that bends rise along the track (surf-slope).
These are slopes of 0.1 to 2 mrad; without them the work of lifting or pushing the wheel would be missing.

Between stations the tables are cubics of the distance (values and rates at both), row by row; between rows a point is
read as in ``surfaces.profile_table``. A yawed wheel touches every point at the place where its own outline has it, by
e_x (u - R tan) ahead with the tangent's slope across. A rail that runs outward is looked at in axes of its own, turned
in plan by the angle whose sine is ``sine`` (surf-heading).
"""

from math import atan2, inf, sqrt
from typing import NamedTuple

from wrsim.contact.records import ProfileTable, Rail, Share
from wrsim.contact.surfaces.profile_table import ProfilePoint, between, profile_point
from wrsim.jit import Array, Bools, Ints, inlined, kernel
from wrsim.jit.root import Bracket, crossing, interval, narrowed

LARGEST_SINE = 0.7  # of the angle about the axle up to which a yawed wheel's shift is followed, as in search.locus
SERIES = 1e-4  # squares of slopes below which series take the place of roots, to round-off
LEAST_PARTING = 0.1  # of the wheel's curvature: a rail that is more hollow is touched at two places
DEPTHS = 5e-5, 2e-4  # of contacts for which tables have the curvature along the track [m]
MOST = 1.5  # of the way between both, up to which the radius is followed
MEAN_GAP = 0.75  # of the depth, sum of the gaps at Chebyshev's outer nodes of a strip (surf-parting)


class Along(NamedTuple):
    """Along the track at a point of the rail: how far ahead the wheel touches it and how much higher that is than in
    the effective profile [m], slope."""

    ahead: float
    drop: float
    slope: float


class Envelope(NamedTuple):
    """What the tables of a rail that changes along the track give at a point of its section: how far ahead of the axle
    it is touched [m], slope; curvature over contacts of both ``DEPTHS`` [1/m], and the slope between the ends of one
    over its depth [1/m] (surf-parting)."""

    ahead: float
    slope: float
    bend: float
    bend_deep: float
    lean: float


@inlined
def changes(rail: Rail) -> bool:
    """Whether the rail changes along the track."""
    return rail.rates.shape[0] > 0


@inlined
def rail_length(rail: Rail) -> float:
    """Arclength of the last row [m]."""
    return (rail.rows - 1) * rail.step


@inlined
def share_at(stations: Array, rows: int, s: float, guess: int) -> Share:
    """The stations about s, and the weights of their values and rates."""
    i = interval(stations, s, guess)
    low = stations[i]
    h = stations[i + 1] - low
    f = min(max((s - low) / h, 0.0), 1.0)
    rise = f * f * (3.0 - 2.0 * f)
    bow = h * f * (1.0 - f)
    return Share(i, i * rows, (i + 1) * rows, 1.0 - rise, rise, bow * (1.0 - f), -bow * f)


@inlined
def way_ahead(rail: Rail, u: float, w: float, tu: float, tw: float) -> float:
    """How far ahead of the rail's place a wheel touches a row with this point and tangent, along the track [m]."""
    sine = min(max(rail.yaw * tw / max(tu, 1e-3), -LARGEST_SINE), LARGEST_SINE)
    ahead = rail.beside + rail.yaw * (u - rail.o) - (rail.radius - w) * sine
    return ahead * sqrt(1.0 - rail.sine * rail.sine)


@inlined
def _share(rail: Rail, row: int) -> tuple[Share, float]:
    """Where the wheel touches a row: a yawed one ahead of its axle or behind it; how far out the track's axis has gone
    from that of the rail on this way [m]."""
    cosine = sqrt(1.0 - rail.sine * rail.sine)
    if rail.yaw == 0.0:
        return rail.share, -rail.sine * rail.beside * cosine
    at = rail.table[rail.share.low + row]
    way = way_ahead(rail, at[0], at[1], at[2], at[3])
    return share_at(rail.stations, rail.rows, rail.place + way, rail.share.at), -rail.sine * way


@inlined
def _value(rail: Rail, share: Share, row: int, column: int) -> float:
    table, rates = rail.table, rail.rates
    low, high = share.low + row, share.high + row
    return (
        share.a * table[low, column]
        + share.b * table[high, column]
        + share.c * rates[low, column]
        + share.d * rates[high, column]
    )


@inlined
def _node(rail: Rail, share: Share, row: int, out: float) -> ProfilePoint:
    """A row as a point, moved ``out``. The next row is touched elsewhere by a yawed wheel, where the rail may be
    higher: the tangent goes along."""
    tu, tw, k = _value(rail, share, row, 2), _value(rail, share, row, 3), _value(rail, share, row, 4)
    u, w = _value(rail, share, row, 0) + out, _value(rail, share, row, 1)
    if rail.yaw != 0.0:
        bent = (rail.radius - w) * k / max(tu * tu, 1e-6) if abs(rail.yaw * tw) < LARGEST_SINE * tu else 0.0
        farther = rail.yaw * (tu - bent) * sqrt(1.0 - rail.sine * rail.sine)
        outward = share.a * rail.rates[share.low + row, 0] + share.b * rail.rates[share.high + row, 0]
        tu += farther * (outward - rail.sine)
        tw += farther * (share.a * rail.rates[share.low + row, 1] + share.b * rail.rates[share.high + row, 1])
    return ProfilePoint(u, w, tu, tw, k)


@inlined
def _bent(p: ProfilePoint, q: ProfilePoint, r: float, step: float) -> float:
    """Curvature between two rows, linear, so that their tangents turn into each other [1/m]."""
    turn = p.tu * q.tw - p.tw * q.tu
    lengths = sqrt((p.tu * p.tu + p.tw * p.tw) * (q.tu * q.tu + q.tw * q.tw))
    return turn / (lengths * step) + (r - 0.5) * (q.k - p.k)


@inlined
def rail_point(rail: Rail, arc: float) -> ProfilePoint:
    """Point of the rail's section at arclength ``arc`` [m]; beyond either end it goes on straight."""
    return rail_and_envelope(rail, arc)[0]


@inlined
def rail_and_envelope(rail: Rail, arc: float) -> tuple[ProfilePoint, Envelope]:
    """As ``rail_point``, and what the tables give along the track there."""
    if not changes(rail):
        return profile_point(ProfileTable(rail.table, rail.step), arc), Envelope(0.0, 0.0, 0.0, 0.0, 0.0)
    x, i, (one, out), (other, farther) = _at(rail, arc)
    r, p, q = x - i, _node(rail, one, i, out), _node(rail, other, i + 1, farther)
    at = between(p, q, r, rail.step)
    if rail.yaw != 0.0:
        inverse = 1.0 / sqrt(at.tu * at.tu + at.tw * at.tw)
        at = ProfilePoint(at.u, at.w, at.tu * inverse, at.tw * inverse, _bent(p, q, r, rail.step))
    beyond = arc - min(max(arc, 0.0), rail_length(rail))
    if beyond != 0.0:
        at = ProfilePoint(at.u + beyond * at.tu, at.w + beyond * at.tw, at.tu, at.tw, 0.0)
    return at, Envelope(
        (1.0 - r) * _value(rail, one, i, 5) + r * _value(rail, other, i + 1, 5),
        (1.0 - r) * _value(rail, one, i, 6) + r * _value(rail, other, i + 1, 6),
        (1.0 - r) * _value(rail, one, i, 7) + r * _value(rail, other, i + 1, 7),
        (1.0 - r) * _value(rail, one, i, 8) + r * _value(rail, other, i + 1, 8),
        (1.0 - r) * _value(rail, one, i, 9) + r * _value(rail, other, i + 1, 9),
    )


@inlined
def _at(rail: Rail, arc: float) -> tuple[float, int, tuple[Share, float], tuple[Share, float]]:
    """Place on a rail that changes along the track: arclength in rows, held on them; the row before; where that
    one and the next are touched (``_share``)."""
    x = min(max(arc / rail.step, 0.0), rail.rows - 1.0)
    i = min(int(x), rail.rows - 2)
    return x, i, _share(rail, i), _share(rail, i + 1)


@inlined
def rail_chord(rail: Rail, arc: float) -> ProfilePoint:
    """Point of a rail that changes along the track, linear between two rows: half a micrometre off where a rail is bent
    most; beyond either end the last one."""
    x, i, (one, out), (other, farther) = _at(rail, arc)
    p, q = _node(rail, one, i, out), _node(rail, other, i + 1, farther)
    r = x - i
    return ProfilePoint(
        p.u + r * (q.u - p.u),
        p.w + r * (q.w - p.w),
        p.tu + r * (q.tu - p.tu),
        p.tw + r * (q.tw - p.tw),
        _bent(p, q, r, rail.step) if rail.yaw != 0.0 else p.k + r * (q.k - p.k),
    )


@inlined
def along(rail: Rail, envelope: Envelope, point: ProfilePoint, x: float, to_axle: float) -> Along:
    """What the rail does along the track where its section has ``point`` and ``envelope`` and a wheel touches at x [m];
    nothing where it is one profile that neither turns nor bends.

    The section rises along its normal by (surf-slope), omega = ``twist`` about (0, 0). It is touched so far ahead of x
    that the true normal meets the axle, at the distance ``to_axle``: a wheel without friction is not driven. A roller
    is met at x itself, for the locus holds its curvature.
    """
    if rail.roller > 0.0:
        sine = x * rail.roller / (1.0 + point.w * rail.roller)
        cosine = sqrt(1.0 - sine * sine)
        return Along(0.0, -x * sine / (1.0 + cosine), -point.tu * sine / cosine)
    return along_rail(rail, envelope, point, x, to_axle)


@inlined
def along_rail(rail: Rail, envelope: Envelope, point: ProfilePoint, x: float, to_axle: float) -> Along:
    """The same where there is no roller."""
    bow = rail.bow_b * point.tu - rail.bow_o * point.tw
    rise = rail.twist * (point.u * point.tu + point.w * point.tw) + bow * (x + envelope.ahead)
    rise /= max(1.0 - bow * to_axle, LEAST_PARTING)  # the way that it is ahead for this rise counts, too
    ahead = envelope.ahead + to_axle * rise
    share = ahead * ahead * (1.0 / (rail.radius * rail.radius))
    if share < SERIES:
        drop = rail.radius * share * (0.5 + share * (0.125 + share * 0.0625))
    else:
        drop = rail.radius - sqrt(rail.radius * rail.radius - ahead * ahead)
    return Along(ahead, drop, envelope.slope + rise)


@inlined
def tilted(at: Along) -> float:
    """Cosine of the slope along the track: of a distance in the section to that along the true normal."""
    square = at.slope * at.slope
    if square < SERIES:
        return 1.0 - square * (0.5 - square * (0.375 - square * 0.3125))
    return 1.0 / sqrt(1.0 + square)


@inlined
def parting(r_t: float, at: Envelope, depth: float) -> tuple[float, float]:
    """Radius with which a wheel of radius ``r_t`` along the track and the rail part over a contact this deep, and how
    far ahead the middle of that lies [m] (surf-parting)."""
    if at.bend == 0.0 and at.bend_deep == 0.0:
        return r_t, 0.0
    least, depth = LEAST_PARTING / r_t, max(depth, 0.0)
    light, deep = 1.0 / max(1.0 / r_t - at.bend, least), 1.0 / max(1.0 / r_t - at.bend_deep, least)
    share = min((depth - DEPTHS[0]) / (DEPTHS[1] - DEPTHS[0]), MOST)
    r = max(light + share * (deep - light), 0.5 * min(light, deep))
    half = sqrt(MEAN_GAP * depth * r)
    return r, min(max(r * at.lean * depth, -half), half)


# tables of a rail whose profile changes along the track: see `wrsim.contact.surfaces.rolled_rail`

PLACES = 61  # at least, at which a contact is looked for before it is found to round-off
FALL = 3.0  # slope with which a piece falls off behind its ends
LONGEST = 0.03  # half length of contact [m]
BESIDE = 1e-4  # half the distance of rows [m]
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
    """The effective profile of a piece at s in axes turned by a heading, one row of ``out`` (n, 10) for each of its
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
        envelope[8], envelope[9] = lean / DEPTHS[1], within_reach


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
