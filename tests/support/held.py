"""Steady motion of a single wheelset with some of its coordinates held, which no analysis asks for."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.newton import damped_newton
from wrsim.simulation.steady_state import TOLERANCE, Equilibrium, SteadyMotion, lower_on_rails
from wrsim.simulation.system import COORDINATES

Array = NDArray[np.float64]


def held_state(
    law: VehicleOnTrack, q: Array, q_t: Array, unknowns: Sequence[str], equations: Sequence[str] = ()
) -> Equilibrium:
    """The steady motion near (q, q_t) in the unknown coordinates, all others held; "spin" stands for the spin rate.

    equations: coordinates whose forces vanish, by default those of the unknowns."""
    law.set_search_start(law.start)
    steady = SteadyMotion(law)
    if "roll" in unknowns:
        q, q_t = lower_on_rails(law, q, q_t)
    columns = [COORDINATES.index(name) for name in unknowns]
    rows = [COORDINATES.index(name) for name in equations or unknowns]
    x = steady.unknowns(q, q_t)

    def residual(part: Array) -> Array:
        x[columns] = part
        return steady.residual(x)[rows]

    x[columns], left, _ = damped_newton(residual, x[columns].copy(), steady.small[columns], 1e-10, 60)
    assert np.abs(left).max() <= TOLERANCE, left
    return Equilibrium(*steady.state(x), float(np.abs(left).max()))
