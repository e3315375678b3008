"""Makes yaw_damper.png: what an active yaw damper, a controller outside of a co-simulation unit, does to hunting.

A GZ18 metro car at 200 km/h, its yaw dampers taken out: the yaw of the front frame after a kick.
Run: python docs/figures/make_yaw_damper.py (needs fmpy)
"""

from __future__ import annotations

import shutil
from math import log, pi
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.simulation import instantiate_fmu

from wrsim import load, write_unit
from wrsim.plots import new_figure, save, style

HERE = Path(__file__).parent
STEP, DURATION = 1e-3, 3.0  # [s]
KICK, KICKED = 20e3, 0.2  # [N, s]
GAIN = 2e5  # [N s/rad]
KEYS: dict[str, Any] = {
    "vehicle.speed_kmh": 200.0,
    "vehicle.changes": {"bogie.yaw damper.velocity_m_per_s_force_kN": [[0, 0], [1, 0.001]]},
    "vehicle.loads": [
        {"name": "kick", "on": "front.frame", "at_mm": [0, 0, 600], "axes": "track", "force_kN": [0, 0, 0]}
    ],
    "track.segments": [{"kind": "straight", "length_m": 600.0}],
    "run.distance_m": 300.0,
    "contact.normal": "kik-piotrowski",
    "contact.tangential": "fastsim",
}


def yaw_of(folder: str, description: Any, gain: float) -> np.ndarray:
    """Yaw of the front frame after every step [rad]."""
    number = {variable.name: variable.valueReference for variable in description.modelVariables}
    unit = instantiate_fmu(folder, description, fmi_type="CoSimulation")
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    yaw = np.zeros(round(DURATION / STEP))
    for i in range(len(yaw)):
        unit.setFloat64([number["kick.force_y_N"]], [KICK if i * STEP < KICKED else 0.0])
        for bogie in ("front", "rear"):
            rate = unit.getFloat64([number[f"{bogie}.frame.yaw_rate_rad_s"]])[0]
            forces = [number[f"{bogie}.yaw_damper_{side}.control_N"] for side in ("left", "right")]
            unit.setFloat64(forces, [-gain * rate, gain * rate])
        unit.doStep(i * STEP, STEP)
        yaw[i] = unit.getFloat64([number["front.frame.yaw_rad"]])[0]
    unit.terminate()
    unit.freeInstance()
    return yaw


def damping(yaw: np.ndarray) -> tuple[float, float]:
    """Frequency [Hz] and part of the critical damping, by the crossings of zero and the ranges from 0.5 s on."""
    free = yaw[round(0.5 / STEP) :]
    late = free[-round(0.5 / STEP) :]
    frequency = 0.5 * np.count_nonzero(np.diff(np.sign(free))) / (len(free) * STEP)
    early = np.ptp(free[: len(late)])
    rate = log(early / np.ptp(late)) / ((len(free) - len(late)) * STEP)
    return frequency, rate / (2.0 * pi * frequency)


def main() -> None:
    """Write the unit, run it without and with the controller, print and draw."""
    scenario = load(HERE.parents[1] / "scenarios" / "gz18_r300.toml").with_values(KEYS)
    file = str(write_unit(scenario, HERE.parents[1] / "build" / "gz18.fmu").files[0])
    folder, description = fmpy.extract(file), fmpy.read_model_description(file)
    with style():
        figure = new_figure(150, 60)
        axes = figure.subplots()
        for label, gain in (("without", 0.0), ("active yaw damper", GAIN)):
            yaw = yaw_of(folder, description, gain)
            frequency, part = damping(yaw)
            print(f"{label}: {frequency:.2f} Hz, {100 * part:.1f} % of critical damping")
            axes.plot(STEP * (1 + np.arange(len(yaw))), 1e3 * yaw, label=label)
        axes.set_xlabel("time, s")
        axes.set_ylabel("yaw of the front frame, mrad")
        axes.legend()
        print(save(figure, HERE / "yaw_damper.png"))
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
