"""Normal pressure after Kik and Piotrowski on a curved patch [S 23-31].

Every strip carries a semi-ellipse p0 / x_L(0) sqrt(x_L(s)^2 - x^2) [S 28]; p0 follows from the displacement at the
main point, where the two surfaces together must yield the approach [S 29]:

    p0 = pi E* delta x_L(0) / I,   I = int ds int dx sqrt(x_L(s)^2 - x^2) / sqrt(x^2 + s^2)

with 1/E* = (1 - nu_w^2)/E_w + (1 - nu_r^2)/E_r, which for equal materials is the paper's E / (2 (1 - sigma^2)).
The inner integral is known (`elliptic.strip_potential`); it has a logarithm at s = 0 that is integrated in closed
form, so the sum over strips converges at second order.

Yaw shifts the strips along x but is left out of I: each strip is taken centred on the main point's x.
"""

from math import log, pi

from numba import njit

from wrsim.core.elliptic import strip_potential
from wrsim.core.patch import DS, FORCE, A, P, S


@njit(cache=True)
def influence_integral(strips, n, half_length):
    """The double integral I of [S 29] over n strips [m2]; half_length: x_L(0)."""
    total = 0.0
    width = strips[0, DS]
    for i in range(n):
        s = strips[i, S]
        a = strips[i, A]
        if abs(s) < 1e-9 * half_length:
            # strip_potential + 2 a ln|s| at s -> 0
            total += width * 2.0 * half_length * (log(4.0 * half_length) - 1.0)
        else:
            total += width * (strip_potential(a, s) + 2.0 * half_length * log(abs(s)))
    start = strips[0, S] - 0.5 * width
    end = strips[n - 1, S] + 0.5 * width
    # exact integral of -2 a ln|s| over the patch
    total -= 2.0 * half_length * (end * log(end) - end - start * log(-start) + start)
    return total


@njit(cache=True)
def kik_piotrowski(strips, n, delta, half_length, modulus, factor):
    """Pressure and force of each strip.

    delta: approach; half_length: x_L(0); modulus: E* [Pa]; factor: multiplies the pressures (damping).
    Writes P (peak pressure of the strip) and FORCE (its normal force [S 30]).
    Returns (p0 at the main point, sum of the strip forces, area).
    """
    p0 = pi * modulus * delta * half_length / influence_integral(strips, n, half_length) * factor
    ratio = p0 / half_length
    force = 0.0
    area = 0.0
    for i in range(n):
        a = strips[i, A]
        strips[i, P] = ratio * a
        strips[i, FORCE] = 0.5 * pi * ratio * a * a * strips[i, DS]
        force += strips[i, FORCE]
        area += 2.0 * a * strips[i, DS]
    return p0, force, area
