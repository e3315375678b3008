"""A system about one of its states: derivatives of the forces, mass, damping and stiffness matrices, state matrix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wrsim.simulation.bodies import Solid, mass_matrix, velocity_forces
from wrsim.simulation.newton import DIFFERENCE
from wrsim.simulation.system import COORDINATES, Array, ForceLaw

SMALL = {"z": 1e-5, "x": 1e-2, "y": 1e-4, "heading": 1e-4, "roll": 1e-5, "spin": 1e-2}
"""Change of a coordinate [m, rad], or of its rate per second, that changes the forces by a few per cent."""

SMALL_EXTENSION = 1e-4
"""Change of the extension of a damper in series with a spring [m], and of the pitch of an axle box [rad]; forces are
linear in it or nearly so."""


def rails_of(forces: ForceLaw) -> int:
    """How many of a law's last coordinates are displacements of rails."""
    return int(getattr(forces, "rails", 0))


def positions_of(forces: ForceLaw) -> int:
    """How many of a law's last coordinates are positions, of axle boxes and rails: they count, unlike those of
    dampers."""
    return int(getattr(forces, "positions", 0))


def force_derivatives(
    forces: ForceLaw, q: Array, q_t: Array, bodies: int, t: float = 0.0, rails: int = 0
) -> tuple[Array, Array]:
    """Derivatives of the generalised forces with respect to q and to q_t, each (n, n), by central differences."""
    n = len(q)
    out = np.zeros(n)
    own = DIFFERENCE * np.array([SMALL[name] for name in COORDINATES] * bodies)
    dampers = np.full(n - own.size - rails, SMALL_EXTENSION)
    steps = np.concatenate([own, dampers, DIFFERENCE * np.array([SMALL["y"], SMALL["z"]] * (rails // 2))])
    found = []
    for which in range(2):
        columns = np.zeros((n, n))
        for i in range(n):
            both = []
            for sign in (1.0, -1.0):
                state = [np.array(q, dtype=float), np.array(q_t, dtype=float)]
                state[which][i] += sign * steps[i]
                forces(t, state[0], state[1], out)
                both.append(out.copy())
            columns[:, i] = (both[0] - both[1]) / (2.0 * steps[i])
        found.append(columns)
    return found[0], found[1]


@dataclass(frozen=True)
class Linearised:
    """mass q_tt + damping q_t + stiffness q = 0 for small motions about a state, all (n, n); bodies: how many.

    Behind the coordinates of the bodies stand those of the dampers in series with springs, whose rates are the
    extensions of the damping parts; behind them ``positions`` more: the pitch of axle boxes and the displacements
    of the rails under the wheels.
    """

    mass: Array
    damping: Array
    stiffness: Array
    bodies: int
    positions: int = 0

    @property
    def state_matrix(self) -> Array:
        """A of y_t = A y with y = (q of the bodies, positions of axle boxes and rails, q_t of the bodies, extensions
        of the dampers, velocities of axle boxes and rails)."""
        n, m = len(self.mass), 6 * self.bodies
        full = np.zeros((2 * n, 2 * n))
        full[:n, n:] = np.eye(n)
        full[n:, :n] = -np.linalg.solve(self.mass, self.stiffness)
        full[n:, n:] = -np.linalg.solve(self.mass, self.damping)
        kept = np.r_[0:m, n - self.positions : n, n : 2 * n]
        return full[np.ix_(kept, kept)]


def linearise(forces: ForceLaw, bodies: Sequence[Solid], q: Array, q_t: Array, t: float = 0.0) -> Linearised:
    """Matrices of the small motions about a state without acceleration, gyroscopic terms included.

    On straight track a steady run is such a state; in a curve it is not, for the coordinates are global.
    """

    def left_over(t: float, q: Array, q_t: Array, out: Array) -> None:
        forces(t, q, q_t, out)
        out -= velocity_forces(bodies, q, q_t)

    by_q, by_q_t = force_derivatives(left_over, q, q_t, len(bodies), t, rails_of(forces))
    return Linearised(mass_matrix(bodies, q), -by_q_t, -by_q, len(bodies), positions_of(forces))
