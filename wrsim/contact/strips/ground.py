"""What grids are laid over: lobes, parts of them, or several that are nearly one.

Neighbouring lobes and shoulders of a lobe share a grid where the ground between them is hardly lower than the chord
over it, the concave hull of d(s); where it is lower they have grids of their own, which end where d over the hull is
least. So a hump that comes into contact beyond a gap has its own strips and edges, and its force grows from nothing.
All this belongs to the pose alone.

A yawed wheel touches its rail along the contact locus, a curve that runs ahead of the axle where the profile climbs.
Where it does not, all strips have one middle, and their third condition holds by symmetry.
"""

from math import sqrt

from wrsim.contact.overlap_patch import first_step
from wrsim.contact.records import STATUS_PROFILE_END
from wrsim.contact.search.lobes import LEAST_ROOM, WIDEST, room_beside
from wrsim.contact.strips.equations import set_fading
from wrsim.contact.strips.grid import find_end, grade_rows, lay_rows, make_room, next_corner
from wrsim.contact.strips.records import ROWS, V
from wrsim.jit.compiling import inlined, kernel

GATHERED = 0.5  # saddle over the depth of the shallower lobe from which on their ground is looked at as one
MERGED = 0.85  # least d over the concave hull where humps share a grid
LOW = 0.05  # of the deepest penetration: lower ground does not touch
CHAINED = 0.0, 0.2  # saddle over the shallower depth: none and all of what reaches one lobe reaches the other
FAINT = 3e-3  # spread of the shifts over the half length below which they do not matter: it acts by its square


@kernel
def set_grids(system, found, wheel, rail, pose, count):
    """Grids over all lobes, their bounds and rows. Returns a status."""
    memo = system.memo[0]
    status = 0
    memo.grids = 0
    memo.deepest = 1e-12
    i = 0
    while i < count:
        first = memo.grids
        grid = system.grids[first]
        limit = max(found[i].arc_rail - system.grids[first - 1].most, LEAST_ROOM) if first > 0 else WIDEST
        way, beyond = _end_of(wheel, rail, found[i], -1.0, limit)
        grid.least = found[i].arc_rail - way
        status |= STATUS_PROFILE_END if beyond else 0
        last = i
        while True:
            while last < count - 1 and found[last].saddle > GATHERED * min(found[last].depth, found[last + 1].depth):
                last += 1
            limit = room_beside(found, last, count)[1]
            apart = last < count - 1 and found[last].saddle < 0.0
            if apart:
                limit = found[last + 1].arc_rail - found[last].arc_rail
            way, beyond = _end_of(wheel, rail, found[last], 1.0, limit)
            if not (apart and way >= limit):
                break
            last += 1  # the gap before the next lobe is narrower than a step of the walk: the ground goes on
        grid.most = found[last].arc_rail + way
        status |= STATUS_PROFILE_END if beyond else 0
        grid.arc, grid.place = found[i].arc_wheel, found[i].arc_rail
        lay_rows(wheel, rail, grid, system.rows[first])
        _set_saddles(found, i, last, system.rows[first])
        room = system.grids.size - first - (count - 1 - last)
        memo.grids += _part(system, first, min(last - i + 2, room))
        for g in range(first, memo.grids):
            grid, rows = system.grids[g], system.rows[g]
            grid.first, grid.last = i, last
            if memo.grids > first + 1:
                lay_rows(wheel, rail, grid, rows)
            grade_rows(grid, rows, pose.axle)
            memo.deepest = max(memo.deepest, grid.deepest)
            _set_main_place(grid, rows)
        for g in range(first, memo.grids - 1):
            grid, other = system.grids[g], system.grids[g + 1]
            grid.chain = _rise(system.rows[g, ROWS - 1].d / min(grid.deepest, other.deepest), CHAINED)
        grid = system.grids[memo.grids - 1]
        grid.chain = 0.0
        if last < count - 1:
            grid.chain = _rise(found[last].saddle / min(found[last].depth, found[last + 1].depth), CHAINED)
        i = last + 1
    set_fading(system, 1.0)
    _set_shifts(system)
    return status


@kernel
def _set_saddles(found, first, last, rows):
    """Places of saddles that the search has not seen, where ground goes on over a gap: its lowest row."""
    for i in range(first, last):
        if found[i].saddle < 0.0:
            found[i].saddle_arc = 0.5 * (found[i].arc_rail + found[i + 1].arc_rail)
            lowest = found[i].depth
            for r in range(ROWS):
                if found[i].arc_rail < rows[r].s < found[i + 1].arc_rail and rows[r].d < lowest:
                    found[i].saddle_arc, lowest = rows[r].s, rows[r].d


@inlined
def _rise(x, ends):
    """From 0 to 1 between two ends, smoothly."""
    t = min(max((x - ends[0]) / (ends[1] - ends[0]), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


@kernel
def _set_shifts(system):
    """Whether shifts along the rail matter."""
    memo, grids = system.memo[0], system.grids
    matter = 0
    for g in range(memo.grids):
        grid, rows = grids[g], system.rows[g]
        total = mean = square = 0.0
        for r in range(ROWS):
            d = max(rows[r].d, 1e-30)
            total += d
            mean += d * rows[r].x
            square += d * rows[r].x * rows[r].x
        if square * total - mean * mean > (FAINT * grid.reach * total) ** 2:
            matter = 1
        for h in range(g):
            if abs(grid.x - grids[h].x) > FAINT * grid.reach and system.vectors[V.FADING, g * memo.grids + h] > 0.0:
                matter = 1
    if matter != memo.shifted:
        memo.shifted = matter
        memo.inverted = 0


@inlined
def _end_of(wheel, rail, lobe, direction, limit):
    """How far the overlap reaches from a lobe's main point, and whether to the end of a profile."""
    step = first_step(lobe.depth, lobe.curvature)
    return find_end(wheel, rail, lobe.arc_wheel, lobe.arc_rail, lobe.depth, step, direction, limit)


@inlined
def _set_main_place(grid, rows):
    """Shift along the rail and half length of the overlap where a grid is deepest."""
    main = 0
    for r in range(1, ROWS):
        main = r if rows[r].d > rows[main].d else main
    grid.x, grid.reach = rows[main].x, sqrt(2.0 * max(rows[main].d, 0.0) * rows[main].r_t)


@kernel
def _part(system, first, most):
    """Part the ground of a grid where it lies low between two humps, into ``most`` parts or fewer; bounds and a pair of
    opposite points to ``grids`` from it on. Returns the number of parts."""
    grids, rows = system.grids, system.rows[first]
    least, h, deepest = grids[first].least, grids[first].spacing, grids[first].deepest
    parts = 1
    k = first
    while k < first + parts and parts < most:
        start = int((grids[k].least - least) / h + 0.999)
        end = min(int((grids[k].most - least) / h + 0.001), ROWS - 1)
        at, bond = _find_waist(rows, start, end, deepest)
        if bond >= MERGED:
            k += 1
            continue
        make_room(grids, k, first + parts)
        grids[k + 1].least = grids[k].most = least + h * at
        parts += 1
    for k in range(first, first + parts if parts > 1 else first):
        middle = min(max(int((0.5 * (grids[k].least + grids[k].most) - least) / h + 0.5), 0), ROWS - 1)
        grids[k].arc, grids[k].place = rows[middle].arc, rows[middle].s
    return parts


@inlined
def _over_hull(rows, p, steep, r):
    """Penetration at a row over its concave hull, which rises by ``steep`` a row from row p on."""
    return rows[r].d / (rows[p].d + steep * (r - p))


@kernel
def _crest(rows, first, last, none):
    """The highest local maximum of the penetration between two rows; ``none`` if there is none."""
    crest = none
    for r in range(first + 1, last):
        if rows[r - 1].d < rows[r].d >= rows[r + 1].d and (crest == none or rows[r].d > rows[crest].d):
            crest = r
    return crest


@kernel
def _find_waist(rows, first, last, deepest):
    """Between two rows: where the penetration over its concave hull is least between two humps, in rows, and how much
    it is, 1.0 where there are no two humps."""
    least, at = 1.0, 0.0
    if not _may_have_two(rows, first, last, LOW * deepest):
        return at, least
    p = first
    while p < last:
        q, steep = next_corner(rows, p, last, 1)
        # a hump may lie below the chord to low ground or to an end
        start = p if p > first and rows[p].d > LOW * deepest else _crest(rows, p, q, last)
        end = q if q < last and rows[q].d > LOW * deepest else _crest(rows, p, q, first)
        if start < end and min(rows[start].d, rows[end].d) > LOW * deepest:
            steep = (rows[end].d - rows[start].d) / (end - start)
            for r in range(start + 1, end):
                ratio = _over_hull(rows, start, steep, r)
                if ratio < least:
                    before, after = _over_hull(rows, start, steep, r - 1), _over_hull(rows, start, steep, r + 1)
                    bend = before + after - 2.0 * ratio
                    at = r + min(max(0.5 * (before - after) / bend, -0.5), 0.5) if bend > 0.0 else float(r)
                    least = ratio
        p = q
    return at, least


@inlined
def _may_have_two(rows, first, last, level):
    """Whether the penetration bends down, up, and down again beyond a level."""
    down = up = again = False
    for r in range(first + 1, last):
        if rows[r].d > level:
            bend = rows[r - 1].d + rows[r + 1].d - 2.0 * rows[r].d
            again = again or (up and bend < 0.0)
            up = up or (down and bend > 0.0)
            down = down or bend < 0.0
    return again
