"""Loads and payloads of a vehicle: hand calculations of tilt and wheel loads, balances of momentum."""

from dataclasses import replace
from math import asin, radians, sin

import numpy as np
import pytest
from scipy.optimize import minimize
from support.vehicles import ROOT, manchester, on_track, shipped

from wrsim import Arc, SimulationError, Track, Vehicle, stationary
from wrsim.analysis.motion.derailment import QuasiStaticForce, check_upright, resultant
from wrsim.analysis.motion.messages import NoSteadyMotion
from wrsim.analysis.stationary.statics import canted, static_state
from wrsim.inputs.lookup import shipped_models
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.placement import design_state, poses_on_track
from wrsim.simulation.steady_state import lower_on_rails, steady_state
from wrsim.track.segments import Segment
from wrsim.vehicle.loads import Load, Payload
from wrsim.vehicle.wheelset import STANDARD_GRAVITY
from wrsim.vehicle.wind import Air

SHIPPED = sorted((ROOT / "models/vehicles").glob("*.toml"))
HEIGHT = 2.2  # of the wind [m]
HALF = 0.75  # half the distance of the wheel profiles [m]
FEW = {"freight_y25", "irw", "manchester_1", "wheelset_s1002_steering"}
with_payload = pytest.mark.parametrize(
    "file",
    [pytest.param(f.stem, marks=[pytest.mark.campaign] * (f.stem not in FEW)) for f in SHIPPED if "lrv" not in f.stem],
)


def in_wind(force: float, height: float = HEIGHT, along: float = 0.0) -> Vehicle:
    """The coach pushed to the left [N] at a height and a place along it [m]."""
    return replace(manchester(), loads=(Load.constant("wind", "carbody", (0.0, force, 0.0), (along, 0.0, height)),))


class Coach:
    """The coach by hand, as a plane model: its energy over (y, z, roll) of car body and frames, roll to the left
    negative. Numbers: ``models/vehicles/manchester_1.toml``. Springs turn with the bodies that they are fixed to."""

    CAR, FRAME = 32000.0, 2615.0
    TRAVEL = 1e-3 * np.array([0, 25, 30, 35, 40, 45, 50, 55, 60, 65])
    STOP = 1e3 * np.array([0, 0, 0.6, 1.76, 3.73, 6.87, 11.58, 17.17, 29.2, 230])

    def __init__(self, *pushes: tuple[float, float, float, float]) -> None:
        """pushes: to the left and up [N], at a place to the left and above the rails [m]."""
        self.pushes = pushes
        start = np.zeros(6)
        self.car, self.frame = np.split(minimize(self.energy, start, tol=1e-14, options={"gtol": 1e-4}).x, 2)

    def energy(self, x: np.ndarray) -> float:
        """Of four quarters: springs with their preloads, stops, gravity, and the wind."""
        (yc, zc, rc), (yf, zf, rf) = x[:3], x[3:]

        def point(y: float, z: float, roll: float, centre: float, point_of_body: tuple[float, float]) -> np.ndarray:
            """Where a point (y, z) of a body has gone."""
            c, s = np.cos(roll), np.sin(roll)
            a, b = point_of_body[0], point_of_body[1] - centre
            return np.array([y + c * a - s * b, centre + z + s * a + c * b])

        def seen(roll: float, d: np.ndarray) -> np.ndarray:
            c, s = np.cos(roll), np.sin(roll)
            return np.array([c * d[0] + s * d[1], -s * d[0] + c * d[1]])

        total = 0.0
        for side in (1.0, -1.0):
            middle = (side, 0.8275)
            d = point(yc, zc, rc, 1.8, middle) - point(yf, zf, rf, 0.6, middle)
            share = self.CAR * STANDARD_GRAVITY / 4.0
            for roll in (rc, rf):  # half of a column turns with either body
                relative = seen(roll, d)
                total += 2.0 * 0.5 * (0.5 * (160e3 * relative[0] ** 2 + 430e3 * relative[1] ** 2) - share * relative[1])
            box = (side, 0.46)
            relative = seen(rf, point(yf, zf, rf, 0.6, box) - np.array(box))  # the frame against its axle
            share = (self.CAR / 4.0 + self.FRAME / 2.0) * STANDARD_GRAVITY / 2.0
            total += 4.0 * (0.5 * (3884e3 * relative[0] ** 2 + 1220e3 * relative[1] ** 2) - share * relative[1])
        total += (2.0 * 940e3 + 4.0 * 10.5e3) * (1.0 - np.cos(rc - rf))
        stop = point(yc, zc, rc, 1.8, (0.0, 0.65)) - point(yf, zf, rf, 0.6, (0.0, 0.65))
        travel = abs(seen(rc, stop)[0])
        fine = np.linspace(0.0, travel, 2001)
        total += 2.0 * np.trapezoid(np.interp(fine, self.TRAVEL, self.STOP), fine)
        total += STANDARD_GRAVITY * (self.CAR * zc + 2.0 * self.FRAME * zf)
        return total - sum(np.dot(push[:2], point(yc, zc, rc, 1.8, push[2:])) for push in self.pushes)

    @property
    def transfer(self) -> float:
        """What a left wheel gains [N] on a right one: wind over the rails, and weight that has swayed."""
        sway = self.CAR * self.car[0] + 2.0 * self.FRAME * self.frame[0]
        y, z, roll = self.car
        turning = STANDARD_GRAVITY * sway
        for left, up, a, b in self.pushes:
            acting_point = (
                y + a * np.cos(roll) - (b - 1.8) * np.sin(roll),
                1.8 + z + a * np.sin(roll) + (b - 1.8) * np.cos(roll),
            )
            turning += left * acting_point[1] - up * acting_point[0]
        return float(turning / (8.0 * HALF))


@pytest.mark.parametrize("force", [1e3, -10e3, 40e3, 80e3])
def test_a_coach_in_the_wind_tilts_and_unloads_as_calculated_by_hand(force: float) -> None:
    """Below some 10 kN on its springs alone, above on its bump stops, which the body meets at 25 mm."""
    rest, hand = static_state(in_wind(force)), Coach((force, 0.0, 0.0, HEIGHT))
    y, _, roll = rest.moved[0]
    assert [y, roll] == pytest.approx([hand.car[0], hand.car[2]], rel=1e-3)
    assert rest.moved[1:, 2] == pytest.approx(hand.frame[2], rel=2e-3)
    gain = rest.wheel_loads[:, 0] - rest.wheel_loads.mean(axis=1)
    assert gain.mean() == pytest.approx(hand.transfer, rel=1e-3)
    stop = [e.name for e in manchester().elements].index("front.lateral stop")
    assert (abs(rest.readings[stop, 1]) > 0.0) == (abs(force) > 20e3)
    assert 62e-3 < abs(40e3 / 640e3) < 63e-3 < abs(y) or abs(force) < 40e3  # more than the springs alone would give


@pytest.mark.parametrize(("wind", "left"), [(5.0, 1.0), (32.0, -1.0)])
def test_five_masses_by_hand_rest_in_the_wind_of_a_tunnels_coefficients_as_the_vehicle_does(wind, left) -> None:
    """Car body, two frames, wheelsets before and behind, as in EN 14067-6, at 120 km/h; on springs and on stops."""
    table = ((0.0, 0.0, 0.0, 0.0), (radians(30.0), 3.0, 1.2, 2.4), (radians(60.0), 5.2, 1.9, 4.1))
    loads = Air(10.0, 0.0, 0.0, 1.225, table, 3.0).loads(manchester(), 0.0, wind, 120.0 / 3.6, left)
    rest = static_state(replace(manchester(), loads=loads))
    hand = Coach(*((*load.largest[1:], *load.at[1:]) for load in loads))
    y, _, roll = rest.moved[0]
    assert [y, roll] == pytest.approx([hand.car[0], hand.car[2]], rel=1e-3)
    assert rest.moved[0, 1] == pytest.approx(hand.car[1], rel=1e-3, abs=6e-6)  # supports sink by 5.4 um
    assert rest.moved[1:, 2] == pytest.approx(hand.frame[2], rel=2e-3)
    assert (abs(y) > 0.025) == (wind > 20.0)  # on the stops
    gain = rest.wheel_loads[:, 0] - rest.wheel_loads.mean(axis=1)
    assert gain.mean() == pytest.approx(hand.transfer, rel=1e-3)


@with_payload
def test_a_payload_changes_wheel_loads_by_its_lever_and_leaves_the_vehicle_where_it_is(file: str) -> None:
    """10 kN a wheelset at 2.2 m: 10 x 2.2 / 2 b. Supports of the wheels give by some micrometres: 1e-5 m, rad."""
    vehicle = shipped(file)
    body = vehicle.parts[vehicle.reference]
    count = len(vehicle.wheelsets)
    has_preloads = any(element.preload is not None for element in vehicle.elements)  # these take no share of a payload
    axles = {*vehicle.boxes, *(mounted.name for mounted in vehicle.wheelsets)}
    steered = any(
        e.kind == "traction-rod" and e.second in axles for e in vehicle.elements
    )  # a push would turn the axle
    aside = 0.0 if has_preloads or steered else 10e3
    push = Payload("push", body.name, (0.0, aside * count, -5e3), (body.centre[0], 0.0, HEIGHT))
    before, after = static_state(vehicle), static_state(replace(vehicle, payloads=(*vehicle.payloads, push)))
    gain = after.wheel_loads - before.wheel_loads
    half = 0.5 * np.array([m.wheelset.profile_spacing for m in vehicle.wheelsets])
    held = {end for e in vehicle.elements for end in (e.first, e.second)} & {"track", "guide frame"}
    if not held:  # no frame beside the rails takes a share
        assert gain.sum() == pytest.approx(5e3, rel=1e-6)
        assert (gain[:, 0] - gain[:, 1]) @ half == pytest.approx(aside * count * HEIGHT, rel=1e-4, abs=1.0)
        assert gain[:, 0] == pytest.approx(aside * HEIGHT / (2.0 * half) + 2.5e3 / count, rel=1e-3)
    assert after.moved[:, [0, 2]] == pytest.approx(before.moved[:, [0, 2]], abs=1e-5)


@with_payload
def test_a_lateral_load_on_an_axle_unloads_its_wheel_by_its_height(file: str) -> None:
    """F R / 2 b, wherever the wheelset belongs: the rails hold it below its axle."""
    vehicle = shipped(file)
    axle = vehicle.wheelsets[0]
    push = Load.constant("push", axle.name, (0.0, 10e3, 0.0), axle.centre)
    gain = static_state(replace(vehicle, loads=(push,))).wheel_loads - static_state(vehicle).wheel_loads
    expected = 10e3 * axle.height / axle.wheelset.profile_spacing
    assert gain[0] == pytest.approx([expected, -expected], rel=1e-2)
    assert np.abs(gain[1:]).max(initial=0.0) < 1e-2 * expected


def test_what_acts_on_a_vehicle_points_to_where_its_moment_vanishes() -> None:
    """Bodies 0.1 m to the left of the middle: weight points there, centrifugal force moves that outward; a load too."""
    vehicle = manchester()
    aside = tuple(replace(b, centre=(b.centre[0], b.centre[1] + 0.1, b.centre[2])) for b in vehicle.bodies)
    vehicle = replace(vehicle, bodies=aside)
    _, y, z = vehicle.centre_of_load
    assert 0.05 < y < 0.1
    assert resultant(vehicle, 0.0, 0.0, 0.0, 20.0).point == pytest.approx(y)
    share = 20.0**2 / 800.0 / vehicle.gravity
    assert resultant(vehicle, 0.0, 1.0 / 800.0, 0.0, 20.0).point == pytest.approx(y - z * share)
    held = replace(
        vehicle, loads=(Load.constant("hook", "carbody", (0.0, 0.0, 1.1 * vehicle.weight), (0.0, y + 0.2, 1.0)),)
    )
    assert not np.isfinite(resultant(held, 0.0, 0.0, 0.0, 20.0).point)
    half = replace(
        vehicle, loads=(Load.constant("h", "carbody", (0.0, 0.0, 0.5 * vehicle.weight), (0.0, y + 0.2, 1.0)),)
    )
    assert resultant(half, 0.0, 0.0, 0.0, 20.0).point == pytest.approx(y - 0.2)


def test_a_vehicle_overturns_where_what_acts_on_it_points_beside_a_rail() -> None:
    check_upright(QuasiStaticForce(0.0, -1.0, 0.74), 1.5, 0.0, manchester())
    for point, curvature, side in ((0.76, 0.0, "left"), (-0.76, 0.0, "right"), (-0.76, 0.01, "outer")):
        with pytest.raises(NoSteadyMotion, match=f"point 10 mm beyond the {side} rail"):
            check_upright(QuasiStaticForce(0.0, -1.0, point), 1.5, curvature, manchester())


CURVE = [Arc(400.0, 300.0, cant=0.1)]
ROWS = ((50.0, 1e3, -2e3, 3e3), (70.0, 4e3, 5e3, -1e3), (90.0, 4e3, -5e3, 2e3))


def bare(vehicle: Vehicle, start: float = 75.0) -> VehicleOnTrack:
    """A law without rails, gravity and drive: what is left are springs, which pull on bodies two by two, and loads."""
    track = Track.build(CURVE, 1.5)
    return VehicleOnTrack(vehicle, track, (), speed=20.0, start=start, drive="free", gravity=0.0)


def resultants(law: VehicleOnTrack, t: float, seed: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sum of the forces on all bodies (3,) along x, y, z of the ground at a shaken state q; q; forces of the bodies."""
    rng = np.random.default_rng(seed)
    q, q_t = design_state(law)
    n = 6 * len(law.bodies)
    q[:n] += 2e-3 * rng.standard_normal(n)
    out = np.zeros(law.size)
    law(t, q, q_t, out)
    rows = out[:n].reshape(-1, 6)
    return rows[:, [1, 2, 0]].sum(axis=0), q, rows


@pytest.mark.parametrize("over", ["time", "distance"])
@pytest.mark.parametrize("axes", ["track", "body"])
def test_loads_change_the_momentum_of_the_vehicle_and_springs_do_not(over: str, axes: str) -> None:
    point = (3.0, 0.5, 2.0)
    load = Load("push", "carbody", point, ROWS, over, axes)
    law = bare(replace(manchester(), loads=(load,)))
    force, q, _ = resultants(law, t=63.0)
    still, _, _ = resultants(bare(replace(manchester(), loads=())), t=63.0)
    change = force - still
    i = 6 * law.vehicle.index("carbody")
    heading, roll, pitch = q[i + 3 : i + 6]
    if axes == "track":
        s = float(law._loads["s"][0])
        t, n, b = law.track.centre.frame(s).reshape(-1, 3)[-3:]
    else:
        turn = np.array([[np.cos(heading), -np.sin(heading), 0], [np.sin(heading), np.cos(heading), 0], [0, 0, 1]])
        lean = np.array([[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]])
        nod = np.array([[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]])
        t, n, b = (turn @ lean @ nod).T
        s = float(law._loads["s"][0])
    assert s == pytest.approx(78.0, abs=0.3)  # the point's, not the body's
    along = [np.interp(63.0 if over == "time" else s, *np.transpose(ROWS)[[0, k]]) for k in (1, 2, 3)]
    assert law._loads["force"][0].tolist() == pytest.approx(along, rel=1e-12)
    assert change == pytest.approx(along[0] * t + along[1] * n + along[2] * b, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize(("x", "expected"), [(-5.0, 0), (50.0, 0), (90.0, 2), (1e4, 2)])
def test_a_table_holds_its_ends(x: float, expected: int) -> None:
    load = Load("push", "carbody", (0.0, 0.0, 2.0), ROWS, "time")
    law = bare(replace(manchester(), loads=(load,)))
    resultants(law, t=x)
    assert law._loads["force"][0].tolist() == pytest.approx(ROWS[expected][1:], abs=0.0)
    assert load.force(x, 0.0) == pytest.approx(ROWS[expected][1:], abs=0.0)


def test_what_a_law_remembers_of_its_loads_can_be_put_back() -> None:
    law = on_track(replace(manchester(), loads=(Load("push", "carbody", (0.0, 0.0, 2.0), ROWS, "distance"),)), 20.0).law
    kept = law.get_state()
    q, q_t = design_state(law)
    q[1 : 6 * len(law.bodies) : 6] += 7.0
    out, again = np.zeros(law.size), np.zeros(law.size)
    law(0.3, q, q_t, out)
    assert not np.array_equal(law.get_state(), kept)
    law.set_state(kept)
    assert np.array_equal(law.get_state(), kept)
    law(0.3, q, q_t, again)
    assert np.array_equal(out, again)


# What an acceptance measures on a vehicle that stands still: sway on canted rails, wheel unloading on twisted ones.
ANGLE = asin(0.15 / 1.5)
TWIST = 5e-3 / 1.5


def roll_moment(vehicle: Vehicle, loads: np.ndarray) -> float:
    """Moment of the wheels' loads about the middle of the track [N m]."""
    half = np.array([0.5 * m.wheelset.profile_spacing for m in vehicle.wheelsets])
    return float(np.sum(half * (loads[:, 0] - loads[:, 1])))


def test_what_is_carried_leans_as_a_rigid_body_does():
    vehicle = shipped("wheelset_s1002")
    rest = static_state(canted(vehicle, ANGLE))
    (mounted,), (carried,) = vehicle.wheelsets, vehicle.carried
    radius = mounted.wheelset.mean_radius
    heights = vehicle.gravity * (mounted.mass * radius + carried.mass * (radius + carried.height))
    assert roll_moment(vehicle, rest.wheel_loads) == pytest.approx(sin(ANGLE) * heights, rel=1e-6)


def test_a_twist_unloads_wheels_by_stiffness_turns_no_vehicle_and_works_both_ways():
    # k = 3646 kN/m at 0.62 m to either side of each axle, which rolls against a level frame (Cooperrider 1972)
    vehicle = shipped("cooperrider_bogie")
    twisted, static = static_state(vehicle, TWIST), static_state(vehicle)
    tilt = TWIST * 1.074
    force = 2.0 * 3646e3 * 0.62**2 * tilt / 1.462
    change = twisted.wheel_loads - static.wheel_loads
    assert change == pytest.approx(np.array([[force, -force], [-force, force]]), rel=1e-3)
    vehicle = manchester()
    forward, backward, half = (static_state(vehicle, twist).wheel_loads for twist in (TWIST, -TWIST, 0.5 * TWIST))
    static = vehicle.weight / 8.0
    assert forward.sum() == pytest.approx(vehicle.weight, rel=1e-9)
    assert abs(roll_moment(vehicle, forward)) < 1e-5 * vehicle.weight
    assert forward == pytest.approx(backward[:, ::-1], rel=1e-9)
    assert forward - static == pytest.approx(2.0 * (half - static), abs=1e-2 * np.ptp(forward))
    # the ends of the vehicle are turned most: within a bogie and between the bogies
    assert forward[0, 0] > forward[1, 0] > static > forward[2, 0] > forward[3, 0]


def test_a_vehicle_that_finds_no_rest_is_refused_with_what_is_implausible_and_too_much_cant_overturns(tmp_path):
    text = (shipped_models() / "vehicles/manchester_1.toml").read_text()
    (tmp_path / "v.toml").write_text(text.replace('to = ["outer", "inner"]', 'to = ["outer"]'))
    with pytest.raises(SimulationError, match=r"(?s)overturns.*\nnothing holds wheelset 'front.inner'"):
        stationary(str(tmp_path / "v.toml"))
    with pytest.raises(SimulationError, match="overturns"):
        static_state(canted(manchester(), 0.5))


# A vehicle at rest and in steady motion: weight, symmetry, load transfer.
def wheel_loads(law: VehicleOnTrack) -> np.ndarray:
    """Vertical force of every wheel on its rail (wheelsets, 2) at the state asked for last [N]."""
    return np.array([[wheel.model.arrays.total.Fb for wheel in pair] for pair in law.wheels])


@pytest.mark.parametrize("speed", [0.0, 30.0])
def test_wheel_loads_sum_to_the_weight_and_are_alike_on_both_sides(speed: float) -> None:
    law = on_track(manchester(), speed).law
    rest = steady_state(law)
    law(0.0, rest.q, rest.q_t, np.zeros(law.size))
    loads = wheel_loads(law)
    assert loads.sum() == pytest.approx(law.vehicle.weight, rel=1e-8)
    assert np.allclose(loads[:, 0], loads[:, 1], rtol=1e-9)
    # at rest the springs hold the design position; the wheels sink into the rails alike
    assert speed > 0.0 or np.allclose(loads, law.vehicle.weight / 8.0, rtol=1e-9)


def test_design_position_is_the_position_of_rest() -> None:
    law = on_track(manchester()).law
    rest = steady_state(law)
    heights = rest.q[: 6 * 7 : 6]
    design = np.array([part.centre[2] for part in law.vehicle.parts])
    sunk = design - heights
    assert np.allclose(sunk, sunk[0], atol=1e-9)  # all alike, by the approach of wheel and rail
    assert 1e-4 < sunk[0] < 4e-4  # KP at 54.5 kN


def curved(radius: float, cant: float) -> list[Segment]:
    return [Arc(400.0, radius, cant=cant)]


def mirror(q: np.ndarray, bodies: int) -> np.ndarray:
    """Coordinates (or rates, or forces) seen in a mirror that exchanges left and right."""
    out = q.copy()
    rows = out[: 6 * bodies].reshape(-1, 6)
    rows[:, [2, 3, 4]] *= -1.0
    return out


def test_a_symmetric_vehicle_in_the_mirrored_curve_has_the_mirrored_forces() -> None:
    left, right = (on_track(manchester(), 25.0, curved(radius, 0.06)).law for radius in (800.0, -800.0))
    q, q_t = design_state(left)
    q, q_t = lower_on_rails(left, q, q_t)
    n = 6 * len(left.bodies)
    rng = np.random.default_rng(5)
    q[:n] += 1e-4 * rng.standard_normal(n)
    # the mirrored vehicle has its left elements on the right: exchange what differs from side to side
    a, b = np.zeros(left.size), np.zeros(left.size)
    left(0.0, q, q_t, a)
    right.set_search_start(50.0)
    right(0.0, mirror(q, len(left.bodies)), mirror(q_t, len(left.bodies)), b)
    assert np.abs(mirror(a, len(left.bodies))[:n] - b[:n]).max() < 1e-9 * np.abs(a).max()


def test_load_transfer_in_a_canted_curve_is_that_of_the_closed_form() -> None:
    """Moments about the track: sum b_i Q_i = sum m (a_q z + g_n y_o) + sum I omega kappa V, a_q the cant deficiency.

    b_i is the arm of a wheel's contact, y_o is how far the masses have swayed outward against the wheels; a curve so
    wide that nothing touches a flange."""
    radius, cant, speed = 2500.0, 0.08, 55.0
    law = on_track(manchester(), speed, curved(radius, cant), start=200.0).law
    q, q_t = design_state(law)
    q, q_t = lower_on_rails(law, q, q_t)
    steady = steady_state(law, (q, q_t))
    law(0.0, steady.q, steady.q_t, np.zeros(law.size))
    angle = float(np.arcsin(cant / law.track.cant_base))
    centrifugal = speed**2 / radius
    deficiency = centrifugal * np.cos(angle) - STANDARD_GRAVITY * np.sin(angle)
    normal = STANDARD_GRAVITY * np.cos(angle) + centrifugal * np.sin(angle)
    parts = law.vehicle.parts
    moment = 0.0
    bend = np.mean([m.x**2 for m in law.vehicle.wheelsets])
    for i, part in enumerate(parts):
        coordinates = slice(6 * i, 6 * i + 6)
        pose = poses_on_track(
            law.track.centre, steady.q[None, coordinates], steady.q_t[None, coordinates], 200.0 + part.centre[0]
        )
        outward = -(pose.lateral[0] + (part.centre[0] ** 2 - bend) / (2.0 * radius))  # the curve is to the left
        moment += part.mass * (deficiency * pose.height[0] + normal * outward)
        if i < len(law.vehicle.wheelsets):
            moment += 112.0 * pose.spin_rate[0] * speed / radius
    transfer = 0.0
    for pair in law.wheels:
        for wheel in pair:
            a = wheel.model.arrays
            rows = a.patches[: a.total.lobes]
            contact = wheel.rail_origin[0] + np.average(rows["o"], weights=rows["N"])
            transfer -= wheel.side * a.total.Fb * contact
    assert transfer > 10e3
    assert transfer == pytest.approx(moment, rel=0.01)
