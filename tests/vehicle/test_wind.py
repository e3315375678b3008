"""Wind on a vehicle: pressure and angle of the air, the gust along the track, and a run into the wind."""

from dataclasses import replace
from math import inf, radians

import numpy as np
import pytest
from support.rows import rows_of
from support.runs import SCENARIOS
from support.vehicles import manchester

from wrsim import InputError, load, load_vehicle, run
from wrsim.analysis.stationary.statics import static_state
from wrsim.scenario.build import build
from wrsim.vehicle.wind import GUST_FACTOR, Air, felt, gust, gust_decay

table = rows_of(__file__)
SIDE = Air(75.0, 2.3, 1.2, 1.225)


def test_no_wind_is_no_force_and_twice_the_wind_is_four_times_the_force():
    assert np.array(SIDE.forces(0.0, 40.0)) == pytest.approx(0.0)
    train = SIDE.along_track(load_vehicle("trains/manchester_3.toml"), 30.0, 0.0, 100.0, False, 20.0)
    assert [each.body for each in train.loads] == [f"coach{k}.carbody" for k in (1, 2, 3)]
    assert {each.table for each in train.loads} == {
        SIDE.along_track(manchester(), 30.0, 0.0, 100.0, False, 20.0).loads[0].table
    }
    side, lift, roll = SIDE.forces(30.0, 0.0)
    assert side == pytest.approx(0.5 * 1.225 * 30.0**2 * 75.0 * 1.2)
    assert [lift, roll] == pytest.approx([0.0, 2.3 * side])
    assert SIDE.forces(60.0, 0.0)[0] == pytest.approx(4.0 * side)
    assert SIDE.forces(60.0, 80.0)[0] == pytest.approx(4.0 * SIDE.forces(30.0, 40.0)[0])  # at one yaw angle
    # of a running vehicle sin(angle) of the larger pressure: linear in the wind far above its speed
    assert SIDE.forces(30.0, 400.0)[0] == pytest.approx(2.0 * SIDE.forces(15.0, 400.0)[0], rel=1e-2)


def test_coefficients_over_the_angle_push_as_the_force_whose_sine_and_lever_they_hold():
    angles = np.radians(np.arange(0.0, 91.0, 1.0))
    rows = tuple((a, 1.2 * np.sin(a), 0.0, 1.2 * np.sin(a) * 2.3 / 3.0) for a in angles)
    tunnel = Air(75.0, 0.0, 0.0, 1.225, rows, 3.0)
    assert np.array(tunnel.forces(22.0, 50.0)) == pytest.approx(np.array(SIDE.forces(22.0, 50.0)), rel=1e-4)
    by_area, by_tunnel = (static_state(loaded(air)).wheel_loads for air in (SIDE, tunnel))
    assert by_area == pytest.approx(by_tunnel, rel=2e-4)


def loaded(air, wind=22.0):
    return replace(manchester(), loads=air.loads(manchester(), 0.0, wind, 50.0))


def test_lift_takes_its_force_from_the_rails_and_a_roll_moment_its_share_from_one_to_the_other():
    coach = manchester()
    lifting = Air(10.0, 0.0, 0.0, 1.225, ((0.0, 0.0, 2.0, 0.0), (radians(90.0), 0.0, 2.0, 0.0)), 3.0)
    (_, lift, _), rest = lifting.forces(22.0, 50.0), static_state(loaded(lifting))
    assert rest.wheel_loads.sum() == pytest.approx(coach.weight - lift, rel=1e-6)
    turning = Air(10.0, 0.0, 0.0, 1.225, ((0.0, 0.0, 0.0, 1.0), (radians(90.0), 0.0, 0.0, 1.0)), 3.0)
    (_, _, roll), rest = turning.forces(22.0, 50.0), static_state(loaded(turning))
    left, right = rest.wheel_loads.sum(axis=0)
    sway = sum(body.mass * y for body, y in zip(coach.bodies, rest.moved[:, 0], strict=True)) * coach.gravity
    half = 0.5 * coach.wheelsets[0].wheelset.profile_spacing
    assert (left - right) * half == pytest.approx(roll + sway, rel=1e-3)  # towards the lee, the left


def test_a_gust_stands_on_the_mean_wind_and_without_an_end_is_a_steady_wind():
    along = np.array([-1e4, -30.0, 0.0, 30.0, 1e4])
    mean = 34.0 / GUST_FACTOR
    wind = gust(34.0, along)
    assert wind[[0, 2, 4]] == pytest.approx([mean, 34.0, mean])
    assert wind[1] == wind[3] == pytest.approx(mean + (34.0 - mean) * np.exp(-30.0 / gust_decay(mean)))
    assert gust(34.0, along[1:4], decay=inf) == pytest.approx(34.0)
    assert gust(34.0, along[1:4], decay=1e9) == pytest.approx(34.0)
    assert gust_decay(20.0) > gust_decay(10.0)  # a stronger wind carries a whirl farther


def test_a_vehicle_feels_the_mean_over_its_length_of_a_wind_that_begins_softly():
    places, short = felt(30.0, 100.0, 300.0, 0.5, True)
    _, long = felt(30.0, 100.0, 300.0, 25.0, True)
    peak = int(np.argmin(np.abs(places - 300.0)))
    assert short.max() == pytest.approx(30.0) and short.argmax() == peak
    near = np.linspace(-12.5, 12.5, 1001)
    assert long[peak] == pytest.approx(gust(30.0, near).mean(), rel=1e-3)
    assert short[0] == long[0] == 0.0 and np.abs(np.diff(short)).max() < 0.5
    places, steady = felt(30.0, 100.0, 300.0, 25.0, False)
    assert steady[places >= 200.0] == pytest.approx(30.0)


def test_a_run_into_a_steady_wind_ends_with_the_wheel_loads_of_the_rest_in_it():
    gust = {"speed_m_s": 25.0, "towards": "right", "begins_m": 20.0, "peak_m": 120.0, "side_area_m2": 75.0}
    keys = {
        "track.segments": [{"kind": "straight", "length_m": 320.0}],
        "run.distance_m": 260.0,
        "track.irregularities": [],
    }
    scenario = load(SCENARIOS / "manchester_r300.toml").with_values(
        keys | {"vehicle.speed_kmh": 90.0, "vehicle.wind": gust | {"height_m": 2.3}, "contact.normal": "kik-piotrowski"}
    )
    data = run(scenario).dataset
    loads = data["Q"].isel(time=slice(-100, None)).mean("time").values
    # contacts move by up to 15 mm over the profiles, whose middles the rest stands on, of 0.75 m of lever
    assert loads == pytest.approx(static_state(build(scenario).vehicle).wheel_loads, abs=0.02 * 54e3)


@pytest.mark.parametrize(("scenario", "values", "message"), table("a_wind_that_cannot_be_is_refused"))
def test_a_wind_that_cannot_be_is_refused(scenario, values, message):
    with pytest.raises(InputError, match=message):
        build(load(SCENARIOS / scenario).with_values(values))
