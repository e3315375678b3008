"""Pressures of half-spaces in contact at a given approach: a preconditioned conjugate gradient method with bounds.

Wanted are pressures p >= 0 with deformed gaps e = A p - pen >= 0 and p e = 0 in every element: the minimum of
1/2 p A p - pen p over p >= 0, A the influence matrix, pen the undeformed interpenetration at the prescribed approach.
Conjugate gradients run on the elements in contact; elements that would pull leave, elements that would overlap enter
(Polonsky and Keer, Wear 231, 1999). Preconditioned in Fourier space with the inverse symbol of A, |k| E*/2
(Vollebregt, Tribology Transactions 57, 2014), six to ten iterations reach 1e-4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.half_space.influence import Operator

Array = NDArray[np.float64]

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
    """Pressures that make the surfaces touch without overlap.

    pen: undeformed interpenetration (rows, columns) [m]; tolerance: largest error of the gap over the approach, the
    largest of pen; start: pressures to begin with.
    """
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
    gap, contact = u - pen, p > 0.0
    last, direction = np.zeros_like(pen), np.zeros_like(pen)
    rho, error = 0.0, np.inf
    for step in range(MOST_STEPS):
        residual = np.where(contact, gap, 0.0)
        error = float(max(np.abs(residual).max(), -gap.min(where=~contact, initial=0.0))) / approach
        if error < tolerance:
            return Pressure(p, gap, step, error, True)
        z = np.where(contact, operator.inverse.pressure(residual), 0.0)
        # Polak and Ribiere
        beta = max(float((z * (residual - last)).sum()) / rho, 0.0) if rho > 0.0 else 0.0
        rho, last = float((z * residual).sum()), residual
        direction = np.where(contact, z + beta * direction, 0.0)
        change = operator.normal(direction)
        curvature = float((direction * change).sum())
        if curvature > 0.0:
            # to the minimum along the direction; elements that would pull leave the contact
            way = float((gap * direction).sum()) / curvature
            gap -= way * change
            p -= way * direction
            pulling = p < 0.0
            if pulling.any():
                p[pulling] = 0.0
                contact &= ~pulling
                gap = operator.normal(p) - pen
        contact |= gap < -0.5 * tolerance * approach
    return Pressure(p, gap, MOST_STEPS, error, False)
