"""The equations of the strip model: misfits of all conditions, and their derivatives by all unknowns.

Unknowns of a grid of n strips: a^2 of each, FACTORS values of k, both edges. Equations in the same order, see
`core.contact.strips.model`. Everything is taken over the deepest penetration, over 1/R_x or is a ratio.
"""

from math import sqrt

from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.strips.grid import place_strips
from wrsim.core.contact.strips.influence import potential, primitives
from wrsim.core.contact.strips.records import EDGES, FACTORS, F, X

EDGE_RATIO = 0.84  # of a^2 in the two outer strips, over what a parabola would give: Hertz's ellipses keep their width
LEAST_DEPTH = 1e-8  # for the longest half length [m]
LESS = 0.1  # weight of an edge's misfit
EVENNESS = 0.005  # weight with which neighbouring factors are kept alike
FADING = 0.8  # exponent, as in contact.half_space.zones


@inlined
def block_of(n):
    """Unknowns of a grid of n strips."""
    return n + FACTORS + EDGES


@inlined
def longest(place):
    """Largest possible a^2 of a strip: beyond sqrt(2 R_x d) the undeformed bodies are apart. An unknown beyond stands
    for a larger amplitude."""
    return 2.0 * max(place.d, LEAST_DEPTH) / place.bend


@inlined
def factor_of(place):
    """Number of the factor before a place, and the share of the next one."""
    f = min(int(place.at), FACTORS - 2)
    return f, place.at - f


@kernel
def fading(system, i, j):
    """How much of the influence of grid i reaches grid j, by the distance of the places where they may touch."""
    if i == j:
        return 1.0
    memo, one, other = system.memo[0], system.grids[i], system.grids[j]
    along = max(max(one.least - other.most, other.least - one.most), 0.0)
    across = max(abs(one.x - other.x) - one.reach - other.reach, 0.0)
    apart = sqrt(along * along + across * across)
    share = (memo.apart - apart) / (memo.apart - memo.together)
    return 1.0 if share >= 1.0 else max(share, 0.0) ** FADING


@kernel
def set_amplitudes(system, n):
    """Amplitudes of the strips and the weights of their curvatures, from the unknowns."""
    memo, places, x = system.memo[0], system.places, system.vectors[X]
    for g in range(memo.grids):
        grid = system.grids[g]
        force = 0.0
        base = g * block_of(n)
        for j in range(n):
            place = places[g * n + j]
            place.q = place.weight = place.y = 0.0
            place.over = 1.0
            if grid.on and x[base + j] > 0.0:
                most = longest(place)
                place.y = min(x[base + j], most)
                place.over = max(x[base + j] / most, 1.0)
                f, r = factor_of(place)
                k = (1.0 - r) * x[base + n + f] + r * x[base + n + f + 1]
                place.q = 0.5 * memo.modulus * place.bend * k * place.over
                place.weight = place.q * place.y * (place.hi - place.lo)
                force += place.weight
        if force > 0.0:
            for j in range(n):
                places[g * n + j].weight /= force


@kernel
def lay_strips(system, n):
    """Strips of all grids in contact between the edges that the unknowns say."""
    x = system.vectors[X]
    for g in range(system.memo[0].grids):
        grid = system.grids[g]
        if grid.on:
            base = g * block_of(n) + n + FACTORS
            grid.start, grid.end = x[base], x[base + 1]
            place_strips(grid, system.rows[g], system.places[g * n : (g + 1) * n])


@kernel
def pressed(system, n, g, target):
    """Displacement at a place of grid g and its curvature, both times pi E*, under all strips."""
    places, table = system.places, system.table
    u = c = 0.0
    for h in range(system.memo[0].grids):
        if not system.grids[h].on:
            continue
        part = fading(system, h, g)
        if part == 0.0:
            continue
        for j in range(h * n, (h + 1) * n):
            place = places[j]
            if place.y <= 0.0:
                continue
            inverse = 1.0 / sqrt(place.y)
            lo, hi = (place.lo - target.s) * inverse, (place.hi - target.s) * inverse
            p0, c0 = primitives(table, abs(lo))
            p1, c1 = primitives(table, abs(hi))
            if lo < 0.0:
                p0, c0 = -p0, -c0
            if hi < 0.0:
                p1, c1 = -p1, -c1
            u += part * place.q * place.y * (p1 - p0)
            c += part * place.q * (c1 - c0)
    return u, c


@kernel
def residuals(system, n, held):
    """Misfits of all equations to ``vectors[F]``; returns the largest, edges counting LESS.

    held: factors and edges stay as they are, their equations are left out.
    """
    memo, places, grids = system.memo[0], system.places, system.grids
    x, out = system.vectors[X], system.vectors[F]
    memo.iterations += 1
    lay_strips(system, n)
    set_amplitudes(system, n)
    largest = 0.0
    block = block_of(n)
    for g in range(memo.grids):
        grid, base = grids[g], g * block
        out[base : base + block] = 0.0
        if not grid.on:
            continue
        own = base + n
        for j in range(n):
            place = places[g * n + j]
            u, c = pressed(system, n, g, place)
            place.gap = (u / memo.stiffness - place.d) / memo.deepest
            place.miss = c / (memo.stiffness * place.bend) - 1.0
            if place.y <= 0.0:
                continue
            out[base + j] = place.gap
            largest = max(largest, abs(place.gap))
            f, r = factor_of(place)
            out[own + f] += (1.0 - r) * place.weight * place.miss
            out[own + f + 1] += r * place.weight * place.miss
        if held:
            out[own : own + FACTORS] = 0.0
            continue
        for f in range(FACTORS):
            before, after = x[own + max(f - 1, 0)], x[own + min(f + 1, FACTORS - 1)]
            out[own + f] += EVENNESS * (2.0 * x[own + f] - before - after)
        if grid.link > 0.0 and grids[g + 1].on:
            out[own + FACTORS - 1] += grid.link * (x[own + FACTORS - 1] - x[own + block])
        if g > 0 and grids[g - 1].link > 0.0 and grids[g - 1].on:
            out[own] += grids[g - 1].link * (x[own] - x[own - block + FACTORS - 1])
        for f in range(FACTORS):
            largest = max(largest, abs(out[own + f]))
        for side in range(2):
            e = own + FACTORS + side
            if grid.start_held if side == 0 else grid.end_held:
                out[e] = 0.0
                continue
            out[e] = edge_wish(places, g * n, n, side)
            largest = max(largest, LESS * abs(out[e]))
    return largest


@inlined
def edge_wish(places, first, n, side):
    """Ratio of a^2 in the two outer strips, less what it should be: positive where the edge should go out.

    Near the edge of a contact p^2, and with it a^2, grows in proportion to the distance: a contact drawn too narrow
    carries a punch's singular pressure in its outer strip, one drawn too wide would have to pull there.
    """
    outer = places[first if side == 0 else first + n - 1]
    inner = places[first + 1 if side == 0 else first + n - 2]
    w0, w1 = outer.hi - outer.lo, inner.hi - inner.lo
    return outer.y / max(inner.y, 1e-30) - EDGE_RATIO * w0 / (2.0 * w0 + w1)


@kernel
def jacobian(system, n, held):
    """Derivatives of all equations by all unknowns to ``matrix``, for the state of the last ``residuals``."""
    memo, places, grids, table = system.memo[0], system.places, system.grids, system.table
    m = system.matrix
    block = block_of(n)
    size = memo.grids * block
    m[:size, :size] = 0.0
    unit = 1.0 / (memo.stiffness * memo.deepest)
    for h in range(memo.grids):
        source, base = grids[h], h * block
        if not source.on:
            for i in range(block):
                m[base + i, base + i] = 1.0
            continue
        for j in range(n):
            place = places[h * n + j]
            column = base + j
            if place.y <= 0.0:
                m[column, column] = 1.0
                continue
            fj, rj = factor_of(place)
            k0 = base + n + fj
            a = sqrt(place.y)
            inverse = 1.0 / a
            half = 0.5 * memo.modulus * place.bend * place.over
            full = place.over > 1.0
            growing = place.d_s / max(place.d, LEAST_DEPTH) - place.bend_s / place.bend if full else 0.0
            lean = place.bend_s / place.bend
            mid_start, mid_end = 0.5 * (place.lo_start + place.hi_start), 0.5 * (place.lo_end + place.hi_end)
            width = place.hi - place.lo
            for g in range(memo.grids):
                target = grids[g]
                if not target.on:
                    continue
                part = fading(system, h, g)
                if part == 0.0:
                    continue
                there = g * block
                e_source, e_target = base + n + FACTORS, there + n + FACTORS
                for i in range(n):
                    at = places[g * n + i]
                    if at.y <= 0.0:
                        continue
                    lo, hi = (place.lo - at.s) * inverse, (place.hi - at.s) * inverse
                    t0, t1 = abs(lo), abs(hi)
                    p0, c0 = primitives(table, t0)
                    p1, c1 = primitives(table, t1)
                    f0, f1 = potential(table, t0), potential(table, t1)
                    g0, g1 = f0 / (1.0 + t0 * t0), f1 / (1.0 + t1 * t1)
                    if lo < 0.0:
                        p0, c0 = -p0, -c0
                    if hi < 0.0:
                        p1, c1 = -p1, -c1
                    u = part * place.y * (p1 - p0)
                    c = part * (c1 - c0)
                    du = part * ((p1 - p0) - 0.5 * (hi * f1 - lo * f0))
                    dc = -0.5 * part * (hi * g1 - lo * g0) / place.y
                    # by the ends of the strip, over pi E*
                    u0, u1 = part * place.q * a * f0, part * place.q * a * f1
                    v0, v1 = part * place.q * g0 * inverse, part * place.q * g1 * inverse
                    # by a^2, or by the amplitude where a^2 is as large as can be
                    more_u = u / place.y if full else du
                    more_c = c / place.y if full else dc
                    more_u, more_c = more_u / place.over, more_c / place.over
                    row = there + i
                    m[row, column] += unit * place.q * more_u
                    if held:
                        continue
                    m[row, k0] += unit * u * half * (1.0 - rj)
                    m[row, k0 + 1] += unit * u * half * rj
                    fi, ri = factor_of(at)
                    w0 = there + n + fi
                    scale = at.weight / (memo.stiffness * at.bend)
                    s0, s1 = (1.0 - ri) * scale, ri * scale
                    m[w0, column] += s0 * more_c * place.q
                    m[w0 + 1, column] += s1 * more_c * place.q
                    by_k = c * half
                    m[w0, k0] += s0 * by_k * (1.0 - rj)
                    m[w0, k0 + 1] += s0 * by_k * rj
                    m[w0 + 1, k0] += s1 * by_k * (1.0 - rj)
                    m[w0 + 1, k0 + 1] += s1 * by_k * rj
                    for side in range(2):
                        by_lo, by_hi, by_mid = place.lo_start, place.hi_start, mid_start
                        at_mid = 0.5 * (at.lo_start + at.hi_start)
                        if side == 1:
                            by_lo, by_hi, by_mid = place.lo_end, place.hi_end, mid_end
                            at_mid = 0.5 * (at.lo_end + at.hi_end)
                        move_u = u1 * by_hi - u0 * by_lo
                        move_c = v1 * by_hi - v0 * by_lo
                        move_u += place.q * (u * lean + growing * (place.y * du - u)) * by_mid
                        move_c += place.q * (c * lean + growing * (place.y * dc - c)) * by_mid
                        m[row, e_source + side] += unit * move_u
                        m[w0, e_source + side] += s0 * move_c
                        m[w0 + 1, e_source + side] += s1 * move_c
                        m[row, e_target + side] += unit * (u0 - u1) * at_mid
                        m[w0, e_target + side] += s0 * (v0 - v1) * at_mid
                        m[w0 + 1, e_target + side] += s1 * (v0 - v1) * at_mid
            if held:
                continue
            # the geometry at the strip's own centre, and the weights of the means
            w0 = k0
            moment = place.weight * place.miss
            share = half / place.q
            for side in range(2):
                mid = mid_start if side == 0 else mid_end
                growth = (place.hi_start - place.lo_start) if side == 0 else (place.hi_end - place.lo_end)
                e = base + n + FACTORS + side
                m[column, e] -= place.d_s * mid / memo.deepest
                by_edge = moment * (lean * mid + growth / width) - place.weight * (place.miss + 1.0) * lean * mid
                m[w0, e] += (1.0 - rj) * by_edge
                m[w0 + 1, e] += rj * by_edge
            for b in range(2):
                own = (1.0 - rj if b == 0 else rj) * moment
                m[w0 + b, column] += own / (place.y * place.over)
                m[w0 + b, k0] += own * share * (1.0 - rj)
                m[w0 + b, k0 + 1] += own * share * rj
    for g in range(memo.grids):
        grid, own = grids[g], g * block + n
        if not grid.on:
            continue
        if held:
            for i in range(own, own + FACTORS + EDGES):
                m[i, :size] = 0.0
                m[i, i] = 1.0
            continue
        for f in range(FACTORS):
            r = own + f
            if f > 0:
                m[r, r] += EVENNESS
                m[r, r - 1] -= EVENNESS
            if f < FACTORS - 1:
                m[r, r] += EVENNESS
                m[r, r + 1] -= EVENNESS
        if grid.link > 0.0 and grids[g + 1].on:
            one, other = own + FACTORS - 1, own + block
            m[one, one] += grid.link
            m[one, other] -= grid.link
            m[other, other] += grid.link
            m[other, one] -= grid.link
        for side in range(2):
            r = own + FACTORS + side
            if grid.start_held if side == 0 else grid.end_held:
                m[r, :size] = 0.0
                m[r, r] = 1.0
                continue
            outer, inner = (g * n, g * n + 1) if side == 0 else (g * n + n - 1, g * n + n - 2)
            y1 = max(places[inner].y, 1e-30)
            m[r, g * block + outer - g * n] = 1.0 / y1
            m[r, g * block + inner - g * n] = -places[outer].y / (y1 * y1)
    return size
