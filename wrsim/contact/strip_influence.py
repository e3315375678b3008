"""The table of a strip's influence that `core.contact.strips.influence` reads."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import ellipe, ellipkm1

from wrsim.core.contact.strips.influence import CUTS, LOWEST, PIECES

Array = NDArray[np.float64]

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
    """(PIECES, 8), see `core.contact.strips.influence`: cubics through values and slopes at the ends of the pieces."""
    number = np.arange(PIECES + 1)
    t = np.ldexp(1.0 + (number & ((1 << CUTS) - 1)) / 2.0**CUTS, LOWEST + (number >> CUTS))
    x, w = np.polynomial.legendre.leggauss(8)
    half = 0.5 * np.diff(t)
    at = t[:-1, None] + half[:, None] * (1.0 + x)
    f, first = potential(at), t[0] * 2.0 * np.log(4.0 / t[0])  # f(1, t) = 2 ln(4/t) - 2 for small t
    table = []
    for integral, slope in (
        (f @ w * half, potential(t)),
        (f / (1.0 + at**2) @ w * half, potential(t) / (1.0 + t**2)),
    ):
        value = np.concatenate([[first], first + np.cumsum(integral)])
        rise = 2.0 * half * slope[:-1], 2.0 * half * slope[1:]
        table += [value[:-1], rise[0], 3.0 * integral - 2.0 * rise[0] - rise[1], rise[0] + rise[1] - 2.0 * integral]
    return np.ascontiguousarray(np.transpose(table))
