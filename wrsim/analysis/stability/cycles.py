"""Limit cycles of a vehicle on straight track, and the nonlinear critical speed, by integration at held speeds.

From above: wheelsets shifted sideways at a high speed set off a limit cycle; the speed then falls in steps, each from
the last state of the one before, until the cycle dies; halved steps from the last cycle find that speed.
From below: at the same speeds, a small shift of the wheelsets that run straight.

When the speed falls by d all bodies lose d and the axles d over their radius: nothing but the speed changes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from wrsim.analysis.motion.derailment import contact_words
from wrsim.analysis.motion.monitor import Monitor
from wrsim.analysis.stability.rolling import PLACE, RollingVehicle
from wrsim.scenario.sections.stability import CyclePlan
from wrsim.simulation.integrate import Integration
from wrsim.simulation.step_size import implicit_step
from wrsim.simulation.system import Array, BodySystem

Branch = Literal["from above", "from below"]
Ending = Literal["cycle", "rest", "not converged", "derailed"]

SAME = 0.003  # change of the amplitude from window to window, as a part of it, below which a cycle has settled ...
STEADY_WINDOWS = 2  # ... and how often in a row

DYING, FAST = 0.5, 0.03
"""A motion that has fallen to this part of what it was when the longest time is over, and in its last window has fallen
by that part of itself, is on its way to rest. Not so one that beats, or goes over into a smaller cycle."""

ABOVE = 1.1  # the first limit cycle is looked for at so many times the linear critical speed, unless the plan gives it
SAMPLES = 1e-3  # time between two samples of the motion [s]


@dataclass(frozen=True)
class Cycle:
    """What became of a vehicle at one held speed [m/s].

    amplitudes: of the wheelsets' lateral motion, half of peak to peak in the last window [m]; frequency of the
    wheelset that moves most [Hz], not-a-number at rest; time: how long it was held [s]. ending: a converged cycle;
    rest, or well on the way there; neither within the longest time; derailed. remark: messages of the contacts.
    """

    speed: float
    branch: Branch
    amplitudes: Array
    frequency: float
    time: float
    ending: Ending
    message: str = ""
    remark: str = ""

    @property
    def moves(self) -> bool:
        """True unless the vehicle came to rest or left the track."""
        return self.ending in ("cycle", "not converged")


class CycleSearch:
    """Holds speeds and looks what the vehicle comes to."""

    def __init__(
        self, rolling: RollingVehicle, plan: CyclePlan, cycles: list[Cycle], report: Callable[[float], None]
    ) -> None:
        """cycles: gains every cycle, in the order of the search; report: called after each with the part done."""
        self.rolling, self.plan, self.cycles, self.report = rolling, plan, cycles, report
        law = rolling.law
        self.system = BodySystem(law.bodies, law)
        self.wheelsets = len(law.vehicle.wheelsets)
        self.radii = np.array([m.wheelset.mean_radius for m in law.vehicle.wheelsets])
        self.expected = 1.0

    def run(self, linear: float, fastest: float) -> dict[str, Any]:
        """Limit cycles from above and from below; what came out, as attributes.

        linear: critical speed, infinite where there is none; fastest: of the speeds whose modes are known [m/s].
        """
        plan, start = self.plan, self.plan.start
        if start is None:
            start = max(ABOVE * linear, plan.lowest + plan.step) if np.isfinite(linear) else fastest
        self.expected = 2.0 * (start - plan.lowest) / plan.step
        lowest = self.from_above(start)
        outcome: dict[str, Any] = {"cycle_start_m_s": start, "nonlinear_critical_speed_m_s": lowest}
        if not self.cycles[0].moves:
            reason = self.cycles[0].message or "the vehicle comes to rest"
            outcome["nonlinear_note"] = f"no limit cycle at {3.6 * start:.4g} km/h, where the search begins: {reason}"
            return outcome
        steps = np.arange(start, max(lowest, plan.lowest) - plan.step, -plan.step)
        for speed in sorted(float(v) for v in steps if v >= plan.lowest):
            self.hold(speed, "from below", self.kicked(speed, plan.small_kick))
        return outcome | nonlinear_outcome(lowest, linear, plan.lowest)

    def from_above(self, start: float) -> float:
        """Follow the cycle down from a speed [m/s]; returns the lowest speed at which it lives.

        Not-a-number where there is none at the start; the lowest speed of the plan where it never dies.
        """
        plan = self.plan
        cycle, state = self.hold(start, "from above", self.kicked(start, plan.kick))
        if not cycle.moves:
            return float("nan")
        alive, dead = start, float("nan")
        while alive > plan.lowest and not alive - dead <= plan.tolerance:
            speed = max(alive - plan.step, plan.lowest) if np.isnan(dead) else 0.5 * (alive + dead)
            cycle, after = self.hold(speed, "from above", self.slowed(state, alive - speed))
            if cycle.moves:
                alive, state = speed, after
            else:
                dead = speed
        return alive if np.isnan(dead) else 0.5 * (alive + dead)

    def kicked(self, speed: float, shift: float) -> tuple[Array, Array]:
        """Steady rolling with all wheelsets shifted to the left [m]."""
        q, q_t = self.rolling.state(speed)
        q[6 * np.arange(self.wheelsets) + 2] += shift
        return q, q_t

    def slowed(self, state: tuple[Array, Array], by: float) -> tuple[Array, Array]:
        """The state at a speed lower by so much [m/s]."""
        q, q_t = state[0].copy(), state[1].copy()
        bodies = np.arange(len(self.system.bodies))
        q_t[6 * bodies + 1] -= by
        q_t[6 * np.arange(self.wheelsets) + 5] -= by / self.radii
        return q, q_t

    def hold(self, speed: float, branch: Branch, state: tuple[Array, Array]) -> tuple[Cycle, tuple[Array, Array]]:
        """Integrate at a speed until the motion has settled; returns what it came to and the last state."""
        plan, law = self.plan, self.rolling.law
        law.set_speed(speed)
        q, q_t = state
        last = np.zeros(self.wheelsets)
        first, steady_windows, held = 0.0, 0, 0.0
        statuses = np.zeros(2 * self.wheelsets if law.wheels else 0, dtype=int)
        ending: Ending = "not converged"
        message = ""
        while held < plan.longest - 1e-9:
            # the vehicle where it started: on straight track its place means nothing
            reference, q = law.vehicle.reference, q.copy()
            ahead = law.vehicle.parts[reference].centre[0]
            q[6 * np.arange(len(self.system.bodies)) + 1] -= q[6 * reference + 1] - PLACE - ahead
            law.set_search_start(PLACE)
            monitor = Monitor(law, speed, self.system.work)
            motion = Integration(
                self.system, duration=plan.window, step=implicit_step(speed, SAMPLES), sample_interval=SAMPLES,
                weight=law.vehicle.weight, monitor=monitor, monitor_interval=monitor.interval,
            ).run(q, q_t)  # fmt: skip
            if motion.cause == "interrupt":
                raise KeyboardInterrupt
            held += motion.end
            statuses = statuses | monitor.statuses
            lateral = motion.q[:, 6 * np.arange(self.wheelsets) + 2]
            amplitudes = 0.5 * np.ptp(lateral, axis=0)
            q, q_t = motion.q[-1].copy(), motion.q_t[-1].copy()
            if motion.status == "stopped":
                ending, message = "derailed", motion.reason
                break
            change = np.abs(amplitudes - last)
            largest = float(amplitudes.max())
            falling = largest < float(last.max()) or held <= plan.window * 1.5
            fast = largest < (1.0 - FAST) * float(last.max())
            last, first = amplitudes, first or largest
            if largest < plan.rest and falling:
                ending = "rest"
                break
            steady_windows = steady_windows + 1 if float(change.max()) < SAME * largest else 0
            if steady_windows >= STEADY_WINDOWS:
                ending = "cycle"
                break
        else:
            if largest < DYING * first and fast:
                ending = "rest"
        most = int(np.argmax(amplitudes))
        frequency = _frequency(motion.times, lateral[:, most]) if ending in ("cycle", "not converged") else float("nan")
        remark = contact_words(monitor.wheels, statuses.tolist())
        cycle = Cycle(speed, branch, amplitudes, frequency, held, ending, message, remark)
        self.cycles.append(cycle)
        self.report(min(len(self.cycles) / self.expected, 0.99))
        return cycle, (q, q_t)


def nonlinear_outcome(lowest: float, linear: float, end: float) -> dict[str, Any]:
    """What the lowest limit cycle found means, as attributes.

    lowest, linear, end: speeds of that cycle, of instability, and where the search ends [m/s]. Above the linear
    critical speed straight running is unstable anyway: a cycle found only there is no critical speed of its own.
    """
    outcome: dict[str, Any] = {"nonlinear_critical_speed_m_s": np.nan if lowest > linear else lowest}
    where = f"at {3.6 * lowest:.4g} km/h"
    if lowest > linear:
        outcome["nonlinear_note"] = f"no limit cycle below the linear critical speed; the lowest one found is {where}"
    elif lowest <= end:
        outcome["nonlinear_note"] = f"the limit cycle is still there {where}, where the search ends"
    return outcome


def _frequency(times: Array, values: Array) -> float:
    """Frequency of a periodic motion from its passages through the mean, upwards [Hz]."""
    values = values - 0.5 * (values.max() + values.min())
    up = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    if up.size < 2:
        return float("nan")
    passages = times[up] - values[up] * (times[up + 1] - times[up]) / (values[up + 1] - values[up])
    return float((passages.size - 1) / (passages[-1] - passages[0]))
