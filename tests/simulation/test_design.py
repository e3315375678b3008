"""Where the search for a steady motion begins: bodies on the wheelsets that carry them."""

import numpy as np
import pytest
from support.vehicles import shipped

from wrsim.geometry.track.segments import Arc, Straight
from wrsim.geometry.track.track import Track
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state, poses_on_track
from wrsim.vehicle.bogies import wheelsets_beneath

START = 60.0


def laid(track: Track) -> dict[str, tuple[float, float]]:
    """By body of the motor coach: how far to the left of the track it lies [m], and its yaw there [rad]."""
    vehicle = shipped("manchester_motor")
    law = VehicleOnTrack(vehicle, track, (), speed=10.0, start=START)
    q, q_t = design_state(law)
    found = {}
    for i, part in enumerate(vehicle.parts):
        own = slice(6 * i, 6 * i + 6)
        pose = poses_on_track(track.centre, q[None, own], q_t[None, own], START + part.centre[0])
        found[part.name] = float(pose.lateral[0]), float(pose.yaw[0])
    return found


@pytest.mark.parametrize("radius", [150.0, -150.0])
def test_in_a_curve_bodies_lie_on_the_chords_of_their_wheelsets(radius):
    found = laid(Track.build([Arc(120.0, radius)], 1.5))
    axles = np.array([9.5 + 1.28, 9.5 - 1.28, -9.5 + 1.28, -9.5 - 1.28])
    assert found["carbody"] == pytest.approx((np.mean(axles**2) / 2.0 / radius, 0.0), abs=1e-3)
    assert found["front.bogie.frame"] == pytest.approx((1.28**2 / 2.0 / radius, 0.0), abs=1e-4)
    # a case 1.18 m ahead of the bogie's centre: nearly above the leading axle, along the frame and not along the track
    inside, yaw = found["front.leading case"]
    assert inside == pytest.approx((1.28**2 - 1.18**2) / 2.0 / radius, abs=1e-4)
    assert yaw == pytest.approx(-1.18 / radius, rel=1e-3)
    assert found["front.bogie.outer"] == pytest.approx((0.0, 0.0), abs=1e-9)


def test_on_straight_track_bodies_lie_where_their_file_has_them():
    for inside, yaw in laid(Track.build([Straight(120.0)], 1.5)).values():
        assert abs(inside) < 1e-12 and abs(yaw) < 1e-12


def test_bodies_know_the_wheelsets_that_carry_them_through_others():
    vehicle = shipped("manchester_motor")
    beneath = wheelsets_beneath(vehicle)
    assert beneath["carbody"] == (0, 1, 2, 3)
    assert beneath["front.leading motor"] == beneath["front.leading case"] == beneath["front.bogie.frame"] == (0, 1)
