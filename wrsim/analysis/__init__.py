"""Analyses: from a scenario to a result.

``run(scenario) -> Result`` in one call; ``wrsim.register`` lists which function runs which analysis.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wrsim.analysis.progress import Progress
from wrsim.analysis.run_times import SPREAD, forecast
from wrsim.errors import InputError
from wrsim.inputs.file_kinds import resolved
from wrsim.register import ANALYSES
from wrsim.results.table import duration
from wrsim.scenario.build import Setup, build
from wrsim.scenario.loading import Scenario, loaded
from wrsim.scenario.plausibility import warnings
from wrsim.simulation.step_size import StepTooLong, evaluations_for
from wrsim.timing import timed

if TYPE_CHECKING:
    from wrsim.results import Result

MANY = 3  # vehicles whose contacts take all cores unless threads are given


def _usual_threads(setup: Setup) -> int:
    """How many compute the contacts of this vehicle or train: one also where there is no OpenMP."""
    from wrsim.jit.compiling import cores, use_threads

    if sum(bool(unit.parts) for unit in setup.vehicle.units) < MANY:
        return 1
    try:
        use_threads(cores())
    except InputError:
        return 1
    return cores()


def run(
    scenario: Scenario | str | Path,
    progress: Progress | None = None,
    *,
    record: str | Path | None = None,
    resume: bool = False,
    setup: Setup | None = None,
    threads: int | None = None,
) -> Result:
    """Run what a scenario asks for.

    Parameters
    ----------
    scenario : Scenario, str or Path
        From `load`, perhaps changed by `Scenario.with_values`; or its file.
    progress : callable, optional
        Called some ten times a second with the fraction done and the seconds left.
    record : str or Path, optional
        A file in which a run along the track is stored while it lasts, so that nothing is lost with its process; delete
        it when the result is safe. Other analyses keep nothing.
    resume : bool
        Go on with the run in that file, with the same numbers as if it had never been interrupted.
    setup : Setup, optional
        What was built from this scenario, if it has been; without it, implausible values are logged as warnings.
    threads : int, optional
        How many compute the contacts of a vehicle's wheels side by side, which changes no number. Default all cores for
        trains of three vehicles and more, else one.

    Returns
    -------
    Result
        A run that has to stop (derailment, Ctrl-C, not-a-number) returns what it computed; ``result.status`` and
        ``result.stop_reason`` give the reason.

    Raises
    ------
    InputError
        When the scenario's parts do not fit together, when there is no run of this scenario to go on with, or for more
        threads than the machine has cores.
    SimulationError
        When there is not even a start.
    """
    from wrsim.analysis.motion.record import RunRecord

    scenario = loaded(scenario)
    if setup is None:
        setup = build(scenario)
        for warning in (*warnings(setup), *exact_run_warning(setup)):
            logging.getLogger(__name__).warning("%s: %s", scenario.path or scenario.title, warning)
    setup = replace(setup, threads=_usual_threads(setup) if threads is None else threads)
    analysis = ANALYSES[setup.analysis]
    function = resolved(analysis.run)
    if not analysis.moves:
        if resume:
            raise scenario.fault(("analysis",), "cannot be resumed; run it without --resume")
        with timed(f"analysis {analysis.name}"):
            return function(setup, progress)  # type: ignore[no-any-return]
    run_record = None if record is None else RunRecord.of(scenario, setup, Path(record), resume)
    with _naming_step(scenario):
        return function(setup, progress, run_record)  # type: ignore[no-any-return]


def check_step(scenario: Scenario, setup: Setup[Any]) -> None:
    """Raise InputError for a time step in a scenario that ``run`` would refuse at the start of its set-up's run."""
    from wrsim.analysis.motion.run import refuse_step

    with _naming_step(scenario):
        refuse_step(setup)


EXACT_TIME = 0.06  # of the exact solver, both wheels together, with creep forces [s]


def exact_run_warning(setup: Setup[Any]) -> list[str]:
    """A warning of a run whose forces all come from the exact contact solver; none of others."""
    if setup.contact.normal != "half-space" or not ANALYSES[setup.analysis].moves:
        return []
    cost, fast = cost_of(setup), ""
    if setup.plan.fast_channels:
        without = cost_of(replace(setup, plan=replace(setup.plan, fast_channels=(), fast_interval=None)))
        fast = f" (without run.fast_channels {between(without['expected_range_s'])})"
    return [
        'contact.normal = "half-space" solves the exact problem at every stage of the integration and in every sample: '
        f"about {cost['evaluations']} times for each wheel, {between(cost['expected_range_s'])}{fast}. "
        "wrsim resolve does it for the snapshots of a fast run"
    ]


def between(times: Sequence[float]) -> str:
    """A range of times [s] in words."""
    return " to ".join(map(duration, times))


EVALUATION_TIME = {"strips": 0.7e-3, "kik-piotrowski": 0.3e-3, "half-space": EXACT_TIME}
"""Time of one evaluation of the contacts of a wheelset and its share of the vehicle [s], measured on one core of a
common processor; another one takes half of it or twice."""


def cost_of(setup: Setup[Any]) -> dict[str, Any]:
    """Evaluations of the forces that a run along the track and its samples need, its time [s], the range in which that
    lies and from where it is known; of other analyses nothing."""
    if not ANALYSES[setup.analysis].moves:
        return {}
    plan = setup.plan
    evaluations = evaluations_for(
        plan.integrator, plan.duration, plan.speeds[0], plan.recorded_interval, plan.step, setup.vehicle
    )
    evaluations += sum(plan.duration / each for each in (plan.output_interval, plan.fast_interval) if each)
    each = EVALUATION_TIME[setup.contact.normal] * len(setup.vehicle.wheelsets)
    expected, source = forecast(setup.contact.normal, each * evaluations)
    low, middle, high = (float(f"{expected * factor:.2g}") for factor in (1.0 / SPREAD, 1.0, SPREAD))
    about = {"expected_range_s": [low, high], "expected_by": source}
    return {"evaluations": round(evaluations), "expected_time_s": middle, **about}


@contextmanager
def _naming_step(scenario: Scenario) -> Iterator[None]:
    """Give a step that is too long its file and the line of its key, which are known only here."""
    try:
        yield
    except StepTooLong as fault:
        raise scenario.fault(("run", "step_us"), fault.rule) from None


def recorded(record: str | Path) -> Result:
    """The result of what a file holds of a run that was cut off, or that is still under way.

    Raises InputError when there is no such file, it is none of a run, or its models are gone or have changed.
    """
    from wrsim.analysis.motion.record import recorded_setup

    setup = recorded_setup(Path(record))
    if not ANALYSES[setup.analysis].moves:
        raise InputError(f"{record}: analysis = {setup.analysis!r} in its scenario is no run along the track")
    return resolved(ANALYSES[setup.analysis].recorded)(setup, Path(record))  # type: ignore[no-any-return]


__all__ = ["between", "check_step", "cost_of", "exact_run_warning", "recorded", "run"]
