"""Newton's method for all unknowns of the strip model at once, with an inverse of the Jacobian that is kept.

A contact that follows another one starts from the step that the change of the overlap asks for (an Euler predictor:
Allgower and Georg, Numerical Continuation Methods, 1990, chapter 2).

The inverse serves from call to call as long as it brings the residual down; updates of rank one by Broyden keep it
accurate. What changes the equations (strips that leave and enter, edges that come to their bounds and go) needs a new
one.
"""

from math import sqrt

from wrsim.contact.strips.changes import activate, deactivate_grid, trim_edges
from wrsim.contact.strips.derivatives import jacobian
from wrsim.contact.strips.equations import (
    CHEBYSHEV_NODE,
    block_of,
    clamp_edges,
    edge_residual,
    edges_of,
    place_strips,
    residual_price,
    residuals,
    set_middles,
)
from wrsim.contact.strips.records import EDGES, MIDDLES, ROWS, System, V
from wrsim.jit import inlined, kernel
from wrsim.jit.dense import copy, factorise, invert, multiply, solve_factorised

MAX_STEPS = 25  # of a solution: those that come to one take fewer
REFRESH_RATIO = 0.3  # residual over the last one that asks for a new inverse
MIN_RATE = 0.03  # of what a step leaves of the residual, when the next one is predicted
KEPT_RATE = 0.95  # of the slowest of the last steps, when the next one is faster
DROP_OVERSHOOT = -0.5  # a^2 after a step, over itself, below which the strip leaves
MIN_KEPT_RATIO = 0.1  # of a^2 that a strip keeps else
MAX_RELATIVE_STEP = 0.5  # growth of a^2 in a step over the largest of its grid, change of a factor over itself
MAX_EDGE_STEP = 1.5  # move of an edge in a step, in mean widths of strips
MAX_HALVINGS = 3  # of a step
DROP_RESIDUAL = 0.05  # residual below which strips may leave, and an inverse is kept
DROP_SIZE = 1e-4  # a^2/R_x over the deepest penetration below which they may at any residual: it may be theirs
CHECK_RESIDUAL = 1e-3  # residual at which the active set is checked
PREDICTION_SAFETY = 2.0  # of the predicted residual
NO_RESIDUAL = 1e9  # residual of a last step that says nothing of the next
JACOBIAN_PRICE = 4.0  # of one with its inverse, in residuals of the same contact, for each grid


@kernel
def newton(system: System, n: int, tolerance: float) -> bool:
    """Solve for all unknowns from near a solution, with a kept inverse. Returns True if the residual has come below the
    tolerance. n: strips of a grid.
    """
    memo, vectors = system.memo[0], system.vectors
    _set_scale(system, n)
    last = NO_RESIDUAL
    active_set_checked = full_step = False  # full_step: the last step was one by the kept inverse, of full length
    if memo.inverted:
        _predict(system, n)
    if not affords(system, n, 0):
        memo.left = 1.0
        return False
    residual = residuals(system, n)
    for _ in range(MAX_STEPS):
        if residual < CHECK_RESIDUAL and not active_set_checked:
            active_set_checked = True
            if activate(system, n):
                active_set_checked = full_step = False
                memo.inverted = 0
                last = NO_RESIDUAL
                if not affords(system, n, 0):
                    memo.left = 1.0
                    return False
                residual = residuals(system, n)
                continue
        if residual < tolerance:
            return True
        renewed = memo.inverted == 0 or residual > REFRESH_RATIO * last
        if not affords(system, n, int(renewed)):
            memo.left = residual
            return False
        if renewed:
            jacobian(system, n)
            invert(system.matrix, memo.unknowns, vectors[V.PIVOT])
            _count_jacobian(system, n)
            memo.inverted = 1
            memo.rate = 1.0
            full_step = False
            last = NO_RESIDUAL
        _multiply_inverse(system)
        previous_full = full_step
        if previous_full:
            _broyden_update(system)
        copy(memo.unknowns, vectors[V.NEXT], vectors[V.LAST_STEP])
        _expand_step(system, n)
        predicted = residual * max(memo.rate, residual / last if previous_full else 0.0)
        changed, full_step = _take_step(system, n, _longest_step(system, n), residual < DROP_RESIDUAL)
        if active_set_checked and full_step and PREDICTION_SAFETY * predicted < tolerance:
            place_strips(system, n)
            return True
        last = residual
        residual = residuals(system, n)
        if changed:
            memo.inverted = 0
            active_set_checked = False
        if not full_step:
            last = NO_RESIDUAL if residual < last else last  # where it grows, the inverse is too old
        elif previous_full:
            # first steps of calls go where the ones before went, and say nothing of others
            memo.rate = max(min(residual / last, 1.0), KEPT_RATE * memo.rate if memo.rate < 1.0 else MIN_RATE, MIN_RATE)
    return False


@kernel
def _predict(system: System, n: int) -> None:
    """Take the step that the change of penetrations and curvatures since the last contact asks for, as if strips
    pressed the surfaces down as they did: the displacements were the gaps then."""
    memo, places, f, before = system.memo[0], system.places, system.vectors[V.F], system.vectors[V.BEFORE]
    block = block_of(n)
    for g in range(memo.grids):
        for j in range(n if system.grids[g].active else 0):
            place = places[g * n + j]
            before[g * block + j], before[g * block + n + j] = place.d, place.curvature
    place_strips(system, n)
    for g in range(memo.grids):
        grid, base = system.grids[g], g * block
        if not grid.active:
            continue
        for j in range(n):
            place = places[g * n + j]
            change = (place.curvature - before[base + n + j]) / memo.deepest if place.y > 0.0 else 0.0
            r = CHEBYSHEV_NODE * sqrt(place.y)
            f[base + j] = (before[base + j] - place.d) / memo.deepest if place.y > 0.0 else 0.0
            f[base + j] += 0.5 * change * place.off * place.off
            f[base + n + j] = -0.5 * change * r * r
            place.tilt = 2.0 * change * r * place.off
        for side in range(EDGES):
            f[edges_of(n, g) + side] = edge_residual(places, g * n, n, side)
        if memo.has_shifts:
            set_middles(system, n, g)
    _multiply_inverse(system)
    _expand_step(system, n)
    if _longest_step(system, n) < 1.0:
        return
    changed, _full_step = _take_step(system, n, 1.0, False)
    if changed:
        memo.inverted = 0


@kernel
def descend(system: System, n: int, tolerance: float) -> bool:
    """Newton's method from far: new factors and a damped step each time. Returns as ``newton``.

    A step is halved until the next one by the same factors is shorter: a test that does not depend on how the equations
    are scaled (Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 3.3).
    """
    memo, vectors = system.memo[0], system.vectors
    size = memo.grids * block_of(n)
    _set_scale(system, n)
    memo.inverted = 0
    active_set_checked = False
    if not affords(system, n, 0):
        memo.left = 1.0
        return False
    residual = residuals(system, n)
    for _ in range(MAX_STEPS):
        if residual < CHECK_RESIDUAL and not active_set_checked:
            active_set_checked = True
            if activate(system, n):
                active_set_checked = False
                if not affords(system, n, 0):
                    memo.left = 1.0
                    return False
                residual = residuals(system, n)
                continue
        if residual < tolerance:
            return True
        if not affords(system, n, 1):
            memo.left = residual
            return False
        jacobian(system, n)
        factorise(system.matrix, memo.unknowns, vectors[V.PIVOT])
        _count_jacobian(system, n)
        length = _solve(system)
        _expand_step(system, n)
        copy(size, vectors[V.X], vectors[V.SAVED])
        share = _longest_step(system, n)
        for halving in range(MAX_HALVINGS + 1):
            changed, _full_step = _take_step(system, n, share, residual < DROP_RESIDUAL)
            after = residuals(system, n)
            if changed:
                active_set_checked = False
                break
            if _solve(system) <= (1.0 - 0.25 * share) * length:
                break
            if halving == MAX_HALVINGS:
                return False
            if not affords(system, n, 0):
                memo.left = after
                return False
            share *= 0.5
            copy(size, vectors[V.SAVED], vectors[V.X])
        residual = after
    return False


@inlined
def affords(system: System, n: int, jacobians: int) -> bool:
    """Whether the budget has room for so many Jacobians, that leave what they must, and a residual behind them."""
    memo = system.memo[0]
    price = residual_price(system, n) + jacobians * (jacobian_price(system, n) + memo.spare)
    return memo.work + price <= memo.budget


@inlined
def jacobian_price(system: System, n: int) -> float:
    """What a Jacobian with its inverse takes: the inverse grows with the cube of the grids in contact."""
    grids = 0
    for g in range(system.memo[0].grids):
        grids += system.grids[g].active
    return JACOBIAN_PRICE * grids * residual_price(system, n)


@inlined
def _count_jacobian(system: System, n: int) -> None:
    """Take a Jacobian into what this call has done."""
    system.memo[0].factorisations += 1
    system.memo[0].work += jacobian_price(system, n)


@kernel
def _multiply_inverse(system: System) -> None:
    """The step of the unknowns that are solved for by the inverse as it is, from the residuals."""
    vectors, size = system.vectors, system.memo[0].unknowns
    for i in range(size):
        vectors[V.RHS, i] = -vectors[V.F, int(vectors[V.UNKNOWN_INDEX, i])]
    multiply(system.matrix, size, vectors[V.RHS], vectors[V.NEXT])


@kernel
def _solve(system: System) -> float:
    """The same by the factors as they are; returns its length by the weights of the unknowns."""
    vectors, size = system.vectors, system.memo[0].unknowns
    step = vectors[V.NEXT]
    for i in range(size):
        step[i] = -vectors[V.F, int(vectors[V.UNKNOWN_INDEX, i])]
    solve_factorised(system.matrix, size, vectors[V.PIVOT], step)
    total = 0.0
    for i in range(size):
        total += vectors[V.SCALE, int(vectors[V.UNKNOWN_INDEX, i])] * step[i] ** 2
    return sqrt(total)


@kernel
def _expand_step(system: System, n: int) -> None:
    """The step of all unknowns: zero where they are not solved for."""
    memo, vectors = system.memo[0], system.vectors
    vectors[V.STEP, : memo.grids * block_of(n)] = 0.0
    for i in range(memo.unknowns):
        vectors[V.STEP, int(vectors[V.UNKNOWN_INDEX, i])] = vectors[V.NEXT, i]


@kernel
def _set_scale(system: System, n: int) -> None:
    """Weights of the unknowns in products of steps."""
    scale = system.vectors[V.SCALE]
    block = block_of(n)
    for g in range(system.memo[0].grids):
        grid, base, e = system.grids[g], g * block, edges_of(n, g)
        middle = system.rows[g, ROWS // 2]
        scale[base : base + n] = (0.5 * middle.curvature / grid.deepest) ** 2
        scale[base + n : base + 2 * n] = 1.0
        scale[e : e + EDGES] = 1.0 / (grid.most - grid.least) ** 2
        scale[e + EDGES : base + block] = 0.5 * middle.curvature / grid.deepest * n


@kernel
def _broyden_update(system: System) -> None:
    """Broyden's update (strip-broyden) of the inverse, and of the next step by it."""
    inverse, vectors, size = system.matrix, system.vectors, system.memo[0].unknowns
    step, following = vectors[V.LAST_STEP], vectors[V.NEXT]
    weighted, product = vectors[V.WEIGHTED], vectors[V.PRODUCT]
    square = mixed = 0.0
    for i in range(size):
        entry = weighted[i] = step[i] * vectors[V.SCALE, int(vectors[V.UNKNOWN_INDEX, i])]
        square += entry * step[i]
        mixed += entry * following[i]
    rest = square - mixed
    if rest <= 0.0:
        return
    product[:size] = 0.0
    for i in range(size):
        entry = weighted[i]
        for j in range(size):
            product[j] += entry * inverse[i, j]
    for i in range(size):
        share = following[i] / rest
        for j in range(size):
            inverse[i, j] += share * product[j]
        following[i] *= square / rest


@kernel
def _longest_step(system: System, n: int) -> float:
    """Share of the step at which no unknown changes too much: 1.0 or less."""
    x, step = system.vectors[V.X], system.vectors[V.STEP]
    worst = 1.0
    for g in range(system.memo[0].grids):
        grid, base, e = system.grids[g], g * block_of(n), edges_of(n, g)
        if not grid.active:
            continue
        highest = 0.0
        for j in range(base, base + n):
            highest = max(highest, x[j])
        for j in range(base, base + n):
            if x[j] > 0.0:
                worst = max(worst, step[j] / (MAX_RELATIVE_STEP * highest))
                worst = max(worst, abs(step[j + n]) / (MAX_RELATIVE_STEP * x[j + n]))
        for k in range(MIDDLES):
            worst = max(worst, abs(step[e + EDGES + k]) / (MAX_RELATIVE_STEP * sqrt(highest)))
        for side in range(EDGES):
            worst = max(worst, n * abs(step[e + side]) / (MAX_EDGE_STEP * (grid.end - grid.start)))
    return 1.0 / worst


@kernel
def _take_step(system: System, n: int, share: float, may_drop: bool) -> tuple[bool, bool]:
    """Take a share of the step; may_drop: strips may leave. Returns whether strips, edges or grids have come or gone,
    and whether it was the full step in all unknowns."""
    memo = system.memo[0]
    x, step = system.vectors[V.X], system.vectors[V.STEP]
    changed = False
    full = share == 1.0
    for g in range(memo.grids):
        grid, base, e = system.grids[g], g * block_of(n), edges_of(n, g)
        if not grid.active:
            continue
        for j in range(n):
            y = x[base + j]
            x[base + n + j] += share * step[base + n + j]
            if y <= 0.0:
                continue
            new = y + share * step[base + j]
            if new < MIN_KEPT_RATIO * y:
                small = y * system.places[g * n + j].curvature < DROP_SIZE * memo.deepest
                leaves = new < DROP_OVERSHOOT * y and (may_drop or small)
                changed = changed or leaves
                full = False
                new = 0.0 if leaves else MIN_KEPT_RATIO * y
            x[base + j] = new
        for k in range(EDGES + MIDDLES):
            x[e + k] += share * step[e + k]
        if clamp_edges(grid, x, e):
            changed = True
        if x[e + 1] <= x[e]:
            deactivate_grid(system, n, g)
            changed = True
        elif trim_edges(system, n, g):
            changed = True
    return changed, full and not changed
