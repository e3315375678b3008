"""Normal pressure after Kik and Piotrowski on a curved patch [S 23-31].

Every strip carries a semi-ellipse (norm-p); p0 follows from the displacement at the main point, where the two surfaces
together must yield the approach (norm-p0); for equal materials E* is the paper's E / (2 (1 - sigma^2)). The inner
integral is known (norm-inner); it has a logarithm at s = 0 that is integrated in closed form, so the sum over strips
converges at second order.

With several lobes (`contact.search.lobes`) each has its own amplitude Q = p0 / x_L(0) by (norm-lobes). The displacement
at every main point is the sum over all lobes, near or far, a far one weighted with the cosine of the angle between the
normals. One lobe alone gives [S 29]; c = 1 gives one amplitude for the whole patch, again [S 29].

Yaw shifts the strips along x but is left out of I: each strip is taken centred on the main point's x.
"""

from math import ceil, log, pi, sqrt

from wrsim.contact.overlap_patch import fill_strips, find_edge, first_step
from wrsim.contact.records import STATUS_PROFILE_END, PlacedWheel, Rail, WheelPose
from wrsim.contact.resultants import set_creepages, set_pressures
from wrsim.jit import Array, Record, Records, inlined, kernel
from wrsim.jit.dense import factorise, solve_factorised

MOST_LOBES = 6


@kernel
def bound_lobe(
    wheel: PlacedWheel, rail: Rail, model: Record, contacts: Records, i: int, left: float, right: float, lobes: Records
) -> int:
    """Recess and edges (norm-h) of lobe i, at most ``left`` and ``right`` of the main point. Returns status bits;
    without contact the width is zero."""
    lobe, contact = lobes[i], contacts[i]
    delta = level = contact.depth
    if model.joint and lobe.partner >= 0 and contacts[lobe.partner].depth > delta:
        level += lobe.coupling * (contacts[lobe.partner].depth - delta)
    lobe.recess = model.recess * level
    if delta <= lobe.recess:
        return 0
    first = first_step(delta - lobe.recess, contact.curvature)
    lobe.end, beyond = find_edge(wheel, rail, lobe, model.projected, first, 1.0, right)
    lobe.start, before = find_edge(wheel, rail, lobe, model.projected, first, -1.0, left)
    lobe.width = lobe.end - lobe.start
    return STATUS_PROFILE_END if beyond or before else 0


@kernel
def build_strips(
    wheel: PlacedWheel, rail: Rail, model: Record, lobes: Records, count: int, i: int, strips: Records
) -> None:
    """Strips of one lobe: by their width, or by their number. Where the model's patches are joint the lobes of a patch
    share the number by their widths; else every lobe has all of them, because its forces would jump, if slightly, with
    their number."""
    lobe = lobes[i]
    if lobe.width <= 0.0:
        return
    if model.strip_width > 0.0:
        n = int(ceil(lobe.width / model.strip_width))  # noqa: RUF046 (a float in compiled code)
    elif model.joint:
        width = 0.0
        for j in range(count):
            if lobes[j].group == lobe.group:
                width += lobes[j].width
        n = int(ceil(model.strips * lobe.width / width - 1e-9))  # noqa: RUF046
    else:
        n = model.strips
    n = min(max(n, model.fewest), strips.shape[0])
    lobe.half_length = fill_strips(wheel, rail, lobe, model.projected, n, strips)
    lobe.n_strips = n
    # the main point lies within its strip: its coordinates follow along the strip's tangent
    main = min(max(int(-lobe.start / (lobe.width / n)), 0), n - 1)
    strip = strips[main]
    neighbour = strips[main - 1] if main > 0 else strips[main + 1]
    lobe.x = strip.x - strip.s * (strip.x - neighbour.x) / (strip.s - neighbour.s)
    lobe.o = strip.o - strip.s * strip.nb
    lobe.b = strip.b + strip.s * strip.no


@kernel
def press_lobes(model: Record, pose: WheelPose, lobes: Records, strips: Records, count: int, work: Array) -> None:
    """Pressures of all lobes from the displacements at their main points, with damping. work: (14, >= 8) scratch."""
    matrix, rows = work[:MOST_LOBES], work[MOST_LOBES : 2 * MOST_LOBES]
    amplitude, pivot = work[2 * MOST_LOBES], work[2 * MOST_LOBES + 1]
    stiffness = pi * model.E
    for i in range(count):
        lobe = lobes[i]
        n = lobe.n_strips
        amplitude[i] = 1.0 if n > 0 else 0.0
        for j in range(count + 1):
            matrix[i, j] = 0.0
        if n == 0:
            continue
        set_creepages(pose, model, lobe, strips[i], n)
        influence = own_influence(strips[i], n, lobe.half_length)
        if count == 1:
            amplitude[0] = stiffness * lobe.approach / influence
            break
        share = lobe.coupling
        for j in range(count):
            source = lobes[j]
            if j != i and source.n_strips > 0:
                facing = lobe.no * source.no + lobe.nb * source.nb
                if facing > 0.0:
                    far = far_influence(strips[j], source.n_strips, lobe.o, lobe.b)
                    matrix[i, j] = (1.0 - share) * facing * far
        matrix[i, i] = influence
        matrix[i, count] = (1.0 - share) * stiffness * lobe.approach
        partner = lobe.partner
        if partner >= 0 and lobes[partner].n_strips > 0:
            matrix[i, partner] -= share * influence
    if count > 1:
        solve_amplitudes(matrix, count, rows, amplitude, pivot)
    for i in range(count):
        lobe = lobes[i]
        factor = max(1.0 + model.damping * lobe.closing, 0.0)
        for j in range(lobe.n_strips):
            strips[i, j].p = amplitude[i]
        largest, normal, area, longest = set_pressures(strips[i], lobe.n_strips, factor)
        lobe.amplitude = amplitude[i] * factor
        lobe.p0 = max(largest, lobe.amplitude * lobe.half_length)
        lobe.N = normal
        if amplitude[i] == 0.0:
            lobe.n_strips = 0
        lobe.area = area
        lobe.length = 2.0 * longest


@kernel
def own_influence(strips: Records, n: int, half_length: float) -> float:
    """The double integral I of (norm-p0), [S 29], over n strips that include s = 0 [m2]; half_length: x_L(0)."""
    total = 0.0
    width = strips[0].ds
    for i in range(n):
        s = strips[i].s
        if abs(s) < 1e-9 * half_length:
            # strip_potential + 2 a ln|s| at s -> 0
            total += width * 2.0 * half_length * (log(4.0 * half_length) - 1.0)
        else:
            total += width * (strip_potential(strips[i].a, s) + 2.0 * half_length * log(abs(s)))
    start = max(0.5 * width - strips[0].s, 1e-12)
    end = max(strips[n - 1].s + 0.5 * width, 1e-12)
    # exact integral of -2 a ln|s| over the patch
    return total - 2.0 * half_length * (end * (log(end) - 1.0) + start * (log(start) - 1.0))


@kernel
def far_influence(strips: Records, n: int, o: float, b: float) -> float:
    """The same integral over the strips of another lobe, seen from the point (o, b) [m2]."""
    total = 0.0
    for i in range(n):
        if strips[i].a > 0.0:
            d = sqrt((strips[i].o - o) ** 2 + (strips[i].b - b) ** 2)
            total += strips[i].ds * strip_potential(strips[i].a, max(d, 1e-6))
    return total


@kernel
def solve_amplitudes(matrix: Array, count: int, rows: Array, amplitude: Array, pivot: Array) -> None:
    """Amplitudes Q of all lobes (norm-lobes). A lobe that would have to pull is lifted off by the others: its Q is 0.
    matrix: (count, count + 1), the right-hand side in the last column; rows: scratch of the same shape; amplitude:
    (count,), on entry 1 for lobes that take part and 0 for the others; pivot: (count,) scratch."""
    for _ in range(count):
        for i in range(count):
            for j in range(count + 1):
                rows[i, j] = matrix[i, j] if amplitude[i] > 0.0 else 0.0
            if amplitude[i] == 0.0:
                rows[i, i] = 1.0
        factorise(rows, count, pivot)
        solve_factorised(rows, count, pivot, rows[:, count])
        worst = -1
        for i in range(count):
            if amplitude[i] > 0.0 and rows[i, count] <= 0.0 and (worst < 0 or rows[i, count] < rows[worst, count]):
                worst = i
        if worst < 0:
            break
        amplitude[worst] = 0.0
    for i in range(count):
        amplitude[i] = max(rows[i, count], 0.0) if amplitude[i] > 0.0 else 0.0


@inlined
def twice_k_minus_e(p: float, b: float, c2: float) -> float:
    """2 p (K - E) of the parameter m = c2 / p^2, with b = p sqrt(1 - m) > 0 [the unit of p]. K = pi / (2 AGM(1, sqrt(1
    - m))) and K - E = K sum_n 2^(n-1) c_n^2 (Abramowitz and Stegun 17.6.4), c_0^2 = m, so nothing cancels at small m.
    Homogeneous in p: one division is left."""
    total = 0.5 * c2
    power = 1.0
    c = 0.0
    for _ in range(40):
        c = 0.5 * (p - b)
        b = sqrt(p * b)
        p -= c
        total += power * c * c
        if c < 1e-5 * p:
            break
        power *= 2.0
    # the next step would take c^2/(4 p) from p, and change the sum by c^4
    inverse = 1.0 / p
    rest = 0.5 * c * inverse
    return pi * total * inverse * (1.0 + rest * rest)


@inlined
def strip_potential(a: float, s: float) -> float:
    """The inner integral (norm-inner) over -a < x < a [m].

    The displacement (times pi E*) at distance s beside a strip of unit width that carries the semi-ellipse
    sqrt(a^2 - x^2): the inner integral of [S 29]. In closed form 2 sqrt(a^2 + s^2) (K(m) - E(m)) with
    m = a^2 / (a^2 + s^2). At s -> 0 it goes like 2 a (ln(4 a / |s|) - 1); s must not be zero.
    """
    return twice_k_minus_e(sqrt(a * a + s * s), abs(s), a * a)
