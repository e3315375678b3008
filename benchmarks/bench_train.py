"""What a vehicle costs in a train. Run: python benchmarks/bench_train.py [--json] [--counts 1 2 4 8 16]

Coaches like Manchester vehicle 1, alone and coupled as in models/trains/manchester_3.toml: at 100 km/h on straight
track with ERRI low irregularities, where all of them have the same to do. Every run goes as a user's does, without the
search for its start and without the making of its result. Processor time on one core, minimum of the repetitions.
"""

import argparse
import json
import tempfile
import time
from pathlib import Path
from typing import Any

import blas_threads  # noqa: F401 (before numpy)
import numpy as np
from bench_vehicle import MODELS, timed

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.start import start_state
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.simulation.placement import design_state

ROOT = Path(__file__).parents[1]
TRAIN = ROOT / "models/trains/manchester_3.toml"
LENGTH = 26.4
KEYS: dict[str, Any] = {
    "vehicle.speed_kmh": 100.0,
    "track.irregularities": [{"kind": "spectrum", "spectrum": "ERRI-low", "seed": 1, "wavelength_m": [3, 100]}],
    "run.distance_m": 60.0,
    "run.output_interval_ms": 10.0,
    "output.patches_at_m": [],
}


def figures(count: int, model: str, repetitions: int) -> dict[str, float]:
    """Times of a train of so many coaches; one runs alone, as a plain vehicle."""
    with tempfile.TemporaryDirectory() as folder:
        name = "vehicles/manchester_1.toml"
        if count > 1:
            file = Path(folder) / "train.toml"
            file.write_text(TRAIN.read_text(encoding="utf-8").replace("count = 3", f"count = {count}"))
            name = str(file)
        scenario = load(ROOT / "scenarios/manchester_r300.toml")
        origin = 30.0 + LENGTH * count  # the whole train is on uneven track
        place = {"run.start_distance_m": origin, "track.segments": [{"kind": "straight", "length_m": origin + 100.0}]}
        setup = build(scenario.with_values(KEYS | place | MODELS[model] | {"vehicle.model": name}))
    law = force_law(setup)
    law(0.0, *design_state(law), np.zeros(law.size))  # what is compiled is loaded
    began = time.process_time()
    q, q_t = start_state(setup, law)
    start = time.process_time() - began
    timed(setup, law, q, q_t, 0.1, 1)  # what is compiled is compiled
    best, motion = timed(setup, law, q, q_t, setup.plan.duration, repetitions)
    steps, work = round(motion.end / motion.step), motion.work
    return {
        "unknowns": law.size,
        "start_s": start,
        "real_time": motion.end / best,
        "us_per_step_and_vehicle": 1e6 * best / steps / count,
        "evaluations": work.evaluations / steps,
        "jacobians_per_s": work.jacobians / motion.end,
    }


def main() -> None:
    """Print the figures, or one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", action="store_true", help="the last line is JSON")
    parser.add_argument("--models", nargs="*", choices=MODELS, default=list(MODELS))
    parser.add_argument("--counts", nargs="*", type=int, default=[1, 2, 4, 8, 16])
    parser.add_argument("--repetitions", type=int, default=3)
    chosen = parser.parse_args()
    trains: dict[str, dict[int, dict[str, float]]] = {}
    for model in chosen.models:
        trains[model] = {}
        for count in chosen.counts:
            measured = trains[model][count] = figures(count, model, chosen.repetitions)
            print(
                f"{model}, {count}: " + ", ".join(f"{name} {value:.3g}" for name, value in measured.items()), flush=True
            )
    print(json.dumps({"train": trains}) if chosen.json else "")


if __name__ == "__main__":
    main()
