"""The equations of the strip model: residuals of all conditions. Their derivatives: `contact.strips.derivatives`.

Unknowns of a grid of n strips: a^2 of each, k of each; both edges; a line, over the locus, that has their middles.
Equations in the same order, see `contact.strips.model`, all over the deepest penetration or ratios.
"""

from math import sqrt

from wrsim.contact.strips.grid import place_strips
from wrsim.contact.strips.influence import Displacements, pressed_at
from wrsim.contact.strips.records import EDGES, MIDDLES, OF_A_STRIP, V
from wrsim.jit.compiling import inlined, kernel

REACH = sqrt(0.75)  # of the half length: the outer ones of Chebyshev's three points
EDGE_RATIO = 0.85  # of p^2 in the outer strips, over what a straight line would give: Hertz's ellipses keep their width
LESS = 0.1  # weight of an edge's residual
EVENNESS = 0.03  # weight with which factors of neighbouring strips are held alike
THIRD = -1.0, 3.0, -3.0, 1.0  # difference
WEAKENING = 0.8  # exponent, as in contact.half_space.zones


@inlined
def block_of(n):
    """Unknowns of a grid of n strips."""
    return OF_A_STRIP * n + EDGES + MIDDLES


@kernel
def set_fading(system, coupling):
    """Write how much of the influence of each grid reaches each other one, by the distance of the places where they may
    touch.

    Grids whose overlaps hang together are one zone, as in contact.half_space.zones: what reaches one reaches the other.
    coupling: share of it that counts; with none, grids out of contact stay out.
    """
    memo, grids = system.memo[0], system.grids
    count, parts = memo.grids, system.vectors[V.FADING]
    for i in range(count):
        for j in range(count):
            one, other = grids[i], grids[j]
            along = max(max(one.least - other.most, other.least - one.most), 0.0)
            across = max(abs(one.x - other.x) - one.reach - other.reach, 0.0)
            apart = sqrt(along * along + across * across)
            share = (memo.apart - apart) / (memo.apart - memo.together)
            parts[i * count + j] = 1.0 if share >= 1.0 or i == j else max(share, 0.0) ** WEAKENING
    memo.alone = int(coupling == 0.0)
    for _ in range(count - 1):
        for j in range(count - 1):
            chain = grids[j].chain
            for i in range(count):
                here, there = parts[i * count + j], parts[i * count + j + 1]
                parts[i * count + j] = parts[j * count + i] = max(here, chain * there)
                parts[i * count + j + 1] = parts[(j + 1) * count + i] = max(there, chain * here)
    for i in range(count):
        for j in range(i):
            parts[i * count + j] *= coupling
            parts[j * count + i] *= coupling


@inlined
def fading(system, i, j):
    """How much of the influence of grid i reaches grid j: nothing if i is out of contact."""
    return system.vectors[V.FADING, i * system.memo[0].grids + j] if system.grids[i].on else 0.0


@kernel
def lay_strips(system, n):
    """Strips of all grids in contact between the edges that the unknowns give, and their amplitudes."""
    memo, places, vectors = system.memo[0], system.places, system.vectors
    x = vectors[V.X]
    for g in range(memo.grids):
        grid = system.grids[g]
        base = g * block_of(n)
        if not grid.on:
            continue
        edges = base + OF_A_STRIP * n
        middles = x[edges + EDGES :]
        grid.start, grid.end = x[edges], x[edges + 1]
        place_strips(system.wheel, system.rail, grid, system.rows[g], places[g * n : (g + 1) * n])
        for j in range(n):
            i, place = g * n + j, places[g * n + j]
            place.q = place.y = 0.0
            place.k = x[base + n + j]
            place.off = place.z = 0.0
            if memo.shifted:
                place.z = (2.0 * j + 1.0) / n - 1.0
                place.off = middles[0] + place.z * middles[1]
            inverse = 1.0
            if x[base + j] > 0.0:
                place.y = x[base + j]
                place.q = 0.5 * memo.modulus * place.bend * place.k
                inverse = 1.0 / sqrt(place.y)
            vectors[V.FROM, i], vectors[V.TO, i] = place.lo, place.hi
            vectors[V.INVERSE, i] = inverse
            vectors[V.PUSH, i] = place.q * place.y
            vectors[V.MIDDLE, i] = place.x + place.off if memo.shifted else grid.x
            vectors[V.NO, i], vectors[V.NB, i] = (place.no, place.nb) if memo.curved else (0.0, 1.0)


@kernel
def pressed(system, n, g, s, x, r, points, no, nb):
    """Displacements at x, x + r and x - r of a place s of grid g under all strips [m], or the first of these.

    no, nb: the normal there, (0, 1) where angles do not count.
    """
    memo = system.memo[0]
    middle = fore = aft = 0.0
    for h in range(memo.grids):
        part = fading(system, h, g) / memo.stiffness
        if part > 0.0:
            aligned = not memo.shifted and h == g
            own = pressed_at(system.table, system.vectors, h * n, (h + 1) * n, s, x, r, points, no, nb, aligned)
            middle, fore, aft = middle + part * own.middle, fore + part * own.fore, aft + part * own.aft
    return Displacements(middle, fore, aft)


@inlined
def set_conditions(system, n, g, j, points):
    """What is left of the conditions of strip j of grid g; points: 1 for the gap alone, 2 where shifts do not count, or
    3."""
    memo, place = system.memo[0], system.places[g * n + j]
    r = REACH * sqrt(place.y)
    v, i = system.vectors, g * n + j
    u = pressed(system, n, g, place.s, v[V.MIDDLE, i], r, points, v[V.NO, i], v[V.NB, i])
    place.gap = (u.middle - place.d + 0.5 * place.bend * place.off * place.off) / memo.deepest
    if points > 1:
        aft = u.aft if points > 2 else u.fore
        place.bow = (u.middle - 0.5 * (u.fore + aft) - 0.5 * place.bend * r * r) / memo.deepest
        place.turn = (u.fore - aft + 2.0 * place.bend * r * place.off) / memo.deepest


@inlined
def points_of(memo):
    """Points of a strip at which the surfaces follow each other: the outer ones are alike where shifts do not count."""
    return 3 if memo.shifted else 2


@kernel
def residuals(system, n):
    """Residuals of all equations to ``vectors[V.F]``; returns the largest, edges counting LESS."""
    memo, places, grids = system.memo[0], system.places, system.grids
    out = system.vectors[V.F]
    memo.iterations += 1
    lay_strips(system, n)
    largest = 0.0
    block, points = block_of(n), points_of(memo)
    for g in range(memo.grids):
        grid, base = grids[g], g * block
        out[base : base + block] = 0.0
        if not grid.on:
            continue
        for j in range(n):
            place = places[g * n + j]
            if place.y > 0.0:
                set_conditions(system, n, g, j, points)
                out[base + j] = place.gap
                out[base + n + j] += place.bow
            if j > 0:
                uneven = EVENNESS * (place.k - places[g * n + j - 1].k)
                out[base + n + j] += uneven
                out[base + n + j - 1] -= uneven
        if memo.shifted:
            grid.stairs = _find_stairs(system, g * n, n)
            for j in range(1, n - 2):
                i = g * n + j
                if four_touch(places, i - 1):
                    bent = places[i + 2].y - places[i - 1].y + 3.0 * (places[i].y - places[i + 1].y)
                    for p in range(4):
                        out[base + j + p - 1] += THIRD[p] * grid.stairs * places[i].bend / memo.deepest * bent
            set_middles(system, n, g)
        for i in range(base, base + block):
            largest = max(largest, abs(out[i]))
        for side in range(EDGES):
            e = base + OF_A_STRIP * n + side
            if grid.start_held if side == 0 else grid.end_held:
                continue
            out[e] = edge_wish(places, g * n, n, side)
            largest = max(largest, LESS * abs(out[e]))
    return largest


@kernel
def _find_stairs(system, first, n):
    """Mean square of the steps along the rail from strip to strip, over 24 times that of the half lengths.

    A strip has straight ends where the contact's are slanted: its middle should run over a step of as much. In the mean
    over the strip that changes a function of x by the square of the step over 24 times its second derivative, and
    displacements by that part of how far the bodies bend away over a half length. So firmly a^2 is held on a parabola.
    """
    middles, steps, squares = system.vectors[V.MIDDLE], 0.0, 0.0
    for i in range(first, first + n):
        y = system.places[i].y
        squares += y
        if i > first and y > 0.0 and system.places[i - 1].y > 0.0:
            steps += (middles[i] - middles[i - 1]) ** 2
    return steps / (24.0 * squares)


@inlined
def four_touch(places, i):
    """Whether four strips from one on are all in contact."""
    return min(places[i].y, places[i + 1].y, places[i + 2].y, places[i + 3].y) > 0.0


@inlined
def weight_of(place):
    """By how much the complementary energy changes with the middle of a strip, over its third condition."""
    return place.q * sqrt(place.y) * (place.hi - place.lo)


@kernel
def set_middles(system, n, g):
    """Residuals of the middles of a grid's strips: the energy does not change with the line that they lie on."""
    total = 0.0
    out = system.vectors[V.F, g * block_of(n) + OF_A_STRIP * n + EDGES :]
    out[:MIDDLES] = 0.0
    for i in range(g * n, (g + 1) * n):
        place = system.places[i]
        if place.y > 0.0:
            part = weight_of(place)
            total += part
            out[0] += part * place.turn
            out[1] += part * place.turn * place.z
    for k in range(MIDDLES):
        out[k] /= total
    system.grids[g].weight = total


@inlined
def edge_wish(places, first, n, side):
    """Ratio of p^2 in the two outer strips, less what it should be: positive where the edge should go out.

    Near the edge of a contact p^2 grows in proportion to the distance: a contact drawn too narrow carries a punch's
    singular pressure in its outer strip, one drawn too wide would have to pull there.
    """
    outer = places[first if side == 0 else first + n - 1]
    inner = places[first + 1 if side == 0 else first + n - 2]
    w0, w1 = outer.hi - outer.lo, inner.hi - inner.lo
    return outer.q * outer.q * outer.y / max(inner.q * inner.q * inner.y, 1e-30) - EDGE_RATIO * w0 / (2.0 * w0 + w1)
