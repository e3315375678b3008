"""First guesses, and what is done until the strip model has a solution.

In a run the last contact is the first guess. Else: Hertz's ellipses where the penetration is large, then in turns half
lengths for given factors and edges (a monotone problem: strips leave and enter as they like), edges from the outer
strips, factors from the misfits of the curvatures; at last Newton's method for all at once. If that fails from all
first guesses and with fewer strips too, strips count as not shifted along the rail. If that fails as well, the contact
as it is before the last step stands for it: u = d in all strips, edges and factors roughly. Kik-Piotrowski's contact on
the same rows is what is left if there is none."""

from math import inf

from wrsim.core.contact.strips.changes import FEWEST, begin, in_contact, leave, move_edges
from wrsim.core.contact.strips.equations import (
    EDGE_RATIO,
    EVENNESS,
    LEAST_FACTOR,
    MOST_FACTOR,
    block_of,
    evenness,
    factor_of,
    joint,
    lay_strips,
    residuals,
    set_amplitudes,
)
from wrsim.core.contact.strips.newton import NEAR, descend, newton
from wrsim.core.contact.strips.records import FACTORS, FEWEST_FREE_STRIPS, NEXT, ROWS, SAVED, STEP, X
from wrsim.core.contact.strips.shifts import hertz_ellipse, hump_of, slanted
from wrsim.core.jit.compiling import inlined, kernel

# Of u - d over the deepest penetration, of curvatures over 1/R_x: from the last contact, and afresh
WARM_TOLERANCE, TOLERANCE = 1e-8, 1e-9
ROUGHLY, FAIRLY = 5e-3, 5e-4  # the same with given factors and edges: in turns of the first attempt, and else
WARM_STEPS, HELD_STEPS, COLD_STEPS = 25, 15, 40
SURELY = 0.7  # of the largest penetration: a grid that is in contact to begin with
FEWER = (0, 2, 3, 5)  # strips than asked for: edges on a shoulder may have no place with some numbers
LEVELS = (0.42, 0.15)  # of a grid's depth: where first guesses begin
ROUGH_LEVEL = LEVELS[1]
ROUNDS = 8  # of half lengths, edges and factors in turn
ENTRIES = 3  # times that this begins anew because grids have come into contact
CALM_EDGES, CALM_FACTORS = 0.5, 0.15  # moves in a round, in widths of strips and over themselves, that end the turns
PUSH, FAR = 0.6, 6.0  # ratio of a^2 of the outer strips from which on an edge is moved far out, in mean widths
OVERLAP, MOST_OVER = 1e-3, 2.0  # penetration [m]; a^2 asked for over the largest that it has room for
PUSHES = 3  # first turns in which that is done
SOFT, HARD = 0.8, 2.0  # exponent of the factors' relaxation; largest ratio it acts on
EVEN = 0.01  # weight of evenness in it
FIRMER = 3.0  # power of how much more it counts in slanted contacts: factors would zigzag with the half lengths there
RECESS = 0.45  # of the deepest penetration, in the substitute, as in Kik-Piotrowski
SETTLED, RETRIED, STRAIGHT, ROUGH, UNSOLVED = range(5)
"""How a solution was found: at once, from another first guess or with fewer strips, as if no strip were shifted along
the rail, with edges and factors only roughly; or not."""


@kernel
def solve(system, n, known, whole):
    """Solve; known: the unknowns are those of a contact near by. Returns one of SETTLED to UNSOLVED.

    whole: else there are other grids to try before strips count as not shifted, and there is no substitute.
    ``memo.strips`` says with how many strips a grid.
    """
    memo = system.memo[0]
    memo.iterations = memo.factorisations = 0
    memo.strips = n
    for g in range(memo.grids):
        system.grids[g].reaches = 0
    if known and newton(system, n, WARM_TOLERANCE, WARM_STEPS) and _sound(system, n):
        return SETTLED
    result = SETTLED
    for attempt in range(2):
        for fewer in FEWER:
            if n - fewer < FEWEST_FREE_STRIPS and fewer > 0:
                break
            memo.strips = n - fewer
            for level in LEVELS:
                held = ROUGHLY if result == SETTLED else FAIRLY
                if _afresh(system, memo.strips, level, True, held) and _sound(system, memo.strips):
                    return result if attempt == 0 else STRAIGHT
                result = RETRIED
        if not memo.shifted or not whole:
            break
        memo.shifted = 0
    memo.strips = n
    if not whole:
        return UNSOLVED
    return ROUGH if _afresh(system, n, ROUGH_LEVEL, False, FAIRLY) and _sound(system, n) else UNSOLVED


@kernel
def _sound(system, n):
    """Whether all unknowns are numbers, and in an overlap some strip is in contact and none asks for a half length far
    beyond its own: there Newton's method may end in what is no contact, with a hundred times the force or none."""
    memo, x, block = system.memo[0], system.vectors[X], block_of(n)
    touches = memo.deepest < OVERLAP
    for g in range(memo.grids):
        for j in range(block if system.grids[g].on else 0):
            if not abs(x[g * block + j]) < inf:
                return False
        for j in range(n if system.grids[g].on and memo.deepest >= OVERLAP else 0):
            place = system.places[g * n + j]
            if place.over > MOST_OVER:
                return False
            touches = touches or place.y > 0.0
    return touches


@kernel
def _guess(system, n, g, level):
    """A grid's contact where its penetration is more than a level of its depth: Hertz's ellipse."""
    grid, rows = system.grids[g], system.rows[g]
    x = system.vectors[X]
    base = g * block_of(n)
    depth = grid.deepest
    main = 0
    first, last = ROWS - 1, 0
    for r in range(ROWS):
        d = rows[r].d
        if d >= depth:
            main = r
        if d > level * depth:
            first, last = min(first, r), max(last, r)
    bend = rows[main].bend
    start = max(rows[first].s - 0.5 * grid.spacing, grid.least)
    end = min(rows[last].s + 0.5 * grid.spacing, grid.most)
    begin(system, n, g, start, end, depth, bend)
    grid.start_held, grid.end_held = int(start <= grid.least), int(end >= grid.most)
    ratio, slope = slanted(hump_of(grid, rows, depth))
    ellipse = hertz_ellipse(ratio, slope, depth, bend)
    # of the depth: where the ellipse ends, and its half length
    edge = 1.0 - ellipse.half_width**2 * ratio * bend / (2.0 * depth)
    most = ellipse.half_length**2 * bend / (2.0 * depth)
    x[base + n : base + n + FACTORS] = min(max(ellipse.factor, LEAST_FACTOR), MOST_FACTOR)
    lay_strips(system, n)
    for j in range(n):
        place = system.places[g * n + j]
        share = max((place.d / depth - edge) / (1.0 - edge), 0.02)
        x[base + j] = 2.0 * most * depth / place.bend * share


@kernel
def _afresh(system, n, level, whole, held):
    """Solve from Hertz's ellipses. whole: for edges and factors as well; held: tolerance of turns in which these are
    given. True if that works."""
    memo = system.memo[0]
    memo.inverted = 0
    for g in range(memo.grids):
        system.grids[g].on = system.grids[g].reaches = 0
        base = g * block_of(n)
        system.vectors[X, base : base + block_of(n)] = 0.0
    for g in range(memo.grids):
        if system.grids[g].tail == 0 and system.grids[g].deepest >= SURELY * memo.deepest:
            _guess(system, n, g, level)
    for _ in range(ENTRIES):
        before = _grids_on(system)
        _take_turns(system, n, held)
        fairly = descend(system, n, True, FAIRLY, HELD_STEPS)
        if _grids_on(system) <= before:
            break
        # edges and factors of those that have come are first guesses, too
    if not whole:
        return fairly
    return descend(system, n, False, NEAR, COLD_STEPS) and newton(system, n, TOLERANCE, WARM_STEPS)


@inlined
def _grids_on(system):
    """How many grids are in contact."""
    count = 0
    for g in range(system.memo[0].grids):
        count += system.grids[g].on
    return count


@kernel
def _take_turns(system, n, held):
    """Half lengths, edges and factors in turns, until they are calm; held: tolerance of the half lengths."""
    memo = system.memo[0]
    for turn in range(ROUNDS):
        descend(system, n, True, held, HELD_STEPS)
        moved = 0.0
        for g in range(memo.grids):
            if system.grids[g].on and system.grids[g].tail == 0:
                moved = max(moved, _draw_edges(system, n, g, turn))
        residuals(system, n, False)
        changed = 0.0
        for g in range(memo.grids):
            if system.grids[g].on and system.grids[g].tail == 0:
                changed = max(changed, _relax_factors(system, n, g))
        for g in range(memo.grids):
            grid, own = system.grids[g], g * block_of(n) + n
            if grid.on and grid.tail != 0:
                system.vectors[X, own : own + FACTORS] = system.vectors[X, joint(g, grid, n)]
        if turn > 0 and moved < CALM_EDGES and changed < CALM_FACTORS:
            break


@kernel
def _draw_edges(system, n, g, turn):
    """Move the edges of a grid to where its outer strips ask for them. Returns by how many mean widths of strips.

    Near an edge a^2 is in proportion to the distance from it, so that the ratio of the outer strips' tells where it is.
    """
    x, base = system.vectors[X], g * block_of(n)
    grid, places = system.grids[g], system.places[g * n : (g + 1) * n]
    first, last, count = in_contact(x[base : base + n])
    if count < FEWEST:
        leave(system, n, g)
        return 0.0
    if first > 0 or last < n - 1:
        move_edges(system, n, g, places[first].lo, places[last].hi)
    mean = (grid.end - grid.start) / n
    ends = grid.start, grid.end
    for side in range(2):
        outer, inner = (0, 1) if side == 0 else (n - 1, n - 2)
        w0, w1 = places[outer].hi - places[outer].lo, places[inner].hi - places[inner].lo
        ratio = min(x[base + outer] / max(x[base + inner], 1e-30) / EDGE_RATIO, 0.7)
        out = (ratio * (w0 + 0.5 * w1) - 0.5 * w0) / (1.0 - ratio)
        if first > 0 if side == 0 else last < n - 1:
            # strips have just left
            out = min(out, 0.5 * mean)
        elif ratio > PUSH and turn < PUSHES:
            # drawn far too narrow; what is too much leaves again
            out = max(out, FAR * mean)
        ends = (max(ends[0] - out, grid.least), ends[1]) if side == 0 else (ends[0], min(ends[1] + out, grid.most))
    moved = (abs(ends[0] - grid.start) + abs(ends[1] - grid.end)) / mean
    move_edges(system, n, g, ends[0], ends[1])
    return moved


@kernel
def _relax_factors(system, n, g):
    """Bring the factors of a grid nearer to what the misfits of the curvatures ask for. Returns the largest change.

    The curvature under the strips is about in proportion to the factors there; nodes without force follow the others.
    """
    x, base = system.vectors[X], g * block_of(n) + n
    load, wish = system.vectors[STEP], system.vectors[SAVED]
    load[:FACTORS] = 0.0
    wish[:FACTORS] = 0.0
    for j in range(g * n, (g + 1) * n):
        place = system.places[j]
        if place.y > 0.0:
            f, r = factor_of(place)
            load[f] += (1.0 - r) * place.weight
            load[f + 1] += r * place.weight
            wish[f] += (1.0 - r) * place.weight * (place.miss + 1.0)
            wish[f + 1] += r * place.weight * (place.miss + 1.0)
    even = EVEN * (evenness(system.memo[0], system.grids[g]) / EVENNESS) ** FIRMER
    # (load + even * bend) ratio = wish: three diagonals
    above = system.vectors[NEXT]
    for f in range(FACTORS):
        ends = 1.0 if f == 0 or f == FACTORS - 1 else 2.0
        diagonal = load[f] + even * ends + 1e-9
        if f > 0:
            diagonal += even * above[f - 1]
            wish[f] += even * wish[f - 1]
        above[f] = -even / diagonal
        wish[f] /= diagonal
    for f in range(FACTORS - 2, -1, -1):
        wish[f] -= above[f] * wish[f + 1]
    largest = 0.0
    for f in range(FACTORS):
        ratio = min(max(wish[f], 1.0 / HARD), HARD)
        k = min(max(x[base + f] / ratio**SOFT, LEAST_FACTOR), MOST_FACTOR)
        largest = max(largest, abs(k / x[base + f] - 1.0))
        x[base + f] = k
    return largest


@kernel
def substitute(system, n):
    """Kik-Piotrowski's contact on the same rows: half lengths from the penetration beyond RECESS of the deepest one,
    one amplitude for all, so that on average the surfaces follow each other."""
    memo, x = system.memo[0], system.vectors[X]
    memo.inverted = 0
    level = RECESS * memo.deepest
    for g in range(memo.grids):
        grid, rows, base = system.grids[g], system.rows[g], g * block_of(n)
        x[base : base + block_of(n)] = 0.0
        grid.on = int(grid.deepest > level)
        if not grid.on:
            continue
        first, last = ROWS - 1, 0
        for r in range(ROWS):
            if rows[r].d > level:
                first, last = min(first, r), max(last, r)
        start, end = rows[first].s, rows[last].s
        if first > 0:
            start -= grid.spacing * (rows[first].d - level) / (rows[first].d - rows[first - 1].d)
        if last < ROWS - 1:
            end += grid.spacing * (rows[last].d - level) / (rows[last].d - rows[last + 1].d)
        x[base + n : base + n + FACTORS] = 1.0
        x[base + n + FACTORS], x[base + n + FACTORS + 1] = start, end
    lay_strips(system, n)
    for g in range(memo.grids):
        for j in range(n if system.grids[g].on else 0):
            place = system.places[g * n + j]
            x[g * block_of(n) + j] = 2.0 * max(place.d - level, 0.0) / place.bend
    residuals(system, n, True)
    penetration = displacement = 0.0
    for g in range(memo.grids):
        for j in range(n if system.grids[g].on else 0):
            place = system.places[g * n + j]
            weight = place.y * (place.hi - place.lo)
            penetration += weight * place.d
            displacement += weight * (place.gap * memo.deepest + place.d)
    for g in range(memo.grids):
        base = g * block_of(n) + n
        x[base : base + FACTORS] = min(max(penetration / max(displacement, 1e-30), LEAST_FACTOR), MOST_FACTOR)
    set_amplitudes(system, n)
