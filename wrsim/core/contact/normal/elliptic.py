"""Complete elliptic integrals by the arithmetic-geometric mean, in the one combination the strips need."""

from math import pi, sqrt

from wrsim.core.jit.compiling import inlined


@inlined
def twice_k_minus_e(p: float, b: float, c2: float) -> float:
    """2 p (K - E) of the parameter m = c2 / p^2, with b = p sqrt(1 - m) > 0 [the unit of p].

    K = pi / (2 AGM(1, sqrt(1 - m))) and K - E = K sum_n 2^(n-1) c_n^2 (Abramowitz and Stegun 17.6.4), c_0^2 = m, so
    nothing cancels at small m. Homogeneous in p: one division is left.
    """
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
    """Integral of sqrt((a^2 - x^2) / (x^2 + s^2)) dx over -a < x < a [m].

    The displacement (times pi E*) at distance s beside a strip of unit width that carries the semi-ellipse
    sqrt(a^2 - x^2): the inner integral of [S 29]. In closed form 2 sqrt(a^2 + s^2) (K(m) - E(m)) with
    m = a^2 / (a^2 + s^2). At s -> 0 it goes like 2 a (ln(4 a / |s|) - 1); s must not be zero.
    """
    return twice_k_minus_e(sqrt(a * a + s * s), abs(s), a * a)
