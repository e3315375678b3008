"""Whether strips lie apart along the rail.

A yawed wheel touches its rail along the contact locus, a curve that runs ahead of the axle where the profile climbs.
Where it does not, all strips have one middle, and their third condition holds by symmetry.
"""

from wrsim.core.contact.strips.records import FADING, ROWS
from wrsim.core.jit.compiling import inlined, kernel

CALM = 0.15  # weight that holds a^2 on a parabola where strips lie far shifted against one another
FAINT = 3e-3  # spread of the shifts over the half length below which they do not matter: it acts by its square


@inlined
def rise(x, ends):
    """From 0 to 1 between two ends, smoothly."""
    t = min(max((x - ends[0]) / (ends[1] - ends[0]), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


@kernel
def set_shifts(system):
    """Whether shifts along the rail matter."""
    memo, grids = system.memo[0], system.grids
    matter = 0
    for g in range(memo.grids):
        grid, rows = grids[g], system.rows[g]
        total = mean = square = 0.0
        for r in range(ROWS):
            d = max(rows[r].d, 0.0)
            total += d
            mean += d * rows[r].x
            square += d * rows[r].x * rows[r].x
        mean /= max(total, 1e-30)
        slant = max(square / max(total, 1e-30) - mean * mean, 0.0) / (grid.reach * grid.reach)
        grid.calm = CALM * slant / (1.0 + slant)
        if slant > FAINT * FAINT:
            matter = 1
        for h in range(g):
            if abs(grid.x - grids[h].x) > FAINT * grid.reach and system.vectors[FADING, g * memo.grids + h] > 0.0:
                matter = 1
    if matter != memo.shifted:
        memo.shifted = matter
        memo.inverted = 0
