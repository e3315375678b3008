"""Overturning beside the balance of moments, symmetry, and an accident."""

import numpy as np
import pytest
from support.runs import SCENARIOS

from wrsim.analysis import run
from wrsim.analysis.overturning import at_speed, side_force
from wrsim.analysis.stationary.statics import static_state
from wrsim.errors import InputError, SimulationError
from wrsim.plots.overturning import overturning_figures
from wrsim.results.overturning import overturning_tables, summarise_overturning
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.scenario.sections.overturning import Wind


def wind(*speeds):
    return {"wind": {"speed_m_s": list(speeds), "side_area_m2": 75.0, "height_m": 2.3}}


def scenario(**keys):
    return load(SCENARIOS / "overturning.toml").with_values({f"overturning.{key}": v for key, v in keys.items()})


@pytest.fixture(scope="module")
def found():
    """Without wind and with some."""
    keys = {"tolerance_kmh": 2.0, "lowest_kmh": 150.0, "highest_kmh": 350.0}
    return run(scenario(**wind(0.0, 25.0), **keys)).dataset


@pytest.mark.parametrize("radius", [945.0, -945.0])
def test_moments_about_the_track_are_in_balance_with_all_bodies_where_they_have_moved(radius):
    setup = build(scenario(radius_m=radius))
    vehicle, speed = setup.vehicle, 230.0 / 3.6
    state = static_state(at_speed(setup, vehicle, speed, 0.0))
    tilt = np.arcsin(0.163 / setup.track.cant_base)
    outward, down = (
        speed**2 / 945.0 * np.cos(tilt) - vehicle.gravity * np.sin(tilt),
        vehicle.gravity * np.cos(tilt) + speed**2 / 945.0 * np.sin(tilt),
    )
    left = -np.sign(radius) * outward
    mass = np.array([body.mass for body in vehicle.bodies])
    place = np.array([body.centre[1:] for body in vehicle.bodies]) + state.moved[:, :2]
    tipping = np.sum(mass * (left * place[:, 1] + down * place[:, 0]))
    tipping += sum(m.mass * left * m.height for m in vehicle.wheelsets)
    half = 0.5 * vehicle.wheelsets[0].wheelset.profile_spacing
    assert np.diff(state.wheel_loads.sum(axis=0))[0] * -half == pytest.approx(tipping, rel=2e-3)
    assert state.wheel_loads.sum() == pytest.approx(vehicle.mass * down, rel=1e-4)


def test_a_coach_overturns_where_its_inner_wheels_have_lost_their_load(found):
    still, windy = summarise_overturning(found)["limits"]
    # the closed form of a rigid coach, half the width over the height of its centre, is an upper bound
    setup = build(scenario())
    limit = setup.vehicle.gravity * (0.75 / setup.vehicle.centre[2] + 0.163 / 1.5) / (1 - 0.75 / 1.44 * 0.163 / 1.5)
    assert 0.8 * limit < (still["overturns_kmh"] / 3.6) ** 2 / 945.0 < limit
    assert still["unloaded_kmh"] < still["overturns_kmh"]
    last = found["wheel_unloading"].values[np.flatnonzero(found["overturns"].values)]
    assert last.max(axis=(1, 2)).min() > 0.95
    assert windy["overturns_kmh"] < still["overturns_kmh"]


def test_left_and_right_curves_are_mirrored():
    right, left = (
        static_state(at_speed(setup, setup.vehicle, 45.0, 20.0)).wheel_loads
        for setup in (build(scenario(radius_m=radius, **wind(20.0))) for radius in (945.0, -945.0))
    )
    assert right == pytest.approx(left[:, ::-1], rel=1e-6)


def test_the_wind_on_a_vehicle_at_rest_is_its_pressure_times_the_side():
    side = Wind((30.0,), 75.0, 2.3, 1.2, 1.225)
    assert side_force(side, 30.0, 0.0) == pytest.approx(0.5 * 1.225 * 30.0**2 * 75.0 * 1.2)
    # of a running one sin(angle) of the larger pressure: linear in the speed far above that of the wind
    assert side_force(side, 30.0, 400.0) == pytest.approx(side_force(side, 15.0, 400.0) * 2.0, rel=1e-2)


@pytest.mark.campaign
def test_a_coach_stands_at_the_speed_of_the_line_and_falls_at_that_of_an_accident():
    # R 945 m, cant 163 mm: line speed 176, derailed at 243 km/h (Eckwersheim 2015, BEA-TT)
    data = run(scenario(run=True, tolerance_kmh=2.0, lowest_kmh=176.0)).dataset
    assert 176.0 < 3.6 * data.attrs["run_stands_m_s"] < 3.6 * data.attrs["run_falls_m_s"] <= 243.0
    assert "derailed" in data.attrs["run_end"]


def test_table_and_picture_tell_every_wind(found, sketched):
    summary = summarise_overturning(found)
    (table,) = overturning_tables(found, summary)
    assert [row[0] for row in table.rows] == [0.0, 25.0]
    pictures = {name: make().axes[0] for name, make in overturning_figures(found).items()}
    assert len(pictures["overturning"].get_lines()) == 3
    assert len(pictures["overturning_wind"].get_lines()) >= 2


def test_what_cannot_be_looked_for_is_refused():
    for keys, words in (
        (wind(20.0) | {"run": True}, "wind"),
        ({"highest_kmh": 10.0}, "highest_kmh"),
        ({"radius_m": 5.0}, "radius_m"),
    ):
        with pytest.raises(InputError, match=words):
            run(scenario(**keys))
    with pytest.raises(InputError, match="single wheelset"):
        run(scenario().with_values({"vehicle.model": "vehicles/wheelset_s1002.toml"}))
    with pytest.raises(SimulationError, match=r"overturns .* already"):
        run(scenario(radius_m=100.0, lowest_kmh=200.0))
