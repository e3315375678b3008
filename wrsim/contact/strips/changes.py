"""Strips, edges and grids of the strip model that come into contact and leave it: what changes the equations."""

from wrsim.contact.strips.equations import (
    block_of,
    displacements,
    edge_residual,
    edges_of,
    hold_edges,
    is_held,
    place_strips,
    set_conditions,
)
from wrsim.contact.strips.hertz import hertz_ellipse
from wrsim.contact.strips.records import EDGES, MIDDLES, ROWS, UNKNOWNS_PER_STRIP, System, V
from wrsim.jit import Array, inlined, kernel
from wrsim.jit.dense import copy

ENTRY_OVERLAP = 1e-6  # overlap at which a strip enters, over the deepest penetration
MIN_STRIPS = 3  # strips in contact below which a grid leaves
ACTIVATION_OVERLAP = 1e-3  # overlap at which a grid comes into contact, over the deepest penetration
DEACTIVATION_SIZE = 4e-4  # a^2/R_x at which it leaves, over the same
CONTACT_LEVEL = 0.45  # overlap, over its largest, about where contact ends


@kernel
def deactivate_grid(system: System, n: int, g: int) -> None:
    """Take a grid out of contact."""
    system.grids[g].active = 0
    system.vectors[V.X, g * block_of(n) : g * block_of(n) + n] = 0.0


@kernel
def in_contact(squares: Array) -> tuple[int, int, int]:
    """First and last strip in contact, -1 where there is none, and how many there are; squares: a^2 of a grid."""
    first = last = -1
    count = 0
    for j in range(squares.shape[0]):
        if squares[j] > 0.0:
            first = j if first < 0 else first
            last = j
            count += 1
    return first, last, count


@kernel
def trim_edges(system: System, n: int, g: int) -> bool:
    """Draw the edges of a grid in to its outer strips in contact. True if anything changed.

    With fewer than MIN_STRIPS strips, or hardly pressed ones, the grid leaves.
    """
    memo, grid, places = system.memo[0], system.grids[g], system.places[g * n : (g + 1) * n]
    base = g * block_of(n)
    x = system.vectors[V.X]
    first, last, count = in_contact(x[base : base + n])
    highest = 0.0
    for j in range(n):
        highest = max(highest, x[base + j] * places[j].curvature)
    if count < MIN_STRIPS or highest < DEACTIVATION_SIZE * memo.deepest:
        deactivate_grid(system, n, g)
        return True
    if first == 0 and last == n - 1:
        return False
    start = places[first].lo if first > 0 else grid.start
    end = places[last].hi if last < n - 1 else grid.end
    move_edges(system, n, g, start, end)
    return True


@kernel
def move_edges(system: System, n: int, g: int, start: float, end: float) -> None:
    """New edges for a grid; half lengths, factors and middles stay where they are, and beyond the old edges half
    lengths are half of the outer ones."""
    grid, places = system.grids[g], system.places[g * n : (g + 1) * n]
    base, e = g * block_of(n), edges_of(n, g)
    x, before = system.vectors[V.X], system.vectors[V.BEFORE]
    for j in range(n):
        places[j].gap = places[j].s  # scratch: the next residuals write gaps anew
    copy(UNKNOWNS_PER_STRIP * n, x[base:], before)
    middle, width = x[e] + x[e + 1], x[e + 1] - x[e]
    hold_edges(grid, start, end)
    x[e], x[e + 1] = max(start, grid.least), min(end, grid.most)
    move, stretch, middles = (x[e] + x[e + 1] - middle) / width, (x[e + 1] - x[e]) / width, x[e + EDGES :]
    middles[0] += move * middles[1]
    middles[1] *= stretch
    place_strips(system, n)
    for j in range(n):
        s = places[j].s
        c = 0
        while c < n - 2 and places[c + 1].gap < s:
            c += 1
        r = min(max((s - places[c].gap) / (places[c + 1].gap - places[c].gap), 0.0), 1.0)
        for kind in range(UNKNOWNS_PER_STRIP):
            x[base + kind * n + j] = before[kind * n + c] * (1.0 - r) + before[kind * n + c + 1] * r
        if s < places[0].gap or s > places[n - 1].gap:
            x[base + j] *= 0.5


@kernel
def carry_over(system: System, m: int, n: int) -> bool:
    """Lay the last contact of m strips a grid over other grids, or over n strips: between its strips half lengths and
    factors are read straight. False if none of the grids comes to lie under enough strips."""
    memo, places, v = system.memo[0], system.places, system.vectors
    x, s, start, end, squares, factors = v[V.X], v[V.BEFORE], v[V.NEXT], v[V.LAST_STEP], v[V.F], v[V.STEP]
    count = 0
    for i in range(memo.grids_before * m):
        base = i // m * block_of(m) + i % m
        if x[base] > 0.0:
            s[count], start[count], end[count] = places[i].s, places[i].lo, places[i].hi
            squares[count], factors[count] = x[base], x[base + m]
            count += 1
    for g in range(memo.grids):  # the same grids keep their middles
        for k in range(MIDDLES):
            old = x[edges_of(m, g) + EDGES + k] if memo.grids == memo.grids_before else 0.0
            start[count + g * MIDDLES + k] = old
    x[: memo.grids * block_of(n)] = 0.0
    memo.inverted = 0
    carried = False
    for g in range(memo.grids):
        grid, e = system.grids[g], edges_of(n, g)
        first, last = count, -1
        for c in range(count):
            if grid.least < s[c] < grid.most:
                first, last = min(first, c), c
        grid.active = int(last - first + 1 >= MIN_STRIPS)
        if grid.active:
            carried = True
            x[e], x[e + 1] = max(start[first], grid.least), min(end[last], grid.most)
            copy(MIDDLES, start[count + g * MIDDLES :], x[e + EDGES :])
            hold_edges(grid, x[e], x[e + 1])
    place_strips(system, n)
    for g in range(memo.grids):
        c = 0
        for j in range(n if system.grids[g].active else 0):
            place, base = places[g * n + j], g * block_of(n) + j
            while c < count - 2 and s[c + 1] < place.s:
                c += 1
            z = min(max((place.s - s[c]) / (s[c + 1] - s[c]), -0.5), 1.5)  # to the edges: half a strip beyond
            least = 0.1 * min(squares[c], squares[c + 1])
            x[base] = max(squares[c] + z * (squares[c + 1] - squares[c]), least)
            x[base + n] = factors[c] + min(max(z, 0.0), 1.0) * (factors[c + 1] - factors[c])
    return carried


@kernel
def activate(system: System, n: int) -> bool:
    """Let strips come into contact whose gap has closed, edges leave their bounds that should go in, and of the grids
    the one that overlaps most: it may press the others apart. True if there are any."""
    memo, places = system.memo[0], system.places
    x = system.vectors[V.X]
    changed = False
    for g in range(memo.grids):
        grid, base = system.grids[g], g * block_of(n)
        if not grid.active:
            continue
        for j in range(n):
            place = places[g * n + j]
            if x[base + j] > 0.0:
                continue
            set_conditions(system, n, g, j, 1)
            if place.gap < -ENTRY_OVERLAP:
                x[base + j] = -place.gap * memo.deepest / place.curvature
                changed = True
        for side in range(EDGES):
            if is_held(grid, side) and edge_residual(places, g * n, n, side) < 0.0:
                if side == 0:
                    grid.start_held = 0
                else:
                    grid.end_held = 0
                changed = True
    deepest, main = -1, 0
    most = 0.0
    for g in range(memo.grids if not memo.uncoupled else 0):
        if not system.grids[g].active:
            overlap, row = _largest_overlap(system, n, g)
            if overlap > most:
                deepest, main, most = g, row, overlap
    if deepest < 0:
        return changed
    _activate_grid(system, n, deepest, main)
    return True


@inlined
def _overlap(system: System, n: int, g: int, r: int) -> float:
    """Overlap of the bodies at a row: the penetration less the displacement (strip-sum) there [m]."""
    row = system.rows[g, r]
    x = row.x if system.memo[0].has_shifts else system.grids[g].x
    no, nb = (row.no, row.nb) if system.memo[0].curved else (0.0, 1.0)
    return row.d - displacements(system, n, g, row.s, x, 0.0, 1, no, nb).middle


@kernel
def _largest_overlap(system: System, n: int, g: int) -> tuple[float, int]:
    """Largest overlap of a grid out of contact [m], and its row; 0 where its gap has not closed."""
    memo, grid, rows = system.memo[0], system.grids[g], system.rows[g]
    # more each time, so that no grid comes and goes without end
    least = ACTIVATION_OVERLAP * (1.0 + grid.entries) * memo.deepest
    most, main = 0.0, 0
    for r in range(0, ROWS, 2):
        rows[r].overlap = _overlap(system, n, g, r) if rows[r].d > least else -1.0
        if rows[r].overlap > max(least, most):
            most, main = rows[r].overlap, r
    return most, main


@kernel
def _activate_grid(system: System, n: int, g: int, main: int) -> None:
    """Bring a grid into contact about the row where it overlaps most."""
    grid, rows = system.grids[g], system.rows[g]
    most = rows[main].overlap
    first = last = main
    while first - 2 >= 0 and rows[first - 2].overlap > CONTACT_LEVEL * most:
        first -= 2
    while last + 2 < ROWS and rows[last + 2].overlap > CONTACT_LEVEL * most:
        last += 2
    start = max(rows[first].s - 0.5 * grid.spacing, grid.least)
    end = min(rows[last].s + 0.5 * grid.spacing, grid.most)
    curvature, half = rows[main].curvature, 0.5 * (end - start)
    ratio = 2.0 * (1.0 - CONTACT_LEVEL) * most / (curvature * half * half)
    factor = hertz_ellipse(ratio, 0.0, most, curvature).factor
    initialise_grid(system, n, g, start, end, most, curvature, factor)
    grid.entries += 1


@kernel
def initialise_grid(
    system: System, n: int, g: int, start: float, end: float, depth: float, curvature: float, factor: float
) -> None:
    """First guess of a grid: a parabola of this depth between these edges. curvature: 1/R_x [1/m]; factor: k."""
    grid, x = system.grids[g], system.vectors[V.X]
    base, e = g * block_of(n), edges_of(n, g)
    grid.active = 1
    hold_edges(grid, start, end)
    for j in range(n):
        z = 2.0 * (j + 0.5) / n - 1.0
        x[base + j] = depth / curvature * (1.0 - z * z)
    x[base + n : base + 2 * n] = factor
    x[e], x[e + 1] = start, end
    x[e + EDGES : e + EDGES + MIDDLES] = 0.0
