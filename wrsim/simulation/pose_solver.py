"""Poses at a prescribed vertical load: one wheel at a given roll, or a wheelset that finds its own roll.

The track is straight and level. The wheelset's centre is at the lateral shift, turned by the yaw; it rolls at
``speed`` along the track without slip at the tape circle (the turning rate is V / R about the yawed axle), or is
at rest in the frictionless case. The height is found for the prescribed load; friction takes part in the balance.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from math import sin
from operator import or_
from typing import NamedTuple

import numpy as np
import scipy

from wrsim.contact.batch import DEEPEST, LOAD_TOLERANCE, search_for
from wrsim.contact.channels import ElementField, WheelOnRail
from wrsim.contact.half_space import HalfSpace, HalfSpaceContact
from wrsim.contact.half_space.strips import element_fields, solve_into
from wrsim.contact.model import ContactModel
from wrsim.contact.models import exact_model, fast_model
from wrsim.contact.pose import Pose
from wrsim.contact.prescribed_load import SEARCHING, approach_of, begin_search, meet_load, next_height
from wrsim.contact.records import STATUS_DISCONTINUOUS, STATUS_LEFT_OUT, STATUS_NOT_CONVERGED, STATUS_TOO_DEEP
from wrsim.contact.status import REMARKS, SUBSTITUTED, TOO_MANY, UNMET, UNSOLVED, status_words
from wrsim.jit.frames import Frame
from wrsim.jit.linalg import Vec
from wrsim.vehicle.dynamics.kinematics import kinematics
from wrsim.vehicle.dynamics.wheel_forces import set_pose, wheel_wrench

ROLLING_SPEED = 2.0  # of the quasi-static rolling [m/s]; creepages do not depend on it
CLEARANCE = 0.02  # of the centre above a wheel's radius, from where it is let down [m]
LARGEST_ROLL = 0.05  # of a wheelset that looks for its balance [rad]
EXACT_TOLERANCE = 2e-5  # of the vertical force, with the exact half-space solver
PATIENCE = 4  # evaluations of it with an overlap that is no contact any more


@dataclass(frozen=True)
class Solved:
    """Where the wheelset comes to rest: height of its centre above the track plane [m], roll [rad]; a message when
    there is no solution (the heights then are not-a-number, or the nearest state); further remarks; whether the model
    has none though there is a contact."""

    height: float
    roll: float
    message: str = ""
    remark: str = ""
    unsolved: bool = False


class PoseSolver:
    """One wheel or two over their rails on straight track. ``holders``: the wheels whose models hold the contact solved
    last, these or those of the half-space solver where the strip model has no solution."""

    load_tolerance = 1e-6  # of the vertical force
    missed = "no equilibrium: the contact force is discontinuous at this load"

    def __init__(self, wheels: Sequence[WheelOnRail], rolling: bool, radius: float) -> None:
        self.wheels = self.holders = tuple(wheels)
        self.rolling = rolling
        self.exact: HalfSpacePoseSolver | None = None
        self.speed = ROLLING_SPEED if rolling else 0.0
        self.radius = radius
        self.force = np.zeros(3)
        self.moment = np.zeros(3)

    def evaluate(self, lateral: float, height: float, yaw: float, roll: float) -> None:
        """Contact of all wheels at one pose; leaves ``force`` and ``moment`` at the centre of mass."""
        self.place(lateral, height, yaw, roll)
        for i in range(len(self.wheels)):
            self._touch(i)
        self._sum_up()

    def place(self, lateral: float, height: float, yaw: float, roll: float) -> None:
        """Set one pose in the arrays of all wheels."""
        q = np.array([height, 0.0, lateral, yaw, roll, 0.0])
        # spin rate about the axle; no other motion but along the track
        q_t = np.array([0.0, self.speed, 0.0, 0.0, 0.0, self.speed / self.radius])
        self._body = kinematics(q, q_t)
        for wheel, rail in self._on_rails():
            a = wheel.model.arrays
            set_pose(self._body, rail, float(wheel.side), wheel.half_spacing, a.pose)
            if wheel.model.roller is None:  # the section of the rail beside the wheel
                a.pose[0] = 0.0

    def _sum_up(self) -> None:
        """Force and moment of all wheels' contacts."""
        self.force[:] = 0.0
        self.moment[:] = 0.0
        for wheel, rail in self._on_rails():
            total = wheel.model.arrays.total
            force, moment = wheel_wrench(self._body, rail, float(wheel.side), wheel.half_spacing, total)
            self.force += force
            self.moment += moment

    def _on_rails(self) -> Iterator[tuple[WheelOnRail, Frame]]:
        """The wheels and the frames of their rails."""
        for wheel in self.wheels:
            o, b = wheel.rail_origin
            origin = Vec(0.0, float(wheel.side) * o, b)
            yield wheel, Frame(origin, Vec(1.0, 0.0, 0.0), Vec(0.0, 1.0, 0.0), Vec(0.0, 0.0, 1.0))

    def solve(self, pose: Pose) -> Solved:
        """Height (and roll, with two wheels) for the pose's load. The models of ``holders`` then hold the contact."""
        solved, self.holders = self.search(pose), self.wheels
        leaves_out = not solved.message and self._status() & STATUS_LEFT_OUT
        if not ((solved.unsolved or leaves_out) and self.wheels[0].model.normal.solves_for_strips):
            return solved
        if self.exact is None:
            wheels = [replace(w, model=exact_model(w.model)) for w in self.wheels]
            self.exact = HalfSpacePoseSolver(wheels, self.rolling, self.radius)
        exact = self.exact.solve(pose)
        if exact.message:
            return solved
        self.holders = self.exact.wheels
        for wheel in self.holders:
            wheel.model.arrays.total.status |= SUBSTITUTED
        return replace(exact, remark=status_words(self.exact._status() & REMARKS))

    def search(self, pose: Pose) -> Solved:
        """The same by the wheels' own models alone."""
        for wheel in self.wheels:
            wheel.model.arrays.inputs.wheel_angle = pose.wheel_angle
        try:
            roll = pose.roll if len(self.wheels) == 1 else self._balanced_roll(pose)
            height = self._height(pose, roll)
        except LoadNotReached as problem:
            message = f"{problem} (lateral shift {1e3 * pose.lateral:g} mm, {pose.load:g} N)"
            return Solved(float("nan"), float("nan"), message, unsolved=isinstance(problem, Unsolved))
        missed = abs(self.force[2] / pose.load - 1.0) > self.load_tolerance
        return Solved(height, roll, self._problem(pose.load), status_words(self._status() & REMARKS), missed)

    def elements(self) -> list[list[ElementField]]:
        """Elements of every wheel's patches at the last pose, where the solver has any."""
        return []

    def _touch(self, wheel: int) -> None:
        """Contact of one wheel at the pose set in its model's arrays."""
        self.wheels[wheel].model.arrays.evaluate()

    def _status(self) -> int:
        """Status of all the contacts found last."""
        return reduce(or_, (wheel.model.arrays.status for wheel in self.wheels))

    def _problem(self, load: float) -> str:
        """Why the state that was found is no solution; nothing when it is one."""
        status, messages = self._status() & ~REMARKS, []
        if abs(self.force[2] / load - 1.0) > self.load_tolerance:
            messages.append(f"{self.missed}: {self.force[2]:.6g} N instead of {load:.6g} N")
            status &= ~STATUS_DISCONTINUOUS
        messages.append(status_words(status))
        return "; ".join(filter(None, messages))

    def _height(self, pose: Pose, roll: float) -> float:
        """Height at which the vertical force is the load. The models then hold the contact there."""
        start = self.radius + CLEARANCE + abs(sin(roll)) * self.wheels[0].half_spacing
        if len(self.wheels) > 1:
            return height_for_load(partial(self._carried, pose, roll), self.wheels[0].model, pose.load, start)
        self.place(pose.lateral, start, pose.yaw, roll)
        model = self.wheels[0].model
        shift = start - float(model.arrays.pose[2])
        message = lower(model, pose.load)
        height = float(model.arrays.pose[2]) + shift
        if model.arrays.status & (UNSOLVED & ~STATUS_DISCONTINUOUS):
            raise Unsolved(status_words(model.arrays.status & UNSOLVED), height)
        if message and not model.arrays.status & STATUS_DISCONTINUOUS:
            raise LoadNotReached(message)
        self._sum_up()
        return height

    def _carried(self, pose: Pose, roll: float, height: float) -> Carried:
        self.evaluate(pose.lateral, height, pose.yaw, roll)
        if self._status() & STATUS_NOT_CONVERGED:
            raise Unsolved(status_words(STATUS_NOT_CONVERGED), height)
        arrays = [wheel.model.arrays for wheel in self.wheels]
        return Carried(float(self.force[2]), max(approach_of(a.patches, a.total) for a in arrays))

    def _balanced_roll(self, pose: Pose) -> float:
        def moment(roll: float) -> float:
            self._height(pose, roll)
            return float(self.moment[0])

        # a wheelset rolled to the left (left wheel up) loads the right wheel, whose force turns it back
        ends = []
        for sign in (-1.0, 1.0):
            roll = 1e-4 * sign
            while sign * moment(roll) > 0.0:
                roll *= 2.0
                if abs(roll) > LARGEST_ROLL:
                    raise LoadNotReached("the wheelset finds no balance in roll")
            ends.append(roll)
        return float(scipy.optimize.brentq(moment, *ends, xtol=1e-15, rtol=8.9e-16, maxiter=200))


class HalfSpacePoseSolver(PoseSolver):
    """Wheels over their rails; ``contacts`` holds what the solver found at the last pose, one for each wheel.

    The elements are chosen at the first height of a pose and stored while its height is looked for.
    """

    load_tolerance = 10.0 * EXACT_TOLERANCE
    missed = "the load is not reached"

    def __init__(
        self, wheels: Sequence[WheelOnRail], rolling: bool, radius: float, solver: HalfSpace | None = None
    ) -> None:
        super().__init__(wheels, rolling, radius)
        self.solver = solver if solver is not None else HalfSpace.of(self.wheels[0].model.settings.half_space)
        self.contacts: list[HalfSpaceContact | None] = [None] * len(self.wheels)
        self._solvers = [self.solver] * len(self.wheels)
        self._fast = PoseSolver([replace(w, model=fast_model(w.model)) for w in wheels], rolling, radius)

    def solve(self, pose: Pose) -> Solved:
        """See `PoseSolver.solve`; ``contacts`` then holds the contact found."""
        self._fix_elements(pose)
        solved = self.search(pose)
        if np.isnan(solved.height):
            self.contacts = [None] * len(self.wheels)
        return solved

    def elements(self) -> list[list[ElementField]]:
        """See `PoseSolver.elements`."""
        most = self.wheels[0].model.settings.patch_count
        return [[] if contact is None else element_fields(contact, most) for contact in self.contacts]

    def _touch(self, wheel: int) -> None:
        self.contacts[wheel] = solve_into(self.wheels[wheel].model, self._solvers[wheel], self.contacts[wheel])

    def _fix_elements(self, pose: Pose) -> None:
        """Elements for the deepest patch of every wheel, at the fast model's height."""
        self.contacts = [None] * len(self.wheels)
        self._solvers = [self.solver] * len(self.wheels)
        self._fast.search(pose)
        for i, (wheel, fast) in enumerate(zip(self.wheels, self._fast.wheels, strict=True)):
            wheel.model.arrays.pose[:] = fast.model.arrays.pose
            wheel.model.arrays.inputs.wheel_angle = pose.wheel_angle
            element = self.solver.elements_at(wheel.model)
            if element is not None:
                self._solvers[i] = replace(self.solver, element=element)

    def _height(self, pose: Pose, roll: float) -> float:
        """See `PoseSolver._height`; starts from the fast model's height."""
        start = self.radius + CLEARANCE + abs(sin(roll)) * self.wheels[0].half_spacing
        try:
            start = self._fast._height(pose, roll)
        except Unsolved as problem:
            start = problem.height
        except LoadNotReached:
            pass
        too_deep = 0

        def carried(z: float) -> Carried:
            nonlocal too_deep
            if too_deep == PATIENCE:
                raise LoadNotReached(status_words(STATUS_TOO_DEEP))
            force = self._carried(pose, roll, z)
            status = self._status()
            if status & TOO_MANY:
                raise LoadNotReached(status_words(TOO_MANY))
            too_deep += bool(status & STATUS_TOO_DEEP)
            return force

        return height_for_load(carried, self.wheels[0].model, pose.load, start, tolerance=EXACT_TOLERANCE)


class LoadNotReached(Exception):
    """The load is not met within any sensible approach, or the wheel is beside its rail."""


class Unsolved(LoadNotReached):
    """The strip model has no solution at the load; height: where that was seen [m]."""

    def __init__(self, message: str, height: float) -> None:
        super().__init__(message)
        self.height = height


class Carried(NamedTuple):
    """At a height: vertical force [N], largest approach [m], below 0 by the distance of the profiles off contact."""

    force: float
    approach: float


def lower(model: ContactModel, load: float, farthest: float = DEEPEST) -> str:
    """Bring one wheel from the height set in its model's arrays to that at which its vertical force is the load [N];
    the arrays then hold the contact there. Returns why the load is not met, empty if it is. Compiled models only."""
    a = model.arrays
    search = search_for([load], a.pose[2], model.radius, a.model.E, farthest=farthest)[0]
    return status_words(meet_load(a.buffer, a.index, search) & UNMET)


def height_for_load(
    carried: Callable[[float], Carried], model: ContactModel, load: float, height: float, *,
    tolerance: float = LOAD_TOLERANCE, farthest: float = DEEPEST,
) -> float:  # fmt: skip
    """Height [m] at which ``carried`` gives the load [N] to a relative tolerance; the last one evaluated.

    model: of one of the wheels; height: to begin with. Raises LoadNotReached when there is no contact, or the load is
    not met within ``farthest`` of the first contact [m]; a load in a jump of the force ends at the jump.
    """
    s = search_for([load], height, model.radius, model.arrays.model.E, tolerance, farthest)[0]
    begin_search(s)
    outcome = SEARCHING
    while outcome == SEARCHING:
        outcome = next_height(s, *carried(float(s.height)), tolerance)
    if outcome & ~STATUS_DISCONTINUOUS:
        raise LoadNotReached(status_words(outcome))
    return float(s.height)
