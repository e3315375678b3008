"""How fast a whole vehicle runs, where the time goes, which step is accurate. Run: python benchmarks/bench_vehicle.py

Manchester vehicle 1, eight wheels with Kik-Piotrowski strips and FASTSIM online: at 60 km/h into a curve of 300 m,
and at 160 km/h on straight track with ERRI low irregularities. First the speed on one core (processor time, minimum of
the repetitions) and the split of a stage: the law without rails gives the suspension, an empty law gives Exudyn and the
callback. Then, for each step, the largest difference from a run at an eighth of a millisecond, as a part of the largest
value: Y and Q of every wheel, lateral shift and angle of attack of every wheelset.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from wrsim.analysis.motion.forces import force_law
from wrsim.analysis.motion.run import run_in_time
from wrsim.analysis.motion.start import start_state
from wrsim.scenario.build import Setup, build
from wrsim.scenario.loading import load
from wrsim.simulation.integrate import integrate
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.system import Array, ForceLaw, System

SCENARIO = Path(__file__).parents[1] / "scenarios" / "manchester_r300.toml"
STEPS_US = {"curve": (625, 500, 250), "uneven": (1000, 500, 250)}  # stable up to 0.7 ms at 60 km/h
REFERENCE_US = 125
STAGES = 4  # of RK44
COMPARED = ("Y", "Q", "lateral_shift", "yaw")
REPETITIONS = 3


UNEVEN: dict[str, object] = {
    "vehicle.speed_kmh": 160.0,
    "track.segments": [{"kind": "straight", "length_m": 400.0}],
    "track.irregularities": [{"kind": "spectrum", "spectrum": "ERRI-low", "seed": 1, "wavelength_m": [3, 100]}],
}


def setup_of(case: str, strips: int, cells: int, length: float) -> Setup:
    """The start of the scenario, over the transition into the full curve; or the uneven straight."""
    keys = {"contact.strips": strips, "contact.cells": cells, "run.distance_m": length, "run.output_interval_ms": 10.0}
    return build(load(SCENARIO).with_values(keys | (UNEVEN if case == "uneven" else {})))


def nothing(t: float, q: Array, q_t: Array, out: Array) -> None:
    """An empty force law."""
    out[:] = 0.0


def stage_time(setup: Setup, law: ForceLaw, vehicle: VehicleOnTrack, step: float, duration: float) -> float:
    """Processor time of a stage of the integration [s]."""
    best = np.inf
    system = System(vehicle.bodies, law, vehicle.dampers)
    for _ in range(REPETITIONS):
        vehicle.look_near(setup.plan.start)
        q, q_t = start_state(setup, vehicle)
        began = time.process_time()
        integrate(system, q, q_t, duration=duration, step=step, sample_interval=5e-3)
        best = min(best, (time.process_time() - began) / (duration / step * STAGES))
    return best


def call_time(call: Callable[[], object], repetitions: int = 2000) -> float:
    """Processor time of a call [s]."""
    best = np.inf
    for _ in range(REPETITIONS):
        began = time.process_time()
        for _ in range(repetitions):
            call()
        best = min(best, (time.process_time() - began) / repetitions)
    return best


def split(case: str, strips: int, cells: int, step: float = 5e-4) -> None:
    """Print how fast a run is and the parts of a stage."""
    setup = setup_of(case, strips, cells, 100.0)
    law = force_law(setup)
    whole = stage_time(setup, law, law, step, setup.plan.duration)
    empty = stage_time(setup, nothing, law, step, 0.5)
    law.look_near(setup.plan.start)
    q, q_t = start_state(setup, law)
    out = np.zeros(law.size)
    bare = VehicleOnTrack(law.vehicle, law.track, (), speed=law.speed, start=law.start)
    suspension = call_time(lambda: bare(0.0, q, q_t, out))
    print(
        f"  {case}, {strips} x {cells}: {step / (whole * STAGES):.2f} times real time at {1e3 * step:g} ms; "
        f"a stage {1e6 * whole:.1f} us = Exudyn and callback {1e6 * empty:.1f} + suspension, bodies "
        f"and call {1e6 * suspension:.1f} + eight contacts {1e6 * (whole - empty - suspension):.1f}"
    )


def accuracy(case: str, strips: int, cells: int, length: float) -> None:
    """Print the differences that the step makes."""
    runs = {}
    for step in (*STEPS_US[case], REFERENCE_US):
        setup = setup_of(case, strips, cells, length)
        setup = replace(setup, plan=replace(setup.plan, step=1e-6 * step))
        runs[step] = run_in_time(setup).dataset
    truth = runs[REFERENCE_US]
    for step in STEPS_US[case]:
        count = min(runs[step].sizes["time"], truth.sizes["time"])
        parts = []
        for name in COMPARED:
            a, b = (d[name].values[:count] for d in (runs[step], truth))
            difference = np.nan_to_num(np.abs(a - b))
            parts.append(f"{name} {difference.max() / np.nanmax(np.abs(b)):.2g} (rms "
                         f"{np.sqrt(np.mean(difference**2)) / np.nanmax(np.abs(b)):.2g})")  # fmt: skip
        print(f"  {case}, {1e-3 * step:g} ms: " + ", ".join(parts))


def main() -> None:
    """Print the tables."""
    print("Manchester vehicle 1 in a 300 m curve at 60 km/h, and on uneven straight track at 160 km/h; strips x cells:")
    for case in STEPS_US:
        for strips, cells in ((40, 20), (25, 12)):
            split(case, strips, cells)
    length = float(sys.argv[1]) if len(sys.argv) > 1 else 100.0
    print(f"difference from a step of {1e-3 * REFERENCE_US:g} ms over {length:g} m, largest (rms):")
    for case in STEPS_US:
        accuracy(case, 25, 12, length)


if __name__ == "__main__":
    main()
