"""Time integration with a fixed step: samples, checkpoints, and an end in good order whatever happens.

A run is a sequence of segments of ``SEGMENT`` steps with checkpoints between them, each of which begins from the state
and the states of law and monitor alone. Which step is accurate, or stable: ``step_size``.
"""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import KW_ONLY, dataclass, field, replace
from math import ceil
from pathlib import Path
from types import FrameType
from typing import Literal, get_args

import numpy as np

from wrsim.contact.workspace import WARM_TOLERANCE
from wrsim.errors import InputError, SimulationError
from wrsim.results.run_file import is_running
from wrsim.simulation import DEFAULT_INTEGRATOR, Integrator
from wrsim.simulation.recorder import Cause, Checkpoint, Ending, RecordedRun, Recorder, get_states, set_states
from wrsim.simulation.system import COORDINATES, Array, BodySystem, NotFinite, Work
from wrsim.vehicle.dynamics.kinematics import first_not_finite
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

Monitor = Callable[[float, Array, Array], str | None]
"""Its ``step(t, sampled)``, if it has one, is called after every step; sampled: whether this state is a sample. Its
``longest_step``, if it has one, is the longest step that it allows from there on [s]."""
Progress = Callable[[float, float], None]

PROGRESS_INTERVAL = 0.1
"""Least time between two calls of the progress function [s]."""

SEGMENT = 200
"""Steps from one checkpoint to the next."""

TOLERANCE = 1e-4
"""Norm of the residual forces at which Newton's method ends, as a part of the weight."""

CONTACT_TOLERANCE = 0.3 * TOLERANCE
"""To which contacts solve their own equations in implicit steps, over the deepest penetration: its power 3/2 is in the
force, so that less than half of what Newton's method leaves is theirs."""

LOOSE = 10.0
"""Factor on this in a step that is not solved otherwise, and in a part of a step, times the number of parts: where the
force of a contact jumps, there may be no balance, and the impulse counts."""

PARTS, EXPLICIT_PARTS = (1, 4, 16), 128
"""Parts of a step that Newton's method does not solve, one number after the other, and at last those for RK44."""


@dataclass(frozen=True)
class Motion:
    """Result of an integration.

    times (n,) [s]; q, q_t (n, 6 per body): sampled coordinates and rates, ``COORDINATES`` of each body; step [s].
    status: ``"completed"`` or ``"stopped"``, by ``cause``, in words ``reason``. All samples are finite; the last one is
    the state at the end or at the stop. work: counts of evaluations.
    """

    times: Array
    q: Array
    q_t: Array
    step: float
    status: Literal["completed", "stopped"]
    cause: Cause = ""
    reason: str = ""
    integrator: Integrator = DEFAULT_INTEGRATOR
    work: Work = field(default_factory=Work)

    @property
    def end(self) -> float:
        return float(self.times[-1])


def _name(index: int, system: BodySystem) -> str:
    """Words for an index of ``first_not_finite``."""
    place, forces = index % system.size, system.forces
    if place >= system.size - forces.rails:
        return "the displacement of a rail under its wheel"
    if place >= system.size - forces.positions:
        return "the pitch of an axle box, the twist of an axle, or an elastic mode"
    if place >= 6 * len(system.bodies):
        return f"unknown {place - 6 * len(system.bodies)} of dampers in series and of friction"
    body, coordinate = divmod(place, 6)
    name = COORDINATES[coordinate] if index < system.size else f"the rate of {COORDINATES[coordinate]}"
    return name if len(system.bodies) == 1 else f"{name} of body {body}"


@contextmanager
def _interruptible() -> Iterator[threading.Event]:
    """An event that the first Ctrl-C sets; the second interrupts. Signals reach the main thread alone."""
    requested = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield requested
        return

    def on_signal(number: int, stack: FrameType | None) -> None:
        if requested.is_set():
            raise KeyboardInterrupt
        requested.set()

    before = signal.signal(signal.SIGINT, on_signal)
    try:
        yield requested
    finally:
        signal.signal(signal.SIGINT, before)


def _motion(rows: Array, step: float, ending: Ending, integrator: Integrator, work: Work) -> Motion:
    q, q_t = np.split(rows[:, 1:], 2, axis=1)
    status: Literal["completed", "stopped"] = "stopped" if ending.cause else "completed"
    return Motion(rows[:, 0].copy(), q, q_t, step, status, ending.cause, ending.reason, integrator, replace(work))


def recorded_motion(path: str | Path, monitor: object = None) -> Motion:
    """The motion in a run file; of a run whose process died, up to its last flush. monitor: its state is restored.

    The file's header must hold ``step_s``, ``start_s`` and ``integrator``. Raises ``InputError`` when there is no whole
    sample.
    """
    recording = RecordedRun.read(path)
    rows, ending, last = recording.rows, recording.ending, recording.last
    step, start, integrator = (recording.header[name] for name in ("step_s", "start_s", "integrator"))
    if integrator not in get_args(Integrator):
        allowed = " or ".join(get_args(Integrator))
        raise InputError(f"{path}: integrator in its header is {integrator!r:.40}; must be {allowed}")
    work = Work()
    if last is not None:
        set_states((work, None, monitor), last.states, str(path))
    if ending is None:
        if last is not None and (len(rows) == 0 or rows[-1, 0] < start + last.step * step):
            rows = np.vstack([rows, np.concatenate([[start + last.step * step], last.q, last.q_t])])
        if len(rows) == 0:
            raise InputError(f"{path}: the run was cut off before its first sample; run the scenario again")
        how = "is still running" if is_running(path) else "was cut off when its process ended"
        ending = Ending("cut-off", f"the run {how}; results up to t = {rows[-1, 0]:.6g} s")
    return _motion(rows, step, ending, integrator, work)


@dataclass
class Integration:
    """Integrates a system over ``duration`` seconds from the time ``start``: ``run``.

    step [s]; sample_interval [s]: rounded to whole steps, default every step; the start and the end are always among
    the samples. record_interval [s]: the same of states in between that are recorded as well, default none. weight [N]:
    of all bodies and their loads, the scale of the tolerance; by default that of the bodies. segment: steps between two
    checkpoints. monitor(t, q, q_t): called every ``monitor_interval`` [s], by default at each sample, ends the run by
    returning the reason. progress(fraction, seconds_left): called some ten times a second, and with (1, 0) at the end
    of a completed run. recorder: takes the samples, by default in memory; from a checkpoint that it holds the run
    continues, whatever its start; a whole run that it holds is returned as it is.

    The run ends early, with the samples so far, when a number is not finite, when the monitor returns a reason, when
    the force law raises ``SimulationError``, and at Ctrl-C (the first ends the step, the second ends at once). Any
    other exception of the force law, the monitor or the progress function is passed on.
    """

    system: BodySystem
    _: KW_ONLY
    duration: float
    step: float
    integrator: Integrator = DEFAULT_INTEGRATOR
    sample_interval: float | None = None
    record_interval: float | None = None
    start: float = 0.0
    weight: float | None = None
    segment: int = SEGMENT
    monitor: Monitor | None = None
    monitor_interval: float | None = None
    progress: Progress | None = None
    recorder: Recorder | None = None

    def __post_init__(self) -> None:
        system, step = self.system, self.step
        if not (step > 0.0 and self.duration > 0.0 and np.isfinite(self.duration)):
            raise ValueError(f"step and duration must be positive, got {step!r} and {self.duration!r}")
        self._steps = max(1, int(np.ceil(self.duration / step - 1e-9)))
        self._every = 1 if self.sample_interval is None else max(1, round(self.sample_interval / step))
        recorded = self.record_interval
        self._record_every = self._every if recorded is None else max(1, round(recorded / step))
        interval = self.monitor_interval
        self._monitor_every = self._every if interval is None else max(1, round(interval / step))
        weight = STANDARD_GRAVITY * sum(body.mass for body in system.bodies) if self.weight is None else self.weight
        self._tolerance = TOLERANCE * weight
        self._of_contacts = WARM_TOLERANCE if self.integrator == "rk44" else CONTACT_TOLERANCE
        self._recorder = Recorder(system.size) if self.recorder is None else self.recorder
        self._with_state = (system.work, system.forces, self.monitor)
        self._watch = getattr(self.monitor, "step", None)
        self._parts = 1
        """Parts that every step is taken in, so that none is longer than the monitor allows."""
        self._ending = Ending("", "")

    def run(self, q: Array, q_t: Array) -> Motion:
        """The motion from the state (q, q_t), each (6 per body, then the unknowns of dampers)."""
        system, recorder = self.system, self._recorder
        q, q_t = np.array(q, dtype=float), np.array(q_t, dtype=float)
        if q.shape != (system.size,) or q_t.shape != (system.size,):
            raise ValueError(f"q and q_t need shape ({system.size},), got {q.shape} and {q_t.shape}")
        bad = first_not_finite(q, q_t)
        if bad >= 0:
            raise SimulationError(f"the start state is not finite: {_name(bad, system)}")
        system.work.set_state(Work().get_state())
        if recorder.ending is not None:
            if recorder.last is not None:
                with system.forces.following(self._of_contacts):
                    set_states(self._with_state, recorder.last.states, recorder.name)
            return _motion(recorder.rows(), self.step, recorder.ending, self.integrator, system.work)
        with _interruptible() as self._interrupt, system.forces.following(self._of_contacts):
            begin = recorder.checkpoint
            if begin is None:
                begin = Checkpoint(0, q, q_t, get_states(self._with_state))
                recorder.sample(self.start, q, q_t)
                recorder.flush(begin)
            self._integrate(begin)
        return _motion(recorder.rows(), self.step, self._ending, self.integrator, system.work)

    @property
    def sample_count(self) -> int:
        """Samples of the whole run, with the start and the end."""
        return 1 + -(-self._steps // self._every)

    def _integrate(self, begin: Checkpoint) -> None:
        """Run from a checkpoint to the end, under warm starts of the law."""
        self._first, self._last = begin.step, begin.step
        self._q, self._q_t = begin.q.copy(), begin.q_t.copy()
        """The last good state."""
        self._began = self._reported = time.perf_counter()
        whole = True
        try:
            set_states(self._with_state, begin.states, self._recorder.name)
            while self._last < self._steps:
                self._run_segment(min(self._steps, (self._last // self.segment + 1) * self.segment))
                if self._ending.cause:
                    break
                checkpoint = self._checkpoint()
                set_states(self._with_state, checkpoint.states)
                if self._recorder.due():
                    self._recorder.flush(checkpoint)
        except KeyboardInterrupt:
            whole = False
            self._stop("interrupt", f"interrupted by the user at t = {self._time(self._last):.6g} s")
        except NotFinite as error:
            coordinate = _name(error.index, self.system)
            self._stop("not-finite", f"the force along {coordinate} is not a number at t = {error.time:.6g} s")
        except SimulationError as error:
            self._stop("forces", str(error))
        if self.progress is not None and not self._ending.cause:
            self.progress(1.0, 0.0)
        if whole:  # else Ctrl-C has interrupted a step: the law has the state of another time
            self._recorder.flush(self._checkpoint(), goes_on=False)
        if self._last % self._record_every and self._last != self._steps:
            self._recorder.sample(self._time(self._last), self._q, self._q_t)
        self._recorder.end(self._ending)

    def _time(self, k: int) -> float:
        return self.start + k * self.step

    def _checkpoint(self) -> Checkpoint:
        """The last good state with the present states of law and monitor."""
        return Checkpoint(self._last, self._q.copy(), self._q_t.copy(), get_states(self._with_state))

    def _stop(self, cause: Cause, reason: str) -> bool:
        self._ending = Ending(cause, reason)
        return False

    def _after_step(self, t: float) -> bool:
        """Check the numbers, sample, call the monitor, report progress; see ``BodySystem.solve``."""
        q, q_t = self.system.q, self.system.q_t
        k = int((t - self.start) / self.step + 1e-6)
        if k <= self._last:  # Exudyn calls at the start as well
            if self._watch is not None and t > self._time(k) + 1e-6 * self.step:  # a part of a step
                self._watch(t, False)
            return True
        bad = first_not_finite(q, q_t)
        if bad >= 0:
            return self._stop("not-finite", f"{_name(bad, self.system)} is not a number at t = {self._time(k):.6g} s")
        self._last = k
        self.system.work.refined_steps += self._parts > 1
        self._q[:], self._q_t[:] = q, q_t
        sampled = k % self._every == 0 or k == self._steps
        if self._watch is not None:
            self._watch(self._time(k), sampled)
        if sampled or k % self._record_every == 0:
            self._recorder.sample(self._time(k), q, q_t)
        if self.monitor is not None and (k % self._monitor_every == 0 or k == self._steps):
            reason = self.monitor(self._time(k), q, q_t)
            if reason:
                return self._stop("monitor", reason)
            parts = self._parts_needed()
            if parts > self._parts or parts == 1 < self._parts:
                return False  # the segment goes on in shorter steps, or in whole ones
        if self.progress is not None:
            now = time.perf_counter()
            if now - self._reported >= PROGRESS_INTERVAL:
                self._reported = now
                self.progress(k / self._steps, (now - self._began) * (self._steps - k) / (k - self._first))
        if self._interrupt.is_set():
            return self._stop("interrupt", f"interrupted by the user at t = {self._time(k):.6g} s")
        return True

    def _run_segment(self, end: int) -> None:
        """From the last good state until ``end`` steps are done, or the run has to stop."""
        while self._last < end and not self._ending.cause:
            k, self._parts = self._last, self._parts_needed()
            try:
                self.system.solve(
                    self._q, self._q_t, self.start, self.step / self._parts, (end - k) * self._parts, self._after_step,
                    first=k * self._parts,
                    integrator=self.integrator, tolerance=self._tolerance, max_residual=LOOSE * self._tolerance,
                )  # fmt: skip
            except SimulationError:
                if self.integrator == "rk44":
                    raise
                self._step_in_parts()
            if self._last == k and not self._ending.cause:
                raise SimulationError(f"Exudyn ended the run at t = {self._time(k):.6g} s without a reason")

    def _parts_needed(self) -> int:
        return max(1, ceil(self.step / getattr(self.monitor, "longest_step", np.inf) - 1e-9))

    def _step_in_parts(self) -> None:
        """Take one implicit step that has failed in parts, at last by RK44 where the law allows it.

        Newton's method fails where a contact begins or ends within the step and the force jumps, or where an iteration
        leads to a state without forces. Explicit steps take any jump.
        """
        system, state = self.system, self.system.forces.get_state()
        for parts in PARTS:
            try:
                system.solve(
                    self._q, self._q_t, self._time(self._last), self.step / parts, parts, lambda t: True,
                    integrator="generalised-alpha", tolerance=LOOSE * parts * self._tolerance,
                )  # fmt: skip
            except SimulationError:
                system.forces.set_state(state)
                if parts == PARTS[-1] and not system.forces.explicit:
                    raise
            else:
                system.work.cut_steps += parts > 1
                break
        else:
            start, step = self._time(self._last), self.step / EXPLICIT_PARTS
            system.solve(self._q, self._q_t, start, step, EXPLICIT_PARTS, lambda t: True)
            system.work.cut_steps += 1
            system.work.explicit_steps += 1
        self._after_step(self._time(self._last + 1))
