"""The strips of the strip model: where they lie and what the profiles are there."""

from math import log, sqrt

from wrsim.core.compiling import kernel
from wrsim.core.contact.strips.edges import forget
from wrsim.core.contact.strips.layout import (
    A_,
    AT,
    B_,
    END_,
    FACTOR,
    FACTORS,
    FIRST,
    HERTZ,
    LEAST,
    LEFT,
    LOBE,
    MOST,
    NB_,
    NO_,
    O_,
    ON,
    OTHER,
    POS,
    Q_,
    RETURNED,
    START_,
    WIDTH_,
    X_,
    D,
    R,
)


@kernel
def take_places(patches, strips, count, warm, v, lobes):
    """Places for the strips of each lobe; edges and half lengths of the last call. Returns (places, all known)."""
    m = 0
    known = warm > 0.5
    for i in range(count):
        n = patches[i].n_strips
        rows = strips[i]
        half = 0.5 * rows[0].ds
        lobes[FIRST, i] = m
        lobes[LEAST, i] = rows[0].s - half
        lobes[MOST, i] = rows[n - 1].s + half
        known = known and patches[i].last_strips == n
        lobes[ON, i] = 1.0
        lobes[RETURNED, i] = 0.0
        forget(i, lobes)
        lobes[START_, i] = max(patches[i].last_start, lobes[LEAST, i])
        lobes[END_, i] = min(patches[i].last_end, lobes[MOST, i])
        if n == 0 or lobes[END_, i] <= lobes[START_, i]:
            lobes[ON, i] = 0.0
        for j in range(n):
            v[LOBE, m] = i
            v[LEFT, m] = 0.0
            v[A_, m] = rows[j].a_last if lobes[ON, i] > 0.5 else 0.0
            v[AT, m] = min(max((j + 0.5) / n * FACTORS - 0.5, 0.0), FACTORS - 1.0)
            m += 1
    return m, known


@kernel
def first_guess(patches, strips, count, v, lobes):
    """Widest edges; within, half lengths and factors about like those of Hertz's ellipse."""
    for i in range(count):
        n = patches[i].n_strips
        rows = strips[i]
        if n == 0:
            continue
        lobes[ON, i] = 1.0
        lobes[RETURNED, i] = 0.0
        forget(i, lobes)
        lobes[START_, i] = lobes[LEAST, i]
        lobes[END_, i] = lobes[MOST, i]
        first = int(lobes[FIRST, i])
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
            v[A_, first + j] = 0.75 * sqrt(2.0 * rows[j].r_t * deepest * share) if share > 0.0 else 0.0
            v[LEFT, first + j] = 0.0
        for k in range(i * FACTORS, (i + 1) * FACTORS):
            v[FACTOR, k] = min(1.0 + 0.27 * ratio**0.63, 5.0)


@kernel
def sample(patches, strips, i, modulus, pose, v, lobes):
    """Geometry at the present strips of lobe i, by cubic interpolation in the rows laid over the penetration."""
    n = patches[i].n_strips
    rows = strips[i]
    first = int(lobes[FIRST, i])
    start = lobes[START_, i]
    width = (lobes[END_, i] - start) / n
    origin = rows[0].s
    spacing = rows[0].ds
    for j in range(n):
        k = first + j
        s = start + (j + 0.5) * width
        x = (s - origin) / spacing
        c = min(max(int(x), 1), n - 3)
        r = x - c
        w0 = -r * (r - 1.0) * (r - 2.0) / 6.0
        w1 = (r + 1.0) * (r - 1.0) * (r - 2.0) / 2.0
        w2 = -(r + 1.0) * r * (r - 2.0) / 2.0
        w3 = (r + 1.0) * r * (r - 1.0) / 6.0
        r0, r1, r2, r3 = rows[c - 1], rows[c], rows[c + 1], rows[c + 2]
        v[POS, k] = s
        v[WIDTH_, k] = width
        v[D, k] = w0 * r0.penetration + w1 * r1.penetration + w2 * r2.penetration + w3 * r3.penetration
        v[O_, k] = w0 * r0.o + w1 * r1.o + w2 * r2.o + w3 * r3.o
        v[B_, k] = w0 * r0.b + w1 * r1.b + w2 * r2.b + w3 * r3.b
        no = r1.no + r * (r2.no - r1.no)
        nb = r1.nb + r * (r2.nb - r1.nb)
        inverse = 1.0 / sqrt(no * no + nb * nb)
        v[NO_, k] = no * inverse
        v[NB_, k] = nb * inverse
        v[X_, k] = r1.x + r * (r2.x - r1.x)
        lean = v[NO_, k] * pose.axle.y + v[NB_, k] * pose.axle.z
        skew = abs(pose.axle.x) / sqrt(max(1.0 - lean * lean, 2.5e-3))
        v[R, k] = 1.0 / _mean_curvature(rows, n, x, skew, v[D, k])
        v[HERTZ, k] = 0.5 * modulus / v[R, k]


@kernel
def _mean_curvature(rows, n, x, skew, d):
    """Mean of 1/R_x over what a strip really runs over, at place x among the rows.

    Along a strip of a wheel whose axle points by e_t along the rail the profile coordinate changes by x times the skew
    e_t / cos(angle), with the angle between the strip and the axle: a curvature that jumps across the profile is felt
    as a mean over +-a times the skew.
    """
    spacing = rows[0].ds
    middle = min(max(int(x + 0.5), 0), n - 1)
    half = 0.7 * sqrt(2.0 * rows[middle].r_t * max(d, 0.0))
    reach = max(half * skew / spacing, 1.0)
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
def leave(patches, i, v, lobes):
    """Take lobe i out of contact."""
    lobes[ON, i] = 0.0
    first = int(lobes[FIRST, i])
    for k in range(first, first + patches[i].n_strips):
        v[A_, k] = 0.0


@kernel
def regrid(patches, strips, i, v, lobes, start, end):
    """Lay the strips of lobe i over ``start`` to ``end`` and what it held before; new ground gets short strips."""
    n = patches[i].n_strips
    first = int(lobes[FIRST, i])
    on = lobes[ON, i] > 0.5
    if on:
        start, end = min(start, lobes[START_, i]), max(end, lobes[END_, i])
    deepest = 0.0
    longest = 0.0
    for j in range(n):
        deepest = max(deepest, strips[i, j].penetration)
        longest = max(longest, strips[i, j].r_t)
        v[OTHER, first + j] = v[A_, first + j] if on else 0.0
    short = 0.1 * sqrt(2.0 * longest * deepest)
    width = (lobes[END_, i] - lobes[START_, i]) / n
    for j in range(n):
        s = start + (j + 0.5) / n * (end - start)
        v[LEFT, first + j] = 0.0
        v[A_, first + j] = short
        if on and lobes[START_, i] < s < lobes[END_, i]:
            x = (s - lobes[START_, i]) / width - 0.5
            c = min(max(int(x), 0), n - 2)
            r = min(max(x - c, 0.0), 1.0)
            v[A_, first + j] = v[OTHER, first + c] * (1.0 - r) + v[OTHER, first + c + 1] * r
    if not on:
        for k in range(i * FACTORS, (i + 1) * FACTORS):
            v[FACTOR, k] = 1.0
    lobes[ON, i] = 1.0
    lobes[START_, i] = start
    lobes[END_, i] = end
    forget(i, lobes)


@kernel
def write_back(patches, strips, count, v, lobes):
    """The solution to the rows, and what the next call may start from."""
    for i in range(count):
        n = patches[i].n_strips
        first = int(lobes[FIRST, i])
        patches[i].last_strips = n
        patches[i].last_start = lobes[START_, i]
        patches[i].last_end = lobes[END_, i] if lobes[ON, i] > 0.5 else lobes[START_, i] - 1.0
        if lobes[ON, i] < 0.5:
            patches[i].n_strips = 0
            continue
        for j in range(n):
            k = first + j
            row = strips[i, j]
            row.s = v[POS, k]
            row.ds = v[WIDTH_, k]
            row.x = v[X_, k]
            row.a = v[A_, k]
            row.a_last = v[A_, k]
            row.p = v[Q_, k] if v[A_, k] > 0.0 else 0.0
            row.no = v[NO_, k]
            row.nb = v[NB_, k]
            row.o = v[O_, k]
            row.b = v[B_, k]
            row.r_t = v[R, k]
