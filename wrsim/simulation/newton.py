"""Damped Newton's method for balances of forces, and a bracketing search for what it cannot reach."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DIFFERENCE = 0.01
"""Step of the numerical derivative as a part of the change that matters."""

LONGEST = 30.0
"""Longest step of one iteration, in changes that matter."""


def newton(
    residual: Callable[[Array], Array],
    x: Array,
    small: Array,
    tolerance: float,
    max_iterations: int,
    near: Callable[[Array], Array] | None = None,
    while_deriving: Callable[[], AbstractContextManager[None]] = nullcontext,
) -> tuple[Array, Array, int]:
    """The best x, its residual (evaluated last), the iterations; the caller judges.

    small: changes of the unknowns that change the residual by a few per cent. near: a cheaper function with nearly the
    same derivatives, of which they are taken. while_deriving: what holds while derivatives are taken.
    """
    r = residual(x)
    damping = 0.0
    iteration = 0
    while iteration < max_iterations and np.max(np.abs(r)) > tolerance:
        iteration += 1
        with while_deriving():
            jacobian = _jacobian(near or residual, x, small)
        for _ in range(15):
            step = _solve(jacobian, -r, damping)
            step *= min(1.0, LONGEST / float(np.max(np.abs(step))))
            trial = residual(x + small * step)
            if np.linalg.norm(trial) < np.linalg.norm(r):  # false for not-a-number
                break
            damping = max(10.0 * damping, 1e-6)
        else:
            break
        x = x + small * step
        r = trial
        damping = 0.1 * damping if damping > 1e-6 else 0.0
    return x, residual(x), iteration


def _jacobian(residual: Callable[[Array], Array], x: Array, small: Array) -> Array:
    """Derivative of the residual with respect to x / small, by central differences."""
    columns = []
    for i in range(x.size):
        h = np.zeros(x.size)
        h[i] = DIFFERENCE * small[i]
        columns.append((residual(x + h) - residual(x - h)) / (2.0 * DIFFERENCE))
    return np.array(columns).T


def _solve(jacobian: Array, right: Array, damping: float) -> Array:
    """Levenberg's step; undamped the shortest least-squares one: the undetermined stays where it is."""
    if damping == 0.0:
        return np.asarray(np.linalg.lstsq(jacobian, right, rcond=1e-12)[0], dtype=float)
    normal = jacobian.T @ jacobian
    return np.linalg.solve(normal + damping * np.trace(normal) * np.eye(jacobian.shape[1]), jacobian.T @ right)


def bracket(function: Callable[[float], float], begin: float, small: float, enough: float, reach: float) -> bool:
    """Move from ``begin`` as the sign of the force points until it is small or changes sign, then bisect.

    function: force along a coordinate. Stops with its last call where abs(force) <= enough; False if there
    is no such place within ``reach``.
    """
    force = function(begin)
    if abs(force) <= enough:
        return True
    sign = 1.0 if force > 0.0 else -1.0
    inner, outer, move = begin, begin, small
    while force * sign > 0.0:
        if not move <= reach:
            return False
        inner, outer = outer, begin + sign * move
        force = function(outer)
        move *= 1.5
    for _ in range(80):
        if abs(force) <= enough:
            break
        middle = 0.5 * (inner + outer)
        force = function(middle)
        if force * sign > 0.0:
            inner = middle
        else:
            outer = middle
    return bool(np.isfinite(force))
