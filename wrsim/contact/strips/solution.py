"""First guesses of the strip model, and what is done until it has a solution.

In a run the last contact is the first guess; a cold start begins with Hertz's slanted ellipses or all rows deep enough
to touch, then with each grid alone, then with fewer strips (docs/theory/strip_model.md, Method 3 and 4)."""

from math import inf
from typing import NamedTuple

from wrsim.contact.strips.changes import (
    ACTIVATION_OVERLAP,
    CONTACT_LEVEL,
    carry_over,
    deactivate_grid,
    in_contact,
    initialise_grid,
)
from wrsim.contact.strips.equations import block_of, edges_of, hold_edges, place_strips, residual_price, set_fading
from wrsim.contact.strips.grid_layout import MIN_DEPTH
from wrsim.contact.strips.hertz import hertz_ellipse
from wrsim.contact.strips.newton import CHECK_RESIDUAL, DROP_RESIDUAL, MAX_STEPS, descend, jacobian_price, newton
from wrsim.contact.strips.records import EDGES, ROWS, System, V
from wrsim.jit import Record, Records, inlined, kernel
from wrsim.jit.dense import copy

TOLERANCE = 1e-9  # of a cold start, over the deepest penetration
ROUND_OFF = 1e-15  # of penetrations: points lie some decimetres from the origin [m]
START_DEPTH = 0.7  # of the deepest penetration: a grid that is in contact to begin with
LEVELS = 0.0, MIN_DEPTH, 0.3  # of a grid's depth: where contact ends in first guesses; in the first one as Hertz's does
MIN_COUPLING_STEP = 1 / 32  # of the coupling of grids, at which a solution is given up
MAX_RESIDUALS = 1500  # no fewer strips are tried from then on: more than any of a million random poses takes


@kernel
def solve(system: System, n: int, known: bool, tolerance: float) -> int:
    """Solve; known: the unknowns are those of a contact near by, solved to the tolerance. Returns the number of strips
    of a grid that have a solution: n or fewer; 0 if none down to half of n have one, or MAX_RESIDUALS found none.

    With a budget below that half as many strips are solved for where it does not suffice for all."""
    memo = system.memo[0]
    memo.iterations = memo.factorisations = 0
    memo.left = 0.0
    for g in range(memo.grids):
        system.grids[g].entries = 0
    if memo.budget < MAX_RESIDUALS:
        return _solve_within(system, n, known, tolerance)
    if known and memo.laid == n and _converges(system, n, tolerance):
        return n
    memo.laid = strips = n
    while strips > n // 2 and memo.iterations < MAX_RESIDUALS:
        for level in LEVELS:
            if _solve_at_once(system, strips, level, TOLERANCE):
                return strips
        if _solve_one_by_one(system, strips):
            return strips
        strips -= 1
    return 0


@inlined
def step_price(system: System, n: int) -> float:
    """What a contact near by takes to CHECK_RESIDUAL: a Jacobian, and three residuals, as steps from DROP_RESIDUAL
    leave .06 each."""
    return 3.0 * residual_price(system, n) + jacobian_price(system, n)


@kernel
def _solve_within(system: System, n: int, known: bool, tolerance: float) -> int:
    """Solve within the budget: as usual, but each Jacobian leaves what half as many strips take; else with these to
    CHECK_RESIDUAL, and with all of them from there, if that is affordable. What is left unsolved is a contact below
    DROP_RESIDUAL, and the next call goes on with it."""
    memo, half, before = system.memo[0], n // 2, system.memo[0].laid
    if known and before == n:
        memo.spare = step_price(system, half)
        solved = _converges(system, n, tolerance) or 0.0 < memo.left < CHECK_RESIDUAL
        memo.spare = 0.0
        if solved:
            return n
    memo.laid = half
    if not known or before == n:
        known = memo.grids_before > 0 and carry_over(system, before, half)
    memo.left = 0.0
    solved = known and memo.unsolved < MAX_STEPS and _converges(system, half, CHECK_RESIDUAL)
    for level in LEVELS:
        solved = solved or (memo.left == 0.0 and _solve_at_once(system, half, level, CHECK_RESIDUAL))
    if not solved:
        memo.unsolved = (memo.unsolved if memo.unsolved < MAX_STEPS else 0) + memo.iterations
        memo.left = memo.left if _touches(system, half) and memo.left <= 1.0 else 0.0  # 1: no contact leaves as much
        return half if 0.0 < memo.left < DROP_RESIDUAL else 0
    memo.unsolved = 0
    if memo.work + 2.0 * step_price(system, n) > memo.budget:
        return half
    copy(memo.grids * block_of(half), system.vectors[V.X], system.vectors[V.LAST_SOLUTION])
    memo.grids_before = memo.grids
    carry_over(system, half, n)
    if _converges(system, n, tolerance) or 0.0 < memo.left < CHECK_RESIDUAL:
        memo.laid = n
        return n
    memo.left = 0.0
    copy(memo.grids * block_of(half), system.vectors[V.LAST_SOLUTION], system.vectors[V.X])
    _set_active_set(system, half)
    memo.inverted = 0
    return half


@kernel
def _couple(system: System, n: int) -> bool:
    """Solve while grids come to press each other down more and more. True if that works: a continuation in their
    coupling, whose steps are halved until Newton's method follows, and doubled behind (Deuflhard, Newton Methods for
    Nonlinear Problems, 2004, chapter 5)."""
    vectors, size = system.vectors, system.memo[0].grids * block_of(n)
    done, step = 0.0, 1.0
    while done < 1.0:
        share = min(done + step, 1.0)
        copy(size, vectors[V.X], vectors[V.LAST_SOLUTION])
        set_fading(system, share)
        if descend(system, n, CHECK_RESIDUAL):
            done = share
            step *= 2.0
            continue
        step *= 0.5
        if step < MIN_COUPLING_STEP or system.memo[0].grids == 1:
            break
        copy(size, vectors[V.LAST_SOLUTION], vectors[V.X])
        _set_active_set(system, n)
    set_fading(system, 1.0)
    return done == 1.0 and _converges(system, n, TOLERANCE)


@kernel
def _set_active_set(system: System, n: int) -> None:
    """Which grids are in contact, and which edges at their bounds, as the unknowns have it."""
    x = system.vectors[V.X]
    for g in range(system.memo[0].grids):
        grid, base, e = system.grids[g], g * block_of(n), edges_of(n, g)
        grid.active = int(in_contact(x[base : base + n])[2] > 0)
        hold_edges(grid, x[e], x[e + 1])
    place_strips(system, n)


@kernel
def _converges(system: System, n: int, tolerance: float) -> bool:
    """Newton's method near a solution. True if it ends in one: all unknowns are numbers, some strip is in contact."""
    if not newton(system, n, max(tolerance, ROUND_OFF / system.memo[0].deepest)):
        return False
    return _touches(system, n)


@kernel
def _touches(system: System, n: int) -> bool:
    """Whether all unknowns are numbers and some strip is in contact."""
    x, block = system.vectors[V.X], block_of(n)
    touches = False
    for g in range(system.memo[0].grids):
        for j in range(block if system.grids[g].active else 0):
            if not abs(x[g * block + j]) < inf:
                return False
            touches = touches or (j < n and x[g * block + j] > 0.0)
    return touches


class Maximum(NamedTuple):
    """A local maximum of the penetration, by its moments beyond a level."""

    s: float  # mean place [m]
    x: float  # mean shift [m]
    curvature: float  # mean of 1/R_x [1/m]
    ratio: float  # curvature across over that along
    slope: float  # of the ridge's shift over s


@kernel
def _main_maximum(grid: Record, rows: Records) -> Maximum:
    """The maximum of a grid, whose penetration is a parabola: where that is more than a level deep the square of its
    half width is five times the mean square."""
    level = CONTACT_LEVEL * grid.deepest
    total = s_mean = x_mean = curvature = ss = sx = 0.0
    for r in range(ROWS):
        d = max(rows[r].d - level, 1e-12)
        total += d
        s_mean += d * rows[r].s
        x_mean += d * rows[r].x
        curvature += d / rows[r].r_t
    s_mean, x_mean, curvature = s_mean / total, x_mean / total, curvature / total
    for r in range(ROWS):
        d, s = max(rows[r].d - level, 1e-12) / total, rows[r].s - s_mean
        ss += d * s * s
        sx += d * s * (rows[r].x - x_mean)
    ratio = 0.4 * (1.0 - CONTACT_LEVEL) * grid.deepest / (curvature * ss)
    return Maximum(s_mean, x_mean, curvature, ratio, sx / ss)


@kernel
def _first_guess(system: System, n: int, g: int, level: float) -> None:
    """A grid's contact: Hertz's ellipse (strip-hertz), where the penetration is more than at the ellipse's edges, or
    than a level of its depth, if there is one."""
    grid, rows, x = system.grids[g], system.rows[g], system.vectors[V.X]
    base, depth = g * block_of(n), grid.deepest
    maximum = _main_maximum(grid, rows)
    ellipse = hertz_ellipse(maximum.ratio, maximum.slope, depth, maximum.curvature)
    edge = 1.0 - ellipse.half_width**2 * maximum.ratio * maximum.curvature / (2.0 * depth)
    level = level if level > 0.0 else max(edge, 0.0)
    first, last = ROWS - 1, 0
    for r in range(ROWS):
        if rows[r].d > level * depth:
            first, last = min(first, r), max(last, r)
    start = max(rows[first].s - 0.5 * grid.spacing, grid.least)
    end = min(rows[last].s + 0.5 * grid.spacing, grid.most)
    initialise_grid(system, n, g, start, end, depth, maximum.curvature, ellipse.factor)
    place_strips(system, n)
    if system.memo[0].has_shifts and level == edge:
        middles, stretch = x[edges_of(n, g) + EDGES :], (ellipse.stretch - 1.0) * maximum.slope
        middles[0] = stretch * (0.5 * (start + end) - maximum.s)
        middles[1] = stretch * 0.5 * (end - start)
    most = ellipse.half_length**2 * maximum.curvature / (2.0 * depth)
    for j in range(n):
        place = system.places[g * n + j]
        share = max((place.d / depth - edge) / (1.0 - edge), 0.02)
        x[base + j] = 2.0 * most * depth / place.curvature * share


@kernel
def _clear(system: System, n: int) -> None:
    """Take all grids out of contact."""
    memo = system.memo[0]
    memo.inverted = 0
    system.vectors[V.X, : memo.grids * block_of(n)] = 0.0
    for g in range(memo.grids):
        system.grids[g].active = system.grids[g].entries = 0


@kernel
def _solve_at_once(system: System, n: int, level: float, tolerance: float) -> bool:
    """Solve for all grids at once from Hertz's ellipses, or from all rows above a level. True if that works."""
    memo = system.memo[0]
    _clear(system, n)
    for g in range(memo.grids):
        if system.grids[g].deepest >= START_DEPTH * memo.deepest:
            _first_guess(system, n, g, level)
    return descend(system, n, DROP_RESIDUAL) and _converges(system, n, tolerance)


@kernel
def _solve_one_by_one(system: System, n: int) -> bool:
    """Solve for each grid as if it were alone, then let them press each other down. True if that works."""
    memo, grids = system.memo[0], system.grids
    _clear(system, n)
    set_fading(system, 0.0)
    for g in range(memo.grids):
        if grids[g].deepest >= ACTIVATION_OVERLAP * memo.deepest and not _solve_alone(system, n, g):
            deactivate_grid(system, n, g)
        grids[g].active = 0
    _set_active_set(system, n)
    return _couple(system, n)


@kernel
def _solve_alone(system: System, n: int, g: int) -> bool:
    """Solve for one grid, the only one in contact. True if that works."""
    for level in LEVELS:
        _first_guess(system, n, g, level)
        if descend(system, n, CHECK_RESIDUAL):
            return newton(system, n, TOLERANCE) and system.grids[g].active > 0
    return False
