"""Looks at a run while it lasts: derailments and lost contacts end it, lifted wheels and bump stops are noted.

Beside the signs of ``derailment``, a wheel without contact for ``LIFT_DISTANCE`` and for ``LIFT_TIME`` counts as
derailed. Either alone would be a false alarm: a wheel that hops by 1 mm flies 3 m at 100 m/s, and at walking pace 50 ms
are no distance. An overlap of wheel and rail beyond what any contact law covers is a lost solution, mostly of too long
a step.
"""

import logging
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from wrsim.analysis.motion.derailment import WatchedWheel, overlap, watched, wheels_of
from wrsim.analysis.motion.messages import Derailment, Event, EventKind, end_words, stop_words
from wrsim.analysis.motion.phase_error import PhaseError
from wrsim.contact.records import STATUS_NOT_CONVERGED, STATUS_PROFILE_END, STATUS_TOO_DEEP
from wrsim.contact.status import bits_of
from wrsim.simulation.integrate import EXPLICIT_PARTS
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.step_size import STEPS_OF_A_PERIOD, growing_modes
from wrsim.simulation.system import Array, Work
from wrsim.vehicle.dynamics import watch as kernel
from wrsim.vehicle.dynamics.vehicle_forces import FIRST_WHEEL

log = logging.getLogger(__name__)

LIFT_DISTANCE = 3.0  # distance without contact on one side after which the wheelset counts as derailed [m] ...
LIFT_TIME = 0.05  # ... if the wheel has been in the air for this time as well [s]
INTERVAL = 5e-3  # longest time between two looks [s]; ...
STRETCH = 0.25  # ... and the longest way [m]. Independent of the samples that are stored

WITHIN = 1e-6
"""Change of the positions [m, rad] in the last iteration of a step within which a look takes the contacts as they were
computed before it."""

LIFT, STOP, STEPS, SPINS, SLIDES, LOOSE, SWINGS = 0.0, -1.0, -2.0, -3.0, -4.0, -5.0, -6.0
"""Kinds of events in the notes: a wheel without contact; a bump stop beyond the end of its table; steps that have been
cut since the last look; an axle that is driven, or braked, beyond adhesion; friction without a normal force; a wheelset
that excites itself on its contacts. A bit of a contact's status is its own kind."""

KINDS: dict[float, EventKind] = {
    LIFT: "lift", STOP: "stop", STEPS: "steps", SPINS: "spins", SLIDES: "slides", LOOSE: "loose", SWINGS: "swings",
}  # fmt: skip

MANY = 20  # looks in a row with steps cut, after which the run warns while it lasts: it takes many times as long
SLOWEST = 4 * EXPLICIT_PARTS // 2  # evaluations of the forces in a step taken by RK44 over those of a usual one

SLIP_DISTANCE = 1.0  # slip beyond adhesion is reported where it lasts for longer than this [m]
SAME = 1.0  # events of one kind and place of the vehicle that follow each other within this distance are one [m]
MISSED = 0.05  # part of the mean wheel load beyond which a force that samples or steps miss is reported
PEAK_ERROR = 0.01  # error of a peak of force that a chosen step leaves, as a part of it or of the mean wheel load

PAUSE = 0.5
"""Least time between two looks for motions that grow [s]; what grows by less than e until the next one is left to it.
They are looked for where a vertical force bends by more than ``MISSED`` from look to look: calm wheels cost nothing."""

STRIKE = np.pi / 12.0
"""Error of a peak of force over its second difference from step to step. A trapezoidal rule such as generalised alpha
makes a vibration A cos(w t) slower by the part (w h)^2 / 12, half a period later off by pi (w h)^2 / 12 A; the second
difference is (w h)^2 A."""

CYCLES = 10
"""Cycles that tell the frequency of an oscillation."""

FINER_STEPS = (1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5)
"""Steps that are recommended [s]: whole parts of a millisecond, and so of most sample intervals."""


class Monitor:
    """Called at regular intervals; returns the reason to stop, or None. ``events`` gives what it has noted."""

    def __init__(self, law: VehicleOnTrack, speed: float, work: Work | None = None, step: float = 0.0) -> None:
        """speed [m/s]: how far the vehicle goes between two looks; work: what the integration takes; step [s]: of the
        integration, where lateral forces may ask for a shorter one."""
        self.law, self.work = law, work or Work()
        self.cut_steps, self.cut_looks = 0, 0
        self.interval = min(INTERVAL, STRETCH / speed)
        self.wheels = wheels_of(law)
        self.last_contact = np.full((len(self.wheels), 2), np.nan)
        self.watched = watched(self.wheels)
        """Records WATCH: the geometry of every wheel, and its vertical force between samples."""
        self._wheels = law.workspace.buffer, law.workspace.index[FIRST_WHEEL:]
        elements = law.vehicle.elements
        stops = [(i, e.travel_place, *e.limits) for i, e in enumerate(elements) if e.limits]
        normals = [None if e.slider is None else e.slider.normal for e in elements]
        loose = [(i, -1, 0.0, 0.0) for i, n in enumerate(normals) if n is not None and n.sense is None]
        axles = law.axles if law.driven else law.axles[:0]
        self.marked = [(STOP, row[0]) for row in stops] + [(LOOSE, row[0]) for row in loose]
        self.marked += [(SPINS, i) for i in range(len(axles))]
        """Kinds and places of what a look marks."""
        self.notes = np.zeros((0, 9))
        """Rows (kind, which wheel or element, `WatchedWheel.end_of_profile` or -1, time, distance, last of both, time
        and way without contact)."""
        self.mean_load = 0.5 * law.vehicle.weight / len(law.vehicle.wheelsets)
        self.phase_error = PhaseError(len(self.wheels), step, 0.5 * PEAK_ERROR * self.mean_load)
        self.looked = np.full((2, len(self.wheels)), np.nan)
        """Vertical forces at the last two looks [N]."""
        self.last = np.full(2, np.nan)
        """Time [s] and distance [m] of the last look."""
        self.growing = np.zeros(1, kernel.GROWTH)
        self._growth = self.growing.view(np.recarray)[0]
        self._growth.longest, self._growth.looked = np.inf, -np.inf
        self._bends, self._marks = np.zeros(len(self.wheels)), np.zeros(len(self.marked), np.int64)
        self._looks = (
            MISSED * self.mean_load if law.on_sleepers is None else np.inf, PAUSE, self.watched, self.growing,
            self.looked, self._bends, self.last, self.last_contact, np.array(stops + loose, float).reshape(-1, 4),
            self._marks, law.elements, law.readings, axles, *self._wheels,
        )  # fmt: skip

    @property
    def longest_step(self) -> float:
        """The longest step that resolves what grows and what swings across [s], infinite where nothing does."""
        return min(float(self.growing["longest"][0]), self.phase_error.longest_step)

    def step(self, t: float, sampled: bool) -> None:
        """After every step, at the law's last evaluation; sampled: whether its state is stored."""
        kernel.watch_step(t, self.law.distance, sampled, self.mean_load, self.watched, self.growing, *self._wheels)
        if self.phase_error.step:
            self.phase_error.add(t, self.watched["lateral"].copy())

    def __call__(self, t: float, q: Array, q_t: Array) -> str | None:
        outcome = self.look(t, q, q_t)
        return None if outcome is None else stop_words(outcome, t, self.law.distance)

    def look(self, t: float, q: Array, q_t: Array) -> Derailment | None:
        """What ends the run, if anything; notes what else there is."""
        self.law.at(t, q, q_t, WITHIN)
        distance = self.law.distance
        remarks = kernel.look(t, distance, *self._looks)
        ending = self._look_at_wheels(t, distance) if remarks & kernel.WHEELS else None
        self.last[:] = t, distance
        if remarks & kernel.GROWS:
            self._look_for_growth(t, q, q_t, distance)
        if ending is not None and ending.kind == "derailed":
            ending = self._resolved(ending, distance)
        for kind, i in (self.marked[k] for k in np.flatnonzero(self._marks)) if remarks & kernel.PARTS else ():
            slides = kind == SPINS and self.law.axles[i].requested < 0.0
            self._note(SLIDES if slides else kind, i, t, distance)
        if self.work.cut_steps > self.cut_steps:
            self._note(STEPS, 0, t, distance)
            self._warn_of_cuts(t, distance)
        else:
            self.cut_looks = 0
        self.cut_steps = self.work.cut_steps
        return ending

    def _look_for_growth(self, t: float, q: Array, q_t: Array, distance: float) -> None:
        """Note an oscillation that grows at the wheel that is the most restless, and the step that resolves it."""
        growth = self._growth
        modes = growing_modes(self.law, self.law.bodies, q, q_t, t, PAUSE)
        if not modes.size:
            return
        if not growth.finds:
            growth.wheel = np.nanargmax(self._bends)
            self._note(SWINGS, int(growth.wheel), t, distance)
        self.notes[self.notes[:, 0] == SWINGS, 5:7] = t, distance
        growth.finds, growth.frequency = growth.finds + 1.0, modes[0].imag / (2.0 * np.pi)
        growth.longest = min(growth.longest, 2.0 * np.pi / (STEPS_OF_A_PERIOD * modes.imag.max()))

    def _resolved(self, ending: Derailment, distance: float) -> Derailment:
        """A derailment; no verdict where the steps do not resolve the blows of wheels ahead of it."""
        worst = self.watched[int(np.argmax(self.watched["bend"]))]
        if STRIKE * worst.bend <= self.mean_load or distance - worst.bend_s > LIFT_DISTANCE:
            return ending
        blow = f"blows of wheels (Q {1e-3 * worst.bend_force:.4g} kN) that the time step does not resolve"
        return Derailment("unresolved", f"{ending.message}, after {blow}")

    def _look_at_wheels(self, t: float, distance: float) -> Derailment | None:
        """What ends the run at a wheel; notes lifted wheels and the remarks of contacts."""
        ending: Derailment | None = None
        too_deep, off = 0, self.last_contact[:, 0] < self.last[0]
        for i, (wheel, watch) in enumerate(zip(self.wheels, self.watched, strict=True)):
            ending = ending or self._look_at(i, wheel, t, distance)
            status, substitutes = wheel.status, wheel.model.arrays.substitutes
            too_deep |= status & STATUS_TOO_DEEP
            # also between two looks
            flags, watch.status = (status | int(watch.status)) & ~STATUS_TOO_DEEP, 0
            if substitutes > watch.substitutes:
                watch.substitutes = substitutes
                flags |= STATUS_NOT_CONVERGED
            for bit in bits_of(flags):
                self._note(bit, i, t, distance, wheel.nearest_end() if bit == STATUS_PROFILE_END else -1)
        share = 0.5 * off + 0.5 * (self.last_contact[:, 0] < t)  # in the air at both ends of the time between two looks
        for i in np.flatnonzero(share).tolist():
            if (row := self._same(LIFT, i, -1)) >= 0 and np.isfinite(self.last[0]):
                self.notes[row, 7:] += share[i] * (np.array([t, distance]) - self.last)
        return ending or (overlap(self.wheels) if too_deep else None)

    def _warn_of_cuts(self, t: float, distance: float) -> None:
        """Warn once, while the run lasts, that its steps are cut again and again."""
        self.cut_looks += 1
        if self.cut_looks == MANY:
            since = self.notes[self.notes[:, 0] == STEPS][-1, 3:]
            log.warning(
                "the time step has to be cut again and again since t = %.4g s, %.2f m along the track: the run takes "
                "up to %d times as long as usual. A mass or a stiffness out of proportion does this (wrsim check warns "
                "of some), or contact that comes and goes: run.integrator = \"rk44\" may be faster",
                since[0], since[1], SLOWEST,
            )  # fmt: skip

    def _look_at(self, i: int, wheel: WatchedWheel, t: float, distance: float) -> Derailment | None:
        """How the vehicle has derailed at a wheel, if it has. Notes a lifted wheel."""
        off = wheel.off_the_rail()
        if off is not None:
            kind, wheel_index, end_of_profile = self.notes[:, :3].T
            at_end = self.notes[(kind == STATUS_PROFILE_END) & (wheel_index == i) & (end_of_profile >= 0)]
            if at_end.size and distance - at_end[-1, 6] <= LIFT_DISTANCE and (end := _end(wheel, at_end[-1, 2])):
                return replace(off, message=f"{off.message}; its contact has passed {end_words(*end)}")
            return off
        since = self.last_contact[i]
        if wheel.in_contact or np.isnan(since[0]):
            self.last_contact[i] = t, distance
            return None
        self._note(LIFT, i, t, distance)
        way = distance - since[1]
        if way >= LIFT_DISTANCE and t - since[0] >= LIFT_TIME:
            return Derailment("derailed", f"{wheel.label} has had no contact with its rail for {way:.2f} m")
        return None

    def _note(self, kind: float, index: int, t: float, distance: float, end: int = -1) -> None:
        """Begin an event, or let the last one of its kind and place go on."""
        same = self._same(kind, index, end)
        if same >= 0 and abs(distance - self.notes[same, 6]) <= SAME:
            self.notes[same, 5:7] = t, distance
        else:
            self.notes = np.vstack([self.notes, [kind, index, end, t, distance, t, distance, 0.0, 0.0]])

    def _same(self, kind: float, index: int, end: int) -> int:
        """The last note of this kind and place; -1 where there is none."""
        same = np.flatnonzero((self.notes[:, :3] == (kind, index, end)).all(axis=1))
        return int(same[-1]) if same.size else -1

    def events(self) -> list[Event]:
        """Everything noted, in the order of its begin."""
        events = []
        for kind, index, at_end, t, distance, last_t, last_distance, *off in self.notes.tolist():
            name, part, side = KINDS.get(kind, "contact"), "", ""
            if kind in (SPINS, SLIDES):
                if last_distance - distance <= SLIP_DISTANCE:
                    continue
                part = self.law.vehicle.wheelsets[int(index)].name
            elif kind == SWINGS and self._growth.finds < 2.0:  # the blow of an impact, that has died away
                continue
            elif kind in (STOP, LOOSE):
                part = self.law.vehicle.elements[int(index)].name
            elif kind != STEPS:
                part, side = self.wheels[int(index)].wheelset, self.wheels[int(index)].side
            bit = int(kind) if name == "contact" else 0
            end = _end(self.wheels[int(index)], at_end) if bit == STATUS_PROFILE_END else None
            events.append(Event(name, part, (t, distance), (last_t, last_distance), side, bit, profile=end))
            if bit == STATUS_NOT_CONVERGED:
                watch = self.watched[int(index)]
                events[-1] = replace(events[-1], unsolved=(int(watch.substitutes), int(watch.steps)))
            if kind == LIFT:
                events[-1] = replace(events[-1], lasted=(off[1], off[0]))
            if kind == SWINGS:
                growth = self._growth
                cycle = float(growth.cycles / growth.cycling) if growth.cycles >= CYCLES else 0.0
                swing = float(growth.frequency), cycle
                events[-1] = replace(events[-1], step=float(growth.longest), swing=swing)
        mean_load = self.mean_load
        if self.wheels and self._growth.finds < 2.0:
            worst = int(np.argmax(self.watched["beyond"]))
            wheel, watch = self.wheels[worst], self.watched[worst]
            if watch.beyond > MISSED * mean_load:
                place, missed = (float(watch.time), float(watch.distance)), (float(watch.force), float(watch.beyond))
                events.append(Event("between", wheel.wheelset, place, place, wheel.side, 0, missed))
            worst = int(np.argmax(self.watched["bend"]))
            wheel, watch = self.wheels[worst], self.watched[worst]
            error = float(STRIKE * watch.bend)
            if error > MISSED * mean_load:
                enough = float(watch.bend_step) * (MISSED * mean_load / error) ** 0.5
                place, missed = (float(watch.bend_at), float(watch.bend_s)), (float(watch.bend_force), error)
                enough = next((finer for finer in FINER_STEPS if finer <= enough), FINER_STEPS[-1])
                events.append(Event("strike", wheel.wheelset, place, place, wheel.side, 0, missed, enough))
        return sorted(events, key=lambda event: (event.start, event.part, event.side))

    @property
    def statuses(self) -> NDArray[np.int_]:
        """Messages of the contact of every wheel since the beginning, as one status each."""
        statuses = np.zeros(len(self.wheels), dtype=int)
        for kind, index in self.notes[self.notes[:, 0] > LIFT, :2].astype(int):
            statuses[index] |= kind
        return statuses

    def get_state(self) -> Array:
        """See ``simulation.recorder.HasState``."""
        arrays = self.watched.view(float), self.last_contact.ravel(), self.looked.ravel(), self.last
        more = self.growing.view(float), *(array.ravel() for array in self.phase_error.arrays)
        return np.concatenate([[self.cut_steps], *arrays, *more, self.notes.ravel()])

    def set_state(self, memory: Array) -> None:
        """Put back what ``get_state`` gave."""
        self.cut_steps, place, watched = int(memory[0]), 1, self.watched.view(float)
        more = self.growing.view(float), *self.phase_error.arrays
        for array in (watched, self.last_contact, self.looked, self.last, *more):
            array[...] = memory[place : place + array.size].reshape(array.shape)
            place += array.size
        self.notes = memory[place:].reshape(-1, 9).copy()
        places = np.where(np.isin(self.notes[:, 0], (STOP, LOOSE)), len(self.law.vehicle.elements), len(self.wheels))
        if not (np.isfinite(self.notes).all() and ((self.notes[:, 1] >= 0) & (self.notes[:, 1] < places)).all()):
            raise ValueError("events of a wheel or an element that is not there")


def _end(wheel: WatchedWheel, index: float) -> tuple[str, str, float] | None:
    """The end of a profile that a note is about; None where it has none."""
    return wheel.end_of_profile(int(index)) if index >= 0 else None
