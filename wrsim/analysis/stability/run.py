"""The stability analysis of a scenario, from its set-up to its result."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from wrsim.analysis.progress import Progress, Report
from wrsim.analysis.stability.cycles import Cycle, CycleSearch
from wrsim.analysis.stability.modes import Modes, critical, follow
from wrsim.analysis.stability.rolling import RollingVehicle
from wrsim.contact.channels import remarks_channel
from wrsim.results import Result, assemble
from wrsim.simulation.modes import mode_name

if TYPE_CHECKING:
    from wrsim.scenario.build import Setup
    from wrsim.scenario.sections.stability import CyclePlan, StabilityPlan
    from wrsim.vehicle.vehicle import Vehicle

ABOVE = 1.1
"""The first limit cycle is looked for at so many times the linear critical speed, unless the plan gives it."""

SHARE_OF_MODES = 0.3
"""What the modes count for in the progress when limit cycles follow."""


def run_stability(setup: Setup[StabilityPlan], progress: Progress | None = None) -> Result:
    """Modes at every speed, the linear critical speed and, where asked for, limit cycles.

    Ctrl-C ends the study with what it has. Raises SimulationError when the vehicle does not even roll straight at the
    first speed.
    """
    plan, vehicle = setup.plan, setup.vehicle
    if plan is None:
        raise ValueError("the set-up has no stability plan")
    report = Report(progress)
    found: list[Modes] = []
    remarks: list[str] = []
    cycles: list[Cycle] = []
    outcome: dict[str, Any] = {}
    reason = ""
    try:
        rolling = RollingVehicle(setup, plan.speeds[0])
        share = SHARE_OF_MODES if plan.cycles else 1.0
        for i, speed in enumerate(plan.speeds):
            found.append(rolling.modes(speed, plan.highest))
            remarks.append(rolling.remark)
            report(share * 0.8 * (i + 1) / len(plan.speeds))
        worst = critical(lambda speed: rolling.modes(speed, plan.highest), found)
        outcome |= _critical_words(worst, found, vehicle)
        report(share)
        if plan.cycles is not None:
            outcome |= _cycles(rolling, plan, plan.cycles, worst, cycles, report)
    except KeyboardInterrupt:
        if not found:
            raise
        reason = f"interrupted by the user after modes at {len(found)} speeds and {len(cycles)} held speeds"
    else:
        report(1.0)
    return _result(setup, found, remarks, cycles, outcome, reason)


def _cycles(
    rolling: RollingVehicle,
    plan: StabilityPlan,
    cycle_plan: CyclePlan,
    worst: Modes | None,
    kept: list[Cycle],
    report: Callable[[float], None],
) -> dict[str, Any]:
    """Limit cycles from above and from below; ``kept`` gains them one by one. Returns what came out."""
    start = cycle_plan.start
    if start is None:
        start = plan.speeds[-1] if worst is None else max(ABOVE * worst.speed, cycle_plan.lowest + cycle_plan.step)
    expected = 2.0 * (start - cycle_plan.lowest) / cycle_plan.step

    def one_more(speed: float) -> None:
        report(min(SHARE_OF_MODES + (1.0 - SHARE_OF_MODES) * len(kept) / expected, 0.99))

    search = CycleSearch(rolling, cycle_plan, one_more)
    search.found = kept
    lowest = search.from_above(start)
    first = kept[0]
    outcome: dict[str, Any] = {"cycle_start_m_s": start, "nonlinear_critical_speed_m_s": lowest}
    if not first.moves:
        words = first.message or "the vehicle comes to rest"
        outcome["nonlinear_note"] = f"no limit cycle at {3.6 * start:.4g} km/h, where the search begins: {words}"
    else:
        outcome |= nonlinear_outcome(lowest, np.inf if worst is None else worst.speed, cycle_plan.lowest)
    if first.moves:
        steps = np.arange(start, max(lowest, cycle_plan.lowest) - cycle_plan.step, -cycle_plan.step)
        for speed in sorted(float(v) for v in steps if v >= cycle_plan.lowest):
            search.hold(speed, "from below", search.kicked(speed, cycle_plan.small_kick))
    return outcome


def nonlinear_outcome(lowest: float, linear: float, end: float) -> dict[str, Any]:
    """What the lowest limit cycle found means, as attributes.

    lowest, linear, end: speeds of that cycle, of instability, and where the search ends [m/s]. Above the linear
    critical speed straight running is unstable anyway: a cycle found only there is no critical speed of its own.
    """
    if lowest > linear:
        words = f"no limit cycle below the linear critical speed; the lowest one found is at {3.6 * lowest:.4g} km/h"
        return {"nonlinear_critical_speed_m_s": np.nan, "nonlinear_note": words}
    if lowest <= end:
        words = f"the limit cycle is still there at {3.6 * lowest:.4g} km/h, where the search ends"
        return {"nonlinear_critical_speed_m_s": lowest, "nonlinear_note": words}
    return {"nonlinear_critical_speed_m_s": lowest}


def _critical_words(worst: Modes | None, found: list[Modes], vehicle: Vehicle) -> dict[str, Any]:
    """The linear critical speed, its frequency and its mode, as attributes."""
    if worst is None:
        top = 3.6 * found[-1].speed
        return {"critical_speed_m_s": np.nan, "critical_note": f"stable at all speeds up to {top:.4g} km/h"}
    mode = int(np.argmax(worst.values.real))  # the least damped one
    words: dict[str, Any] = {
        "critical_speed_m_s": worst.speed,
        "critical_frequency_Hz": float(worst.values[mode].imag / (2.0 * np.pi)),
        "critical_mode": mode_name(vehicle, worst.shapes[mode]),
    }
    if worst.values[mode].real < 0.5 * worst.largest:
        words |= {"critical_frequency_Hz": 0.0, "critical_mode": "monotonic, without oscillation"}
    if worst is found[0]:
        words["critical_note"] = f"unstable already at the lowest speed, {3.6 * worst.speed:.4g} km/h"
    return words


def _result(
    setup: Setup[StabilityPlan],
    found: list[Modes],
    remarks: list[str],
    cycles: list[Cycle],
    outcome: dict[str, Any],
    reason: str,
) -> Result:
    most = max(len(m.values) for m in found)
    growth, frequency, damping = (np.full((len(found), most), np.nan) for _ in range(3))
    branch = np.zeros((len(found), most))
    names = np.full((len(found), most), "", dtype=object)
    for i, (modes, own) in enumerate(zip(found, follow(found), strict=True)):
        n = len(modes.values)
        growth[i, :n] = modes.values.real
        frequency[i, :n] = modes.values.imag / (2.0 * np.pi)
        damping[i, :n] = -modes.values.real / np.abs(modes.values)
        branch[i, :n] = own + 1
        names[i, :n] = [mode_name(setup.vehicle, shape) for shape in modes.shapes]
    channels: dict[str, Any] = {
        "pose_speed": [m.speed for m in found],
        **remarks_channel(remarks),
        "growth_max": [m.largest for m in found],
        "mode_growth": growth,
        "mode_frequency": frequency,
        "mode_damping": damping,
        "mode_branch": branch,
        "mode_name": names.astype(str),
    }
    if any(c.remark for c in cycles):
        channels["cycle_remark"] = np.array([c.remark for c in cycles])
    if cycles:
        channels |= {
            "cycle_speed": [c.speed for c in cycles],
            "cycle_branch": [c.branch for c in cycles],
            "cycle_ending": [c.ending for c in cycles],
            "cycle_time": [c.time for c in cycles],
            "cycle_frequency": [c.frequency for c in cycles],
            "cycle_amplitude": np.array([c.amplitudes for c in cycles]),
        }
    coords: dict[str, Any] = {
        "pose": [f"{3.6 * m.speed:.10g}kmh" for m in found],
        "wheelset": [m.name for m in setup.vehicle.wheelsets],
    }
    return Result(assemble(coords, channels, setup.attributes(reason) | outcome))
