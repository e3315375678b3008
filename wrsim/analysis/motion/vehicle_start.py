"""The force law of a whole vehicle from a set-up, and the steady motion that its run starts from."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.contacts import contact_models
from wrsim.analysis.motion.vehicle_run_in import run_in
from wrsim.errors import SimulationError
from wrsim.simulation.equilibrium import Equilibrium
from wrsim.simulation.vehicle_law import VehicleOnTrack
from wrsim.simulation.vehicle_state import design_state, lower_on_rails, steady_state

if TYPE_CHECKING:
    from wrsim.scenario.build import Setup
    from wrsim.simulation.system import Array
    from wrsim.vehicle.vehicle import Drive

SHIFTS = (0.0, 6e-3)
"""Outward shifts of the wheelsets from which the search for steady motion in a curve begins [m]."""


STEADY_ENOUGH = 1e-3
"""Unbalanced part of the weight with which a run may start after running in: patches that appear and vanish let forces
jump, and a balance may lie inside of the jump."""


def vehicle_law(setup: Setup, speed: float | None = None, drive: Drive | None = None) -> VehicleOnTrack:
    """The law of the set-up's vehicle on its track; speed and drive, where given, in the place of the run's.

    Raises ValueError for the set-up of a lone wheelset.
    """
    vehicle, run = setup.vehicle, setup.run
    if vehicle is None:
        raise ValueError("the set-up has no whole vehicle")
    contacts = [contact_models(replace(setup, wheelset=mounted.wheelset)) for mounted in vehicle.wheelsets]
    return VehicleOnTrack(
        vehicle,
        setup.track,
        contacts,
        speed=run.speed if speed is None else speed,
        start=run.start,
        drive=run.drive if drive is None else drive,
    )


def vehicle_start(setup: Setup, law: VehicleOnTrack) -> tuple[Array, Array]:
    """State (q, q_t) from which a run starts: steady motion in the track as it is at the start, held by a pull.

    In a curve the search begins from shifts further and further outward; what is not found so is run in from straight
    track. Raises SimulationError when there is no steady motion.
    """
    run = setup.run
    curvature = float(setup.track.curvature(run.start))
    held = law if law.drive == "train" else vehicle_law(setup, law.speed, "train")
    problem = None
    for shift in SHIFTS if curvature != 0.0 else SHIFTS[:1]:
        q, q_t = design_state(held, run.start, lateral=-np.copysign(shift, curvature))
        try:
            held.look_near(run.start)
            lower_on_rails(held, q, q_t)
            return _started(law, run.start, steady_state(held, run.start, (q, q_t)))
        except SimulationError as error:
            problem = problem or error
    if curvature != 0.0:
        try:
            guess = run_in(setup, lambda there: vehicle_law(there, law.speed, "train"), vehicle_start)
            return _started(law, run.start, steady_state(held, run.start, guess, enough=STEADY_ENOUGH))
        except SimulationError as error:
            problem = error
    advice = "" if curvature == 0.0 else " Start the run before the curve to see what becomes of it."
    raise SimulationError(
        f"the run has no steady motion to start from at {run.start:g} m and {3.6 * law.speed:g} km/h: "
        f"{problem}.{advice}"
    )


def _started(law: VehicleOnTrack, start: float, found: Equilibrium) -> tuple[Array, Array]:
    """The state found, the law told where to look for it."""
    law.look_near(start)
    return found.q, found.q_t
