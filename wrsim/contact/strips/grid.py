"""Grids of the strip model: where rows and strips lie, and what the profiles are there.

Rows stand at equal steps of the rail's arclength, each with the point of the wheel's outline opposite it, so that the
penetration d(s) belongs to the pose alone, wherever it is counted from. Strips lie between the edges of the contact,
as densely as (strip-density) has it.
"""

from math import sqrt
from typing import Any, NamedTuple

from wrsim.contact.overlap_patch import bisector, first_step
from wrsim.contact.records import PlacedWheel, ProfileTable, Rail
from wrsim.contact.search.locus import Locus, locus_point, yawed_point
from wrsim.contact.strips.records import ROWS
from wrsim.contact.surfaces.profile_table import ProfilePoint, inner_point, length
from wrsim.contact.surfaces.rail import (
    Along,
    Envelope,
    along,
    along_rail,
    changes,
    parting,
    rail_and_envelope,
    rail_length,
    tilted,
)
from wrsim.jit import Array, Record, Records, inlined, kernel, noalias_kernel
from wrsim.jit.arena import bits_of, number_of
from wrsim.jit.linalg import Vec
from wrsim.jit.root import Bracket, crossing, narrowed

MIN_DENSITY = 0.3  # share of even density
ROUNDS = 8  # at most in which points are brought opposite: each leaves a tenth of the distance or less
MAX_AHEAD = 0.01  # of the rows' distance: how far ahead a point may be for the shift along the rail to be read there
_THIRD = (2 * 1023 << 52) // 3  # of the bits of 1.0, what a third of a number's own leaves
LEVEL = Envelope(0.0, 0.0, 0.0, 0.0, 0.0)  # of a rail of one profile
MIN_SINE_SQUARED = 2.5e-3  # square of the sine between axle and normal, held above


class Opposite(NamedTuple):
    """A pair of opposite points of wheel and rail: numbers, or of several pairs arrays (n,)."""

    d: Any  # penetration along the mean normal [m]
    d_s: Any  # its slope over s: the tangents lean by the same angle to both sides of the mean one
    x: Any  # middle of the pair along the rail [m]
    o: Any  # outward [m]
    b: Any  # upward [m]
    no: Any  # normal, outward
    nb: Any  # upward
    shrink: Any  # arclength of the wheel's profile over that of its outline
    r_t: Any  # radius with which both part along the rail [m]
    ahead: Any  # distance of the wheel's point ahead of the rail's [m]
    slope: Any  # of the rail along the track


@inlined
def opposite(wheel: PlacedWheel, rail: Rail, arc_wheel: float, arc_rail: float) -> Opposite:
    """The pair at these arclengths; what the wheel's point is ahead along the mean tangent is taken back along its own
    circle of curvature."""
    w = locus_point(wheel, arc_wheel)
    r, envelope = rail_and_envelope(rail, arc_rail)
    return _pair_of(w, r, envelope, along(rail, envelope, r, w.x, w.to_axle))


@inlined
def _pair_of(w: Locus, r: ProfilePoint, envelope: Envelope, frame: Along) -> Opposite:
    """The pair of two points; envelope, frame: what the rail does along the track there."""
    no, nb = bisector(w, r)
    ahead = (w.o - r.u) * nb - (w.b - r.w) * no
    turn = 0.5 * w.shrink * w.k * ahead  # half of what the wheel's normal turns by on the way
    wo = w.o + ahead * (w.nb - turn * w.no)
    wb = w.b - ahead * (w.no + turn * w.nb)
    no, nb = no - turn * w.nb, nb + turn * w.no
    d = -((wo - r.u) * no + (wb - r.w) * nb)
    d_s = 2.0 * (r.tu * no + r.tw * nb)
    tilt = tilted(frame)
    r_t, farther = parting(w.r_t, envelope, d)
    return Opposite(
        d * tilt, d_s * tilt, w.x + frame.ahead + farther, 0.5 * (wo + r.u), 0.5 * (wb + r.w) + frame.drop, no, nb,
        w.shrink, r_t, ahead, frame.slope,
    )  # fmt: skip


@inlined
def _set_pair(out: Opposite, j: int, pair: Opposite) -> None:
    """Write a pair to place j of arrays."""
    out.d[j], out.d_s[j], out.x[j], out.o[j], out.b[j] = pair.d, pair.d_s, pair.x, pair.o, pair.b
    out.no[j], out.nb[j], out.shrink[j], out.r_t[j] = pair.no, pair.nb, pair.shrink, pair.r_t
    out.ahead[j], out.slope[j] = pair.ahead, pair.slope


@noalias_kernel
def _set_plain_pairs(wheel: PlacedWheel, rail: Rail, arcs: Array, places: Array, out: Opposite) -> None:
    """The pairs at these arclengths of a round wheel that yaws on a rail of one profile, several at a time."""
    profile = ProfileTable(rail.table, rail.step)
    for j in range(arcs.size):
        w, r = yawed_point(wheel, inner_point(wheel.profile, arcs[j])), inner_point(profile, places[j])
        _set_pair(out, j, _pair_of(w, r, LEVEL, along_rail(rail, LEVEL, r, w.x, w.to_axle)))


@inlined
def _pairs(work: Array, n: int) -> Opposite:
    """What ``_find_pairs`` leaves, arrays (n,)."""
    return Opposite(
        work[2, :n], work[3, :n], work[4, :n], work[5, :n], work[6, :n], work[7, :n], work[8, :n], work[9, :n],
        work[10, :n], work[11, :n], work[12, :n],
    )  # fmt: skip


@kernel
def _find_pairs(wheel: PlacedWheel, rail: Rail, spacing: float, work: Array, n: int) -> None:
    """Find pairs at rising places on the rail, ``work[1]``, of the wheel's points near those in ``work[0]``, which are
    brought opposite, (n,): ``_pairs``. Where profiles bend sharply the locus may run along the rail ten times as fast
    as across, and pairs are computed once more."""
    arcs, places, out = work[0, :n], work[1, :n], _pairs(work, n)
    plain = wheel.lean != 0.0 and wheel.roller == 0.0 and not changes(rail)
    plain = plain and places[0] > 0.0 and places[n - 1] < rail_length(rail)
    for _ in range(ROUNDS):
        if plain and arcs[0] > 0.0 and arcs[n - 1] < length(wheel.profile):
            _set_plain_pairs(wheel, rail, arcs, places, out)
        else:
            for j in range(n):
                _set_pair(out, j, opposite(wheel, rail, arcs[j], places[j]))
        farthest = 0.0
        for j in range(n):
            before = out.ahead[j] * out.shrink[j]
            arcs[j] -= before
            farthest = max(farthest, abs(before))
        if farthest <= MAX_AHEAD * spacing:
            break


@kernel
def find_end(wheel: PlacedWheel, rail: Rail, contact: Record, direction: float, limit: float) -> tuple[float, int]:
    """Distance on the rail from a contact to the end of the overlap.

    direction: +1.0 or -1.0; limit: largest distance. Returns (distance, status): status 0, or 1 at the end of a
    profile.
    """
    wheel_end, rail_end = length(wheel.profile), rail_length(rail)
    arc_rail, depth = contact.arc_rail, contact.depth
    inner, inner_arc, inner_d = 0.0, contact.arc_wheel, depth
    shrink = last = opposite(wheel, rail, contact.arc_wheel, arc_rail).shrink
    step = first_step(depth, contact.curvature)
    while True:
        outer = min(inner + step, limit)
        arc = inner_arc + direction * (outer - inner) * (1.5 * shrink - 0.5 * last)
        pair = opposite(wheel, rail, arc, arc_rail + direction * outer)
        if pair.d <= 0.0:
            break
        if outer >= limit:
            return limit, 0
        on_rail = arc_rail + direction * outer
        if arc <= 0.0 or arc >= wheel_end or on_rail <= 0.0 or on_rail >= rail_end:
            return outer, 1
        inner, inner_d = outer, pair.d
        inner_arc = arc - pair.ahead * pair.shrink
        last, shrink = shrink, pair.shrink
    bracket = Bracket(inner, inner_d, outer, pair.d, 0)
    s = outer
    for _ in range(60):
        s = crossing(bracket)
        arc = inner_arc + direction * (s - inner) * (1.5 * shrink - 0.5 * last)
        h = opposite(wheel, rail, arc, arc_rail + direction * s).d
        if abs(h) < 1e-6 * depth or bracket.hi - bracket.lo < 1e-12:
            break
        bracket = narrowed(bracket, s, h)
    return s, 0


@kernel
def sample_rows(wheel: PlacedWheel, rail: Rail, grid: Record, rows: Records, work: Array) -> None:
    """Rows of a grid from ``least`` to ``most``, away from its pair of opposite points. work: (13, ROWS) scratch."""
    h = (grid.most - grid.least) / (ROWS - 1)
    grid.spacing = h
    grid.deepest = 1e-12
    pair = opposite(wheel, rail, grid.arc_wheel, grid.arc_rail)
    for r in range(ROWS):
        s = work[1, r] = grid.least + r * h
        work[0, r] = grid.arc_wheel + (s - grid.arc_rail - pair.ahead) * pair.shrink
    _find_pairs(wheel, rail, h, work, ROWS)
    out = _pairs(work, ROWS)
    for r in range(ROWS):
        row = rows[r]
        row.s, row.arc_wheel, row.d, row.x, row.o = work[1, r], work[0, r], out.d[r], out.x[r], out.o[r]
        row.b, row.no, row.nb, row.r_t, row.slope = out.b[r], out.no[r], out.nb[r], out.r_t[r], out.slope[r]
        grid.deepest = max(grid.deepest, row.d)


@inlined
def _cube_root(x: float) -> float:
    """Of x > 0 to 1e-12, by two steps of Halley's method from a third of the exponent: a library's takes 10 ns."""
    y = number_of(bits_of(x) // 3 + _THIRD)
    for _ in range(2):
        cube = y * y * y
        y *= (cube + 2.0 * x) / (2.0 * cube + x)
    return y


@kernel
def grade_rows(grid: Record, rows: Records, axle: Vec) -> None:
    """Density of the strips (strip-density) and its integral; curvatures along the rail as a strip feels them. axle:
    (t, o, b).

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
        rows[r].xi = _cube_root(max((unit * bow) ** 2, 1e-30))
        total += rows[r].xi
    floor = MIN_DENSITY * total / ROWS
    for r in range(ROWS):
        row = rows[r]
        near = 0.0
        for q in range(-1, 2):
            near += rows[min(max(r + q, 0), ROWS - 1)].xi
        row.density = near / 3.0 + floor
        lean = row.no * axle.y + row.nb * axle.z
        reach = skew * skew * 2.0 * row.r_t * max(row.d, 0.0) / max(1.0 - lean * lean, MIN_SINE_SQUARED)
        if reach <= 1.0:
            row.curvature = 1.0 / row.r_t
            continue
        reach = sqrt(reach)
        curvature = weights = 0.0
        for q in range(max(int(r - reach), 0), min(int(r + reach) + 2, ROWS)):
            weight = 1.0 - abs(q - r) / reach
            if weight > 0.0:
                curvature += weight / rows[q].r_t
                weights += weight
        row.curvature = curvature / weights
    total = 0.0
    for r in range(ROWS):
        if r > 0:
            total += 0.5 * h * (rows[r].density + rows[r - 1].density)
        rows[r].xi = total


@inlined
def row_below(grid: Record, s: float) -> tuple[int, float]:
    """Number of the row below s, and the distance from it in rows."""
    x = (s - grid.least) / grid.spacing
    r = min(max(int(x), 0), ROWS - 2)
    return r, x - r


@inlined
def _integral(grid: Record, rows: Records, s: float) -> tuple[float, float]:
    """Integral of the density up to s, and the density there."""
    r, x = row_below(grid, s)
    rise = rows[r + 1].density - rows[r].density
    return rows[r].xi + grid.spacing * x * (rows[r].density + 0.5 * x * rise), rows[r].density + x * rise


@inlined
def _cubic(a: float, b: float, c: float, d: float, t: float, h: float) -> tuple[float, float]:
    """A number at t, 0 to 1, from the second of four rows to the third, and its slope along the rail: a cubic whose
    slopes at rows are those over the rows beside them, so that Newton's method meets no corner."""
    rise = 0.5 * (c - a)
    bow = a - 2.5 * b + 2.0 * c - 0.5 * d
    turn = 0.5 * (d - a) + 1.5 * (b - c)
    return b + t * (rise + t * (bow + t * turn)), (rise + t * (2.0 * bow + 3.0 * t * turn)) / h


@kernel
def place_grid_strips(
    wheel: PlacedWheel, rail: Rail, grid: Record, rows: Records, places: Records, work: Array
) -> None:
    """Place the strips of one grid, ``places``, between its edges by (strip-density), and find the geometry there.
    work: (13, >= strips) scratch."""
    n = places.size
    h, inverse = grid.spacing, 1.0 / grid.spacing
    first, density_start = _integral(grid, rows, grid.start)
    end, density_end = _integral(grid, rows, grid.end)
    r, _x = row_below(grid, grid.start)
    lo, lo_start, lo_end = grid.start, 1.0, 0.0
    for j in range(n):
        place = places[j]
        share = (j + 1.0) / n
        goal = first + share * (end - first)
        while r < ROWS - 2 and rows[r + 1].xi < goal:
            r += 1
        density, rise = rows[r].density, rows[r + 1].density - rows[r].density
        c = (goal - rows[r].xi) * inverse
        x = 2.0 * c / (density + sqrt(max(density * density + 2.0 * rise * c, 1e-30)))
        there = max(density + x * rise, 1e-12)
        place.lo, place.lo_start, place.lo_end = lo, lo_start, lo_end
        lo, lo_start, lo_end = rows[r].s + h * x, (1.0 - share) * density_start / there, share * density_end / there
        if j == n - 1:
            lo, lo_start, lo_end = grid.end, 0.0, 1.0
        place.hi, place.hi_start, place.hi_end = lo, lo_start, lo_end
    # apart from the boundaries: a processor takes several strips at a time
    for j in range(n):
        place = places[j]
        s = place.s = work[1, j] = 0.5 * (place.lo + place.hi)
        x = (s - grid.least) * inverse
        c = min(max(int(x), 1), ROWS - 3)
        t = x - c
        # profiles bend sharply within a row's distance: what lies between rows is computed, not read
        work[0, j] = rows[c].arc_wheel + t * (rows[c + 1].arc_wheel - rows[c].arc_wheel)
        place.curvature, place.curvature_s = _cubic(
            rows[c - 1].curvature, rows[c].curvature, rows[c + 1].curvature, rows[c + 2].curvature, t, h
        )
        place.x, place.x_s = _cubic(rows[c - 1].x, rows[c].x, rows[c + 1].x, rows[c + 2].x, t, h)
    _find_pairs(wheel, rail, h, work, n)
    out = _pairs(work, n)
    for j in range(n):
        place = places[j]
        place.d, place.d_s, place.no, place.nb = out.d[j], out.d_s[j], out.no[j], out.nb[j]
