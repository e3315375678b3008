"""Newton's method for all unknowns of the strip model at once, with an inverse of the Jacobian that is kept.

A contact that follows another one starts from the step that the moved ground asks for (an Euler predictor: Allgower and
Georg, Numerical Continuation Methods, 1990, chapter 2).

The inverse serves from call to call as long as it brings the residual down; updates of rank one by Broyden keep it
young.
What changes the equations (strips that leave and enter, edges that come to their bounds and go) needs a new one.
"""

from math import sqrt

from wrsim.contact.strips.changes import enter, leave, trim
from wrsim.contact.strips.derivatives import jacobian
from wrsim.contact.strips.equations import (
    REACH,
    block_of,
    edge_wish,
    lay_strips,
    residuals,
    set_middles,
)
from wrsim.contact.strips.records import EDGES, MIDDLES, OF_A_STRIP, ROWS, V
from wrsim.jit.compiling import kernel
from wrsim.jit.dense import copy, factorise, invert, multiply, solve_factorised

STEPS = 25  # of a solution, at most: those that come to one take fewer
SLOW = 0.3  # residual over the last one that asks for a new inverse
LEAST_RATE = 0.03  # of what a step leaves of the residual, when the next one is predicted
KEPT_RATE = 0.95  # of the slowest of the last steps, when the next one is faster
OVERSHOOT, KEPT = -0.5, 0.1  # of a^2 after a step, over itself: below the first the strip leaves; what it keeps else
LARGEST = 0.5  # growth of a^2 in a step over the largest of its grid, change of a factor over itself
FARTHEST = 1.5  # move of an edge in a step, in mean widths of strips
HALVINGS = 3  # of a step, at most
CALM = 0.05  # residual below which strips may leave
SPENT = 1e-4  # a^2/R_x over the deepest penetration below which they may at any residual: it may be theirs
NEAR = 1e-3  # residual at which strips and edges are looked after
SURE = 2.0  # safety of the predicted residual


@kernel
def newton(system, n, tolerance):
    """Solve for all unknowns from near a solution, with a kept inverse. Returns True if the residual has come below the
    tolerance. n: strips of a grid.
    """
    memo, vectors = system.memo[0], system.vectors
    size = memo.grids * block_of(n)
    _set_scale(system, n)
    last = 1e9
    looked = whole = False  # whole: the last step was one by the kept inverse, of full length
    if memo.inverted:
        _predict(system, n)
    residual = residuals(system, n)
    for _ in range(STEPS):
        if residual < NEAR and not looked:
            looked = True
            if enter(system, n):
                looked = whole = False
                memo.inverted = 0
                last = 1e9
                residual = residuals(system, n)
                continue
        if residual < tolerance:
            return True
        if memo.inverted == 0 or residual > SLOW * last:
            jacobian(system, n)
            invert(system.matrix, memo.unknowns, vectors[V.PIVOT])
            memo.factorisations += 1
            memo.inverted = 1
            memo.rate = 1.0
            whole = False
            last = 1e9
        _multiply_inverse(system)
        again = whole
        if again:
            _learn(system)
        copy(memo.unknowns, vectors[V.NEXT], vectors[V.LAST])
        _scatter(system, size)
        predicted = residual * max(memo.rate, residual / last if again else 0.0)
        share = _longest_step(system, n)
        changed, whole = _advance(system, n, share, residual < CALM)
        if looked and whole and SURE * predicted < tolerance:
            lay_strips(system, n)
            return True
        last = residual
        residual = residuals(system, n)
        if changed:
            memo.inverted = 0
            looked = False
        if not whole:
            last = 1e9 if residual < last else last  # where it grows, the inverse is too old
        elif again:
            # first steps of calls go where the ones before went, and say nothing of others
            memo.rate = max(
                min(residual / last, 1.0), KEPT_RATE * memo.rate if memo.rate < 1.0 else LEAST_RATE, LEAST_RATE
            )
    return False


@kernel
def _predict(system, n):
    """Take the step that the ground asks for which has moved since the last contact, as if strips pressed it down as
    they did: the displacements were the gaps then."""
    memo, places, vectors = system.memo[0], system.places, system.vectors
    f, block = vectors[V.F], block_of(n)
    for g in range(memo.grids):
        for j in range(n if system.grids[g].on else 0):
            place = places[g * n + j]
            f[g * block + j], f[g * block + n + j] = place.d, place.bend
    lay_strips(system, n)
    for g in range(memo.grids):
        grid, base = system.grids[g], g * block
        if not grid.on:
            continue
        for j in range(n):
            place = places[g * n + j]
            bend = (place.bend - f[base + n + j]) / memo.deepest if place.y > 0.0 else 0.0
            r = REACH * sqrt(place.y)
            f[base + j] = (f[base + j] - place.d) / memo.deepest if place.y > 0.0 else 0.0
            f[base + j] += 0.5 * bend * place.off * place.off
            f[base + n + j] = -0.5 * bend * r * r
            place.turn = 2.0 * bend * r * place.off
        for side in range(EDGES):
            f[base + OF_A_STRIP * n + side] = edge_wish(places, g * n, n, side)
        if memo.shifted:
            set_middles(system, n, g)
    _multiply_inverse(system)
    _scatter(system, memo.grids * block)
    if _longest_step(system, n) < 1.0:
        return
    changed, _whole = _advance(system, n, 1.0, False)
    if changed:
        memo.inverted = 0


@kernel
def descend(system, n, tolerance):
    """Newton's method from far: new factors and a damped step each time. Returns as ``newton``.

    A step is halved until the next one by the same factors is shorter: a test
    that does not depend on how the equations are scaled (Deuflhard, Newton Methods for Nonlinear Problems, 2004,
    section 3.3).
    """
    memo, vectors = system.memo[0], system.vectors
    size = memo.grids * block_of(n)
    _set_scale(system, n)
    memo.inverted = 0
    looked = False
    residual = residuals(system, n)
    for _ in range(STEPS):
        if residual < NEAR and not looked:
            looked = True
            if enter(system, n):
                looked = False
                residual = residuals(system, n)
                continue
        if residual < tolerance:
            return True
        jacobian(system, n)
        factorise(system.matrix, memo.unknowns, vectors[V.PIVOT])
        memo.factorisations += 1
        length = _solve(system)
        _scatter(system, size)
        copy(size, vectors[V.X], vectors[V.SAVED])
        share = _longest_step(system, n)
        for halving in range(HALVINGS + 1):
            changed, _whole = _advance(system, n, share, residual < CALM)
            after = residuals(system, n)
            if changed:
                looked = False
                break
            if _solve(system) <= (1.0 - 0.25 * share) * length:
                break
            if halving == HALVINGS:
                return False
            share *= 0.5
            copy(size, vectors[V.SAVED], vectors[V.X])
        residual = after
    return False


@kernel
def _multiply_inverse(system):
    """The step of the unknowns that are solved for by the inverse as it is, from the residuals."""
    vectors, size = system.vectors, system.memo[0].unknowns
    wish = vectors[V.WISH]
    for i in range(size):
        wish[i] = -vectors[V.F, int(vectors[V.SOLVED, i])]
    multiply(system.matrix, size, wish, vectors[V.NEXT])


@kernel
def _solve(system):
    """The same by the factors as they are; returns its length by the weights of the unknowns."""
    vectors, size = system.vectors, system.memo[0].unknowns
    step = vectors[V.NEXT]
    for i in range(size):
        step[i] = -vectors[V.F, int(vectors[V.SOLVED, i])]
    solve_factorised(system.matrix, size, vectors[V.PIVOT], step)
    total = 0.0
    for i in range(size):
        total += vectors[V.SCALE, int(vectors[V.SOLVED, i])] * step[i] ** 2
    return sqrt(total)


@kernel
def _scatter(system, size):
    """The step of all unknowns."""
    vectors = system.vectors
    vectors[V.STEP, :size] = 0.0
    for i in range(system.memo[0].unknowns):
        vectors[V.STEP, int(vectors[V.SOLVED, i])] = vectors[V.NEXT, i]


@kernel
def _set_scale(system, n):
    """Weights of the unknowns in products of steps."""
    scale = system.vectors[V.SCALE]
    block = block_of(n)
    for g in range(system.memo[0].grids):
        grid, base = system.grids[g], g * block
        middle = system.rows[g, ROWS // 2]
        scale[base : base + n] = (0.5 * middle.bend / grid.deepest) ** 2
        scale[base + n : base + 2 * n] = 1.0
        e = base + OF_A_STRIP * n
        scale[e : e + EDGES] = 1.0 / (grid.most - grid.least) ** 2
        scale[e + EDGES : base + block] = 0.5 * middle.bend / grid.deepest * n


@kernel
def _learn(system):
    """Broyden's update of the inverse, and of the next step by it, from what the last step was short of: the change of
    the residuals comes to be mapped to the step that made it (Kelley, Solving Nonlinear Equations with Newton's Method,
    2003, section 4.1)."""
    inverse, vectors, size = system.matrix, system.vectors, system.memo[0].unknowns
    step, missing, weighed, row = vectors[V.LAST], vectors[V.NEXT], vectors[V.WISH], vectors[V.SAVED]
    square = product = 0.0
    for i in range(size):
        weighted = weighed[i] = step[i] * vectors[V.SCALE, int(vectors[V.SOLVED, i])]
        square += weighted * step[i]
        product += weighted * missing[i]
    rest = square - product
    if rest <= 0.0:
        return
    row[:size] = 0.0
    for i in range(size):
        weighted = weighed[i]
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
    x, step = system.vectors[V.X], system.vectors[V.STEP]
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
                worst = max(worst, step[j] / (LARGEST * highest))
                worst = max(worst, abs(step[j + n]) / (LARGEST * x[j + n]))
        e = base + OF_A_STRIP * n
        for k in range(MIDDLES):
            worst = max(worst, abs(step[e + EDGES + k]) / (LARGEST * sqrt(highest)))
        for side in range(EDGES):
            worst = max(worst, n * abs(step[e + side]) / (FARTHEST * (grid.end - grid.start)))
    return 1.0 / worst


@kernel
def _advance(system, n, share, calm):
    """Take a share of the step; calm: strips may leave. Returns whether strips, edges or grids have come or gone, and
    whether it was the whole step in all unknowns."""
    memo = system.memo[0]
    x, step = system.vectors[V.X], system.vectors[V.STEP]
    block = block_of(n)
    changed = False
    whole = share == 1.0
    for g in range(memo.grids):
        grid, base = system.grids[g], g * block
        if not grid.on:
            continue
        for j in range(n):
            y = x[base + j]
            x[base + n + j] += share * step[base + n + j]
            if y <= 0.0:
                continue
            new = y + share * step[base + j]
            if new < KEPT * y:
                leaves = new < OVERSHOOT * y and (calm or y * system.places[g * n + j].bend < SPENT * memo.deepest)
                changed = changed or leaves
                whole = False
                new = 0.0 if leaves else KEPT * y
            x[base + j] = new
        e = base + OF_A_STRIP * n
        x[e] += share * step[e]
        x[e + 1] += share * step[e + 1]
        for k in range(MIDDLES):
            x[e + EDGES + k] += share * step[e + EDGES + k]
        if x[e] < grid.least:
            x[e] = grid.least
            changed = changed or not grid.start_held
            grid.start_held = 1
        if x[e + 1] > grid.most:
            x[e + 1] = grid.most
            changed = changed or not grid.end_held
            grid.end_held = 1
        if x[e + 1] <= x[e]:
            leave(system, n, g)
            changed = True
        elif trim(system, n, g):
            changed = True
    return changed, whole and not changed
