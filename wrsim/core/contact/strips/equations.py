"""The equations of the strip model: misfits of all conditions. Their derivatives: `core.contact.strips.derivatives`.

Unknowns of a grid of n strips: a^2 of each, FACTORS values of k, both edges. Equations in the same order, see
`core.contact.strips.model`. Everything is taken over the deepest penetration, over 1/R_x or is a ratio.
"""

from math import sqrt

from wrsim.core.contact.strips.grid import place_strips
from wrsim.core.contact.strips.influence import (
    pressed_beside,
    pressed_by,
)
from wrsim.core.contact.strips.records import (
    CURVE,
    EDGES,
    FACTORS,
    FADING,
    FROM,
    INVERSE,
    MIDDLE,
    PUSH,
    TO,
    F,
    X,
)
from wrsim.core.contact.strips.shifts import off_locus
from wrsim.core.contact.strips.tails import bending
from wrsim.core.jit.compiling import inlined, kernel

EDGE_RATIO = 0.84  # of a^2 in the two outer strips, over what a parabola would give: Hertz's ellipses keep their width
LEAST_DEPTH = 1e-8  # for the longest half length [m]
THIRD = -1.0, 3.0, -3.0, 1.0  # difference
LESS = 0.1  # weight of an edge's misfit
EVENNESS = 0.005  # weight with which neighbouring factors are kept alike
# At its least value a factor stays as long as its equation asks for less. Not so at its largest: there are roots with
# half lengths far too short, which a run could slip into.
LEAST_FACTOR, MOST_FACTOR = 0.3, 20.0
WEAKENING = 0.8  # exponent, as in contact.half_space.zones


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
def set_fading(system):
    """Write how much of the influence of each grid reaches each other one, by the distance of the places where they may
    touch.

    Grids whose overlaps hang together are one zone, as in contact.half_space.zones: what reaches one reaches the other.
    """
    memo, grids = system.memo[0], system.grids
    count, parts = memo.grids, system.vectors[FADING]
    for i in range(count):
        for j in range(count):
            one, other = grids[i], grids[j]
            along = max(max(one.least - other.most, other.least - one.most), 0.0)
            across = max(abs(one.x - other.x) - one.reach - other.reach, 0.0)
            apart = sqrt(along * along + across * across)
            share = (memo.apart - apart) / (memo.apart - memo.together)
            parts[i * count + j] = 1.0 if share >= 1.0 or i == j else max(share, 0.0) ** WEAKENING
    for _ in range(count - 1):
        for j in range(count - 1):
            chain = grids[j].chain
            for i in range(count):
                here, there = parts[i * count + j], parts[i * count + j + 1]
                parts[i * count + j] = parts[j * count + i] = max(here, chain * there)
                parts[i * count + j + 1] = parts[(j + 1) * count + i] = max(there, chain * here)


@inlined
def fading(system, i, j):
    """How much of the influence of grid i reaches grid j: nothing if i is out of contact."""
    return system.vectors[FADING, i * system.memo[0].grids + j] if system.grids[i].on else 0.0


@kernel
def set_amplitudes(system, n):
    """Amplitudes of the strips and the weights of their curvatures, from the unknowns."""
    memo, places, vectors = system.memo[0], system.places, system.vectors
    x = vectors[X]
    for g in range(memo.grids):
        grid = system.grids[g]
        force = 0.0
        base = g * block_of(n)
        grid.pressing = grid.beyond = 0
        for j in range(n):
            place = places[g * n + j]
            place.q = place.weight = place.y = 0.0
            place.over = inverse = 1.0
            if grid.on and x[base + j] > 0.0:
                most = longest(place)
                place.y = min(x[base + j], most)
                place.over = max(x[base + j] / most, 1.0)
                f, r = factor_of(place)
                k = (1.0 - r) * x[base + n + f] + r * x[base + n + f + 1]
                place.q = 0.5 * memo.modulus * place.bend * k * place.over
                place.weight = place.q * place.y * (place.hi - place.lo)
                inverse = 1.0 / sqrt(place.y)
                force += place.weight
                grid.pressing = grid.pressing if grid.beyond > 0 else j
                grid.beyond = j + 1
            vectors[FROM, g * n + j] = place.lo
            vectors[TO, g * n + j] = place.hi
            vectors[INVERSE, g * n + j] = inverse
            vectors[PUSH, g * n + j] = place.q * place.y
            place.bent, place.bent_y = 1.0, 0.0
            if grid.tail != 0:
                place.bent, place.bent_y = bending(grid, place)
            vectors[CURVE, g * n + j] = place.q * place.bent
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
def set_middles(system, n):
    """Middles of all strips along x; on the locus where shifts do not count."""
    memo = system.memo[0]
    for g in range(memo.grids):
        for j in range(g * n, (g + 1) * n):
            place = system.places[j]
            place.off = off_locus(system.grids[g], place.x) if memo.shifted else 0.0
            system.vectors[MIDDLE, j] = place.x + place.off


@kernel
def pressed(system, n, g, s, x):
    """Displacement at a place s of grid g and its curvature, both times pi E*, under all strips.

    x: the place along the rail, of use only where shifts count.
    """
    u = c = 0.0
    shifted = system.memo[0].shifted
    for h in range(system.memo[0].grids):
        part = fading(system, h, g)
        if part > 0.0:
            first, end = h * n + system.grids[h].pressing, h * n + system.grids[h].beyond
            if shifted:
                own_u, own_c = pressed_beside(system.table, system.vectors, first, end, s, x)
            else:
                own_u, own_c = pressed_by(system.table, system.vectors, first, end, s)
            u += part * own_u
            c += part * own_c
    return u, c


@inlined
def gap_and_curvature(system, n, g, place):
    """u - d of a strip of grid g, over the deepest penetration, and the curvature of u times pi E*."""
    memo = system.memo[0]
    u, c = pressed(system, n, g, place.s, place.x + place.off)
    return (u / memo.stiffness - place.d + 0.5 * place.bend * place.off * place.off) / memo.deepest, c


@kernel
def residuals(system, n, held):
    """Misfits of all equations to ``vectors[F]``; returns the largest, edges counting LESS.

    held: factors and edges stay as they are, their equations are left out; strips out of contact have their gaps, too.
    """
    memo, places, grids = system.memo[0], system.places, system.grids
    x, out = system.vectors[X], system.vectors[F]
    memo.iterations += 1
    lay_strips(system, n)
    set_amplitudes(system, n)
    set_middles(system, n)
    largest = 0.0
    block = block_of(n)
    for g in range(memo.grids):
        grid, base = grids[g], g * block
        out[base : base + block] = 0.0
        if not grid.on:
            continue
        own = base + n
        if memo.shifted:
            _calm(grid, places[g * n : (g + 1) * n], x[base : base + n], memo.deepest, out[base : base + n])
        for j in range(n):
            place = places[g * n + j]
            if place.y <= 0.0 and not held:
                continue
            place.gap, c = gap_and_curvature(system, n, g, place)
            place.miss = c / (memo.stiffness * place.bend) - 1.0
            if place.y <= 0.0:
                continue
            out[base + j] += place.gap
            largest = max(largest, abs(out[base + j]))
            f, r = factor_of(place)
            out[own + f] += (1.0 - r) * place.weight * place.miss
            out[own + f + 1] += r * place.weight * place.miss
        if held:
            out[own : own + block - n] = 0.0
            continue
        if grid.tail != 0:
            # its factors are those at the joint, its edges stand still
            out[own : own + block - n] = 0.0
            continue
        even = evenness(memo, grid)
        for f in range(FACTORS):
            before, after = x[own + max(f - 1, 0)], x[own + min(f + 1, FACTORS - 1)]
            out[own + f] += even * (2.0 * x[own + f] - before - after)
        if grid.link > 0.0 and grids[grid.linked].on:
            last, first = own + FACTORS - 1, grid.linked * block + n
            out[last] += grid.link * (x[last] - x[first])
        for h in range(g):
            if grids[h].linked == g and grids[h].link > 0.0 and grids[h].on:
                out[own] += grids[h].link * (x[own] - x[h * block + n + FACTORS - 1])
        for f in range(FACTORS):
            if x[own + f] <= LEAST_FACTOR and out[own + f] > 0.0:
                out[own + f] = 0.0
            largest = max(largest, abs(out[own + f]))
        for side in range(2):
            e = own + FACTORS + side
            if grid.start_held if side == 0 else grid.end_held:
                out[e] = 0.0
                continue
            out[e] = edge_wish(places, g * n, n, side)
            largest = max(largest, LESS * abs(out[e]))
    return largest


@kernel
def _calm(grid, places, squares, deepest, out):
    """Add what holds a^2 of neighbouring strips on a parabola: the derivatives of a sum of squares of third
    differences, nothing for Hertz's ellipse."""
    n = places.size
    weight = grid.calm * places[n // 2].bend / deepest
    for j in range(n - 3):
        if min(min(places[j].y, places[j + 1].y), min(places[j + 2].y, places[j + 3].y)) > 0.0:
            bend = weight * (squares[j + 3] - squares[j] + 3.0 * (squares[j + 1] - squares[j + 2]))
            out[j] -= bend
            out[j + 1] += 3.0 * bend
            out[j + 2] -= 3.0 * bend
            out[j + 3] += bend


@inlined
def joint(g, grid, n):
    """Unknown of the factor where a tail meets its hump."""
    return (g + grid.tail) * block_of(n) + n + (FACTORS - 1 if grid.tail < 0 else 0)


@inlined
def evenness(memo, grid):
    """Weight with which neighbouring factors are kept alike."""
    return EVENNESS * grid.evenness if memo.shifted else EVENNESS


@inlined
def edge_wish(places, first, n, side):
    """Ratio of a^2 in the two outer strips, less what it should be: positive where the edge should go out.

    Near the edge of a contact p^2, and with it a^2, grows in proportion to the distance: a contact drawn too narrow
    carries a punch's singular pressure in its outer strip, one drawn too wide would have to pull there.
    """
    outer = places[first if side == 0 else first + n - 1]
    inner = places[first + 1 if side == 0 else first + n - 2]
    w0, w1 = outer.hi - outer.lo, inner.hi - inner.lo
    # what they ask for: where a strip is as long as it can be, its amplitude still says how hard it presses
    return outer.y * outer.over / max(inner.y * inner.over, 1e-30) - EDGE_RATIO * w0 / (2.0 * w0 + w1)
