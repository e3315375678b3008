"""Curving of a whole vehicle: time integration at speed, from steady motion at the start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.motion.run_motion import run_motion
from wrsim.analysis.motion.step_choice import allowed_step
from wrsim.analysis.motion.vehicle_result import vehicle_result
from wrsim.analysis.motion.vehicle_start import vehicle_law, vehicle_start
from wrsim.analysis.motion.vehicle_watch import VehicleWatch
from wrsim.geometry.track.segments import Straight
from wrsim.simulation.integrate import recorded_motion
from wrsim.simulation.step import LARGEST_STEP, LARGEST_VEHICLE_STEP, SAFETY, round_step, stable_step
from wrsim.simulation.system import System

if TYPE_CHECKING:
    from wrsim.analysis.motion.keeping import Keeping
    from wrsim.results import Result
    from wrsim.scenario.build import Setup
    from wrsim.simulation.system import Array


def run_vehicle_curving(
    setup: Setup,
    progress: Callable[[float, float], None] | None = None,
    keeping: Keeping | None = None,
) -> Result:
    """Integrate from the start to the end of the run; a run that has to stop returns what it has.

    keeping: the file in which the run is kept while it lasts, and from which it may go on.
    """
    law = vehicle_law(setup)
    system = System(law.bodies, law, law.dampers)
    if keeping is not None and keeping.resume:
        step = keeping.recorded_step()
        q = q_t = np.zeros(system.size)  # the file knows better
    else:
        q, q_t = vehicle_start(setup, law)
        step = vehicle_step(setup, system, q, q_t)
    watch = VehicleWatch(setup, law)
    motion = run_motion(setup.run, system, q, q_t, step, watch, progress, keeping)
    return vehicle_result(setup, law, motion, watch.events())


def recorded_vehicle_curving(setup: Setup, path: Path) -> Result:
    """The result of what a file holds of a run; the process that ran it may be dead or still at work."""
    law = vehicle_law(setup)
    motion = recorded_motion(path)
    watch = VehicleWatch(setup, law)
    for t, q, q_t in zip(motion.times, motion.q, motion.q_t, strict=True):
        watch(t, q, q_t)
    return vehicle_result(setup, vehicle_law(setup), motion, watch.events())


def vehicle_step(setup: Setup, system: System, q: Array, q_t: Array) -> float:
    """Step [s] that the plan asks for, or one that is stable at the start (q, q_t) of the run and on straight track.

    As ``analysis.motion.curving.chosen_step``. Raises StepTooLong for a step asked for that is not stable at the start.
    """
    plan = setup.run
    limit = stable_step(system, q, q_t)
    if plan.step is not None:
        return allowed_step(plan.step, limit, plan.speed)
    if setup.track.curvature(plan.start) != 0.0:
        level = replace(setup, track=setup.track.relaid([Straight(100.0)]), run=replace(plan, start=30.0))
        law = vehicle_law(level)
        limit = min(limit, stable_step(System(law.bodies, law, law.dampers), *vehicle_start(level, law)))
    largest = LARGEST_STEP if setup.track.is_uneven else LARGEST_VEHICLE_STEP
    return round_step(min(SAFETY * limit, plan.output_interval), largest)
