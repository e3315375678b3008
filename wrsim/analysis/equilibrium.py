"""Equilibrium: a wheelset at rest on its track."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.contacts import contact_models
from wrsim.analysis.motion_result import result_of
from wrsim.analysis.start import EXACT, PLAY
from wrsim.errors import SimulationError
from wrsim.simulation.equilibrium import Equilibrium, find_equilibrium
from wrsim.simulation.half_space_law import HalfSpaceOnTrack
from wrsim.simulation.integrate import Motion
from wrsim.simulation.placement import place_on_track
from wrsim.simulation.wheelset_law import WheelsetOnTrack

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.scenario.build import Setup

REST = ("z", "x", "y", "heading", "roll")


def standing(setup: Setup, law: WheelsetOnTrack) -> Equilibrium:
    """The wheelset at rest at the start of the run: height, lateral shift, yaw and roll without any force left.

    At rest there is no rolling, so the creep forces say nothing and friction holds the wheelset wherever it is put;
    the equilibrium asked for is the one that needs no friction.
    """
    run, wheelset = setup.run, setup.wheelset
    cant = float(setup.track.cant(run.start))
    play = PLAY + 0.5 * max(float(setup.track.gauge(run.start)) - setup.track.nominal_gauge, 0.0)
    # on canted track it slides down until springs or flange hold it: look for it further and further down
    shifts = np.copysign(np.arange(0.0, play, 1e-3), cant) if cant != 0.0 else np.zeros(1)
    problems = []
    for lateral in shifts:
        q, q_t = place_on_track(
            setup.track.centre,
            run.start,
            speed=0.0,
            height=wheelset.mean_radius,
            spin_rate=0.0,
            lateral=float(lateral),
        )
        try:
            return find_equilibrium(law, q, q_t, REST, weight=wheelset.static_axle_load)
        except SimulationError as error:
            problems.append(error)
    raise problems[0]


def run_equilibrium(setup: Setup, progress: Callable[[float, float], None] | None = None) -> Result:
    """Find the rest state; the result holds that one sample, at time 0."""
    fast = replace(setup, contact=setup.contact.fast())
    law = WheelsetOnTrack(setup.wheelset, setup.track, contact_models(fast), speed=0.0, start=setup.run.start)
    found = standing(fast, law)
    if setup.contact.normal == "half-space":
        law = HalfSpaceOnTrack(setup.wheelset, setup.track, contact_models(setup), speed=0.0, start=setup.run.start)
        weight = setup.wheelset.static_axle_load
        found = find_equilibrium(law, found.q, found.q_t, REST, weight=weight, tolerance=EXACT)
    if progress is not None:
        progress(1.0, 0.0)
    rest = Motion(np.zeros(1), found.q[None], found.q_t[None], 0.0, "completed")
    return result_of(replace(setup, run=replace(setup.run, speed=0.0, patches_at=(setup.run.start,))), law, rest)
