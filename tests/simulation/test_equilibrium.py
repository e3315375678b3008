"""Steady motions: found from bad guesses, to 1e-9 of the weight, and a clear word when there is none."""

import numpy as np
import pytest
from support.knife_edge import KnifeEdge, KnifeEdgeForces, example_wheelset
from support.rows import rows_of
from support.vehicles import on_track, shipped

from wrsim import Arc, Straight, Track
from wrsim.simulation.force_law import all_on_all
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.newton import damped_newton
from wrsim.simulation.placement import design_state, poses_on_track
from wrsim.simulation.steady_state import NotCarried, Unbalanced, crept_state, lower_on_rails, steady_state
from wrsim.simulation.system import COORDINATES
from wrsim.vehicle.bogies import wheelsets_beneath

table = rows_of(__file__)

SPEED = 30.0


def near(forces, places):
    """The design state with some coordinates moved, lowered on its rails; places: names of q to values."""
    q, q_t = design_state(forces)
    for name, value in places.items():
        q[COORDINATES.index(name)] = value
    return lower_on_rails(forces, q, q_t)


@pytest.mark.parametrize(
    "places",
    table("a_symmetric_wheelset_rolls_straight_in_the_middle"),
    ids=["near", "aside", "too low", "in the air", "askew"],
)
def test_a_symmetric_wheelset_rolls_straight_in_the_middle(places):
    law = KnifeEdge()
    forces = KnifeEdgeForces(example_wheelset(), SPEED, law=law)
    steady = steady_state(forces, near(forces, places))
    assert steady.residual <= 1e-9
    assert steady.q[2] == pytest.approx(0.0, abs=1e-9)
    assert steady.q[3:5] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert steady.q[0] == pytest.approx(0.46 - law.approach(50e3), abs=1e-6)
    assert steady.q_t[5] == pytest.approx(SPEED / 0.46, rel=1e-5)
    left, right = forces.edge_memory[1:]
    assert left == pytest.approx(right, rel=1e-6)
    assert left * np.cos(np.arctan(0.05)) == pytest.approx(50e3, rel=2e-6)


def test_a_rolling_wheelset_without_springs_keeps_the_place_that_nothing_determines():
    forces = KnifeEdgeForces(example_wheelset(spring=0.0), SPEED)
    steady = steady_state(forces, near(forces, {"x": 7.0}))
    assert steady.q[1] == pytest.approx(7.0, abs=1e-9)


def test_steady_motion_in_an_arc_is_the_same_at_every_heading():
    """A coach on its flanges in 300 m, headings of 0.1 and 0.9 rad: its drive alone holds it along the track, and the
    forces balance within the tolerance at either place."""
    shifts = []
    for start in (40.0, 260.0):
        law = on_track(shipped("manchester_1"), 16.0, [Arc(400.0, 300.0, 0.1)], start).law
        state = crept_state(law, lower_on_rails(law, *design_state(law)))
        wheelsets = (slice(6 * i, 6 * i + 6) for i in range(4))
        poses = [poses_on_track(law.track.centre, state.q[None, w], state.q_t[None, w], start) for w in wheelsets]
        shifts.append([pose.lateral.item() for pose in poses])
    assert min(shifts[0]) < -5e-3
    np.testing.assert_allclose(*shifts, rtol=0.0, atol=1e-8)


def test_a_wheelset_off_the_rails_and_what_did_not_converge_are_named():
    forces = KnifeEdgeForces(example_wheelset(), SPEED)
    with pytest.raises(NotCarried, match=r"the rails do not carry wheelset 'wheelset' anywhere within 50 mm"):
        near(forces, {"z": 1.46})
    # ten times its weight sideways
    forces = KnifeEdgeForces(example_wheelset(spring=0.0, push=1e6), SPEED)
    with pytest.raises(Unbalanced, match=r"remaining forces over the weight: wheelset \w+ ") as problem:
        steady_state(forces)
    assert problem.value.forces[0][0].startswith("wheelset ")
    assert abs(problem.value.forces[0][1]) > 0.1


def test_a_path_between_stiff_walls_is_followed_along_its_bends():
    """Two forces that let a point move along a circle only, and a weak one along it: a search by straight steps
    creeps."""

    def residual(x):
        return np.array([1e2 * (np.hypot(*x) - 1.0), np.arctan2(x[1], x[0]) - 2.5])

    x, left, iterations = damped_newton(residual, np.array([1.0, 0.0]), np.full(2, 0.01), 1e-9, 60)
    assert np.abs(left).max() < 1e-9
    assert x == pytest.approx([np.cos(2.5), np.sin(2.5)], abs=1e-9)
    assert iterations < 20


def test_a_search_that_stalls_ends_before_its_time():
    def residual(x):
        return np.array([1.0 + 0.1 * np.exp(-0.001 * x[0])])  # falls for ever, and never to zero

    _, left, iterations = damped_newton(residual, np.zeros(1), np.ones(1), 1e-9, 500)
    assert iterations < 100 and left[0] > 1.0


def test_derivatives_may_come_from_a_function_nearby():
    def residual(x):
        return np.array([x[0] ** 3 - 8.0 + 0.1 * np.sin(x[1]), x[1] + 0.2 * x[0] - 1.0])

    def nearby(x):
        return np.array([x[0] ** 3 - 8.0, x[1] + 0.2 * x[0] - 1.0])

    small = np.full(2, 1e-2)
    x, left, iterations = damped_newton(residual, np.array([1.9, 0.5]), small, 1e-12, 40, [(nearby, all_on_all(2))])
    assert np.abs(left).max() < 1e-12
    assert np.abs(residual(x)).max() < 1e-12
    assert iterations < 40  # though it converges linearly


# Where the search for a steady motion begins: bodies on the wheelsets that carry them.
START = 60.0


def laid(track: Track) -> dict[str, tuple[float, float]]:
    """By body of the motor coach: how far to the left of the track it lies [m], and its yaw there [rad]."""
    vehicle = shipped("manchester_motor")
    law = VehicleOnTrack(vehicle, track, (), speed=10.0, start=START)
    q, q_t = design_state(law)
    lateral_and_yaw = {}
    for i, part in enumerate(vehicle.parts):
        coordinates = slice(6 * i, 6 * i + 6)
        pose = poses_on_track(track.centre, q[None, coordinates], q_t[None, coordinates], START + part.centre[0])
        lateral_and_yaw[part.name] = float(pose.lateral[0]), float(pose.yaw[0])
    return lateral_and_yaw


@pytest.mark.parametrize("radius", [150.0, -150.0])
def test_in_a_curve_bodies_lie_on_the_chords_of_their_wheelsets(radius):
    bodies = laid(Track.build([Arc(120.0, radius)], 1.5))
    axles = np.array([9.5 + 1.28, 9.5 - 1.28, -9.5 + 1.28, -9.5 - 1.28])
    assert bodies["carbody"] == pytest.approx((np.mean(axles**2) / 2.0 / radius, 0.0), abs=1e-3)
    assert bodies["front.bogie.frame"] == pytest.approx((1.28**2 / 2.0 / radius, 0.0), abs=1e-4)
    # a case 1.18 m ahead of the bogie's centre: nearly above the leading axle, along the frame and not along the track
    inside, yaw = bodies["front.leading case"]
    assert inside == pytest.approx((1.28**2 - 1.18**2) / 2.0 / radius, abs=1e-4)
    assert yaw == pytest.approx(-1.18 / radius, rel=1e-3)
    assert bodies["front.bogie.outer"] == pytest.approx((0.0, 0.0), abs=1e-9)


def test_bodies_know_their_wheelsets_and_lie_on_straight_track_where_their_file_has_them():
    for inside, yaw in laid(Track.build([Straight(120.0)], 1.5)).values():
        assert abs(inside) < 1e-12 and abs(yaw) < 1e-12
    vehicle = shipped("manchester_motor")
    beneath = wheelsets_beneath(vehicle)
    assert beneath["carbody"] == (0, 1, 2, 3)
    assert beneath["front.leading motor"] == beneath["front.leading case"] == beneath["front.bogie.frame"] == (0, 1)
