"""Kalker's linear theory on strips, without a bound or with that of Shen, Hedrick and Elkins.

FASTSIM's strips without slip: tractions that grow from the leading edge on by xi / L1, eta / L2 and phi x / L3 (the
deviation of a strip's creepage from the mean through L3). Integrated over a strip of half length a and width ds:

    Fx = -2 a^2 ds (xi_0 / L1 + (xi - xi_0) / L3)
    Fy = -2 a^2 ds (eta_0 / L2 + (eta - eta_0) / L3) - (2/3) a^3 ds phi / L3
    Mz = (2/3) a^3 ds eta / L3

On an ellipse the sums are (creep-linear) exactly, and Mz has the same C23 as Fy (reciprocity), which keeps the power of
the two against each other at zero. |T| may exceed mu N.

Saturated (Shen, Hedrick and Elkins 1983, after Vermeulen and Johnson) by (creep-she). Applied to each strip, not to the
patch, so that friction may differ by place; without spin that is the same. The moment falls with (1 - u/3) more, as in
full sliding it must, but not below what keeps the power of the strip from being positive.
"""

from math import sqrt

from wrsim.contact.creep.flexibility import Creepages, Rolling
from wrsim.jit import kernel


@kernel
def linear_creep(on: Rolling, mean: Creepages, saturated: float) -> None:
    """Forces (creep-linear) of the strips; mean: creepages over the patch; saturated: 1 with a bound, else 0."""
    strips, n, soft, direction, _shape, _work, _slip, _traction = on
    for i in range(n):
        strip = strips[i]
        area = 2.0 * strip.a * strip.a * strip.ds
        lever = area * strip.a / (3.0 * soft.l3)
        fx = -area * (mean.xi / soft.l1 + (strip.xi - mean.xi) / soft.l3)
        fy = -area * (mean.eta / soft.l2 + (strip.eta - mean.eta) / soft.l3) - direction * lever * strip.phi
        mz = direction * lever * strip.eta
        if saturated:
            size = sqrt(fx * fx + fy * fy)
            limit = strip.mu * strip.N
            scale = limit / max(size, 1e-300)
            u = 3.0
            if size < 3.0 * limit:
                u = size / limit
                scale = 1.0 - u / 3.0 + u * u / 27.0
            fx *= scale
            fy *= scale
            mz = limit_moment(fx * strip.xi + fy * strip.eta, strip.phi, scale * (1.0 - u / 3.0) * mz)
        strip.Fx = fx
        strip.Fy = fy
        strip.Mz = mz


@kernel
def limit_moment(power: float, phi: float, moment: float) -> float:
    """The moment, or the one that makes up for the power of the forces where both together would be positive."""
    return -power / phi if power + moment * phi > 0.0 and phi != 0.0 else moment
