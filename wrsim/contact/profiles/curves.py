"""Arclength of plane curves, integrals along them, and points between given ones."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def arclengths(velocity: Callable[[Array], Array], t: Array) -> Array:
    """Arclength at the parameters t (n,) of a plane curve from t[0], given its derivative (n, 2) as a function."""
    return np.append(0.0, np.cumsum(gauss_integrals(lambda x: np.hypot(*velocity(x).T), t[:-1], t[1:], 8)))


AT_ONCE = 10_000  # integrals that are taken side by side: some 10 MB
_gauss = lru_cache(np.polynomial.legendre.leggauss)


def gauss_integrals(function: Callable[[Array], Array], start: Array, end: Array, points: int) -> Array:
    """Integrals of function(s (m,)) -> (m, ...) from start to end, both (n,), by Gauss-Legendre quadrature."""
    if start.size > AT_ONCE:  # a long track has millions of points
        parts = [slice(i, i + AT_ONCE) for i in range(0, start.size, AT_ONCE)]
        return np.concatenate([gauss_integrals(function, start[part], end[part], points) for part in parts])
    middle, half = 0.5 * (start + end), 0.5 * (end - start)
    place, weight = _gauss(points)
    values = function((middle + place[:, None] * half).ravel())
    total = sum(w * row for w, row in zip(weight, values.reshape(points, -1, *values.shape[1:]), strict=True))
    return np.asarray((np.asarray(total).T * half).T)


def subdivided(edges: Array, pieces: Array) -> Array:
    """The edges (n + 1,) and equally spaced points that part interval i into pieces[i] (at least one)."""
    count = np.maximum(1, np.asarray(pieces)).astype(int)
    first = np.repeat(np.cumsum(count) - count, count)
    share = (np.arange(count.sum()) - first) / np.repeat(count, count)
    begin, length = np.repeat(edges[:-1], count), np.repeat(np.diff(edges), count)
    return np.append(begin + share * length, edges[-1])
