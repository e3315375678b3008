"""Newton's method for all unknowns of the strip model at once, with an inverse of the Jacobian that is kept.

The inverse serves from call to call as long as it brings the misfit down; Broyden's updates of rank one keep it young.
What changes the equations (strips that leave and enter, edges that come to their bounds and go) needs a new one.
"""

from math import sqrt

from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.strips.equations import (
    block_of,
    edge_wish,
    jacobian,
    lay_strips,
    pressed,
    residuals,
    set_amplitudes,
)
from wrsim.core.contact.strips.records import (
    FACTORS,
    NEXT,
    PIVOT,
    ROWS,
    SAVED,
    SCALE,
    STEP,
    F,
    X,
)
from wrsim.core.dense import factorise, invert, multiply, solve_factorised

SLOW = 0.3  # misfit over the last one that asks for a new inverse
LEAST_RATE = 0.03  # of what a step leaves of the misfit, when the next one is foretold
KEPT_RATE = 0.95  # of the slowest of the last steps, when the next one is faster
LEAST_REST = 0.2  # of a step that has to be left of it along itself for the inverse to learn from it
LEAST_FACTOR, MOST_FACTOR = 0.3, 20.0
OVERSHOOT, KEPT = -0.5, 0.1  # of a^2 after a step, over itself: below the first the strip leaves; what it keeps else
LARGEST_GROWTH = 0.5  # of a^2 in a step, over the largest of its grid
LARGEST_CHANGE = 0.5  # of a factor in a step, over itself
FARTHEST = 1.5  # move of an edge in a step, in mean widths of strips
ENTRY = 1e-6  # closing of a gap at which a strip enters, over the deepest penetration
FEWEST = 3  # strips in contact below which a grid leaves
RETURN, LEAVE = 1e-3, 4e-4  # closing at which a grid comes into contact; a^2/R_x at which it leaves; over the deepest
REACH = 0.01  # closing at which edges move out over a gap, as well: a hump so flat bears some .001 of the load
HUMP = 0.45  # closing, over its largest, up to which the contact of a new grid reaches at first
TURNS = 12  # changes of strips and edges in one solution
HALVINGS = 6  # of a step, at most
CALM = 0.05  # misfit below which strips may leave
NEAR = 1e-3  # misfit at which strips and edges are looked after
SURE = 2.0  # safety of the foretold misfit


@kernel
def newton(system, n, tolerance, most):
    """Solve for all unknowns from near a solution, with a kept inverse. Returns True if the misfit has come below the
    tolerance. n: strips of a grid; most: steps.
    """
    memo, vectors = system.memo[0], system.vectors
    size = memo.grids * block_of(n)
    _set_scale(system, n)
    turns = 0
    last = 1e9
    looked = whole = False  # whole: the last step was one by the kept inverse, of full length
    misfit = residuals(system, n, False)
    for _ in range(most):
        if misfit < NEAR and not looked:
            looked = True
            turns += 1
            if turns <= TURNS and _changes(system, n, False):
                looked = whole = False
                memo.inverted = 0
                last = 1e9
                misfit = residuals(system, n, False)
                continue
        if misfit < tolerance:
            return True
        if memo.inverted == 0 or misfit > SLOW * last:
            jacobian(system, n, False)
            invert(system.matrix, size, vectors[PIVOT])
            memo.factorisations += 1
            memo.inverted = 1
            memo.rate = 1.0
            whole = False
            last = 1e9
        _multiply_into(system, size, NEXT)
        again = whole
        if again:
            _learn(system, size)
        vectors[STEP, :size] = vectors[NEXT, :size]
        foretold = misfit * max(memo.rate, misfit / last if again else 0.0)
        share = _longest_step(system, n)
        changed, whole = _advance(system, n, False, share, misfit < CALM)
        if looked and whole and SURE * foretold < tolerance:
            lay_strips(system, n)
            set_amplitudes(system, n)
            return True
        last = misfit
        misfit = residuals(system, n, False)
        if changed:
            memo.inverted = 0
            looked = False
        if not whole:
            last = 1e9
        elif again:
            # first steps of calls go where the ones before went, and say nothing of others
            memo.rate = max(
                min(misfit / last, 1.0), KEPT_RATE * memo.rate if memo.rate < 1.0 else LEAST_RATE, LEAST_RATE
            )
    return False


@kernel
def descend(system, n, held, tolerance, most):
    """Newton's method from far: new factors and a damped step each time. Returns as ``newton``.

    held: factors and edges stay as they are. A step is halved until the next one by the same factors is shorter: a test
    that does not depend on how the equations are scaled (Deuflhard, Newton Methods for Nonlinear Problems, 2004,
    section 3.3).
    """
    memo, vectors = system.memo[0], system.vectors
    size = memo.grids * block_of(n)
    _set_scale(system, n)
    memo.inverted = turns = 0
    looked = False
    misfit = residuals(system, n, held)
    for _ in range(most):
        if misfit < NEAR and not looked:
            looked = True
            turns += 1
            if turns <= TURNS and _changes(system, n, held):
                looked = False
                misfit = residuals(system, n, held)
                continue
        if misfit < tolerance:
            return True
        jacobian(system, n, held)
        factorise(system.matrix, size, vectors[PIVOT])
        memo.factorisations += 1
        _solve_into(system, size, STEP)
        vectors[SAVED, :size] = vectors[X, :size]
        length = _norm(vectors, STEP, size)
        share = 1.0 if held else _longest_step(system, n)
        for halving in range(HALVINGS + 1):
            changed, _whole = _advance(system, n, held, share, misfit < CALM)
            after = residuals(system, n, held)
            if changed:
                looked = False
                break
            _solve_into(system, size, NEXT)
            if halving == HALVINGS or _norm(vectors, NEXT, size) <= (1.0 - 0.25 * share) * length:
                break
            share *= 0.5
            vectors[X, :size] = vectors[SAVED, :size]
        misfit = after
    return False


@inlined
def _multiply_into(system, size, row):
    """A step by the inverse as it is, from the misfits."""
    step = system.vectors[row]
    multiply(system.matrix, size, system.vectors[F], step)
    for i in range(size):
        step[i] = -step[i]


@inlined
def _solve_into(system, size, row):
    """A step by the factors as they are, from the misfits."""
    step = system.vectors[row]
    for i in range(size):
        step[i] = -system.vectors[F, i]
    solve_factorised(system.matrix, size, system.vectors[PIVOT], step)


@inlined
def _norm(vectors, row, size):
    """Length of a step by the weights of the unknowns."""
    total = 0.0
    for i in range(size):
        total += vectors[SCALE, i] * vectors[row, i] ** 2
    return sqrt(total)


@kernel
def _set_scale(system, n):
    """Weights of the unknowns in products of steps."""
    scale = system.vectors[SCALE]
    block = block_of(n)
    for g in range(system.memo[0].grids):
        grid, base = system.grids[g], g * block
        middle = system.rows[g, ROWS // 2]
        scale[base : base + n] = (0.5 * middle.bend / grid.deepest) ** 2
        scale[base + n : base + n + FACTORS] = 1.0
        scale[base + n + FACTORS : base + block] = 1.0 / (grid.most - grid.least) ** 2


@kernel
def _learn(system, size):
    """Broyden's update of the inverse, and of the next step by it, from what the last step was short of: the change of
    the misfits comes to be mapped to the step that made it (Kelley, Solving Nonlinear Equations with Newton's Method,
    2003, section 4.1)."""
    inverse, vectors = system.matrix, system.vectors
    step, missing, scale, row = vectors[STEP], vectors[NEXT], vectors[SCALE], vectors[SAVED]
    square = product = 0.0
    for i in range(size):
        weighted = step[i] * scale[i]
        square += weighted * step[i]
        product += weighted * missing[i]
    rest = square - product
    if rest < LEAST_REST * square:
        return
    row[:size] = 0.0
    for i in range(size):
        weighted = step[i] * scale[i]
        for j in range(size):
            row[j] += weighted * inverse[i, j]
    for i in range(size):
        part = missing[i] / rest
        for j in range(size):
            inverse[i, j] += part * row[j]
        missing[i] *= square / rest


@kernel
def _longest_step(system, n):
    """Share of the step at which no unknown changes too much: 1.0 or less."""
    x, step = system.vectors[X], system.vectors[STEP]
    block = block_of(n)
    worst = 1.0
    for g in range(system.memo[0].grids):
        grid, base = system.grids[g], g * block
        if not grid.on:
            continue
        highest = 0.0
        for j in range(base, base + n):
            highest = max(highest, x[j])
        for j in range(base, base + n):
            if x[j] > 0.0:
                worst = max(worst, step[j] / (LARGEST_GROWTH * highest))
        for f in range(base + n, base + n + FACTORS):
            worst = max(worst, abs(step[f]) / (LARGEST_CHANGE * x[f]))
        for e in range(base + n + FACTORS, base + block):
            worst = max(worst, n * abs(step[e]) / (FARTHEST * (grid.end - grid.start)))
    return 1.0 / worst


@kernel
def _advance(system, n, held, share, calm):
    """Take a share of the step; calm: strips may leave. Returns whether strips, edges or grids have come or gone, and
    whether it was the whole step in all unknowns."""
    memo = system.memo[0]
    x, step = system.vectors[X], system.vectors[STEP]
    block = block_of(n)
    changed = False
    whole = share == 1.0
    for g in range(memo.grids):
        grid, base = system.grids[g], g * block
        if not grid.on:
            continue
        for j in range(n):
            y = x[base + j]
            if y <= 0.0:
                place = system.places[g * n + j]
                if held and place.gap < -ENTRY:
                    x[base + j] = -place.gap * memo.deepest / place.bend
                    changed = True
                continue
            new = y + share * step[base + j]
            if held:
                new = max(new, 0.0)
                changed = changed or new == 0.0
            elif new < KEPT * y:
                leaves = calm and new < OVERSHOOT * y
                changed = changed or leaves
                whole = False
                new = 0.0 if leaves else KEPT * y
            x[base + j] = new
        if held:
            continue
        for f in range(base + n, base + n + FACTORS):
            k = x[f] + share * step[f]
            x[f] = min(max(k, LEAST_FACTOR), MOST_FACTOR)
            whole = whole and x[f] == k
        e = base + n + FACTORS
        x[e] += share * step[e]
        x[e + 1] += share * step[e + 1]
        if x[e] < grid.least:
            x[e] = grid.least
            changed = changed or not grid.start_held
            grid.start_held = 1
        if x[e + 1] > grid.most:
            x[e + 1] = grid.most
            changed = changed or not grid.end_held
            grid.end_held = 1
        if x[e + 1] - x[e] < 1e-4 * (grid.most - grid.least):
            leave(system, n, g)
            changed = True
        elif trim(system, n, g):
            changed = True
    return changed, whole and not changed


@kernel
def leave(system, n, g):
    """Take a grid out of contact."""
    base = g * block_of(n)
    system.grids[g].on = 0
    system.vectors[X, base : base + n] = 0.0


@kernel
def in_contact(squares):
    """First and last strip in contact, -1 where there is none, and how many there are; squares: a^2 of a grid's."""
    first = last = -1
    count = 0
    for j in range(squares.shape[0]):
        if squares[j] > 0.0:
            first = j if first < 0 else first
            last = j
            count += 1
    return first, last, count


@kernel
def trim(system, n, g):
    """Draw the edges of a grid in to its outer strips in contact. True if anything changed.

    With fewer than FEWEST strips, or hardly pressed ones, the grid leaves.
    """
    memo, grid, places = system.memo[0], system.grids[g], system.places[g * n : (g + 1) * n]
    base = g * block_of(n)
    x = system.vectors[X]
    first, last, count = in_contact(x[base : base + n])
    highest = 0.0
    for j in range(n):
        highest = max(highest, x[base + j] * places[j].bend)
    if count < FEWEST or highest < LEAVE * memo.deepest:
        leave(system, n, g)
        return True
    if first == 0 and last == n - 1:
        return False
    start = places[first].lo if first > 0 else grid.start
    end = places[last].hi if last < n - 1 else grid.end
    move_edges(system, n, g, start, end)
    return True


@kernel
def move_edges(system, n, g, start, end):
    """New edges for a grid; half lengths stay where they are, ground that is new has none."""
    grid, places = system.grids[g], system.places[g * n : (g + 1) * n]
    base = g * block_of(n)
    x, saved = system.vectors[X], system.vectors[STEP]
    for j in range(n):
        places[j].gap = places[j].s
        saved[j] = x[base + j]
    grid.start_held, grid.end_held = int(start <= grid.least), int(end >= grid.most)
    x[base + n + FACTORS], x[base + n + FACTORS + 1] = max(start, grid.least), min(end, grid.most)
    lay_strips(system, n)
    for j in range(n):
        s = places[j].s
        c = 0
        while c < n - 2 and places[c + 1].gap < s:
            c += 1
        r = min(max((s - places[c].gap) / (places[c + 1].gap - places[c].gap), 0.0), 1.0)
        y = saved[c] * (1.0 - r) + saved[c + 1] * r
        # outside of the old strips
        if s < places[0].gap or s > places[n - 1].gap:
            y *= 0.5
        x[base + j] = y


@kernel
def _changes(system, n, held):
    """Strips, edges and grids that come into contact, edges that leave their bounds. True if there are any."""
    memo, places = system.memo[0], system.places
    x = system.vectors[X]
    block = block_of(n)
    changed = False
    for g in range(memo.grids):
        grid, base = system.grids[g], g * block
        if not grid.on:
            changed = _enter(system, n, g) or changed
            continue
        for j in range(n):
            place = places[g * n + j]
            if x[base + j] <= 0.0 and place.gap < -ENTRY:
                x[base + j] = -place.gap * memo.deepest / place.bend
                if 0 < j < n - 1:
                    x[base + j] = max(x[base + j], 0.5 * min(x[base + j - 1], x[base + j + 1]))
                changed = True
        if held:
            continue
        changed = _reach_out(system, n, g) or changed
        if grid.start_held and edge_wish(places, g * n, n, 0) < 0.0:
            grid.start_held = 0
            changed = True
        if grid.end_held and edge_wish(places, g * n, n, 1) < 0.0:
            grid.end_held = 0
            changed = True
    return changed


@inlined
def _closing(system, n, g, r):
    """How far the bodies would overlap at a row, over what all strips press them down there [m]."""
    row = system.rows[g, r]
    u, _c = pressed(system, n, g, row.s)
    return row.d - u / system.memo[0].stiffness


@kernel
def _enter(system, n, g):
    """A grid out of contact comes into it where its gap has closed. True if it does."""
    memo, grid, rows = system.memo[0], system.grids[g], system.rows[g]
    most = RETURN * memo.deepest
    main = -1
    for r in range(0, ROWS, 2):
        rows[r].closing = _closing(system, n, g, r) if rows[r].d > most else -1.0
        if rows[r].closing > most:
            most, main = rows[r].closing, r
    if main < 0:
        return False
    first = last = main
    while first - 2 >= 0 and rows[first - 2].closing > HUMP * most:
        first -= 2
    while last + 2 < ROWS and rows[last + 2].closing > HUMP * most:
        last += 2
    start = max(rows[first].s - 0.6 * grid.spacing, grid.least)
    end = min(rows[last].s + 0.6 * grid.spacing, grid.most)
    begin(system, n, g, start, end, most, rows[main].bend)
    return True


@inlined
def _may_close(rows, r, step, rise):
    """Whether a gap beside the contact may close again by so much from row r on: no more than the penetration bends up
    there, for what the strips press down bends up everywhere beside them."""
    slope = risen = 0.0
    while 0 < r < ROWS - 1:
        slope += max(rows[r - 1].d + rows[r + 1].d - 2.0 * rows[r].d, 0.0)
        risen += slope
        if risen > rise:
            return True
        r += step
    return False


@kernel
def _reach_out(system, n, g):
    """Edges of a grid move out over a gap to where it has closed again beyond. True if one does."""
    memo, grid, rows = system.memo[0], system.grids[g], system.rows[g]
    least = REACH * memo.deepest
    start, end = grid.start, grid.end
    for side in range(2):
        step = -1 if side == 0 else 1
        r = int(((start if side == 0 else end) - grid.least) / grid.spacing) + (0 if side == 0 else 1)
        if not _may_close(rows, r, step, 0.5 * least):
            continue
        apart = beyond = False
        # displacements at the last two rows that were asked; it bends up, so beyond it is more than in line with them
        u = slope = 0.0
        asked = -1
        while 0 <= r < ROWS:
            closing = -1.0
            if rows[r].d > least and (slope == 0.0 or rows[r].d > u + slope * abs(r - asked)):
                last = u
                u = rows[r].d - _closing(system, n, g, r)
                slope = (u - last) / abs(r - asked) if asked >= 0 else 0.0
                asked = r
                closing = rows[r].d - u
            if closing < 0.0:
                apart = True
                if beyond:
                    break
            elif apart and closing > least:
                beyond = True
                if side == 0:
                    start = max(rows[r].s - 0.6 * grid.spacing, grid.least)
                else:
                    end = min(rows[r].s + 0.6 * grid.spacing, grid.most)
            r += step
    if start == grid.start and end == grid.end:
        return False
    before = grid.start, grid.end
    move_edges(system, n, g, start, end)
    for j in range(n):
        s = system.places[g * n + j].s
        if s < before[0] or s > before[1]:
            system.vectors[X, g * block_of(n) + j] = 0.0
    return True


@inlined
def hertz_factor(ratio):
    """Roughly k of Hertz's ellipse, by the ratio of the curvatures across and along."""
    return min(1.0 + 0.27 * ratio**0.63, 12.0)


@kernel
def begin(system, n, g, start, end, depth, bend):
    """First guess of a grid: a hump of this depth between these edges. bend: 1/R_x [1/m]."""
    grid, x = system.grids[g], system.vectors[X]
    base = g * block_of(n)
    grid.on = 1
    grid.start_held = grid.end_held = 0
    factor = hertz_factor(depth / (bend * (0.5 * (end - start)) ** 2))
    for j in range(n):
        z = 2.0 * (j + 0.5) / n - 1.0
        x[base + j] = depth / bend * (1.0 - z * z)
    x[base + n : base + n + FACTORS] = factor
    x[base + n + FACTORS], x[base + n + FACTORS + 1] = start, end
