"""Flange climbing beside Nadal's limit, rolling without slip, and TCRP Report 71."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.rows import rows_of
from support.runs import SCENARIOS

from wrsim import InputError, SimulationError, load, load_profile, run
from wrsim.analysis.overturning import at_speed, stopped_at
from wrsim.analysis.stationary.statics import static_state
from wrsim.assessment.nadal import nadal_limit
from wrsim.contact.profiles.flange import flange_dimensions, flank_of
from wrsim.plots.climb import climb_figure
from wrsim.plots.overturning import overturning_figures
from wrsim.results.climb import climb_tables, summarise_climb
from wrsim.results.overturning import overturning_tables, summarise_overturning
from wrsim.scenario.build import build

table = rows_of(__file__)

LIMIT = nadal_limit(np.radians(70.0), 0.5)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A flange of 70 degrees and 15 mm, with 11.5 mm of flank less the arc of the tip."""
    return flanged(tmp_path_factory.mktemp("wheel") / "wheel.toml", 70.0, 15.0)


def flanged(path: Path, angle: float, length: float, **more) -> str:
    keys = {"name": "flange", "body": "wheel", "kind": "flanged", "source": "definition"}
    numbers = {"flange_angle_deg": angle, "flange_length_mm": length} | more
    lines = [f'{key} = "{value}"' for key, value in keys.items()] + ["date = 2026-11-26"]
    path.write_text("\n".join(lines + [f"{key} = {value}" for key, value in numbers.items()]), encoding="utf-8")
    return str(path)


def climb(wheel, **keys):
    values = {"vehicle.wheel": wheel, "climb.longest_m": 20.0}
    values |= {f"climb.{key}" if "." not in key else key: value for key, value in keys.items()}
    return run(load(SCENARIOS / "climb.toml").with_values(values)).dataset


@pytest.fixture(scope="module")
def climbs(wheel):
    """Below, just above and far above Nadal's limit, at two angles of attack."""
    asked = {"angle_of_attack_mrad": [5.0, 20.0], "Y_over_Q": [0.95 * LIMIT, 1.1 * LIMIT, 1.99]}
    return climb(wheel, longest_m=8.0, **asked)


def test_a_wheel_climbs_above_nadals_limit_and_not_below_it(climbs):
    assert climbs["climbed"].values.tolist() == [0, 1, 1, 0, 1, 1]
    assert climbs["nadal_limit"].values == pytest.approx(LIMIT, rel=1e-6)


def test_the_way_of_a_climb_depends_on_force_and_angle_and_hardly_on_speed_and_model(climbs, wheel):
    ways = climbs["climb_distance"].values.reshape(2, 3)[:, 1:]
    assert (ways[:, 1] < ways[:, 0]).all()
    assert (ways[1] < ways[0]).all()
    expected = climbs["climb_distance"].values[2]
    for keys in ({"vehicle.speed_kmh": 9.0}, {"contact.normal": "strips"}):
        distance = climb(wheel, angle_of_attack_mrad=[5.0], Y_over_Q=[1.99], **keys)["climb_distance"].item()
        assert distance == pytest.approx(expected, rel=0.05)  # inertia lengthens it at a higher speed


@pytest.mark.parametrize("angle", [70.0, pytest.param(68.0, marks=pytest.mark.campaign)])
def test_ways_are_those_of_tcrp_report_71(tmp_path, angle):
    # Y/Q 1.99, length 0.6 in; the formula knows neither the radius of the tip nor that of the rail's corner
    wheel = flanged(tmp_path / "wheel.toml", angle, 15.24)
    climbed = climb(wheel, angle_of_attack_mrad=[0.0, 5.0], Y_over_Q=[1.99])
    assert climbed["climb_distance"].values == pytest.approx(climbed["climb_distance_tcrp"].values, rel=0.16)


def test_summary_table_and_picture_tell_what_was_found(climbs, sketched):
    summary = summarise_climb(climbs)
    assert summary["climbed"] == 4
    assert summary["climb_distance_min_m"] == climbs["climb_distance"].values[5]
    (table,) = climb_tables(climbs, summary)
    assert [row[-1] for row in table.rows] == ["is held", "climbs", "climbs"] * 2
    (axes,) = climb_figure(climbs).axes
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert len(labels) == 4
    assert labels[0].endswith("held")


@pytest.mark.parametrize(("angle", "length", "thickness"), [(70.0, 15.0, 32.5), (75.0, 12.0, 26.0), (60.0, 20.0, 30.0)])
def test_a_flanged_profile_has_the_angle_length_and_thickness_of_its_file(tmp_path, angle, length, thickness):
    profile = load_profile(flanged(tmp_path / "wheel.toml", angle, length, thickness_mm=thickness))
    flank = flank_of(profile)
    assert np.degrees(flank.angle) == pytest.approx(angle, abs=1e-6)
    # the root's arc is as steep as the flank to 0.1 degrees over 14 mm times that
    assert flank.length(np.arctan(0.5)) == pytest.approx(1e-3 * length, abs=0.06e-3)
    assert flange_dimensions(profile).thickness == pytest.approx(1e-3 * thickness, abs=1e-8)
    assert float(profile.at(profile.arclength_of(0.0))[1]) == pytest.approx(0.0, abs=1e-9)


def test_flange_of_s1002():
    flank = flank_of(load_profile("wheels/S1002.toml"))
    assert np.degrees(flank.angle) == pytest.approx(70.0, abs=0.01)  # EN 13715


@cache
def scenario():
    return load(SCENARIOS / "climb.toml")


@pytest.mark.parametrize(("keys", "message"), table("what_cannot_climb_is_refused"))
def test_what_cannot_climb_is_refused(keys, message):
    with pytest.raises(InputError, match=message):
        run(scenario().with_values(keys))


def test_what_cannot_be_looked_for_or_does_not_fit_is_refused(tmp_path):
    for keys, message in (({"highest_kmh": 10.0}, "highest_kmh"), ({"radius_m": 5.0}, "radius_m")):
        with pytest.raises(InputError, match=message):
            run(in_wind(**keys))
    with pytest.raises(InputError, match="single wheelset"):
        run(in_wind().with_values({"vehicle.model": "vehicles/wheelset_s1002.toml"}))
    with pytest.raises(SimulationError, match=r"overturns .* already"):
        run(in_wind(radius_m=100.0, lowest_kmh=200.0))
    with pytest.raises(InputError, match="flange_length_mm"):
        load_profile(flanged(tmp_path / "wheel.toml", 70.0, 5.0))


# Overturning beside the balance of moments, symmetry, and an accident.
def wind(*speeds):
    return {"wind": {"speed_m_s": list(speeds), "side_area_m2": 75.0, "height_m": 2.3}}


def in_wind(**keys):
    return load(SCENARIOS / "overturning.toml").with_values({f"overturning.{key}": v for key, v in keys.items()})


@pytest.fixture(scope="module")
def overturning():
    """Without wind and with some."""
    keys = {"tolerance_kmh": 5.0, "lowest_kmh": 150.0, "highest_kmh": 350.0}
    return run(in_wind(**wind(0.0, 25.0), **keys)).dataset


@pytest.mark.parametrize("radius", [945.0, -945.0])
def test_moments_about_the_track_are_in_balance_with_all_bodies_where_they_have_moved(radius):
    setup = build(in_wind(radius_m=radius))
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


def test_a_coach_overturns_where_its_inner_wheels_have_lost_their_load(overturning):
    still, windy = summarise_overturning(overturning)["limits"]
    # the closed form of a rigid coach, half the width over the height of its centre, is an upper bound
    setup = build(in_wind())
    limit = setup.vehicle.gravity * (0.75 / setup.vehicle.centre[2] + 0.163 / 1.5) / (1 - 0.75 / 1.44 * 0.163 / 1.5)
    assert 0.8 * limit < (still["overturns_kmh"] / 3.6) ** 2 / 945.0 < limit
    assert still["unloaded_kmh"] < still["overturns_kmh"]
    last = overturning["wheel_unloading"].values[np.flatnonzero(overturning["overturns"].values)]
    assert last.max(axis=(1, 2)).min() > 0.95
    assert windy["overturns_kmh"] < still["overturns_kmh"]


def test_left_and_right_curves_are_mirrored():
    right, left = (
        static_state(at_speed(setup, setup.vehicle, 45.0, 20.0)).wheel_loads
        for setup in (build(in_wind(radius_m=radius, **wind(20.0))) for radius in (945.0, -945.0))
    )
    assert right == pytest.approx(left[:, ::-1], rel=1e-6)


def test_a_coach_that_comes_through_a_curve_falls_there_in_a_gust(monkeypatch):
    monkeypatch.setattr("wrsim.analysis.overturning.RUN_ON", 1.0)
    monkeypatch.setattr("wrsim.analysis.overturning.RISING", 3.0)
    gusty = wind(40.0)["wind"] | {"gust": "EN 14067-6"}
    calm, windy = (build(in_wind(run=True, **more)) for more in ({}, {"wind": gusty}))
    assert not stopped_at(calm, 150.0 / 3.6)
    assert stopped_at(windy, 150.0 / 3.6)


@pytest.mark.campaign
def test_a_coach_stands_at_the_speed_of_the_line_and_falls_at_that_of_an_accident():
    # R 945 m, cant 163 mm: line speed 176, derailed at 243 km/h (Eckwersheim 2015, BEA-TT)
    data = run(in_wind(run=True, tolerance_kmh=2.0, lowest_kmh=176.0)).dataset
    assert 176.0 < 3.6 * data.attrs["run_stands_m_s"] < 3.6 * data.attrs["run_falls_m_s"] <= 243.0
    assert "derailed" in data.attrs["run_end"]


def test_table_and_picture_tell_every_wind(overturning, sketched):
    summary = summarise_overturning(overturning)
    (table,) = overturning_tables(overturning, summary)
    assert [row[0] for row in table.rows] == [0.0, 25.0]
    pictures = {name: make().axes[0] for name, make in overturning_figures(overturning).items()}
    assert len(pictures["overturning"].get_lines()) == 3
    assert len(pictures["overturning_wind"].get_lines()) >= 2
