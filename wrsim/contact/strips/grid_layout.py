"""Grids over lobes, parts of them, or several that are nearly one.

Neighbouring lobes and shoulders of a lobe share a grid where the penetration between them is hardly less than on the
chord over it, the concave hull of d(s); where it is less they have grids of their own, which end where d over the hull
is least. So a maximum that comes into contact beyond a gap has its own strips and edges, and its force grows from
nothing. All this belongs to the pose alone.
"""

from math import sqrt

from wrsim.contact.records import STATUS_PROFILE_END, WheelPose
from wrsim.contact.search.lobes import MIN_DISTANCE, WIDEST, distance_to_saddles
from wrsim.contact.strips.equations import set_fading
from wrsim.contact.strips.grid import find_end, grade_rows, sample_rows
from wrsim.contact.strips.records import ROWS, System, V
from wrsim.jit import Record, Records, inlined, kernel

SAME_OVERLAP = 0.5  # saddle over the depth of the shallower lobe from which on both belong to one overlap interval
MERGE_RATIO = 0.85  # least d over the concave hull where maxima share a grid
MIN_DEPTH = 0.05  # of the deepest penetration: where it is less nothing touches
COUPLING_RANGE = 0.0, 0.2  # saddle over the shallower depth: none and all of what reaches one lobe reaches the other
SHIFT_THRESHOLD = 3e-3  # spread of shifts over the half length below which they do not matter: it acts squared


@kernel
def set_grids(system: System, contacts: Records, pose: WheelPose, count: int) -> int:
    """Grids over all lobes, their bounds and rows. Returns a status."""
    memo, wheel, rail = system.memo[0], system.wheel, system.rail
    status = 0
    memo.grids = 0
    memo.deepest = 1e-12
    i = 0
    while i < count:
        first = memo.grids
        grid = system.grids[first]
        limit = max(contacts[i].arc_rail - system.grids[first - 1].most, MIN_DISTANCE) if first > 0 else WIDEST
        distance, beyond = find_end(wheel, rail, contacts[i], -1.0, limit)
        grid.least = contacts[i].arc_rail - distance
        status |= STATUS_PROFILE_END if beyond else 0
        last = i
        while True:
            while last < count - 1 and contacts[last].saddle > SAME_OVERLAP * _shallower(contacts, last):
                last += 1
            limit = distance_to_saddles(contacts, last, count)[1]
            apart = last < count - 1 and contacts[last].saddle < 0.0
            if apart:
                limit = contacts[last + 1].arc_rail - contacts[last].arc_rail
            distance, beyond = find_end(wheel, rail, contacts[last], 1.0, limit)
            if not (apart and distance >= limit):
                break
            last += 1  # the gap before the next lobe is narrower than a step of the walk: the overlap goes on
        grid.most = contacts[last].arc_rail + distance
        status |= STATUS_PROFILE_END if beyond else 0
        grid.arc_wheel, grid.arc_rail = contacts[i].arc_wheel, contacts[i].arc_rail
        sample_rows(wheel, rail, grid, system.rows[first], system.vectors[V.TERMS :])
        _set_saddles(contacts, i, last, system.rows[first])
        free = system.grids.size - first - (count - 1 - last)
        memo.grids += _divide(system, first, min(last - i + 2, free))
        for g in range(first, memo.grids):
            grid, rows = system.grids[g], system.rows[g]
            grid.first, grid.last = i, last
            if memo.grids > first + 1:
                sample_rows(wheel, rail, grid, rows, system.vectors[V.TERMS :])
            grade_rows(grid, rows, pose.axle)
            memo.deepest = max(memo.deepest, grid.deepest)
            _set_deepest_point(grid, rows)
        for g in range(first, memo.grids - 1):
            grid, following = system.grids[g], system.grids[g + 1]
            grid.coupling = _smooth_step(system.rows[g, ROWS - 1].d / min(grid.deepest, following.deepest))
        grid = system.grids[memo.grids - 1]
        grid.coupling = 0.0
        if last < count - 1:
            grid.coupling = _smooth_step(contacts[last].saddle / _shallower(contacts, last))
        i = last + 1
    set_fading(system, 1.0)
    _set_shifts(system)
    return status


@inlined
def _shallower(contacts: Records, i: int) -> float:
    """Depth of the shallower one of a lobe and the next."""
    return min(contacts[i].depth, contacts[i + 1].depth)


@kernel
def _set_saddles(contacts: Records, first: int, last: int, rows: Records) -> None:
    """Places of saddles that the search has not seen, where the overlap goes on over a gap: its lowest row."""
    for i in range(first, last):
        if contacts[i].saddle < 0.0:
            contacts[i].saddle_arc = 0.5 * (contacts[i].arc_rail + contacts[i + 1].arc_rail)
            lowest = contacts[i].depth
            for r in range(ROWS):
                if contacts[i].arc_rail < rows[r].s < contacts[i + 1].arc_rail and rows[r].d < lowest:
                    contacts[i].saddle_arc, lowest = rows[r].s, rows[r].d


@inlined
def _smooth_step(x: float) -> float:
    """The coupling of two neighbours in (strip-fading): from 0 to 1 over COUPLING_RANGE."""
    t = min(max((x - COUPLING_RANGE[0]) / (COUPLING_RANGE[1] - COUPLING_RANGE[0]), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


@kernel
def _set_shifts(system: System) -> None:
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
        threshold = SHIFT_THRESHOLD * grid.half_length
        if square * total - mean * mean > (threshold * total) ** 2:
            matter = 1
        for h in range(g):
            if abs(grid.x - grids[h].x) > threshold and system.vectors[V.FADING, g * memo.grids + h] > 0.0:
                matter = 1
    if matter != memo.has_shifts:
        memo.has_shifts = matter
        memo.inverted = 0


@inlined
def _set_deepest_point(grid: Record, rows: Records) -> None:
    """Shift along the rail and half length of the overlap where a grid is deepest."""
    main = 0
    for r in range(1, ROWS):
        main = r if rows[r].d > rows[main].d else main
    grid.x, grid.half_length = rows[main].x, sqrt(2.0 * max(rows[main].d, 0.0) * rows[main].r_t)


@kernel
def _divide(system: System, first: int, most: int) -> int:
    """Divide a grid where the penetration between two maxima is small, into ``most`` parts or fewer; bounds and a pair
    of opposite points to ``grids`` from it on. Returns the number of parts."""
    grids, rows = system.grids, system.rows[first]
    least, h, deepest = grids[first].least, grids[first].spacing, grids[first].deepest
    parts = 1
    k = first
    while k < first + parts and parts < most:
        start = int((grids[k].least - least) / h + 0.999)
        end = min(int((grids[k].most - least) / h + 0.001), ROWS - 1)
        boundary, ratio = _lowest_over_hull(rows, start, end, deepest)
        if ratio >= MERGE_RATIO:
            k += 1
            continue
        for later in range(first + parts, k, -1):
            grids[later].least, grids[later].most = grids[later - 1].least, grids[later - 1].most
        grids[k + 1].least = grids[k].most = least + h * boundary
        parts += 1
    for k in range(first, first + parts if parts > 1 else first):
        middle = min(max(int((0.5 * (grids[k].least + grids[k].most) - least) / h + 0.5), 0), ROWS - 1)
        grids[k].arc_wheel, grids[k].arc_rail = rows[middle].arc_wheel, rows[middle].s
    return parts


@kernel
def _set_corners(rows: Records, first: int, last: int) -> None:
    """Write to each row from first on the corner behind it of the concave hull of the penetration from there to row
    ``last`` (Andrew, Information Processing Letters 9 (1979) 216)."""
    for p in range(last - 1, first - 1, -1):
        q = p + 1
        while q < last:
            r = rows[q].corner
            if (rows[q].d - rows[p].d) * (r - q) > (rows[r].d - rows[q].d) * (q - p):
                break
            q = r
        rows[p].corner = q


@inlined
def _over_hull(rows: Records, p: int, steep: float, r: int) -> float:
    """Penetration at a row over its concave hull, which rises by ``steep`` a row from row p on."""
    return rows[r].d / (rows[p].d + steep * (r - p))


@kernel
def _highest_maximum(rows: Records, first: int, last: int, none: int) -> int:
    """The highest local maximum of the penetration between two rows; ``none`` if there is none."""
    highest = none
    for r in range(first + 1, last):
        if rows[r - 1].d < rows[r].d >= rows[r + 1].d and (highest == none or rows[r].d > rows[highest].d):
            highest = r
    return highest


@kernel
def _lowest_over_hull(rows: Records, first: int, last: int, deepest: float) -> tuple[float, float]:
    """Between two rows: where the penetration over its concave hull is least between two local maxima, in rows, and how
    much it is, 1.0 where there are no two maxima."""
    least, place = 1.0, 0.0
    if not _has_two_maxima(rows, first, last, MIN_DEPTH * deepest):
        return place, least
    _set_corners(rows, first, last)
    p = first
    while p < last:
        q = rows[p].corner
        # a maximum may lie below the chord to rows that do not touch, or to an end
        start = p if p > first and rows[p].d > MIN_DEPTH * deepest else _highest_maximum(rows, p, q, last)
        end = q if q < last and rows[q].d > MIN_DEPTH * deepest else _highest_maximum(rows, p, q, first)
        if start < end and min(rows[start].d, rows[end].d) > MIN_DEPTH * deepest:
            steep = (rows[end].d - rows[start].d) / (end - start)
            for r in range(start + 1, end):
                ratio = _over_hull(rows, start, steep, r)
                if ratio < least:
                    before, after = _over_hull(rows, start, steep, r - 1), _over_hull(rows, start, steep, r + 1)
                    bend = before + after - 2.0 * ratio
                    place = r + min(max(0.5 * (before - after) / bend, -0.5), 0.5) if bend > 0.0 else float(r)
                    least = ratio
        p = q
    return place, least


@inlined
def _has_two_maxima(rows: Records, first: int, last: int, level: float) -> bool:
    """Whether the penetration bends down, up, and down again beyond a level."""
    down = up = twice = False
    for r in range(first + 1, last):
        if rows[r].d > level:
            bend = rows[r - 1].d + rows[r + 1].d - 2.0 * rows[r].d
            twice = twice or (up and bend < 0.0)
            up = up or (down and bend > 0.0)
            down = down or bend < 0.0
    return twice
