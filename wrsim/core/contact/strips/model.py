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
from wrsim.core.contact.strips.edges import edge_shifts, forget, in_contact, move_edges
from wrsim.core.contact.strips.grid import first_guess, leave, regrid, sample, take_places, write_back
from wrsim.core.contact.strips.influence import assemble, displacement_at, displacement_beside
from wrsim.core.contact.strips.layout import (
    A_,
    A_MATRIX,
    AT,
    B_MATRIX,
    BEFORE,
    DA_MATRIX,
    DB_MATRIX,
    END_,
    FACTOR,
    FACTORS,
    HAS,
    HERTZ,
    JACOBIAN,
    LEAST,
    LEFT,
    LOBE,
    MISFIT,
    MOST,
    MOVES,
    ON,
    Q_,
    RETURNED,
    START_,
    STEP,
    WEIGHT,
    D,
    R,
)
from wrsim.core.dense import solve_pivoted

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
LONGEST_STEP = 0.8  # in ln a and in the factors
OVERSHOOT, SMALLEST_SQUARE = -0.3, 0.1  # of a^2 after a step over a^2 before: left at once below; kept at least
LEAST_FACTOR = 0.3
MOST_FACTOR = 8.0
EVENNESS = 0.005  # weight with which neighbouring factors are kept alike


@kernel
def strip_model(patches, strips, count, modulus, pose, warm, v, lobes, matrices, index):
    """Half lengths and amplitudes of the strips of all lobes, and the edges of the contact.

    patches (lobes,) LOBE and strips (lobes, rows) STRIP: rows laid over the penetration, wider than the contact,
    as a table of the geometry; overwritten with the strips found.
    modulus: E* [Pa]; pose: its axle yaws the strips; warm: SETTINGS.start. v: (VECTORS, m),
    lobes: (LOBE_ROWS, count), matrices: (MATRICES, m, m), index: (m,) scratch, m places plus FACTORS a lobe.
    Writes per strip s, ds, x, a (0 out of contact), no, nb, o, b, r_t and, as p, the amplitude Q [Pa/m]; per lobe
    n_strips (0 out of contact). Returns (iterations, largest misfit): negative iterations say that there was no
    convergence.
    """
    m, known = take_places(patches, strips, count, warm, v, lobes)
    loose = 0.5 < warm < 1.5
    iterations = 0
    misfit = 1.0
    if known:
        most = WARM_ITERATIONS if loose else ITERATIONS
        iterations, misfit = _solve(patches, strips, count, modulus, pose, loose, most, v, lobes, m, matrices, index)
    if iterations <= 0:
        first_guess(patches, strips, count, v, lobes)
        iterations, misfit = _solve(
            patches, strips, count, modulus, pose, loose, ITERATIONS, v, lobes, m, matrices, index
        )
    write_back(patches, strips, count, v, lobes)
    return iterations, misfit


@kernel
def _solve(patches, strips, count, modulus, pose, loose, most, v, lobes, m, matrices, index):
    """Newton's method from the state in v. Returns (iterations, largest misfit), negative if unsolved."""
    stiffness = pi * modulus
    tolerance = WARM_TOLERANCE if loose else COLD_TOLERANCE
    edge_tolerance = WARM_EDGE if loose else COLD_EDGE
    deepest = 1e-12
    longest = 0.0
    _sample_all(patches, strips, count, modulus, pose, v, lobes)
    for i in range(count):
        for j in range(patches[i].n_strips):
            deepest = max(deepest, strips[i, j].penetration)
    for k in range(m):
        if lobes[ON, int(v[LOBE, k])] > 0.5:
            longest = max(longest, sqrt(2.0 * v[R, k] * max(v[D, k], 0.0)))
    misfit = last = 1e9
    for iteration in range(1, most + 1):
        n = _collect(v, lobes, m, index)
        if n == 0:
            if not _take_in(patches, strips, count, v, lobes, m, stiffness, index, n, deepest):
                return iteration, 0.0
            _sample_all(patches, strips, count, modulus, pose, v, lobes)
            continue
        assemble(v, index, n, m, matrices)
        misfit = _residuals(v, lobes, index, n, count, matrices, stiffness, deepest)
        # factors at their bounds: only other edges can help
        stuck = abs(misfit - last) < STUCK * misfit
        last = misfit
        if misfit < tolerance:
            shift = 0.0
            for i in range(count):
                if lobes[ON, i] > 0.5 and lobes[MOVES, i] < MOST_MOVES:
                    shift = max(shift, edge_shifts(patches, i, v, lobes))
            if shift < edge_tolerance:
                if 2 * iteration > most or not _take_in(
                    patches, strips, count, v, lobes, m, stiffness, index, n, deepest
                ):
                    return iteration, misfit
                _sample_all(patches, strips, count, modulus, pose, v, lobes)
                continue
        else:
            _newton_step(v, lobes, index, n, count, matrices, stiffness, SHORTEST * longest)
        for i in range(count):
            if lobes[ON, i] < 0.5:
                continue
            narrow = lobes[END_, i] - lobes[START_, i] < NARROWEST * (lobes[MOST, i] - lobes[LEAST, i])
            if narrow or in_contact(patches, i, v, lobes) < FEWEST:
                leave(patches, i, v, lobes)
                for j in range(count):
                    forget(j, lobes)
            elif (
                (misfit < LOOSE or stuck)
                and lobes[MOVES, i] < MOST_MOVES
                and edge_shifts(patches, i, v, lobes) >= 0.5 * edge_tolerance
            ):
                move_edges(patches, i, v, lobes)
                lobes[MOVES, i] += 1.0
                sample(patches, strips, i, modulus, pose, v, lobes)
    return -most, misfit


@kernel
def _sample_all(patches, strips, count, modulus, pose, v, lobes):
    """Geometry at the strips of all lobes in contact."""
    for i in range(count):
        if lobes[ON, i] > 0.5:
            sample(patches, strips, i, modulus, pose, v, lobes)


@kernel
def _collect(v, lobes, m, index):
    """Places in contact. Returns their number."""
    n = 0
    for k in range(m):
        if v[A_, k] > 0.0 and lobes[ON, int(v[LOBE, k])] > 0.5:
            index[n] = k
            n += 1
    return n


@kernel
def _residuals(v, lobes, index, n, count, matrices, stiffness, deepest):
    """Misfits of all equations to STEP; returns the largest, relative to the penetration."""
    am, bm = matrices[A_MATRIX], matrices[B_MATRIX]
    size = n + count * FACTORS
    # amplitudes and the weights of the second condition
    for i in range(count):
        v[STEP, i] = lobes[HAS, i] = 0.0
    for i in range(n):
        k = int(index[i])
        f, r = _factor_at(v, k)
        v[Q_, k] = v[HERTZ, k] * ((1.0 - r) * v[FACTOR, f] + r * v[FACTOR, f + 1])
        v[WEIGHT, k] = v[Q_, k] * v[A_, k] * v[A_, k]
        v[STEP, int(v[LOBE, k])] += v[WEIGHT, k]
        lobes[HAS, int(v[LOBE, k])] = 1.0
    for i in range(n):
        k = int(index[i])
        v[WEIGHT, k] /= v[STEP, int(v[LOBE, k])]
    largest = 0.0
    for i in range(size):
        v[STEP, i] = 0.0
    for i in range(n):
        u = c = 0.0
        for j in range(n):
            q = v[Q_, int(index[j])]
            u += am[i, j] * q
            c += bm[i, j] * q
        k = int(index[i])
        v[STEP, i] = u / stiffness - v[D, k]
        v[MISFIT, k] = c * v[R, k] / stiffness - 1.0
        largest = max(largest, abs(v[STEP, i]))
        f, r = _factor_at(v, k)
        v[STEP, n + f] += (1.0 - r) * v[WEIGHT, k] * v[MISFIT, k]
        v[STEP, n + f + 1] += r * v[WEIGHT, k] * v[MISFIT, k]
    for f in range(count * FACTORS):
        if lobes[HAS, f // FACTORS] < 0.5:
            continue
        first, last = f % FACTORS == 0, f % FACTORS == FACTORS - 1
        before = v[FACTOR, f if first else f - 1]
        after = v[FACTOR, f if last else f + 1]
        v[STEP, n + f] += EVENNESS * (2.0 * v[FACTOR, f] - before - after)
    largest /= deepest
    for f in range(count * FACTORS):
        largest = max(largest, 0.1 * abs(v[STEP, n + f]))
    return largest


@kernel
def _factor_at(v, k):
    """Number of the factor before place k and the share r of the next one."""
    at = v[AT, k]
    f = min(int(at), FACTORS - 2)
    return int(v[LOBE, k]) * FACTORS + f, at - f


@kernel
def _newton_step(v, lobes, index, n, count, matrices, stiffness, shortest):
    """One step in the squares of the half lengths, in which u is nearly linear, and in the factors."""
    am, bm, da, db = matrices[A_MATRIX], matrices[B_MATRIX], matrices[DA_MATRIX], matrices[DB_MATRIX]
    jacobian = matrices[JACOBIAN]
    size = n + count * FACTORS
    for i in range(size):
        for j in range(n, size):
            jacobian[i, j] = 0.0
    for i in range(n, size):
        for j in range(n):
            jacobian[i, j] = 0.0
    for i in range(n):
        ki = int(index[i])
        li, ri = _factor_at(v, ki)
        scale = v[WEIGHT, ki] * v[R, ki] / stiffness
        w0, w1 = n + li, n + li + 1
        s0, s1 = (1.0 - ri) * scale, ri * scale
        for j in range(n):
            kj = int(index[j])
            q = v[Q_, kj]
            jacobian[i, j] = da[i, j] * q / stiffness
            jacobian[w0, j] += s0 * db[i, j] * q
            jacobian[w1, j] += s1 * db[i, j] * q
            lj, rj = _factor_at(v, kj)
            h0, h1 = n + lj, n + lj + 1
            q = v[HERTZ, kj]
            jacobian[i, h0] += am[i, j] * q * (1.0 - rj) / stiffness
            jacobian[i, h1] += am[i, j] * q * rj / stiffness
            c = bm[i, j] * q
            jacobian[w0, h0] += s0 * c * (1.0 - rj)
            jacobian[w0, h1] += s0 * c * rj
            jacobian[w1, h0] += s1 * c * (1.0 - rj)
            jacobian[w1, h1] += s1 * c * rj
    for f in range(count * FACTORS):
        first, last = f % FACTORS == 0, f % FACTORS == FACTORS - 1
        row = n + f
        jacobian[row, row] += EVENNESS * (2.0 - (1.0 if first else 0.0) - (1.0 if last else 0.0))
        if not first:
            jacobian[row, row - 1] -= EVENNESS
        if not last:
            jacobian[row, row + 1] -= EVENNESS
    for i in range(count):
        if lobes[HAS, i] < 0.5:
            for f in range(i * FACTORS, (i + 1) * FACTORS):
                for j in range(size):
                    jacobian[n + f, j] = 0.0
                jacobian[n + f, n + f] = 1.0
                v[STEP, n + f] = 0.0
    solve_pivoted(jacobian, size, v[STEP])
    for i in range(count):
        # no lobe grows or changes its factors by too much at once
        largest = 0.0
        for f in range(i * FACTORS, (i + 1) * FACTORS):
            largest = max(largest, abs(v[STEP, n + f]) / v[FACTOR, f])
        for j in range(n):
            if int(v[LOBE, int(index[j])]) == i:
                largest = max(largest, -v[STEP, j])
        share = min(1.0, LONGEST_STEP / largest) if largest > 0.0 else 1.0
        for f in range(i * FACTORS, (i + 1) * FACTORS):
            v[FACTOR, f] = min(max(v[FACTOR, f] - share * v[STEP, n + f], LEAST_FACTOR), MOST_FACTOR)
        for j in range(n):
            k = int(index[j])
            if int(v[LOBE, k]) != i:
                continue
            square = 1.0 - 2.0 * share * v[STEP, j]
            # a step that just overshoots lets no strip go: the next one tells
            square = max(square, SMALLEST_SQUARE) if square > OVERSHOOT else 0.0
            v[A_, k] *= sqrt(square)
            if v[A_, k] < shortest:
                v[A_, k] = 0.0
                v[LEFT, k] += 1.0


@kernel
def _take_in(patches, strips, count, v, lobes, m, stiffness, index, n, deepest):
    """Strips where the displacement falls short of the penetration enter the contact. True if any did."""
    changed = False
    for i in range(count):
        start, end = lobes[START_, i], lobes[END_, i]
        moved = abs(start - lobes[BEFORE, i]) + abs(end - lobes[BEFORE + 1, i])
        if lobes[RETURNED, i] > 0.0 and moved < IDLE * (end - start):
            continue
        if lobes[RETURNED, i] < RETURNS and _widen(patches, strips, i, v, lobes, stiffness, index, n, deepest):
            lobes[RETURNED, i] += 1.0
            lobes[BEFORE, i], lobes[BEFORE + 1, i] = start, end
            changed = True
    if changed:
        return True
    for k in range(m):
        v[MISFIT, k] = 0.0
        if v[A_, k] > 0.0 or v[LEFT, k] > RETURNS or lobes[ON, int(v[LOBE, k])] < 0.5:
            continue
        closing = v[D, k] - displacement_at(v, k, index, n) / stiffness
        if closing > ENTRY * deepest:
            # a strip alone: Q = E*/(2 R_x), u about 6 Q a^2 / (pi E*)
            v[MISFIT, k] = sqrt(closing * v[R, k])
            forget(int(v[LOBE, k]), lobes)
            changed = True
    if changed:
        for k in range(m):
            v[A_, k] += v[MISFIT, k]
    return changed


@kernel
def _widen(patches, strips, i, v, lobes, stiffness, index, n, deepest):
    """Let lobe i reach over the rows beyond its edges where the gap has closed. True if there are any.

    This is how a lobe comes into contact, and how a second hump of the penetration is found.
    """
    rows = strips[i]
    places = patches[i].n_strips
    on = lobes[ON, i] > 0.5
    start, end = lobes[START_, i], lobes[END_, i]
    clear = 1.5 * (end - start) / places if on else 0.0
    first = places
    last = -1
    for j in range(places):
        if on and start - clear < rows[j].s < end + clear:
            continue
        if rows[j].penetration <= WIDEN * deepest:
            continue
        u = displacement_beside(v, rows[j].o, rows[j].b, rows[j].no, rows[j].nb, index, n)
        if rows[j].penetration - u / stiffness > WIDEN * deepest:
            first = min(first, j)
            last = j
    if last < 0:
        return False
    half = 0.5 * rows[0].ds
    start, end = rows[first].s - half, rows[last].s + half
    regrid(patches, strips, i, v, lobes, start, end)
    return True
