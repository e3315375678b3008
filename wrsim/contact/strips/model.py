"""Normal pressure on strips that follow the bodies at three points each (docs/theory/strip_model.md).

Every strip carries a semi-ellipse p = Q sqrt(a^2 - x^2), as in Kik-Piotrowski, but with an amplitude Q, a half length a
and a middle along the rail of its own. With f(a, x, s) of `contact.strips.influence` the displacement is

    u = 1/(pi E*) sum_i Q_i int_i f ds,

and in each strip in contact it is the gap of the undeformed bodies at three points, d the penetration on the contact
locus, x counted from there, R_x the wheel's radius along the rail:

    u = d - x^2/(2 R_x)    in the middle and sqrt(3)/2 a to both sides of it.

There the derivatives of the complementary energy by Q, a and the middle vanish, its integrals by the rule of Gauss and
Chebyshev with three points. In each grid of strips the middles lie on a line over the locus, so they have means of the
third condition. A semi-ellipsoid over an ellipse meets the conditions everywhere with Q = k E*/(2 R_x), so
Hertz's solution is exact up to the width of the strips; nothing is fitted. At either edge the ratio of p^2 of the outer
strips is Hertz's. Strips that would have to pull carry nothing. s is the rail's arclength, and the distance of two
strips is counted along it.

Lobes that are nearly one share a grid of strips, a lobe with a shoulder may have two (`ground`). After the solution
grids are cut at the saddles, so every lobe has its strips and nothing that is reported jumps where grids merge.
"""

from math import pi, sqrt

from wrsim.contact.records import COLD_START, STATUS_NOT_CONVERGED
from wrsim.contact.resultants import set_creepages, set_pressures
from wrsim.contact.strips.equations import block_of
from wrsim.contact.strips.grid import opposite
from wrsim.contact.strips.ground import set_grids
from wrsim.contact.strips.records import OF_A_STRIP, ROWS, System, V
from wrsim.contact.strips.solution import solve
from wrsim.jit.compiling import kernel

OVERLAP = 0.5  # of the last contact with a grid's new bounds that makes it the same grid


@kernel
def press_strips(a, wheel, rail, pose, count):
    """Pressures of all lobes, with damping; a: Arrays of contact.arrays. Returns a status: STATUS_NOT_CONVERGED
    and no strips where there is no solution."""
    model, state, lobes = a.model[0], a.state[0], a.patches
    n = model.strips
    system = System(wheel, rail, a.influence, a.rows, a.places, a.grids, a.vectors, a.matrix, a.memo)
    memo = a.memo[0]
    if state.start == COLD_START and memo.turn == 0:
        memo.known = 0
    for i in range(count):
        _set_main_point(wheel, rail, lobes[i])
    memo.modulus = model.E
    memo.together, memo.apart = model.together, model.apart
    memo.stiffness = pi * model.E
    memo.curved = model.curved
    _set_sides(system, n, model.E / model.G - 1.0, a.strips)
    status = set_grids(system, a.found, wheel, rail, pose, count)
    known = memo.known > 0 and _same_grids(system, n, memo.known)
    memo.strips = solve(system, n, known, state.tolerance)
    memo.known = memo.grids if memo.strips == n else 0
    for i in range(count):
        lobes[i].n_strips = 0
    if memo.strips == 0:
        memo.substitutes += 1
        return status | STATUS_NOT_CONVERGED
    for g in range(memo.grids):
        _hand_out(system, memo.strips, g, a.found, lobes, a.strips)
    for i in range(count):
        _report(model, pose, lobes[i], a.strips[i])
    return status


@kernel
def _set_sides(system, n, transverse, strips):
    """How the lateral creep forces of strips press on others whose normals are turned: none before they are known.

    n: strips of the grids of the last call; transverse: nu/(1 - nu).
    """
    memo, vectors = system.memo[0], system.vectors
    vectors[V.SIDE : V.LIFT + 1] = 0.0
    if memo.turn == 0:
        return
    for i in range(memo.known * n):
        place = system.places[i]
        if place.y > 0.0:
            strip = strips[place.lobe, place.row]
            vectors[V.SIDE, i] = strip.Fy / strip.N if strip.N > 0.0 else 0.0
            vectors[V.LIFT, i] = transverse * vectors[V.SIDE, i]


@kernel
def _set_main_point(wheel, rail, lobe):
    """Place of a lobe's main point, and the half length of the overlap there."""
    at = opposite(wheel, rail, lobe.arc_wheel, lobe.arc_rail)
    lobe.x, lobe.o, lobe.b = at.x, at.o, at.b
    lobe.half_length = sqrt(2.0 * max(at.d, 0.0) * at.r_t)


@kernel
def _same_grids(system, n, before):
    """Whether the unknowns of the last call suit the grids as they are; edges are brought within the bounds."""
    memo, x = system.memo[0], system.vectors[V.X]
    if before != memo.grids:
        return False
    for g in range(before):
        grid = system.grids[g]
        if not grid.on:
            continue
        e = g * block_of(n) + OF_A_STRIP * n
        common = min(x[e + 1], grid.most) - max(x[e], grid.least)
        if common < OVERLAP * (x[e + 1] - x[e]):
            return False
        if grid.start_held or x[e] < grid.least:
            x[e] = grid.least
            memo.inverted = memo.inverted if grid.start_held else 0
            grid.start_held = 1
        if grid.end_held or x[e + 1] > grid.most:
            x[e + 1] = grid.most
            memo.inverted = memo.inverted if grid.end_held else 0
            grid.end_held = 1
    return True


@kernel
def _hand_out(system, n, g, found, lobes, strips):
    """The strips of a grid in contact to its lobes, cut at the saddles between them."""
    grid, rows = system.grids[g], system.rows[g]
    if not grid.on:
        return
    for i in range(grid.first, grid.last + 1):
        lobe = lobes[i]
        least = found[i - 1].saddle_arc if i > grid.first else grid.least
        most = found[i].saddle_arc if i < grid.last else grid.most
        for j in range(n):
            place = system.places[g * n + j]
            lo, hi = max(place.lo, least), min(place.hi, most)
            if place.y <= 0.0 or hi <= lo:
                continue
            place.lobe, place.row = i, lobe.n_strips
            strip = strips[i, lobe.n_strips]
            lobe.n_strips += 1
            s = 0.5 * (lo + hi)
            z = (s - grid.least) / grid.spacing
            r = min(max(int(z), 0), ROWS - 2)
            z -= r
            one, other = rows[r], rows[r + 1]
            strip.s = s - lobe.arc_rail
            strip.ds = hi - lo
            strip.a = sqrt(place.y)
            strip.p = place.q
            strip.x = one.x + z * (other.x - one.x) + place.off
            strip.o = one.o + z * (other.o - one.o)
            strip.b = one.b + z * (other.b - one.b)
            no = one.no + z * (other.no - one.no)
            nb = one.nb + z * (other.nb - one.nb)
            inverse = 1.0 / sqrt(no * no + nb * nb)
            strip.no, strip.nb = no * inverse, nb * inverse
            strip.slope = one.slope + z * (other.slope - one.slope)
            strip.r_t = 1.0 / place.bend
            strip.penetration = one.d + z * (other.d - one.d)


@kernel
def _report(model, pose, lobe, strips):
    """Damping, forces of the strips, and what a lobe reports. The strips' p comes as amplitude and goes as pressure."""
    n = lobe.n_strips
    set_creepages(pose, model.least_speed, lobe, strips, n)
    factor = max(1.0 + model.damping * lobe.closing, 0.0)
    largest, lobe.N, lobe.area, longest = set_pressures(strips, n, factor)
    lobe.p0 = _peak(strips, n, largest)
    lobe.start = strips[0].s - 0.5 * strips[0].ds if n > 0 else 0.0
    lobe.end = strips[n - 1].s + 0.5 * strips[n - 1].ds if n > 0 else 0.0
    lobe.width = lobe.end - lobe.start
    lobe.length = 2.0 * longest
    lobe.amplitude = lobe.p0 / longest if longest > 0.0 else 0.0


@kernel
def _peak(strips, n, largest):
    """Peak of the pressure: p^2 over s is a parabola where the contact is Hertz's, through the largest strip and those
    beside it; at an end that strip's own, ``largest``.

    A strip of width h spreads its pressure evenly. In its middle, a wave cos(w s) of pressure thus presses the surface
    down by sin(w h/2)/(w h/2) of what it would, and the strips' pressures are 1 + (w h)^2/24 times the true ones to
    third order: the bend of p over h^2/24, at a peak half the bend of p^2, comes off.
    """
    i = 0
    for j in range(1, n):
        if strips[j].p > strips[i].p:
            i = j
    if i == 0 or i == n - 1:
        return largest
    left, middle, right = strips[i - 1], strips[i], strips[i + 1]
    to_left, to_right = middle.s - left.s, right.s - middle.s
    before = (middle.p * middle.p - left.p * left.p) / to_left
    behind = (right.p * right.p - middle.p * middle.p) / to_right
    bend = (behind - before) / (to_left + to_right)
    if bend >= 0.0:
        return largest
    slope = before + bend * to_left
    return sqrt(middle.p * middle.p - 0.25 * slope * slope / bend + middle.ds * middle.ds * bend / 12.0)
