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
from typing import Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from wrsim.simulation.bodies import RigidBody, Solid

if not hasattr(sys, "exudynFast") and not os.environ.get("EXUDYN_MODULE"):
    sys.exudynFast = True  # type: ignore[attr-defined]
with contextlib.redirect_stdout(io.StringIO()):  # it announces which module it loaded
    import exudyn
    from exudyn import itemInterface as items

__all__ = ["COORDINATES", "Array", "ForceLaw", "RigidBody", "System"]

Array = NDArray[np.float64]

COORDINATES = ("z", "x", "y", "heading", "roll", "spin")
"""Names of the six coordinates of a body, in the order of q and q_t [m, rad]."""


SPAN = 1 << 20
"""Steps that Exudyn is asked for at once; it is stopped after half of them, or sooner."""


@runtime_checkable
class Follows(Protocol):
    """A force law that may start from its last answer, which is quicker in a run."""

    def follow(self, on: bool) -> None:
        """From now on start from the last answer, or afresh."""


class ForceLaw(Protocol):
    """Generalised forces on all bodies.

    Called with the time [s], the coordinates q and rates q_t (6 per body, live: neither keep nor change
    them) and ``out`` of the same length to fill: forces along z, x, y [N], moments about the vertical, the
    forward direction and the axle [N m]. A law that cannot go on raises ``SimulationError``; the run then
    ends in good order.
    """

    def __call__(self, t: float, q: Array, q_t: Array, out: Array) -> object: ...


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
    a run lasts. Copy what you keep; they must not outlive the system.
    """

    def __init__(self, bodies: Sequence[Solid], forces: ForceLaw, dampers: int = 0) -> None:
        """dampers: how many in series with a spring, each with an unknown of its own (``core.body.vehicle_forces``)."""
        self.bodies = tuple(bodies)
        self.forces = forces
        self.size = 6 * len(self.bodies) + dampers
        self._error: BaseException | None = None
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
            mbs.AddObject(items.ObjectGenericODE2(nodeNumbers=nodes, forceUserFunction=self._callback()))
            mbs.Assemble()
        self._mbs = mbs
        current = exudyn.ConfigurationType.Current
        self.q: Array = cast(Array, mbs.systemData.GetODE2Coordinates(current, False))
        self.q_t: Array = cast(Array, mbs.systemData.GetODE2Coordinates_t(current, False))

    def _callback(self) -> Callable[..., Array]:
        """The user function. Exudyn's own arguments are Python lists; the views hold the same numbers.

        Exudyn keeps the function for ever, so it must not keep the system (and the tables of its law) alive.
        """
        out = np.zeros(self.size)
        reference = weakref.ref(self)

        def user_function(mbs: object, t: float, item: int, q: object, q_t: object) -> Array:
            system = cast(System, reference())
            start, half, before = system._clock
            try:
                system.forces(start + (before + round(t / half)) * half, system.q, system.q_t, out)
            except BaseException as error:
                system._error = error
                raise
            return out

        return user_function

    def solve(
        self,
        q: Array,
        q_t: Array,
        start: float,
        step: float,
        steps: int,
        after_step: Callable[[float], bool],
        first: int = 0,
    ) -> None:
        """Integrate ``steps`` steps of RK44 from the state (q, q_t), which is that after ``first`` steps.

        Times are start + k step exactly, k whole (and half, within a step), and the step is the same number to the
        last bit however a run is cut into calls of this function: what it computes depends on the state alone.

        ``after_step(t)`` runs after every step (``q`` and ``q_t`` then hold the new state), and once at the
        start; False ends the run. What it or the force law raises comes through. Exudyn does not look at the
        numbers: check them in ``after_step``. Accelerations are not computed anew at the end of a step, so a
        step costs four evaluations of the force law.
        """
        data = self._mbs.systemData
        initial = exudyn.ConfigurationType.Initial
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
        integration.verboseMode = 0
        integration.verboseModeFile = 0
        half = 0.5 * step
        going = True
        done = last = 0

        def post_step(mbs: object, t: float) -> bool:
            nonlocal going, done
            done = round(t / step)
            try:
                going = after_step(start + (first + done) * step)
            except BaseException as error:
                self._error = error
                raise
            return going and done < last

        self._error = None
        with _silence():
            self._mbs.SetPostStepUserFunction(post_step)
            try:
                while going and steps > 0 and self._error is None:
                    data.SetODE2Coordinates(list(map(float, q)), initial)
                    data.SetODE2Coordinates_t(list(map(float, q_t)), initial)
                    done, last = 0, min(steps, SPAN // 2)
                    self._clock = (start, half, 2 * first)
                    self._mbs.SolveDynamic(
                        settings, solverType=exudyn.DynamicSolverType.RK44, storeSolver=False, showCausingItems=False
                    )
                    if done == 0:
                        break
                    first, steps, q, q_t = first + done, steps - done, self.q.copy(), self.q_t.copy()
            except exudyn.ExudynError:
                if self._error is None:
                    raise
            finally:
                self._mbs.SetPostStepUserFunction(0)  # type: ignore[arg-type]
        if self._error is not None:  # the module that checks ranges wraps it in an error of its own
            error, self._error = self._error, None
            raise error
