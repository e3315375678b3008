"""Normal pressure on strips from two contact conditions each (docs/strip_model.md).

Every strip carries a semi-ellipse p = Q sqrt(a^2 - x^2), as in Kik-Piotrowski, but with an amplitude Q and a half
length a of its own. At the centre of each strip in contact the elastic surfaces must follow the rigid ones to second
order along x,

    u = d,      d2u/dx2 = -1/R_x,

d = delta c - g the penetration of the undeformed profiles there, R_x the wheel's radius along the rail. With f(a, s) of
`core.contact.strips.influence` the displacement is u = 1/(pi E*) sum_i Q_i int_i f ds, and because
f_xx = -f_ss - f_s/s = -f/(a^2 + s^2),

    sum_i Q_i int_i f ds = pi E* d,      sum_i Q_i int_i f/(a_i^2 + s^2) ds = pi E* / R_x.

A semi-ellipsoid over an ellipse satisfies both everywhere with Q = k E*/(2 R_x), so Hertz's solution is exact up to
the width of the strips; nothing is fitted. In general k varies along a lobe, linearly between FACTORS values: the first
condition holds at every strip's centre, the second in the mean around each of those values.

Newton's method finds a^2 and k, the strips' places follow the edges of the contact (`core.contact.strips.edges`).
Strips that would have to pull are let go, those where the gap has closed are taken in. Yaw shifts are left out of f.
"""

from math import pi, sqrt

from wrsim.core.compiling import kernel
from wrsim.core.contact.records import FROM_LAST
from wrsim.core.contact.strips.edges import edge_shifts, forget, in_contact, move_edges
from wrsim.core.contact.strips.grid import first_guess, leave, regrid, sample, take_places, write_back
from wrsim.core.contact.strips.influence import assemble, displacement_at, displacement_beside
from wrsim.core.contact.strips.newton import newton_step, residuals
from wrsim.core.contact.strips.records import FACTORS, of_span

# Of u - d, over the deepest penetration, with ten times that for the curvature, and of an edge in strip widths. From
# step to step of a run, where the forces change by more, and where a solution must be the same from any first guess.
WARM_TOLERANCE, WARM_EDGE = 1e-5, 0.02
COLD_TOLERANCE, COLD_EDGE = 1e-10, 1e-6
STUCK = 0.05  # change of the misfit, over itself, below which Newton's method is stuck
LOOSE = 0.01  # misfit below which edges may move
MOST_MOVES = 25  # of an edge
ITERATIONS = 100
WARM_ITERATIONS = 25  # from the last contact; beyond, a fresh start is better
SHORTEST = 2e-3  # half length below which a strip is out of contact, over the longest possible one
ENTRY = 2e-5  # closing of the gap at which a strip enters, over the deepest penetration
WIDEN = 1e-3  # the same beyond the edges
FEWEST = 4  # strips in contact below which a lobe has left it
IDLE = 1e-4  # move of the edges, over the width, that shows that widening a lobe was in vain
NARROWEST = 0.03  # the same for its width, over that of its penetration: a force of some 1e-5 of what it could be
RETURNS = 3  # times that a strip may be taken in again


@kernel
def strip_model(lobes, strips, count, modulus, axle, start, state):
    """Half lengths and amplitudes of the strips of all lobes, and the edges of the contact.

    lobes (lobes,) LOBE and strips (lobes, rows) STRIP: rows laid over the penetration, wider than the contact, as a
    table of the geometry; overwritten with the strips found. modulus: E* [Pa]; axle: of the wheel (t, o, b); start:
    SETTINGS.start; state: Unknowns, for m places and as many factors.
    Writes per strip s, ds, x, a (0 out of contact), no, nb, o, b, r_t and, as p, the amplitude Q [Pa/m]; per lobe
    n_strips (0 out of contact). Returns (iterations, largest misfit): negative iterations say that there was no
    convergence.
    """
    m, known = take_places(lobes, strips, count, start, state)
    loose = start == FROM_LAST
    iterations = 0
    misfit = 1.0
    if known:
        most = WARM_ITERATIONS if loose else ITERATIONS
        iterations, misfit = _solve(strips, count, modulus, axle, loose, most, m, state)
    if iterations <= 0:
        first_guess(strips, count, state)
        iterations, misfit = _solve(strips, count, modulus, axle, loose, ITERATIONS, m, state)
    write_back(lobes, strips, count, state)
    return iterations, misfit


@kernel
def _solve(strips, count, modulus, axle, loose, most, m, state):
    """Newton's method and moves of the edges, in turns. Returns (iterations, largest misfit), negative if unsolved."""
    places, spans = state.places, state.spans
    stiffness = pi * modulus
    tolerance = WARM_TOLERANCE if loose else COLD_TOLERANCE
    edge_tolerance = WARM_EDGE if loose else COLD_EDGE
    deepest = 1e-12
    longest = 0.0
    _sample_all(strips, count, modulus, axle, state)
    for i in range(count):
        for j in range(spans[i].n):
            deepest = max(deepest, strips[i, j].penetration)
    for k in range(m):
        if spans[places[k].lobe].on:
            longest = max(longest, sqrt(2.0 * places[k].r_t * max(places[k].d, 0.0)))
    misfit = last = 1e9
    for iteration in range(1, most + 1):
        n = _collect(places, spans, m)
        if n == 0:
            if not _take_in(strips, count, m, n, stiffness, deepest, state):
                return iteration, 0.0
            _sample_all(strips, count, modulus, axle, state)
            continue
        assemble(state, n, m)
        misfit = residuals(state, n, count, stiffness, deepest)
        # factors at their bounds: only other edges can help
        stuck = abs(misfit - last) < STUCK * misfit
        last = misfit
        if misfit < tolerance:
            shift = 0.0
            for i in range(count):
                if spans[i].on and spans[i].moves < MOST_MOVES:
                    shift = max(shift, edge_shifts(spans[i], of_span(places, spans[i])))
            if shift < edge_tolerance:
                if 2 * iteration > most or not _take_in(strips, count, m, n, stiffness, deepest, state):
                    return iteration, misfit
                _sample_all(strips, count, modulus, axle, state)
                continue
        else:
            newton_step(state, n, count, stiffness, SHORTEST * longest)
        for i in range(count):
            span, own = spans[i], of_span(places, spans[i])
            if not span.on:
                continue
            narrow = span.end.at - span.start.at < NARROWEST * (span.end.limit - span.start.limit)
            if narrow or in_contact(own) < FEWEST:
                leave(span, own)
                for j in range(count):
                    forget(spans[j])
            elif (
                (misfit < LOOSE or stuck) and span.moves < MOST_MOVES and edge_shifts(span, own) >= 0.5 * edge_tolerance
            ):
                move_edges(span, own)
                span.moves += 1
                sample(strips[i], span, own, modulus, axle)
    return -most, misfit


@kernel
def _sample_all(strips, count, modulus, axle, state):
    """Geometry at the strips of all lobes in contact."""
    for i in range(count):
        if state.spans[i].on:
            sample(strips[i], state.spans[i], of_span(state.places, state.spans[i]), modulus, axle)


@kernel
def _collect(places, spans, m):
    """Number the strips in contact; returns how many there are."""
    n = 0
    for k in range(m):
        if places[k].a > 0.0 and spans[places[k].lobe].on:
            places[n].touching = k
            n += 1
    return n


@kernel
def _take_in(strips, count, m, n, stiffness, deepest, state):
    """Strips where the displacement falls short of the penetration enter the contact. True if any did."""
    places, spans = state.places, state.spans
    changed = False
    for i in range(count):
        span = spans[i]
        start, end = span.start.at, span.end.at
        moved = abs(start - span.start.before) + abs(end - span.end.before)
        if span.widened > 0 and moved < IDLE * (end - start):
            continue
        if span.widened < RETURNS and _widen(strips[i], i, n, stiffness, deepest, state):
            span.widened += 1
            span.start.before = start
            span.end.before = end
            changed = True
    if changed:
        return True
    for k in range(m):
        place = places[k]
        place.misfit = 0.0
        if place.a > 0.0 or place.let_go > RETURNS or not spans[place.lobe].on:
            continue
        closing = place.d - displacement_at(places, k, n) / stiffness
        if closing > ENTRY * deepest:
            # a strip alone: Q = E*/(2 R_x), u about 6 Q a^2 / (pi E*)
            place.misfit = sqrt(closing * place.r_t)
            forget(spans[place.lobe])
            changed = True
    if changed:
        for k in range(m):
            places[k].a += places[k].misfit
    return changed


@kernel
def _widen(rows, i, n, stiffness, deepest, state):
    """Let lobe i reach over the rows beyond its edges where the gap has closed. True if there are any.

    This is how a lobe comes into contact, and how a second hump of the penetration is found.
    """
    span = state.spans[i]
    start, end = span.start.at, span.end.at
    clear = 1.5 * (end - start) / span.n if span.on else 0.0
    first = span.n
    last = -1
    for j in range(span.n):
        row = rows[j]
        if span.on and start - clear < row.s < end + clear:
            continue
        if row.penetration <= WIDEN * deepest:
            continue
        if row.penetration - displacement_beside(state.places, row, n) / stiffness > WIDEN * deepest:
            first = min(first, j)
            last = j
    if last < 0:
        return False
    half = 0.5 * rows[0].ds
    factors = state.factors[i * FACTORS : (i + 1) * FACTORS]
    regrid(rows, span, of_span(state.places, span), factors, rows[first].s - half, rows[last].s + half)
    return True
