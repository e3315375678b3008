"""Looks at a run while it lasts: derailments and lost contacts end it, lifted wheels and bump stops are noted.

Beside the signs of ``derailment``, a wheel without contact for ``LIFT_DISTANCE`` and for ``LIFT_TIME`` counts as
derailed. Either alone would be a false alarm: a wheel that hops by 1 mm flies 3 m at 100 m/s, and at walking pace 50 ms
are no distance. An overlap of wheel and rail beyond what any contact law covers is a lost solution, mostly of too long
a step.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wrsim.analysis.motion.derailment import WatchedWheel, overlap, wheels_of
from wrsim.analysis.motion.messages import Event, EventKind, OffRail, Overlap, stop_words
from wrsim.contact.model import ContactModel
from wrsim.contact.status import bits_of
from wrsim.core.contact.records import STATUS_NOT_CONVERGED, STATUS_TOO_DEEP
from wrsim.simulation.integrate import EXPLICIT_PARTS
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.system import Array, Work

log = logging.getLogger(__name__)

LIFT_DISTANCE = 3.0  # distance without contact on one side after which the wheelset counts as derailed [m] ...
LIFT_TIME = 0.05  # ... if the wheel has been in the air for this time as well [s]
INTERVAL = 5e-3  # longest time between two looks [s]; ...
STRETCH = 0.25  # ... and the longest way [m]. Independent of the samples that are kept

WITHIN = 1e-6
"""Change of the positions [m, rad] in the last iteration of a step within which a look takes the contacts as they were
computed before it."""

LIFT, STOP, STEPS, SPINS, SLIDES, LOOSE = 0.0, -1.0, -2.0, -3.0, -4.0, -5.0
"""Kinds of events in the notes: a wheel without contact; a bump stop beyond the end of its table; steps that have been
cut since the last look; an axle that is driven, or braked, beyond adhesion; friction without a normal force. A bit of
a contact's status is its own kind."""

KINDS: dict[float, EventKind] = {
    LIFT: "lift", STOP: "stop", STEPS: "steps", SPINS: "spins", SLIDES: "slides", LOOSE: "loose",
}  # fmt: skip

MANY = 20  # looks in a row with steps cut, after which the run warns while it lasts: it takes many times as long
SLOWEST = 4 * EXPLICIT_PARTS // 2  # evaluations of the forces in a step taken by RK44 over those of a usual one

SLIP, GIVEN = 0.02, 0.99
"""An axle is driven or braked beyond adhesion where its slip is more than this part of the speed, creep forces are at
their limit long before, or where slip control gives less than this part of the moment that is asked for; ..."""

SLIP_DISTANCE = 1.0  # ... and reported where that lasts for longer than this [m]
SAME = 1.0  # events of one kind and place of the vehicle that follow each other within this distance are one [m]
MISSED = 0.05  # part of the mean wheel load by which a force between samples goes beyond them where it is reported


class IntersamplePeaks:
    """What the samples of a run miss: how far vertical wheel forces go beyond them at the steps that lie between.

    Samples every 10 ms show what rings at 113 Hz as a slow swing of 13 Hz, and miss its peaks. Looks at the forces
    after every step, as the law has computed them last; costs no evaluation.
    """

    def __init__(self, wheels: Sequence[ContactModel]) -> None:
        self.forces = [model.arrays.rows.total["Fb"] for model in wheels]
        n = len(self.forces)
        self.sample, self.sampled = np.zeros(n), False
        self.steps: list[list[float]] = []
        """Rows (time, distance, forces) of the steps since the last sample."""
        self.worst = np.zeros((n, 4))
        """Of every wheel: beyond the samples by, force, time, distance."""

    def step(self, t: float, distance: float, sampled: bool) -> None:
        """After a step at time t [s]; sampled: whether its state is kept."""
        row = [force.item() for force in self.forces]
        if not sampled:
            self.steps.append([t, distance, *row])
            return
        forces = np.array(row)
        if self.steps and self.sampled:
            rows = np.array(self.steps)
            high, low = np.maximum(self.sample, forces), np.minimum(self.sample, forces)
            beyond = np.maximum(rows[:, 2:] - high, low - rows[:, 2:])
            at = np.argmax(beyond, axis=0)
            for i in np.flatnonzero(beyond.max(axis=0) > self.worst[:, 0]):
                place = rows[at[i]]
                self.worst[i] = beyond[at[i], i], place[2 + i], place[0], place[1]
        self.steps.clear()
        self.sample, self.sampled = forces, True

    def largest(self, least: float) -> tuple[int, list[float]] | None:
        """The wheel whose force goes farthest beyond its samples, its row of ``worst``; None below ``least`` [N]."""
        if not self.worst.size:
            return None
        i = int(np.argmax(self.worst[:, 0]))
        return (i, self.worst[i].tolist()) if self.worst[i, 0] > least else None

    def get_state(self) -> Array:
        """What has been seen so far, in one row."""
        rows = np.ravel(self.steps)
        return np.concatenate([[float(len(self.steps)), float(self.sampled)], self.sample, self.worst.ravel(), rows])

    def set_state(self, memory: Array) -> None:
        """Put back what ``get_state`` gave."""
        count, n = int(memory[0]), self.sample.size
        self.sampled, self.sample, rest = bool(memory[1]), memory[2 : 2 + n].copy(), memory[2 + n :]
        self.worst = rest[: 4 * n].reshape(n, 4).copy()
        self.steps = rest[4 * n :].reshape(count, 2 + n).tolist()


class Monitor:
    """Asked at regular intervals; answers with the reason to stop, or None. ``events`` gives what it has noted."""

    def __init__(self, law: VehicleOnTrack, speed: float, work: Work | None = None) -> None:
        """speed [m/s]: how far the vehicle goes between two looks; work: what the integration takes."""
        self.law, self.work = law, work or Work()
        self.cut_steps, self.cut_looks = 0, 0
        self.interval = min(INTERVAL, STRETCH / speed)
        self.wheels = wheels_of(law)
        self.last_contact = np.full((len(self.wheels), 2), np.nan)
        self.substitutes = np.array([wheel.model.arrays.substitutes for wheel in self.wheels], dtype=float)
        elements = law.vehicle.elements
        self.stops = [(i, e.limits, e.travel_place) for i, e in enumerate(elements) if e.limits]
        normals = [None if e.slider is None else e.slider.normal for e in elements]
        self.pressed = np.array([i for i, n in enumerate(normals) if n is not None and n.sense is None], dtype=int)
        self.notes = np.zeros((0, 6))
        """Rows (kind, which wheel or element, time, distance, last time, last distance)."""
        self.peaks = IntersamplePeaks([wheel.model for wheel in self.wheels])

    def step(self, t: float, sampled: bool) -> None:
        """After every step, with what the law has computed last; sampled: whether its state is kept."""
        self.peaks.step(t, self.law.distance, sampled)

    def __call__(self, t: float, q: Array, q_t: Array) -> str | None:
        outcome = self.look(t, q, q_t)
        return None if outcome is None else stop_words(outcome, self.law.vehicle, t, self.law.distance)

    def look(self, t: float, q: Array, q_t: Array) -> OffRail | Overlap | None:
        """What ends the run, if anything; notes what else there is."""
        self.law.at(t, q, q_t, WITHIN)
        distance, too_deep = self.law.distance, 0
        ending: OffRail | Overlap | None = None
        for i, wheel in enumerate(self.wheels):
            ending = ending or self._look_at(i, wheel, t, distance)
            status, substitutes = wheel.status, wheel.model.arrays.substitutes
            too_deep |= status & STATUS_TOO_DEEP
            flags = status & ~STATUS_TOO_DEEP
            if substitutes > self.substitutes.item(i):  # also between two looks
                self.substitutes[i] = substitutes
                flags |= STATUS_NOT_CONVERGED
            for bit in bits_of(flags):
                self._note(bit, i, t, distance)
        for i, limits, place in self.stops:
            if not limits[0] <= self.law.records[i, place] <= limits[1]:
                self._note(STOP, i, t, distance)
        for i in self.pressed.tolist():
            row = self.law.elements[i]
            if np.dot(row.load.tolist(), self.law.records[row.normal, :3]) <= 0.0:
                self._note(LOOSE, i, t, distance)
        for i, axle in enumerate(self.law.axles if self.law.driven else ()):
            less = axle.asked != 0.0 and axle.moment / axle.asked < GIVEN
            if less or (axle.asked != 0.0 and abs(axle.slip) > SLIP * abs(axle.speed)):
                self._note(SPINS if axle.asked > 0.0 else SLIDES, i, t, distance)
        if self.work.cut_steps > self.cut_steps:
            self._note(STEPS, 0, t, distance)
            self._warn_of_cuts(t, distance)
        else:
            self.cut_looks = 0
        self.cut_steps = self.work.cut_steps
        if too_deep:
            ending = ending or overlap(self.wheels)
        return ending

    def _warn_of_cuts(self, t: float, distance: float) -> None:
        """Warn once, while the run lasts, that its steps are cut again and again."""
        self.cut_looks += 1
        if self.cut_looks == MANY:
            since = self.notes[self.notes[:, 0] == STEPS][-1]
            log.warning(
                "the time step has to be cut again and again since t = %.4g s, %.2f m along the track: the run takes "
                "up to %d times as long as usual. A mass or a stiffness out of proportion does this (wrsim check warns "
                "of some), or contact that comes and goes: run.integrator = \"rk44\" may be faster",
                since[2], since[3], SLOWEST,
            )  # fmt: skip

    def _look_at(self, i: int, wheel: WatchedWheel, t: float, distance: float) -> OffRail | None:
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

    def events(self) -> list[Event]:
        """Everything noted, in the order of its begin."""
        found = []
        for kind, which, t, distance, last_t, last_distance in self.notes.tolist():
            name, part, side = KINDS.get(kind, "contact"), "", ""
            if kind in (SPINS, SLIDES):
                if last_distance - distance <= SLIP_DISTANCE:
                    continue
                part = self.law.vehicle.wheelsets[int(which)].name
            elif kind in (STOP, LOOSE):
                part = self.law.vehicle.elements[int(which)].name
            elif kind != STEPS:
                part, side = self.wheels[int(which)].wheelset, self.wheels[int(which)].side
            bit = int(kind) if name == "contact" else 0
            found.append(Event(name, part, (t, distance), (last_t, last_distance), side, bit))
        mean_load = 0.5 * self.law.vehicle.weight / len(self.law.vehicle.wheelsets)
        if (peak := self.peaks.largest(MISSED * mean_load)) is not None:
            wheel, (beyond, force, *at) = self.wheels[peak[0]], peak[1]
            place = at[0], at[1]
            found.append(Event("between", wheel.wheelset, place, place, wheel.side, 0, (force, beyond)))
        return sorted(found, key=lambda event: (event.start, event.part, event.side))

    @property
    def statuses(self) -> NDArray[np.int_]:
        """Messages of the contact of every wheel since the beginning, as one status each."""
        found = np.zeros(len(self.wheels), dtype=int)
        for kind, which in self.notes[self.notes[:, 0] > LIFT, :2].astype(int):
            found[which] |= kind
        return found

    def get_state(self) -> Array:
        """See ``simulation.recorder.HasState``."""
        between = self.peaks.get_state()
        own = (self.last_contact.ravel(), self.substitutes, self.notes.ravel())
        return np.concatenate([[self.cut_steps, between.size], between, *own])

    def set_state(self, memory: Array) -> None:
        """Put back what ``get_state`` gave."""
        self.cut_steps, behind = int(memory[0]), 2 + int(memory[1])
        self.peaks.set_state(memory[2:behind])
        memory = memory[behind:]
        size, wheels = self.last_contact.size, len(self.substitutes)
        self.last_contact = memory[:size].reshape(self.last_contact.shape).copy()
        self.substitutes = memory[size : size + wheels].copy()
        self.notes = memory[size + wheels :].reshape(-1, 6).copy()
        places = np.where(np.isin(self.notes[:, 0], (STOP, LOOSE)), len(self.law.vehicle.elements), wheels)
        if not (np.isfinite(self.notes).all() and ((self.notes[:, 1] >= 0) & (self.notes[:, 1] < places)).all()):
            raise ValueError("events of a wheel or an element that is not there")
