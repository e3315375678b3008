"""The strips of the strip model: where they lie and what the profiles are there."""

from math import log, sqrt

from wrsim.core.compiling import kernel
from wrsim.core.contact.layout import (
    DS,
    N_STRIPS,
    NB,
    NO,
    PENETRATION,
    RADIUS_T,
    WARM_A,
    WARM_END,
    WARM_START,
    WARM_STRIPS,
    A,
    B,
    O,
    P,
    S,
    X,
)
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
        n = int(patches[i, N_STRIPS])
        rows = strips[i]
        half = 0.5 * rows[0, DS]
        lobes[FIRST, i] = m
        lobes[LEAST, i] = rows[0, S] - half
        lobes[MOST, i] = rows[n - 1, S] + half
        known = known and int(patches[i, WARM_STRIPS]) == n
        lobes[ON, i] = 1.0
        lobes[RETURNED, i] = 0.0
        forget(i, lobes)
        lobes[START_, i] = max(patches[i, WARM_START], lobes[LEAST, i])
        lobes[END_, i] = min(patches[i, WARM_END], lobes[MOST, i])
        if n == 0 or lobes[END_, i] <= lobes[START_, i]:
            lobes[ON, i] = 0.0
        for j in range(n):
            v[LOBE, m] = i
            v[LEFT, m] = 0.0
            v[A_, m] = rows[j, WARM_A] if lobes[ON, i] > 0.5 else 0.0
            v[AT, m] = min(max((j + 0.5) / n * FACTORS - 0.5, 0.0), FACTORS - 1.0)
            m += 1
    return m, known


@kernel
def first_guess(patches, strips, count, v, lobes):
    """Widest edges; within, half lengths and factors about like those of Hertz's ellipse."""
    for i in range(count):
        n = int(patches[i, N_STRIPS])
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
            if rows[j, PENETRATION] > deepest:
                deepest = rows[j, PENETRATION]
                main = j
        # ratio of the curvatures across and along from the width at half of the depth; Hertz's factor and edges for it
        wide = 0
        for j in range(n):
            wide += 1 if rows[j, PENETRATION] > 0.5 * deepest else 0
        ratio = rows[main, RADIUS_T] * deepest / (0.5 * max(wide, 1) * rows[0, DS]) ** 2
        level = min(max(0.5 + 0.07 * log(ratio), 0.2), 0.8)
        for j in range(n):
            share = (rows[j, PENETRATION] / deepest - level) / (1.0 - level)
            v[A_, first + j] = 0.75 * sqrt(2.0 * rows[j, RADIUS_T] * deepest * share) if share > 0.0 else 0.0
            v[LEFT, first + j] = 0.0
        for k in range(i * FACTORS, (i + 1) * FACTORS):
            v[FACTOR, k] = min(1.0 + 0.27 * ratio**0.63, 5.0)


@kernel
def sample(patches, strips, i, modulus, pose, v, lobes):
    """Geometry at the present strips of lobe i, by cubic interpolation in the rows laid over the penetration."""
    n = int(patches[i, N_STRIPS])
    rows = strips[i]
    first = int(lobes[FIRST, i])
    start = lobes[START_, i]
    width = (lobes[END_, i] - start) / n
    origin = rows[0, S]
    spacing = rows[0, DS]
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
        v[D, k] = w0 * r0[PENETRATION] + w1 * r1[PENETRATION] + w2 * r2[PENETRATION] + w3 * r3[PENETRATION]
        v[O_, k] = w0 * r0[O] + w1 * r1[O] + w2 * r2[O] + w3 * r3[O]
        v[B_, k] = w0 * r0[B] + w1 * r1[B] + w2 * r2[B] + w3 * r3[B]
        no = r1[NO] + r * (r2[NO] - r1[NO])
        nb = r1[NB] + r * (r2[NB] - r1[NB])
        inverse = 1.0 / sqrt(no * no + nb * nb)
        v[NO_, k] = no * inverse
        v[NB_, k] = nb * inverse
        v[X_, k] = r1[X] + r * (r2[X] - r1[X])
        lean = v[NO_, k] * pose[4] + v[NB_, k] * pose[5]
        skew = abs(pose[3]) / sqrt(max(1.0 - lean * lean, 2.5e-3))
        v[R, k] = 1.0 / _mean_curvature(rows, n, x, skew, v[D, k])
        v[HERTZ, k] = 0.5 * modulus / v[R, k]


@kernel
def _mean_curvature(rows, n, x, skew, d):
    """Mean of 1/R_x over what a strip really runs over, at place x among the rows.

    Along a strip of a wheel whose axle points by e_t along the rail the profile coordinate changes by x times the skew
    e_t / cos(angle), with the angle between the strip and the axle: a curvature that jumps across the profile is felt
    as a mean over +-a times the skew.
    """
    spacing = rows[0, DS]
    middle = min(max(int(x + 0.5), 0), n - 1)
    half = 0.7 * sqrt(2.0 * rows[middle, RADIUS_T] * max(d, 0.0))
    reach = max(half * skew / spacing, 1.0)
    total = 0.0
    weights = 0.0
    for k in range(max(int(x - reach), 0), min(int(x + reach) + 2, n)):
        weight = 1.0 - abs(k - x) / reach
        if weight > 0.0:
            total += weight / rows[k, RADIUS_T]
            weights += weight
    if weights == 0.0:
        return 1.0 / rows[middle, RADIUS_T]
    return total / weights


@kernel
def leave(patches, i, v, lobes):
    """Take lobe i out of contact."""
    lobes[ON, i] = 0.0
    first = int(lobes[FIRST, i])
    for k in range(first, first + int(patches[i, N_STRIPS])):
        v[A_, k] = 0.0


@kernel
def regrid(patches, strips, i, v, lobes, start, end):
    """Lay the strips of lobe i over ``start`` to ``end`` and what it held before; new ground gets short strips."""
    n = int(patches[i, N_STRIPS])
    first = int(lobes[FIRST, i])
    on = lobes[ON, i] > 0.5
    if on:
        start, end = min(start, lobes[START_, i]), max(end, lobes[END_, i])
    deepest = 0.0
    longest = 0.0
    for j in range(n):
        deepest = max(deepest, strips[i, j, PENETRATION])
        longest = max(longest, strips[i, j, RADIUS_T])
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
        n = int(patches[i, N_STRIPS])
        first = int(lobes[FIRST, i])
        patches[i, WARM_STRIPS] = n
        patches[i, WARM_START] = lobes[START_, i]
        patches[i, WARM_END] = lobes[END_, i] if lobes[ON, i] > 0.5 else lobes[START_, i] - 1.0
        if lobes[ON, i] < 0.5:
            patches[i, N_STRIPS] = 0.0
            continue
        for j in range(n):
            k = first + j
            row = strips[i, j]
            row[S] = v[POS, k]
            row[DS] = v[WIDTH_, k]
            row[X] = v[X_, k]
            row[A] = v[A_, k]
            row[WARM_A] = v[A_, k]
            row[P] = v[Q_, k] if v[A_, k] > 0.0 else 0.0
            row[NO] = v[NO_, k]
            row[NB] = v[NB_, k]
            row[O] = v[O_, k]
            row[B] = v[B_, k]
            row[RADIUS_T] = v[R, k]
