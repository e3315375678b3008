"""Pressures of half-spaces in contact at a given approach: the loop around contact.half_space.normal_kernel."""

from dataclasses import dataclass

import numpy as np

from wrsim.contact.half_space import normal_kernel as normal
from wrsim.contact.half_space.influence import Operator
from wrsim.jit import Array

FIRST_LEVEL = 0.45  # of the approach: where the first guess of the pressure begins
MOST_STEPS = 200


@dataclass(frozen=True)
class Pressure:
    """Pressures (rows, columns) [Pa], the deformed gap [m], steps taken, and the largest error over the approach."""

    p: Array
    gap: Array
    steps: int
    error: float
    converged: bool


def solve_normal(operator: Operator, pen: Array, tolerance: float = 1e-4, start: Array | None = None) -> Pressure:
    """Pressures that make the surfaces touch without overlap. pen: undeformed interpenetration (rows, columns) [m];
    tolerance: largest error of the gap over the approach, the largest of pen; start: pressures to begin with."""
    approach = float(pen.max())
    if approach <= 0.0:
        return Pressure(np.zeros_like(pen), -pen, 0, 0.0, True)
    if start is not None and start.shape == pen.shape and start.max() > 0.0:
        p = start.copy()
        u = operator.normal(p)
    else:
        # semi-ellipses
        p = np.sqrt(np.maximum(pen - FIRST_LEVEL * approach, 0.0))
        u = operator.normal(p)
        scale = float((p * pen).sum() / (p * u).sum())
        p *= scale
        u *= scale
    gap = u - pen
    contact, residual = p > 0.0, np.zeros_like(pen)
    fields = (p, gap, contact, residual, np.zeros_like(pen), np.zeros_like(pen))
    descent = normal.Descent(*(field.reshape(-1) for field in fields))
    direction = descent.direction.reshape(pen.shape)
    rho, error = 0.0, np.inf
    for step in range(MOST_STEPS):
        error = max(normal.errors(descent)) / approach
        if error < tolerance:
            return Pressure(p, gap, step, error, True)
        rho = normal.turn(descent, operator.inverse.pressure(residual).reshape(-1), rho)
        if normal.advance(descent, operator.normal(direction).reshape(-1)):
            np.subtract(operator.normal(p), pen, out=gap)
        normal.admit(descent, 0.5 * tolerance * approach)
    return Pressure(p, gap, MOST_STEPS, error, False)
