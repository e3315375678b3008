"""Least residuals of a linear system over the vectors z whose images w = A z are orthonormal.

Generalised minimal residuals (Saad and Schultz 1986) without rotations: "simpler GMRES" (Walker and Zhou, Numerical
Linear Algebra with Applications 1, 1994). Plain loops: a threaded library would wait for busy cores.
"""

from math import sqrt

from wrsim.core.compiling import kernel


@kernel
def extend(z, w, k, x, r):
    """Take vector k and its image into the space, both (steps, n), and go to the least residual.

    Makes w[k] orthogonal to those before it and of unit length, z[k] follows; x and the residual r advance along them.
    Returns the size of the residual.
    """
    for j in range(k):
        share = _product(w[j], w[k])
        for i in range(r.size):
            w[k, i] -= share * w[j, i]
            z[k, i] -= share * z[j, i]
    size = sqrt(_product(w[k], w[k]))
    if size > 0.0:
        for i in range(r.size):
            w[k, i] /= size
            z[k, i] /= size
    step = _product(w[k], r)
    for i in range(r.size):
        x[i] += step * z[k, i]
        r[i] -= step * w[k, i]
    return sqrt(_product(r, r))


@kernel
def _product(a, b):
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total
