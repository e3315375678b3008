"""Watches the run of a whole vehicle: derailment ends it; lifted wheels and bump stops at their end are noted.

The signs of a derailment are those of ``analysis.motion.derailment``, looked for on every wheel.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.motion.derailment import (
    INTERVAL,
    LIFT_DISTANCE,
    LIFT_TIME,
    STRETCH,
    flange_tip,
    gauge_face,
    off_the_rail,
)
from wrsim.core.contact import layout as k
from wrsim.core.contact.wheel_rail import DEEPEST
from wrsim.vehicle.elements import Strut

if TYPE_CHECKING:
    from wrsim.contact.channels import WheelOnRail
    from wrsim.scenario.build import Setup
    from wrsim.simulation.system import Array
    from wrsim.simulation.vehicle_law import VehicleOnTrack

LIFT, STOP = 0.0, 1.0
"""Kinds of events: a wheel without contact; a bump stop beyond the end of its table."""

SAME = 1.0
"""Events of one kind and place of the vehicle that follow each other within this distance are one [m]."""


class VehicleWatch:
    """A ``Monitor`` of the integrator: answers with the reason to stop, or None. ``events`` tells what it has noted."""

    def __init__(self, setup: Setup, law: VehicleOnTrack) -> None:
        self.law = law
        self.out = np.zeros(law.size)
        self.interval = min(INTERVAL, STRETCH / setup.run.speed)
        self.names = law.vehicle.names
        self.wheels = [(i, wheel) for i, pair in enumerate(law.wheels) for wheel in pair]
        self.tips = [flange_tip(wheel.model.wheel) for _, wheel in self.wheels]
        self.faces = [gauge_face(wheel.model.rail) for _, wheel in self.wheels]
        self.last_contact = np.full((len(self.wheels), 2), np.nan)
        elements = law.vehicle.elements
        self.stops = [(i, e.limits, e.axis or 0) for i, e in enumerate(elements) if isinstance(e, Strut) and e.limits]
        self.notes = np.zeros((0, 6))
        """Rows (kind, which wheel or element, time, distance, last time, last distance)."""

    def __call__(self, t: float, q: Array, q_t: Array) -> str | None:
        status = self.law(t, q, q_t, self.out)
        distance = self.law.distance
        reason = None
        for i, (w, wheel) in enumerate(self.wheels):
            reason = reason or self._look(i, w, wheel, t, distance)
        for i, limits, axis in self.stops:
            travel = self.law.records[i, 3 + axis]
            if not limits[0] <= travel <= limits[1]:
                self._note(STOP, i, t, distance)
        if status & k.STATUS_TOO_DEEP and not reason:
            reason = self._overlap()
        return f"{reason}, at t = {t:.4g} s, {distance:.2f} m along the track" if reason else None

    def _look(self, i: int, w: int, wheel: WheelOnRail, t: float, distance: float) -> str:
        """Why the vehicle has derailed at a wheel; empty when it has not. Notes a lifted wheel."""
        of = f" of wheelset {self.names[w]}"
        reason = off_the_rail(wheel, self.tips[i], self.faces[i])
        if reason:
            return f"derailed: {reason.replace(' wheel', ' wheel' + of, 1)}"
        a = wheel.model.arrays
        count = int(a.total[k.COUNT])
        since = self.last_contact[i]
        if np.any(a.patches[:count, k.N] > 0.0) or np.isnan(since[0]):
            self.last_contact[i] = (t, distance)
            return ""
        self._note(LIFT, i, t, distance)
        way = distance - since[1]
        if way >= LIFT_DISTANCE and t - since[0] >= LIFT_TIME:
            return f"derailed: the {wheel.name} wheel{of} has had no contact with its rail for {way:.2f} m"
        return ""

    def _note(self, kind: float, which: int, t: float, distance: float) -> None:
        """Begin an event, or let the last one of its kind and place go on."""
        same = np.flatnonzero((self.notes[:, 0] == kind) & (self.notes[:, 1] == which))
        if same.size and abs(distance - self.notes[same[-1], 5]) <= SAME:
            self.notes[same[-1], 4:] = t, distance
        else:
            self.notes = np.vstack([self.notes, [kind, which, t, distance, t, distance]])

    def _overlap(self) -> str:
        """Words for wheels that are deeper in their rails than any contact."""
        depths = [-float(wheel.model.arrays.total[k.CLOSEST]) for _, wheel in self.wheels]
        deepest = int(np.argmax(depths))
        w, wheel = self.wheels[deepest]
        return (
            f"the contact solution is lost: the {wheel.name} wheel of wheelset {self.names[w]} and its rail overlap by "
            f"{1e3 * depths[deepest]:.2g} mm (more than {1e3 * DEEPEST:g} mm); a shorter step may help"
        )

    def events(self) -> list[tuple[float, float, str]]:
        """Time [s], distance of the vehicle [m] and words of everything noted, in the order of its begin."""
        found = []
        for kind, which, t, distance, last_t, last_distance in self.notes:
            lasted = f"for {last_distance - distance:.2f} m, {1e3 * (last_t - t):.0f} ms"
            if kind == LIFT:
                w, wheel = self.wheels[int(which)]
                words = f"the {wheel.name} wheel of wheelset {self.names[w]} is lifted {lasted}"
            else:
                words = (
                    f"bump stop {self.law.vehicle.elements[int(which)].name} is beyond the end of its table {lasted}"
                )
            found.append((float(t), float(distance), words))
        return sorted(found)

    def memory(self) -> Array:
        """What has been seen so far. See ``simulation.tape.Remembers``."""
        return np.concatenate([self.last_contact.ravel(), self.notes.ravel()])

    def recall(self, memory: Array) -> None:
        """Put back what ``memory`` gave."""
        size = self.last_contact.size
        self.last_contact = memory[:size].reshape(self.last_contact.shape).copy()
        self.notes = memory[size:].reshape(-1, 6).copy()
