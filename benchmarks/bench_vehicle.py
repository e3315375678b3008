"""How fast a whole vehicle runs, and which step is accurate. Run: python benchmarks/bench_vehicle.py [--json]

Manchester vehicle 1, eight wheels: at 60 km/h into a curve of 300 m (curve), on rails whose sections are
alike but for .1 um (alike: the same contacts as in the curve, at the cost of sections), on rails worn all along (worn),
on rails that go from new to worn and back twice (sections), at 160 km/h on straight track with ERRI
low irregularities (uneven), the same at 80 km/h (rigid) and there on rails on 200 sleepers (sleepers), at 5 km/h into
a curve of 150 m (slow). A laden freight wagon, whose suspension is full of
friction, at 60 km/h into a curve of 300 m (freight). Every run goes as a user's does: with the
integrator and the step that it chooses, its samples and its monitor; without the search for its start and without the
making of its result. Processor time on one core, minimum of the repetitions; also as a ratio to Kik-Piotrowski with
RK44 at .5 ms in the same process, which a machine that wavers leaves alone. Models: Kik-Piotrowski with 25 x 12, the
strip model with its own number of strips.

Without --json also the split of an evaluation, and for each step the largest difference from RK44 at an eighth of a
millisecond, as a part of the largest value: Y and Q of every wheel after the low-pass of 20 Hz of an assessment.
"""

import argparse
import json
import time
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import blas_threads  # noqa: F401 (before numpy)
import numpy as np
from scipy.interpolate import CubicSpline

from wrsim.analysis import run
from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.monitor import Monitor
from wrsim.analysis.motion.run import chosen_step
from wrsim.analysis.motion.start import start_state
from wrsim.results.filters import low_pass
from wrsim.scenario.build import Setup, build
from wrsim.scenario.loading import Scenario, load
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation.integrate import Integration, Motion
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.system import BodySystem

SCENARIOS = Path(__file__).parents[1] / "scenarios"
UNEVEN: dict[str, Any] = {
    "vehicle.speed_kmh": 160.0,
    "track.segments": [{"kind": "straight", "length_m": 400.0}],
    "track.irregularities": [{"kind": "spectrum", "spectrum": "ERRI-low", "seed": 1, "wavelength_m": [3, 100]}],
    "run.distance_m": 100.0,
}
SECTIONS: dict[str, Any] = {
    "run.distance_m": 100.0,
    "track.rail_sections": [
        {"at_m": place, "rail": f"rails/60E1{'_worn' * worn}.toml"}
        for place, worn in ((10, 0), (40, 1), (70, 0), (90, 1))
    ],
}
ALIKE: dict[str, Any] = {
    "run.distance_m": 100.0,
    "track.rail_sections": [
        {"at_m": place, "rail": "rails/60E1.toml", "outward_mm": off}
        for place, off in ((10, 0.0), (40, 1e-4), (70, 0.0))
    ],
}
AT_80: dict[str, Any] = UNEVEN | {"vehicle.speed_kmh": 80.0, "run.distance_m": 120.0}
SLEEPERS: dict[str, Any] = AT_80 | {
    "track.structure": tomllib.loads((SCENARIOS / "flat_on_sleepers.toml").read_text())["track"]["structure"]
}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "curve": ("manchester_r300.toml", {"run.distance_m": 100.0}),
    "uneven": ("manchester_r300.toml", UNEVEN),
    "rigid": ("manchester_r300.toml", AT_80),
    "sleepers": ("manchester_r300.toml", SLEEPERS),
    "alike": ("manchester_r300.toml", ALIKE),
    "worn": ("manchester_r300.toml", {"run.distance_m": 100.0, "track.rail": "rails/60E1_worn.toml"}),
    "sections": ("manchester_r300.toml", SECTIONS),
    "freight": ("freight_r300_laden.toml", {}),
    "slow": ("manchester_r150.toml", {"vehicle.speed_kmh": 5.0, "run.start_distance_m": 16.0, "run.distance_m": 10.0}),
}
MODELS: dict[str, dict[str, Any]] = {
    "kik-piotrowski": {"contact.normal": "kik-piotrowski", "contact.strips": 25, "contact.cells": 12},
    "strips": {"contact.normal": "strips"},
}
REFERENCE_STEP, STAGES = 5e-4, 4
TRUTH_US, STEPS_US = 125, (2000, 1000)
REPETITIONS = 3


def scenario_of(case: str, model: str) -> Scenario:
    """The case with a model."""
    file, keys = CASES[case]
    base = {"run.output_interval_ms": 10.0, "output.patches_at_m": []}
    return load(SCENARIOS / file).with_values(base | keys | MODELS[model])


def timed(
    setup: Setup[RunPlan], law: VehicleOnTrack, q: np.ndarray, q_t: np.ndarray, duration: float, repetitions: int
) -> tuple[float, Motion]:
    """Processor time of a run from a state [s], and its motion."""
    plan = setup.plan
    step = chosen_step(setup, law, q, q_t) if plan.step is None else plan.step
    system, begin = BodySystem(law.bodies, law), law.get_state()
    best = np.inf
    for _ in range(repetitions):
        law.set_state(begin)  # where the contacts, and the rails under the wheels, are
        monitor = Monitor(law, plan.speed)
        began = time.process_time()
        motion = Integration(
            system, duration=duration, step=step, integrator=plan.integrator, weight=law.vehicle.weight,
            sample_interval=plan.output_interval, monitor=monitor, monitor_interval=monitor.interval,
        ).run(q, q_t)  # fmt: skip
        best = min(best, time.process_time() - began)
    law.set_state(begin)
    return best, motion


def figures(setup: Setup[RunPlan]) -> dict[str, float]:
    """Times real time, step and what a run takes."""
    law = force_law(setup)
    q, q_t = start_state(setup, law)
    timed(setup, law, q, q_t, 0.1, 1)  # what is compiled is compiled
    best, motion = timed(setup, law, q, q_t, setup.plan.duration, REPETITIONS)
    steps = round(motion.end / motion.step)
    return {
        "real_time": motion.end / best,
        "step_ms": 1e3 * motion.step,
        "evaluations": motion.work.evaluations / steps,
        "jacobians_per_s": motion.work.jacobians / motion.end,
        "explicit_steps": motion.work.explicit_steps,
    }


def reference_speed(case: str) -> float:
    """Times real time of Kik-Piotrowski with RK44 at .5 ms (which is not stable at 5 km/h: the time it takes all the
    same)."""
    setup = build(scenario_of(case, "kik-piotrowski"))
    setup = replace(setup, plan=replace(setup.plan, integrator="rk44", step=REFERENCE_STEP))
    law = force_law(setup)
    q, q_t = start_state(setup, law)
    duration = min(setup.plan.duration, 1.0)
    timed(setup, law, q, q_t, 0.05, 1)
    best, motion = timed(setup, law, q, q_t, duration, REPETITIONS)
    return motion.end / best


def call_time(call: Callable[[], object], repetitions: int = 2000) -> float:
    """Processor time of a call [s]."""
    best = np.inf
    for _ in range(REPETITIONS):
        began = time.process_time()
        for _ in range(repetitions):
            call()
        best = min(best, (time.process_time() - began) / repetitions)
    return best


def split(case: str) -> None:
    """Print the parts of an evaluation at the start of a case."""
    setup = build(scenario_of(case, "kik-piotrowski"))
    law = force_law(setup)
    q, q_t = start_state(setup, law)
    out = np.zeros(law.size)
    whole, suspension = (call_time(lambda call=call: call(0.0, q, q_t, out)) for call in (law, law.on_bodies))
    print(
        f"  {case}: an evaluation {1e6 * whole:.1f} us = suspension, bodies and call {1e6 * suspension:.1f} + eight "
        f"contacts {1e6 * (whole - suspension):.1f}"
    )


def accuracy(case: str) -> None:
    """Print the differences that the step makes."""

    def filtered(step_us: int, integrator: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        interval = max(1e-3 * step_us, 0.5)
        values = {"run.integrator": integrator, "run.step_us": step_us, "run.output_interval_ms": interval}
        data = run(scenario_of(case, "kik-piotrowski").with_values(values)).dataset
        times = data["time"].values
        rate = 1e3 / interval
        return times, {name: low_pass(data[name].values.reshape(len(times), -1), rate, 20.0) for name in ("Y", "Q")}

    times, truth = filtered(TRUTH_US, "rk44")
    for step_us in STEPS_US:
        sampled, values = filtered(step_us, "generalised-alpha")
        inside = (sampled > 0.1) & (sampled < times[-1] - 0.1)
        errors = {
            name: np.abs(values[name] - CubicSpline(times, truth[name])(sampled))[inside].max()
            / np.abs(truth[name]).max()
            for name in values
        }
        print(f"  {case}, {1e-3 * step_us:g} ms: " + ", ".join(f"{name} {e:.2g}" for name, e in errors.items()))


def main() -> None:
    """Print the tables, or the figures as one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", action="store_true", help="figures only; the last line is JSON")
    parser.add_argument("--models", nargs="*", choices=MODELS, default=list(MODELS))
    parser.add_argument("--cases", nargs="*", choices=CASES, default=list(CASES))
    chosen = parser.parse_args()
    speeds: dict[str, dict[str, dict[str, float]]] = {}
    for case in chosen.cases:
        reference = reference_speed(case)
        print(f"{case}: Kik-Piotrowski, rk44 at {1e3 * REFERENCE_STEP:g} ms: {reference:.2f} times real time")
        speeds[case] = {}
        for model in chosen.models:
            measured = figures(build(scenario_of(case, model)))
            measured["to_reference"] = measured["real_time"] / reference
            speeds[case][model] = measured
            print(f"  {model}: " + ", ".join(f"{name} {value:.3g}" for name, value in measured.items()), flush=True)
    if not chosen.json:
        for case in ("curve", "uneven", "freight"):
            split(case)
        print(f"largest difference from rk44 at {1e-3 * TRUTH_US:g} ms, after the low-pass of 20 Hz:")
        for case in ("curve", "uneven", "freight"):
            accuracy(case)
    print(json.dumps({"coach": speeds}) if chosen.json else "")


if __name__ == "__main__":
    main()
