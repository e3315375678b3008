"""The last contact of a run as the first guess where the grids are others now."""

from wrsim.core.contact.strips.changes import FEWEST
from wrsim.core.contact.strips.equations import block_of, lay_strips
from wrsim.core.contact.strips.records import LAST, NEXT, OF_A_STRIP, SAVED, STEP, TERMS, X
from wrsim.core.jit.compiling import kernel


@kernel
def carry_over(system, n):
    """Unknowns of the grids by their places on the rail, from the last call's of other grids.
    Returns whether any is in contact.

    Places, unknowns and state of the grids still are those of the last call, their bounds new.
    """
    memo, x, grids = system.memo[0], system.vectors[X], system.grids
    block = block_of(n)
    old_s, old_w = system.vectors[SAVED], system.vectors[LAST]
    old_y, old_k, old_off = system.vectors[STEP], system.vectors[NEXT], system.vectors[TERMS]
    count = 0
    for g in range(memo.known):
        own = g * block
        for j in range(n):
            place = system.places[g * n + j]
            if grids[g].on and x[own + j] > 0.0:
                old_s[count], old_w[count] = place.s, place.hi - place.lo
                old_y[count], old_k[count] = x[own + j], x[own + n + j]
                old_off[count] = x[own + 2 * n + j]
                count += 1
    found = False
    for g in range(memo.grids):
        grid, base = grids[g], g * block
        x[base : base + block] = 0.0
        grid.on = grid.start_held = grid.end_held = 0
        first = last = -1
        for i in range(count):
            if grid.least < old_s[i] < grid.most:
                first = i if first < 0 else first
                last = i
        if first < 0 or last - first + 1 < FEWEST:
            continue
        found = True
        start = max(old_s[first] - 0.5 * old_w[first], grid.least)
        end = min(old_s[last] + 0.5 * old_w[last], grid.most)
        grid.on, grid.start_held, grid.end_held = 1, int(start <= grid.least), int(end >= grid.most)
        x[base + OF_A_STRIP * n], x[base + OF_A_STRIP * n + 1] = start, end
    lay_strips(system, n)
    for g in range(memo.grids):
        for j in range(n if grids[g].on else 0):
            s, own = system.places[g * n + j].s, g * block + j
            i = _before(old_s, count, s)
            apart = old_s[min(i + 1, count - 1)] - old_s[i] > 0.75 * (old_w[i] + old_w[min(i + 1, count - 1)])
            x[own] = 0.0 if apart else _between(old_s, old_y, count, i, s)
            x[own + n], x[own + 2 * n] = _between(old_s, old_k, count, i, s), _between(old_s, old_off, count, i, s)
    return found


@kernel
def _before(places, count, s):
    """Number of the last place but one that is not beyond s."""
    i = 0
    while i < count - 2 and places[i + 1] < s:
        i += 1
    return i


@kernel
def _between(places, values, count, i, s):
    """Value at s between places i and i + 1."""
    if count < 2:
        return values[0]
    r = min(max((s - places[i]) / max(places[i + 1] - places[i], 1e-12), 0.0), 1.0)
    return (1.0 - r) * values[i] + r * values[i + 1]
