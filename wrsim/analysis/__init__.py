"""Analyses: from a scenario to a result.

``run(scenario) -> Result`` in one call; each kind of analysis has a module of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from wrsim.analysis.curving import StepTooLong, run_curving
from wrsim.analysis.equilibrium import run_equilibrium
from wrsim.analysis.static import run_static
from wrsim.scenario.build import build

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.scenario.loading import Scenario

Progress = Callable[[float, float], None]
"""progress(fraction done, seconds left)"""

_ANALYSES = {"static": run_static, "equilibrium": run_equilibrium, "curving": run_curving}


def run(scenario: Scenario, progress: Progress | None = None) -> Result:
    """Run what the scenario asks for.

    progress: called some ten times a second with the fraction done and the seconds left. A run that has to stop
    (derailment, Ctrl-C, not-a-number) returns what it computed; ``result.status`` and ``result.stop_reason`` say so.
    Raises InputError when the scenario's parts do not fit together, SimulationError when there is not even a start.
    """
    setup = build(scenario)
    if setup.contact.normal == "half-space" and setup.analysis != "static":
        raise scenario.fault(("contact", "normal"), 'is for analysis = "static" only')
    try:
        return _ANALYSES[setup.analysis](setup, progress)
    except StepTooLong as fault:
        # only here are the file and the line of the key known
        raise scenario.fault(("run", "step_us"), fault.rule) from None


__all__ = ["run"]
