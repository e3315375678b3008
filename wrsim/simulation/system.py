"""Rigid bodies as an Exudyn system with one force law for all of them.

Each body is a node ``NodeRigidBodyRxyz`` with permuted global axes (see ``wrsim.core.body.kinematics``):
coordinates (z, x, y, heading, roll, spin), six a body, one body after the other. One ``ObjectGenericODE2``
calls the force law. This is the only file that imports Exudyn. The import is quiet and asks for the fast
module unless somebody has chosen before (``sys.exudynFast = False`` gives the one that checks ranges; the
tests use it).
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
import weakref
from collections.abc import Callable, Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from typing import cast

import numpy as np

from wrsim.core.body.kinematics import first_not_finite
from wrsim.errors import SimulationError
from wrsim.simulation.bodies import RigidBody, Solid
from wrsim.simulation.force_law import COORDINATES, SMALL, Array, ForceLaw, force_derivative
from wrsim.simulation.integrators import Integrator

if not hasattr(sys, "exudynFast") and not os.environ.get("EXUDYN_MODULE"):
    sys.exudynFast = True  # type: ignore[attr-defined]
with contextlib.redirect_stdout(io.StringIO()):  # it announces which module it loaded
    import exudyn
    from exudyn import itemInterface as items

__all__ = ["COORDINATES", "Array", "ForceLaw", "NotFinite", "NotSolved", "RigidBody", "System", "Work"]

SPECTRAL_RADIUS = 0.9
"""What generalised alpha leaves of the fastest oscillation from step to step."""

CONTRACTION = 0.5
"""Newton's method keeps its Jacobian as long as an iteration leaves less than this of the residual."""

TREND = 0.5
"""Part of the last change of the accelerations that is taken to go on in the next step. Tried 0, 0.5 and 1, coach with
strips at 2 ms over a dip: 0.63, 0.44, 0.25 % of the largest Y are left; into a curve: 78, 78, 125 Jacobians."""

SCALE = np.array([SMALL[name] for name in COORDINATES]) ** -2.0
"""Weights of the coordinates of a body in Broyden's update."""

NEAR, UNSEEN, FORGET = 30.0, 8, 0.9
"""Forces are foretold, not computed, where what should be left is within the tolerance and their change, also that
since the last step, is no more than so many tolerances; at most in so many steps one after the other. What was left in
a step counts as this part of it in the next."""

MOST_ASTRAY = 2
"""New Jacobians in a step that foretell less than half of what happens, before the method ends where it is, or fails.
"""

SPAN = 1 << 20
"""Steps that Exudyn is asked for at once; it is stopped after half of them, or sooner."""


class NotSolved(SimulationError):
    """Newton's method has not found the end of a step."""


class NotFinite(SimulationError):
    """The force with this index is not a finite number at a time [s]."""

    def __init__(self, index: int, time: float) -> None:
        super().__init__(f"force {index} is not a number at t = {time:.6g} s")
        self.index, self.time = index, time


@dataclass
class Work:
    """How often the force law and its derivatives have been asked for; implicit steps that had to be cut into parts,
    and how many of these RK44 had to take."""

    evaluations: int = 0
    jacobians: int = 0
    cut_steps: int = 0
    explicit_steps: int = 0

    def clear(self) -> None:
        """Count anew."""
        self.recall(np.zeros(len(fields(self))))

    def memory(self) -> Array:
        """See ``recorder.Remembers``."""
        return np.array(astuple(self), dtype=float)

    def recall(self, memory: Array) -> None:
        """Put back what ``memory`` gave."""
        self.evaluations, self.jacobians, self.cut_steps, self.explicit_steps = (int(count) for count in memory)


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Keep Exudyn from writing to the console, and let a second Ctrl-C come through as KeyboardInterrupt."""
    console = exudyn.config.printToConsole
    throw = exudyn.special.solver.throwErrorWithCtrlC
    exudyn.config.printToConsole = False
    exudyn.special.solver.throwErrorWithCtrlC = True
    try:
        yield
    finally:
        exudyn.config.printToConsole = console
        exudyn.special.solver.throwErrorWithCtrlC = throw


class System:
    """An assembled Exudyn system; build one per force law and run it as often as you like.

    ``q`` and ``q_t`` (6 per body, then the dampers') are live views on Exudyn's memory: the state of the moment while
    a run lasts. Copy what you keep; they must not outlive the system. ``work`` counts what it took.
    """

    def __init__(self, bodies: Sequence[Solid], forces: ForceLaw, dampers: int = 0) -> None:
        """dampers: how many in series with a spring, each with an unknown of its own (``core.body.vehicle_forces``)."""
        self.bodies = tuple(bodies)
        self.forces = forces
        self.size = 6 * len(self.bodies) + dampers
        self.work = Work()
        self._error: BaseException | None = None
        self._newton: _Newton | None = None
        self._clock = (0.0, 1.0, 0)
        """Start [s], half a step [s], half steps done before Exudyn's time 0."""
        with _silence():
            self._container = exudyn.SystemContainer()
            mbs = self._container.AddSystem()
            nodes = []
            for body in self.bodies:
                node = mbs.AddNode(items.NodeRigidBodyRxyz())
                roll, spin, yaw = body.inertia
                inertia = [yaw, roll, spin, 0.0, 0.0, 0.0]  # order of the permuted axes: z, x, y
                mbs.AddObject(items.ObjectRigidBody(mass=body.mass, inertia=inertia, nodeNumber=node))
                nodes.append(node)
            if dampers:
                zeros = [0.0] * dampers
                node = mbs.AddNode(
                    items.NodeGenericODE2(
                        numberOfODE2Coordinates=dampers,
                        referenceCoordinates=zeros,
                        initialCoordinates=zeros,
                        initialCoordinates_t=zeros,
                    )
                )
                mbs.AddObject(items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=np.eye(dampers)))
                nodes.append(node)
            size = self.size
            mbs.AddObject(
                items.ObjectGenericODE2(
                    nodeNumbers=nodes,
                    massMatrix=np.zeros((size, size)),
                    forceUserFunction=self._force_function(),
                    jacobianUserFunction=self._jacobian_function(),  # type: ignore[arg-type]
                )
            )
            mbs.Assemble()
        self._mbs = mbs
        current = exudyn.ConfigurationType.Current
        self.q: Array = cast(Array, mbs.systemData.GetODE2Coordinates(current, False))
        self.q_t: Array = cast(Array, mbs.systemData.GetODE2Coordinates_t(current, False))
        self.q_tt: Array = cast(Array, mbs.systemData.GetODE2Coordinates_tt(current, False))

    def _time(self, t: float) -> float:
        """The time [s] of the moment that Exudyn calls t."""
        start, half, before = self._clock
        return start + (before + round(t / half)) * half

    def _force_function(self) -> Callable[..., Array]:
        """The user function. Exudyn's own arguments are Python lists; the views hold the same numbers.

        Exudyn keeps the function for ever, so it must not keep the system (and the tables of its law) alive.
        """
        out = np.zeros(self.size)
        reference = weakref.ref(self)

        def force(mbs: object, t: float, item: int, q: object, q_t: object) -> Array:
            system = cast(System, reference())
            newton = system._newton
            if newton is not None and newton.foretells(out):
                return out
            system.work.evaluations += 1
            try:
                system.forces(system._time(t), system.q, system.q_t, out)
                bad = first_not_finite(out, out)
                if bad >= 0:
                    raise NotFinite(bad, system._time(t))
                if newton is not None:
                    newton.learn(out)
            except BaseException as error:
                system._error = error
                raise
            return out

        return force

    def _jacobian_function(self) -> Callable[..., Array]:
        """The same for the derivatives of what stands on the left-hand side; see ``_force_function``."""
        reference = weakref.ref(self)

        def jacobian(mbs: object, t: float, item: int, q: object, q_t: object, by_q: float, by_q_t: float) -> Array:
            system = cast(System, reference())
            system.work.jacobians += 1
            try:
                count, at = len(system.bodies), system._time(t)
                found = force_derivative(system.forces, system.q, system.q_t, count, at, by_q, by_q_t, central=False)
                cast(_Newton, system._newton).take(found, by_q)
                return -found
            except BaseException as error:
                system._error = error
                raise

        return jacobian

    def solve(
        self,
        q: Array,
        q_t: Array,
        start: float,
        step: float,
        steps: int,
        after_step: Callable[[float], bool],
        first: int = 0,
        integrator: Integrator = "rk44",
        tolerance: float = 1e-3,
        loosest: float | None = None,
    ) -> None:
        """Integrate ``steps`` steps from the state (q, q_t), which is that after ``first`` steps.

        Times are start + k step exactly, k whole (and half, within a step of RK44), and the step is the same number to
        the last bit however a run is cut into calls of this function: what RK44 computes depends on the state alone.
        Generalised alpha starts every call with the accelerations that the forces give and a new Jacobian, and carries
        both from step to step: there it matters where a call begins.

        ``after_step(t)`` runs after every step (``q`` and ``q_t`` then hold the new state), and once at the
        start; False ends the run. What it or the force law raises comes through. Exudyn does not look at the
        numbers: check them in ``after_step``. RK44 does not compute accelerations anew at the end of a step, so a step
        costs four evaluations of the force law.

        tolerance: norm of the forces left over [N] with which Newton's method ends; it raises ``NotSolved`` when it
        does not get there. loosest: where it gets no further; then it may also foretell forces (``_Newton``), by
        default it computes all of them.
        """
        data = self._mbs.systemData
        initial = exudyn.ConfigurationType.Initial
        implicit = integrator == "generalised-alpha"
        settings = _settings(step, tolerance)
        kind = exudyn.DynamicSolverType.GeneralizedAlpha if implicit else exudyn.DynamicSolverType.RK44
        half = 0.5 * step
        going = True
        done = last = 0
        newton = self._newton = _Newton(self, step, tolerance, loosest) if implicit else None

        def post_step(mbs: object, t: float) -> bool:
            nonlocal going, done
            done = round(t / step)
            if newton is not None:
                newton.keep()
            try:
                going = after_step(start + (first + done) * step)
            except BaseException as error:
                self._error = error
                raise
            return going and done < last

        self._error = None
        with _silence():
            self._mbs.SetPostStepUserFunction(post_step)
            if newton is not None:
                self._mbs.SetPreNewtonResidualUserFunction(newton)
            try:
                while going and steps > 0 and self._error is None:
                    data.SetODE2Coordinates(list(map(float, q)), initial)
                    data.SetODE2Coordinates_t(list(map(float, q_t)), initial)
                    done, last = 0, min(steps, SPAN // 2)
                    self._clock = (start, half, 2 * first)
                    self._mbs.SolveDynamic(settings, solverType=kind, storeSolver=False, showCausingItems=False)
                    if done == 0:
                        break
                    first, steps, q, q_t = first + done, steps - done, self.q.copy(), self.q_t.copy()
            except exudyn.ExudynError as error:
                if self._error is None:
                    if not isinstance(error, exudyn.SolverError):
                        raise
                    raise NotSolved("Newton's method does not find the end of a time step") from None
            finally:
                self._newton = None
                self._mbs.SetPostStepUserFunction(0)  # type: ignore[arg-type]
                self._mbs.SetPreNewtonResidualUserFunction(0)  # type: ignore[arg-type]
        if self._error is not None:  # the module that checks ranges wraps it in an error of its own
            error, self._error = self._error, None
            raise error


class _Newton:
    """Newton's method within a call of ``System.solve``: its first guess, its last answer, and when it gives up.

    First guess: a step starts from the accelerations of the last one and a part of their trend; Exudyn starts from
    none. Without the trend, what the method does not finish lies on the same side step after step. This is a user
    function that is called before every residual. q, q_t and q_tt then change together, as they do in an iteration
    (Arnold and Bruls, algorithm 1).

    Last answer: the forces after an iteration differ from those that the Jacobian foretells by a part of the change
    that it foretells (``ratio``), which shows wherever they are computed, and bends what foretells (Broyden's update,
    body by body), not the Jacobian that Exudyn keeps. Where the difference is sure to be within the
    tolerance they are not computed: what is foretold ends the iteration (the test of Hairer and Wanner, Solving
    Ordinary Differential Equations II, IV.8).

    Giving up: where new Jacobians foretell nothing, the force jumps, and iterations lead nowhere.
    """

    def __init__(self, system: System, step: float, tolerance: float, loosest: float | None) -> None:
        """tolerance, loosest: see ``System.solve``."""
        rho = SPECTRAL_RADIUS
        alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
        gamma = 0.5 + alpha_f - alpha_m
        beta = 0.25 * (gamma + 0.5) ** 2
        of_acceleration = step * step * beta * (1.0 - alpha_f) / (1.0 - alpha_m)
        self.system, self.q_of_q_tt = system, of_acceleration
        self.q_t_of_q_tt = of_acceleration * gamma / (step * beta)
        self.last, self.ahead = np.zeros((2, system.size))
        self.tolerance, self.may_foretell = tolerance, loosest is not None
        self.loosest = tolerance if loosest is None else loosest
        self.steps, self.iteration = 0, -1
        own = np.arange(6 * len(system.bodies)).reshape(-1, 6)
        self.rows, self.columns = own[:, :, None], own[:, None, :]
        self.jacobian: Array | None = None
        self.at, self.forces, self.change = np.zeros((3, system.size))
        """State of the last forces that were computed, these, and their change since by the Jacobian."""
        self.size = self.left = self.moved = np.inf
        """Norms [N]: of that change, of what the last one has left of the forces, and of their change since the last
        step."""
        self.ratio, self.unseen = np.inf, 0
        """The largest part that was left of late, and for how many steps it has not been looked at."""
        self.new, self.astray = False, 0
        """Whether the Jacobian is of this step, and how often it has foretold nothing."""

    def keep(self) -> None:
        """Take note of the accelerations at the end of a step."""
        q_tt = self.system.q_tt
        self.ahead[:] = q_tt + TREND * (q_tt - self.last) if self.steps else q_tt
        self.last[:] = q_tt
        self.steps += 1

    def __call__(self, mbs: object, t: float, iteration: int, repetition: int) -> None:
        self.iteration = iteration
        if iteration == 0:
            system = self.system
            system.q_tt += self.ahead
            system.q_t += self.q_t_of_q_tt * self.ahead
            system.q += self.q_of_q_tt * self.ahead
            self.new, self.astray = False, 0

    def take(self, derivative: Array, by_q: float) -> None:
        """A Jacobian has been computed: derivative of the forces for a change of q by ``by_q``."""
        self.jacobian = derivative / by_q
        self.ratio, self.new = np.inf, True

    def foretells(self, out: Array) -> bool:
        """Fill ``out`` with the forces that the Jacobian foretells and return True, if that ends the iteration."""
        if self.iteration < 1 or self.jacobian is None:
            return False
        np.dot(self.jacobian, self.system.q - self.at, out=self.change)
        self.size = float(np.linalg.norm(self.change))
        if not self.may_foretell:
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
        """Broyden's update of what foretells, of every body by itself: the Jacobian that would have left nothing."""
        moved, missed = (x[: self.rows.size].reshape(-1, 6) for x in (self.system.q - self.at, left))
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
        self.at[:] = self.system.q


def _settings(step: float, tolerance: float) -> exudyn.SimulationSettings:
    """How Exudyn shall go: a fixed step, nothing written."""
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.active = False
    integration = settings.timeIntegration
    # Exudyn divides the time by the number of steps; a power of two gives the step back exactly
    integration.startTime = 0.0
    integration.endTime = SPAN * step
    integration.numberOfSteps = SPAN
    integration.automaticStepSize = False
    integration.adaptiveStep = False
    integration.explicit.computeEndOfStepAccelerations = False
    integration.explicit.useLieGroupIntegration = False
    integration.generalizedAlpha.spectralRadius = SPECTRAL_RADIUS
    integration.newton.useModifiedNewton = True
    integration.newton.modifiedNewtonContractivity = CONTRACTION
    integration.newton.relativeTolerance = 1e-12
    integration.newton.absoluteTolerance = tolerance
    integration.verboseMode = 0
    integration.verboseModeFile = 0
    return settings
