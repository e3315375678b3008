"""Normal pressure on strips that follow the bodies at three points each (docs/theory/strip_model.md).

Every strip carries a semi-ellipse (strip-pressure), as in Kik-Piotrowski, but with an amplitude, a half length and a
middle along the rail of its own. The displacement (strip-sum) meets the gap of the undeformed bodies at three points of
each strip in contact (strip-points), where the derivatives of the complementary energy vanish; middles of a grid lie on
a line over the contact locus (strip-means), and its edges follow from (strip-edges). Strips that would have to pull
carry nothing. s is the rail's arclength, and the distance of two strips is counted along it.

Lobes that are nearly one share a grid of strips, a lobe with a shoulder may have two (`grid_layout`). After the
solution grids are cut at the saddles, so every lobe has its strips and no result jumps where grids merge.
"""

from math import inf, pi, sqrt

from wrsim.contact.records import COLD_START, STATUS_COARSE, STATUS_NOT_CONVERGED, PlacedWheel, Rail, WheelPose
from wrsim.contact.resultants import set_creepages, set_pressures
from wrsim.contact.strips.equations import clamp_edges, edges_of
from wrsim.contact.strips.grid import opposite, row_below
from wrsim.contact.strips.grid_layout import set_grids
from wrsim.contact.strips.records import ROWS, System, V
from wrsim.contact.strips.solution import solve, step_price
from wrsim.jit import Record, Records, inlined, kernel

MAX_EXCESS = 1 / 54  # of a strip's pressure over that of the surface: Hertz' on three strips, the least with a bend
SAME_GRID = 0.5  # of the last contact within a grid's new bounds that makes it the same grid


@kernel
def solve_pressure(
    system: System, model: Record, state: Record, pose: WheelPose, contacts: Records, lobes: Records,
    strips: Records, count: int,
) -> int:  # fmt: skip
    """Pressures of all lobes, with damping. Returns a status: STATUS_NOT_CONVERGED and no strips where there is no
    solution."""
    memo, n = system.memo[0], model.strips
    if state.start == COLD_START and memo.traction_pass == 0:
        memo.grids_before = 0
    for i in range(count):
        _set_main_point(system.wheel, system.rail, lobes[i])
    memo.modulus = model.E
    memo.together, memo.apart = model.together, model.apart
    memo.stiffness = pi * model.E
    memo.curved = model.curved
    memo.transverse = model.E / model.G - 1.0
    if memo.traction_pass > 0:
        _set_lateral_forces(system, strips)
    status = set_grids(system, contacts, pose, count)
    memo.all_strips = n
    known = memo.grids_before > 0 and _same_grids(system, memo.laid)
    memo.strips = solve(system, n, known, state.tolerance)
    status |= STATUS_COARSE if memo.left > 0.0 or (memo.strips < n and memo.budget < inf) else 0
    goes_on = memo.strips == memo.laid or memo.left > 0.0
    memo.grids_before = memo.grids if goes_on else 0
    memo.reserve = step_price(system, n // 2)
    for i in range(count):
        lobes[i].n_strips = 0
    if memo.strips == 0:
        memo.substitutes += 1
        return status | STATUS_NOT_CONVERGED
    for g in range(memo.grids):
        _assign_to_lobes(system, memo.strips, g, contacts, lobes, strips)
    for i in range(count):
        _set_results(model, pose, lobes[i], strips[i])
    return status


@kernel
def _set_lateral_forces(system: System, strips: Records) -> None:
    """Lateral creep forces over normal forces of the strips of the last solution of this call, to its grids' rows: the
    next one may have other strips, or fewer."""
    n = system.memo[0].strips
    for g in range(system.memo[0].grids):
        rows, r, last, s = system.rows[g], 0, inf, 0.0
        for i in range(g * n, (g + 1) * n):
            place = system.places[i]
            if place.y <= 0.0:
                continue
            strip = strips[place.lobe, place.row]
            side = strip.Fy / strip.N if strip.N > 0.0 else 0.0
            last = side if last == inf else last  # before the first strip as in it
            while r < ROWS and rows[r].s < place.s:
                rows[r].side = last + (side - last) * max((rows[r].s - s) / (place.s - s), 0.0)
                r += 1
            last, s = side, place.s
        while r < ROWS:
            rows[r].side = last if last < inf else 0.0
            r += 1


@kernel
def _set_main_point(wheel: PlacedWheel, rail: Rail, lobe: Record) -> None:
    """Place of a lobe's main point, and the half length of the overlap there."""
    pair = opposite(wheel, rail, lobe.arc_wheel, lobe.arc_rail)
    lobe.x, lobe.o, lobe.b = pair.x, pair.o, pair.b
    lobe.half_length = sqrt(2.0 * max(pair.d, 0.0) * pair.r_t)


@kernel
def _same_grids(system: System, n: int) -> bool:
    """Whether the unknowns of the last call suit the grids as they are; edges are brought within the bounds."""
    memo, x = system.memo[0], system.vectors[V.X]
    if memo.grids_before != memo.grids:
        return False
    for g in range(memo.grids):
        grid, e = system.grids[g], edges_of(n, g)
        if not grid.active:
            continue
        common = min(x[e + 1], grid.most) - max(x[e], grid.least)
        if common < SAME_GRID * (x[e + 1] - x[e]):
            return False
        if clamp_edges(grid, x, e):
            memo.inverted = 0
    return True


@kernel
def _assign_to_lobes(system: System, n: int, g: int, contacts: Records, lobes: Records, strips: Records) -> None:
    """Assign the strips of a grid in contact to its lobes, cut at the saddles between them."""
    grid, rows = system.grids[g], system.rows[g]
    if not grid.active:
        return
    for i in range(grid.first, grid.last + 1):
        lobe = lobes[i]
        least = contacts[i - 1].saddle_arc if i > grid.first else grid.least
        most = contacts[i].saddle_arc if i < grid.last else grid.most
        for j in range(n):
            place = system.places[g * n + j]
            lo, hi = max(place.lo, least), min(place.hi, most)
            if place.y <= 0.0 or hi <= lo:
                continue
            place.lobe, place.row = i, lobe.n_strips
            strip = strips[i, lobe.n_strips]
            lobe.n_strips += 1
            s = 0.5 * (lo + hi)
            r, z = row_below(grid, s)
            below, above = rows[r], rows[r + 1]
            strip.s = s - lobe.arc_rail
            strip.ds = hi - lo
            strip.a = sqrt(place.y)
            strip.p = place.q
            strip.x = below.x + z * (above.x - below.x) + place.off
            strip.o = below.o + z * (above.o - below.o)
            strip.b = below.b + z * (above.b - below.b)
            no = below.no + z * (above.no - below.no)
            nb = below.nb + z * (above.nb - below.nb)
            inverse = 1.0 / sqrt(no * no + nb * nb)
            strip.no, strip.nb = no * inverse, nb * inverse
            strip.slope = below.slope + z * (above.slope - below.slope)
            strip.r_t = 1.0 / place.curvature
            strip.penetration = below.d + z * (above.d - below.d)


@kernel
def _set_results(model: Record, pose: WheelPose, lobe: Record, strips: Records) -> None:
    """Damping, forces of the strips, and what a lobe reports. The strips' p comes as amplitude and goes as pressure."""
    n = lobe.n_strips
    set_creepages(pose, model, lobe, strips, n)
    factor = max(1.0 + model.damping * lobe.closing, 0.0)
    largest, lobe.N, lobe.area, longest = set_pressures(strips, n, factor)
    lobe.p0 = _peak_pressure(strips, n, largest)
    lobe.start = strips[0].s - 0.5 * strips[0].ds if n > 0 else 0.0
    lobe.end = strips[n - 1].s + 0.5 * strips[n - 1].ds if n > 0 else 0.0
    lobe.width = lobe.end - lobe.start
    lobe.length = 2.0 * longest
    lobe.amplitude = lobe.p0 / longest if longest > 0.0 else 0.0


@inlined
def _surface_pressure(strips: Records, n: int, i: int) -> float:
    """Pressure in the middle of strip i: that of the strip less what its even spread takes (strip-peak)."""
    p = strips[i].p
    if i == 0 or i == n - 1:
        return p
    left, middle, right = strips[i - 1], strips[i], strips[i + 1]
    slope = (right.p - p) / (right.s - middle.s) - (p - left.p) / (middle.s - left.s)
    excess = max(-slope / (right.s - left.s), 0.0) * middle.ds * middle.ds / (12.0 * max(p, 1e-30))
    return p * (1.0 - excess / (1.0 + excess / MAX_EXCESS))


@kernel
def _peak_pressure(strips: Records, n: int, largest: float) -> float:
    """Peak of the pressure (strip-peak), beside the largest strip; with fewer than four that strip's, ``largest``."""
    if n < 4:
        return largest
    i = 0
    for j in range(1, n):
        if strips[j].p > strips[i].p:
            i = j
    peak = _surface_pressure(strips, n, i)
    for k in range(max(i - 1, 0), min(i + 1, n - 1)):
        j = min(max(k - 1, 0), n - 4)
        e, f, g = strips[j + 1].s - strips[j].s, strips[j + 2].s - strips[j + 1].s, strips[j + 3].s - strips[j + 2].s
        p0, p1 = _surface_pressure(strips, n, j), _surface_pressure(strips, n, j + 1)
        p2, p3 = _surface_pressure(strips, n, j + 2), _surface_pressure(strips, n, j + 3)
        first = (p1 - p0) / e, (p2 - p1) / f, (p3 - p2) / g
        second = (first[1] - first[0]) / (e + f), (first[2] - first[1]) / (f + g)
        third = (second[1] - second[0]) / (e + f + g)
        # slope of Newton's cubic at a distance from strip j + 1: 3 third x^2 + 2 bend x + rise
        bend, rise = second[0] + third * (e - f), first[0] + second[0] * e - third * e * f
        square = bend * bend - 3.0 * third * rise
        if square > 0.0 and bend < sqrt(square):
            x = rise / (sqrt(square) - bend)
            if strips[k].s <= strips[j + 1].s + x <= strips[k + 1].s:
                peak = max(peak, p0 + (x + e) * (first[0] + x * (second[0] + third * (x - f))))
    return peak
