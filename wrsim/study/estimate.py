"""How long the cases of a study will take."""

import time
from collections.abc import Sequence
from math import ceil
from typing import Any

from wrsim.analysis import between, cost_of, run
from wrsim.analysis.run_times import SPREAD
from wrsim.errors import WrsimError
from wrsim.register import ANALYSES
from wrsim.results.table import Column, Table
from wrsim.scenario.build import build
from wrsim.scenario.loading import Scenario
from wrsim.study.candidates import Candidates
from wrsim.study.collect import MOST_LISTED, markers_of
from wrsim.study.engine import kinds
from wrsim.study.plan import Plan
from wrsim.study.task import COMPLETED, Marker, StopCase, compile_for, missing
from wrsim.system import processors

PROBES = 3
"""Cases that are tried, spread over the study."""
PROBE = 2.0
"""How long each is tried [s]."""
START = 8.0
"""Until a worker's first case runs [s]: imports take 3.5 s of a processor, kernels from their cache some 4 s."""


def time_of_cases(plan: Plan, todo: Sequence[int], markers: Sequence[Marker]) -> tuple[float, str]:
    """Time of one case [s], and from where that is known: from cases that are done, or from the starts of a few."""
    known = [m.wall_time for m in markers if m.status == COMPLETED and not m.resumed]
    if known:
        return sum(known) / len(known), f"mean of the {len(known)} that are done"
    if not todo:
        return 0.0, "nothing is left"
    tried = list(dict.fromkeys(todo[(len(todo) - 1) * k // max(PROBES - 1, 1)] for k in range(PROBES)))
    if ANALYSES[plan.analysis].moves:  # their lengths tell it, and preparing a rail that changes takes half a minute
        costs = [cost_of(build(plan.scenario(plan.cases[i])))["expected_time_s"] for i in tried]
        return sum(costs) / len(costs), f"estimated from the lengths of {len(costs)} of them"
    for i in kinds(plan, todo):
        compile_for(plan.scenario(plan.cases[i]))
    times = [time_of(plan.scenario(plan.cases[i])) for i in tried]
    return sum(times) / len(times), f"estimated from the first seconds of {len(times)} of them"


def time_of(scenario: Scenario) -> float:
    """Time that a case takes [s], from its first seconds."""
    begin = time.perf_counter()
    seen: list[tuple[float, float]] = []

    def progress(fraction: float, seconds_left: float) -> None:
        seen.append((fraction, time.perf_counter()))
        if seen[-1][1] - seen[0][1] > PROBE:
            raise StopCase(fraction)

    try:
        run(scenario, progress, setup=build(scenario), threads=1)
    except StopCase:
        (first, start), (last, now) = seen[0], seen[-1]
        return now - begin + (1.0 - last) * (now - start) / max(last - first, 1e-9)
    except WrsimError:
        pass  # it fails as fast in the study
    return time.perf_counter() - begin


def estimated_cost(plan: Plan, workers: int | None) -> tuple[dict[str, Any], Table]:
    """What a study will take on so many workers, one a processor unless given.

    Plain numbers with units in the keys, of all cases; a table of the first cases and the time.
    """
    markers, todo = markers_of(plan), missing(plan)
    each, source = time_of_cases(plan, todo, markers)
    workers, count = workers or processors(), len(plan.cases)
    total = START + each * ceil(len(todo) / workers) if todo else 0.0
    pairs = list(zip(plan.cases, markers, strict=True))
    cases = [{"case": c.name, "label": c.label, "values": c.values, "status": m.status} for c, m in pairs]
    expected = {"of_one_case_s": each, "on_workers": workers, "of_all_s": total}
    notes = [f"... and {count - MOST_LISTED} more; --json lists all"] if count > MOST_LISTED else []
    notes.append(f"{count} cases, {len(todo)} to run")
    if todo:
        spread = 1.0 if any(m.status == COMPLETED and not m.resumed for m in markers) else SPREAD
        case_time, all_cases = (between(sorted({x / spread, x * spread})) for x in (each, total))
        notes.append(f"one case takes {case_time} ({source}); on {workers} workers the study takes {all_cases}")
    rows = [(c.name, c.label, m.status) for c, m in pairs[:MOST_LISTED]]
    table = Table(plan.title, (Column("case"), Column("values"), Column("state")), rows, tuple(notes))
    return {"cases": cases, "missing": len(todo), "time": expected}, table


def estimated_search(
    candidates: Candidates, count: int, at_once: int, alone: int, told: str, total_told: str
) -> tuple[dict[str, Any], Table]:
    """What a search will take: plain numbers with units in the keys; a table of the scenarios.

    count: of candidates, of which ``alone`` run one after the other, the others so many at once; told: a note on the
    candidates; total_told: a note on all of it, with {} for the time.
    """
    rows, total = [], START
    for scenario in candidates.scenarios:
        plan, _ = candidates.plan(scenario, [candidates.values(candidates.start)])
        each, source = time_of_cases(plan, missing(plan), markers_of(plan))
        rows.append((scenario.name, scenario.base.title, each, source))
        total += each * (alone + (count - alone) / at_once)
    heads = (Column("scenario"), Column("title"), Column("one case", "s", ".3g"), Column("from"))
    notes = (told, f"all of it takes {total_told.format(between([total / SPREAD, total * SPREAD]))}")
    numbers = {
        "candidates": count, "cases": len(rows) * count, "of_all_s": total,
        "of_one_case_s": {name: each for name, _, each, _ in rows},
    }  # fmt: skip
    return numbers, Table(candidates.title, heads, rows, notes)
