"""Poses at a prescribed vertical load with the exact half-space solver in place of the fast model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from wrsim.analysis.poses.poses import DEEPEST, LoadNotReached, NoContact, Solved, StaticBench
from wrsim.contact.channels import ElementField, WheelOnRail
from wrsim.contact.half_space.patch import HalfSpaceContact
from wrsim.contact.half_space.rows import element_fields, solve_into
from wrsim.contact.half_space.solver import STATUS_TOO_MANY, HalfSpace, status_words
from wrsim.core.body.kinematics import kinematics
from wrsim.core.body.wheel_pose import add_forces, set_pose
from wrsim.core.contact import layout as k
from wrsim.scenario.cases import StaticPose

LOAD_TOLERANCE = 2e-5  # of the vertical force
LARGEST_MOVE = 0.3  # of the approach in one step of the height
EVALUATIONS = 40
PATIENCE = 4  # evaluations with an overlap that is no contact any more


class HalfSpaceBench(StaticBench):
    """Wheels over their rails; ``contacts`` holds what the solver found at the last pose, one for each wheel.

    The elements are chosen at the first height of a pose and kept while its height is looked for.
    """

    def __init__(
        self, wheels: Sequence[WheelOnRail], rolling: bool, radius: float, solver: HalfSpace | None = None
    ) -> None:
        super().__init__(wheels, rolling, radius)
        self.solver = solver if solver is not None else HalfSpace.of(self.wheels[0].model.settings.half_space)
        self.contacts: list[HalfSpaceContact | None] = [None] * len(self.wheels)
        self.evaluations = 0
        self._solvers = [self.solver] * len(self.wheels)
        self._fast = StaticBench([replace(w, model=w.model.fast()) for w in wheels], rolling, radius)

    def evaluate(self, lateral: float, height: float, yaw: float, roll: float) -> None:
        """Contact of all wheels at one pose; leaves ``contacts``, ``force`` and ``moment`` at the centre of mass."""
        q = np.array([height, 0.0, lateral, yaw, roll, 0.0])
        body = kinematics(q, np.array([0.0, self.speed, 0.0, 0.0, 0.0, self.speed / self.radius]))
        self.force[:] = 0.0
        self.moment[:] = 0.0
        self.evaluations += 1
        for i, wheel in enumerate(self.wheels):
            o, b = wheel.rail_origin
            frame = (0.0, wheel.side * o, b, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
            pose = wheel.model.arrays.pose
            set_pose(body, frame, wheel.side, wheel.half_spacing, pose)
            pose[0] = 0.0
            self.contacts[i] = solve_into(wheel.model, self._solvers[i], self.contacts[i])
            add_forces(body, frame, wheel.side, wheel.half_spacing, wheel.model.arrays.total, self.force, self.moment)

    def solve(self, pose: StaticPose) -> Solved:
        """Height (and roll, with two wheels) for the pose's load; ``contacts`` then holds the contact found."""
        self._fix_elements(pose)
        try:
            roll = pose.roll if len(self.wheels) == 1 else self._balanced_roll(pose)
            height = self._height(pose, roll)
        except (NoContact, LoadNotReached) as problem:
            self.contacts = [None] * len(self.wheels)
            return Solved(float("nan"), float("nan"), str(problem))
        missed = self.force[2] / pose.load - 1.0
        message = status_words(self._status())
        if abs(missed) > 10.0 * LOAD_TOLERANCE:
            words = f"the load was missed: {self.force[2]:.6g} N instead of {pose.load:.6g} N"
            message = f"{words}; {message}" if message else words
        return Solved(height, roll, message)

    def elements(self) -> list[list[ElementField]]:
        """See `StaticBench.elements`."""
        most = self.wheels[0].model.settings.max_patches
        return [[] if contact is None else element_fields(contact, most) for contact in self.contacts]

    def _status(self) -> int:
        """All that the contacts found last have to say."""
        status = 0
        for contact in self.contacts:
            status |= contact.status if contact is not None else 0
        return status

    def _fix_elements(self, pose: StaticPose) -> None:
        """Elements for the deepest patch of every wheel, at the fast model's height."""
        self.contacts = [None] * len(self.wheels)
        self._solvers = [self.solver] * len(self.wheels)
        self._fast.solve(pose)
        for i, (wheel, fast) in enumerate(zip(self.wheels, self._fast.wheels, strict=True)):
            wheel.model.arrays.pose[:] = fast.model.arrays.pose
            element = self.solver.elements_at(wheel.model)
            if element is not None:
                self._solvers[i] = replace(self.solver, element=element)

    def _height(self, pose: StaticPose, roll: float) -> float:
        """Height at which the vertical force is the load: secants on force^(2/3), nearly linear in the height."""
        try:
            height = self._fast._height(pose, roll)
        except LoadNotReached:
            height = self._fast._first_contact(pose, roll)
        target = pose.load ** (2.0 / 3.0)

        def excess(z: float) -> float:
            self.evaluate(pose.lateral, z, pose.yaw, roll)
            if self._status() & STATUS_TOO_MANY:
                raise LoadNotReached(status_words(STATUS_TOO_MANY))
            return float(np.cbrt(max(self.force[2], 0.0)) ** 2 - target)

        def approach() -> float:
            return max((p.approach for c in self.contacts if c is not None for p in c.patches), default=0.0)

        high, low = np.inf, -np.inf  # heights with too little and too much force
        too_deep = 0
        first = height
        value = excess(height)
        # force^(2/3) is about proportional to the approach
        rate = -max(value + target, 0.1 * target) / max(approach(), 1e-7)
        for _ in range(EVALUATIONS):
            if abs(self.force[2] / pose.load - 1.0) < LOAD_TOLERANCE:
                return height
            if value < 0.0:
                high = min(high, height)
            else:
                low = max(low, height)
            too_deep += bool(self._status() & k.STATUS_TOO_DEEP)
            if too_deep == PATIENCE:
                raise LoadNotReached(f"{pose.load:g} N are not met: {status_words(k.STATUS_TOO_DEEP)}")
            largest = LARGEST_MOVE * max(approach(), 1e-6)
            new = height + float(np.clip(-value / rate, -largest, largest))
            if not low < new < high:
                new = 0.5 * (low + high) if np.isfinite(low) and np.isfinite(high) else height - value / rate
            if abs(new - first) > DEEPEST:
                raise LoadNotReached(f"{pose.load:g} N are not reached within {1e3 * DEEPEST:g} mm of approach")
            if abs(new - height) < 1e-13:
                return height
            last, last_value = height, value
            height = new
            value = excess(height)
            if (value - last_value) * (height - last) < 0.0:
                rate = (value - last_value) / (height - last)
        return height
