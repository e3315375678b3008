"""The derivatives of the strip model's equations by all unknowns, see `contact.strips.equations`."""

from math import sqrt

from wrsim.contact.strips.equations import (
    CHEBYSHEV_NODE,
    EDGE_RATIO,
    SMOOTHING_WEIGHT,
    THIRD,
    block_of,
    edges_of,
    fading,
    four_in_contact,
    is_held,
    weight_of,
)
from wrsim.contact.strips.influence import find_terms, turned_influence, turned_rates
from wrsim.contact.strips.records import EDGES, MIDDLES, TERMS_PER_POINT, UNKNOWNS_PER_STRIP, System, V
from wrsim.jit import Array, inlined, kernel

Derivatives = tuple[float, float, float, float]  # by the edges and the line of the middles of a grid


@kernel
def _displacement_rows(system: System, n: int, g: int, i: int) -> None:
    """Derivatives of the displacements (strip-sum) at all points of strip i of grid g, through the strips, to
    ``matrix``; those of the tilt to ``vectors[V.TILT]``."""
    memo, places, vectors, m = system.memo[0], system.places, system.vectors, system.matrix
    by_tilt = vectors[V.TILT]
    block = block_of(n)
    unit = 1.0 / (memo.stiffness * memo.deepest)
    strip = places[g * n + i]
    row, e = g * block + i, edges_of(n, g)
    middle, r = vectors[V.MIDDLE, g * n + i], CHEBYSHEV_NODE * strip.a
    points = 2 + memo.has_shifts  # outer points are alike where shifts do not count
    no, nb = vectors[V.NO, g * n + i], vectors[V.NB, g * n + i]
    for point in range(points):
        arm = r if point == 1 else -r if point == 2 else 0.0
        x = middle + arm
        # shares of this point in the three equations
        gap = 1.0 if point == 0 else 0.0
        bow = 1.0 if point == 0 else -0.5 if points == 3 else -1.0
        tilt = 0.0 if point == 0 or points == 2 else 1.0 if point == 1 else -1.0
        t = V.TERMS + TERMS_PER_POINT * point
        p, p_xi, lever, f0, f1 = vectors[t], vectors[t + 1], vectors[t + 2], vectors[t + 3], vectors[t + 4]
        by_x = by_s = 0.0
        for h in range(memo.grids):
            share = unit * fading(system, h, g)
            if share == 0.0:
                continue
            aligned = point == 0 and h == g and not memo.has_shifts
            first, last, base = h * n, (h + 1) * n, h * block
            find_terms(system.table, vectors, first, last, strip.s, x, aligned, p, p_xi, lever, f0, f1)
            by_start = by_end = by_b0 = by_b1 = 0.0
            for j in range(first, last):
                place = places[j]
                if place.y <= 0.0:
                    continue
                column = base + j - first
                felt = share * turned_influence(vectors, j, no, nb, strip.s)
                q, a = felt * place.q, place.a
                xi = (x - vectors[V.MIDDLE, j]) / a
                by_y = q * (p[j] - 0.5 * (xi * p_xi[j] + lever[j]))
                by_k = felt * place.q_k * place.y * p[j]
                shift = q * a * p_xi[j]
                lo, hi = q * a * f0[j], q * a * f1[j]
                by_x += shift
                by_s += lo - hi
                by_middle = q * place.y * p[j] * place.log_slope - (shift * place.x_s if memo.has_shifts else 0.0)
                if memo.curved:
                    there, here = turned_rates(vectors, j, no, nb, strip.s, place.turn, place.side_s, strip.turn)
                    push = share * place.q * place.y * p[j]
                    by_middle += push * there
                    by_s += push * here
                by_start += hi * place.hi_start - lo * place.lo_start + by_middle * place.s_start
                by_end += hi * place.hi_end - lo * place.lo_end + by_middle * place.s_end
                m[row, column] += gap * by_y
                m[row, column + n] += gap * by_k
                m[row + n, column] += bow * by_y
                m[row + n, column + n] += bow * by_k
                by_tilt[column] += tilt * by_y
                by_tilt[column + n] += tilt * by_k
                by_b0 -= shift
                by_b1 -= shift * place.z
            _add_derivatives(m, by_tilt, row, n, edges_of(n, h), gap, bow, tilt, (by_start, by_end, by_b0, by_b1))
        # the point moves with the strip's middle, half length and place
        by_y = by_x * arm / (2.0 * strip.y)
        m[row + n, row] += bow * by_y
        by_tilt[row] += tilt * by_y
        along = by_s + (by_x * strip.x_s if points == 3 else 0.0)
        by_place = along * strip.s_start, along * strip.s_end, by_x, by_x * strip.z
        _add_derivatives(m, by_tilt, row, n, e, gap, bow, tilt, by_place)


@inlined
def _add_derivatives(
    m: Array, by_tilt: Array, row: int, n: int, e: int, gap: float, bow: float, tilt: float, by_line: Derivatives
) -> None:
    """Add the derivatives of a quantity by edges and middles of a grid, the first of them unknown e, to the conditions
    of a strip, in which it counts by gap, bow and tilt."""
    for k in range(EDGES + MIDDLES):
        m[row, e + k] += gap * by_line[k]
        m[row + n, e + k] += bow * by_line[k]
        by_tilt[e + k] += tilt * by_line[k]


@kernel
def _geometry_rows(system: System, n: int, g: int, i: int) -> None:
    """Derivatives of the geometry in (strip-points) at strip i of grid g, to ``matrix`` and ``vectors[V.TILT]``."""
    m, by_tilt, strip = system.matrix, system.vectors[V.TILT], system.places[g * n + i]
    row, e = g * block_of(n) + i, edges_of(n, g)
    r, off, unit = CHEBYSHEV_NODE * strip.a, strip.off, 1.0 / system.memo[0].deepest
    curvature, curvature_s = strip.curvature, strip.curvature_s
    # u - d + off^2/(2 R);  -r^2/(2 R);  2 r off/R
    m[row + n, row] -= 0.5 * curvature * CHEBYSHEV_NODE * CHEBYSHEV_NODE * unit
    by_tilt[row] += curvature * CHEBYSHEV_NODE * off / strip.a * unit
    gap, bow, tilt = -strip.d_s + 0.5 * curvature_s * off * off, -0.5 * curvature_s * r * r, 2.0 * curvature_s * r * off
    by_s = strip.s_start, strip.s_end, 0.0, 0.0
    _add_derivatives(m, by_tilt, row, n, e, gap * unit, bow * unit, tilt * unit, by_s)
    by_off = 0.0, 0.0, 1.0, strip.z
    _add_derivatives(m, by_tilt, row, n, e, curvature * off * unit, 0.0, 2.0 * curvature * r * unit, by_off)


@kernel
def _add_to_middles(system: System, n: int, g: int, i: int) -> None:
    """The share of strip i of grid g in the derivatives of (strip-means). Its weight counts as constant: with its
    derivatives Newton's method fails more often."""
    memo, grid, strip = system.memo[0], system.grids[g], system.places[g * n + i]
    by_tilt, first, share = system.vectors[V.TILT], edges_of(n, g) + EDGES, weight_of(strip) / grid.weight
    for j in range(memo.grids * block_of(n)):
        term = share * by_tilt[j]
        for k in range(MIDDLES):
            system.matrix[first + k, j] += term
            term *= strip.z


@kernel
def jacobian(system: System, n: int) -> None:
    """Derivatives of the equations by the unknowns that are solved for, to ``matrix``, for the state of the last
    ``residuals``; the numbers of these unknowns to ``vectors[V.UNKNOWN_INDEX]``, how many there are to the memo.

    Edges that are held and grids out of contact stay as they are; of strips out of contact factors are solved for, so
    that they come to be what they have when they touch.
    """
    memo, places, grids = system.memo[0], system.places, system.grids
    m = system.matrix
    size = memo.grids * block_of(n)
    m[:size, :size] = 0.0
    for g in range(memo.grids):
        for j in range(n if grids[g].active else 0):
            place = places[g * n + j]
            place.a = sqrt(place.y)
            place.q_k = 0.5 * memo.modulus * place.curvature
            place.log_slope = place.curvature_s / place.curvature
            place.s_start = 0.5 * (place.lo_start + place.hi_start)
            place.s_end = 0.5 * (place.lo_end + place.hi_end)
            first, last = g * n + max(j - 1, 0), g * n + min(j + 1, n - 1)
            before, behind, side = places[first], places[last], system.vectors[V.SIDE]
            inverse = 1.0 / (behind.s - before.s)
            place.turn = (before.no * behind.nb - before.nb * behind.no) * inverse
            place.side_s = (side[last] - side[first]) * inverse
    for g in range(memo.grids):
        for i in range(n if grids[g].active else 0):
            if places[g * n + i].y <= 0.0:
                continue
            system.vectors[V.TILT, :size] = 0.0
            _displacement_rows(system, n, g, i)
            _geometry_rows(system, n, g, i)
            if memo.has_shifts:
                _add_to_middles(system, n, g, i)
        if grids[g].active:
            _smoothing_rows(system, n, g)
            _edge_rows(system, n, g)
    _select_unknowns(system, n)


@kernel
def _smoothing_rows(system: System, n: int, g: int) -> None:
    """Derivatives of (strip-smoothing) and (strip-stairs)."""
    m, base = system.matrix, g * block_of(n)
    for j in range(1, n):
        r = base + n + j
        m[r, r] += SMOOTHING_WEIGHT
        m[r, r - 1] -= SMOOTHING_WEIGHT
        m[r - 1, r - 1] += SMOOTHING_WEIGHT
        m[r - 1, r] -= SMOOTHING_WEIGHT
    places, grid = system.places, system.grids[g]
    for j in range(1, n - 2 if system.memo[0].has_shifts else 1):
        if four_in_contact(places, g * n + j - 1):
            weight, r = grid.stair_variance * places[g * n + j].curvature / system.memo[0].deepest, base + j - 1
            for p in range(4):
                for q in range(4):
                    m[r + p, r + q] += weight * THIRD[p] * THIRD[q]


@kernel
def _edge_rows(system: System, n: int, g: int) -> None:
    """Derivatives of (strip-edges)."""
    places, m, base, e = system.places, system.matrix, g * block_of(n), edges_of(n, g)
    for side in range(EDGES):
        r = e + side
        i, j = (0, 1) if side == 0 else (n - 1, n - 2)
        outer, inner = places[g * n + i], places[g * n + j]
        ratio = outer.q * outer.q * outer.y / max(inner.q * inner.q * inner.y, 1e-30)
        m[r, base + i] = ratio / max(outer.y, 1e-30)
        m[r, base + j] = -ratio / max(inner.y, 1e-30)
        m[r, base + n + i] = 2.0 * ratio / outer.k
        m[r, base + n + j] = -2.0 * ratio / inner.k
        by_start = 2.0 * ratio * (outer.log_slope * outer.s_start - inner.log_slope * inner.s_start)
        by_end = 2.0 * ratio * (outer.log_slope * outer.s_end - inner.log_slope * inner.s_end)
        w0, w1 = outer.hi - outer.lo, inner.hi - inner.lo
        rate = -EDGE_RATIO / (2.0 * w0 + w1) ** 2
        m[r, e] = by_start + rate * ((outer.hi_start - outer.lo_start) * w1 - (inner.hi_start - inner.lo_start) * w0)
        m[r, e + 1] = by_end + rate * ((outer.hi_end - outer.lo_end) * w1 - (inner.hi_end - inner.lo_end) * w0)


@kernel
def _select_unknowns(system: System, n: int) -> None:
    """Bring what is solved for to the first rows and columns of ``matrix``."""
    memo, grids, m, index = system.memo[0], system.grids, system.matrix, system.vectors[V.UNKNOWN_INDEX]
    size = 0
    for g in range(memo.grids):
        grid = grids[g]
        if not grid.active:
            continue
        for kind in range(UNKNOWNS_PER_STRIP):
            for j in range(n):
                if kind > 0 or system.places[g * n + j].y > 0.0:
                    index[size] = g * block_of(n) + kind * n + j
                    size += 1
        for side in range(EDGES):
            if not is_held(grid, side):
                index[size] = edges_of(n, g) + side
                size += 1
        for k in range(MIDDLES if memo.has_shifts else 0):
            index[size] = edges_of(n, g) + EDGES + k
            size += 1
    memo.unknowns = size
    for i in range(size):
        row = int(index[i])
        for j in range(size):
            m[i, j] = m[row, int(index[j])]
