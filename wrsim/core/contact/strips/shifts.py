"""Where the middles of strips lie along the rail.

A yawed wheel touches its rail along the contact locus, a curve that runs ahead of the axle where the profile climbs.
The middles of the strips do not lie on it: for Hertz's ellipse, whose axes are those of the gap, they lie on a straight
line too, but farther apart by a factor that follows from the curvatures. A grid takes the factor of the ellipse over a
hump that is as wide, as deep and leans as much; where the locus is bent its strips stay on it.
"""

from math import pi, sqrt
from typing import NamedTuple

from wrsim.core.contact.strips.grid import next_hump
from wrsim.core.contact.strips.records import FADING, ROWS
from wrsim.core.jit.compiling import inlined, kernel

LEVEL = 0.45  # of the depth: about where contact ends
EXCENTRIC = 1.27  # power of the gap's ratio of curvatures that gives the ellipse's
EVEN = 0.8, 0.95  # squared correlation of shift and place at which strips stay on the locus, and are all stretched
FAINT = 3e-3  # spread of the shifts, over the half length, below which they do not matter
STIFFER = 25.0  # growth of that weight with the spread of the shifts over the half length
CALM, SLANTED = 5.0, 0.2  # weight that holds a^2 of neighbours on a parabola, by the square of its slant beyond that
CALM_BENT = 0.1  # the same where the locus is bent, by the square of all of the slant
LOOSER = 0.9  # part of their evenness that the factors of two humps lose which have just come to share a grid
STIFF = 1.0, 3.0  # evenness over that without slant at which they lose nothing, and all of that
JOINED = 0.5, 0.9  # d over its hull at which neighbouring grids have nothing and all in common


class Hump(NamedTuple):
    """The ground of a grid, or of two, weighted with the penetration d beyond a level: integral of it; means of place
    s, shift x and 1/R_x; mean squares and product of s and x about their means; largest d."""

    weight: float
    s: float
    x: float
    bend: float
    ss: float
    sx: float
    xx: float
    deepest: float


@inlined
def rise(x, ends):
    """From 0 to 1 between two ends, smoothly."""
    t = min(max((x - ends[0]) / (ends[1] - ends[0]), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


@kernel
def hump_of(grid, rows, deepest):
    """The ground of one grid beyond LEVEL of ``deepest``, about where it is pressed."""
    level = LEVEL * deepest
    total = s_mean = x_mean = bend = 0.0
    for r in range(ROWS):
        d = max(rows[r].d - level, 1e-12)
        total += d
        s_mean += d * rows[r].s
        x_mean += d * rows[r].x
        bend += d / rows[r].r_t
    s_mean, x_mean = s_mean / total, x_mean / total
    ss = sx = xx = 0.0
    for r in range(ROWS):
        d, s, x = max(rows[r].d - level, 1e-12) / total, rows[r].s - s_mean, rows[r].x - x_mean
        ss += d * s * s
        sx += d * s * x
        xx += d * x * x
    return Hump(total * grid.spacing, s_mean, x_mean, bend / total, ss, sx, xx, deepest)


@inlined
def joined(a, b):
    """The ground of two grids together."""
    weight = a.weight + b.weight
    p, q = a.weight / weight, b.weight / weight
    ds, dx = b.s - a.s, b.x - a.x
    return Hump(
        weight,
        p * a.s + q * b.s,
        p * a.x + q * b.x,
        p * a.bend + q * b.bend,
        p * a.ss + q * b.ss + p * q * ds * ds,
        p * a.sx + q * b.sx + p * q * ds * dx,
        p * a.xx + q * b.xx + p * q * dx * dx,
        max(a.deepest, b.deepest),
    )


class Slant(NamedTuple):
    """What a slanted ground asks of a grid: how much farther from the mean middles lie than the locus, over the locus's
    distance; how much more firmly factors are kept alike; how firmly half lengths of neighbours are held together."""

    stretch: float
    evenness: float
    calm: float


class Curvatures(NamedTuple):
    """Principal curvatures of the gap, the larger and the smaller one, and their difference."""

    most: float
    least: float
    apart: float


@inlined
def _principal(ratio, slope):
    """Of a gap of curvature 1 along x, whose ridge is bent ``ratio`` times as much across and leans by ``slope``."""
    square = slope * slope
    across = ratio + square
    apart = sqrt((across - 1.0) ** 2 + 4.0 * square)
    return Curvatures(0.5 * (1.0 + across + apart), 0.5 * (1.0 + across - apart), apart)


@inlined
def hertz_stretch(ratio, slope):
    """How much farther apart along x the middles of the strips of Hertz's ellipse lie than the ridge of the gap.

    ratio: of the ridge's curvature across to the curvature along; slope: of the ridge's place along x.
    """
    most, least, apart = _principal(ratio, slope)
    more = ((most / least) ** EXCENTRIC - 1.0) / max(apart, 1e-9)
    return more / (1.0 + more * (1.0 - least))


class Ellipse(NamedTuple):
    """Contact of a slanted parabolic ground: half length [m] of the strip in its middle, half of its width [m], factor
    k."""

    half_length: float
    half_width: float
    factor: float


@kernel
def hertz_ellipse(ratio, slope, depth, bend):
    """Hertz's ellipse over a ground this deep whose ridge is bent ``ratio`` times as much across as along, and leans.

    slope: of the ridge's place along x; bend: curvature along [1/m]. With both principal curvatures of the gap, c1
    along the longer axis: b/a by a power of their ratio, a^2 = 2 d/c1 (K - E)/(e^2 K), p0 = E* d/(b K) (Johnson,
    Contact Mechanics, 4.2), the integrals by the arithmetic-geometric mean (Abramowitz and Stegun 17.6).
    """
    most, least, apart = _principal(ratio, slope)
    thin = (least / most) ** (0.5 * EXCENTRIC)
    p, q, power, part = 1.0, thin, 1.0, 0.5
    excentric = max(1.0 - thin * thin, 1e-12)
    for _ in range(8):
        c = 0.5 * (p - q)
        p, q = 0.5 * (p + q), sqrt(p * q)
        part += power * c * c / excentric
        power *= 2.0
    integral = 0.5 * pi / p
    long = 2.0 * depth / (least * bend) * part  # squares of both half axes
    short = long * thin * thin
    lean = (1.0 - least) / apart if apart > 0.0 else 0.0  # square of the cosine between x and the shorter axis
    in_x = 1.0 / long + (1.0 / short - 1.0 / long) * lean
    half_length = 1.0 / sqrt(in_x)
    return Ellipse(half_length, sqrt(in_x * long * short), 2.0 * depth / (bend * sqrt(short) * integral * half_length))


@inlined
def slanted(hump):
    """Ratio of the curvatures of this ground and slope of its ridge, none where it is bent."""
    return _ratio(hump), hump.sx / hump.ss * (rise(_even(hump), EVEN))


@inlined
def _even(hump):
    """Squared correlation of shift and place: 1 where the locus is straight."""
    return hump.sx * hump.sx / (hump.ss * hump.xx) if hump.xx > 0.0 else 0.0


@inlined
def _ratio(hump):
    """Curvature of the ground across over that along: where a parabola is more than a level deep the square of the half
    width is five times the mean square."""
    return 0.4 * (1.0 - LEVEL) * hump.deepest / (hump.bend * hump.ss)


@inlined
def _slant(hump, reach):
    """What this ground asks of a grid; reach: half length along x.

    Where strips lie slanted across a narrow contact, their curvatures tell less of their own factor; where they lie
    shifted closely side by side, their influence hardly tells one from the other.
    """
    ratio, straight = _ratio(hump), rise(_even(hump), EVEN)
    lean = sqrt(hump.xx) / reach * ratio / (1.0 + ratio)
    return Slant(
        straight * (hertz_stretch(ratio, hump.sx / hump.ss) - 1.0),
        1.0 + STIFFER * lean,
        CALM * max(lean - SLANTED, 0.0) ** 2 + CALM_BENT * lean * lean * (1.0 - straight),
    )


@inlined
def off_locus(grid, x):
    """How far the middle of a strip at shift x lies off the locus."""
    return grid.stretch * x - grid.pivot


NO_SLANT = Slant(0.0, 1.0, 0.0)  # of a tail: its strips lie on the locus


@kernel
def set_shifts(system):
    """How far the middles of all grids' strips lie off the locus, how evenly their factors run, whether it matters.

    Grids that are about to merge take what they will have in common.
    """
    memo, grids = system.memo[0], system.grids
    matter = 0
    for g in range(memo.grids):
        grid = grids[g]
        hump = hump_of(grid, system.rows[g], grid.deepest)
        grid.along = hump.x
        grid.stretch, grid.evenness, grid.calm = _slant(hump, grid.reach) if grid.tail == 0 else NO_SLANT
        grid.pivot = grid.stretch * hump.x
        if grid.tail == 0:
            grid.evenness *= 1.0 - LOOSER * grid.soft * rise(grid.evenness, STIFF)
        if sqrt(hump.xx) > FAINT * grid.reach:
            matter = 1
        for h in range(g):
            if (
                abs(grid.along - grids[h].along) > FAINT * grid.reach
                and system.vectors[FADING, g * memo.grids + h] > 0.0
            ):
                matter = 1
    if matter != memo.shifted:
        memo.shifted = matter
        memo.inverted = 0
    if matter == 0:
        return
    for g in range(memo.grids - 1):
        if grids[g].tail != 0:
            continue
        beside = next_hump(grids, g, memo.grids)
        share = beside.near * rise(beside.bond, JOINED) if beside.grid > 0 else 0.0
        if share > 0.0:
            h = beside.grid
            most = max(grids[g].deepest, grids[h].deepest)
            both = joined(hump_of(grids[g], system.rows[g], most), hump_of(grids[h], system.rows[h], most))
            stretch, even, calm = _slant(both, max(grids[g].reach, grids[h].reach))
            for k in range(g, h + 1, h - g):
                grid = grids[k]
                grid.evenness += share * (even - grid.evenness)
                grid.calm += share * (calm - grid.calm)
                grid.stretch += share * (stretch - grid.stretch)
                grid.pivot += share * (stretch * both.x - grid.pivot)
