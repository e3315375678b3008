"""First guesses of the strip model, and what is done until it has a solution.

In a run the last contact is the first guess. Else Hertz's slanted ellipses, or all ground that may touch, and Newton's
method for all at once. If both fail, every grid is solved for alone, then they come to press each other down step by
step. The conditions of so many strips may have no solution at a pose where those of fewer have: these are tried after
that, with one strip less a grid each."""

from math import inf
from typing import NamedTuple

from wrsim.contact.strips.changes import HUMP, RETURN, begin_grid, in_contact, leave
from wrsim.contact.strips.equations import block_of, lay_strips, set_fading
from wrsim.contact.strips.ground import LOW
from wrsim.contact.strips.hertz import hertz_ellipse
from wrsim.contact.strips.newton import NEAR, descend, newton
from wrsim.contact.strips.records import EDGES, OF_A_STRIP, ROWS, V
from wrsim.jit.compiling import kernel
from wrsim.jit.dense import copy

TOLERANCE = 1e-9  # of a cold start, over the deepest penetration
ROUND_OFF = 1e-15  # of penetrations: places are some decimetres [m]
SURELY = 0.7  # of the largest penetration: a grid that is in contact to begin with
LEVELS = 0.0, LOW, 0.3  # of a grid's depth: where contact ends in first guesses; in the first one where Hertz's does
LEAST_PORTION = 1 / 32  # of the coupling of grids, at which a solution is given up
MOST = 1500  # residuals, from which on no fewer strips are tried: more than any of a million random poses takes


@kernel
def solve(system, n, known, tolerance):
    """Solve; known: the unknowns are those of a contact near by, solved to the tolerance. Returns the number of strips
    of a grid that have a solution: n or fewer; 0 if none down to half of n have one, or MOST residuals found none."""
    memo = system.memo[0]
    memo.iterations = memo.factorisations = 0
    for g in range(memo.grids):
        system.grids[g].entries = 0
    if known and _solved(system, n, tolerance):
        return n
    strips = n
    while strips > n // 2 and memo.iterations < MOST:
        for level in LEVELS:
            if _at_once(system, strips, level):
                return strips
        if _one_by_one(system, strips):
            return strips
        strips -= 1
    return 0


@kernel
def _couple(system, n):
    """Solve while grids come to press each other down more and more. True if that works: a continuation in their
    coupling, whose portions are halved until Newton's method follows, and doubled behind (Deuflhard, Newton Methods for
    Nonlinear Problems, 2004, chapter 5)."""
    vectors, size = system.vectors, system.memo[0].grids * block_of(n)
    done, portion = 0.0, 1.0
    while done < 1.0:
        share = min(done + portion, 1.0)
        copy(size, vectors[V.X], vectors[V.SOUND])
        set_fading(system, share)
        if descend(system, n, NEAR):
            done = share
            portion *= 2.0
            continue
        portion *= 0.5
        if portion < LEAST_PORTION or system.memo[0].grids == 1:
            break
        copy(size, vectors[V.SOUND], vectors[V.X])
        _switch(system, n)
    set_fading(system, 1.0)
    return done == 1.0 and _solved(system, n, TOLERANCE)


@kernel
def _switch(system, n):
    """Which grids are in contact, and which edges at their bounds, as the unknowns have it."""
    x = system.vectors[V.X]
    for g in range(system.memo[0].grids):
        grid, base = system.grids[g], g * block_of(n)
        e = base + OF_A_STRIP * n
        grid.on = int(in_contact(x[base : base + n])[2] > 0)
        grid.start_held, grid.end_held = int(x[e] <= grid.least), int(x[e + 1] >= grid.most)
    lay_strips(system, n)


@kernel
def _solved(system, n, tolerance):
    """Newton's method near a solution. True if it ends in one: all unknowns are numbers, some strip is in contact."""
    if not newton(system, n, max(tolerance, ROUND_OFF / system.memo[0].deepest)):
        return False
    x, block = system.vectors[V.X], block_of(n)
    touches = False
    for g in range(system.memo[0].grids):
        for j in range(block if system.grids[g].on else 0):
            if not abs(x[g * block + j]) < inf:
                return False
            touches = touches or (j < n and x[g * block + j] > 0.0)
    return touches


class Hump(NamedTuple):
    """The ground of a grid, weighted with the penetration beyond a level: means of place s, shift x and 1/R_x; ratio of
    its curvature across to that along; slope of its ridge's place along the rail."""

    s: float
    x: float
    bend: float
    ratio: float
    slope: float


@kernel
def _hump_of(grid, rows):
    """Where a parabola is more than a level deep the square of its half width is five times the mean square."""
    level = HUMP * grid.deepest
    total = s_mean = x_mean = bend = ss = sx = 0.0
    for r in range(ROWS):
        d = max(rows[r].d - level, 1e-12)
        total += d
        s_mean += d * rows[r].s
        x_mean += d * rows[r].x
        bend += d / rows[r].r_t
    s_mean, x_mean, bend = s_mean / total, x_mean / total, bend / total
    for r in range(ROWS):
        d, s = max(rows[r].d - level, 1e-12) / total, rows[r].s - s_mean
        ss += d * s * s
        sx += d * s * (rows[r].x - x_mean)
    return Hump(s_mean, x_mean, bend, 0.4 * (1.0 - HUMP) * grid.deepest / (bend * ss), sx / ss)


@kernel
def _guess(system, n, g, level):
    """A grid's contact: Hertz's ellipse, where the penetration is more than at the ellipse's edges, or than a level of
    its depth, if there is one."""
    grid, rows, x = system.grids[g], system.rows[g], system.vectors[V.X]
    base, depth = g * block_of(n), grid.deepest
    hump = _hump_of(grid, rows)
    ellipse = hertz_ellipse(hump.ratio, hump.slope, depth, hump.bend)
    edge = 1.0 - ellipse.half_width**2 * hump.ratio * hump.bend / (2.0 * depth)
    level = level if level > 0.0 else max(edge, 0.0)
    first, last = ROWS - 1, 0
    for r in range(ROWS):
        if rows[r].d > level * depth:
            first, last = min(first, r), max(last, r)
    start = max(rows[first].s - 0.5 * grid.spacing, grid.least)
    end = min(rows[last].s + 0.5 * grid.spacing, grid.most)
    begin_grid(system, n, g, start, end, depth, hump.bend, ellipse.factor)
    lay_strips(system, n)
    if system.memo[0].shifted and level == edge:
        middles, stretch = x[base + OF_A_STRIP * n + EDGES :], (ellipse.stretch - 1.0) * hump.slope
        middles[0] = stretch * (0.5 * (start + end) - hump.s)
        middles[1] = stretch * 0.5 * (end - start)
    most = ellipse.half_length**2 * hump.bend / (2.0 * depth)
    for j in range(n):
        place = system.places[g * n + j]
        share = max((place.d / depth - edge) / (1.0 - edge), 0.02)
        x[base + j] = 2.0 * most * depth / place.bend * share


@kernel
def _clear(system, n):
    """No grid is in contact."""
    memo = system.memo[0]
    memo.inverted = 0
    system.vectors[V.X, : memo.grids * block_of(n)] = 0.0
    for g in range(memo.grids):
        system.grids[g].on = system.grids[g].entries = 0


@kernel
def _at_once(system, n, level):
    """Solve for all grids at once from Hertz's ellipses, or from all ground above a level. True if that works."""
    memo = system.memo[0]
    _clear(system, n)
    for g in range(memo.grids):
        if system.grids[g].deepest >= SURELY * memo.deepest:
            _guess(system, n, g, level)
    return descend(system, n, NEAR) and _solved(system, n, TOLERANCE)


@kernel
def _one_by_one(system, n):
    """Solve for each grid as if it were alone, then let them press each other down. True if that works."""
    memo, grids = system.memo[0], system.grids
    _clear(system, n)
    set_fading(system, 0.0)
    for g in range(memo.grids):
        if grids[g].deepest >= RETURN * memo.deepest and not _alone(system, n, g):
            leave(system, n, g)
        grids[g].on = 0
    _switch(system, n)
    return _couple(system, n)


@kernel
def _alone(system, n, g):
    """Solve for one grid, the only one in contact. True if that works."""
    for level in LEVELS:
        _guess(system, n, g, level)
        if descend(system, n, NEAR):
            return newton(system, n, TOLERANCE) and system.grids[g].on > 0
    return False
