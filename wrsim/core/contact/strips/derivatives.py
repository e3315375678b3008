"""The derivatives of the strip model's equations by all unknowns, see `core.contact.strips.equations`."""

from math import sqrt

from wrsim.core.contact.strips.equations import (
    EDGE_RATIO,
    LEAST_DEPTH,
    LEAST_FACTOR,
    THIRD,
    block_of,
    evenness,
    factor_of,
    fading,
    joint,
)
from wrsim.core.contact.strips.influence import (
    find_presses,
    find_terms,
    put_beside,
    put_presses_beside,
)
from wrsim.core.contact.strips.records import (
    FACTORS,
    FROM,
    INVERSE,
    MIDDLE,
    SOLVED,
    TERMS,
    TO,
    F,
    X,
)
from wrsim.core.jit.compiling import inlined, kernel


@kernel
def _calm_rows(grid, places, deepest, matrix):
    """Derivatives of ``_calm`` by a^2; matrix: a grid's own rows and columns."""
    n = places.size
    weight = grid.calm * places[n // 2].bend / deepest
    for j in range(n - 3):
        if min(min(places[j].y, places[j + 1].y), min(places[j + 2].y, places[j + 3].y)) > 0.0:
            for p in range(4):
                for q in range(4):
                    matrix[j + p, j + q] += weight * THIRD[p] * THIRD[q]


@kernel
def _press_held(system, n, g, i):
    """Derivatives of the displacement at strip i of grid g by a^2 of all strips, to ``matrix``."""
    memo, vectors, m = system.memo[0], system.vectors, system.matrix
    u, du = vectors[TERMS], vectors[TERMS + 1]
    unit = 1.0 / (memo.stiffness * memo.deepest)
    at = system.places[g * n + i]
    for h in range(memo.grids):
        part = unit * fading(system, h, g)
        if part == 0.0:
            continue
        column = h * (block_of(n) - n)
        first, last = h * n + system.grids[h].pressing, h * n + system.grids[h].beyond
        begin, end, inverse = vectors[FROM], vectors[TO], vectors[INVERSE]
        find_presses(system.table, begin, end, inverse, first, last, at.s, u, du)
        if memo.shifted:
            put_presses_beside(begin, end, inverse, vectors[MIDDLE], first, last, at.s, at.x + at.off, u, du)
        for j in range(first, last):
            place = system.places[j]
            if place.y > 0.0:
                less = 0.0 if place.over > 1.0 else 0.5 * du[j]
                m[g * block_of(n) + i, column + j] = part * place.q * (u[j] - less) / place.over


@kernel
def _press_row(system, n, g, i):
    """Derivatives of displacement and curvature at strip i of grid g by all unknowns, through the strips, to
    ``matrix``."""
    memo, places, vectors, m = system.memo[0], system.places, system.vectors, system.matrix
    grids = system.grids
    u, c, du, dc = vectors[TERMS], vectors[TERMS + 1], vectors[TERMS + 2], vectors[TERMS + 3]
    f0, f1, g0, g1 = vectors[TERMS + 4], vectors[TERMS + 5], vectors[TERMS + 6], vectors[TERMS + 7]
    t, cx, shifted = vectors[TERMS + 8], vectors[TERMS + 9], memo.shifted
    begin, finish, inverse = vectors[FROM], vectors[TO], vectors[INVERSE]
    block = block_of(n)
    unit = 1.0 / (memo.stiffness * memo.deepest)
    at = places[g * n + i]
    row = g * block + i
    f, r = factor_of(at)
    w = g * block + n + f
    scale = at.weight / (memo.stiffness * at.bend)
    s0, s1 = (1.0 - r) * scale, r * scale
    by_s_u = by_s_c = 0.0
    turn = (1.0 + grids[g].stretch) * at.x_s  # of the place along x
    for h in range(memo.grids):
        part = fading(system, h, g)
        if part == 0.0:
            continue
        base, before = h * block, h * (block - n)
        first, last = h * n + grids[h].pressing, h * n + grids[h].beyond
        find_terms(system.table, begin, finish, inverse, first, last, at.s, u, c, du, dc, f0, f1, g0, g1)
        if shifted:
            put_beside(
                begin, finish, inverse, vectors[MIDDLE], first, last, at.s, at.x + at.off,
                u, c, du, dc, f0, f1, g0, g1, t, cx,
            )  # fmt: skip
        start_u = start_c = end_u = end_c = 0.0
        stretch = 1.0 + grids[h].stretch
        for j in range(first, last):
            place = places[j]
            if place.y <= 0.0:
                continue
            full, bent = place.over > 1.0, place.bent
            # by a^2, or by the amplitude where a^2 is as large as can be
            q = part * place.q
            column = before + j
            m[row, column] = unit * q * (u[j] if full else u[j] - 0.5 * du[j]) / place.over
            by_y = bent * q * (c[j] if full else place.bent_y * c[j] - 0.5 * dc[j]) / (place.y * place.over)
            m[w, column] += s0 * by_y
            m[w + 1, column] += s1 * by_y
            fj, rj = factor_of(place)
            k = base + n + fj
            by_u, by_c = part * unit * place.half * place.y * u[j], bent * part * place.half * c[j]
            m[row, k] += (1.0 - rj) * by_u
            m[row, k + 1] += rj * by_u
            m[w, k] += s0 * (1.0 - rj) * by_c
            m[w, k + 1] += s0 * rj * by_c
            m[w + 1, k] += s1 * (1.0 - rj) * by_c
            m[w + 1, k + 1] += s1 * rj * by_c
            # by the ends of the strip, over pi E*, and by its middle
            qa, qc = q * place.root, q / place.root
            u0, u1, v0, v1 = qa * f0[j], qa * f1[j], bent * qc * g0[j], bent * qc * g1[j]
            mid_u = q * place.y * (u[j] * place.lean - 0.5 * place.growing * du[j])
            mid_c = bent * q * (c[j] * place.lean - place.growing * (c[j] + 0.5 * dc[j]))
            start_u += u1 * place.hi_start - u0 * place.lo_start + mid_u * place.mid_start
            start_c += v1 * place.hi_start - v0 * place.lo_start + mid_c * place.mid_start
            end_u += u1 * place.hi_end - u0 * place.lo_end + mid_u * place.mid_end
            end_c += v1 * place.hi_end - v0 * place.lo_end + mid_c * place.mid_end
            by_s_u += u0 - u1
            by_s_c += v0 - v1
            if not shifted:
                continue
            # by this strip's middle along x against the one here
            x_u, x_c = qa * t[j], bent * qc * cx[j]
            moved = stretch * place.x_s
            start_u -= x_u * moved * place.mid_start
            end_u -= x_u * moved * place.mid_end
            start_c -= x_c * moved * place.mid_start
            end_c -= x_c * moved * place.mid_end
            by_s_u += x_u * turn
            by_s_c += x_c * turn
        e = base + n + FACTORS
        _add_edges(m, row, e, unit * start_u, unit * end_u)
        _add_edges(m, w, e, s0 * start_c, s0 * end_c)
        _add_edges(m, w + 1, e, s1 * start_c, s1 * end_c)
    e = g * block + n + FACTORS
    _add_edges(m, row, e, unit * by_s_u * at.mid_start, unit * by_s_u * at.mid_end)
    _add_edges(m, w, e, s0 * by_s_c * at.mid_start, s0 * by_s_c * at.mid_end)
    _add_edges(m, w + 1, e, s1 * by_s_c * at.mid_start, s1 * by_s_c * at.mid_end)


@inlined
def _add_edges(m, row, e, by_start, by_end):
    """Add derivatives by both edges to a row."""
    m[row, e] += by_start
    m[row, e + 1] += by_end


@kernel
def _own_row(system, n, g, i):
    """Derivatives of the geometry at strip i of grid g, and of its weight in the means of the curvature, to
    ``matrix``."""
    m, at = system.matrix, system.places[g * n + i]
    row = g * block_of(n) + i
    e = g * block_of(n) + n + FACTORS
    f, r = factor_of(at)
    w = g * block_of(n) + n + f
    moment, width, deepest = at.weight * at.miss, at.hi - at.lo, system.memo[0].deepest
    # what lies off the locus is less deep
    slope = at.d_s - at.bend * at.off * system.grids[g].stretch * at.x_s - 0.5 * at.bend_s * at.off * at.off
    _add_edges(m, row, e, -slope * at.mid_start / deepest, -slope * at.mid_end / deepest)
    lean = (moment - at.weight * (at.miss + 1.0)) * at.lean
    start = lean * at.mid_start + moment * (at.hi_start - at.lo_start) / width
    end = lean * at.mid_end + moment * (at.hi_end - at.lo_end) / width
    share = at.half / at.q
    for b in range(2):
        part = 1.0 - r if b == 0 else r
        _add_edges(m, w + b, e, part * start, part * end)
        m[w + b, row] += part * moment / (at.y * at.over)
        m[w + b, w] += part * moment * share * (1.0 - r)
        m[w + b, w + 1] += part * moment * share * r


@kernel
def jacobian(system, n, held):
    """Derivatives of the equations by the unknowns that are solved for, to ``matrix``, for the state of the last
    ``residuals``; the numbers of these unknowns to ``vectors[SOLVED]``, how many there are to the memo.

    Strips out of contact, edges that are held and grids that are not on stay as they are, the factors of tails are
    those at their joints; held: all factors and edges stay.
    """
    memo, places, grids = system.memo[0], system.places, system.grids
    m = system.matrix
    block = block_of(n)
    size = memo.grids * block
    m[:size, :size] = 0.0
    for g in range(memo.grids):
        for j in range(n if grids[g].on else 0):
            place = places[g * n + j]
            if place.y <= 0.0:
                continue
            place.root = sqrt(place.y)
            place.half = 0.5 * memo.modulus * place.bend * place.over
            place.lean = place.bend_s / place.bend
            place.growing = 0.0
            if place.over > 1.0:
                place.growing = place.d_s / max(place.d, LEAST_DEPTH) - place.lean
            place.mid_start = 0.5 * (place.lo_start + place.hi_start)
            place.mid_end = 0.5 * (place.lo_end + place.hi_end)
    for g in range(memo.grids):
        if not grids[g].on:
            continue
        for i in range(n):
            if places[g * n + i].y <= 0.0:
                continue
            if held:
                _press_held(system, n, g, i)
            else:
                _press_row(system, n, g, i)
                _own_row(system, n, g, i)
        if memo.shifted:
            base = g * block
            _calm_rows(grids[g], places[g * n : (g + 1) * n], memo.deepest, m[base : base + n, base : base + n])
    for g in range(memo.grids):
        if grids[g].on and grids[g].tail == 0 and not held:
            _factor_and_edge_rows(system, n, g)
    _gather(system, n, held)


@kernel
def _factor_and_edge_rows(system, n, g):
    """What holds the factors of a grid together, and the derivatives of the edges' misfits."""
    memo, places, grids, m = system.memo[0], system.places, system.grids, system.matrix
    grid, block = grids[g], block_of(n)
    own = g * block + n
    even = evenness(memo, grid)
    for f in range(FACTORS):
        r = own + f
        if f > 0:
            m[r, r] += even
            m[r, r - 1] -= even
        if f < FACTORS - 1:
            m[r, r] += even
            m[r, r + 1] -= even
    if grid.link > 0.0 and grids[grid.linked].on:
        one, other = own + FACTORS - 1, grid.linked * block + n
        m[one, one] += grid.link
        m[one, other] -= grid.link
        m[other, other] += grid.link
        m[other, one] -= grid.link
    for side in range(2):
        r = own + FACTORS + side
        outer, inner = (g * n, g * n + 1) if side == 0 else (g * n + n - 1, g * n + n - 2)
        one, two = places[outer], places[inner]
        y1 = max(two.y * two.over, 1e-30)
        m[r, g * block + outer - g * n] = 1.0 / y1
        m[r, g * block + inner - g * n] = -one.y * one.over / (y1 * y1)
        w0, w1 = one.hi - one.lo, two.hi - two.lo
        rate = -EDGE_RATIO / (2.0 * w0 + w1) ** 2
        by_start = (one.hi_start - one.lo_start) * w1 - (two.hi_start - two.lo_start) * w0
        by_end = (one.hi_end - one.lo_end) * w1 - (two.hi_end - two.lo_end) * w0
        _add_edges(m, r, own + FACTORS, rate * by_start, rate * by_end)


@kernel
def _gather(system, n, held):
    """Bring what is solved for to the first rows and columns of ``matrix``."""
    memo, grids, m, solved = system.memo[0], system.grids, system.matrix, system.vectors[SOLVED]
    block = block_of(n)
    size = 0
    for g in range(memo.grids):
        grid, base = grids[g], g * block
        for j in range(n if grid.on else 0):
            if system.places[g * n + j].y > 0.0:
                solved[size] = base + j
                size += 1
        if not grid.on or grid.tail != 0 or held:
            continue
        for j in range(n, block):
            kept = grid.start_held if j == block - 2 else grid.end_held if j == block - 1 else 0
            if j < n + FACTORS:
                # at its least value, and its equation asks for less (``residuals``)
                kept = system.vectors[X, base + j] <= LEAST_FACTOR and system.vectors[F, base + j] == 0.0
            if not kept:
                solved[size] = base + j
                size += 1
    memo.unknowns = size
    for i in range(size):
        row = int(solved[i])
        for g in range(memo.grids):
            if grids[g].on and grids[g].tail != 0:
                at_joint, own = joint(g, grids[g], n), g * block + n
                for f in range(own, own + FACTORS):
                    m[row, at_joint] += m[row, f]
        for j in range(size):
            m[i, j] = m[row, int(solved[j])]
