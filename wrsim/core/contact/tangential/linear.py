"""Kalker's linear theory on strips, without a bound or with that of Shen, Hedrick and Elkins.

FASTSIM's strips without slip: tractions that grow from the leading edge on by xi / L1, eta / L2 and phi x / L3 (the
deviation of a strip's creepage from the mean through L3). Integrated over a strip of half length a and width ds:

    Fx = -2 a^2 ds (xi_0 / L1 + (xi - xi_0) / L3)
    Fy = -2 a^2 ds (eta_0 / L2 + (eta - eta_0) / L3) - (2/3) a^3 ds phi / L3
    Mz = (2/3) a^3 ds eta / L3

On an ellipse the sums are Kalker's -C11 G ab xi and -C22 G ab eta - C23 G (ab)^(3/2) phi exactly, and Mz has the same
C23 as Fy (reciprocity), which keeps the power of the two against each other at zero. |T| may exceed mu N.

Saturated (Shen, Hedrick and Elkins 1983, after Vermeulen and Johnson): with u = |F| / (mu N) of the strip, forces
times (1 - u/3 + u^2/27) for u < 3, and |F| = mu N beyond. Applied to each strip, not to the patch, so that friction
may differ by place; without spin that is the same. The moment falls with (1 - u/3) more, as in full sliding it must,
but not below what keeps the power of the strip from being positive.
"""

from math import sqrt

from wrsim.core.compiling import kernel
from wrsim.core.contact.layout import DS, ETA, FORCE, FX, FY, MU, MZ, PHI, XI, A


@kernel
def linear_creep(strips, n, xi0, eta0, l1, l2, l3, direction, saturated):
    """Forces of n strips; xi0, eta0: mean creepages; direction: +1 rolling along +x, -1 backwards.

    Reads A, DS, FORCE, MU, XI, ETA, PHI of each strip and writes FX, FY, MZ.
    """
    for i in range(n):
        row = strips[i]
        area = 2.0 * row[A] * row[A] * row[DS]
        lever = area * row[A] / (3.0 * l3)
        fx = -area * (xi0 / l1 + (row[XI] - xi0) / l3)
        fy = -area * (eta0 / l2 + (row[ETA] - eta0) / l3) - direction * lever * row[PHI]
        mz = direction * lever * row[ETA]
        if saturated:
            size = sqrt(fx * fx + fy * fy)
            limit = row[MU] * row[FORCE]
            scale = limit / max(size, 1e-300)
            u = 3.0
            if size < 3.0 * limit:
                u = size / limit
                scale = 1.0 - u / 3.0 + u * u / 27.0
            fx *= scale
            fy *= scale
            mz = restrain(fx * row[XI] + fy * row[ETA], row[PHI], scale * (1.0 - u / 3.0) * mz)
        row[FX] = fx
        row[FY] = fy
        row[MZ] = mz


@kernel
def restrain(power, phi, moment):
    """The moment, or the one that makes up for the power of the forces where both together would be positive."""
    return -power / phi if power + moment * phi > 0.0 and phi != 0.0 else moment
