"""The strips of the strip model: where they lie and what the profiles are there."""

from math import log, sqrt

from wrsim.core.compiling import kernel
from wrsim.core.contact.records import AFRESH
from wrsim.core.contact.strips.edges import forget
from wrsim.core.contact.strips.records import FACTORS, of_span


@kernel
def take_places(lobes, strips, count, start, state):
    """Places for the strips of each lobe; edges and half lengths of the last call. Returns (places, all known)."""
    m = 0
    known = start != AFRESH
    for i in range(count):
        lobe, rows, span = lobes[i], strips[i], state.spans[i]
        n = lobe.n_strips
        half = 0.5 * rows[0].ds
        span.first = m
        span.n = n
        span.start.limit = rows[0].s - half
        span.end.limit = rows[n - 1].s + half
        known = known and lobe.last_strips == n
        span.start.at = max(lobe.last_start, span.start.limit)
        span.end.at = min(lobe.last_end, span.end.limit)
        span.on = n > 0 and span.end.at > span.start.at
        span.widened = 0
        forget(span)
        for j in range(n):
            place = state.places[m]
            place.lobe = i
            place.let_go = 0
            place.a = rows[j].a_last if span.on else 0.0
            place.at = min(max((j + 0.5) / n * FACTORS - 0.5, 0.0), FACTORS - 1.0)
            m += 1
    return m, known


@kernel
def first_guess(strips, count, state):
    """Widest edges; within, half lengths and factors about like those of Hertz's ellipse."""
    for i in range(count):
        rows, span = strips[i], state.spans[i]
        own = of_span(state.places, span)
        n = span.n
        if n == 0:
            continue
        span.on = 1
        span.widened = 0
        forget(span)
        span.start.at = span.start.limit
        span.end.at = span.end.limit
        deepest = 1e-12
        main = 0
        for j in range(n):
            if rows[j].penetration > deepest:
                deepest = rows[j].penetration
                main = j
        # ratio of the curvatures across and along from the width at half of the depth; Hertz's factor and edges for it
        wide = 0
        for j in range(n):
            wide += 1 if rows[j].penetration > 0.5 * deepest else 0
        ratio = rows[main].r_t * deepest / (0.5 * max(wide, 1) * rows[0].ds) ** 2
        level = min(max(0.5 + 0.07 * log(ratio), 0.2), 0.8)
        for j in range(n):
            share = (rows[j].penetration / deepest - level) / (1.0 - level)
            own[j].a = 0.75 * sqrt(2.0 * rows[j].r_t * deepest * share) if share > 0.0 else 0.0
            own[j].let_go = 0
        state.factors[i * FACTORS : (i + 1) * FACTORS] = min(1.0 + 0.27 * ratio**0.63, 5.0)


@kernel
def sample(rows, span, own, modulus, axle):
    """Geometry at the present strips of a lobe, by cubic interpolation in the rows laid over the penetration.

    axle: of the wheel (t, o, b); it yaws the strips.
    """
    n = span.n
    width = (span.end.at - span.start.at) / n
    for j in range(n):
        s = span.start.at + (j + 0.5) * width
        x = (s - rows[0].s) / rows[0].ds
        c = min(max(int(x), 1), n - 3)
        r = x - c
        w0 = -r * (r - 1.0) * (r - 2.0) / 6.0
        w1 = (r + 1.0) * (r - 1.0) * (r - 2.0) / 2.0
        w2 = -(r + 1.0) * r * (r - 2.0) / 2.0
        w3 = (r + 1.0) * r * (r - 1.0) / 6.0
        r0, r1, r2, r3 = rows[c - 1], rows[c], rows[c + 1], rows[c + 2]
        place = own[j]
        place.s = s
        place.ds = width
        place.d = w0 * r0.penetration + w1 * r1.penetration + w2 * r2.penetration + w3 * r3.penetration
        place.o = w0 * r0.o + w1 * r1.o + w2 * r2.o + w3 * r3.o
        place.b = w0 * r0.b + w1 * r1.b + w2 * r2.b + w3 * r3.b
        place.x = r1.x + r * (r2.x - r1.x)
        no = r1.no + r * (r2.no - r1.no)
        nb = r1.nb + r * (r2.nb - r1.nb)
        inverse = 1.0 / sqrt(no * no + nb * nb)
        place.no = no * inverse
        place.nb = nb * inverse
        lean = place.no * axle.y + place.nb * axle.z
        skew = abs(axle.x) / sqrt(max(1.0 - lean * lean, 2.5e-3))
        place.r_t = 1.0 / _mean_curvature(rows, n, x, skew, place.d)
        place.hertz = 0.5 * modulus / place.r_t


@kernel
def _mean_curvature(rows, n, x, skew, d):
    """Mean of 1/R_x over what a strip really runs over, at place x among the rows.

    Along a strip of a wheel whose axle points by e_t along the rail the profile coordinate changes by x times the skew
    e_t / cos(angle), with the angle between the strip and the axle: a curvature that jumps across the profile is felt
    as a mean over +-a times the skew.
    """
    middle = min(max(int(x + 0.5), 0), n - 1)
    half = 0.7 * sqrt(2.0 * rows[middle].r_t * max(d, 0.0))
    reach = max(half * skew / rows[0].ds, 1.0)
    total = 0.0
    weights = 0.0
    for k in range(max(int(x - reach), 0), min(int(x + reach) + 2, n)):
        weight = 1.0 - abs(k - x) / reach
        if weight > 0.0:
            total += weight / rows[k].r_t
            weights += weight
    if weights == 0.0:
        return 1.0 / rows[middle].r_t
    return total / weights


@kernel
def leave(span, own):
    """Take a lobe out of contact."""
    span.on = 0
    for j in range(span.n):
        own[j].a = 0.0


@kernel
def regrid(rows, span, own, factors, start, end):
    """Lay the strips of a lobe over ``start`` to ``end`` and what it held before; new ground gets short strips.

    factors: all of the lobe's.
    """
    n = span.n
    on = span.on != 0
    old_start, old_end = span.start.at, span.end.at
    if on:
        start, end = min(start, old_start), max(end, old_end)
    deepest = 0.0
    longest = 0.0
    for j in range(n):
        deepest = max(deepest, rows[j].penetration)
        longest = max(longest, rows[j].r_t)
        own[j].a_before = own[j].a if on else 0.0
    short = 0.1 * sqrt(2.0 * longest * deepest)
    width = (old_end - old_start) / n
    for j in range(n):
        s = start + (j + 0.5) / n * (end - start)
        own[j].let_go = 0
        own[j].a = short
        if on and old_start < s < old_end:
            x = (s - old_start) / width - 0.5
            c = min(max(int(x), 0), n - 2)
            r = min(max(x - c, 0.0), 1.0)
            own[j].a = own[c].a_before * (1.0 - r) + own[c + 1].a_before * r
    if not on:
        factors[:] = 1.0
    span.on = 1
    span.start.at = start
    span.end.at = end
    forget(span)


@kernel
def write_back(lobes, strips, count, state):
    """The solution to the rows, and what the next call may start from."""
    for i in range(count):
        lobe, span = lobes[i], state.spans[i]
        own = of_span(state.places, span)
        lobe.last_strips = span.n
        lobe.last_start = span.start.at
        lobe.last_end = span.end.at if span.on else span.start.at - 1.0
        if not span.on:
            lobe.n_strips = 0
            continue
        for j in range(span.n):
            row, place = strips[i, j], own[j]
            row.s = place.s
            row.ds = place.ds
            row.x = place.x
            row.a = row.a_last = place.a
            row.p = place.q if place.a > 0.0 else 0.0
            row.no = place.no
            row.nb = place.nb
            row.o = place.o
            row.b = place.b
            row.r_t = place.r_t
