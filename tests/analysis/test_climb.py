"""Flange climbing beside Nadal's limit, rolling without slip, and TCRP Report 71."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from support.rows import rows_of
from support.runs import SCENARIOS

from wrsim.analysis import run
from wrsim.analysis.assessment.nadal import nadal_limit
from wrsim.errors import InputError
from wrsim.geometry.profile.flange import flange_dimensions, flank_of
from wrsim.geometry.profile.models import load_profile
from wrsim.plots.climb import climb_figure
from wrsim.results.climb import climb_tables, summarise_climb
from wrsim.scenario.loading import load

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
    path.write_text("\n".join(lines + [f"{key} = {value}" for key, value in numbers.items()]))
    return str(path)


def climb(wheel, **keys):
    values = {"vehicle.wheel": wheel, "climb.longest_m": 20.0}
    values |= {f"climb.{key}" if "." not in key else key: value for key, value in keys.items()}
    return run(load(SCENARIOS / "climb.toml").with_values(values)).dataset


@pytest.fixture(scope="module")
def climbs(wheel):
    """Below, just above and far above Nadal's limit, at two angles of attack."""
    return climb(wheel, angle_of_attack_mrad=[5.0, 20.0], Y_over_Q=[0.95 * LIMIT, 1.1 * LIMIT, 1.99])


def test_a_wheel_climbs_above_nadals_limit_and_not_below_it(climbs):
    assert climbs["climbed"].values.tolist() == [0, 1, 1, 0, 1, 1]
    assert climbs["nadal_limit"].values == pytest.approx(LIMIT, rel=1e-6)


@pytest.mark.campaign
def test_the_rail_holds_a_wheel_below_nadals_limit_for_200_m(wheel):
    held = climb(wheel, angle_of_attack_mrad=[2.5, 10.0, 20.0], Y_over_Q=[0.97 * LIMIT], longest_m=200.0)
    assert not held["climbed"].values.any()


def test_a_climb_is_shorter_with_a_larger_force_and_a_larger_angle_of_attack(climbs):
    ways = climbs["climb_distance"].values.reshape(2, 3)[:, 1:]
    assert (ways[:, 1] < ways[:, 0]).all()
    assert (ways[1] < ways[0]).all()


def test_the_way_hardly_depends_on_the_speed_and_not_on_the_contact_model(wheel, climbs):
    expected = climbs["climb_distance"].values[2]
    for keys in ({"vehicle.speed_kmh": 9.0}, {"contact.normal": "strips"}):
        own = climb(wheel, angle_of_attack_mrad=[5.0], Y_over_Q=[1.99], **keys)["climb_distance"].item()
        assert own == pytest.approx(expected, rel=0.05)  # inertia lengthens it at a higher speed


@pytest.mark.parametrize("angle", [70.0, pytest.param(68.0, marks=pytest.mark.campaign)])
def test_ways_are_those_of_tcrp_report_71(tmp_path, angle):
    # Y/Q 1.99, length 0.6 in; the formula knows neither the radius of the tip nor that of the rail's corner
    wheel = flanged(tmp_path / "wheel.toml", angle, 15.24)
    own = climb(wheel, angle_of_attack_mrad=[0.0, 5.0], Y_over_Q=[1.99])
    assert own["climb_distance"].values == pytest.approx(own["climb_distance_tcrp"].values, rel=0.16)


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


@pytest.mark.parametrize(("keys", "words"), table("what_cannot_climb_is_refused"))
def test_what_cannot_climb_is_refused(keys, words):
    with pytest.raises(InputError, match=words):
        run(scenario().with_values(keys))


def test_a_tip_that_does_not_fit_is_refused(tmp_path):
    with pytest.raises(InputError, match="flange_length_mm"):
        load_profile(flanged(tmp_path / "wheel.toml", 70.0, 5.0))
