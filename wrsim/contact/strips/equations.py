"""The equations of the strip model: residuals of all conditions. Their derivatives: `contact.strips.derivatives`.

Unknowns of a grid of n strips: a^2 of each, k of each; both edges; the line of (strip-middles).
Equations in the same order, see `contact.strips.model`, all over the deepest penetration or ratios.
"""

from math import sqrt

from wrsim.contact.strips.grid import place_grid_strips, row_below
from wrsim.contact.strips.influence import Displacements, displacement_at
from wrsim.contact.strips.records import EDGES, MIDDLES, UNKNOWNS_PER_STRIP, System, V
from wrsim.jit import Array, Record, Records, inlined, kernel

CHEBYSHEV_NODE = sqrt(0.75)  # of the half length: the outer ones of Chebyshev's three points
EDGE_RATIO = 0.85  # of p^2 in the outer strips, over what a straight line would give: Hertz's ellipses keep their width
EDGE_WEIGHT = 0.1  # of an edge's residual among all residuals
SMOOTHING_WEIGHT = 0.03  # of differences between factors of neighbouring strips
THIRD = -1.0, 3.0, -3.0, 1.0  # difference
DECAY_EXPONENT = 0.8  # of the influence between grids, as in contact.half_space.zones


@inlined
def block_of(n: int) -> int:
    """Unknowns of a grid of n strips."""
    return UNKNOWNS_PER_STRIP * n + EDGES + MIDDLES


@inlined
def edges_of(n: int, g: int) -> int:
    """Number of the first edge of grid g among all unknowns; the end and the line of the middles follow it."""
    return g * block_of(n) + UNKNOWNS_PER_STRIP * n


@inlined
def is_held(grid: Record, side: int) -> bool:
    """Whether an edge is held at its bound; side: 0 for the start, 1 for the end."""
    return (grid.start_held if side == 0 else grid.end_held) != 0


@inlined
def hold_edges(grid: Record, start: float, end: float) -> None:
    """Hold the edges that have come to their bounds, free the others."""
    grid.start_held, grid.end_held = int(start <= grid.least), int(end >= grid.most)


@inlined
def clamp_edges(grid: Record, x: Array, e: int) -> bool:
    """Bring edges e, e + 1 of the unknowns x back to their bounds and hold them there. True if one was not held."""
    before = grid.start_held + grid.end_held
    if grid.start_held or x[e] < grid.least:
        x[e] = grid.least
        grid.start_held = 1
    if grid.end_held or x[e + 1] > grid.most:
        x[e + 1] = grid.most
        grid.end_held = 1
    return grid.start_held + grid.end_held > before


@kernel
def set_fading(system: System, coupling: float) -> None:
    """Write how much of the influence of each grid reaches each other one (strip-fading), by the distance of the places
    where they may touch.

    Grids whose overlaps hang together are one zone, as in contact.half_space.zones: what reaches one reaches the other.
    coupling: share of it that counts; with none, grids out of contact stay out.
    """
    memo, grids = system.memo[0], system.grids
    count, shares = memo.grids, system.vectors[V.FADING]
    for i in range(count):
        for j in range(count):
            first, second = grids[i], grids[j]
            along = max(max(first.least - second.most, second.least - first.most), 0.0)
            across = max(abs(first.x - second.x) - first.half_length - second.half_length, 0.0)
            distance = sqrt(along * along + across * across)
            share = (memo.apart - distance) / (memo.apart - memo.together)
            shares[i * count + j] = 1.0 if share >= 1.0 or i == j else max(share, 0.0) ** DECAY_EXPONENT
    memo.uncoupled = int(coupling == 0.0)
    for _ in range(count - 1):
        for j in range(count - 1):
            link = grids[j].coupling
            for i in range(count):
                here, there = shares[i * count + j], shares[i * count + j + 1]
                shares[i * count + j] = shares[j * count + i] = max(here, link * there)
                shares[i * count + j + 1] = shares[(j + 1) * count + i] = max(there, link * here)
    for i in range(count):
        for j in range(i):
            shares[i * count + j] *= coupling
            shares[j * count + i] *= coupling


@inlined
def fading(system: System, i: int, j: int) -> float:
    """Share of the influence of grid i that reaches grid j: nothing if i is out of contact."""
    return system.vectors[V.FADING, i * system.memo[0].grids + j] if system.grids[i].active else 0.0


@kernel
def place_strips(system: System, n: int) -> None:
    """Strips of all grids in contact between the edges that the unknowns give, with amplitudes (strip-amplitude) and
    middles (strip-middles)."""
    memo, places, vectors = system.memo[0], system.places, system.vectors
    x = vectors[V.X]
    for g in range(memo.grids):
        grid = system.grids[g]
        base, edges = g * block_of(n), edges_of(n, g)
        if not grid.active:
            continue
        middles = x[edges + EDGES :]
        grid.start, grid.end = x[edges], x[edges + 1]
        rows = system.rows[g]
        strips = places[g * n : (g + 1) * n]
        place_grid_strips(system.wheel, system.rail, grid, rows, strips, vectors[V.TERMS :])
        for j in range(n):
            i, place = g * n + j, places[g * n + j]
            place.q = place.y = 0.0
            place.k = x[base + n + j]
            place.off = place.z = 0.0
            if memo.has_shifts:
                place.z = (2.0 * j + 1.0) / n - 1.0
                place.off = middles[0] + place.z * middles[1]
            inverse = 1.0
            if x[base + j] > 0.0:
                place.y = x[base + j]
                place.q = 0.5 * memo.modulus * place.curvature * place.k
                inverse = 1.0 / sqrt(place.y)
            vectors[V.FROM, i], vectors[V.TO, i] = place.lo, place.hi
            vectors[V.INVERSE, i] = inverse
            vectors[V.PUSH, i] = place.q * place.y
            vectors[V.MIDDLE, i] = place.x + place.off if memo.has_shifts else grid.x
            vectors[V.NO, i], vectors[V.NB, i] = (place.no, place.nb) if memo.curved else (0.0, 1.0)
            side = 0.0
            if memo.traction_pass > 0:
                r, z = row_below(grid, place.s)
                side = rows[r].side + z * (rows[r + 1].side - rows[r].side)
            vectors[V.SIDE, i], vectors[V.LIFT, i] = side, memo.transverse * side


@kernel
def displacements(
    system: System, n: int, g: int, s: float, x: float, r: float, points: int, no: float, nb: float
) -> Displacements:
    """Displacements (strip-sum) at x, x + r and x - r of a place s of grid g under all strips [m], or the first
    ``points`` of these.

    no, nb: the normal there, (0, 1) where angles do not count.
    """
    memo = system.memo[0]
    middle = fore = aft = 0.0
    for h in range(memo.grids):
        share = fading(system, h, g) / memo.stiffness
        if share > 0.0:
            aligned = not memo.has_shifts and h == g
            first, last, turned = h * n, (h + 1) * n, memo.curved != 0
            u = displacement_at(system.table, system.vectors, first, last, s, x, r, points, no, nb, turned, aligned)
            middle, fore, aft = middle + share * u.middle, fore + share * u.fore, aft + share * u.aft
    return Displacements(middle, fore, aft)


@inlined
def set_conditions(system: System, n: int, g: int, j: int, points: int) -> None:
    """Write the residuals of (strip-points) of strip j of grid g: 1 point for the gap alone, 2 where shifts do not
    count, or 3."""
    memo, place = system.memo[0], system.places[g * n + j]
    r = CHEBYSHEV_NODE * sqrt(place.y)
    v, i = system.vectors, g * n + j
    u = displacements(system, n, g, place.s, v[V.MIDDLE, i], r, points, v[V.NO, i], v[V.NB, i])
    place.gap = (u.middle - place.d + 0.5 * place.curvature * place.off * place.off) / memo.deepest
    if points > 1:
        place.bow = (u.middle - 0.5 * (u.fore + u.aft) - 0.5 * place.curvature * r * r) / memo.deepest
        place.tilt = (u.fore - u.aft + 2.0 * place.curvature * r * place.off) / memo.deepest


@inlined
def residual_price(system: System, n: int) -> float:
    """What a residual takes: half of it strips take by themselves, half the strips that act on them, at two points or
    three."""
    memo, grids = system.memo[0], system.grids
    size = n / memo.all_strips
    price = 0.0
    for g in range(memo.grids):
        for h in range(memo.grids if grids[g].active else 0):
            price += 0.5 * size * size * int(fading(system, h, g) > 0.0)
        price += 0.5 * size * grids[g].active
    return (1.0 + 0.5 * memo.has_shifts) * price


@kernel
def residuals(system: System, n: int) -> float:
    """Residuals of (strip-points), (strip-smoothing), (strip-stairs), (strip-means) and (strip-edges) to
    ``vectors[V.F]``; returns the largest, edges counting EDGE_WEIGHT."""
    memo, places, grids = system.memo[0], system.places, system.grids
    out = system.vectors[V.F]
    memo.iterations += 1
    memo.work += residual_price(system, n)
    place_strips(system, n)
    largest = 0.0
    block, points = block_of(n), 2 + memo.has_shifts  # outer points are alike where shifts do not count
    for g in range(memo.grids):
        grid, base = grids[g], g * block
        out[base : base + block] = 0.0
        if not grid.active:
            continue
        for j in range(n):
            place = places[g * n + j]
            if place.y > 0.0:
                set_conditions(system, n, g, j, points)
                out[base + j] = place.gap
                out[base + n + j] += place.bow
            if j > 0:
                uneven = SMOOTHING_WEIGHT * (place.k - places[g * n + j - 1].k)
                out[base + n + j] += uneven
                out[base + n + j - 1] -= uneven
        if memo.has_shifts:
            grid.stair_variance = _stair_variance(system, g * n, n)
            for j in range(1, n - 2):
                i = g * n + j
                if four_in_contact(places, i - 1):
                    third = places[i + 2].y - places[i - 1].y + 3.0 * (places[i].y - places[i + 1].y)
                    for p in range(4):
                        weight = THIRD[p] * grid.stair_variance * places[i].curvature / memo.deepest
                        out[base + j + p - 1] += weight * third
            set_middles(system, n, g)
        for i in range(base, base + block):
            largest = max(largest, abs(out[i]))
        for side in range(EDGES):
            if not is_held(grid, side):
                e = edges_of(n, g) + side
                out[e] = edge_residual(places, g * n, n, side)
                largest = max(largest, EDGE_WEIGHT * abs(out[e]))
    return largest


@kernel
def _stair_variance(system: System, first: int, n: int) -> float:
    """The factor of (strip-stairs): mean square of the steps along the rail from strip to strip, over 24 times that of
    the half lengths. So firmly a^2 is held on a parabola."""
    middles, steps, squares = system.vectors[V.MIDDLE], 0.0, 0.0
    for i in range(first, first + n):
        y = system.places[i].y
        squares += y
        if i > first and y > 0.0 and system.places[i - 1].y > 0.0:
            steps += (middles[i] - middles[i - 1]) ** 2
    return steps / (24.0 * squares)


@inlined
def four_in_contact(places: Records, i: int) -> bool:
    """Whether four strips from strip i on are all in contact."""
    return min(places[i].y, places[i + 1].y, places[i + 2].y, places[i + 3].y) > 0.0


@inlined
def weight_of(place: Record) -> float:
    """Weight Q a h of a strip in (strip-means): change of the complementary energy with its middle."""
    return place.q * sqrt(place.y) * (place.hi - place.lo)


@kernel
def set_middles(system: System, n: int, g: int) -> None:
    """Residuals (strip-means) of the line that the middles of a grid's strips lie on."""
    total = 0.0
    out = system.vectors[V.F, edges_of(n, g) + EDGES :]
    out[:MIDDLES] = 0.0
    for i in range(g * n, (g + 1) * n):
        place = system.places[i]
        if place.y > 0.0:
            weight = weight_of(place)
            total += weight
            out[0] += weight * place.tilt
            out[1] += weight * place.tilt * place.z
    for k in range(MIDDLES):
        out[k] /= total
    system.grids[g].weight = total


@inlined
def edge_residual(places: Records, first: int, n: int, side: int) -> float:
    """Residual of (strip-edges): positive where the edge should go out.

    A contact drawn too narrow carries a punch's singular pressure in its outer strip, one drawn too wide would have to
    pull there.
    """
    outer = places[first if side == 0 else first + n - 1]
    inner = places[first + 1 if side == 0 else first + n - 2]
    w0, w1 = outer.hi - outer.lo, inner.hi - inner.lo
    return outer.q * outer.q * outer.y / max(inner.q * inner.q * inner.y, 1e-30) - EDGE_RATIO * w0 / (2.0 * w0 + w1)
