"""Studies: how much of the workers' time is simulation, and what a study of many cases costs beside it.

    python benchmarks/bench_study.py                     200 cases of 2 s on all processors
    python benchmarks/bench_study.py --cases 40 --workers 1,2,4     shares and identical results
    python benchmarks/bench_study.py --scale 10000       the engine alone: planning, scheduler, files

``simulation``: from the scenario to the result, as ``wrsim run`` does it; ``saving``: the rest of a case;
``idle``: workers without a case, from the first case that begins to the last that ends. ``start``: before that.
"""

import argparse
import json
import os
import resource
import shutil
import tempfile
import time
from pathlib import Path
from typing import Any

import blas_threads  # noqa: F401 (before numpy)
import numpy as np

from wrsim.results import write_atomically
from wrsim.study.cluster import local_workers
from wrsim.study.collect import collected, markers_of, write_study
from wrsim.study.engine import execute, kinds
from wrsim.study.plan import PLAN, Plan, planned
from wrsim.study.task import Marker, compile_for, missing, write_marker

SCENARIO = Path(__file__).parents[1] / "scenarios" / "curve_r300.toml"


def study(folder: Path, cases: int, seconds: float, keep: str) -> Plan:
    """A plan of so many cases, sampled over friction and speed, that run for so many seconds of simulated time."""
    base = f'base = "{SCENARIO}"\n[run]\ntime_s = {seconds}\n[output]\npatches_at_m = []\n'
    (folder / "base.toml").write_text(base)
    over = '[[vary.over]]\nkey = "contact.friction"\nlow = 0.1\nhigh = 0.5\n'
    over += '[[vary.over]]\nkey = "vehicle.speed_kmh"\nlow = 40\nhigh = 60\n'
    axis = f'[[vary]]\nkind = "latin-hypercube"\nsamples = {cases}\nseed = 1\n'
    (folder / "study.toml").write_text(f'base = "base.toml"\n{axis}{over}[cases]\nkeep = "{keep}"\n')
    plan, _ = planned(folder / "study.toml", folder / "out")
    write_atomically(folder / "out" / PLAN, plan.dumped())
    return plan


def run(folder: Path, cases: int, seconds: float, workers: int, keep: str) -> tuple[Plan, dict[str, float]]:
    """Figures of one study from its cold start."""
    begin = time.time()
    plan = study(folder, cases, seconds, keep)
    todo = missing(plan)
    planning = time.time() - begin
    for i in kinds(plan, todo):
        compile_for(plan.scenario(plan.cases[i]))
    with local_workers(workers) as client:
        ready = time.time()
        execute(client, plan, todo)
    known = [m for m in markers_of(plan) if m is not None]
    first, last = min(m.began for m in known), max(m.ended for m in known)
    room = workers * (last - first)
    simulation, whole = sum(m.simulation for m in known), sum(m.wall_time for m in known)
    return plan, {
        "workers": workers,
        "cases": cases,
        "completed": sum(m.status == "completed" for m in known),
        "case_s": float(np.median([m.wall_time for m in known])),
        "simulation_percent": 100.0 * simulation / room,
        "saving_percent": 100.0 * (whole - simulation) / room,
        "idle_percent": 100.0 * (1.0 - whole / room),
        "planning_s": planning,
        "start_s": first - begin,
        "workers_start_s": first - ready,
        "wall_s": last - begin,
    }


def same(plans: list[Plan]) -> bool:
    """True if all studies came to the same numbers, to the bit."""
    first, *repeated = (collected(plan, markers_of(plan)) for plan in plans)
    return all(first.identical(dataset) for dataset in repeated)


def scale(folder: Path, cases: int) -> dict[str, float]:
    """What a study of so many cases costs beside its simulations: its markers are written by the benchmark."""
    begin = time.perf_counter()
    plan = study(folder, cases, 1.0, "numbers")
    planning = time.perf_counter() - begin
    size = (folder / "out" / PLAN).stat().st_size
    begin = time.perf_counter()
    todo = missing(plan)
    looking = time.perf_counter() - begin
    numbers = {f"output_{k}": 1.0 for k in range(8)}
    begin = time.perf_counter()
    for case in plan.cases:
        marker = Marker(case.name, case.label, "completed", "", dict(numbers), dict.fromkeys(numbers, ""))
        marker.outputs = plan.outputs_digest
        write_marker(plan.folder_of(case), marker)
    writing = time.perf_counter() - begin
    before = _memory()
    with local_workers(1) as client:
        begin = time.perf_counter()
        execute(client, plan, todo)  # every worker finds the marker: what is left is the engine
        handing = time.perf_counter() - begin
        after = _memory()
    begin = time.perf_counter()
    write_study(plan, markers_of(plan), pictures=False)
    collecting = time.perf_counter() - begin
    return {
        "cases": cases,
        "planning_s": planning,
        "plan_MB": size / 1e6,
        "looking_s": looking,
        "writing_markers_s": writing,
        "handing_out_ms_a_case": 1e3 * handing / cases,
        "memory_MB": after,
        "memory_of_scheduler_MB": after - before,
        "collecting_s": collecting,
        "files": sum(len(names) for _, _, names in os.walk(folder / "out")),
    }


def _memory() -> float:
    """Largest memory of this process so far, client and scheduler [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=4.0, help="simulated time of a case")
    parser.add_argument("--workers", default=str(os.cpu_count() or 1), help="numbers of workers, such as 1,2,4")
    parser.add_argument("--keep", choices=("results", "numbers"), default="results")
    parser.add_argument("--scale", type=int, metavar="CASES", help="the engine alone")
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    root = Path(tempfile.mkdtemp(prefix="bench_study_"))
    figures: dict[str, Any] = {}
    try:
        if asked.scale:
            (root / "scale").mkdir()
            figures["scale"] = scale(root / "scale", asked.scale)
        else:
            plans = []
            for workers in map(int, asked.workers.split(",")):
                folder = root / str(workers)
                folder.mkdir()
                plan, figures[f"workers_{workers}"] = run(folder, asked.cases, asked.seconds, workers, asked.keep)
                plans.append(plan)
            if len(plans) > 1:
                figures["identical"] = same(plans)
    finally:
        shutil.rmtree(root)
    if asked.json:
        print(json.dumps(figures))
        return
    for name, value_or_table in figures.items():
        print(name if isinstance(value_or_table, dict) else f"{name}: {value_or_table}")
        for key, value in value_or_table.items() if isinstance(value_or_table, dict) else ():
            print(f"  {key:<24} {value:.6g}")


if __name__ == "__main__":
    main()
