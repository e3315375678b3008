"""Processor time of every step of a test bench.

    python benchmarks/bench_deadline.py [--json] [--distance 300] [--passes 2] [--budget 3]

Manchester vehicle 1 at 60 km/h, as `wrsim.stepper` moves it on, 1 ms and two iterations a step: straight track, on it
a dip of the right rail as wheels see it at a crossing (3 mm deep, from wing to nose within 0.6 m), then a curve of
300 m, all of it with ERRI low irregularities. Of the processor time of every step: mean, quantiles, the most, the share
above 1 ms. Beside them what is left of the balance, and how far the bodies are from those of a usual run of the same
track [mm rms, over all bodies, across the track and up]. Processor time of one evaluation of the forces tells how fast
the machine is at that moment.

The same steps are taken in several passes, which come to the same states: of each step the least time counts. Figures
of the first pass stand beside them: what is slow there alone is the host's.

The same in counts, which do not depend on the machine: residuals of the strip model a step (``strips.newton``), mean,
quantiles, the most; steps and contacts that the budget was too small for, those that it left unsolved; page faults
of all steps but the first hundred. Memory is locked and Python's garbage collector off while steps are timed.
"""

import argparse
import json
import resource
import time
from pathlib import Path
from typing import Any, NamedTuple

import blas_threads  # noqa: F401 (before numpy)
import numpy as np
from bench_vehicle import MODELS, call_time

from wrsim import load, stepper
from wrsim.analysis.contacts import force_law
from wrsim.scenario.build import build
from wrsim.scenario.loading import Scenario
from wrsim.simulation.integrate import Integration
from wrsim.simulation.stepper import Stepper
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
        {"at_m": 40.0 + offset, "rail": "rails/60E1.toml", "side": "right", "down_mm": down}
        for offset, down in ((-1.0, 0.0), (-0.3, 0.0), (0.0, 3.0), (0.3, 0.0), (1.0, 0.0))
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


class Pass(NamedTuple):
    """What a test bench does from start to end."""

    bench: Stepper
    times: np.ndarray  # of every step [ns]
    work: np.ndarray  # residuals of every step
    states: np.ndarray  # every EVERY steps, the first one at the start
    faults: int  # of pages, after WARM steps
    problem: str | None  # why memory is not locked


def steps_of(scenario: Scenario, iterations: int, budget: float) -> Pass:
    """Times of all steps of a scenario, garbage collector off and memory locked."""
    bench = stepper(scenario, STEP, iterations, budget)
    record = bench.memory.views[kernel.STEP_RECORD][0]
    samples = int(build(scenario).plan.duration / STEP / EVERY)
    times, work = np.zeros(samples * EVERY, dtype=np.int64), np.zeros(samples * EVERY)
    states, before = np.zeros((samples + 1, bench.law.size)), 0
    states[:] = bench.q
    with bench.deadline() as problem:
        for k in range(samples):
            for j in range(k * EVERY, (k + 1) * EVERY):
                began = time.thread_time_ns()
                bench.step()
                times[j] = time.thread_time_ns() - began
                work[j] = record.work
            states[k + 1] = bench.q
            before = page_faults() if k == WARM // EVERY else before
        faults = page_faults() - before
    return Pass(bench, times, work, states, faults, problem)


def figures(scenario: Scenario, iterations: int, budget: float, passes: int) -> dict[str, float]:
    """Times of the steps [us], counts, and differences from a usual run [mm]."""
    bench = stepper(scenario, STEP, iterations, budget)
    law, q, q_t = bench.law, bench.q.copy(), bench.q_t.copy()
    scratch = np.zeros(law.size)
    evaluation = call_time(lambda: law(0.0, q, q_t, scratch), 200)
    bench.step()  # what is compiled is compiled
    first = steps_of(scenario, iterations, budget)
    bench, work, states = first.bench, first.work, first.states
    print(f"memory is not locked: {first.problem}" if first.problem else "memory is locked")
    times = first.times.copy()
    for _ in range(passes - 1):
        again = steps_of(scenario, iterations, budget)
        if not np.array_equal(again.states, states):
            raise SystemExit("passes come to different states")
        np.minimum(times, again.times, out=times)
    usual = force_law(build(scenario))
    motion = Integration(
        BodySystem(usual.bodies, usual), duration=len(times) * STEP, step=2 * STEP, weight=usual.vehicle.weight,
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
        "most_us_of_one_pass": 1e-3 * first.times.max(),
        "above_1_ms_in_one_pass": float((first.times > 1e9 * DEADLINE).mean()),
        "residuals_mean": work.mean(),
        "residuals_q99": np.quantile(work, 0.99),
        "residuals_q9999": np.quantile(work, 0.9999),
        "residuals_most": work.max(),
        "coarse_steps": bench.coarse.steps / len(times),
        "coarse_contacts": bench.coarse.contacts / (len(times) * iterations * 2 * len(law.wheels)),
        "unsolved_contacts": bench.coarse.unsolved / (len(times) * iterations * 2 * len(law.wheels)),
        "page_faults": first.faults,
        "residual_most": bench.residual[1],
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
    parser.add_argument("--passes", type=int, default=2, help="through the same steps, of which the least times count")
    parser.add_argument("--budget", type=float, default=BUDGET, help="residuals a wheel and evaluation; inf: any")
    chosen = parser.parse_args()
    results: dict[str, dict[int, dict[str, float]]] = {}
    for model in chosen.models:
        scenario = scenario_of(model, chosen.distance)
        results[model] = {}
        for iterations in chosen.iterations:
            result = results[model][iterations] = figures(scenario, iterations, chosen.budget, chosen.passes)
            line = ", ".join(f"{name} {value:.3g}" for name, value in result.items())
            print(f"{model}, {iterations}: {line}", flush=True)
    print(json.dumps({"deadline": results}) if chosen.json else "")


if __name__ == "__main__":
    main()
