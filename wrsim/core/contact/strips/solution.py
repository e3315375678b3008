"""First guesses, and what is done until the strip model has a solution.

In a run the last contact is the first guess. Else: Hertz's half lengths where the penetration is large; Newton's method
with given factors and edges, then with all unknowns. Where that fails the wheel is lifted until it works and lowered
in steps; where that fails neighbouring lobes share a grid (`model`); where that fails too there is a substitute:
Kik-Piotrowski's contact on the same rows.
"""

from math import log

from wrsim.core.compiling import kernel
from wrsim.core.contact.strips.equations import block_of, factor_of, lay_strips, residuals, set_amplitudes
from wrsim.core.contact.strips.newton import FEWEST, begin, hertz_factor, in_contact, leave, move_edges, newton
from wrsim.core.contact.strips.records import FACTORS, KEPT, ROWS, SAVED, STEP, STEPS, X

# Of u - d over the deepest penetration, of curvatures over 1/R_x: from the last contact, and afresh
WARM_TOLERANCE, TOLERANCE = 1e-8, 1e-9
FAIRLY = 3e-3  # the same with given factors and edges
WARM_STEPS, COLD_STEPS = 25, 60
SURELY = 0.7  # of the largest penetration: a grid that is in contact to begin with
LEVELS = (0.42, 0.3, 0.55)  # of a grid's depth: where first guesses begin
LIFTS = (0.7, 0.5, 0.85)  # of the deepest penetration
MOST_WALKS = 40
RECESS = 0.45  # of the deepest penetration, in the substitute, as in Kik-Piotrowski
SETTLED, WALKED, MERGED_ALL, UNSOLVED = range(4)
"""How a solution was found: at once, by lifting the wheel, on one grid for all lobes that hang together; or not."""


@kernel
def solve(system, n, known):
    """Solve; known: the unknowns are those of a contact near by. Returns SETTLED, WALKED or UNSOLVED."""
    memo = system.memo[0]
    memo.iterations = memo.factorisations = 0
    memo.offset = 0.0
    if known and newton(system, n, False, False, WARM_TOLERANCE, WARM_STEPS):
        return SETTLED
    for level in LEVELS:
        if _afresh(system, n, level):
            return SETTLED
    for lift in LIFTS:
        if walk(system, n, lift):
            return WALKED
    return UNSOLVED


@kernel
def _guess(system, n, g, level):
    """A grid's contact where its penetration is more than a level of its depth: Hertz's ellipse."""
    memo, grid, rows = system.memo[0], system.grids[g], system.rows[g]
    x = system.vectors[X]
    base = g * block_of(n)
    depth = max(grid.deepest - memo.offset, 1e-3 * grid.deepest)
    wide = main = 0
    first, last = ROWS - 1, 0
    for r in range(ROWS):
        d = rows[r].d - memo.offset
        wide += 1 if d > 0.5 * depth else 0
        if rows[r].d >= grid.deepest:
            main = r
        if d > level * depth:
            first, last = min(first, r), max(last, r)
    bend = rows[main].bend
    start = max(rows[first].s - 0.5 * grid.spacing, grid.least)
    end = min(rows[last].s + 0.5 * grid.spacing, grid.most)
    begin(system, n, g, start, end, depth, bend)
    grid.start_held, grid.end_held = int(start <= grid.least), int(end >= grid.most)
    ratio = depth / (bend * (0.5 * max(wide, 1) * grid.spacing) ** 2)
    x[base + n : base + n + FACTORS] = hertz_factor(ratio)
    # where Hertz's ellipse ends, and its half length
    edge = min(max(1.0 - 0.5 * ratio**-0.168, 0.2), 0.8)
    most = min(max(0.5 + 0.055 * log(ratio), 0.3), 0.8)
    lay_strips(system, n)
    for j in range(n):
        place = system.places[g * n + j]
        share = max((place.d / depth - edge) / (1.0 - edge), 0.02)
        x[base + j] = 2.0 * most * depth / place.bend * share


@kernel
def _afresh(system, n, level):
    """Solve from Hertz's ellipses. True if that works."""
    memo = system.memo[0]
    memo.factored = 0
    for g in range(memo.grids):
        system.grids[g].on = 0
        base = g * block_of(n)
        system.vectors[X, base : base + block_of(n)] = 0.0
    for g in range(memo.grids):
        if system.grids[g].deepest >= SURELY * memo.deepest:
            _guess(system, n, g, level)
    newton(system, n, True, True, FAIRLY, 15)
    for g in range(memo.grids):
        if system.grids[g].on:
            _fit_edges(system, n, g)
    return newton(system, n, False, True, TOLERANCE, COLD_STEPS)


@kernel
def _fit_edges(system, n, g):
    """Edges at the outer strips in contact."""
    x, base = system.vectors[X], g * block_of(n)
    first, last, count = in_contact(x[base : base + n])
    if count < FEWEST:
        leave(system, n, g)
    elif first > 0 or last < n - 1:
        places = system.places[g * n : (g + 1) * n]
        move_edges(system, n, g, places[first].lo, places[last].hi)


@kernel
def walk(system, n, lift):
    """Solve with the wheel lifted by a share of the deepest penetration, then lower it. True if that works."""
    memo = system.memo[0]
    offset = memo.offset = lift * memo.deepest
    good = False
    for level in LEVELS:
        good = good or _afresh(system, n, level)
    step = 0.25 * offset
    for _ in range(MOST_WALKS):
        if not good or offset <= 0.0:
            break
        keep(system, n)
        memo.offset = max(offset - step, 0.0)
        if newton(system, n, False, True, TOLERANCE, WARM_STEPS):
            offset = memo.offset
            step *= 1.5
        else:
            restore(system, n)
            memo.factored = 0
            step *= 0.4
            if step < 1e-4 * memo.deepest:
                break
    memo.offset = 0.0
    return good and offset <= 0.0


@kernel
def keep(system, n):
    """Keep the unknowns and the state of the grids."""
    kept, size = system.vectors[KEPT], system.memo[0].grids * block_of(n)
    for i in range(size):
        kept[i] = system.vectors[X, i]
    for g in range(system.memo[0].grids):
        grid = system.grids[g]
        kept[size + 3 * g], kept[size + 3 * g + 1], kept[size + 3 * g + 2] = grid.on, grid.start_held, grid.end_held


@kernel
def restore(system, n):
    """Put back what ``keep`` kept."""
    kept, size = system.vectors[KEPT], system.memo[0].grids * block_of(n)
    for i in range(size):
        system.vectors[X, i] = kept[i]
    for g in range(system.memo[0].grids):
        grid = system.grids[g]
        grid.on, grid.start_held = int(kept[size + 3 * g]), int(kept[size + 3 * g + 1])
        grid.end_held = int(kept[size + 3 * g + 2])


@kernel
def substitute(system, n):
    """Kik-Piotrowski's contact on the same rows: half lengths from the penetration beyond RECESS of the deepest one,
    one amplitude for all, so that on average the surfaces follow each other."""
    memo, x = system.memo[0], system.vectors[X]
    memo.factored = 0
    memo.offset = 0.0
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
        x[base : base + FACTORS] = penetration / displacement
    set_amplitudes(system, n)


@kernel
def carry_over(system, n):
    """Unknowns of the grids by their places on the rail, from the last call's of other grids. Returns whether any is in
    contact.

    Places, unknowns and state of the grids still are those of the last call, their bounds new.
    """
    memo, x, grids = system.memo[0], system.vectors[X], system.grids
    block = block_of(n)
    old_s, old_y, old_k, old_w = (system.vectors[SAVED], system.vectors[STEP], system.vectors[STEPS],
                                  system.vectors[STEPS + 1])  # fmt: skip
    count = 0
    for g in range(memo.known):
        for j in range(n):
            place = system.places[g * n + j]
            y = x[g * block + j]
            if grids[g].on and y > 0.0:
                f, r = factor_of(place)
                old_s[count], old_y[count], old_w[count] = place.s, y, place.hi - place.lo
                old_k[count] = (1.0 - r) * x[g * block + n + f] + r * x[g * block + n + f + 1]
                count += 1
    found = False
    for g in range(memo.grids):
        grid, base = grids[g], g * block
        x[base : base + block] = 0.0
        grid.on = grid.start_held = grid.end_held = 0
        first = last = -1
        for i in range(count):
            if grid.least < old_s[i] < grid.most:
                first = i if first < 0 else first
                last = i
        if first < 0 or last - first + 1 < FEWEST:
            continue
        found = True
        start = max(old_s[first] - 0.5 * old_w[first], grid.least)
        end = min(old_s[last] + 0.5 * old_w[last], grid.most)
        grid.on, grid.start_held, grid.end_held = 1, int(start <= grid.least), int(end >= grid.most)
        x[base + n + FACTORS], x[base + n + FACTORS + 1] = start, end
        for f in range(FACTORS):
            s = start + (f + 0.5) / FACTORS * (end - start)
            i = _before(old_s, count, s)
            x[base + n + f] = _between(old_s, old_k, count, i, s)
    lay_strips(system, n)
    for g in range(memo.grids):
        for j in range(n if grids[g].on else 0):
            s = system.places[g * n + j].s
            i = _before(old_s, count, s)
            apart = old_s[min(i + 1, count - 1)] - old_s[i] > 0.75 * (old_w[i] + old_w[min(i + 1, count - 1)])
            x[g * block + j] = 0.0 if apart else _between(old_s, old_y, count, i, s)
    return found


@kernel
def _before(places, count, s):
    """Number of the last place but one that is not beyond s."""
    i = 0
    while i < count - 2 and places[i + 1] < s:
        i += 1
    return i


@kernel
def _between(places, values, count, i, s):
    """Value at s between places i and i + 1."""
    if count < 2:
        return values[0]
    r = min(max((s - places[i]) / max(places[i + 1] - places[i], 1e-12), 0.0), 1.0)
    return (1.0 - r) * values[i] + r * values[i + 1]
