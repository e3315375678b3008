"""Stages of a step of wear and their weights: a Runge-Kutta-Chebyshev method.

Wear is stiff: it flattens a narrow bump of some 10 um within ten kilometres, while a step takes a hundred. Heun's
method overshoots there, and the profile oscillates from step to step. The method of second order of B. P. Sommeijer,
L. F. Shampine and J. G. Verwer (RKC: an explicit solver for parabolic PDEs, Journal of Computational and Applied
Mathematics 88, 1998) is stable for steps of 0.65 (s^2 - 1) over the fastest rate with s stages: 9.8 with four, where
two steps of Heun's method have 4.
"""

from functools import cache

import numpy as np
from numpy.polynomial.chebyshev import Chebyshev
from numpy.typing import NDArray

Array = NDArray[np.float64]

STAGES = 4
"""Profiles on which the cases run in one step of wear."""
DAMPING = 2.0 / 13.0


@cache
def tableau() -> tuple[Array, Array]:
    """Weights (STAGES, STAGES) of the rates before each stage, and those of all of them for the step (STAGES,)."""
    s = STAGES
    w0 = 1.0 + DAMPING / s**2
    bases = [Chebyshev.basis(j) for j in range(s + 1)]
    T, T1, T2 = (np.array([basis.deriv(m)(w0) if m else basis(w0) for basis in bases]) for m in range(3))
    w1 = T1[s] / T2[s]
    b = np.zeros(s + 1)
    b[2:] = T2[2:] / T1[2:] ** 2
    b[:2] = b[2]
    weights = np.zeros((s + 1, s))
    weights[1, 0] = b[1] * w1
    for j in range(2, s + 1):
        mine = 2.0 * b[j] * w1 / b[j - 1]
        weights[j] = 2.0 * b[j] * w0 / b[j - 1] * weights[j - 1] - b[j] / b[j - 2] * weights[j - 2]
        weights[j, j - 1] += mine
        weights[j, 0] -= (1.0 - b[j - 1] * T[j - 1]) * mine
    return weights[:s], weights[s]
