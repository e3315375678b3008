"""A rail at a wheel: its profile, or the effective profile (envelope) of sections that change along the track.

A rail that turns about itself, as it does on a ramp of cant, and one that bends rise along the track (surf-slope).
These are slopes of 0.1 to 2 mrad; without them the work of lifting or pushing the wheel would be missing.

Between stations the tables are cubics of the distance (values and rates at both), row by row; between rows a point is
read as in ``surfaces.profile_table``. A yawed wheel touches every point at the place where its own outline has it, by
e_x (u - R tan) ahead with the tangent's slope across. A rail that runs outward is looked at in axes of its own, turned
in plan by the angle whose sine is ``sine`` (surf-heading).
"""

from math import sqrt
from typing import NamedTuple

from wrsim.contact.records import ProfileTable, Rail, Share
from wrsim.contact.surfaces.profile_table import ProfilePoint, between, profile_point
from wrsim.jit import Array, inlined
from wrsim.jit.root import interval

LARGEST_SINE = 0.7  # of the angle about the axle up to which a yawed wheel's shift is followed, as in search.locus
SERIES = 1e-4  # squares of slopes below which series take the place of roots, to round-off
LEAST_PARTING = 0.1  # of the wheel's curvature: a rail that is more hollow is touched at two places
DEPTHS = 5e-5, 2e-4  # of contacts for which tables have the curvature along the track [m]
MOST = 1.5  # of the way between both, up to which the radius is followed
AHEAD, SLOPE, BEND, BEND_DEEP, LEAN = range(5, 10)  # columns of tables behind a point (rolled_rail.COLUMNS)
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
        (1.0 - r) * _value(rail, one, i, AHEAD) + r * _value(rail, other, i + 1, AHEAD),
        (1.0 - r) * _value(rail, one, i, SLOPE) + r * _value(rail, other, i + 1, SLOPE),
        (1.0 - r) * _value(rail, one, i, BEND) + r * _value(rail, other, i + 1, BEND),
        (1.0 - r) * _value(rail, one, i, BEND_DEEP) + r * _value(rail, other, i + 1, BEND_DEEP),
        (1.0 - r) * _value(rail, one, i, LEAN) + r * _value(rail, other, i + 1, LEAN),
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
