"""The table of a strip's influence that `core.contact.strips.influence` reads."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import ellipe, ellipkm1

from wrsim.core.contact.strips.influence import (
    F_SERIES,
    FAR,
    LARGE,
    NODES,
    PHI_SERIES,
    PSI_SERIES,
    SMALL,
    TABLE_ROWS,
)

Array = NDArray[np.float64]

TERMS = 4
CANCELS = 40.0  # beyond, K - E loses digits and the asymptotic series has them all


def potential(t: Array) -> Array:
    """f(1, t) = 2 sqrt(1 + t^2) (K - E) of the parameter 1/(1 + t^2), t > 0."""
    t = np.asarray(t, dtype=np.float64)
    complement = t * t / (1.0 + t * t)
    near = 2.0 * np.sqrt(1.0 + t * t) * (ellipkm1(complement) - ellipe(1.0 - complement))
    far = 0.5 * np.pi / t * (1.0 - 1.0 / (8.0 * t**2) + 3.0 / (64.0 * t**4))
    return np.where(t > CANCELS, far, near)


@cache
def influence_table() -> Array:
    """(TABLE_ROWS, 4), see `core.contact.strips.influence`."""
    table = np.zeros((TABLE_ROWS, 4))
    small = np.geomspace(1e-4, 1.3 * SMALL, 400)
    powers = np.column_stack([small ** (2 * i) for i in range(TERMS)])
    basis = np.hstack([powers, powers * np.log(small)[:, None]])
    f = np.linalg.lstsq(basis, potential(small), rcond=None)[0].reshape(2, TERMS)
    g = np.linalg.lstsq(basis, potential(small) / (1.0 + small**2), rcond=None)[0].reshape(2, TERMS)
    odd = 2.0 * np.arange(TERMS) + 1.0
    # int t^(2i) (A + L ln t) = t^(2i+1) (A/(2i+1) - L/(2i+1)^2 + L ln t/(2i+1))
    phi, psi = (np.stack([c[0] / odd - c[1] / odd**2, c[1] / odd]) for c in (f, g))
    table[F_SERIES : F_SERIES + 2] = f
    table[PHI_SERIES : PHI_SERIES + 2] = phi
    table[PSI_SERIES : PSI_SERIES + 2] = psi
    share = np.arange(NODES) / NODES
    t = share / (1.0 - share)
    first = int(np.ceil(0.8 * SMALL / (1.0 + 0.8 * SMALL) * NODES))
    start = t[first] ** (2 * np.arange(TERMS))
    value = [t[first] * float(c @ start @ [1.0, np.log(t[first])]) for c in (phi, psi)]
    x, w = np.polynomial.legendre.leggauss(8)
    for i in range(first, NODES):
        if i > first:
            half = 0.5 * (t[i] - t[i - 1])
            at = t[i - 1] + half * (1.0 + x)
            value[0] += half * float(w @ potential(at))
            value[1] += half * float(w @ (potential(at) / (1.0 + at**2)))
        slope = float(potential(t[i])) * (1.0 + t[i]) ** 2 / NODES
        table[i] = value[0], slope, value[1], slope / (1.0 + t[i] ** 2)
    i = int(LARGE / (1.0 + LARGE) * NODES)
    table[FAR, 0] = table[i, 0] - 0.5 * np.pi * (np.log(t[i]) + 0.0625 / t[i] ** 2)
    table[FAR, 1] = table[i, 2] + 0.25 * np.pi / t[i] ** 2 * (1.0 - 0.5625 / t[i] ** 2)
    return table
