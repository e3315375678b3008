"""Newton's method within the implicit steps of generalised alpha: first guess, estimates, and failure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wrsim.errors import SimulationError
from wrsim.simulation.force_law import COORDINATES, SMALL, Array
from wrsim.vehicle.dynamics import implicit_step as kernel

SPECTRAL_RADIUS = 0.9
"""Factor by which generalised alpha damps the fastest oscillation in a step."""


class GeneralizedAlpha(NamedTuple):
    """Parameters of generalised alpha."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float

    @classmethod
    def from_spectral_radius(cls, radius: float) -> GeneralizedAlpha:
        """The method that damps the fastest oscillation by a factor in a step."""
        alpha_m, alpha_f = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
        gamma = 0.5 + alpha_f - alpha_m
        return cls(alpha_m, alpha_f, 0.25 * (gamma + 0.5) ** 2, gamma)

    def increments(self, step: float) -> tuple[float, float]:
        """Changes of q and q_t for a change of q_tt in a step [s]."""
        of_acceleration = step * step * self.beta * (1.0 - self.alpha_f) / (1.0 - self.alpha_m)
        return of_acceleration, of_acceleration * self.gamma / (step * self.beta)


METHOD = GeneralizedAlpha.from_spectral_radius(SPECTRAL_RADIUS)

WEIGHTS = np.array([SMALL[name] for name in COORDINATES]) ** -2.0
"""Weights of the coordinates of a body in Broyden's update, and in the sums of which accelerations are predicted."""

NOT_SOLVED = "Newton's method does not find the end of a time step"


class NotSolved(SimulationError):
    """Newton's method has not found the end of a step."""


class ImplicitStep:
    """Newton's method within a call of ``BodySystem.solve``; its state is a record and arrays, its method is compiled
    (``dynamics.implicit_step``)."""

    def __init__(
        self, q: Array, q_t: Array, q_tt: Array, bodies: int, rails: int, step: float, tolerance: float,
        max_residual: float | None,
    ) -> None:  # fmt: skip
        """q, q_t, q_tt: arrays of the solver, bodies first, rails last; the others: see ``BodySystem.solve``."""
        self.q, self.q_t, self.q_tt = q, q_t, q_tt
        record = np.zeros(1, kernel.STEP)
        record["q_of_q_tt"], record["q_t_of_q_tt"] = METHOD.increments(step)
        record["tolerance"], record["max_residual"] = tolerance, tolerance if max_residual is None else max_residual
        for name in ("predicted", "residual", "force_change", "ratio"):
            record[name] = np.inf
        record["bodies"], record["rails"] = bodies, rails
        record["iteration"], record["estimates"] = -1, max_residual is not None
        self.record, self._iteration, self._counted, self._begins = record, record["iteration"], -1, True
        self.rows, self.jacobian = np.zeros((kernel.ROWS, q.size)), np.zeros((q.size, q.size))
        self._sums, self._fit = np.zeros((kernel.ORDER + 1,) * 2), np.zeros((kernel.ORDER + 2, kernel.ORDER))
        self.computed_at = tolerance, self.rows[kernel.COMPUTED_AT]
        """Tolerance, and coordinates of the last computed forces."""
        self.rows[kernel.WEIGHTS, : 6 * bodies] = np.tile(WEIGHTS, bodies)
        self.rows[kernel.WEIGHTS, q.size - rails :] = np.tile([SMALL["y"] ** -2.0, SMALL["z"] ** -2.0], rails // 2)

    def end_step(self) -> None:
        """Predict the accelerations of the next step."""
        kernel.end_step(self.record, self.rows, self._sums, self._fit, self.q_tt)

    def begin_iteration(self, iteration: int) -> bool:
        """Called ahead of every residual; the first one of a step starts from the prediction. Returns whether the
        solver begins this step again, from its own guess: it does not count an iteration then."""
        again = 0 < iteration == self._counted
        self._counted, self._begins = iteration, iteration == 0 or again
        if self._begins:
            kernel.predict(self.record, self.rows, self.q, self.q_t, self.q_tt)
        else:
            self._iteration[0] = iteration
        return again

    def held(self) -> None:
        """The law has changed this iteration: it says nothing about a new Jacobian."""
        self.record["new"] = 0

    def set_jacobian(self, derivative: Array, by_q: float) -> None:
        """Take a new derivative of the forces with respect to by_q q."""
        kernel.set_jacobian(self.record, self.jacobian, derivative, by_q)

    def estimate(self, out: Array) -> bool:
        """Fill ``out`` with the predicted forces and return True, where that ends the iteration."""
        return not self._begins and kernel.estimate(self.record, self.rows, self.jacobian, self.q, out)

    def update(self, forces: Array) -> int:
        """Compare computed forces with the prediction; -1, or the index of a force that is not finite.

        Raises NotSolved where the method does not converge.
        """
        status = kernel.update(self.record, self.rows, self.jacobian, self.q, forces)
        if status == kernel.NOT_SOLVED:
            raise NotSolved(NOT_SOLVED)
        return status
