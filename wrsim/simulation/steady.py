"""Steady motion along a track: what a force law leaves over when a wheelset follows the track with its pose held.

On straight track nothing accelerates. In a curve the wheelset is carried round: its centrifugal force and the
gyroscopic moment of its spin belong to the balance. How fast the curvature itself changes is left out, so the balance
is exact on straight track and in full curves, and close in transitions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wrsim.core.body import kinematics as kernels
from wrsim.errors import SimulationError
from wrsim.simulation.system import Array, ForceLaw, RigidBody

if TYPE_CHECKING:
    from wrsim.geometry.track.path import Path


class SteadyMotion:
    """Forces less inertia forces of a wheelset in steady motion; a ``ForceLaw`` whose zeros ``find_equilibrium`` finds.

    Of the state that it is asked for, the pose against the track and the spin rate count; the other rates are those
    of a wheelset that keeps this pose at the given speed. ``state`` returns them.
    """

    def __init__(self, forces: ForceLaw, body: RigidBody, centre: Path, *, speed: float, distance: float) -> None:
        """centre: line of the track; speed [m/s]; distance: where the wheelset is, within some metres [m]."""
        self.forces, self.body, self.centre = forces, body, centre
        self.speed, self.distance = speed, distance
        self._q, self._q_t, self._inertia = np.zeros(6), np.zeros(6), np.zeros(6)

    def __call__(self, t: float, q: Array, q_t: Array, out: Array) -> None:
        """See ``ForceLaw``."""
        turning = self._follow(q, q_t)
        self.forces(t, self._q, self._q_t, out)
        b = self.body
        kernels.steady_inertia(self._q, self._q_t, *turning, b.mass, b.spin_inertia, b.cross_inertia, self._inertia)
        out -= self._inertia

    def state(self, q: Array, q_t: Array) -> tuple[Array, Array]:
        """The steady state (q, q_t), each (6,), with the pose and the spin rate of the given one."""
        self._follow(q, q_t)
        return self._q.copy(), self._q_t.copy()

    def _follow(self, q: Array, q_t: Array) -> tuple[float, float, float]:
        """Set the steady state; returns the angular velocity of the track frame [rad/s]."""
        path = self.centre
        wx, wy, wz, status = kernels.follow(
            q, q_t, path.table, path.step, self.distance, self.speed, self._q, self._q_t
        )
        if status:
            raise SimulationError(f"the wheelset has no place on the track near {self.distance:g} m")
        return wx, wy, wz
