"""A lone wheelset at rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.motion.start import PLAY
from wrsim.errors import SimulationError
from wrsim.simulation.equilibrium import Equilibrium, find_equilibrium
from wrsim.simulation.placement import place_on_track
from wrsim.simulation.wheelset_law import WheelsetOnTrack

if TYPE_CHECKING:
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
