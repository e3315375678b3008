"""Tails: ground beside a hump that a yawed wheel touches elsewhere along the rail, or hardly.

Beside a hump the elastic surface bends up. Where the ground does so as well the two run nearly alike, and a contact
that goes on there ends now here, now there. Without yaw that is harmless. But where the locus turns aside, too, its
short strips lie beside the long ones of the hump, and what they do to the curvature of the surface there is as large
as what the hump does itself: the factors of the hump, and with them its force, hung on where the contact ended.

So a hump's grid ends where the locus leaves the line it has under the hump, by the pose alone. What lies beyond is a
tail: a grid of strips that stand still, come into contact and leave it one by one from no force, and take the factor
at the hump's end. For a given hump that is a monotone problem. What they do to the curvature counts the less the
farther they lie off the line and the shorter they are.
"""

from math import sqrt
from typing import NamedTuple

from wrsim.core.contact.strips.grid import make_room, next_corner
from wrsim.core.contact.strips.records import ROWS
from wrsim.core.contact.strips.shifts import rise
from wrsim.core.jit.compiling import inlined, kernel

BENT = 0.05  # of the half length of the overlap: how far the locus leaves the line of its hump where a tail begins
FADED = 3.0  # times that: where the curvature that a tail makes no longer counts
SHORT = 6.0  # times that: half length of strips of which half of the curvature counts
CORE = 0.8  # of the depth of a hump: ground that says where its line is
SAG = 0.85, 0.97  # least d beyond over its concave hull: all of a tail, and none
SHOULDER = 0.6, 0.75  # d at a corner of the hull over that of the hump: none of a shoulder, which is no tail, and all
LONG = 0.48, 0.6  # the same for the squares of the half lengths of both overlaps, 2 R_x d: strips as long are no tail
LOW = 0.3, 0.45  # of the depth of a hump: ground that lies lower is not touched, so none of it is a tail, and all
LEAST, WIDE = 0.25, 8.0  # rows of a tail that counts at all, and as a whole
TOP = 0.6, 0.9  # of the depth of a hump: where all and nothing of the locus' way back to the line counts


class Line(NamedTuple):
    """Straight line through the locus under a hump: place, shift, slope; half length of the overlap [m]."""

    s: float
    x: float
    slope: float
    half_length: float


@kernel
def cut_tails(system, first, parts, most):
    """Cut the tails off the ground of the grids from ``first`` on. Returns the number of grids, ``most`` or fewer."""
    grids, rows = system.grids, system.rows[first]
    least, h = grids[first].least, grids[first].spacing
    k = first
    while k < first + parts:
        start = int((grids[k].least - least) / h + 0.999)
        end = min(int((grids[k].most - least) / h + 0.001), ROWS - 1)
        main = start
        for r in range(start, end + 1):
            main = r if rows[r].d > rows[main].d else main
        line = _line_of(rows, start, end, main)
        bounds = (grids[k].least - least) / h, (grids[k].most - least) / h
        for side in range(2):
            if parts == most:
                break
            at, reach = _find_tail(rows, main, bounds[side], 2 * side - 1, line)
            if at < 0.0:
                continue
            make_room(grids, k, first + parts)
            grids[k].most = grids[k + 1].least = least + h * at
            grids[k].bond = 0.0
            parts += 1
            hump, tail = (k + 1, k) if side == 0 else (k, k + 1)
            grids[hump].tail, grids[tail].tail = 0, hump - tail
            grids[tail].line_s, grids[tail].line_x = line.s, line.x
            grids[tail].line_slope, grids[tail].line_reach = line.slope, reach
            grids[tail].wide = rise((grids[tail].most - grids[tail].least) / h, (0.0, WIDE))
            k += 1
        k += 1
    return parts


@inlined
def _off(line, s, x):
    """How far a place of the locus lies off a line."""
    return abs(x - line.x - line.slope * (s - line.s))


@kernel
def _line_of(rows, start, end, main):
    """The line of the hump that is deepest at row ``main``: of all ground beyond CORE of its depth."""
    level = CORE * rows[main].d
    total = s_mean = x_mean = ss = sx = 0.0
    for r in range(start, end + 1):
        weight = max(rows[r].d - level, 0.0)
        total += weight
        s_mean += weight * rows[r].s
        x_mean += weight * rows[r].x
    s_mean, x_mean = s_mean / total, x_mean / total
    for r in range(start, end + 1):
        weight = max(rows[r].d - level, 0.0)
        ss += weight * (rows[r].s - s_mean) ** 2
        sx += weight * (rows[r].s - s_mean) * (rows[r].x - x_mean)
    return Line(s_mean, x_mean, sx / max(ss, 1e-30), sqrt(2.0 * max(rows[main].d, 0.0) * rows[main].r_t))


class Leaving(NamedTuple):
    """Where the locus leaves the line of a hump, in rows, -1.0 where it does not, and the penetration there [m]."""

    at: float
    d: float


@kernel
def _find_tail(rows, main, bound, step, line):
    """Where the tail of a hump begins on the way to the end of its ground, in rows, and how far off the line that is
    [m]; rows are -1.0 where there is none. The less the ground is a tail, the farther off the line it begins.

    bound: the end of the ground, in rows; step: on the way to it.
    """
    reach = BENT * line.half_length
    found = _leaves(rows, main, bound, step, line, reach)
    if found.at >= 0.0:
        reach /= max((1.0 - rise(_sag(rows, main, bound, step), SAG)) * rise(found.d / rows[main].d, LOW), 1e-6)
        found = _leaves(rows, main, bound, step, line, reach)
    if found.at < 0.0 or (bound - found.at) * step < LEAST:
        return -1.0, reach
    return found.at, reach


@kernel
def _leaves(rows, main, bound, step, line, reach):
    """Where on the way from a hump to the end of its ground the locus comes so far off the line.

    Where it comes back again the way back counts as well, so that this place goes on without a jump as the reach grows;
    on top of the hump it does not.
    """
    way = off = _off(line, rows[main].s, rows[main].x)
    r = main
    while (bound - r) * step > 0.0 and 0 <= r + step < ROWS:
        one, other = rows[r], rows[r + step]
        beyond = _off(line, other.s, other.x)
        more = beyond - off
        if more < 0.0:
            more *= 2.0 * rise(other.d / rows[main].d, TOP) - 1.0
        if way + more > reach:
            share = (reach - way) / more
            return Leaving(r + step * share, one.d + share * (other.d - one.d))
        way, off = way + more, beyond
        r += step
    return Leaving(-1.0, 0.0)


@kernel
def _sag(rows, main, bound, step):
    """Least penetration over its concave hull beyond a hump, where the hull has no corner that is a shoulder.

    The hull is that of all the ground, whichever grids it is parted into; ``bound``: where the grid of the hump ends,
    in rows.
    """
    far = ROWS - 1 if step > 0 else 0
    end = int(bound + 0.001) if step > 0 else int(bound + 0.999)
    next_row = min(max(end + step, 0), ROWS - 1)
    bound_d = rows[end].d + abs(bound - end) * (rows[next_row].d - rows[end].d)
    least = 1.0
    p = main
    while (end - p) * step > 0:
        q, steep = next_corner(rows, p, far, step)
        beyond = (q - end) * step > 0
        # up to where the grid ends: between two rows, so that nothing jumps when that place comes past one
        d, r_t = (bound_d, rows[end].r_t) if beyond and bound_d < rows[q].d else (rows[q].d, rows[q].r_t)
        depth = d / rows[main].d
        counts = 1.0 - max(rise(depth, SHOULDER), rise(depth * r_t / rows[main].r_t, LONG))
        for r in range(p + step, end + step if beyond else q, step):
            least = min(least, 1.0 - counts * (1.0 - rows[r].d / (rows[p].d + steep * abs(r - p))))
        p = q
    return least


@inlined
def has_tail(grids, g, side):
    """Whether the grid beyond this end of grid g is its tail; grids: those there are."""
    k = g - 1 if side == 0 else g + 1
    return 0 <= k < grids.size and grids[k].tail != 0 and k + grids[k].tail == g


@inlined
def bending(grid, place):
    """How much of what a strip of a tail does to the curvature counts, and the slope of its logarithm over that of
    a^2."""
    off = abs(place.x - grid.line_x - grid.line_slope * (place.s - grid.line_s)) / grid.line_reach
    short = (SHORT * grid.line_reach) ** 2 / max(place.y, 1e-30)
    counts = (1.0 - rise(off, (1.0, FADED))) / (1.0 + short)
    bent = 1.0 - grid.wide * (1.0 - counts)
    return bent, grid.wide * counts / max(bent, 1e-30) * short / (1.0 + short)
