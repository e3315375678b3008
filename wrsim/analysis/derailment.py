"""Watches a run for derailment.

A wheelset has derailed when one wheel has had no contact for a stated distance, or when the flange stands on top of
its rail: the contact has moved beyond the flange's lowest point, or the wheel is that far beyond its rail.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wrsim.core import layout as k

if TYPE_CHECKING:
    from wrsim.contact.channels import WheelOnRail
    from wrsim.scenario.build import Setup
    from wrsim.simulation.system import Array
    from wrsim.simulation.wheelset_law import WheelsetOnTrack

LIFT_DISTANCE = 3.0
"""Distance without contact on one side after which the wheelset counts as derailed [m]."""

CLIMB_MARGIN = 2e-3
"""The contact counts as on the flange's top when it is nearer to the flange tip than this [m]."""


class DerailmentWatch:
    """Asked at every sample; answers with the reason to stop, or None. A ``Monitor`` of the integrator."""

    def __init__(self, setup: Setup, law: WheelsetOnTrack) -> None:
        self.law = law
        self.out = np.zeros(6)
        self.speed = setup.run.speed
        self.last_contact: list[float | None] = [None, None]
        self.flange_tips = [_flange_tip(wheel) for wheel in law.wheels]

    def __call__(self, t: float, q: Array, q_t: Array) -> str | None:
        self.law(t, q, q_t, self.out)
        distance = self.law.distance
        for i, wheel in enumerate(self.law.wheels):
            a = wheel.model.arrays
            count = int(a.total[k.COUNT])
            loaded = [j for j in range(count) if a.patches[j, k.N] > 0.0]
            before = self.last_contact[i]
            if loaded or before is None:
                self.last_contact[i] = distance
            elif distance - before >= LIFT_DISTANCE:
                return (
                    f"derailed: the {wheel.name} wheel has had no contact with its rail for {distance - before:.2f} m, "
                    f"at t = {t:.4g} s, {distance:.2f} m along the track"
                )
            if loaded:
                main = max(loaded, key=lambda j: a.patches[j, k.N])
                arc = a.patches[main, k.ARC_WHEEL]
                if arc < self.flange_tips[i] + CLIMB_MARGIN:
                    return (
                        f"derailed: the flange of the {wheel.name} wheel has climbed onto the rail, "
                        f"at t = {t:.4g} s, {distance:.2f} m along the track"
                    )
        return None


def _flange_tip(wheel: WheelOnRail) -> float:
    """Arclength of the lowest point of the flange on the wheel profile [m]; -1 for a wheel without a flange."""
    profile = wheel.model.wheel
    arc = np.linspace(0.0, profile.length, 2001)
    u, w = profile.at(arc)
    flange = u < -0.02
    if not flange.any() or w[flange].min() > -0.01:
        return -1.0
    return float(arc[flange][np.argmin(w[flange])])
