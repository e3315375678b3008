"""The integration of a run as its plan wants it, of a wheelset and of a whole vehicle alike."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing, nullcontext
from typing import TYPE_CHECKING, Protocol

from wrsim.simulation.integrate import Motion, integrate

if TYPE_CHECKING:
    from wrsim.analysis.motion.keeping import Keeping
    from wrsim.scenario.build import RunPlan
    from wrsim.simulation.system import Array, System


class Watch(Protocol):
    """Looks at the state every ``interval`` [s] and says why the run has to end, if so."""

    interval: float

    def __call__(self, t: float, q: Array, q_t: Array) -> str | None:
        """The reason to end, or None."""


def run_motion(
    plan: RunPlan,
    system: System,
    q: Array,
    q_t: Array,
    step: float,
    watch: Watch,
    progress: Callable[[float, float], None] | None,
    keeping: Keeping | None,
) -> Motion:
    """Integrate from the state (q, q_t) to the end of the plan; ``keeping`` is the file that keeps it meanwhile."""
    with nullcontext() if keeping is None else closing(keeping.tape(step, system.size)) as tape:
        return integrate(
            system,
            q,
            q_t,
            # whole steps, so that the run does not pass the end of the track
            duration=step * max(1, int(plan.duration / step + 1e-6)),
            step=step,
            sample_interval=plan.output_interval,
            monitor=watch,
            monitor_interval=watch.interval,
            progress=progress,
            tape=tape,
        )
