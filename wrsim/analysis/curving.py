"""Curving: a wheelset runs along the track at constant speed, from an equilibrium start."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from wrsim.analysis.contacts import contact_models
from wrsim.analysis.derailment import DerailmentWatch
from wrsim.analysis.equilibrium import start_state
from wrsim.analysis.motion_result import result_of
from wrsim.simulation.integrate import integrate
from wrsim.simulation.step import SAFETY, round_step, stable_step
from wrsim.simulation.system import RigidBody, System
from wrsim.simulation.wheelset_law import WheelsetOnTrack

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.scenario.build import Setup


def run_curving(setup: Setup, progress: Callable[[float, float], None] | None = None) -> Result:
    """Integrate from the start to the end of the run; a run that has to stop returns what it has."""
    plan = setup.run
    law = WheelsetOnTrack(setup.wheelset, setup.track, contact_models(setup), speed=plan.speed, start=plan.start)
    q, q_t = start_state(setup, law)
    system = System([RigidBody.of(setup.wheelset)], law)
    step = plan.step if plan.step is not None else round_step(SAFETY * stable_step(system, q, q_t))
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
