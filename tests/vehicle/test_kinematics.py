"""Laws of the rigid wheelset: kinematics, generalised forces, pose on the track, what the track frame does to it."""

from dataclasses import replace

import exudyn
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.knife_edge import bare_wheelset
from support.paths import curvature, locate

from wrsim import Arc, Straight, Track, Transition
from wrsim.errors import SimulationError
from wrsim.jit.frames import BodyMotion, point_velocity
from wrsim.jit.linalg import Vec
from wrsim.simulation.bodies import Solid
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import poses_on_track, state_on_track
from wrsim.simulation.system import BodySystem
from wrsim.track import path_kernel as core
from wrsim.track import path_kernel as path
from wrsim.track.path import COLUMNS, Path
from wrsim.vehicle.dynamics import kinematics as wheelset
from wrsim.vehicle.vehicle import single_wheelset

TO_GLOBAL = [1, 2, 0]  # Exudyn's axes are (z, x, y)

angles = st.tuples(st.floats(-10.0, 10.0), st.floats(-0.3, 0.3), st.floats(-50.0, 50.0))
vectors = st.tuples(*[st.floats(-5.0, 5.0)] * 3)


def moving(q, q_t):
    """kinematics with arrays in the place of tuples."""
    return BodyMotion(*map(np.array, wheelset.kinematics(q, q_t)))


def body_of(position, turn, velocity, rates):
    """kinematics of a state given as global position, angles, velocity, rates of the angles."""
    q = np.array([position[2], position[0], position[1], *turn])
    q_t = np.array([velocity[2], velocity[0], velocity[1], *rates])
    return q, q_t, moving(q, q_t)


@given(turn=angles, rates=vectors)
def test_orientation_and_angular_velocity_are_those_of_the_exudyn_node(turn, rates):
    q, q_t, body = body_of((1.0, 2.0, 3.0), turn, (4.0, 5.0, 6.0), rates)
    system = BodySystem([Solid(1500.0, (900.0, 100.0, 900.0))], lambda t, q, q_t, out: out.fill(0.0))
    system._mbs.systemData.SetODE2Coordinates(list(q))
    system._mbs.systemData.SetODE2Coordinates_t(list(q_t))
    output = exudyn.OutputVariableType
    rotation = np.reshape(system._mbs.GetNodeOutput(0, output.RotationMatrix), (3, 3))[TO_GLOBAL]
    omega = np.array(system._mbs.GetNodeOutput(0, output.AngularVelocity))[TO_GLOBAL]
    assert body.position == pytest.approx(np.array(system._mbs.GetNodeOutput(0, output.Position))[TO_GLOBAL])
    assert body.left == pytest.approx(rotation[:, 2], abs=1e-12)  # body z is the axle
    assert body.omega == pytest.approx(omega, abs=1e-12)
    assert body.up == pytest.approx(np.cross(body.forward, body.left), abs=1e-15)
    # without its spin the body's x is up
    up = rotation @ [np.cos(turn[2]), -np.sin(turn[2]), 0.0]
    assert body.up == pytest.approx(up, abs=1e-12)


@given(turn=angles, velocity=vectors, rates=vectors, force=vectors, moment=vectors)
def test_generalised_forces_do_the_power_of_force_and_moment(turn, velocity, rates, force, moment):
    q, q_t, body = body_of((0.0, 0.0, 0.0), turn, velocity, rates)
    out = np.zeros(6)
    wheelset.add_generalised_forces(wheelset.kinematics(q, q_t), Vec(*force), Vec(*moment), out)
    power = np.dot(force, body.velocity) + np.dot(moment, body.omega)
    assert out @ q_t == pytest.approx(power, abs=1e-11)


@given(turn=angles, rates=vectors)
def test_velocity_of_a_material_point_is_its_change_of_place(turn, rates):
    q, q_t, body = body_of((1.0, 2.0, 0.5), turn, (3.0, -1.0, 0.2), rates)
    point = body.position + 0.7 * body.left - 0.4 * body.up
    h = 1e-6

    def carried(step):
        """The material point that is at ``point`` now, ``step`` seconds later."""
        later = moving(q + step * q_t, q_t)
        c, s = np.cos(step * q_t[5]), np.sin(step * q_t[5])
        # spin turns -up towards -forward
        radial = -c * later.up - s * later.forward
        return later.position + 0.7 * later.left + 0.4 * radial

    measured = (carried(h) - carried(-h)) / (2 * h)
    velocity = point_velocity(wheelset.kinematics(q, q_t), Vec(*point))
    assert velocity == pytest.approx(measured, abs=1e-8)


@pytest.fixture(scope="module")
def curve() -> Track:
    """A left curve of 300 m with 100 mm of cant behind a clothoid, started in an odd direction."""
    return Track.build(
        [Straight(20.0), Transition(40.0), Arc(150.0, 300.0, cant=0.1)], heading=2.0, start=(100.0, -50.0, 3.0)
    )


@pytest.mark.parametrize("distance", [5.0, 41.3, 120.0])
def test_placing_a_wheelset_on_the_track_and_reading_its_pose_are_inverse(curve, distance):
    q, q_t = state_on_track(
        curve.centre, distance, speed=20.0, height=0.46, spin_rate=43.0, lateral=4e-3, yaw=5e-3, roll=-2e-3
    )
    poses = poses_on_track(curve.centre, q[None], q_t[None], start=distance + 1.0)
    assert poses.distance[0] == pytest.approx(distance, abs=1e-9)
    assert poses.lateral[0] == pytest.approx(4e-3, abs=1e-12)
    assert poses.height[0] == pytest.approx(0.46, abs=1e-12)
    assert poses.yaw[0] == pytest.approx(5e-3, abs=1e-12)
    assert poses.roll[0] == pytest.approx(-2e-3, abs=1e-12)
    assert poses.spin_rate[0] == pytest.approx(43.0, abs=1e-12)


@pytest.mark.parametrize("distance", [5.0, 41.3, 120.0])
def test_a_placed_wheelset_moves_with_the_track_frame(curve, distance):
    pose = {"speed": 20.0, "height": 0.46, "spin_rate": 43.0, "lateral": 4e-3, "yaw": 5e-3, "roll": -2e-3}
    h = 1e-4
    before = state_on_track(curve.centre, distance - 20.0 * h, **pose)[0]
    after = state_on_track(curve.centre, distance + 20.0 * h, **pose)[0]
    rates = state_on_track(curve.centre, distance, **pose)[1]
    assert rates[:5] == pytest.approx((after - before)[:5] / (2 * h), abs=1e-6)


def test_a_state_far_from_the_track_has_no_pose(curve):
    with pytest.raises(SimulationError, match="sample 0 has no place"):
        poses_on_track(curve.centre, np.full((1, 6), np.nan), np.zeros((1, 6)))


def pushed(vehicle, track, distance, speed, q, q_t):
    """Force and moment on a wheelset without rails, in track axes (t, n, b)."""
    law = VehicleOnTrack(vehicle, track, (), speed=speed, start=distance)
    out = np.zeros(6)
    law(0.0, q, q_t, out)
    body = wheelset.kinematics(q, q_t)
    s, _ = path.locate(track.centre.curve, body.position, distance)
    axes = np.array(path.frame_at(track.centre.curve, s))[1:]
    moment = np.linalg.solve([(0.0, 0.0, 1.0), body.forward, body.left], out[3:])
    return axes @ out[TO_GLOBAL], axes @ moment


def guided(stiffness=(5e6, 3e6, 1e6), **options):
    """A wheelset without weight that only the guide frame pushes, and what it carries."""
    bare = replace(bare_wheelset(), mass=1e-30)
    return single_wheelset(bare, stiffness=stiffness, damping=(2e4, 3e4, 1e4), **options)


@pytest.mark.parametrize("distance", [5.0, 41.3, 120.0])
def test_the_undisturbed_follower_in_a_curve_meets_no_suspension_force(curve, distance):
    q, q_t = state_on_track(curve.centre, distance, speed=20.0, height=0.46, spin_rate=43.0)
    force, moment = pushed(guided(), curve, distance, 20.0, q, q_t)
    # round-off of positions of 100 m times 1e7 N/m
    assert np.abs(force).max() < 1e-5
    assert np.abs(moment).max() < 1e-5


@given(turn=st.tuples(*[st.floats(-0.05, 0.05)] * 3), velocity=vectors, rates=vectors)
def test_dampers_on_straight_track_only_take_power(turn, velocity, rates):
    track = Track.build([Straight(50.0)])
    q, q_t, _ = body_of((10.0, 0.01, 0.47), turn, np.add(velocity, (20.0, 0, 0)), rates)
    damped = guided(stiffness=(0.0, 0.0, 0.0))
    force, moment = pushed(damped, track, 10.0, 20.0, q, q_t)
    body = moving(q, q_t)
    assert force @ (body.velocity - [20.0, 0.0, 0.0]) + moment @ body.omega <= 1e-9


def test_a_carried_mass_presses_with_its_weight_and_its_centrifugal_force():
    track = Track.build([Arc(100.0, 300.0)])
    vehicle = guided(carried_mass=1e4, carried_height=1.3)
    q, q_t = state_on_track(track.centre, 50.0, speed=15.0, height=0.46, spin_rate=0.0)
    force, moment = pushed(vehicle, track, 50.0, 15.0, q, q_t)
    outward = 1e4 * 15.0**2 / 300.0
    assert force == pytest.approx([0.0, -outward, -1e4 * 9.80665], rel=1e-9, abs=1e-3)
    # to the right at 1.3 m above the axle: the left wheel goes up
    assert moment == pytest.approx([1.3 * outward, 0.0, 0.0], rel=1e-9, abs=1e-3)


def test_a_state_is_near_where_no_first_position_is_farther_than_allowed():
    q, q_t = np.array([1.0, 2.0, 3.0]), np.array([0.1, 0.2, 0.3])
    known = np.array([q, q_t])
    assert wheelset.is_near(known, q, q_t, 2, 0.0)  # the very same, rates and all
    assert not wheelset.is_near(known, q, q_t + 0.1, 2, 0.0) and wheelset.is_near(known, q, q_t + 0.1, 2, 0.5)
    moved = q + np.array([0.0, 0.25, 9.0])  # only the first two count
    assert wheelset.is_near(known, moved, q_t, 2, 0.25) and not wheelset.is_near(known, moved, q_t, 2, 0.2)
    assert not wheelset.is_near(known, moved, q_t, 3, 0.25) and not wheelset.is_near(known, moved, q_t, 2, 0.0)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("i", range(6))
def test_the_first_number_that_is_not_finite_is_found_among_positions_then_rates(bad, i):
    state = np.arange(6.0)
    assert wheelset.first_not_finite(state[:3], state[3:]) == -1
    state[i:] = bad
    assert wheelset.first_not_finite(state[:3], state[3:]) == i


# Laws of a path: the interpolated curve, its frame, and the search for a cross-section.
def helix(radius: float, slope: float, turns: float, step: float, roll_rate: float = 0.0) -> Path:
    """A helix: every coordinate, tangent and curvature is known. Angle cos(slope) s / R."""
    n = round(2.0 * np.pi * radius * turns / step) + 1
    s = np.arange(n) * step
    c, d = np.cos(slope), np.sin(slope)
    a = c * s / radius
    table = np.zeros((n, len(COLUMNS)))
    table[:, 0:3] = np.column_stack((radius * np.sin(a), radius * (1 - np.cos(a)), d * s))
    table[:, 3:6] = np.column_stack((c * np.cos(a), c * np.sin(a), np.full(n, d)))
    table[:, 6] = 0.1 * np.sin(roll_rate * s)
    table[:, 7] = 0.1 * roll_rate * np.cos(roll_rate * s)
    table[:, 8:10] = c**2 / radius * np.column_stack((-np.sin(a), np.cos(a)))
    return Path(table, step)


@pytest.fixture(scope="module")
def spiral() -> Path:
    """Two turns of 30 m radius, climbing, rolling."""
    return helix(30.0, 0.03, 2.0, 0.25, roll_rate=0.05)


def test_frame_is_orthonormal_right_handed_and_its_roll_is_the_tilt_of_n(spiral: Path) -> None:
    s = np.linspace(-5.0, spiral.length + 5.0, 1000)
    axes = spiral.frame(s)[:, 1:]
    gram = axes @ axes.transpose(0, 2, 1)
    assert np.abs(gram - np.eye(3)).max() < 1e-14
    assert np.abs(np.linalg.det(axes) - 1.0).max() < 1e-14
    inside = np.clip(s, 0.0, spiral.length)
    cos_slope = np.hypot(axes[:, 0, 0], axes[:, 0, 1])
    # n.z = sin(roll) cos(slope); tolerance: cubic Hermite of a sine of 0.1 rad and 0.05 rad/m
    assert np.abs(axes[:, 1, 2] - np.sin(0.1 * np.sin(0.05 * inside)) * cos_slope).max() < 1e-10


def test_interpolation_converges_with_order_six_in_position_five_in_tangent_four_in_curvature() -> None:
    errors = []
    for step in (8.0, 4.0, 2.0):
        radius = 30.0
        path = helix(radius, 0.0, 1.0, step)
        s = np.linspace(0.0, path.length, 2001)
        a = s / radius
        frame = path.frame(s)
        exact = np.column_stack((radius * np.sin(a), radius * (1.0 - np.cos(a))))
        tangent = np.column_stack((np.cos(a), np.sin(a)))
        errors.append(
            (
                np.abs(frame[:, 0, :2] - exact).max(),
                np.abs(frame[:, 1, :2] - tangent).max(),
                np.abs(curvature(path, s) - 1.0 / radius).max(),
            )
        )
    order = np.log2(np.array(errors[1]) / np.array(errors[2]))
    assert order == pytest.approx([6.0, 5.0, 4.0], abs=0.15)


def test_a_path_continues_straight_and_its_frame_turns_by_its_rates(spiral: Path) -> None:
    for end, sign in ((0.0, -1.0), (spiral.length, 1.0)):
        end_frame, beyond = spiral.frame(end), spiral.frame(end + sign * 7.0)
        assert np.abs(beyond[0] - (end_frame[0] + sign * 7.0 * end_frame[1])).max() < 1e-13
        assert np.abs(beyond[1:] - end_frame[1:]).max() < 1e-15
        assert curvature(spiral, end + sign * 7.0) == 0.0
        assert core.frame_rates(spiral.curve, end + sign * 7.0) == ((0.0, 0.0, 0.0), 0.0)
    h = 1e-4
    for s in (0.3, 11.11, 200.0, spiral.length - 0.2):
        omega, droll = core.frame_rates(spiral.curve, s)
        slope = (spiral.frame(s + h)[1:] - spiral.frame(s - h)[1:]) / (2.0 * h)
        turned = np.cross(np.array(omega), spiral.frame(s)[1:])
        assert np.abs(slope - turned).max() < 1e-9  # differences of 1e-16 / 1e-4, and of the table's roll
        assert droll == pytest.approx(0.005 * np.cos(0.05 * s), abs=1e-9)


def test_locate_is_the_inverse_of_frame_and_does_not_care_for_the_guess(spiral: Path) -> None:
    rng = np.random.default_rng(1)
    s = rng.uniform(-3.0, spiral.length + 3.0, 400)
    frame = spiral.frame(s)
    points = (
        frame[:, 0]
        + rng.uniform(-1.5, 1.5, 400)[:, None] * frame[:, 2]
        + rng.uniform(-1.0, 1.0, 400)[:, None] * frame[:, 3]
    )
    located = locate(spiral, points, s + rng.uniform(-4.0, 4.0, 400))
    assert np.abs(located - s).max() < 1e-12 * 400.0
    again = locate(spiral, points, s + rng.uniform(-1e-3, 1e-3, 400))
    assert np.abs(located - again).max() < 1e-12 * 400.0


def test_locate_says_when_it_has_no_answer(spiral: Path) -> None:
    curve = spiral.curve
    assert core.locate(curve, Vec(np.nan, 0.0, 0.0), 1.0)[1] == core.LOCATE_NOT_FINITE
    assert core.locate(curve, Vec(0.0, 0.0, 0.0), np.nan)[1] == core.LOCATE_NOT_FINITE
    assert core.locate(curve, Vec(1.0, np.inf, 0.0), 1.0)[1] == core.LOCATE_NOT_FINITE
    line = helix(1e9, 0.0, 1e-9, 0.25)  # hardly bent: a guess 1000 km away is out of reach
    assert core.locate(line.curve, Vec(1e6, 0.0, 0.0), 0.0)[1] == core.LOCATE_NOT_CONVERGED
    assert np.isnan(locate(line, np.array([1e6, 0.0, 0.0]), 0.0))
