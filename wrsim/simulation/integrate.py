"""Time integration with a fixed step, samples, and an end in good order whatever happens.

A run goes in segments of ``SEGMENT`` steps. Each begins with what state and memory alone determine: the implicit method
anew (``System.solve``), the law with what its memory keeps. Checkpoints lie between them. Which step is accurate, or
stable: ``wrsim.simulation.step``.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import FrameType
from typing import Literal, Protocol, get_args, runtime_checkable

import numpy as np

from wrsim.core.body.kinematics import first_not_finite
from wrsim.errors import InputError, SimulationError
from wrsim.results.run_file import is_running
from wrsim.simulation.force_law import following, positions_of, rails_of
from wrsim.simulation.implicit import DEFAULT_INTEGRATOR, Integrator
from wrsim.simulation.recorder import Cause, Checkpoint, Ending, Recorder, Recording, memory_of, recall
from wrsim.simulation.system import COORDINATES, Array, NotFinite, System, Work
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

Monitor = Callable[[float, Array, Array], str | None]
Progress = Callable[[float, float], None]


@runtime_checkable
class Watches(Protocol):
    """A monitor that is told of every step, beside the looks that it is asked for."""

    def step(self, t: float, sampled: bool) -> None:
        """After a step at time t [s]; sampled: whether its state is kept."""


PROGRESS_INTERVAL = 0.1
"""Least time between two calls of the progress function [s]."""

SEGMENT = 100
"""Steps from one checkpoint to the next."""

TOLERANCE = 1e-4
"""Norm of the forces left over with which Newton's method ends, as a part of the weight."""

LOOSE = 10.0
"""By how much more it may leave in a step that it does not solve otherwise, and in a part of the step by so many times
more as there are parts: where the force of a contact jumps, there may be no balance, and what counts is the impulse."""

PARTS, EXPLICIT_PARTS = (1, 4, 16), 128
"""Into how many parts a step is cut that Newton's method does not solve, and in the end one for RK44."""


@dataclass(frozen=True)
class Motion:
    """What an integration computed.

    times (n,) [s]; q, q_t (n, 6 per body): sampled coordinates and rates, ``COORDINATES`` of each body; step [s].
    status: ``"completed"`` or ``"stopped"``; a stopped run says what stopped it (``cause``) and why in words
    (``reason``). All samples are finite. The last one is the state at the end or at the stop. work: what it took.
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
        """Time reached [s]."""
        return float(self.times[-1])


def _name(index: int, system: System) -> str:
    """Words for an index of ``first_not_finite``."""
    place = index % system.size
    if place >= system.size - rails_of(system.forces):
        return "the displacement of a rail under its wheel"
    if place >= system.size - positions_of(system.forces):
        return "the pitch of an axle box, or the twist of an axle"
    if place >= 6 * len(system.bodies):
        return f"unknown {place - 6 * len(system.bodies)} of dampers in series and of friction"
    body, coordinate = divmod(place, 6)
    what = COORDINATES[coordinate] if index < system.size else f"the rate of {COORDINATES[coordinate]}"
    return what if len(system.bodies) == 1 else f"{what} of body {body}"


class _Interrupt:
    """Counts Ctrl-C: the first ends the run after the step, the second at once."""

    asked = False

    def __call__(self, number: int, stack: FrameType | None) -> None:
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True


@contextmanager
def _interruptible() -> Iterator[_Interrupt]:
    """Install the Ctrl-C counter; only the main thread may (elsewhere no signal arrives)."""
    interrupt = _Interrupt()
    if threading.current_thread() is not threading.main_thread():
        yield interrupt
        return
    before = signal.signal(signal.SIGINT, interrupt)
    try:
        yield interrupt
    finally:
        signal.signal(signal.SIGINT, before)


@dataclass
class _AfterStep:
    """Called after every step: looks at the numbers, samples, asks the monitor, reports progress.

    begin: where the run begins or goes on; every, monitor_every: steps between two samples, and two looks.
    """

    system: System
    start: float
    step: float
    steps: int
    every: int
    monitor: Monitor | None
    monitor_every: int
    progress: Progress | None
    interrupt: _Interrupt
    recorder: Recorder
    begin: Checkpoint
    cause: Cause = ""
    reason: str = ""
    broken_off: bool = False

    def __post_init__(self) -> None:
        self.last_step, self.last_q, self.last_q_t = self.begin.step, self.begin.q.copy(), self.begin.q_t.copy()
        self.began = self.reported = time.perf_counter()
        self.watch = self.monitor if isinstance(self.monitor, Watches) else None

    @property
    def things(self) -> tuple[object, ...]:
        """What remembers something from step to step."""
        return self.system.work, self.system.forces, self.monitor

    def time_of(self, k: int) -> float:
        """Time after k steps [s]."""
        return self.start + k * self.step

    def checkpoint(self) -> Checkpoint:
        """The last good state with what is remembered now."""
        return Checkpoint(self.last_step, self.last_q.copy(), self.last_q_t.copy(), memory_of(self.things))

    def stop(self, cause: Cause, reason: str) -> bool:
        """Note why the run ends."""
        self.cause, self.reason = cause, reason
        return False

    def after_step(self, t: float) -> bool:
        """See ``System.solve``."""
        q, q_t = self.system.q, self.system.q_t
        k = round((t - self.start) / self.step)
        if k <= self.last_step:  # Exudyn calls at the start as well
            return True
        bad = first_not_finite(q, q_t)
        if bad >= 0:
            return self.stop("not-finite", f"{_name(bad, self.system)} is not a number at t = {self.time_of(k):.6g} s")
        self.last_step = k
        self.last_q[:], self.last_q_t[:] = q, q_t
        sampled = k % self.every == 0 or k == self.steps
        if self.watch is not None:
            self.watch.step(self.time_of(k), sampled)
        if sampled:
            self.recorder.sample(self.time_of(k), q, q_t)
        if self.monitor is not None and (k % self.monitor_every == 0 or k == self.steps):
            reason = self.monitor(self.time_of(k), q, q_t)
            if reason:
                return self.stop("monitor", reason)
        if self.progress is not None:
            now = time.perf_counter()
            if now - self.reported >= PROGRESS_INTERVAL:
                self.reported = now
                self.progress(k / self.steps, (now - self.began) * (self.steps - k) / (k - self.begin.step))
        if self.interrupt.asked:
            return self.stop("interrupt", f"interrupted by the user at t = {self.time_of(k):.6g} s")
        return True

    def end(self) -> None:
        """Put the last good state among the samples and say how the run ended.

        The file keeps what the monitor remembers of the whole run. Not so when Ctrl-C has broken into a step, for then
        the law remembers a state that is not the last one.
        """
        if not self.broken_off:
            self.recorder.flush(self.checkpoint(), goes_on=False)
        if self.last_step % self.every and self.last_step != self.steps:
            self.recorder.sample(self.time_of(self.last_step), self.last_q, self.last_q_t)
        self.recorder.end(Ending(self.cause, self.reason))


def _motion(rows: Array, step: float, ending: Ending, integrator: Integrator, work: Work) -> Motion:
    """A motion from the rows of a recorder."""
    q, q_t = np.split(rows[:, 1:], 2, axis=1)
    status: Literal["completed", "stopped"] = "stopped" if ending.cause else "completed"
    return Motion(rows[:, 0].copy(), q, q_t, step, status, ending.cause, ending.reason, integrator, replace(work))


def recorded_motion(path: str | Path, monitor: object = None) -> Motion:
    """The motion that a run file holds; of a run whose process died, up to its last flush.

    monitor: is given back what it remembered then.
    The file's header must hold ``step_s``, ``start_s`` and ``integrator``. Raises ``InputError`` when there is no whole
    sample.
    """
    recording = Recording.read(path)
    rows, ending, known = recording.rows, recording.ending, recording.last
    step, start, integrator = (recording.header[name] for name in ("step_s", "start_s", "integrator"))
    if integrator not in get_args(Integrator):
        allowed = " or ".join(get_args(Integrator))
        raise InputError(f"{path}: integrator in its header is {integrator!r:.40}; must be {allowed}")
    work = Work()
    if known is not None:
        recall((work, None, monitor), known.memory, str(path))
    if ending is None:
        if known is not None and (len(rows) == 0 or rows[-1, 0] < start + known.step * step):
            rows = np.vstack([rows, np.concatenate([[start + known.step * step], known.q, known.q_t])])
        if len(rows) == 0:
            raise InputError(f"{path}: the run was cut off before its first sample; run the scenario again")
        what = "is still running; this is" if is_running(path) else "was cut off, its process ended before it did;"
        ending = Ending("cut-off", f"the run {what} known up to t = {rows[-1, 0]:.6g} s")
    return _motion(rows, step, ending, integrator, work)


def integrate(
    system: System,
    q: Array,
    q_t: Array,
    *,
    duration: float,
    step: float,
    integrator: Integrator = DEFAULT_INTEGRATOR,
    sample_interval: float | None = None,
    start: float = 0.0,
    weight: float | None = None,
    segment: int = SEGMENT,
    monitor: Monitor | None = None,
    monitor_interval: float | None = None,
    progress: Progress | None = None,
    recorder: Recorder | None = None,
) -> Motion:
    """Integrate a system from the state (q, q_t) at time ``start`` for ``duration`` seconds.

    q, q_t: (6 per body,); step [s]; sample_interval [s]: rounded to whole steps, default every step; the
    start and the end are always among the samples. weight [N]: of all that is carried, the measure for what Newton's
    method may leave over; by default that of the bodies. segment: steps between two checkpoints. monitor(t, q, q_t):
    asked every ``monitor_interval`` [s], by default at each sample, ends the run by returning the reason.
    progress(fraction, seconds_left): called some ten times a second, and with (1, 0) at the end of a completed run.
    recorder: takes the samples, by default in memory; one that holds a checkpoint makes the run go on from there,
    whatever (q, q_t), and one that holds the whole run only plays it back.

    The run ends early, with the samples so far, when a number is not finite, when the monitor says so, when
    the force law raises ``SimulationError``, and at Ctrl-C (the first ends the step, the second ends at once). Any
    other exception of the force law, the monitor or the progress function comes through.
    """
    q, q_t = np.array(q, dtype=float), np.array(q_t, dtype=float)
    if q.shape != (system.size,) or q_t.shape != (system.size,):
        raise ValueError(f"q and q_t need shape ({system.size},), got {q.shape} and {q_t.shape}")
    bad = first_not_finite(q, q_t)
    if bad >= 0:
        raise SimulationError(f"the start state is not finite: {_name(bad, system)}")
    if not (step > 0.0 and duration > 0.0 and np.isfinite(duration)):
        raise ValueError(f"step and duration must be positive, got {step!r} and {duration!r}")
    steps = max(1, int(np.ceil(duration / step - 1e-9)))
    every = 1 if sample_interval is None else max(1, round(sample_interval / step))
    monitor_every = every if monitor_interval is None else max(1, round(monitor_interval / step))
    if weight is None:
        weight = STANDARD_GRAVITY * sum(body.mass for body in system.bodies)
    recorder = Recorder(system.size) if recorder is None else recorder
    system.work.clear()
    things = (system.work, system.forces, monitor)
    if recorder.ending is not None:
        if recorder.last is not None:
            with following(system.forces):
                recall(things, recorder.last.memory, recorder.name)
        return _motion(recorder.rows(), step, recorder.ending, integrator, system.work)
    begin = recorder.checkpoint
    with _interruptible() as interrupt, following(system.forces):
        if begin is None:
            begin = Checkpoint(0, q, q_t, memory_of(things))
            recorder.sample(start, q, q_t)
            recorder.flush(begin)
        after = _AfterStep(
            system, start, step, steps, every, monitor, monitor_every, progress, interrupt, recorder, begin
        )
        try:
            recall(things, begin.memory, recorder.name)
            while after.last_step < steps:
                end = min(steps, (after.last_step // segment + 1) * segment)
                _run_segment(after, end, integrator, TOLERANCE * weight)
                if after.cause:
                    break
                checkpoint = after.checkpoint()
                recall(things, checkpoint.memory)
                if recorder.due():
                    recorder.flush(checkpoint)
        except KeyboardInterrupt:
            at = after.time_of(after.last_step)
            after.broken_off = True
            after.stop("interrupt", f"interrupted by the user at t = {at:.6g} s")
        except NotFinite as error:
            what = _name(error.index, system)
            after.stop("not-finite", f"the force along {what} is not a number at t = {error.time:.6g} s")
        except SimulationError as error:
            after.stop("forces", str(error))
        if progress is not None and not after.cause:
            progress(1.0, 0.0)
        after.end()  # here, where the law still keeps what it remembers
    return _motion(recorder.rows(), step, Ending(after.cause, after.reason), integrator, system.work)


def _run_segment(after: _AfterStep, end: int, integrator: Integrator, tolerance: float) -> None:
    """Go on from the last good state until ``end`` steps are done, or the run has to stop."""
    while after.last_step < end and not after.cause:
        k = after.last_step
        try:
            after.system.solve(
                after.last_q, after.last_q_t, after.start, after.step, end - k, after.after_step,
                first=k, integrator=integrator, tolerance=tolerance, loosest=LOOSE * tolerance,
            )  # fmt: skip
        except SimulationError:
            if integrator == "rk44":
                raise
            _step_in_parts(after, tolerance)
        if after.last_step == k and not after.cause:
            raise SimulationError(f"Exudyn ended the run at t = {after.time_of(k):.6g} s without a reason")


def _step_in_parts(after: _AfterStep, tolerance: float) -> None:
    """One implicit step that has failed, cut into parts, in the end by RK44; raises what the law raises there.

    Newton's method goes astray where a contact begins or ends within the step and the force jumps; and on its way it
    may try states in which the law has no answer. Explicit steps take any jump.
    """
    system, t = after.system, after.time_of(after.last_step)
    memory = memory_of((system.forces,))
    for parts in (*PARTS, EXPLICIT_PARTS):
        explicit = parts == EXPLICIT_PARTS
        try:
            system.solve(
                after.last_q, after.last_q_t, t, after.step / parts, parts, lambda t: True,
                integrator="rk44" if explicit else "generalised-alpha", tolerance=LOOSE * parts * tolerance,
            )  # fmt: skip
        except SimulationError:
            if explicit:
                raise
            recall((system.forces,), memory)
        else:
            system.work.cut_steps += parts > 1
            system.work.explicit_steps += explicit
            after.after_step(after.time_of(after.last_step + 1))
            return
