"""What an acceptance measures on a vehicle that stands still: sway on canted rails, wheel unloading on twisted ones."""

from math import asin, cos, sin

import numpy as np
import pytest
from support.vehicles import manchester, shipped

from wrsim.analysis.stationary.statics import canted, static_state
from wrsim.errors import SimulationError
from wrsim.vehicle.vehicle import Vehicle

ANGLE = asin(0.15 / 1.5)
TWIST = 5e-3 / 1.5


def roll_moment(vehicle: Vehicle, loads: np.ndarray) -> float:
    """Moment of the wheels' loads about the middle of the track [N m]."""
    half = np.array([0.5 * m.wheelset.profile_spacing for m in vehicle.wheelsets])
    return float(np.sum(half * (loads[:, 0] - loads[:, 1])))


def test_wheel_loads_on_canted_rails_balance_the_weight_where_it_has_moved_to():
    vehicle = manchester()
    found = static_state(canted(vehicle, ANGLE))
    assert found.wheel_loads.sum() == pytest.approx(vehicle.weight * cos(ANGLE), rel=1e-9)
    moment = sum(m.mass * vehicle.gravity * sin(ANGLE) * m.wheelset.mean_radius for m in vehicle.wheelsets)
    for body, (y, z, _) in zip(vehicle.bodies, found.moved, strict=True):
        weight = body.mass * vehicle.gravity
        moment += weight * (sin(ANGLE) * (body.centre[2] + z) + cos(ANGLE) * y)
    assert roll_moment(vehicle, found.wheel_loads) == pytest.approx(moment, rel=1e-5)
    other = static_state(canted(vehicle, -ANGLE))
    assert found.wheel_loads == pytest.approx(other.wheel_loads[:, ::-1], rel=1e-9)
    # rails canted to the left turn the bodies outward, to the left: roll is positive to the right
    assert (found.moved[:, 2] < 0.0).all() and found.moved[0, 2] < found.moved[1, 2]


def test_what_is_carried_leans_as_a_rigid_body_does():
    vehicle = shipped("wheelset_s1002")
    found = static_state(canted(vehicle, ANGLE))
    (mounted,), (carried,) = vehicle.wheelsets, vehicle.carried
    radius = mounted.wheelset.mean_radius
    heights = vehicle.gravity * (mounted.mass * radius + carried.mass * (radius + carried.height))
    assert roll_moment(vehicle, found.wheel_loads) == pytest.approx(sin(ANGLE) * heights, rel=1e-6)


def test_a_twisted_track_unloads_wheels_by_the_stiffness_between_its_axles():
    # k = 3646 kN/m at 0.62 m to either side of each axle, which rolls against a level frame (Cooperrider 1972)
    vehicle = shipped("cooperrider_bogie")
    found, static = static_state(vehicle, TWIST), static_state(vehicle)
    tilt = TWIST * 1.074
    force = 2.0 * 3646e3 * 0.62**2 * tilt / 1.462
    change = found.wheel_loads - static.wheel_loads
    assert change == pytest.approx(np.array([[force, -force], [-force, force]]), rel=1e-3)


def test_a_twist_turns_no_vehicle_and_works_alike_both_ways():
    vehicle = manchester()
    one, other, half = (static_state(vehicle, twist).wheel_loads for twist in (TWIST, -TWIST, 0.5 * TWIST))
    static = vehicle.weight / 8.0
    assert one.sum() == pytest.approx(vehicle.weight, rel=1e-9)
    assert abs(roll_moment(vehicle, one)) < 1e-5 * vehicle.weight
    assert one == pytest.approx(other[:, ::-1], rel=1e-9)
    assert one - static == pytest.approx(2.0 * (half - static), abs=1e-2 * np.ptp(one))
    # the ends of the vehicle are turned most: within a bogie and between the bogies
    assert one[0, 0] > one[1, 0] > static > one[2, 0] > one[3, 0]


def test_more_cant_than_the_weight_can_hold_overturns():
    with pytest.raises(SimulationError, match="overturns"):
        static_state(canted(manchester(), 0.5))
