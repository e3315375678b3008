"""How fast a lone wheelset runs through a curve. Run: python benchmarks/bench_run.py [--json]

Kik-Piotrowski (25 x 12) in curve_r300 and the strip model with its own number of strips in curve_r150_sharp, as a
user's run goes: see ``bench_vehicle``. Processor time on one core, minimum of the repetitions, without the search for
the start and the making of the result; also as a ratio to Kik-Piotrowski with RK44 at .5 ms on the same track in the
same process.
"""

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from bench_vehicle import REFERENCE_STEP, figures

from wrsim.scenario.build import build
from wrsim.scenario.loading import load

SCENARIOS = Path(__file__).parents[1] / "scenarios"
KIK_PIOTROWSKI: dict[str, Any] = {"contact": {"normal": "kik-piotrowski", "strips": 25, "cells": 12}}
STRIPS: dict[str, Any] = {"contact": {"normal": "strips"}}
RUNS = {"kik-piotrowski": ("curve_r300", KIK_PIOTROWSKI), "strips": ("curve_r150_sharp", STRIPS)}


def main() -> None:
    """Print the table, or the figures as one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", action="store_true", help="the last line is JSON")
    as_json = parser.parse_args().json
    speeds: dict[str, dict[str, dict[str, float]]] = {}
    for model, (name, keys) in RUNS.items():
        scenario = load(SCENARIOS / f"{name}.toml")
        measured = figures(build(scenario.with_values(keys)))
        reference = build(scenario.with_values(KIK_PIOTROWSKI))
        plan = replace(reference.plan, integrator="rk44", step=REFERENCE_STEP)
        measured["to_reference"] = measured["real_time"] / figures(replace(reference, plan=plan))["real_time"]
        speeds[name] = {model: measured}
        print(f"{name}, {model}: " + ", ".join(f"{key} {value:.3g}" for key, value in measured.items()), flush=True)
    if as_json:
        print(json.dumps({"wheelset": speeds}))


if __name__ == "__main__":
    main()
