"""Curving: a wheelset (a vehicle: ``vehicle_curving``) runs along the track at constant speed, from equilibrium."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.contacts import contact_models
from wrsim.analysis.motion.derailment import DerailmentWatch
from wrsim.analysis.motion.motion_result import result_of
from wrsim.analysis.motion.run_motion import run_motion
from wrsim.analysis.motion.start import exact_start, start_state
from wrsim.analysis.motion.step_choice import allowed_step
from wrsim.analysis.motion.vehicle_curving import recorded_vehicle_curving, run_vehicle_curving
from wrsim.geometry.track.segments import Straight
from wrsim.simulation.half_space_law import HalfSpaceOnTrack
from wrsim.simulation.integrate import recorded_motion
from wrsim.simulation.step import SAFETY, round_step, stable_step
from wrsim.simulation.system import RigidBody, System
from wrsim.simulation.wheelset_law import WheelsetOnTrack

if TYPE_CHECKING:
    from wrsim.analysis.motion.keeping import Keeping
    from wrsim.results import Result
    from wrsim.scenario.build import Setup
    from wrsim.simulation.system import Array


def run_curving(
    setup: Setup,
    progress: Callable[[float, float], None] | None = None,
    keeping: Keeping | None = None,
) -> Result:
    """Integrate from the start to the end of the run; a run that has to stop returns what it has.

    keeping: the file in which the run is kept while it lasts, and from which it may go on.
    """
    if setup.vehicle is not None:
        return run_vehicle_curving(setup, progress, keeping)
    law = _law(setup)
    system = System([RigidBody.of(setup.wheelset)], law)
    if keeping is not None and keeping.resume:
        step = keeping.recorded_step()
        q = q_t = np.zeros(system.size)  # the file knows better
    else:
        q, q_t, step = _start(setup, law, system)
    watch = DerailmentWatch(setup, law)
    motion = run_motion(setup.run, system, q, q_t, step, watch, progress, keeping)
    return result_of(setup, law, motion)


def recorded_curving(setup: Setup, path: Path) -> Result:
    """The result of what a file holds of a run; the process that ran it may be dead or still at work."""
    if setup.vehicle is not None:
        return recorded_vehicle_curving(setup, path)
    return result_of(setup, _law(setup), recorded_motion(path))


def _law(setup: Setup) -> WheelsetOnTrack:
    run = setup.run
    kind = HalfSpaceOnTrack if setup.contact.normal == "half-space" else WheelsetOnTrack
    return kind(setup.wheelset, setup.track, contact_models(setup), speed=run.speed, start=run.start)


def _start(setup: Setup, law: WheelsetOnTrack, system: System) -> tuple[Array, Array, float]:
    """State (q, q_t) and step of a run. The exact contact solver takes the step that is stable with a fast model."""
    near = replace(setup, contact=setup.contact.fast())
    if near.contact == setup.contact:
        q, q_t = start_state(setup, law)
        return q, q_t, chosen_step(setup, system, q, q_t)
    fast = _law(near)
    q, q_t = start_state(near, fast)
    step = chosen_step(near, System([RigidBody.of(setup.wheelset)], fast), q, q_t)
    return *exact_start(setup, law, q, q_t), step


def chosen_step(setup: Setup, system: System, q: Array, q_t: Array) -> float:
    """Step [s] that the plan asks for, or one that is stable at the start (q, q_t) of the run and on straight track.

    It is never longer than the time between two samples.

    In a curve the creep forces are near saturation and allow a longer step than they do on straight track, so a run
    that starts in a curve must not rely on its start.
    Raises StepTooLong for a step asked for that is not even stable at the start: its results would look like results.
    """
    limit = stable_step(system, q, q_t)
    if setup.run.step is not None:
        return allowed_step(setup.run.step, limit, setup.run.speed)
    if setup.track.curvature(setup.run.start) != 0.0:
        level = replace(setup, track=setup.track.relaid([Straight(100.0)]), run=replace(setup.run, start=0.0))
        law = WheelsetOnTrack(level.wheelset, level.track, contact_models(level), speed=level.run.speed)
        limit = min(limit, stable_step(System([RigidBody.of(level.wheelset)], law), *start_state(level, law)))
    return round_step(min(SAFETY * limit, setup.run.output_interval))
