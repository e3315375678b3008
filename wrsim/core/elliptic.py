"""Complete elliptic integrals by the arithmetic-geometric mean, in the one combination the strips need."""

from math import pi, sqrt

from wrsim.core.compiling import inlined, kernel


@kernel
def k_minus_e(m, m1):
    """K(m) - E(m), complete elliptic integrals of parameter m; m1 = 1 - m is passed to keep its digits near m = 1.

    K = pi / (2 AGM(1, sqrt(m1))) and K - E = K sum_n 2^(n-1) c_n^2 (Abramowitz and Stegun 17.6.4), so nothing
    cancels at small m. Infinite at m = 1.
    """
    if m1 <= 0.0:
        return float("inf")
    a = 1.0
    b = sqrt(m1)
    total = 0.5 * m
    power = 1.0
    for _ in range(40):
        c = 0.5 * (a - b)
        b = sqrt(a * b)
        a -= c
        total += power * c * c
        if c < 1e-9 * a:
            break
        power *= 2.0
    return 0.5 * pi / a * total


@inlined
def strip_potential(a, s):
    """Integral of sqrt((a^2 - x^2) / (x^2 + s^2)) dx over -a < x < a [m].

    The displacement (times pi E*) at distance s beside a strip of unit width that carries the semi-ellipse
    sqrt(a^2 - x^2): the inner integral of [S 29]. In closed form 2 sqrt(a^2 + s^2) (K(m) - E(m)) with
    m = a^2 / (a^2 + s^2); written homogeneously so that only one division is left. At s -> 0 it goes like
    2 a (ln(4 a / |s|) - 1); s must not be zero.
    """
    p = sqrt(a * a + s * s)
    b = abs(s)
    total = 0.5 * a * a
    power = 1.0
    for _ in range(40):
        c = 0.5 * (p - b)
        b = sqrt(p * b)
        p -= c
        total += power * c * c
        if c < 1e-9 * p:
            break
        power *= 2.0
    return pi * total / p
