"""Watches a run for derailment and for a contact that can no longer be solved.

Three signs of a derailment are looked for, each on both wheels, in geometry rather than in forces, so that neither an
impact nor a lost contact hides or fakes one:

- the flange is over the rail: its lowest point has passed the gauge face, outward;
- the wheel has dropped: its tread is deeper below the top of its rail than ``DROP``, so it has left the head;
- the wheel is lifted: no contact for ``LIFT_DISTANCE`` and for ``LIFT_TIME``. Either alone would be a false alarm: a
  wheel that hops by 1 mm flies 3 m at 100 m/s, and at walking pace 50 ms are no distance.

An overlap of wheel and rail beyond what any contact law covers is a lost solution, mostly of too long a step.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wrsim.core.contact import layout as k
from wrsim.core.contact.wheel_rail import DEEPEST
from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.contact.channels import WheelOnRail
    from wrsim.geometry.profile.profile import Profile
    from wrsim.scenario.build import Setup
    from wrsim.simulation.system import Array
    from wrsim.simulation.wheelset_law import WheelsetOnTrack

LIFT_DISTANCE = 3.0
"""Distance without contact on one side after which the wheelset counts as derailed [m] ..."""

LIFT_TIME = 0.05
"""... if the wheel has been in the air for this time as well [s]."""

DROP = 15e-3
"""Depth of the tape circle below the top of its rail at which a wheel has left the rail's head [m]."""

INTERVAL = 5e-3
"""Longest time between two looks [s]; ..."""

STRETCH = 0.25
"""... and the longest way [m]. Independent of the samples that are kept."""


class DerailmentWatch:
    """Asked at regular intervals; answers with the reason to stop, or None. A ``Monitor`` of the integrator."""

    def __init__(self, setup: Setup, law: WheelsetOnTrack) -> None:
        self.law = law
        self.out = np.zeros(6)
        self.interval = min(INTERVAL, STRETCH / setup.run.speed)
        self.last_contact: list[tuple[float, float] | None] = [None, None]
        self.flange_tips = [flange_tip(wheel.model.wheel) for wheel in law.wheels]
        self.gauge_faces = [gauge_face(wheel.model.rail) for wheel in law.wheels]

    def __call__(self, t: float, q: Array, q_t: Array) -> str | None:
        status = self.law(t, q, q_t, self.out)
        distance = self.law.distance
        reason = None
        for i, wheel in enumerate(self.law.wheels):
            reason = reason or self._derailed(i, wheel, t, distance)
        if status & k.STATUS_TOO_DEEP:
            reason = reason or self._overlap()
        return f"{reason}, at t = {t:.4g} s, {distance:.2f} m along the track" if reason else None

    def memory(self) -> Array:
        """When and where either wheel was last seen in contact. See ``simulation.tape.Remembers``."""
        return np.array([np.nan if seen is None else seen[j] for seen in self.last_contact for j in (0, 1)])

    def recall(self, memory: Array) -> None:
        """Put back what ``memory`` gave."""
        pairs = [(float(memory[i]), float(memory[i + 1])) for i in (0, 2)]
        self.last_contact = [None if np.isnan(pair[0]) else pair for pair in pairs]

    def _derailed(self, i: int, wheel: WheelOnRail, t: float, distance: float) -> str:
        """Why the wheelset has derailed on one side; empty when it has not."""
        reason = off_the_rail(wheel, self.flange_tips[i], self.gauge_faces[i])
        if reason:
            return f"derailed: {reason}"
        a = wheel.model.arrays
        count = int(a.total[k.COUNT])
        before = self.last_contact[i]
        if before is None or np.any(a.patches[:count, k.N] > 0.0):
            self.last_contact[i] = (t, distance)
        elif distance - before[1] >= LIFT_DISTANCE and t - before[0] >= LIFT_TIME:
            way = distance - before[1]
            return f"derailed: the {wheel.name} wheel has had no contact with its rail for {way:.2f} m"
        return ""

    def _overlap(self) -> str:
        """Words for wheels that are deeper in their rails than any contact."""
        depths = {w.name: -float(w.model.arrays.total[k.CLOSEST]) for w in self.law.wheels}
        name = max(depths, key=lambda side: depths[side])
        return (
            f"the contact solution is lost: the {name} wheel and its rail overlap by {1e3 * depths[name]:.2g} mm "
            f"(more than {1e3 * DEEPEST:g} mm); a shorter step may help"
        )


def off_the_rail(wheel: WheelOnRail, tip: tuple[float, float] | None, face: float) -> str:
    """How a wheel, at the pose that its model computed last, has left its rail; empty when it has not.

    tip: of its flange, from ``flange_tip``; face: of the rail, from ``gauge_face``.
    """
    pose = wheel.model.arrays.pose
    height = pose[2] - wheel.model.radius - wheel.model.rail.top[1]
    if height < -DROP:
        return f"the {wheel.name} wheel has dropped beside its rail"
    if tip is not None and _outward(wheel, pose, tip) > face:
        return f"the flange of the {wheel.name} wheel has climbed over its rail (lifted by {1e3 * height:.0f} mm)"
    return ""


def _outward(wheel: WheelOnRail, pose: Array, point: tuple[float, float]) -> float:
    """Outward coordinate o [m], in the rail's axes, of a point (u, w) of the wheel profile, below the axle."""
    u, w = point
    return float(pose[1] + u * pose[4] + (wheel.model.radius - w) * pose[5])


def flange_tip(wheel: Profile) -> tuple[float, float] | None:
    """(u, w) of the lowest point of the flange [m]; None for a wheel without a flange."""
    u, w = wheel.at(np.linspace(0.0, wheel.length, 2001))
    flange = u < -0.02
    if not flange.any() or w[flange].min() > -0.01:
        return None
    lowest = int(np.argmin(np.where(flange, w, np.inf)))
    return float(u[lowest]), float(w[lowest])


def gauge_face(rail: Profile) -> float:
    """Outward coordinate of the gauge point of a rail profile [m], of its inner end if it has none."""
    try:
        return rail.gauge_point()[0]
    except InputError:
        return float(rail.at(0.0)[0])
