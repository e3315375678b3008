"""Strips, edges and grids of the strip model that come into contact and leave it: what changes the equations."""

from wrsim.contact.strips.equations import block_of, edge_wish, lay_strips, pressed, set_conditions
from wrsim.contact.strips.hertz import hertz_ellipse
from wrsim.contact.strips.records import EDGES, MIDDLES, OF_A_STRIP, ROWS, V
from wrsim.jit.compiling import inlined, kernel
from wrsim.jit.dense import copy

ENTRY = 1e-6  # closing of a gap at which a strip enters, over the deepest penetration
FEWEST = 3  # strips in contact below which a grid leaves
RETURN, LEAVE = 1e-3, 4e-4  # closing at which a grid comes into contact; a^2/R_x at which it leaves; over the deepest
HUMP = 0.45  # closing, over its largest, about where contact ends


@kernel
def leave(system, n, g):
    """Take a grid out of contact."""
    system.grids[g].on = 0
    system.vectors[V.X, g * block_of(n) : g * block_of(n) + n] = 0.0


@kernel
def in_contact(squares):
    """First and last strip in contact, -1 where there is none, and how many there are; squares: a^2 of a grid's."""
    first = last = -1
    count = 0
    for j in range(squares.shape[0]):
        if squares[j] > 0.0:
            first = j if first < 0 else first
            last = j
            count += 1
    return first, last, count


@kernel
def trim(system, n, g):
    """Draw the edges of a grid in to its outer strips in contact. True if anything changed.

    With fewer than FEWEST strips, or hardly pressed ones, the grid leaves.
    """
    memo, grid, places = system.memo[0], system.grids[g], system.places[g * n : (g + 1) * n]
    base = g * block_of(n)
    x = system.vectors[V.X]
    first, last, count = in_contact(x[base : base + n])
    highest = 0.0
    for j in range(n):
        highest = max(highest, x[base + j] * places[j].bend)
    if count < FEWEST or highest < LEAVE * memo.deepest:
        leave(system, n, g)
        return True
    if first == 0 and last == n - 1:
        return False
    start = places[first].lo if first > 0 else grid.start
    end = places[last].hi if last < n - 1 else grid.end
    move_edges(system, n, g, start, end)
    return True


@kernel
def move_edges(system, n, g, start, end):
    """New edges for a grid; half lengths, factors and middles stay where they are, ground that is new has half of the
    half lengths beside it."""
    grid, places = system.grids[g], system.places[g * n : (g + 1) * n]
    base = g * block_of(n)
    x, saved = system.vectors[V.X], system.vectors[V.STEP]
    for j in range(n):
        places[j].gap = places[j].s
    copy(OF_A_STRIP * n, x[base:], saved)
    e = base + OF_A_STRIP * n
    middle, width = x[e] + x[e + 1], x[e + 1] - x[e]
    grid.start_held, grid.end_held = int(start <= grid.least), int(end >= grid.most)
    x[e], x[e + 1] = max(start, grid.least), min(end, grid.most)
    move, stretch, middles = (x[e] + x[e + 1] - middle) / width, (x[e + 1] - x[e]) / width, x[e + EDGES :]
    middles[0] += move * middles[1]
    middles[1] *= stretch
    lay_strips(system, n)
    for j in range(n):
        s = places[j].s
        c = 0
        while c < n - 2 and places[c + 1].gap < s:
            c += 1
        r = min(max((s - places[c].gap) / (places[c + 1].gap - places[c].gap), 0.0), 1.0)
        for kind in range(OF_A_STRIP):
            x[base + kind * n + j] = saved[kind * n + c] * (1.0 - r) + saved[kind * n + c + 1] * r
        if s < places[0].gap or s > places[n - 1].gap:
            x[base + j] *= 0.5


@kernel
def enter(system, n):
    """Strips that come into contact, edges that leave their bounds, and of the grids the one whose gap has closed most:
    it may press the others apart. True if there are any."""
    memo, places = system.memo[0], system.places
    x = system.vectors[V.X]
    block = block_of(n)
    changed = False
    for g in range(memo.grids):
        grid, base = system.grids[g], g * block
        if not grid.on:
            continue
        for j in range(n):
            place = places[g * n + j]
            if x[base + j] > 0.0:
                continue
            set_conditions(system, n, g, j, 1)
            if place.gap < -ENTRY:
                x[base + j] = -place.gap * memo.deepest / place.bend
                changed = True
        for side in range(EDGES):
            if (grid.start_held if side == 0 else grid.end_held) and edge_wish(places, g * n, n, side) < 0.0:
                if side == 0:
                    grid.start_held = 0
                else:
                    grid.end_held = 0
                changed = True
    deepest, main = -1, 0
    most = 0.0
    for g in range(memo.grids if not memo.alone else 0):
        if not system.grids[g].on:
            closing, row = _largest_closing(system, n, g)
            if closing > most:
                deepest, main, most = g, row, closing
    if deepest < 0:
        return changed
    _grid_enters(system, n, deepest, main)
    return True


@inlined
def _closing(system, n, g, r):
    """How far the bodies would overlap at a row, over what all strips press them down there [m]."""
    row = system.rows[g, r]
    x = row.x if system.memo[0].shifted else system.grids[g].x
    no, nb = (row.no, row.nb) if system.memo[0].curved else (0.0, 1.0)
    return row.d - pressed(system, n, g, row.s, x, 0.0, 1, no, nb).middle


@kernel
def _largest_closing(system, n, g):
    """Largest closing of a grid out of contact [m], and its row; 0 where its gap has not closed."""
    memo, grid, rows = system.memo[0], system.grids[g], system.rows[g]
    least = RETURN * (1.0 + grid.entries) * memo.deepest  # more each time, so that no grid comes and goes without end
    most, main = 0.0, 0
    for r in range(0, ROWS, 2):
        rows[r].closing = _closing(system, n, g, r) if rows[r].d > least else -1.0
        if rows[r].closing > max(least, most):
            most, main = rows[r].closing, r
    return most, main


@kernel
def _grid_enters(system, n, g, main):
    """A grid comes into contact about the row where its gap has closed most."""
    grid, rows = system.grids[g], system.rows[g]
    most = rows[main].closing
    first = last = main
    while first - 2 >= 0 and rows[first - 2].closing > HUMP * most:
        first -= 2
    while last + 2 < ROWS and rows[last + 2].closing > HUMP * most:
        last += 2
    start = max(rows[first].s - 0.5 * grid.spacing, grid.least)
    end = min(rows[last].s + 0.5 * grid.spacing, grid.most)
    bend, half = rows[main].bend, 0.5 * (end - start)
    factor = hertz_ellipse(2.0 * (1.0 - HUMP) * most / (bend * half * half), 0.0, most, bend).factor
    begin_grid(system, n, g, start, end, most, bend, factor)
    grid.entries += 1


@kernel
def begin_grid(system, n, g, start, end, depth, bend, factor):
    """First guess of a grid: a hump of this depth between these edges. bend: 1/R_x [1/m];
    factor: of all strips."""
    grid, x = system.grids[g], system.vectors[V.X]
    base = g * block_of(n)
    grid.on = 1
    grid.start_held, grid.end_held = int(start <= grid.least), int(end >= grid.most)
    for j in range(n):
        z = 2.0 * (j + 0.5) / n - 1.0
        x[base + j] = depth / bend * (1.0 - z * z)
    x[base + n : base + 2 * n] = factor
    e = base + OF_A_STRIP * n
    x[e], x[e + 1] = start, end
    x[e + EDGES : e + EDGES + MIDDLES] = 0.0
