"""Looks at a run while it lasts: derailments and lost contacts end it, lifted wheels and bump stops are noted.

Beside the signs of ``derailment``, a wheel without contact for ``LIFT_DISTANCE`` and for ``LIFT_TIME`` counts as
derailed. Either alone would be a false alarm: a wheel that hops by 1 mm flies 3 m at 100 m/s, and at walking pace 50 ms
are no distance. An overlap of wheel and rail beyond what any contact law covers is a lost solution, mostly of too long
a step.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np

from wrsim.analysis.motion.derailment import Wheel, wheels_of
from wrsim.analysis.motion.outcomes import Event, OffRail, Overlap
from wrsim.analysis.motion.words import stop_words
from wrsim.core.contact import records as k

if TYPE_CHECKING:
    from wrsim.simulation.law import VehicleOnTrack
    from wrsim.simulation.system import Array

LIFT_DISTANCE = 3.0
"""Distance without contact on one side after which the wheelset counts as derailed [m] ..."""

LIFT_TIME = 0.05
"""... if the wheel has been in the air for this time as well [s]."""

INTERVAL = 5e-3
"""Longest time between two looks [s]; ..."""

STRETCH = 0.25
"""... and the longest way [m]. Independent of the samples that are kept."""

LIFT, STOP, SUBSTITUTE = 0.0, 1.0, 2.0
"""Kinds of events in the notes: a wheel without contact; a bump stop beyond the end of its table; a contact that has
not been solved since the last look."""

SAME = 1.0
"""Events of one kind and place of the vehicle that follow each other within this distance are one [m]."""


class Monitor:
    """Asked at regular intervals; answers with the reason to stop, or None. ``events`` tells what it has noted."""

    def __init__(self, law: VehicleOnTrack, speed: float) -> None:
        """speed [m/s]: how far the vehicle goes between two looks."""
        self.law = law
        self.interval = min(INTERVAL, STRETCH / speed)
        self.wheels = wheels_of(law)
        self.last_contact = np.full((len(self.wheels), 2), np.nan)
        self.substitutes = np.array([wheel.model.arrays.substitutes for wheel in self.wheels], dtype=float)
        elements = law.vehicle.elements
        self.stops = [(i, e.limits, e.travel_place) for i, e in enumerate(elements) if e.limits]
        self.notes = np.zeros((0, 6))
        """Rows (kind, which wheel or element, time, distance, last time, last distance)."""

    def __call__(self, t: float, q: Array, q_t: Array) -> str | None:
        outcome = self.look(t, q, q_t)
        return None if outcome is None else stop_words(outcome, self.law.vehicle, t, self.law.distance)

    def look(self, t: float, q: Array, q_t: Array) -> OffRail | Overlap | None:
        """What ends the run, if anything; notes what else there is."""
        status = self.law.at(t, q, q_t)
        distance = self.law.distance
        ending: OffRail | Overlap | None = None
        for i, wheel in enumerate(self.wheels):
            ending = ending or self._look_at(i, wheel, t, distance)
            if wheel.model.arrays.substitutes > self.substitutes[i]:
                self.substitutes[i] = wheel.model.arrays.substitutes
                self._note(SUBSTITUTE, i, t, distance)
        for i, limits, place in self.stops:
            if not limits[0] <= self.law.records[i, place] <= limits[1]:
                self._note(STOP, i, t, distance)
        if status & k.STATUS_TOO_DEEP:
            ending = ending or self._overlap()
        return ending

    def _look_at(self, i: int, wheel: Wheel, t: float, distance: float) -> OffRail | None:
        """How the vehicle has derailed at a wheel, if it has. Notes a lifted wheel."""
        off = wheel.off_the_rail()
        if off is not None:
            return off
        since = self.last_contact[i]
        if wheel.in_contact or np.isnan(since[0]):
            self.last_contact[i] = t, distance
            return None
        self._note(LIFT, i, t, distance)
        way = distance - since[1]
        if way >= LIFT_DISTANCE and t - since[0] >= LIFT_TIME:
            return OffRail(wheel.wheelset, wheel.side, "no contact", float(way))
        return None

    def _note(self, kind: float, which: int, t: float, distance: float) -> None:
        """Begin an event, or let the last one of its kind and place go on."""
        same = np.flatnonzero((self.notes[:, 0] == kind) & (self.notes[:, 1] == which))
        if same.size and abs(distance - self.notes[same[-1], 5]) <= SAME:
            self.notes[same[-1], 4:] = t, distance
        else:
            self.notes = np.vstack([self.notes, [kind, which, t, distance, t, distance]])

    def _overlap(self) -> Overlap:
        """The wheel that is deepest in its rail."""
        depths = [-float(wheel.model.arrays.total["closest"]) for wheel in self.wheels]
        deepest = int(np.argmax(depths))
        return Overlap(self.wheels[deepest].wheelset, self.wheels[deepest].side, depths[deepest])

    def events(self) -> list[Event]:
        """Everything noted, in the order of its begin."""
        found = []
        for kind, which, t, distance, last_t, last_distance in self.notes.tolist():
            begin, end = (t, distance), (last_t, last_distance)
            if kind != STOP:
                wheel = self.wheels[int(which)]
                name: Literal["lift", "substitute"] = "lift" if kind == LIFT else "substitute"
                found.append(Event(name, wheel.wheelset, begin, end, wheel.side))
            else:
                found.append(Event("stop", self.law.vehicle.elements[int(which)].name, begin, end))
        return sorted(found, key=lambda event: (event.start, event.part, event.side))

    def memory(self) -> Array:
        """What has been seen so far. See ``simulation.recorder.Remembers``."""
        return np.concatenate([self.last_contact.ravel(), self.substitutes, self.notes.ravel()])

    def recall(self, memory: Array) -> None:
        """Put back what ``memory`` gave."""
        size, wheels = self.last_contact.size, len(self.substitutes)
        self.last_contact = memory[:size].reshape(self.last_contact.shape).copy()
        self.substitutes = memory[size : size + wheels].copy()
        self.notes = memory[size + wheels :].reshape(-1, 6).copy()
