"""A rail at a wheel: its profile, or what the wheel feels of sections that change along the track.

A rail that turns about itself, as it does on a ramp of cant, rises along the track wherever it is touched beside its
origin, and one that bends wherever a yawed wheel touches it ahead of its axle or behind. These are slopes of .1 to 2
mrad, but without them nobody would do the work of lifting or pushing the wheel.

Between stations the tables are cubics of the distance (values and rates at both), row by row; between rows a point is
read as in ``core.contact.profile``. A yawed wheel feels every point at the place where its own outline has it, by
e_x (u - R tan) ahead with the tangent's slope across.
"""

from math import sqrt
from typing import NamedTuple

from wrsim.core.compiling import inlined
from wrsim.core.contact.profile import Point, between, profile_point
from wrsim.core.contact.records import Profile, Share
from wrsim.core.root import interval

STEEPEST = 3.0  # slope across up to which a yawed wheel's shift is followed
LEAST_PARTING = 0.1  # of the wheel's curvature: a rail that is more hollow is touched at two places


class Along(NamedTuple):
    """Along the track at a point of the rail: how far ahead the wheel touches it and how much higher that is than in
    the felt section [m], slope, curvature [1/m]."""

    ahead: float
    drop: float
    slope: float
    bend: float


class Felt(NamedTuple):
    """What the tables of a rail that changes along the track tell at a point of its section: how far ahead of the axle
    it is touched [m], slope, curvature [1/m]."""

    ahead: float
    slope: float
    bend: float


@inlined
def changes(rail):
    """Whether the rail changes along the track."""
    return rail.rates.shape[0] > 0


@inlined
def rail_length(rail):
    """Arclength of the last row [m]."""
    return (rail.rows - 1) * rail.step


@inlined
def share_at(stations, rows, s, guess):
    """The stations about s, and the weights of their values and rates."""
    i = interval(stations, s, guess)
    low = stations[i]
    h = stations[i + 1] - low
    f = min(max((s - low) / h, 0.0), 1.0)
    rise = f * f * (3.0 - 2.0 * f)
    bow = h * f * (1.0 - f)
    return Share(i, i * rows, (i + 1) * rows, 1.0 - rise, rise, bow * (1.0 - f), -bow * f)


@inlined
def _share(rail, row):
    """Where the wheel feels a row: a yawed one ahead of its axle or behind it."""
    if rail.yaw == 0.0:
        return rail.share
    own = rail.share.low + row
    tangent = min(max(rail.table[own, 3] / max(rail.table[own, 2], 1e-3), -STEEPEST), STEEPEST)
    ahead = rail.yaw * (rail.table[own, 0] - rail.o - rail.radius * tangent)
    return share_at(rail.stations, rail.rows, rail.place + ahead, rail.share.at)


@inlined
def _value(rail, share, row, column):
    table, rates = rail.table, rail.rates
    low, high = share.low + row, share.high + row
    return (
        share.a * table[low, column]
        + share.b * table[high, column]
        + share.c * rates[low, column]
        + share.d * rates[high, column]
    )


@inlined
def _node(rail, share, row):
    """A row as a point.

    The next row is felt elsewhere by a yawed wheel, where the rail may be higher: the tangent goes along.
    """
    tu, tw, k = _value(rail, share, row, 2), _value(rail, share, row, 3), _value(rail, share, row, 4)
    u, w = _value(rail, share, row, 0), _value(rail, share, row, 1)
    if rail.yaw != 0.0:
        bent = rail.radius * k / max(tu * tu, 1e-6) if abs(tw) < STEEPEST * tu else 0.0
        farther = rail.yaw * (tu - bent)
        tu += farther * (share.a * rail.rates[share.low + row, 0] + share.b * rail.rates[share.high + row, 0])
        tw += farther * (share.a * rail.rates[share.low + row, 1] + share.b * rail.rates[share.high + row, 1])
    return Point(u, w, tu, tw, k)


@inlined
def _bent(p, q, r, step):
    """Curvature between two rows, linear, so that their tangents turn into each other [1/m]."""
    turn = p.tu * q.tw - p.tw * q.tu
    lengths = sqrt((p.tu * p.tu + p.tw * p.tw) * (q.tu * q.tu + q.tw * q.tw))
    return turn / (lengths * step) + (r - 0.5) * (q.k - p.k)


@inlined
def rail_point(rail, arc):
    """Point of the rail's section at arclength ``arc`` [m]; beyond either end it goes on straight."""
    if not changes(rail):
        return profile_point(Profile(rail.table, rail.step), arc)
    x, i, one, other = _at(rail, arc)
    return _point(rail, one, other, arc, x, i)


@inlined
def rail_and_felt(rail, arc):
    """As ``rail_point``, and what the tables tell along the track there."""
    if not changes(rail):
        return profile_point(Profile(rail.table, rail.step), arc), Felt(0.0, 0.0, 0.0)
    x, i, one, other = _at(rail, arc)
    r = x - i
    return _point(rail, one, other, arc, x, i), Felt(
        (1.0 - r) * _value(rail, one, i, 5) + r * _value(rail, other, i + 1, 5),
        (1.0 - r) * _value(rail, one, i, 6) + r * _value(rail, other, i + 1, 6),
        (1.0 - r) * _value(rail, one, i, 7) + r * _value(rail, other, i + 1, 7),
    )


@inlined
def _at(rail, arc):
    """Of a rail that changes along the track: arclength in rows, held on them; the row before; where that one and the
    next are felt."""
    x = min(max(arc / rail.step, 0.0), rail.rows - 1.0)
    i = min(int(x), rail.rows - 2)
    return x, i, _share(rail, i), _share(rail, i + 1)


@inlined
def _point(rail, one, other, arc, x, i):
    """The point at x rows, behind row i."""
    p, q = _node(rail, one, i), _node(rail, other, i + 1)
    at = between(p, q, x - i, rail.step)
    if rail.yaw != 0.0:
        inverse = 1.0 / sqrt(at.tu * at.tu + at.tw * at.tw)
        at = Point(at.u, at.w, at.tu * inverse, at.tw * inverse, _bent(p, q, x - i, rail.step))
    beyond = arc - min(max(arc, 0.0), rail_length(rail))
    if beyond != 0.0:
        return Point(at.u + beyond * at.tu, at.w + beyond * at.tw, at.tu, at.tw, 0.0)
    return at


@inlined
def rail_chord(rail, arc):
    """Point of a rail that changes along the track, linear between two rows: half a micrometre off where a rail is bent
    most; beyond either end the last one."""
    x, i, one, other = _at(rail, arc)
    p, q = _node(rail, one, i), _node(rail, other, i + 1)
    r = x - i
    return Point(
        p.u + r * (q.u - p.u),
        p.w + r * (q.w - p.w),
        p.tu + r * (q.tu - p.tu),
        p.tw + r * (q.tw - p.tw),
        _bent(p, q, r, rail.step) if rail.yaw != 0.0 else p.k + r * (q.k - p.k),
    )


@inlined
def along(rail, felt, point, x, to_axle):
    """What the rail does along the track where its section has ``point`` and ``felt`` and a wheel touches at x [m];
    nothing where it is one profile that neither turns nor bends.

    A section that turns by ``twist`` a metre about (0, 0) rises along its normal by twist (u tu + w tw), one that bends
    by bow_b tu - bow_o tw times the way from the wheel's section. It is touched so far ahead of x that the true normal
    meets the axle, at the distance ``to_axle``: a wheel without friction is not driven.
    """
    bow = rail.bow_b * point.tu - rail.bow_o * point.tw
    rise = rail.twist * (point.u * point.tu + point.w * point.tw) + bow * (x + felt.ahead)
    rise /= max(1.0 - bow * to_axle, LEAST_PARTING)  # the way that it is ahead for this rise counts, too
    ahead = felt.ahead + to_axle * rise
    drop = rail.radius - sqrt(rail.radius * rail.radius - ahead * ahead)
    return Along(ahead, drop, felt.slope + rise, felt.bend)


@inlined
def tilted(at):
    """Cosine of the slope along the track: of a distance in the section to that along the true normal."""
    return 1.0 / sqrt(1.0 + at.slope * at.slope)


@inlined
def parting(r_t, at):
    """Radius with which a wheel of radius ``r_t`` along the track and the rail part [m]."""
    if at.bend == 0.0:
        return r_t
    return 1.0 / max(1.0 / r_t - at.bend, LEAST_PARTING / r_t)
