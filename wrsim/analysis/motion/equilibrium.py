"""Equilibrium: a wheelset at rest on its track."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.contacts import contact_models
from wrsim.analysis.motion.motion_result import result_of
from wrsim.analysis.motion.standing import REST, standing
from wrsim.analysis.motion.start import EXACT
from wrsim.analysis.motion.vehicle_equilibrium import run_vehicle_equilibrium
from wrsim.simulation.equilibrium import find_equilibrium
from wrsim.simulation.half_space_law import HalfSpaceOnTrack
from wrsim.simulation.integrate import Motion
from wrsim.simulation.wheelset_law import WheelsetOnTrack

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.scenario.build import Setup


def run_equilibrium(setup: Setup, progress: Callable[[float, float], None] | None = None) -> Result:
    """Find the rest state; the result holds that one sample, at time 0."""
    if setup.vehicle is not None:
        return run_vehicle_equilibrium(setup, progress)
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
