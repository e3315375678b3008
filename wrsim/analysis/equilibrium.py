"""Equilibrium: a wheelset at rest on its track, and the steady rolling state that a run starts from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.contacts import contact_models
from wrsim.analysis.motion_result import result_of
from wrsim.errors import SimulationError
from wrsim.simulation.equilibrium import Equilibrium, find_equilibrium
from wrsim.simulation.integrate import Motion
from wrsim.simulation.placement import place_on_track
from wrsim.simulation.steady import SteadyMotion
from wrsim.simulation.system import RigidBody
from wrsim.simulation.wheelset_law import WheelsetOnTrack

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.scenario.build import Setup
    from wrsim.simulation.system import Array

REST = ("z", "y", "heading", "roll")
ROLLING = ("z", "x", "y", "heading", "roll", "spin_rate")

PLAY = 12e-3
"""Farthest lateral shift at which the search for steady curving begins, more by half the gauge widening [m]."""


def standing(setup: Setup, law: WheelsetOnTrack) -> Equilibrium:
    """The wheelset at rest at the start of the run: height, lateral shift, yaw and roll without any force left.

    At rest there is no rolling, so the creep forces say nothing and friction holds the wheelset wherever it is put;
    the equilibrium asked for is the one that needs no friction.
    """
    q, q_t = place_on_track(
        setup.track.centre, setup.run.start, speed=0.0, height=setup.wheelset.mean_radius, spin_rate=0.0
    )
    return find_equilibrium(law, q, q_t, REST, weight=setup.wheelset.static_axle_load)


def start_state(setup: Setup, law: WheelsetOnTrack) -> tuple[Array, Array]:
    """State (q, q_t) from which a run starts: rolling steadily in the track as it is at the start, also in a curve.

    In a curve the search begins in the middle of the track and, as long as nothing is found, further and further
    outward: a wheelset held hard against yaw does not find its way to the outer rail by itself.
    Raises SimulationError when no start finds a balance.
    """
    speed, radius, start = setup.run.speed, setup.wheelset.mean_radius, setup.run.start
    centre, weight = setup.track.centre, setup.wheelset.static_axle_load
    steady = SteadyMotion(law, RigidBody.of(setup.wheelset), centre, speed=speed, distance=start)
    curvature = float(setup.track.curvature(start))
    yaw = -setup.wheelset.suspension.ahead_of_bogie_centre * curvature
    problem: SimulationError | None = None
    play = PLAY + 0.5 * max(float(setup.track.gauge(start)) - setup.track.nominal_gauge, 0.0)
    shifts = np.arange(0.0, play, 1e-3) if curvature != 0.0 else np.zeros(1)
    for lateral in -np.copysign(shifts, curvature):
        q, q_t = place_on_track(
            centre, start, speed=speed, height=radius, spin_rate=speed / radius, lateral=float(lateral), yaw=yaw
        )
        try:
            found = find_equilibrium(steady, q, q_t, ROLLING, weight=weight)
        except SimulationError as error:
            problem = problem or error
        else:
            return steady.state(found.q, found.q_t)
    assert problem is not None
    raise SimulationError(f"no steady motion to start from at {start:g} m and {speed:g} m/s: {problem}")


def run_equilibrium(setup: Setup, progress: Callable[[float, float], None] | None = None) -> Result:
    """Find the rest state; the result holds that one sample, at time 0."""
    law = WheelsetOnTrack(setup.wheelset, setup.track, contact_models(setup), speed=0.0, start=setup.run.start)
    found = standing(setup, law)
    if progress is not None:
        progress(1.0, 0.0)
    rest = Motion(np.zeros(1), found.q[None], found.q_t[None], 0.0, "completed")
    return result_of(replace(setup, run=replace(setup.run, speed=0.0, patches_at=(setup.run.start,))), law, rest)
