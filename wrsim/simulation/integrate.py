"""Time integration with a fixed step, samples, and an end in good order whatever happens.

Which step is stable: ``wrsim.simulation.step``.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Literal

import numpy as np

from wrsim.core.wheelset import first_not_finite
from wrsim.errors import SimulationError
from wrsim.simulation.system import COORDINATES, Array, System

Cause = Literal["", "monitor", "interrupt", "not-finite", "forces"]
Monitor = Callable[[float, Array, Array], str | None]
Progress = Callable[[float, float], None]

PROGRESS_INTERVAL = 0.1
"""Least time between two calls of the progress function [s]."""


@dataclass(frozen=True)
class Motion:
    """What an integration computed.

    times (n,) [s]; q, q_t (n, 6 per body): sampled coordinates and rates, ``COORDINATES`` of each body; step [s].
    status: ``"completed"`` or ``"stopped"``; a stopped run says what stopped it (``cause``) and why in words
    (``reason``). All samples are finite. The last one is the state at the end or at the stop.
    """

    times: Array
    q: Array
    q_t: Array
    step: float
    status: Literal["completed", "stopped"]
    cause: Cause = ""
    reason: str = ""

    @property
    def end(self) -> float:
        """Time reached [s]."""
        return float(self.times[-1])


def _name(index: int, size: int) -> str:
    """Words for an index of ``first_not_finite``."""
    body, coordinate = divmod(index % size, 6)
    what = COORDINATES[coordinate] if index < size else f"the rate of {COORDINATES[coordinate]}"
    return what if size == 6 else f"{what} of body {body}"


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


class _Recorder:
    """Called after every step: looks at the numbers, samples, asks the monitor, reports progress."""

    def __init__(
        self,
        system: System,
        start: float,
        step: float,
        steps: int,
        every: int,
        monitor: Monitor | None,
        monitor_every: int,
        progress: Progress | None,
        interrupt: _Interrupt,
    ) -> None:
        self.system = system
        self.start = start
        self.step = step
        self.steps = steps
        self.every = every
        self.monitor = monitor
        self.monitor_every = monitor_every
        self.progress = progress
        self.interrupt = interrupt
        rows = steps // every + 2
        self.times = np.zeros(rows)
        self.q = np.zeros((rows, system.size))
        self.q_t = np.zeros((rows, system.size))
        self.count = 0
        self.last_step = 0
        self.last_q = np.array(system.q)
        self.last_q_t = np.array(system.q_t)
        self.cause: Cause = ""
        self.reason = ""
        self.began = self.reported = time.perf_counter()

    def time_of(self, k: int) -> float:
        """Time after k steps [s]."""
        return self.start + k * self.step

    def sample(self, k: int, q: Array, q_t: Array) -> None:
        """Store the state after step k."""
        self.times[self.count] = self.time_of(k)
        self.q[self.count] = q
        self.q_t[self.count] = q_t
        self.count += 1

    def stop(self, cause: Cause, reason: str) -> bool:
        """Note why the run ends."""
        self.cause = cause
        self.reason = reason
        return False

    def after_step(self, t: float) -> bool:
        """See ``System.solve``."""
        q = self.system.q
        q_t = self.system.q_t
        k = round((t - self.start) / self.step)
        if k <= self.last_step:  # Exudyn calls at the start as well
            return True
        bad = first_not_finite(q, q_t)
        if bad >= 0:
            return self.stop(
                "not-finite",
                f"{_name(bad, self.system.size)} is not a number at t = {self.time_of(k):.6g} s",
            )
        self.last_step = k
        self.last_q[:] = q
        self.last_q_t[:] = q_t
        if k % self.every == 0 or k == self.steps:
            self.sample(k, q, q_t)
        if self.monitor is not None and (k % self.monitor_every == 0 or k == self.steps):
            reason = self.monitor(self.time_of(k), q, q_t)
            if reason:
                return self.stop("monitor", reason)
        if self.progress is not None:
            now = time.perf_counter()
            if now - self.reported >= PROGRESS_INTERVAL:
                self.reported = now
                self.progress(k / self.steps, (now - self.began) * (self.steps - k) / k)
        if self.interrupt.asked:
            return self.stop("interrupt", f"interrupted by the user at t = {self.time_of(k):.6g} s")
        return True

    def motion(self) -> Motion:
        """The samples so far, with the last good state at the end."""
        last = self.time_of(self.last_step)
        if self.times[self.count - 1] < last:
            self.sample(self.last_step, self.last_q, self.last_q_t)
        n = self.count
        return Motion(
            times=self.times[:n].copy(),
            q=self.q[:n].copy(),
            q_t=self.q_t[:n].copy(),
            step=self.step,
            status="stopped" if self.cause else "completed",
            cause=self.cause,
            reason=self.reason,
        )


def _blame(system: System, recorder: _Recorder) -> str:
    """Take the step that broke once more and say which force broke first; an empty string if none did.

    In the state the fault has spread to every coordinate through the mass matrix.
    """
    law = system.forces
    found: list[str] = []

    def watch(t: float, q: Array, q_t: Array, out: Array) -> None:
        law(t, q, q_t, out)
        bad = first_not_finite(out, out)
        if bad >= 0 and not found:
            found.append(f"the force along {_name(bad, system.size)} is not a number at t = {t:.6g} s")

    system.forces = watch
    try:
        at = recorder.time_of(recorder.last_step)
        system.solve(recorder.last_q, recorder.last_q_t, at, recorder.step, 1, lambda t: True)
    except SimulationError:
        pass
    finally:
        system.forces = law
    return found[0] if found else ""


def integrate(
    system: System,
    q: Array,
    q_t: Array,
    *,
    duration: float,
    step: float,
    sample_interval: float | None = None,
    start: float = 0.0,
    monitor: Monitor | None = None,
    monitor_interval: float | None = None,
    progress: Progress | None = None,
) -> Motion:
    """Integrate a system from the state (q, q_t) at time ``start`` for ``duration`` seconds.

    q, q_t: (6 per body,); step [s]; sample_interval [s]: rounded to whole steps, default every step; the
    start and the end are always among the samples. monitor(t, q, q_t): asked every ``monitor_interval`` [s],
    by default at each sample, ends the run by returning the reason. progress(fraction, seconds_left): called
    some ten times a second, and with (1, 0) at the end of a completed run.

    The run ends early, with the samples so far, when a number is not finite, when the monitor says so, when
    the force law raises ``SimulationError``, and at Ctrl-C (the first ends the step, the second ends at
    once). Any other exception of the force law, the monitor or the progress function comes through.
    """
    q = np.array(q, dtype=float)
    q_t = np.array(q_t, dtype=float)
    if q.shape != (system.size,) or q_t.shape != (system.size,):
        raise ValueError(f"q and q_t need shape ({system.size},), got {q.shape} and {q_t.shape}")
    bad = first_not_finite(q, q_t)
    if bad >= 0:
        raise SimulationError(f"the start state is not finite: {_name(bad, system.size)}")
    if not (step > 0.0 and duration > 0.0 and np.isfinite(duration)):
        raise ValueError(f"step and duration must be positive, got {step!r} and {duration!r}")
    steps = max(1, int(np.ceil(duration / step - 1e-9)))
    every = 1 if sample_interval is None else max(1, round(sample_interval / step))
    monitor_every = every if monitor_interval is None else max(1, round(monitor_interval / step))
    with _interruptible() as interrupt:
        recorder = _Recorder(system, start, step, steps, every, monitor, monitor_every, progress, interrupt)
        recorder.last_q[:] = q
        recorder.last_q_t[:] = q_t
        recorder.sample(0, q, q_t)
        try:
            system.solve(q, q_t, start, step, steps, recorder.after_step)
        except KeyboardInterrupt:
            at = recorder.time_of(recorder.last_step)
            recorder.stop("interrupt", f"interrupted by the user at t = {at:.6g} s")
        except SimulationError as error:
            recorder.stop("forces", str(error))
    if recorder.cause == "not-finite":
        recorder.reason = _blame(system, recorder) or recorder.reason
    if not recorder.cause and recorder.last_step < steps:
        at = recorder.time_of(recorder.last_step)
        raise SimulationError(
            f"Exudyn ended the run at t = {at:.6g} s of {recorder.time_of(steps):.6g} s without a reason"
        )
    if progress is not None and not recorder.cause:
        progress(1.0, 0.0)
    return recorder.motion()
