"""What wear costs: in a run, and one step of wheels in service. Run: python benchmarks/bench_wear.py [--json]

A run of the coach through scenarios/manchester_r300.toml, with strips, without wear and with all three laws: the whole
of `wrsim.run`, from the start to the result. Then the first step of the services in scenarios/wear, case after case in
one process: looks at the profile and what lies between them. Processor time on one core, minimum of the repetitions;
the first of them, which may compile, does not count.
"""

import argparse
import json
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import blas_threads  # noqa: F401 (before numpy)

from wrsim import load, run
from wrsim.results import write_atomically
from wrsim.results.files import digest_of
from wrsim.study.evolution.reading import read_evolution
from wrsim.study.evolution.stages import STAGES
from wrsim.study.evolution.steps import wear_steps
from wrsim.study.plan import PLAN, Plan
from wrsim.study.task import run_case

ROOT = Path(__file__).parents[1]
SERVICES = ("service", "coach_service")
LAWS = ["usfd", "archard", "brr"]


def best(work: Callable[[], object], repetitions: int) -> float:
    """Least processor time of the work [s]."""
    work()
    durations = []
    for _ in range(repetitions):
        began = time.process_time()
        work()
        durations.append(time.process_time() - began)
    return min(durations)


def of_run(repetitions: int) -> dict[str, float]:
    """A run without wear and with it."""
    plain = load(ROOT / "scenarios/manchester_r300.toml")
    worn = plain.with_values({"wear.laws": LAWS})
    without, with_wear = (best(lambda scenario=scenario: run(scenario), repetitions) for scenario in (plain, worn))
    return {"run_s": without, "run_with_wear_s": with_wear, "ratio": with_wear / without}


def of_step(name: str) -> dict[str, float]:
    """The first step of a service."""
    evolution, _ = read_evolution(ROOT / "scenarios/wear" / f"{name}.toml")
    spent = [0.0]

    def work(plan: Plan, todo: Sequence[int]) -> None:
        began = time.process_time()
        write_atomically(Path(plan.folder) / PLAN, plan.dumped())
        for index in todo:
            run_case(plan.folder, digest_of(plan.dumped()), index)
        spent[0] += time.process_time() - began

    with TemporaryDirectory() as folder:
        for number in range(2):  # the first compiles
            fresh = replace(evolution, digest=f"{number}")
            spent[0], began = 0.0, time.process_time()
            next(wear_steps(fresh, Path(folder) / str(number), work))
            whole = time.process_time() - began
    cases = STAGES * len(evolution.shares)
    return {"step_s": whole, "cases": cases, "case_s": spent[0] / cases, "between_s": whole - spent[0]}


def main() -> None:
    """Print the figures, or one line of JSON."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", action="store_true", help="the last line is JSON")
    parser.add_argument("--repetitions", type=int, default=2)
    parser.add_argument("--services", nargs="*", choices=SERVICES, default=list(SERVICES))
    chosen = parser.parse_args()
    table: dict[str, Any] = {"run": of_run(chosen.repetitions)}
    table |= {name: of_step(name) for name in chosen.services}
    for name, row in table.items():
        print(f"{name}: " + ", ".join(f"{key} {value:.3g}" for key, value in row.items()), flush=True)
    print(json.dumps({"wear": table}) if chosen.json else "")


if __name__ == "__main__":
    main()
