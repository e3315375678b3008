"""Pseudo-transient continuation: a vehicle creeps, without masses and dampers, to where nothing pushes it.

Newton's method looks for less and less force. Wheels that turn on their own have next to none between their flanges,
and more on the way out of it: the way to the balance leads over hills. So every unknown moves as the force along it
pushes, x_t = r / d, like a wheelset that its creep forces hold back, in implicit steps of Euler that become longer as
the motion dies away: (d / h - r') dx = r. After Kelley and Keyes, Convergence analysis of pseudo-transient
continuation, SIAM J. Numer. Anal. 35 (1998) 508.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager

import numpy as np

from wrsim.simulation.newton import Array, derivatives

DRAG = 1e-3
"""Residual that moves an unknown by one small change in a unit of the pseudo-time."""

FIRST, LONGER, SHORTER = 1.0, 3.0, 0.25
"""The first step in pseudo-time, and what becomes of one that was easy, and of one that failed."""

REACH, EASY = 10.0, 3.0
"""Longest change in a step, in small changes, and one after which the next step may be longer."""

ASTRAY = 0.7
"""Part of the residual by which a step may miss the equation that it solves to first order."""

CREEPS = 15
"""The search ends after so many steps that were cut and changed no unknown by its small change."""

TRIES = 12
"""Steps tried one after the other, each shorter, before the search ends."""


def relax(
    residual: Callable[[Array], Array],
    x: Array,
    small: Array,
    goal: float,
    most: int,
    settled: Callable[[Array], Array],
    while_deriving: Callable[[], AbstractContextManager[None]],
) -> tuple[Array, float]:
    """The x (n,) to which the motion has come after at most so many steps, and the largest residual there.

    residual: what pushes along every unknown; small (n,): changes of the unknowns that change it by a few per cent;
    goal: largest residual that ends the search; settled: puts some unknowns where their own residuals vanish;
    while_deriving: what holds while derivatives are taken.
    """
    x = settled(x)
    r, h, creeps = residual(x), FIRST, 0
    for _ in range(most):
        if np.max(np.abs(r)) <= goal or creeps == CREEPS:
            break
        with while_deriving():
            slope = derivatives(residual, x, small)
        for _ in range(TRIES):
            step = np.linalg.solve(np.diag(np.full(x.size, DRAG / h)) - slope, r)
            far = float(np.max(np.abs(step)))
            if far <= REACH:
                there = settled(x + small * step)
                trial = residual(there)
                missed = float(np.linalg.norm(DRAG / h * step - trial))
                if missed <= ASTRAY * max(float(np.linalg.norm(r)), float(np.linalg.norm(trial))):  # false for nan
                    break
            h *= SHORTER
        else:
            break
        x, r = there, trial
        creeps += far < 1.0 and h < FIRST
        if far < EASY:
            h *= LONGER
    return x, float(np.max(np.abs(r)))
