"""A vehicle at rest and in steady motion: weight, symmetry, load transfer."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.vehicles import manchester, on_track
from wrsim.core.layout import FORCE_B
from wrsim.simulation.vehicle_law import VehicleOnTrack
from wrsim.simulation.vehicle_state import steady_state


def wheel_loads(law: VehicleOnTrack) -> np.ndarray:
    """Vertical force of every wheel on its rail (wheelsets, 2) at the state asked for last [N]."""
    return np.array([[wheel.model.arrays.total[FORCE_B] for wheel in pair] for pair in law.wheels])


def test_mass_and_centre_are_the_sum_of_the_bodies() -> None:
    vehicle = manchester()
    assert vehicle.mass == 4 * 1813 + 2 * 2615 + 32000
    height = (4 * 1813 * 0.46 + 2 * 2615 * 0.6 + 32000 * 1.8) / vehicle.mass
    assert np.allclose(vehicle.centre, (0.0, 0.0, height), atol=1e-12)


@pytest.mark.parametrize("speed", [0.0, 30.0])
def test_wheel_loads_sum_to_the_weight_and_are_alike_on_both_sides(speed: float) -> None:
    law = on_track(manchester(), speed).law
    found = steady_state(law, 50.0)
    law(0.0, found.q, found.q_t, np.zeros(law.size))
    loads = wheel_loads(law)
    assert loads.sum() == pytest.approx(law.vehicle.weight, rel=1e-8)
    assert np.allclose(loads[:, 0], loads[:, 1], rtol=1e-9)
    # at rest the springs hold the design position; the wheels sink into the rails alike
    assert speed > 0.0 or np.allclose(loads, law.vehicle.weight / 8.0, rtol=1e-9)


def test_design_position_is_the_position_of_rest() -> None:
    law = on_track(manchester()).law
    found = steady_state(law, 50.0)
    heights = found.q[: 6 * 7 : 6]
    design = np.array([part.centre[2] for part in law.vehicle.parts])
    sunk = design - heights
    assert np.allclose(sunk, sunk[0], atol=1e-9)  # all alike, by the approach of wheel and rail
    assert 1e-4 < sunk[0] < 4e-4  # KP at 54.5 kN
