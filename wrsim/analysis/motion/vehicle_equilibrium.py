"""Equilibrium of a whole vehicle: at rest on its track, as `equilibrium` finds that of a lone wheelset."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.contacts import contact_models
from wrsim.analysis.motion.standing import standing
from wrsim.analysis.motion.vehicle_result import vehicle_result
from wrsim.analysis.motion.vehicle_start import vehicle_law
from wrsim.simulation.equilibrium import Equilibrium
from wrsim.simulation.integrate import Motion
from wrsim.simulation.vehicle_state import design_state, steady_state
from wrsim.simulation.wheelset_law import WheelsetOnTrack
from wrsim.vehicle.wheelset import SprungMass, Suspension

if TYPE_CHECKING:
    from wrsim.results import Result
    from wrsim.scenario.build import Setup
    from wrsim.simulation.system import Array
    from wrsim.simulation.vehicle_law import VehicleOnTrack
    from wrsim.vehicle.vehicle import Vehicle


ENOUGH = 1e-5
"""Force left over, as a part of the weight, that is accepted where patches that appear and vanish stop the search."""


def vehicle_at_rest(setup: Setup, law: VehicleOnTrack) -> Equilibrium:
    """The vehicle at rest at the start of the run, without friction: on canted track it has slid down to its flanges.

    Raises SimulationError when there is no such position.
    """
    start = setup.run.start
    q, q_t = design_state(law, start)
    law.look_near(start)
    for i in range(len(law.vehicle.wheelsets)):
        q[6 * i : 6 * i + 6] = _seat(setup, law, i)
    return steady_state(law, start, (q, q_t), enough=ENOUGH)


def _seat(setup: Setup, law: VehicleOnTrack, i: int) -> Array:
    """Coordinates (6,) of wheelset i at rest with its share of the vehicle on it, free of everything else."""
    vehicle, run = law.vehicle, setup.run
    mounted = vehicle.wheelsets[i]
    carried = (vehicle.mass - sum(m.mass for m in vehicle.wheelsets)) / len(vehicle.wheelsets)
    lone = replace(mounted.wheelset, suspension=Suspension(), sprung=SprungMass(carried, _height(vehicle)))
    there = replace(setup, wheelset=lone, vehicle=None, run=replace(run, start=run.start + mounted.x))
    own = WheelsetOnTrack(lone, setup.track, contact_models(there), speed=0.0, start=there.run.start)
    return standing(there, own).q


def _height(vehicle: Vehicle) -> float:
    """Height of what the wheelsets carry above their axles [m]."""
    mass = sum(body.mass for body in vehicle.bodies)
    axles = float(np.mean([mounted.height for mounted in vehicle.wheelsets]))
    return sum(body.mass * body.centre[2] for body in vehicle.bodies) / mass - axles if mass > 0.0 else 0.0


def run_vehicle_equilibrium(setup: Setup, progress: Callable[[float, float], None] | None = None) -> Result:
    """Find the rest state; the result holds that one sample, at time 0."""
    law = vehicle_law(setup, speed=0.0, drive="train")
    found = vehicle_at_rest(setup, law)
    if progress is not None:
        progress(1.0, 0.0)
    rest = Motion(np.zeros(1), found.q[None], found.q_t[None], 0.0, "completed")
    return vehicle_result(replace(setup, run=replace(setup.run, patches_at=(setup.run.start,))), law, rest, [])
