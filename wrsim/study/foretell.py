"""How long the cases of a study will take."""

from __future__ import annotations

import time
from collections.abc import Sequence

from wrsim.analysis import run
from wrsim.errors import WrsimError
from wrsim.scenario.loading import Scenario
from wrsim.study.engine import kinds
from wrsim.study.plan import Plan
from wrsim.study.task import COMPLETED, Marker, compile_for

PROBES = 3
"""Cases that are tried, spread over the study."""
PROBE = 2.0
"""How long each is tried [s]."""


class _Seen(Exception):
    """Enough of a case has been seen."""


def time_of_cases(plan: Plan, todo: Sequence[int], markers: Sequence[Marker | None]) -> tuple[float, str]:
    """Time of one case [s], and from where that is known: from cases that are done, or from the starts of a few."""
    known = [m.wall_time for m in markers if m is not None and m.status == COMPLETED and not m.resumed]
    if known:
        return sum(known) / len(known), f"mean of the {len(known)} that are done"
    if not todo:
        return 0.0, "nothing is left"
    for i in kinds(plan, todo):
        compile_for(plan.scenario(plan.cases[i]))
    tried = list(dict.fromkeys(todo[(len(todo) - 1) * k // max(PROBES - 1, 1)] for k in range(PROBES)))
    times = [time_of(plan.scenario(plan.cases[i])) for i in tried]
    return sum(times) / len(times), f"foretold from the first seconds of {len(times)} of them"


def time_of(scenario: Scenario) -> float:
    """Time that a case takes [s], from its first seconds."""
    begin = time.perf_counter()
    seen: list[tuple[float, float]] = []

    def progress(fraction: float, seconds_left: float) -> None:
        seen.append((fraction, time.perf_counter()))
        if seen[-1][1] - seen[0][1] > PROBE:
            raise _Seen

    try:
        run(scenario, progress)
    except _Seen:
        (first, start), (last, now) = seen[0], seen[-1]
        return now - begin + (1.0 - last) * (now - start) / max(last - first, 1e-9)
    except WrsimError:
        pass  # it fails as fast in the study
    return time.perf_counter() - begin
