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
from typing import Any, cast

import numpy as np
from scipy.sparse import csr_matrix

from wrsim.core.body.kinematics import first_not_finite
from wrsim.errors import SimulationError
from wrsim.simulation.bodies import Solid
from wrsim.simulation.force_law import COORDINATES, Array, ForceLaw, Forces, FunctionLaw, force_derivative
from wrsim.simulation.implicit import CONTRACTION, SPECTRAL_RADIUS, ImplicitStep, Integrator, NotSolved

if not hasattr(sys, "exudynFast") and not os.environ.get("EXUDYN_MODULE"):
    sys.exudynFast = True  # type: ignore[attr-defined]
with contextlib.redirect_stdout(io.StringIO()):  # it announces which module it loaded
    import exudyn
    from exudyn import itemInterface as items

__all__ = ["COORDINATES", "Array", "ForceLaw", "NotFinite", "BodySystem", "Work"]

SPAN = 1 << 20
"""Steps that Exudyn is asked for at once; it is stopped after half of them, or sooner."""


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
        self.set_state(np.zeros(len(fields(self))))

    def get_state(self) -> Array:
        """See ``recorder.Remembers``."""
        return np.array(astuple(self), dtype=float)

    def set_state(self, memory: Array) -> None:
        """Put back what ``get_state`` gave."""
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


class BodySystem:
    """An assembled Exudyn system; build one per force law and run it as often as you like.

    ``q`` and ``q_t`` (6 per body, then the dampers') are live views on Exudyn's memory: the state of the moment while
    a run lasts. Copy what you keep; they must not outlive the system. ``work`` counts what it took. ``sparse``: of a
    train, whose vehicles act on their neighbours alone; the solver's work then grows with the number of vehicles, not
    with its square or cube.
    """

    def __init__(self, bodies: Sequence[Solid], forces: ForceLaw | Forces) -> None:
        self.bodies = tuple(bodies)
        self.forces = forces if isinstance(forces, ForceLaw) else FunctionLaw(forces)
        dampers = self.forces.dampers
        self.size = 6 * len(self.bodies) + dampers
        self.work = Work()
        self.sparse = self.forces.units > 1
        self._error: BaseException | None = None
        self._newton: ImplicitStep | None = None
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
                mbs.AddObject(items.ObjectGenericODE2(nodeNumbers=[node], massMatrix=self._matrix(np.eye(dampers))))
                nodes.append(node)
            mbs.AddObject(
                items.ObjectGenericODE2(
                    nodeNumbers=nodes,
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

    def _matrix(self, full: Array) -> Any:
        """A matrix as the solver takes it."""
        if not self.sparse:
            return full
        kept = exudyn.MatrixContainer()
        kept.SetWithSparseMatrix(csr_matrix(full))
        return kept

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
            system = cast(BodySystem, reference())
            newton = system._newton
            if newton is not None and newton.estimates(out):
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

    def _jacobian_function(self) -> Callable[..., Any]:
        """The same for the derivatives of the left-hand side; see ``_force_function``."""
        reference = weakref.ref(self)

        def jacobian(mbs: object, t: float, item: int, q: object, q_t: object, by_q: float, by_q_t: float) -> Any:
            system = cast(BodySystem, reference())
            system.work.jacobians += 1
            try:
                count, at = len(system.bodies), system._time(t)
                found = force_derivative(system.forces, system.q, system.q_t, count, at, by_q, by_q_t, central=False)
                cast(ImplicitStep, system._newton).take(found, by_q)
                return system._matrix(-found)
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
        does not get there. loosest: where it gets no further; then it may also estimate forces (``ImplicitStep``), by
        default it computes all of them.
        """
        data = self._mbs.systemData
        initial = exudyn.ConfigurationType.Initial
        implicit = integrator == "generalised-alpha"
        settings = _settings(step, tolerance)
        if self.sparse:
            settings.linearSolver.solverType = exudyn.LinearSolverType.EigenSparse
        kind = exudyn.DynamicSolverType.GeneralizedAlpha if implicit else exudyn.DynamicSolverType.RK44
        half = 0.5 * step
        going = True
        done = last = 0
        newton: ImplicitStep | None = None
        if implicit:
            newton = ImplicitStep(self.q, self.q_t, self.q_tt, len(self.bodies), step, tolerance, loosest)
        self._newton = newton

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
