"""Processor time of every step of a test bench. Run: python benchmarks/bench_deadline.py [--json] [--distance 300]

Manchester vehicle 1 at 60 km/h, as `wrsim.stepper` moves it on, 1 ms and two iterations a step: straight track, on it
a dip of the right rail as wheels see it at a crossing (3 mm deep, from wing to nose within 0.6 m), then a curve of
300 m, all of it with ERRI low irregularities. Of the processor time of every step: mean, quantiles, the most, the share
above 1 ms. Beside them what is left of the balance, and how far the bodies are from those of a usual run of the same
track [mm rms, over all bodies, across the track and up]. Processor time of one evaluation of the forces tells how fast
the machine is at that moment.

The same in counts, which do not depend on the machine: residuals of the strip model a step (``strips.newton``), mean,
quantiles, the most; steps and contacts that the budget was too small for, those that it left unsolved; page faults
of all steps but the first hundred. Memory is locked and Python's garbage collector off while steps are timed.
"""

import argparse
import json
import resource
import time
from pathlib import Path
from typing import Any

import blas_threads  # noqa: F401 (before numpy)
import numpy as np
from bench_vehicle import MODELS, call_time

from wrsim import load, stepper
from wrsim.analysis.contacts import force_law
from wrsim.scenario.build import build
from wrsim.scenario.loading import Scenario
from wrsim.simulation.integrate import Integration
from wrsim.simulation.system import BodySystem
from wrsim.vehicle.dynamics import stepper as kernel

ROOT = Path(__file__).parents[1]
STEP = 1e-3
EVERY = 10  # steps between two states that are compared
DEADLINE = 1e-3  # [s]
BUDGET = 5.0  # residuals a wheel and evaluation: with 5.7 us each, 21 for the rest of a wheel, 16 times, .79 ms
WARM = 100  # steps, of which page faults do not count
KEYS: dict[str, Any] = {
    "vehicle.speed_kmh": 60.0,
    "track.rail_sections": [
        {"at_m": 40.0 + at, "rail": "rails/60E1.toml", "side": "right", "down_mm": down}
        for at, down in ((-1.0, 0.0), (-0.3, 0.0), (0.0, 3.0), (0.3, 0.0), (1.0, 0.0))
    ],
    "track.irregularities": [{"kind": "spectrum", "spectrum": "ERRI-low", "seed": 1, "wavelength_m": [3, 100]}],
    "run.start_distance_m": 12.0,
    "run.output_interval_ms": 1e3 * STEP * EVERY,
    "output.patches_at_m": [],
}


def page_faults() -> int:
    """Of this thread so far."""
    used = resource.getrusage(resource.RUSAGE_THREAD)
    return used.ru_minflt + used.ru_majflt


def scenario_of(model: str, distance: float) -> Scenario:
    """The track with as long a curve as the distance [m] needs."""
    curve = [
        {"kind": "straight", "length_m": 60.0},
        {"kind": "transition", "length_m": 40.0},
        {"kind": "arc", "radius_m": 300.0, "cant_mm": 100.0, "length_m": distance},
    ]
    keys = KEYS | MODELS[model] | {"track.segments": curve, "run.distance_m": distance}
    return load(ROOT / "scenarios/manchester_r300.toml").with_values(keys)


def figures(scenario: Scenario, iterations: int, budget: float) -> dict[str, float]:
    """Times of the steps [us], counts, and differences from a usual run [mm]."""
    own = stepper(scenario, STEP, iterations, budget)
    law, q, q_t = own.law, own.q.copy(), own.q_t.copy()
    scratch = np.zeros(law.size)
    evaluation = call_time(lambda: law(0.0, q, q_t, scratch), 200)
    own.step()  # what is compiled is compiled
    own = stepper(scenario, STEP, iterations, budget)
    record = own.memory.views[kernel.STEP_RECORD][0]
    samples = int(build(scenario).plan.duration / STEP / EVERY)
    states, times = np.zeros((samples + 1, law.size)), np.zeros(samples * EVERY, dtype=np.int64)
    states[:], work, faults = q, np.zeros(len(times)), 0
    with own.deadline() as problem:
        for k in range(samples):
            for j in range(EVERY):
                began = time.thread_time_ns()
                own.step()
                times[k * EVERY + j] = time.thread_time_ns() - began
                work[k * EVERY + j] = record.work
            states[k + 1] = own.q
            faults = page_faults() if k == WARM // EVERY else faults
        faults = page_faults() - faults
    print(f"memory is not locked: {problem}" if problem else "memory is locked")
    usual = force_law(build(scenario))
    motion = Integration(
        BodySystem(usual.bodies, usual), duration=samples * EVERY * STEP, step=2 * STEP, weight=usual.vehicle.weight,
        sample_interval=EVERY * STEP,
    ).run(q, q_t)  # fmt: skip
    n = 6 * len(law.bodies)
    off = (states - motion.q)[:, :n].reshape(len(states), -1, 6)
    heading = motion.q[:, 3:n:6]
    across = np.cos(heading) * off[:, :, 2] - np.sin(heading) * off[:, :, 1]
    us = 1e-3 * times
    return {
        "steps": len(times),
        "evaluation_us": 1e6 * evaluation,
        "mean_us": us.mean(),
        "median_us": np.median(us),
        "q99_us": np.quantile(us, 0.99),
        "q9999_us": np.quantile(us, 0.9999),
        "most_us": us.max(),
        "above_1_ms": float((times > 1e9 * DEADLINE).mean()),
        "residuals_mean": work.mean(),
        "residuals_q99": np.quantile(work, 0.99),
        "residuals_q9999": np.quantile(work, 0.9999),
        "residuals_most": work.max(),
        "coarse_steps": own.coarse.steps / len(times),
        "coarse_contacts": own.coarse.contacts / (len(times) * iterations * 2 * len(law.wheels)),
        "unsolved_contacts": own.coarse.unsolved / (len(times) * iterations * 2 * len(law.wheels)),
        "page_faults": faults,
        "residual_most": own.residual[1],
        "across_mm": 1e3 * float(np.sqrt((across**2).mean())),
        "up_mm": 1e3 * float(np.sqrt((off[:, :, 0] ** 2).mean())),
    }


def main() -> None:
    """Print the figures, or one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", action="store_true", help="the last line is JSON")
    parser.add_argument("--models", nargs="*", choices=MODELS, default=list(MODELS))
    parser.add_argument("--distance", type=float, default=300.0, help="of the run [m]; an hour is 60000")
    parser.add_argument("--iterations", nargs="*", type=int, default=[2])
    parser.add_argument("--budget", type=float, default=BUDGET, help="residuals a wheel and evaluation; inf: any")
    chosen = parser.parse_args()
    found: dict[str, dict[int, dict[str, float]]] = {}
    for model in chosen.models:
        scenario = scenario_of(model, chosen.distance)
        found[model] = {}
        for iterations in chosen.iterations:
            own = found[model][iterations] = figures(scenario, iterations, chosen.budget)
            words = ", ".join(f"{name} {value:.3g}" for name, value in own.items())
            print(f"{model}, {iterations}: {words}", flush=True)
    print(json.dumps({"deadline": found}) if chosen.json else "")


if __name__ == "__main__":
    main()
