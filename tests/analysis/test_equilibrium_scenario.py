"""The shipped rest scenario: a wheelset on straight, level track carries its weight evenly and stands in the middle."""

from typing import Any

import numpy as np
import pytest
from support.rows import rows_of
from support.runs import FAST, SCENARIOS, STEERING, setup_of, straight

from wrsim.analysis import run
from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.run import run_in_time
from wrsim.analysis.motion.start import start_state
from wrsim.errors import SimulationError
from wrsim.scenario.build import Setup, build
from wrsim.scenario.loading import load
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

table = rows_of(__file__)

BARE = 1813.0  # mass of the wheelset [kg]


def resting(**values):
    """Set-up and dataset of the rest scenario with some keys changed (dots written as two underscores)."""
    scenario = load(SCENARIOS / "equilibrium_s1002.toml")
    scenario = scenario.with_values({key.replace("__", "."): value for key, value in values.items()})
    result = run(scenario)
    assert (result.status, result.analysis) == ("completed", "equilibrium")
    return build(scenario), result.wheelset().isel(time=0)


@pytest.mark.parametrize(
    "keys",
    table("a_resting_wheelset_stands_in_the_middle_on_even_wheels"),
    ids=lambda keys: " ".join(f"{key.split('__')[-1]}={value}" for key, value in keys.items()) or "as shipped",
)
def test_a_resting_wheelset_stands_in_the_middle_on_even_wheels(keys):
    setup, rest = resting(**keys)
    half = 0.5 * (BARE + sum(c.mass for c in setup.vehicle.carried)) * STANDARD_GRAVITY
    assert rest.Q.values == pytest.approx([half, half], rel=1e-6)
    assert abs(rest.lateral_shift.item()) < 1e-9
    assert abs(rest.yaw.item()) < 1e-9
    assert abs(rest["roll"].item()) < 1e-9
    # nothing moves, so nothing creeps: each wheel leans outward with what gravity makes of its contact angle
    assert rest.T_gamma.values == pytest.approx(0.0, abs=1e-9)
    assert np.abs(rest.X.values).max() < 1e-6 * half
    angle = rest.contact_angle_mean.values[:, 0]
    assert rest.Y.values == pytest.approx(rest.Q.values * np.tan(angle), rel=1e-4)  # two lobes: mean of their means


@pytest.mark.parametrize(("radius", "cant", "widening"), [(300.0, 150.0, 0.0), (-150.0, 60.0, 10.0)])
def test_a_wheelset_that_rests_in_a_canted_curve_leans_to_the_inner_rail(radius, cant, widening):
    segment = {"kind": "arc", "radius_m": radius, "length_m": 50.0, "cant_mm": cant, "gauge_widening_mm": widening}
    keys = {"track__segments": [segment], "run__start_distance_m": 20.0}
    keys |= {key.replace(".", "__"): value for key, value in FAST.items()}
    setup, rest = resting(vehicle__model="vehicles/wheelset_s1002_steering.toml", **keys)
    weight = setup.vehicle.weight
    angle = np.arcsin(1e-3 * cant / setup.track.cant_base)
    inner, outer = ("left", "right") if radius > 0.0 else ("right", "left")
    inward = np.sign(radius) * rest.lateral_shift.item()
    assert inward > 1e-3
    assert rest.Q.values.sum() == pytest.approx(weight * np.cos(angle), rel=1e-6)
    assert rest.Q.sel(wheel=inner).item() > rest.Q.sel(wheel=outer).item()
    held = 2.0 * setup.vehicle.elements[0].stiffness[1] * inward
    guided = rest.Y.sel(wheel=inner).item() - rest.Y.sel(wheel=outer).item()
    assert guided == pytest.approx(weight * np.sin(angle) - held, rel=1e-5)


# Unequal wheels on straight track: the wheelset runs towards the smaller one, to its flange root if need be.
def wheelset(left_mm: float, right_mm: float, **values: Any) -> Setup:
    """Five metres of straight track at 54 km/h."""
    keys = FAST | {"vehicle.radius_left_mm": left_mm, "vehicle.radius_right_mm": right_mm}
    return setup_of([straight(5.0)], 15.0, STEERING, values=keys | {k.replace("__", "."): v for k, v in values.items()})


def test_cones_shift_by_half_the_difference_over_their_conicity():
    setup = wheelset(461.0, 460.0, vehicle__wheel="wheels/cone_1in20.toml")
    q, _ = start_state(setup, force_law(setup))
    # 0.5 mm over 1/20: 10 mm; the lateral spring takes a little of it back by yaw
    assert q[2] == pytest.approx(-0.5e-3 / 0.05, rel=0.02)


def test_where_there_is_no_such_place_the_message_says_what_is_asked_of_the_wheelset():
    setup = wheelset(500.0, 420.0)
    with pytest.raises(SimulationError) as refused:
        run_in_time(setup)
    words = str(refused.value)
    assert "no steady motion to start from at 0 m and 54 km/h" in words
    assert "The right wheel is the smaller one by 80 mm of radius: to roll straight" in words
