"""The derivatives of the strip model's equations by all unknowns, see `contact.strips.equations`."""

from math import sqrt

from wrsim.contact.strips.equations import (
    EDGE_RATIO,
    EVENNESS,
    REACH,
    THIRD,
    block_of,
    fading,
    four_touch,
    points_of,
    weight_of,
)
from wrsim.contact.strips.influence import facing, find_terms
from wrsim.contact.strips.records import EDGES, MIDDLES, OF_A_POINT, OF_A_STRIP, V
from wrsim.jit.compiling import inlined, kernel


@inlined
def _point(system, n, g, i, h, point, x):
    """The terms of the strips of grid h at a point x of strip i of grid g."""
    v, t = system.vectors, V.TERMS + OF_A_POINT * point
    aligned = point == 0 and h == g and not system.memo[0].shifted
    first, last, s = h * n, (h + 1) * n, system.places[g * n + i].s
    find_terms(system.table, v, first, last, s, x, aligned, v[t], v[t + 1], v[t + 2], v[t + 3], v[t + 4])


@kernel
def _press_row(system, n, g, i):
    """Derivatives of the displacements at all points of strip i of grid g, through the strips, to ``matrix``; those of
    the third condition to ``vectors[V.WISH]``."""
    memo, places, vectors, m = system.memo[0], system.places, system.vectors, system.matrix
    third = vectors[V.WISH]
    block = block_of(n)
    unit = 1.0 / (memo.stiffness * memo.deepest)
    at = places[g * n + i]
    row, e = g * block + i, g * block + OF_A_STRIP * n
    middle, r = vectors[V.MIDDLE, g * n + i], REACH * at.root
    points = points_of(memo)
    no, nb = vectors[V.NO, g * n + i], vectors[V.NB, g * n + i]
    for point in range(points):
        arm = r if point == 1 else -r if point == 2 else 0.0
        x = middle + arm
        # its shares of the three equations
        level = 1.0 if point == 0 else 0.0
        bow = 1.0 if point == 0 else -0.5 if points == 3 else -1.0
        turn = 0.0 if point == 0 or points == 2 else 1.0 if point == 1 else -1.0
        t = V.TERMS + OF_A_POINT * point
        p, p_xi, lever, f0, f1 = vectors[t], vectors[t + 1], vectors[t + 2], vectors[t + 3], vectors[t + 4]
        by_x = by_s = 0.0
        for h in range(memo.grids):
            part = unit * fading(system, h, g)
            if part == 0.0:
                continue
            _point(system, n, g, i, h, point, x)
            base = h * block
            by_start = by_end = by_place = by_lean = 0.0
            for j in range(h * n, (h + 1) * n):
                place = places[j]
                if place.y <= 0.0:
                    continue
                column = base + j - h * n
                share = part * facing(vectors, j, no, nb, at.s)
                q, a = share * place.q, place.root
                xi = (x - vectors[V.MIDDLE, j]) / a
                by_y = q * (p[j] - 0.5 * (xi * p_xi[j] + lever[j]))
                by_k = share * place.half * place.y * p[j]
                shift = q * a * p_xi[j]
                lo, hi = q * a * f0[j], q * a * f1[j]
                by_x += shift
                by_s += lo - hi
                by_middle = q * place.y * p[j] * place.lean - (shift * place.x_s if memo.shifted else 0.0)
                by_start += hi * place.hi_start - lo * place.lo_start + by_middle * place.mid_start
                by_end += hi * place.hi_end - lo * place.lo_end + by_middle * place.mid_end
                m[row, column] += level * by_y
                m[row, column + n] += level * by_k
                m[row + n, column] += bow * by_y
                m[row + n, column + n] += bow * by_k
                third[column] += turn * by_y
                third[column + n] += turn * by_k
                by_place -= shift
                by_lean -= shift * place.z
            of_grid = by_start, by_end, by_place, by_lean
            _add(m, third, row, n, base + OF_A_STRIP * n, level, bow, turn, of_grid)
        # the point moves with the strip's own middle, half length and place
        own_y = by_x * arm / (2.0 * at.y)
        m[row + n, row] += bow * own_y
        third[row] += turn * own_y
        along = by_s + (by_x * at.x_s if points == 3 else 0.0)
        own = along * at.mid_start, along * at.mid_end, by_x, by_x * at.z
        _add(m, third, row, n, e, level, bow, turn, own)


@inlined
def _add(m, third, row, n, e, level, bow, turn, own):
    """Add what a displacement does by the unknowns of a grid behind those of its strips to the conditions of one."""
    for k in range(EDGES + MIDDLES):
        m[row, e + k] += level * own[k]
        m[row + n, e + k] += bow * own[k]
        third[e + k] += turn * own[k]


@kernel
def _own_row(system, n, g, i):
    """Derivatives of the geometry at strip i of grid g, to ``matrix`` and ``vectors[V.WISH]``."""
    m, third, at = system.matrix, system.vectors[V.WISH], system.places[g * n + i]
    row, e = g * block_of(n) + i, g * block_of(n) + OF_A_STRIP * n
    r, off, unit = REACH * at.root, at.off, 1.0 / system.memo[0].deepest
    # u - d + off^2/(2 R);  -r^2/(2 R);  2 r off/R
    m[row + n, row] -= 0.5 * at.bend * REACH * REACH * unit
    third[row] += at.bend * REACH * off / at.root * unit
    first, second, last = -at.d_s + 0.5 * at.bend_s * off * off, -0.5 * at.bend_s * r * r, 2.0 * at.bend_s * r * off
    _add(m, third, row, n, e, first * unit, second * unit, last * unit, (at.mid_start, at.mid_end, 0.0, 0.0))
    by_off = 0.0, 0.0, 1.0, at.z
    _add(m, third, row, n, e, at.bend * off * unit, 0.0, 2.0 * at.bend * r * unit, by_off)


@kernel
def _add_to_middles(system, n, g, i):
    """The share of strip i of grid g in the conditions of the middles. Its weight counts as fixed: with
    its derivatives Newton's method fails more often."""
    memo, grid, at, third = system.memo[0], system.grids[g], system.places[g * n + i], system.vectors[V.WISH]
    first, share = g * block_of(n) + OF_A_STRIP * n + EDGES, weight_of(at) / grid.weight
    for j in range(memo.grids * block_of(n)):
        part = share * third[j]
        for k in range(MIDDLES):
            system.matrix[first + k, j] += part
            part *= at.z


@kernel
def jacobian(system, n):
    """Derivatives of the equations by the unknowns that are solved for, to ``matrix``, for the state of the last
    ``residuals``; the numbers of these unknowns to ``vectors[V.SOLVED]``, how many there are to the memo.

    Edges that are held and grids that are not on stay as they are; of strips out of contact factors are solved
    for, so that they come to be what they have when they touch.
    """
    memo, places, grids = system.memo[0], system.places, system.grids
    m = system.matrix
    block = block_of(n)
    size = memo.grids * block
    m[:size, :size] = 0.0
    for g in range(memo.grids):
        for j in range(n if grids[g].on else 0):
            place = places[g * n + j]
            place.root = sqrt(place.y)
            place.half = 0.5 * memo.modulus * place.bend
            place.lean = place.bend_s / place.bend
            place.mid_start = 0.5 * (place.lo_start + place.hi_start)
            place.mid_end = 0.5 * (place.lo_end + place.hi_end)
    for g in range(memo.grids):
        for i in range(n if grids[g].on else 0):
            if places[g * n + i].y <= 0.0:
                continue
            system.vectors[V.WISH, :size] = 0.0
            _press_row(system, n, g, i)
            _own_row(system, n, g, i)
            if memo.shifted:
                _add_to_middles(system, n, g, i)
        if grids[g].on:
            _even_rows(system, n, g)
            _edge_rows(system, n, g)
    _gather(system, n)


@kernel
def _even_rows(system, n, g):
    """What holds neighbouring strips alike."""
    m, base = system.matrix, g * block_of(n)
    for j in range(1, n):
        r = base + n + j
        m[r, r] += EVENNESS
        m[r, r - 1] -= EVENNESS
        m[r - 1, r - 1] += EVENNESS
        m[r - 1, r] -= EVENNESS
    places, grid = system.places, system.grids[g]
    for j in range(1, n - 2 if system.memo[0].shifted else 1):
        if four_touch(places, g * n + j - 1):
            weight, r = grid.stairs * places[g * n + j].bend / system.memo[0].deepest, base + j - 1
            for p in range(4):
                for q in range(4):
                    m[r + p, r + q] += weight * THIRD[p] * THIRD[q]


@kernel
def _edge_rows(system, n, g):
    """Derivatives of the edges' residuals."""
    places, m, base = system.places, system.matrix, g * block_of(n)
    for side in range(EDGES):
        r = base + OF_A_STRIP * n + side
        outer, inner = (0, 1) if side == 0 else (n - 1, n - 2)
        one, two = places[g * n + outer], places[g * n + inner]
        ratio = one.q * one.q * one.y / max(two.q * two.q * two.y, 1e-30)
        m[r, base + outer] = ratio / max(one.y, 1e-30)
        m[r, base + inner] = -ratio / max(two.y, 1e-30)
        m[r, base + n + outer] = 2.0 * ratio / one.k
        m[r, base + n + inner] = -2.0 * ratio / two.k
        by_start = 2.0 * ratio * (one.lean * one.mid_start - two.lean * two.mid_start)
        by_end = 2.0 * ratio * (one.lean * one.mid_end - two.lean * two.mid_end)
        w0, w1 = one.hi - one.lo, two.hi - two.lo
        rate = -EDGE_RATIO / (2.0 * w0 + w1) ** 2
        m[r, base + OF_A_STRIP * n] = by_start + rate * (
            (one.hi_start - one.lo_start) * w1 - (two.hi_start - two.lo_start) * w0
        )
        m[r, base + OF_A_STRIP * n + 1] = by_end + rate * (
            (one.hi_end - one.lo_end) * w1 - (two.hi_end - two.lo_end) * w0
        )


@kernel
def _gather(system, n):
    """Bring what is solved for to the first rows and columns of ``matrix``."""
    memo, grids, m, solved = system.memo[0], system.grids, system.matrix, system.vectors[V.SOLVED]
    size = 0
    for g in range(memo.grids):
        grid, base = grids[g], g * block_of(n)
        for kind in range(OF_A_STRIP):
            for j in range(n if grid.on else 0):
                if kind > 0 or system.places[g * n + j].y > 0.0:
                    solved[size] = base + kind * n + j
                    size += 1
        for side in range(EDGES if grid.on else 0):
            if not (grid.start_held if side == 0 else grid.end_held):
                solved[size] = base + OF_A_STRIP * n + side
                size += 1
        for k in range(MIDDLES if memo.shifted and grid.on else 0):
            solved[size] = base + OF_A_STRIP * n + EDGES + k
            size += 1
    memo.unknowns = size
    for i in range(size):
        row = int(solved[i])
        for j in range(size):
            m[i, j] = m[row, int(solved[j])]
