"""Newton's method within the implicit steps of generalised alpha: how it begins, ends and gives up."""

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
"""What generalised alpha leaves of the fastest oscillation from step to step."""

CONTRACTION = 0.5
"""Newton's method keeps its Jacobian as long as an iteration leaves less than this of the residual."""

TREND = 0.5
"""Part of the last change of the accelerations that is taken to go on in the next step."""

SCALE = np.array([SMALL[name] for name in COORDINATES]) ** -2.0
"""Weights of the coordinates of a body in Broyden's update."""

NEAR, UNSEEN, FORGET = 30.0, 8, 0.9
"""Forces are estimated, not computed, where what should be left is within the tolerance and their change, also that
since the last step, is no more than so many tolerances; at most in so many steps one after the other. What was left in
a step counts as this part of it in the next."""

MOST_ASTRAY = 2
"""New Jacobians in a step that predict less than half of what happens, before the method ends where it is, or fails.
"""


class NotSolved(SimulationError):
    """Newton's method has not found the end of a step."""


class ImplicitStep:
    """Newton's method within a call of ``BodySystem.solve``: its first guess, its last answer, and when it gives up.

    First guess: a step starts from the accelerations of the last one and a part of their trend; Exudyn starts from
    none. Without the trend, what the method does not finish lies on the same side step after step. This is a user
    function that is called before every residual. q, q_t and q_tt then change together, as they do in an iteration
    (Arnold and Bruls, algorithm 1).

    Last answer: the forces after an iteration differ from those that the Jacobian predicts by a part of the change
    that it predicts (``ratio``), which shows wherever they are computed, and bends the estimate (Broyden's update,
    body by body), not the Jacobian that Exudyn keeps. Where the difference is sure to be within the
    tolerance they are not computed: the estimate ends the iteration (the test of Hairer and Wanner, Solving
    Ordinary Differential Equations II, IV.8).

    Giving up: where new Jacobians predict nothing, the force jumps, and iterations lead nowhere.
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
        self.tolerance, self.may_estimate = tolerance, loosest is not None
        self.loosest = tolerance if loosest is None else loosest
        self.steps, self.iteration = 0, -1
        own = np.arange(6 * bodies).reshape(-1, 6)
        self.rows, self.columns = own[:, :, None], own[:, None, :]
        self.jacobian: Array | None = None
        self.at, self.forces, self.change = np.zeros((3, q.size))
        """State of the last forces that were computed, these, and their change since by the Jacobian."""
        self.size = self.left = self.moved = np.inf
        """Norms [N]: of that change, of what the last one has left of the forces, and of their change since the last
        step."""
        self.ratio, self.unseen = np.inf, 0
        """The largest part that was left of late, and for how many steps it has not been looked at."""
        self.new, self.astray = False, 0
        """Whether the Jacobian is of this step, and how often it has predicted nothing."""

    def keep(self) -> None:
        """Take note of the accelerations at the end of a step."""
        self.ahead[:] = self.q_tt + TREND * (self.q_tt - self.last) if self.steps else self.q_tt
        self.last[:] = self.q_tt
        self.steps += 1

    def __call__(self, mbs: object, t: float, iteration: int, repetition: int) -> None:
        self.iteration = iteration
        if iteration == 0:
            self.q_tt += self.ahead
            self.q_t += self.q_t_of_q_tt * self.ahead
            self.q += self.q_of_q_tt * self.ahead
            self.new, self.astray = False, 0

    def take(self, derivative: Array, by_q: float) -> None:
        """A Jacobian has been computed: derivative of the forces for a change of q by ``by_q``."""
        self.jacobian = derivative / by_q
        self.ratio, self.new = np.inf, True

    def estimates(self, out: Array) -> bool:
        """Fill ``out`` with the forces that the Jacobian predicts and return True, if that ends the iteration."""
        if self.iteration < 1 or self.jacobian is None:
            return False
        np.dot(self.jacobian, self.q - self.at, out=self.change)
        self.size = float(np.linalg.norm(self.change))
        if not self.may_estimate:
            return False
        stuck = self.astray >= MOST_ASTRAY and self.left <= self.loosest
        calm = max(self.size, self.moved if self.iteration == 1 else 0.0) <= NEAR * self.tolerance
        close = self.ratio <= CONTRACTION and self.ratio * self.size <= self.tolerance
        sure = calm and close and self.unseen < UNSEEN
        if not (stuck or sure):
            return False
        self.unseen += 1
        np.add(self.forces, self.change, out=out)
        return True

    def _bend(self, jacobian: Array, left: Array) -> None:
        """Broyden's update of the estimating Jacobian, body by body: the one that would have left nothing."""
        moved, missed = (x[: self.rows.size].reshape(-1, 6) for x in (self.q - self.at, left))
        scaled = SCALE * moved
        scaled /= np.maximum((scaled * moved).sum(axis=1, keepdims=True), 1e-300)
        jacobian[self.rows, self.columns] += missed[:, :, None] * scaled[:, None, :]

    def learn(self, forces: Array) -> None:
        """Forces have been computed. Raises NotSolved where the method leads nowhere."""
        if self.iteration >= 1 and self.jacobian is not None:
            left = forces - self.forces - self.change
            self.left = float(np.linalg.norm(left))
            if self.left <= CONTRACTION * self.size:
                self._bend(self.jacobian, left)
            ratio = self.left / max(self.size, 1e-300)
            forgotten = 0.0 if self.iteration > 1 or not np.isfinite(self.ratio) else FORGET * self.ratio
            self.ratio, self.unseen = max(ratio, forgotten), 0
            if self.new and ratio > CONTRACTION:
                self.astray += 1
                if self.astray > MOST_ASTRAY and self.left > self.loosest:
                    raise NotSolved("Newton's method does not find the end of a time step")
        elif self.iteration == 0:
            self.moved = float(np.linalg.norm(forces - self.forces))
        self.forces[:] = forces
        self.at[:] = self.q
