"""A system about one of its states: derivatives of the forces, mass, damping and stiffness matrices, state matrix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wrsim.simulation.bodies import Solid, mass_matrix, velocity_forces
from wrsim.simulation.force_law import Array, ForceLaw, FunctionLaw, force_derivative


@dataclass(frozen=True)
class Linearised:
    """mass q_tt + damping q_t + stiffness q = 0 for small motions about a state, all (n, n); bodies: how many.

    Behind the coordinates of the bodies stand those of the dampers in series with springs, whose rates are the
    extensions of the damping parts, and of sliders (their places: ``sliders``), which stick; behind them ``positions``
    more: the pitch of axle boxes, the twist of axles and the displacements of the rails under the wheels.
    """

    mass: Array
    damping: Array
    stiffness: Array
    bodies: int
    positions: int = 0
    sliders: tuple[int, ...] = ()

    @property
    def state_matrix(self) -> Array:
        """A of y_t = A y with y = (q of the bodies, positions of axle boxes and rails, q_t of the bodies, extensions
        of the dampers, velocities of axle boxes and rails). Sliders have no place in it."""
        n, m = len(self.mass), 6 * self.bodies
        full = np.zeros((2 * n, 2 * n))
        full[:n, n:] = np.eye(n)
        full[n:, :n] = -np.linalg.solve(self.mass, self.stiffness)
        full[n:, n:] = -np.linalg.solve(self.mass, self.damping)
        rates = np.delete(np.arange(n, 2 * n), self.sliders)
        kept = np.r_[0:m, n - self.positions : n, rates]
        return full[np.ix_(kept, kept)]


def linearise(forces: ForceLaw, bodies: Sequence[Solid], q: Array, q_t: Array, t: float = 0.0) -> Linearised:
    """Matrices of the small motions about a state without acceleration, gyroscopic terms included; sliders stick.

    On straight track a steady run is such a state; in a curve it is not, for the coordinates are global.
    """

    def inertia(t: float, q: Array, q_t: Array, out: Array) -> None:
        out[:] = velocity_forces(bodies, q, q_t)

    with forces.stuck():
        stiffness, damping = (
            force_derivative(FunctionLaw(inertia), q, q_t, len(bodies), t, *by)
            - force_derivative(forces, q, q_t, len(bodies), t, *by)
            for by in ((1.0, 0.0), (0.0, 1.0))
        )
    sliders = tuple(forces.sliders.tolist())
    return Linearised(mass_matrix(bodies, q), damping, stiffness, len(bodies), forces.positions, sliders)
