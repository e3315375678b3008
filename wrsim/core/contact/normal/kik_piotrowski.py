"""Normal pressure after Kik and Piotrowski on a curved patch [S 23-31].

Every strip carries a semi-ellipse p0 / x_L(0) sqrt(x_L(s)^2 - x^2) [S 28]; p0 follows from the displacement at the
main point, where the two surfaces together must yield the approach [S 29]:

    p0 = pi E* delta x_L(0) / I,   I = int ds int dx sqrt(x_L(s)^2 - x^2) / sqrt(x^2 + s^2)

with 1/E* = (1 - nu_w^2)/E_w + (1 - nu_r^2)/E_r, which for equal materials is the paper's E / (2 (1 - sigma^2)).
The inner integral is known (`elliptic.strip_potential`); it has a logarithm at s = 0 that is integrated in closed
form, so the sum over strips converges at second order.

With several lobes (`core.contact.search.lobes`) each has its own amplitude Q = p0 / x_L(0). The displacement at every
main point is the sum over all lobes, near or far, a far one weighted with the cosine of the angle between the normals:

    (1 - c_k) (sum_j I_kj Q_j - pi E* delta_k) + c_k I_kk (Q_k - Q_partner) = 0.

One lobe alone gives [S 29]; c = 1 gives one amplitude for the whole patch, again [S 29].

Yaw shifts the strips along x but is left out of I: each strip is taken centred on the main point's x.
"""

from math import log, pi, sqrt

from wrsim.core.compiling import kernel
from wrsim.core.contact.layout import DS, FORCE, A, B, O, P, S
from wrsim.core.contact.normal.elliptic import strip_potential


@kernel
def own_influence(strips, n, half_length):
    """The double integral I of [S 29] over n strips that include s = 0 [m2]; half_length: x_L(0)."""
    total = 0.0
    width = strips[0, DS]
    for i in range(n):
        s = strips[i, S]
        if abs(s) < 1e-9 * half_length:
            # strip_potential + 2 a ln|s| at s -> 0
            total += width * 2.0 * half_length * (log(4.0 * half_length) - 1.0)
        else:
            total += width * (strip_potential(strips[i, A], s) + 2.0 * half_length * log(abs(s)))
    start = max(0.5 * width - strips[0, S], 1e-12)
    end = max(strips[n - 1, S] + 0.5 * width, 1e-12)
    # exact integral of -2 a ln|s| over the patch
    return total - 2.0 * half_length * (end * (log(end) - 1.0) + start * (log(start) - 1.0))


@kernel
def far_influence(strips, n, o, b):
    """The same integral over the strips of another lobe, seen from the point (o, b) [m2]."""
    total = 0.0
    for i in range(n):
        if strips[i, A] > 0.0:
            d = sqrt((strips[i, O] - o) ** 2 + (strips[i, B] - b) ** 2)
            total += strips[i, DS] * strip_potential(strips[i, A], max(d, 1e-6))
    return total


@kernel
def solve_amplitudes(matrix, count, rows, amplitude):
    """Amplitudes Q of all lobes. A lobe that would have to pull is lifted off by the others: its Q is zero.

    matrix: (count, count + 1), the right-hand side in the last column; rows: scratch of the same shape; amplitude:
    (count,), on entry 1 for lobes that take part and 0 for the others.
    """
    for _ in range(count):
        for i in range(count):
            for j in range(count + 1):
                rows[i, j] = matrix[i, j] if amplitude[i] > 0.0 else 0.0
            if amplitude[i] == 0.0:
                rows[i, i] = 1.0
        _eliminate(rows, count)
        worst = -1
        for i in range(count):
            if amplitude[i] > 0.0 and rows[i, count] <= 0.0 and (worst < 0 or rows[i, count] < rows[worst, count]):
                worst = i
        if worst < 0:
            break
        amplitude[worst] = 0.0
    for i in range(count):
        amplitude[i] = max(rows[i, count], 0.0) if amplitude[i] > 0.0 else 0.0


@kernel
def _eliminate(rows, n):
    """Gauss-Jordan with row pivots in place; the solution is left in column n."""
    for c in range(n):
        pivot = c
        for i in range(c + 1, n):
            if abs(rows[i, c]) > abs(rows[pivot, c]):
                pivot = i
        for j in range(n + 1):
            rows[c, j], rows[pivot, j] = rows[pivot, j], rows[c, j]
        inverse = 1.0 / rows[c, c]
        for j in range(n + 1):
            rows[c, j] *= inverse
        for i in range(n):
            if i != c:
                f = rows[i, c]
                for j in range(n + 1):
                    rows[i, j] -= f * rows[c, j]


@kernel
def set_pressures(strips, n, amplitude, factor):
    """Write P (peak pressure of each strip) and FORCE (its normal force [S 30]).

    amplitude: Q = p0 / x_L(0) [Pa/m]; factor: multiplies the pressures (damping).
    Returns (largest pressure, sum of the strip forces, area, longest half length).
    """
    ratio = amplitude * factor
    force = 0.0
    area = 0.0
    longest = 0.0
    for i in range(n):
        a = strips[i, A]
        strips[i, P] = ratio * a
        strips[i, FORCE] = 0.5 * pi * ratio * a * a * strips[i, DS]
        force += strips[i, FORCE]
        area += 2.0 * a * strips[i, DS]
        longest = max(longest, a)
    return ratio * longest, force, area, longest
