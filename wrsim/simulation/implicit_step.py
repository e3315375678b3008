"""Newton's method within the implicit steps of generalised alpha: first guess, estimates, and failure."""

from __future__ import annotations

from typing import Literal

import numpy as np

from wrsim.errors import SimulationError
from wrsim.simulation.force_law import COORDINATES, SMALL, Array

Integrator = Literal["generalised-alpha", "rk44"]
"""The implicit method of Chung and Hulbert in the form of Arnold and Bruls (Multibody System Dynamics 18, 2007); or
Runge-Kutta's explicit one of fourth order."""

DEFAULT_INTEGRATOR: Integrator = "generalised-alpha"

SPECTRAL_RADIUS = 0.9
"""Factor by which generalised alpha damps the fastest oscillation in a step."""

CONTRACTION = 0.5
"""Newton's method retains its Jacobian as long as an iteration reduces the residual below this part of it."""

TREND = 0.5
"""Part of the last change of the accelerations that is extrapolated to the next step."""

SCALE = np.array([SMALL[name] for name in COORDINATES]) ** -2.0
"""Weights of the coordinates of a body in Broyden's update."""

NEAR, UNSEEN, FORGET = 30.0, 8, 0.9
"""Forces are estimated, not computed, where the expected residual is within the tolerance and their change, also since
the last step, within so many tolerances; in at most so many steps in succession. The contraction in a step counts as
this part of it in the next."""

MOST_ASTRAY = 2
"""New Jacobians in a step that predict less than half of the change, at which the method stops or fails."""

NOT_SOLVED = "Newton's method does not find the end of a time step"


class NotSolved(SimulationError):
    """Newton's method has not found the end of a step."""


class ImplicitStep:
    """State of Newton's method within a call of ``BodySystem.solve``; all of it are arrays and numbers.

    First guess: a step starts from the accelerations of the last one and a part of their trend; Exudyn starts from
    zero. Without the trend, the remaining residual lies on the same side step after step. q, q_t and q_tt change
    together, as in an iteration (Arnold and Bruls, algorithm 1).

    Estimates: the forces after an iteration differ from those predicted by the Jacobian by a part (``ratio``) of the
    predicted change. It is measured wherever forces are computed, and there the estimating Jacobian is updated
    (Broyden, body by body), not the one that Exudyn holds. Where the difference is sure to be within the
    tolerance, the prediction ends the iteration (the test of Hairer and Wanner, Solving
    Ordinary Differential Equations II, IV.8).

    Failure: where new Jacobians predict less than half of the change, the force is discontinuous.
    """

    def __init__(
        self, q: Array, q_t: Array, q_tt: Array, bodies: int, step: float, tolerance: float, loosest: float | None
    ) -> None:
        """q, q_t, q_tt: the solver's own arrays, bodies first; tolerance, loosest: see ``BodySystem.solve``."""
        rho = SPECTRAL_RADIUS
        alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
        gamma = 0.5 + alpha_f - alpha_m
        beta = 0.25 * (gamma + 0.5) ** 2
        of_acceleration = step * step * beta * (1.0 - alpha_f) / (1.0 - alpha_m)
        self.q, self.q_t, self.q_tt = q, q_t, q_tt
        self.q_of_q_tt = of_acceleration
        self.q_t_of_q_tt = of_acceleration * gamma / (step * beta)
        self.last, self.ahead = np.zeros((2, q.size))
        """Accelerations at the end of the last step, and those predicted for the next."""
        self.tolerance, self.may_estimate = tolerance, loosest is not None
        self.loosest = tolerance if loosest is None else loosest
        self.steps, self.iteration = 0, -1
        own = np.arange(6 * bodies).reshape(-1, 6)
        self.rows, self.columns = own[:, :, None], own[:, None, :]
        self.jacobian: Array | None = None
        self.at, self.forces, self.change = np.zeros((3, q.size))
        """Coordinates of the last computed forces, these forces, and their predicted change since."""
        self.predicted = self.residual = self.moved = np.inf
        """Norms [N]: of the predicted change, of its last error, and of the change since the last step."""
        self.ratio, self.unseen = np.inf, 0
        """Largest recent error of a prediction over the predicted change, and steps since it was last measured."""
        self.new, self.astray = False, 0
        """Whether the Jacobian is of this step, and how many of its predictions have failed."""

    def end_step(self) -> None:
        """Predict the accelerations of the next step."""
        self.ahead[:] = self.q_tt + TREND * (self.q_tt - self.last) if self.steps else self.q_tt
        self.last[:] = self.q_tt
        self.steps += 1

    def begin_iteration(self, iteration: int) -> None:
        """Called ahead of every residual; the first one of a step starts from the prediction."""
        self.iteration = iteration
        if iteration == 0:
            self.q_tt += self.ahead
            self.q_t += self.q_t_of_q_tt * self.ahead
            self.q += self.q_of_q_tt * self.ahead
            self.new, self.astray = False, 0

    def set_jacobian(self, derivative: Array, by_q: float) -> None:
        """Take a new derivative of the forces with respect to by_q q."""
        self.jacobian = derivative / by_q
        self.ratio, self.new = np.inf, True

    def estimate(self, out: Array) -> bool:
        """Fill ``out`` with the predicted forces and return True, where that ends the iteration."""
        if self.iteration < 1 or self.jacobian is None:
            return False
        np.dot(self.jacobian, self.q - self.at, out=self.change)
        self.predicted = float(np.linalg.norm(self.change))
        if not self.may_estimate:
            return False
        stuck = self.astray >= MOST_ASTRAY and self.residual <= self.loosest
        calm = max(self.predicted, self.moved if self.iteration == 1 else 0.0) <= NEAR * self.tolerance
        close = self.ratio <= CONTRACTION and self.ratio * self.predicted <= self.tolerance
        if not (stuck or (calm and close and self.unseen < UNSEEN)):
            return False
        self.unseen += 1
        np.add(self.forces, self.change, out=out)
        return True

    def update(self, forces: Array) -> None:
        """Compare computed forces with the prediction. Raises NotSolved where the method does not converge."""
        if self.iteration >= 1 and self.jacobian is not None:
            error = forces - self.forces - self.change
            self.residual = float(np.linalg.norm(error))
            if self.residual <= CONTRACTION * self.predicted:
                self._broyden(self.jacobian, error)
            ratio = self.residual / max(self.predicted, 1e-300)
            forgotten = 0.0 if self.iteration > 1 or not np.isfinite(self.ratio) else FORGET * self.ratio
            self.ratio, self.unseen = max(ratio, forgotten), 0
            if self.new and ratio > CONTRACTION:
                self.astray += 1
                if self.astray > MOST_ASTRAY and self.residual > self.loosest:
                    raise NotSolved(NOT_SOLVED)
        elif self.iteration == 0:
            self.moved = float(np.linalg.norm(forces - self.forces))
        self.forces[:] = forces
        self.at[:] = self.q

    def _broyden(self, jacobian: Array, error: Array) -> None:
        """Broyden's update, body by body: the Jacobian that would have predicted without error."""
        moved, missed = (x[: self.rows.size].reshape(-1, 6) for x in (self.q - self.at, error))
        scaled = SCALE * moved
        scaled /= np.maximum((scaled * moved).sum(axis=1, keepdims=True), 1e-300)
        jacobian[self.rows, self.columns] += missed[:, :, None] * scaled[:, None, :]
