"""The stability analysis of a scenario, from its set-up to its result."""

from typing import Any

import numpy as np

from wrsim.analysis.progress import Progress, Report
from wrsim.analysis.stability.cycles import Cycle, CycleSearch
from wrsim.analysis.stability.rolling import RollingModes, RollingVehicle, critical, follow
from wrsim.contact.channels import remarks_channel
from wrsim.results import Result, assemble
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.stability import StabilityPlan
from wrsim.simulation.modes import mode_name
from wrsim.vehicle.vehicle import Vehicle

SHARE_OF_MODES = 0.3  # what the modes count for in the progress when limit cycles follow


def run_stability(setup: Setup[StabilityPlan], progress: Progress | None = None) -> Result:
    """Modes at every speed, the linear critical speed and, where wanted, limit cycles.

    Ctrl-C ends it with what it has. Raises SimulationError when the vehicle does not roll straight at the first speed.
    """
    plan, vehicle = setup.plan, setup.vehicle
    report = Report(progress)
    series: list[RollingModes] = []
    remarks: list[str] = []
    cycles: list[Cycle] = []
    nonlinear = any(e.is_linearised for e in vehicle.elements)
    outcome: dict[str, Any] = {"linearised": plan.stroke.label} if nonlinear else {}
    reason = ""
    try:
        rolling = RollingVehicle(setup, plan.speeds[0])
        share = SHARE_OF_MODES if plan.cycles else 1.0
        for i, speed in enumerate(plan.speeds):
            series.append(rolling.modes(speed, plan))
            remarks.append(rolling.remark)
            report(share * 0.8 * (i + 1) / len(plan.speeds))
        worst = critical(lambda speed: rolling.modes(speed, plan), series)
        outcome |= _critical_speed(worst, series, vehicle)
        report(share)
        if plan.cycles is not None:
            linear = np.inf if worst is None else worst.speed
            search = CycleSearch(rolling, plan.cycles, cycles, lambda part: report(share + (1.0 - share) * part))
            outcome |= search.run(linear, plan.speeds[-1])
    except KeyboardInterrupt:
        if not series:
            raise
        reason = f"interrupted by the user after modes at {len(series)} speeds and {len(cycles)} held speeds"
    else:
        report(1.0)
    return _result(setup, series, remarks, cycles, outcome, reason)


def _critical_speed(worst: RollingModes | None, series: list[RollingModes], vehicle: Vehicle) -> dict[str, Any]:
    """The linear critical speed, its frequency and its mode, as attributes."""
    if worst is None:
        top = 3.6 * series[-1].speed
        return {"critical_speed_m_s": np.nan, "critical_note": f"stable at all speeds up to {top:.4g} km/h"}
    mode = int(np.argmax(worst.values.real))  # the least damped one
    attributes: dict[str, Any] = {
        "critical_speed_m_s": worst.speed,
        "critical_frequency_Hz": float(worst.values[mode].imag / (2.0 * np.pi)),
        "critical_mode": mode_name(vehicle, worst.shapes[mode]),
    }
    if worst.values[mode].real < 0.5 * worst.largest:
        attributes |= {"critical_frequency_Hz": 0.0, "critical_mode": "monotonic, without oscillation"}
    if worst is series[0]:
        attributes["critical_note"] = f"unstable already at the lowest speed, {3.6 * worst.speed:.4g} km/h"
    return attributes


def _result(
    setup: Setup[StabilityPlan], series: list[RollingModes], remarks: list[str], cycles: list[Cycle],
    outcome: dict[str, Any], reason: str,
) -> Result:  # fmt: skip
    most = max(len(m.values) for m in series)
    growth, frequency, damping = (np.full((len(series), most), np.nan) for _ in range(3))
    branch = np.zeros((len(series), most))
    names = np.full((len(series), most), "", dtype=object)
    for i, (modes, branches) in enumerate(zip(series, follow(series), strict=True)):
        n = len(modes.values)
        growth[i, :n] = modes.values.real
        frequency[i, :n] = modes.values.imag / (2.0 * np.pi)
        damping[i, :n] = -modes.values.real / np.abs(modes.values)
        branch[i, :n] = branches + 1
        names[i, :n] = [mode_name(setup.vehicle, shape) for shape in modes.shapes]
    channels: dict[str, Any] = {
        "pose_speed": [m.speed for m in series],
        **remarks_channel(remarks),
        "growth_max": [m.largest for m in series],
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
        "pose": [f"{3.6 * m.speed:.10g}kmh" for m in series],
        "wheelset": [m.name for m in setup.vehicle.wheelsets],
    }
    return Result(assemble(coords, channels, setup.attributes(reason) | outcome))
