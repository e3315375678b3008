"""The shipped rest scenario: a wheelset on straight, level track carries its weight evenly and stands in the middle."""

import numpy as np
import pytest
from support.runs import SCENARIOS

from wrsim.analysis import run
from wrsim.scenario.build import build
from wrsim.scenario.loading import load
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

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
    [
        {},
        {"contact__friction_left": 0.1, "contact__friction_right": 0.5},
        {"contact__friction": 0.0},
        {"contact__tangential": "none"},
        {"contact__normal": "kik-piotrowski", "contact__approach": "constant"},
        {"vehicle__sprung_mass_kg": 0.0},
        {"vehicle__sprung_mass_kg": 20e3},
        {"track__inclination": "1:20"},
        {"track__rail": "rails/54E1.toml"},
    ],
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


def test_the_axle_load_is_that_of_the_file():
    setup, rest = resting()
    assert rest.Q.values.sum() == pytest.approx((1813.0 + 9307.5) * STANDARD_GRAVITY, rel=1e-6)
    assert setup.vehicle.weight == pytest.approx(rest.Q.values.sum(), rel=1e-6)
    # S1002 on 60E1 1:40, centred: contact 3 mm outside of the tape circle (CONTACT says the same to 1 mm)
    assert rest.u_wheel.values[:, 0] == pytest.approx([3.2e-3, 3.2e-3], abs=1e-3)
    assert rest.p0.values[:, 0] == pytest.approx([755.8e6, 755.8e6], rel=0.02)  # the half-space solver's


@pytest.mark.parametrize(
    ("radius", "cant", "widening"), [(300.0, 150.0, 0.0), (-300.0, 150.0, 0.0), (-150.0, 60.0, 10.0)]
)
def test_a_wheelset_that_rests_in_a_canted_curve_leans_to_the_inner_rail(radius, cant, widening):
    segment = {"kind": "arc", "radius_m": radius, "length_m": 50.0, "cant_mm": cant, "gauge_widening_mm": widening}
    keys = {"track__segments": [segment], "run__start_distance_m": 20.0}
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
