"""Polach's creep forces (1999, with the reduction factors of 2005) on the equivalent ellipse.

With F and v_c of (creep-polach),

    Fx = -F xi / v_c,   Fy = -F eta / v_c + (9/16) mu N a K S phi / v_c,   S = 1 + 6.3 (1 - exp(-a/b))
    K = |e| (d^3/3 - d^2/2 + 1/6) - sqrt((1 - d^2)^3) / 3,   d = (e^2 - 1) / (e^2 + 1),
    e = (8/3) G b sqrt(ab) C23 eta_c / (mu N S).

kA = kS = 1 is Kalker's linear slope; smaller ones (kS <= kA) describe wet or contaminated rails. |(Fx, Fy)| is held
below mu N. Polach gives no moment. Here there is one where the spin's share of Fy would push along the slip: as much
as it takes that creep does no positive work.
"""

from math import atan, exp, pi, sqrt

from wrsim.contact.creep.flexibility import Coefficients, Creepages, Ellipse
from wrsim.contact.creep.linear import limit_moment
from wrsim.jit import kernel

LARGE = 1e60  # creepages beyond are full sliding; their powers are still numbers


@kernel
def polach(
    creepages: Creepages, ellipse: Ellipse, coefficients: Coefficients, stiffness: float, adhesion: float, slip: float
) -> tuple[float, float, float]:
    """Fx, Fy over mu N and the moment over mu N [m], on the wheel, rolling along +x. stiffness: G / (mu N) [1/m2];
    adhesion, slip: kA, kS."""
    xi, eta, phi = creepages
    a, b = ellipse.a, ellipse.b
    c11, c22, c23 = coefficients
    turned = eta + phi * a
    if abs(turned) <= abs(eta):
        turned = eta
    whole = sqrt(xi * xi + turned * turned)
    stiffness = min(stiffness, LARGE)
    if whole == 0.0:
        return 0.0, 0.0, 0.0
    plain = sqrt(xi * xi + eta * eta)
    c = sqrt((c11 * xi) ** 2 + (c22 * eta) ** 2) / plain if plain > 0.0 else c22
    eps = min(0.25 * pi * a * b * c * stiffness * whole, LARGE)
    ratio = adhesion * eps
    force = 2.0 / pi * (ratio / (1.0 + ratio * ratio) + atan(slip * eps)) / whole
    s = 1.0 + 6.3 * (1.0 - exp(-a / b))
    e = min(8.0 / 3.0 * b * sqrt(a * b) * c23 * stiffness * abs(turned) / s, LARGE)
    inverse = 1.0 / (e * e + 1.0)
    d = (e * e - 1.0) * inverse
    root = 2.0 * e * inverse  # sqrt(1 - d^2)
    k = e * (d * d * d / 3.0 - d * d / 2.0 + 1.0 / 6.0) - root * root * root / 3.0
    spin = 0.5625 * a * k * s / whole
    fx = -force * xi
    fy = -force * eta + spin * phi
    scale = 1.0 / max(sqrt(fx * fx + fy * fy), 1.0)
    fx *= scale
    fy *= scale
    return fx, fy, limit_moment(fx * xi + fy * eta, phi, 0.0)
