"""A vehicle that rolls straight at any speed: its force law, the steady state, its modes, the linear critical speed.

Modes are eigenvalues of the state matrix about steady rolling on straight track; the spin angles of the axles, on which
nothing depends, are left out, so that no eigenvalue is zero by nature.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.derailment import contact_words, overlap, resultant_at_start, wheels_of
from wrsim.analysis.motion.messages import NoSteadyMotion, steady_words
from wrsim.analysis.motion.start import steady_alone
from wrsim.contact.records import STATUS_TOO_DEEP
from wrsim.errors import SimulationError
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.scenario.sections.stability import StabilityPlan
from wrsim.simulation.law import ConicalVehicleOnTrack, VehicleOnTrack
from wrsim.simulation.modes import linearise, mode_name
from wrsim.simulation.steady_state import steady_state
from wrsim.simulation.system import Array
from wrsim.track.segments import Straight

LENGTH, PLACE = 400.0, 200.0
"""Straight track, and where on it the vehicle starts [m]; behind its end it goes on straight."""
SLOWEST = 0.05  # frequency below which nothing is called an oscillation [Hz]
SPEED_TOLERANCE = 1e-4  # the critical speed is found to this part of itself
FAR = 0.7  # cost of two modes from which on they are no longer one: see ``_costs``


@dataclass(frozen=True)
class RollingModes:
    """Oscillating modes at one speed [m/s]: eigenvalues (n,) [1/s], imaginary parts positive; shapes (n, bodies, 6).

    largest: real part of the eigenvalue farthest to the right among all, oscillating or not.
    """

    speed: float
    values: NDArray[np.complex128]
    shapes: NDArray[np.complex128]
    largest: float


def follow(series: Sequence[RollingModes]) -> list[NDArray[np.intp]]:
    """For every speed the number of the branch that each mode belongs to; branches go on from speed to speed.

    A mode goes on as the one that is nearest in eigenvalue and shape; what has no such mode begins a branch.
    """
    branches = [np.arange(len(series[0].values))]
    next_branch = len(branches[0])
    for before, after in pairwise(series):
        numbers = np.full(len(after.values), -1)
        costs = _costs(before, after)
        for i, j in zip(*linear_sum_assignment(costs), strict=True):
            if costs[i, j] < FAR:
                numbers[j] = branches[-1][i]
        for j in np.flatnonzero(numbers < 0):
            numbers[j] = next_branch
            next_branch += 1
        branches.append(numbers)
    return branches


def _costs(before: RollingModes, after: RollingModes) -> Array:
    """How unlike two modes are, (n, m): distance of the eigenvalues over their size, and one minus their likeness.

    Likeness is the modal assurance criterion |a^H b|^2 / (|a|^2 |b|^2).
    """
    a, b = (m.shapes.reshape(len(m.values), -1) for m in (before, after))
    a, b = (s / np.linalg.norm(s, axis=1, keepdims=True) for s in (a, b))
    likeness = np.abs(a.conj() @ b.T) ** 2
    apart = np.abs(before.values[:, None] - after.values[None, :])
    scale = 0.5 * (np.abs(before.values)[:, None] + np.abs(after.values)[None, :])
    return np.asarray(apart / scale + 0.5 * (1.0 - likeness))


def critical(modes_at: Callable[[float], RollingModes], series: Sequence[RollingModes]) -> RollingModes | None:
    """Modes at the lowest speed at which the largest real part passes zero upwards; None where it does not.

    modes_at: those at any speed; series: those at rising speeds. Bisection between the two that embrace the passage.
    Already unstable at the first speed: its modes are the answer.
    """
    if series[0].largest > 0.0:
        return series[0]
    for low, high in pairwise(series):
        if high.largest > 0.0:
            below, above, last = low.speed, high.speed, high
            while above - below > SPEED_TOLERANCE * above:
                middle = modes_at(0.5 * (below + above))
                if middle.largest > 0.0:
                    above, last = middle.speed, middle
                else:
                    below = middle.speed
            return last
    return None


class RollingVehicle:
    """Steady rolling on straight level track. ``law`` is that of the speed set last."""

    def __init__(self, setup: Setup, speed: float) -> None:
        straight = setup.track.relaid([Straight(LENGTH)])
        self.setup = replace(setup, track=straight, plan=RunPlan(PLACE, PLACE, speed))
        self.law: VehicleOnTrack
        if setup.conical is not None:
            self.law = ConicalVehicleOnTrack(
                setup.vehicle, straight, setup.conical, speed=speed, start=PLACE, drive=setup.drive
            )
        else:
            self.law = force_law(self.setup)
        self._last: tuple[Array, Array] | None = None
        self.remark = ""
        """Messages of the contacts of the state found last."""

    def state(self, speed: float) -> tuple[Array, Array]:
        """The steady state (q, q_t) at a speed [m/s]. Raises SimulationError when there is none."""
        law = self.law
        law.set_speed(speed)
        resultant_at_start(self.setup, speed)  # not overturned
        law.set_search_start(PLACE)
        try:
            equilibrium = steady_alone(law) if self._last is None else steady_state(law, self._last)
        except SimulationError:
            if self._last is None:
                raise
            equilibrium = steady_alone(law)
        self._last = equilibrium.q, equilibrium.q_t
        law.at(0.0, equilibrium.q, equilibrium.q_t)
        wheels = wheels_of(law)
        if any(wheel.status & STATUS_TOO_DEEP for wheel in wheels):
            raise SimulationError(steady_words(NoSteadyMotion(overlap(wheels)), law.vehicle))
        self.remark = contact_words(wheels)
        return equilibrium.q.copy(), equilibrium.q_t.copy()

    def modes(self, speed: float, plan: StabilityPlan) -> RollingModes:
        """Modes of the small motions about the steady state at a speed [m/s], up to the highest frequency."""
        linear = linearise(self.law, self.law.bodies, *self.state(speed), plan.stroke)
        m = 6 * linear.bodies
        spins = 6 * np.arange(len(self.law.vehicle.wheelsets)) + 5
        retained = np.setdiff1d(np.arange(linear.state_matrix.shape[0]), spins)
        values, vectors = np.linalg.eig(linear.state_matrix[np.ix_(retained, retained)])
        whole = np.zeros((m, len(values)), dtype=complex)
        of_bodies = retained < m
        whole[retained[of_bodies]] = vectors[of_bodies]
        oscillating = (values.imag > 2.0 * np.pi * SLOWEST) & (np.abs(values.imag) <= 2.0 * np.pi * plan.highest)
        order = np.argsort(values[oscillating].imag)
        shapes = whole[:, oscillating].T[order].reshape(-1, linear.bodies, 6)
        return RollingModes(speed, values[oscillating][order], shapes, float(values.real.max()))


def mode_shapes(setup: Setup[StabilityPlan], speeds: Sequence[float]) -> Iterator[tuple[RollingModes, list[str]]]:
    """Modes of the set-up's vehicle at speeds [m/s], each with the names of its modes."""
    rolling = RollingVehicle(setup, speeds[0])
    for speed in speeds:
        modes = rolling.modes(speed, setup.plan)
        yield modes, [mode_name(setup.vehicle, shape) for shape in modes.shapes]
