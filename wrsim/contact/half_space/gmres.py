"""Generalised minimal residuals for a linear system that is known by its products: the loop around the kernels."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from wrsim.core.contact.half_space.gmres import Krylov, combine, extend

Array = NDArray[np.float64]


class Gmres:
    """Workspace for systems of n unknowns, solved from zero without restart."""

    def __init__(self, n: int, steps: int) -> None:
        self._steps = steps
        self._space = Krylov(
            np.empty((steps + 1, n)), np.zeros((steps, steps + 1)), *np.zeros((2, steps)), np.zeros(steps + 1),
            np.zeros(steps),
        )  # fmt: skip

    def solve(self, product: Callable[[Array], Array], b: Array, tolerance: float, x: Array) -> None:
        """Write x so that product(x) is b to a relative tolerance."""
        space = self._space
        size = float(np.sqrt((b * b).sum()))
        x[:] = 0.0
        if size == 0.0:
            return
        space.rhs[0] = size
        np.divide(b, size, out=space.basis[0])
        for k in range(self._steps):
            space.basis[k + 1] = product(space.basis[k])
            if extend(space, k) <= tolerance * size:
                break
        combine(space, k + 1, x)
