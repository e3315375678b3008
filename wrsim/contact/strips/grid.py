"""Grids of the strip model: where rows and strips lie, and what the profiles are there.

Rows stand at equal steps of the rail's arclength, each with the point of the wheel's outline opposite it, so that the
penetration d(s) belongs to the pose alone, wherever it is counted from. Strips lie between the edges of the contact,
denser where d bends more (Hertz: equally) and where the locus runs along the rail: as equal pieces of the integral of

    density = (|d''| + |x'| sqrt(1 + x'^2) / R_x)^(2/3), a mean over neighbouring rows, + FLOOR times its mean.

Strips are constants in place of p(s): the square of their error is least where they stand as |p'|^(2/3) (de Boor, Good
Approximation by Splines with Variable Knots, 1973). Across the rail p' goes with d'', as in plane contact. Where the
locus leans by x' a contact is a band along it: across the band the curvature is (1 + x'^2) / R_x, the half width that
of the strip over sqrt(1 + x'^2), so p' along the rail goes with sqrt(1 + x'^2) / R_x, and across it with x' times that.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from wrsim.contact.overlap_patch import bisector
from wrsim.contact.search.locus import locus_point
from wrsim.contact.strips.records import ROWS
from wrsim.contact.surfaces.profile_table import length
from wrsim.contact.surfaces.rail import along, parting, rail_and_envelope, rail_length, tilted
from wrsim.jit.compiling import inlined, kernel
from wrsim.jit.root import Bracket, crossing, narrowed

FLOOR = 0.3  # share of even density
NEAR = 0.01  # of the rows' distance: how far ahead a point may be for the shift along the rail to be read there
LEAST_FACING = 2.5e-3  # square of the sine between axle and normal, held above


class Opposite(NamedTuple):
    """A pair of opposite points: penetration along the mean normal, and how it changes along the rail (the tangents
    lean by the same angle to both sides of the mean one); middle (x, o, b) and normal (no, nb); the wheel's shrink;
    radius with which both part along t; how far the wheel's point was ahead of the rail's [m]; slope of the rail along
    the track."""

    d: float
    d_s: float
    x: float
    o: float
    b: float
    no: float
    nb: float
    shrink: float
    r_t: float
    ahead: float
    slope: float


@inlined
def opposite(wheel, rail, arc_wheel, arc_rail):
    """The pair at these arclengths; what the wheel's point is ahead along the mean tangent is taken back along its own
    tangent."""
    w = locus_point(wheel, arc_wheel)
    r, envelope = rail_and_envelope(rail, arc_rail)
    no, nb = bisector(w, r)
    ahead = (w.o - r.u) * nb - (w.b - r.w) * no
    wo = w.o + ahead * w.nb
    wb = w.b - ahead * w.no
    d = -((wo - r.u) * no + (wb - r.w) * nb)
    d_s = 2.0 * (r.tu * no + r.tw * nb)
    at = along(rail, envelope, r, w.x, w.to_axle)
    tilt = tilted(at)
    return Opposite(
        d * tilt, d_s * tilt, w.x + at.ahead, 0.5 * (wo + r.u), 0.5 * (wb + r.w) + at.drop, no, nb, w.shrink,
        parting(w.r_t, at), ahead, at.slope,
    )  # fmt: skip


@kernel
def find_end(wheel, rail, arc_wheel, arc_rail, depth, first, direction, limit):
    """Arclength on the rail where the overlap ends, walking from a main point of this depth.

    first: first step [m]; direction: +1.0 or -1.0; limit: largest distance. Returns (distance, status): status 0, or 1
    at the end of a profile.
    """
    wheel_end, rail_end = length(wheel.profile), rail_length(rail)
    inner, inner_arc, inner_d = 0.0, arc_wheel, depth
    shrink = last = opposite(wheel, rail, arc_wheel, arc_rail).shrink
    step = first
    while True:
        outer = min(inner + step, limit)
        arc = inner_arc + direction * (outer - inner) * (1.5 * shrink - 0.5 * last)
        at = opposite(wheel, rail, arc, arc_rail + direction * outer)
        if at.d <= 0.0:
            break
        if outer >= limit:
            return limit, 0
        on_rail = arc_rail + direction * outer
        if arc <= 0.0 or arc >= wheel_end or on_rail <= 0.0 or on_rail >= rail_end:
            return outer, 1
        inner, inner_d = outer, at.d
        inner_arc = arc - at.ahead * at.shrink
        last, shrink = shrink, at.shrink
    bracket = Bracket(inner, inner_d, outer, at.d, 0)
    s = outer
    for _ in range(60):
        s = crossing(bracket)
        arc = inner_arc + direction * (s - inner) * (1.5 * shrink - 0.5 * last)
        h = opposite(wheel, rail, arc, arc_rail + direction * s).d
        if abs(h) < 1e-6 * depth or bracket.hi - bracket.lo < 1e-12:
            break
        bracket = narrowed(bracket, s, h)
    return s, 0


class Walk(NamedTuple):
    """Where a walk along the rows has come to: arclengths on wheel and rail; the wheel's shrink there and a row before;
    how fast the pair has drifted apart on the way."""

    arc: float
    s: float
    shrink: float
    last: float
    drift: float


@kernel
def lay_rows(wheel, rail, grid, rows):
    """Rows of a grid from ``least`` to ``most``, away from its pair of opposite points."""
    arc_wheel, arc_rail = grid.arc, grid.place
    h = (grid.most - grid.least) / (ROWS - 1)
    grid.spacing = h
    grid.deepest = 1e-12
    right = min(max(int((arc_rail - grid.least) / h), 0), ROWS - 1)
    left = right - 1
    at = opposite(wheel, rail, arc_wheel, arc_rail)
    up = down = Walk(arc_wheel - at.ahead * at.shrink, arc_rail, at.shrink, at.shrink, 0.0)
    # to both sides at a time: a processor does one while it waits for the other
    while left >= 0 or right < ROWS:
        if right < ROWS:
            up = _lay_row(wheel, rail, up, grid, rows[right], grid.least + right * h)
            right += 1
        if left >= 0:
            down = _lay_row(wheel, rail, down, grid, rows[left], grid.least + left * h)
            left -= 1


@inlined
def _lay_row(wheel, rail, walk, grid, row, s):
    """Write the row at s, the next one of a walk; returns where that has come to."""
    # how far the pair drifts apart in a step is predicted from the last one
    arc = walk.arc + (s - walk.s) * (1.5 * walk.shrink - 0.5 * walk.last - walk.drift)
    at = opposite(wheel, rail, arc, s)
    taken = at.ahead * at.shrink
    if abs(taken) > NEAR * grid.spacing:
        # where profiles bend sharply: the locus may run along the rail ten times as fast as across
        at = opposite(wheel, rail, arc - taken, s)
        taken += at.ahead * at.shrink
    # a first row may stand beside the pair that the walk begins at
    drift = walk.drift + taken / (s - walk.s) if abs(s - walk.s) > 0.3 * grid.spacing else walk.drift
    row.s, row.arc, row.d, row.x, row.o, row.b = s, arc - taken, at.d, at.x, at.o, at.b
    row.no, row.nb, row.r_t, row.slope = at.no, at.nb, at.r_t, at.slope
    grid.deepest = max(grid.deepest, at.d)
    return Walk(arc - taken, s, at.shrink, walk.shrink, drift)


@kernel
def grade_rows(grid, rows, axle):
    """Density of the strips and its integral; curvatures along the rail as a strip feels them. axle: (t, o, b).

    Along a strip of a wheel whose axle points by e_t along the rail the profile coordinate changes by x times the skew
    e_t / sin(angle), with the angle between normal and axle: a curvature that jumps across the profile is felt as a
    mean over +-a times the skew.
    """
    h = grid.spacing
    total = 0.0
    unit = 1.0 / (h * h * grid.deepest)
    skew = 0.7 * abs(axle.x) / h
    for r in range(ROWS):
        c = min(max(r, 1), ROWS - 2)
        bow = abs(rows[c - 1].d - 2.0 * rows[c].d + rows[c + 1].d)
        run = 0.5 * (rows[c + 1].x - rows[c - 1].x)
        bow += abs(run) * sqrt(h * h + run * run) / rows[c].r_t
        rows[r].xi = np.cbrt((unit * bow) ** 2)
        total += rows[r].xi
    floor = FLOOR * total / ROWS
    for r in range(ROWS):
        row = rows[r]
        near = 0.0
        for q in range(-1, 2):
            near += rows[min(max(r + q, 0), ROWS - 1)].xi
        row.density = near / 3.0 + floor
        lean = row.no * axle.y + row.nb * axle.z
        reach = skew * skew * 2.0 * row.r_t * max(row.d, 0.0) / max(1.0 - lean * lean, LEAST_FACING)
        if reach <= 1.0:
            row.bend = 1.0 / row.r_t
            continue
        reach = sqrt(reach)
        bend = weights = 0.0
        for q in range(max(int(r - reach), 0), min(int(r + reach) + 2, ROWS)):
            weight = 1.0 - abs(q - r) / reach
            if weight > 0.0:
                bend += weight / rows[q].r_t
                weights += weight
        row.bend = bend / weights
    total = 0.0
    for r in range(ROWS):
        if r > 0:
            total += 0.5 * h * (rows[r].density + rows[r - 1].density)
        rows[r].xi = total


@inlined
def _integral(grid, rows, s):
    """Integral of the density up to s, and the density there."""
    x = (s - grid.least) / grid.spacing
    r = min(max(int(x), 0), ROWS - 2)
    x -= r
    rise = rows[r + 1].density - rows[r].density
    return rows[r].xi + grid.spacing * x * (rows[r].density + 0.5 * x * rise), rows[r].density + x * rise


@inlined
def _cubic(a, b, c, d, t, h):
    """A number at t, 0 to 1, from the second of four rows to the third, and its slope along the rail: a cubic whose
    slopes at rows are those over the rows beside them, so that Newton's method meets no corner."""
    rise = 0.5 * (c - a)
    bow = a - 2.5 * b + 2.0 * c - 0.5 * d
    turn = 0.5 * (d - a) + 1.5 * (b - c)
    return b + t * (rise + t * (bow + t * turn)), (rise + t * (2.0 * bow + 3.0 * t * turn)) / h


@kernel
def place_strips(wheel, rail, grid, rows, places):
    """Lay the strips of a grid between its edges and find the geometry there. places: its own."""
    n = places.size
    h = grid.spacing
    first, density_start = _integral(grid, rows, grid.start)
    end, density_end = _integral(grid, rows, grid.end)
    r = min(max(int((grid.start - grid.least) / h), 0), ROWS - 2)
    lo, lo_start, lo_end = grid.start, 1.0, 0.0
    for j in range(n):
        place = places[j]
        share = (j + 1.0) / n
        goal = first + share * (end - first)
        while r < ROWS - 2 and rows[r + 1].xi < goal:
            r += 1
        density, rise = rows[r].density, rows[r + 1].density - rows[r].density
        c = (goal - rows[r].xi) / h
        x = 2.0 * c / (density + sqrt(max(density * density + 2.0 * rise * c, 1e-30)))
        there = max(density + x * rise, 1e-12)
        place.lo, place.lo_start, place.lo_end = lo, lo_start, lo_end
        lo, lo_start, lo_end = rows[r].s + h * x, (1.0 - share) * density_start / there, share * density_end / there
        if j == n - 1:
            lo, lo_start, lo_end = grid.end, 0.0, 1.0
        place.hi, place.hi_start, place.hi_end = lo, lo_start, lo_end
        s = place.s = 0.5 * (place.lo + place.hi)
        x = (s - grid.least) / h
        c = min(max(int(x), 1), ROWS - 3)
        t = x - c
        # profiles bend sharply within a row's distance: what lies between rows is computed, not read
        arc = rows[c].arc + t * (rows[c + 1].arc - rows[c].arc)
        at = opposite(wheel, rail, arc, s)
        taken = at.ahead * at.shrink
        if abs(taken) > NEAR * h:
            at = opposite(wheel, rail, arc - taken, s)
        place.d, place.d_s, place.no, place.nb = at.d, at.d_s, at.no, at.nb
        place.bend, place.bend_s = _cubic(rows[c - 1].bend, rows[c].bend, rows[c + 1].bend, rows[c + 2].bend, t, h)
        place.x, place.x_s = _cubic(rows[c - 1].x, rows[c].x, rows[c + 1].x, rows[c + 2].x, t, h)


@inlined
def next_corner(rows, p, end, step):
    """The corner behind row p of the concave hull of the penetration, on the way to row ``end``, and how much the hull
    rises from row to row up to there. step: +1 or -1."""
    q, steep = p + step, rows[p + step].d - rows[p].d
    for r in range(p + 2 * step, end + step, step):
        slope = (rows[r].d - rows[p].d) / abs(r - p)
        if slope >= steep:
            q, steep = r, slope
    return q, steep


@kernel
def make_room(grids, k, end):
    """Bounds of the grids from k to before ``end`` move on by one; those of k stand twice then."""
    for later in range(end, k, -1):
        grids[later].least, grids[later].most = grids[later - 1].least, grids[later - 1].most
