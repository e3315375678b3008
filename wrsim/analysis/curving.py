"""Curving: a wheelset runs along the track at constant speed, from an equilibrium start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from wrsim.analysis.contacts import contact_models
from wrsim.analysis.derailment import DerailmentWatch
from wrsim.analysis.motion_result import result_of
from wrsim.analysis.start import start_state
from wrsim.errors import InputError
from wrsim.geometry.segments import Straight
from wrsim.simulation.integrate import integrate
from wrsim.simulation.step import SAFETY, round_step, stable_step
from wrsim.simulation.system import RigidBody, System
from wrsim.simulation.wheelset_law import WheelsetOnTrack

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.scenario.build import Setup
    from wrsim.simulation.system import Array


class StepTooLong(InputError):
    """The step asked for is not stable. ``rule`` says what is allowed, without file and key."""

    def __init__(self, step: float, rule: str) -> None:
        super().__init__(f"run.step_us = {1e6 * step:g}: {rule}")
        self.rule = rule


def run_curving(setup: Setup, progress: Callable[[float, float], None] | None = None) -> Result:
    """Integrate from the start to the end of the run; a run that has to stop returns what it has."""
    plan = setup.run
    law = WheelsetOnTrack(setup.wheelset, setup.track, contact_models(setup), speed=plan.speed, start=plan.start)
    q, q_t = start_state(setup, law)
    system = System([RigidBody.of(setup.wheelset)], law)
    step = chosen_step(setup, system, q, q_t)
    watch = DerailmentWatch(setup, law)
    motion = integrate(
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
    )
    return result_of(setup, law, motion)


def chosen_step(setup: Setup, system: System, q: Array, q_t: Array) -> float:
    """Step [s] that the plan asks for, or one that is stable at the start (q, q_t) of the run and on straight track.

    It is never longer than the time between two samples.

    In a curve the creep forces are near saturation and allow a longer step than they do on straight track, so a run
    that starts in a curve must not rely on its start.
    Raises StepTooLong for a step asked for that is not even stable at the start: its results would look like results.
    """
    limit = stable_step(system, q, q_t)
    if setup.run.step is not None:
        if setup.run.step > limit:
            raise StepTooLong(
                setup.run.step,
                f"must be at most {1e6 * limit:.0f}, where the integration becomes unstable at "
                f"{3.6 * setup.run.speed:g} km/h; without step_us a good one is chosen",
            )
        return setup.run.step
    if setup.track.curvature(setup.run.start) != 0.0:
        level = replace(setup, track=setup.track.relaid([Straight(100.0)]), run=replace(setup.run, start=0.0))
        law = WheelsetOnTrack(level.wheelset, level.track, contact_models(level), speed=level.run.speed)
        limit = min(limit, stable_step(System([RigidBody.of(level.wheelset)], law), *start_state(level, law)))
    return round_step(min(SAFETY * limit, setup.run.output_interval))
