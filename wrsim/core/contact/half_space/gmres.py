"""Generalised minimal residuals: one step of Arnoldi's method with Givens' rotations (Saad and Schultz 1986).

Plain loops: a threaded library would wait for busy cores.
"""

from math import sqrt
from typing import Any, NamedTuple

from wrsim.core.compiling import kernel


class Krylov(NamedTuple):
    """basis: (steps + 1, n) orthonormal; columns: (steps, steps + 1) of Arnoldi's matrix, rotated to a triangle.

    cosines, sines: (steps,) of the rotations; rhs: (steps + 1,) turned right hand side; y: (steps,).
    """

    basis: Any
    columns: Any
    cosines: Any
    sines: Any
    rhs: Any
    y: Any


@kernel
def extend(space, k):
    """Take row k + 1 of the basis into it (modified Gram and Schmidt). Returns the residual that then remains."""
    h = space.columns[k]
    w = space.basis[k + 1]
    for j in range(k + 1):
        v = space.basis[j]
        product = 0.0
        for i in range(w.size):
            product += v[i] * w[i]
        h[j] = product
        for i in range(w.size):
            w[i] -= product * v[i]
    size = 0.0
    for i in range(w.size):
        size += w[i] * w[i]
    size = sqrt(size)
    if size > 0.0:
        for i in range(w.size):
            w[i] /= size
    h[k + 1] = size
    return _rotate(h, k, space)


@kernel
def _rotate(h, k, space):
    """Turn the new column and the right hand side so that the column's last entry vanishes."""
    cosines, sines, g = space.cosines, space.sines, space.rhs
    for j in range(k):
        a = cosines[j] * h[j] + sines[j] * h[j + 1]
        h[j + 1] = -sines[j] * h[j] + cosines[j] * h[j + 1]
        h[j] = a
    size = sqrt(h[k] * h[k] + h[k + 1] * h[k + 1])
    cosines[k] = h[k] / size if size > 0.0 else 1.0
    sines[k] = h[k + 1] / size if size > 0.0 else 0.0
    h[k] = size
    h[k + 1] = 0.0
    g[k + 1] = -sines[k] * g[k]
    g[k] = cosines[k] * g[k]
    return abs(g[k + 1])


@kernel
def combine(space, k, x):
    """x = the combination of the first k vectors that leaves the least residual."""
    y = space.y
    for i in range(k - 1, -1, -1):
        value = space.rhs[i]
        for j in range(i + 1, k):
            value -= space.columns[j, i] * y[j]
        y[i] = value / space.columns[i, i] if space.columns[i, i] != 0.0 else 0.0
    x[:] = 0.0
    for j in range(k):
        v = space.basis[j]
        for i in range(x.size):
            x[i] += y[j] * v[i]
