"""Radial steering index: cones by hand, sides that differ, what is asked for wrongly."""

import json
from math import atan, degrees, inf

import numpy as np
import pytest
from support.commands import call
from support.runs import ROOT

from wrsim.analysis import run
from wrsim.analysis.conicity.conicity import conicity
from wrsim.geometry.profile.models import load_profile
from wrsim.geometry.profile.sections import circle, cone
from wrsim.results.conicity import FLANGE_FROM, radial_steering, steering_summary
from wrsim.scenario.loading import load
from wrsim.scenario.sections.conicity import ConicityPlan
from wrsim.vehicle.wheelset import Wheel, Wheelset

RADIUS = 0.46
RAIL = circle("round rail", "rail", 0.02, 0.0199)
GAUGE = 1.5 + 2.0 * RAIL.gauge_point()[0]
"""Puts the tops of round rails 1.5 m apart."""


def found(wheels, radii=(RADIUS, RADIUS), flange_from=FLANGE_FROM, rail=RAIL, gauge=GAUGE, curves=()):
    wheelset = Wheelset("w", 1.0, (1.0, 1.0, 1.0), 1.5, *(Wheel(w, r) for w, r in zip(wheels, radii, strict=True)))
    plan = ConicityPlan((3e-3, 7e-3), "none", curves, flange_from)
    return conicity(wheelset, (rail, rail), gauge, plan, "test").wheelset()


@pytest.mark.parametrize("slope", [0.025, 0.2])
def test_a_cone_steers_radially_at_e_r0_over_r_times_its_slope(slope):
    wheel = cone("cone", "wheel", slope, -0.06, 0.06)
    dataset = found((wheel, wheel))
    reach = float(dataset["lateral_shift"].max())
    for radius in (300.0, 2000.0):
        steering = radial_steering(dataset, radius)
        assert steering.needed == pytest.approx(1.5 * RADIUS / radius)
        assert steering.available == pytest.approx(2.0 * slope * reach, rel=1e-6)
        assert steering.index == pytest.approx(0.75 * RADIUS / (radius * slope * reach), rel=1e-6)
        by_hand = 0.75 * RADIUS / (radius * slope)
        assert steering.shift == pytest.approx(by_hand if by_hand <= reach else np.nan, rel=1e-6, nan_ok=True)


def test_a_cone_as_steep_as_a_flange_is_one():
    wheel = cone("cone", "wheel", 0.2, -0.06, 0.06)
    angle = atan(0.2)
    assert radial_steering(found((wheel, wheel), flange_from=1.01 * angle), 300.0).available > 0.0
    steering = radial_steering(found((wheel, wheel), flange_from=0.99 * angle), 300.0)
    assert steering.available == 0.0 and steering.index == inf
    summary = steering_summary(found((wheel, wheel), flange_from=0.99 * angle, curves=(300.0,)))
    assert summary["radial_steering"][0]["q_E"] is None and summary["smallest_radial_curve_m"] is None


def test_the_less_able_side_counts_and_mirrored_wheelsets_are_alike():
    models = ROOT / "models"
    wheel, rail = load_profile(models / "wheels/S1002.toml"), load_profile(models / "rails/60E1.toml").inclined(1 / 40)
    worn = wheel.shifted(dw=1e-3)
    both, one, other = (found(pair, rail=rail, gauge=1.435) for pair in ((wheel, wheel), (wheel, worn), (worn, wheel)))
    first, second = radial_steering(one, 400.0), radial_steering(other, 400.0)
    assert first.available == pytest.approx(second.available, abs=2e-5)
    assert first.index > radial_steering(both, 400.0).index


def test_a_later_flange_makes_more_available_and_the_smallest_curve_follows():
    told = []
    for angle in ("6", "15", "40"):
        asked = ["conicity", "wheels/S1002.toml", "rails/60E1.toml", "--curve-m", "300", "--curve-m", "1200"]
        told.append(json.loads(call(*asked, "--flange-from-deg", angle, "--json").stdout))
    available = [t["radial_steering"][0]["available_mm"] for t in told]
    assert available[0] < available[1] < available[2]
    for answer in told:
        steep, wide = answer["radial_steering"]
        assert steep["q_E"] == pytest.approx(4.0 * wide["q_E"])
        assert steep["q_E"] == pytest.approx(answer["smallest_radial_curve_m"] / 300.0)
        assert (steep["shift_mm"] is None) == (steep["q_E"] > 1.0)


def test_the_scenario_and_the_command_tell_the_same():
    scenario = load(ROOT / "scenarios/conicity_s1002.toml").with_values({"conicity.curve_radius_m": [300.0]})
    own = run(scenario).summary()["wheelsets"]["wheelset"]["radial_steering"]
    asked = ["conicity", "wheels/S1002.toml", "rails/60E1.toml", "--curve-m", "300"]
    assert json.loads(call(*asked, "--json").stdout)["radial_steering"] == own
    assert degrees(ConicityPlan((3e-3,)).flange_from) == pytest.approx(40.0)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--curve-m", "3"], "--curve-m 3.0: must be"),
        (["--curve-m", "300", "--flange-from-deg", "95"], "--flange-from-deg 95.0: must be"),
        (["--curve-m", "300", "--gauges-mm", "1430", "1435", "1"], "no --diameters-mm, -right and --curve-m"),
    ],
)
def test_curves_that_cannot_be_are_refused(arguments, said):
    told = call("conicity", "wheels/S1002.toml", "rails/60E1.toml", *arguments)
    assert told.exit_code == 2 and said in " ".join(told.output.split())
