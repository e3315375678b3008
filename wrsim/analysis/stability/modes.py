"""Modes of a rolling vehicle against its speed, and the linear critical speed.

Eigenvalues of the state matrix about steady rolling on straight track; the spin angles of the axles, on which nothing
depends, are left out, so that no eigenvalue is zero by nature.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from wrsim.simulation.modes import Linearised
from wrsim.simulation.system import Array

SLOWEST = 0.05  # frequency below which nothing is called an oscillation [Hz]
SPEED_TOLERANCE = 1e-4  # the critical speed is found to this part of itself
FAR = 0.7  # cost of two modes from which on they are no longer one: see ``_costs``


@dataclass(frozen=True)
class Modes:
    """Oscillating modes at one speed [m/s]: eigenvalues (n,) [1/s], imaginary parts positive; shapes (n, bodies, 6).

    largest: real part of the eigenvalue farthest to the right among all, oscillating or not.
    """

    speed: float
    values: NDArray[np.complex128]
    shapes: NDArray[np.complex128]
    largest: float


def modes_of(linear: Linearised, speed: float, wheelsets: int, highest: float) -> Modes:
    """Modes up to the frequency ``highest`` [Hz] of a vehicle whose first bodies are wheelsets."""
    m = 6 * linear.bodies
    spins = 6 * np.arange(wheelsets) + 5
    kept = np.setdiff1d(np.arange(linear.state_matrix.shape[0]), spins)
    values, vectors = np.linalg.eig(linear.state_matrix[np.ix_(kept, kept)])
    whole = np.zeros((m, len(values)), dtype=complex)
    own = kept < m
    whole[kept[own]] = vectors[own]
    oscillating = (values.imag > 2.0 * np.pi * SLOWEST) & (np.abs(values.imag) <= 2.0 * np.pi * highest)
    order = np.argsort(values[oscillating].imag)
    shapes = whole[:, oscillating].T[order].reshape(-1, linear.bodies, 6)
    return Modes(speed, values[oscillating][order], shapes, float(values.real.max()))


def follow(found: Sequence[Modes]) -> list[NDArray[np.intp]]:
    """For every speed the number of the branch that each mode belongs to; branches go on from speed to speed.

    A mode goes on as the one that is nearest in eigenvalue and shape; what has no such mode begins a branch.
    """
    branches = [np.arange(len(found[0].values))]
    next_branch = len(branches[0])
    for before, after in pairwise(found):
        own = np.full(len(after.values), -1)
        costs = _costs(before, after)
        for i, j in zip(*linear_sum_assignment(costs), strict=True):
            if costs[i, j] < FAR:
                own[j] = branches[-1][i]
        for j in np.flatnonzero(own < 0):
            own[j] = next_branch
            next_branch += 1
        branches.append(own)
    return branches


def _costs(before: Modes, after: Modes) -> Array:
    """How unlike two modes are, (n, m): distance of the eigenvalues over their size, and one minus their likeness.

    Likeness is the modal assurance criterion |a^H b|^2 / (|a|^2 |b|^2).
    """
    a, b = (m.shapes.reshape(len(m.values), -1) for m in (before, after))
    a, b = (s / np.linalg.norm(s, axis=1, keepdims=True) for s in (a, b))
    likeness = np.abs(a.conj() @ b.T) ** 2
    apart = np.abs(before.values[:, None] - after.values[None, :])
    scale = 0.5 * (np.abs(before.values)[:, None] + np.abs(after.values)[None, :])
    return np.asarray(apart / scale + 0.5 * (1.0 - likeness))


def critical(at: Callable[[float], Modes], found: Sequence[Modes]) -> Modes | None:
    """Modes at the lowest speed at which the largest real part passes zero upwards; None where it does not.

    at: modes at any speed; found: at rising speeds. Bisection between the two that embrace the passage. Already
    unstable at the first speed: its modes are the answer.
    """
    if found[0].largest > 0.0:
        return found[0]
    for low, high in pairwise(found):
        if high.largest > 0.0:
            below, above, last = low.speed, high.speed, high
            while above - below > SPEED_TOLERANCE * above:
                middle = at(0.5 * (below + above))
                if middle.largest > 0.0:
                    above, last = middle.speed, middle
                else:
                    below = middle.speed
            return last
    return None
