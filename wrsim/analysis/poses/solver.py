"""Poses at a prescribed vertical load: one wheel at a given roll, or a wheelset that finds its own roll.

The track is straight and level. The wheelset's centre is at the lateral shift, turned by the yaw; it rolls at
``speed`` along the track without slip at the tape circle (the turning rate is V / R about the yawed axle), or is
at rest in the frictionless case. The height is found for the prescribed load; friction takes part in the balance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from math import sin
from operator import or_
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from wrsim.contact.channels import ElementField, WheelOnRail
from wrsim.contact.pose import Pose
from wrsim.contact.status import REMARKS, status_words
from wrsim.core.body.kinematics import kinematics
from wrsim.core.body.wheel_forces import set_pose, wheel_wrench
from wrsim.core.frames import Frame
from wrsim.core.linalg import Vec

ROLLING_SPEED = 2.0  # of the quasi-static rolling [m/s]; creepages do not depend on it
DEEPEST = 5e-3  # approach at which the search for the load is given up [m]
LARGEST_ROLL = 0.05  # of a wheelset that looks for its balance [rad]


@dataclass(frozen=True)
class Solved:
    """Where the wheelset comes to rest: height of its centre above the track plane [m], roll [rad]; a message when
    there is no solution (the heights then are not-a-number, or the nearest state); further remarks."""

    height: float
    roll: float
    message: str = ""
    remark: str = ""


class PoseSolver:
    """One wheel or two over their rails on straight track."""

    load_tolerance = 1e-6  # of the vertical force
    missed = "no equilibrium: the contact force is discontinuous at this load"

    def __init__(self, wheels: Sequence[WheelOnRail], rolling: bool, radius: float) -> None:
        self.wheels = tuple(wheels)
        self.speed = ROLLING_SPEED if rolling else 0.0
        self.radius = radius
        self.force = np.zeros(3)
        self.moment = np.zeros(3)

    def evaluate(self, lateral: float, height: float, yaw: float, roll: float) -> None:
        """Contact of all wheels at one pose; leaves ``force`` and ``moment`` at the centre of mass."""
        q = np.array([height, 0.0, lateral, yaw, roll, 0.0])
        # spin rate about the axle; no other motion but along the track
        q_t = np.array([0.0, self.speed, 0.0, 0.0, 0.0, self.speed / self.radius])
        body = kinematics(q, q_t)
        self.force[:] = 0.0
        self.moment[:] = 0.0
        for i, wheel in enumerate(self.wheels):
            o, b = wheel.rail_origin
            side = float(wheel.side)
            rail = Frame(Vec(0.0, side * o, b), Vec(1.0, 0.0, 0.0), Vec(0.0, 1.0, 0.0), Vec(0.0, 0.0, 1.0))
            a = wheel.model.arrays
            set_pose(body, rail, side, wheel.half_spacing, a.pose)
            # the section of the rail beside the wheel
            a.pose[0] = 0.0
            self._touch(i)
            force, moment = wheel_wrench(body, rail, side, wheel.half_spacing, a.total)
            self.force += force
            self.moment += moment

    def solve(self, pose: Pose) -> Solved:
        """Height (and roll, with two wheels) for the pose's load. The models then hold the contact found."""
        try:
            roll = pose.roll if len(self.wheels) == 1 else self._balanced_roll(pose)
            height = self._height(pose, roll)
        except LoadNotReached as problem:
            return Solved(float("nan"), float("nan"), str(problem))
        return Solved(height, roll, self._problem(pose.load), status_words(self._status() & REMARKS))

    def elements(self) -> list[list[ElementField]]:
        """Elements of every wheel's patches at the last pose, where the solver has any."""
        return []

    def _touch(self, wheel: int) -> None:
        """Contact of one wheel at the pose set in its model's arrays."""
        self.wheels[wheel].model.arrays.call()

    def _status(self) -> int:
        """Status of all the contacts found last."""
        return reduce(or_, (wheel.model.arrays.status for wheel in self.wheels))

    def _problem(self, load: float) -> str:
        """Why the state that was found is no solution; nothing when it is one."""
        words = [status_words(self._status() & ~REMARKS)]
        if abs(self.force[2] / load - 1.0) > self.load_tolerance:
            words.insert(0, f"{self.missed}: {self.force[2]:.6g} N instead of {load:.6g} N")
        return "; ".join(filter(None, words))

    def _first_contact(self, pose: Pose, roll: float) -> float:
        """A height with contact, approached from above by the clearance between the profiles."""
        height = self.radius + 0.02 + abs(sin(roll)) * self.wheels[0].half_spacing
        lowest = height - 0.1
        for _ in range(400):
            self.evaluate(pose.lateral, height, pose.yaw, roll)
            if any(w.model.arrays.total["lobes"] > 0 for w in self.wheels):
                return height
            height -= max(min(float(w.model.arrays.total["closest"]) for w in self.wheels), 1e-6)
            if height < lowest:
                break
        raise LoadNotReached(
            f"no contact: at a lateral shift of {1e3 * pose.lateral:g} mm the wheel is beside its rail"
        )

    def _height(self, pose: Pose, roll: float) -> float:
        """Height at which the vertical force is the load. The models then hold the contact there."""

        def excess(height: float) -> float:
            self.evaluate(pose.lateral, height, pose.yaw, roll)
            return float(self.force[2]) - pose.load

        first = self._first_contact(pose, roll)
        sign = 1.0 if excess(first) > 0.0 else -1.0
        step = 1e-5
        near, far = first, first + sign * step
        while excess(far) * sign > 0.0:
            near = far
            step *= 1.6
            far += sign * step
            if step > DEEPEST:
                raise LoadNotReached(f"{pose.load:g} N are not reached within {1e3 * DEEPEST:g} mm of approach")
        height = float(brentq(excess, near, far, xtol=1e-16, rtol=8.9e-16, maxiter=200))
        excess(height)
        return height

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
        return float(brentq(moment, *ends, xtol=1e-15, rtol=8.9e-16, maxiter=200))


LARGEST_MOVE = 0.3  # of the approach in one step
EVALUATIONS = 40


class LoadNotReached(Exception):
    """The load is not met within any sensible approach, or the wheel is beside its rail."""


class Carried(NamedTuple):
    """What a wheel carries at a height: vertical force [N], largest approach [m]."""

    force: float
    approach: float


def height_for_load(
    carried: Callable[[float], Carried], load: float, height: float, *, tolerance: float, farthest: float
) -> float:
    """Height [m] at which ``carried`` gives the load [N] to a relative tolerance; the last one asked for.

    height: to begin with. Raises LoadNotReached when the load is not met within ``farthest`` of it [m]; a load in a
    jump of the force ends at the jump.
    """
    target = load ** (2.0 / 3.0)
    high, low = np.inf, -np.inf  # heights with too little and too much force
    first, at = height, carried(height)
    excess = _power(at) - target
    # force^(2/3) is about proportional to the approach
    rate = -max(_power(at), 0.1 * target) / max(at.approach, 1e-7)
    for _ in range(EVALUATIONS):
        if abs(at.force / load - 1.0) < tolerance:
            break
        if excess < 0.0:
            high = min(high, height)
        else:
            low = max(low, height)
        largest = LARGEST_MOVE * max(at.approach, 1e-6)
        new = height + float(np.clip(-excess / rate, -largest, largest))
        if not low < new < high:
            new = 0.5 * (low + high) if np.isfinite(low) and np.isfinite(high) else height - excess / rate
        if abs(new - first) > farthest:
            raise LoadNotReached(f"{load:g} N are not reached within {1e3 * farthest:g} mm of approach")
        if abs(new - height) < 1e-13:
            break
        last, last_height = excess, height
        height = new
        at = carried(height)
        excess = _power(at) - target
        if (excess - last) * (height - last_height) < 0.0:
            rate = (excess - last) / (height - last_height)
    return height


def _power(at: Carried) -> float:
    return float(np.cbrt(max(at.force, 0.0)) ** 2)
