"""Rigid bodies as an Exudyn system with one force law for all of them.

Each body is a node ``NodeRigidBodyRxyz`` with permuted global axes (see ``wrsim.vehicle.dynamics.kinematics``):
coordinates (z, x, y, heading, roll, spin), six a body, one body after the other. One ``ObjectGenericODE2``
calls the force law. This is the only file that imports Exudyn: quietly, and the fast module unless chosen otherwise
(``sys.exudynFast = False`` gives the one that checks ranges; the tests use it).
"""

import contextlib
import io
import os
import sys
import weakref
from collections.abc import Callable, Iterator, Sequence
from dataclasses import astuple, dataclass
from typing import Any, cast

import numpy as np
import scipy

from wrsim.errors import SimulationError
from wrsim.simulation import Integrator
from wrsim.simulation.bodies import Solid
from wrsim.simulation.force_law import COORDINATES, Array, ForceLaw, Forces, force_derivative
from wrsim.simulation.implicit_step import NOT_SOLVED, SPECTRAL_RADIUS, ImplicitStep, NotSolved
from wrsim.vehicle.dynamics.implicit_step import CONTRACTION
from wrsim.vehicle.dynamics.kinematics import first_not_finite

if not hasattr(sys, "exudynFast") and not os.environ.get("EXUDYN_MODULE"):
    sys.exudynFast = True  # type: ignore[attr-defined]
with contextlib.redirect_stdout(io.StringIO()):  # it prints which module it loads
    import exudyn
    from exudyn import itemInterface as items

__all__ = ["COORDINATES", "Array", "ForceLaw", "NotFinite", "BodySystem", "Work"]

SPAN = 1 << 20
"""Most steps of a call of Exudyn's solver; it is stopped earlier."""

NO_FORCES = [0.0] * 6

AfterStep = Callable[[float], bool]


class NotFinite(SimulationError):
    """The force with this index is not a finite number at a time [s]."""

    def __init__(self, index: int, time: float) -> None:
        super().__init__(f"force {index} is not a number at t = {time:.6g} s")
        self.index, self.time = index, time


@dataclass
class Work:
    """Evaluations of the force law and of its derivatives; implicit steps that were cut into parts, and how many of
    these were taken by RK44; steps taken in parts for their accuracy."""

    evaluations: int = 0
    jacobians: int = 0
    cut_steps: int = 0
    explicit_steps: int = 0
    refined_steps: int = 0

    def get_state(self) -> Array:
        return np.array(astuple(self), dtype=float)

    def set_state(self, memory: Array) -> None:
        vars(self).update(zip(vars(self), map(int, memory), strict=True))


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


class BodySystem:
    """An assembled Exudyn system; build one per force law and run it as often as you like.

    ``q`` and ``q_t`` (6 per body, then the dampers') are live views on Exudyn's memory: the current state during a
    run. Copy them to keep them; they must not outlive the system. ``work``: counts. ``sparse``: of a train, whose
    vehicles act on their neighbours alone; the solver's work then grows in proportion to the number of vehicles.
    """

    def __init__(self, bodies: Sequence[Solid], forces: ForceLaw | Forces) -> None:
        self.bodies = tuple(bodies)
        self.forces = forces if isinstance(forces, ForceLaw) else ForceLaw(forces)
        dampers = self.forces.dampers
        self.size = 6 * len(self.bodies) + dampers
        self.work = Work()
        self.sparse = self.forces.units > 1
        self._out = np.zeros(self.size)
        self._error: BaseException | None = None
        self._newton: ImplicitStep | None = None
        self._after_step: AfterStep = lambda t: True
        self._clock = (0.0, 1.0, 0)
        """Start [s], step [s], steps that precede Exudyn's time 0."""
        self._done, self._last = 0, 0
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
                node = items.NodeGenericODE2("inner unknowns", zeros, zeros, zeros, dampers)
                nodes.append(mbs.AddNode(node))
                mass = self._matrix(np.eye(dampers))
                mbs.AddObject(items.ObjectGenericODE2(nodeNumbers=nodes[-1:], massMatrix=mass))
            # user functions of forces take and return lists: that of RK44 has six numbers, and fills the vector of the
            # other object; in implicit steps that is filled ahead of every residual
            none, self._function = self._matrix(np.zeros((6, 6))), self._callback(BodySystem._force)
            self._of_rk44 = mbs.AddObject(
                items.ObjectGenericODE2(nodeNumbers=nodes[:1], jacobianUserFunction=lambda *_: none)
            )
            jacobian = self._callback(BodySystem._jacobian)
            self._forced = mbs.AddObject(
                items.ObjectGenericODE2(nodeNumbers=nodes, forceVector=self._out, jacobianUserFunction=jacobian)
            )
            mbs.Assemble()
            mbs.SetPostStepUserFunction(self._callback(BodySystem._post_step))
            mbs.SetPreNewtonResidualUserFunction(self._callback(BodySystem._pre_newton))
        self._mbs = mbs
        current = exudyn.ConfigurationType.Current
        self.q: Array = cast(Array, mbs.systemData.GetODE2Coordinates(current, False))
        self.q_t: Array = cast(Array, mbs.systemData.GetODE2Coordinates_t(current, False))
        self.q_tt: Array = cast(Array, mbs.systemData.GetODE2Coordinates_tt(current, False))

    def _callback(self, method: Callable[..., Any]) -> Any:
        """A user function of Exudyn that calls a method.

        Exudyn keeps it for ever: it must not keep the system (and the tables of its law) alive. The module that checks
        ranges wraps an error in one of its own: the original is noted.
        """
        reference = cast(Any, weakref.ref(self))

        def call(mbs: object, *arguments: Any) -> Any:
            system = reference()
            try:
                return method(system, *arguments)
            except BaseException as error:
                system._error = error
                raise

        return call

    def _matrix(self, full: Array) -> Any:
        """A matrix as the solver takes it."""
        if not self.sparse:
            return full
        sparse = exudyn.MatrixContainer()
        sparse.SetWithSparseMatrix(scipy.sparse.csr_matrix(full))
        return sparse

    def _time(self, t: float) -> float:
        """The time [s] at Exudyn's time t."""
        start, step, before = self._clock
        half = 0.5 * step
        return start + (2 * before + round(t / half)) * half

    def _force(self, t: float, *_: object) -> list[float]:
        """Take the generalised forces at the current state; beside them there are none."""
        newton, out = self._newton, self._out
        if newton is None or not newton.estimate(out):
            self.work.evaluations += 1
            time = self._time(t)
            self.forces(time, self.q, self.q_t, out)
            bad = first_not_finite(out, out) if newton is None else newton.update(out)
            if bad >= 0:
                raise NotFinite(bad, time)
        self._mbs.SetObjectParameter(self._forced, "forceVector", out)
        return NO_FORCES

    def _jacobian(self, t: float, item: int, q: object, q_t: object, by_q: float, by_q_t: float) -> Any:
        self.work.jacobians += 1
        bodies = len(self.bodies)
        derivative = force_derivative(self.forces, self.q, self.q_t, bodies, self._time(t), by_q, by_q_t, central=False)
        cast(ImplicitStep, self._newton).set_jacobian(derivative, by_q)
        return self._matrix(-derivative)

    def _pre_newton(self, t: float, iteration: int, repetition: int) -> None:
        if (newton := self._newton) is not None:
            again = newton.begin_iteration(iteration)
            if iteration == 0 or again:
                self.forces.begin_step(self._clock[1], self.q, self.q_t, self.q_tt, again)
            elif iteration > 1 and self.forces.hold(iteration == 2, *newton.computed_at, self.q, self.q_t, self.q_tt):
                newton.held()
            self._force(t)

    def _post_step(self, t: float) -> bool:
        start, step, before = self._clock
        self._done = round(t / step)
        if self._newton is not None:
            self._newton.end_step()
            if self._done:
                self.forces.end_step(self.q, self.q_t)
        return self._after_step(start + (before + self._done) * step) and self._done < self._last

    def solve(
        self,
        q: Array,
        q_t: Array,
        start: float,
        step: float,
        steps: int,
        after_step: AfterStep,
        first: int = 0,
        integrator: Integrator = "rk44",
        tolerance: float = 1e-3,
        max_residual: float | None = None,
    ) -> None:
        """Integrate ``steps`` steps, at most ``SPAN``, from the state (q, q_t), which is that after ``first`` steps.

        Times are start + k step exactly, k whole (and half, within a step of RK44), and the step is the same number to
        the last bit however a run is divided into calls: RK44 depends on the state alone. Generalised alpha begins
        every call with the accelerations of the forces and a new Jacobian, and carries both from step to step: there
        it matters where a call begins.

        ``after_step(t)`` runs after every step (``q`` and ``q_t`` then hold the new state), and once at the
        start; False ends the run. Exceptions of it and of the force law are passed on. Exudyn does not check the
        numbers: check them in ``after_step``. RK44 does not compute accelerations at the end of a step, so a step
        costs four evaluations of the force law.

        tolerance: norm of the residual forces [N] at which Newton's method ends; it raises ``NotSolved`` when it
        does not converge. max_residual: where it does not converge further; with it forces may be estimated
        (``ImplicitStep``), by default all of them are computed.
        """
        data, initial = self._mbs.systemData, exudyn.ConfigurationType.Initial
        settings = _settings(step, tolerance, self.sparse)
        kind = exudyn.DynamicSolverType.RK44
        self._after_step, self._error = after_step, None
        if integrator == "generalised-alpha":
            kind = exudyn.DynamicSolverType.GeneralizedAlpha
            counts = len(self.bodies), self.forces.rails
            self._newton = ImplicitStep(self.q, self.q_t, self.q_tt, *counts, step, tolerance, max_residual)
        with _silence():
            try:
                data.SetODE2Coordinates(list(map(float, q)), initial)
                data.SetODE2Coordinates_t(list(map(float, q_t)), initial)
                self._clock, self._done, self._last = (start, step, first), 0, steps
                if self._newton:  # its first accelerations are those of these forces
                    self.q[:], self.q_t[:] = q, q_t
                    self._force(0.0)
                function = 0 if self._newton else self._function
                self._mbs.SetObjectParameter(self._of_rk44, "forceUserFunction", function)
                self._mbs.SolveDynamic(settings, solverType=kind, storeSolver=False, showCausingItems=False)
            except exudyn.ExudynError as error:
                if self._error is None:
                    if not isinstance(error, exudyn.SolverError):
                        raise
                    raise NotSolved(NOT_SOLVED) from None
            finally:
                self._newton, self._after_step = None, lambda t: True
        if self._error is not None:
            error, self._error = self._error, None
            raise error


def _settings(step: float, tolerance: float, sparse: bool) -> exudyn.SimulationSettings:
    """Settings of Exudyn: a fixed step, no output."""
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.active = False
    if sparse:
        settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
    integration = settings.timeIntegration
    # Exudyn divides the time by the number of steps; a power of two gives the step exactly
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
