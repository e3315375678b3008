"""Poses at a prescribed vertical load with the exact half-space solver in place of the fast model."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from math import sin

import numpy as np

from wrsim.analysis.poses.solver import (
    CLEARANCE,
    Carried,
    LoadNotReached,
    PoseSolver,
    Solved,
    approach_of,
    height_for_load,
)
from wrsim.contact.channels import ElementField, WheelOnRail
from wrsim.contact.half_space import HalfSpace, HalfSpaceContact
from wrsim.contact.half_space.strips import element_fields, solve_into
from wrsim.contact.models import fast_model
from wrsim.contact.pose import Pose
from wrsim.contact.status import TOO_MANY, status_words
from wrsim.core.contact.records import STATUS_TOO_DEEP

LOAD_TOLERANCE = 2e-5  # of the vertical force
PATIENCE = 4  # evaluations with an overlap that is no contact any more


class HalfSpacePoseSolver(PoseSolver):
    """Wheels over their rails; ``contacts`` holds what the solver found at the last pose, one for each wheel.

    The elements are chosen at the first height of a pose and kept while its height is looked for.
    """

    load_tolerance = 10.0 * LOAD_TOLERANCE
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
        solved = super().solve(pose)
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
        self._fast.solve(pose)
        for i, (wheel, fast) in enumerate(zip(self.wheels, self._fast.wheels, strict=True)):
            wheel.model.arrays.pose[:] = fast.model.arrays.pose
            element = self.solver.elements_at(wheel.model)
            if element is not None:
                self._solvers[i] = replace(self.solver, element=element)

    def _height(self, pose: Pose, roll: float) -> float:
        """See `PoseSolver._height`; starts from the fast model's height."""
        start = self.radius + CLEARANCE + abs(sin(roll)) * self.wheels[0].half_spacing
        with suppress(LoadNotReached):
            start = self._fast._height(pose, roll)
        too_deep = 0

        def carried(z: float) -> Carried:
            nonlocal too_deep
            if too_deep == PATIENCE:
                raise LoadNotReached(f"{pose.load:g} N are not met: {status_words(STATUS_TOO_DEEP)}")
            self.evaluate(pose.lateral, z, pose.yaw, roll)
            status = self._status()
            if status & TOO_MANY:
                raise LoadNotReached(status_words(TOO_MANY))
            too_deep += bool(status & STATUS_TOO_DEEP)
            return Carried(float(self.force[2]), max(approach_of(wheel.model) for wheel in self.wheels))

        return height_for_load(carried, self.wheels[0].model, pose.load, start, tolerance=LOAD_TOLERANCE)
