"""The shipped rest scenario: a wheelset on straight, level track carries its weight evenly and stands in the middle."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from support.rows import rows_of
from support.runs import FAST, SCENARIOS, STEERING, setup_of, straight

from wrsim.analysis import run
from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.run import run_in_time
from wrsim.analysis.motion.start import start_state
from wrsim.errors import SimulationError
from wrsim.scenario.build import Setup, build
from wrsim.scenario.loading import load
from wrsim.vehicle.vehicle import MountedWheelset
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


def test_the_axle_load_is_that_of_the_file():
    setup, rest = resting()
    assert rest.Q.values.sum() == pytest.approx((1813.0 + 9307.5) * STANDARD_GRAVITY, rel=1e-6)
    assert setup.vehicle.weight == pytest.approx(rest.Q.values.sum(), rel=1e-6)
    # S1002 on 60E1 1:40, centred: contact 3 mm outside of the tape circle (CONTACT says the same to 1 mm)
    assert rest.u_wheel.values[:, 0] == pytest.approx([3.2e-3, 3.2e-3], abs=1e-3)
    assert rest.p0.values[:, 0] == pytest.approx([755.8e6, 755.8e6], rel=0.02)  # the half-space solver's


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


@cache
def run_with(left_mm: float, right_mm: float) -> xr.Dataset:
    return run_in_time(wheelset(left_mm, right_mm)).wheelset()


def test_three_millimetres_are_rolled_off_on_the_flange_root_of_the_smaller_wheel():
    run = run_with(463.0, 460.0)
    shift = run["lateral_shift"].values
    assert -7e-3 < shift[0] < -5.5e-3
    assert shift == pytest.approx(shift[0], abs=1e-6), "it is steady"
    first = run.isel(time=0)
    assert np.degrees(first["contact_angle_max"].sel(wheel="right").max()) > 15.0
    assert np.degrees(first["contact_angle_max"].sel(wheel="left").max()) < 2.0
    # wheels that rolled 3 mm apart would slip by 3.25 mm a metre from each other: 160 kN of creep forces at once
    assert np.abs(first["X"].values).max() < 0.02 * first["Q"].values.max()
    # spin that the contact angle of the root brings; two patches on one wheel, which turn each other
    assert first["n_patches"].sel(wheel="right") == 2
    fx = first["Fx"].sel(wheel="right").values[:2]
    assert fx[0] * fx[1] < 0.0


def test_cones_shift_by_half_the_difference_over_their_conicity():
    setup = wheelset(461.0, 460.0, vehicle__wheel="wheels/cone_1in20.toml")
    q, _ = start_state(setup, force_law(setup))
    # 0.5 mm over 1/20: 10 mm; the lateral spring takes a little of it back by yaw
    assert q[2] == pytest.approx(-0.5e-3 / 0.05, rel=0.02)


def test_a_coach_with_one_unequal_wheelset_has_a_steady_motion_too():
    keys = FAST | {"track.segments": [straight(60.0)], "output.patches_at_m": []}
    setup = build(load(SCENARIOS / "manchester_r300.toml").with_values(keys))
    first, *others = setup.vehicle.wheelsets
    whole = replace(setup, vehicle=replace(setup.vehicle, wheelsets=(_unequal(first, 3e-3), *others)))
    shift = start_state(whole, force_law(whole))[0][2:24:6]
    assert -7e-3 < shift[0] < -5e-3
    assert -6e-3 < shift[1] < -3e-3, "its bogie turns the second one along"
    assert np.abs(shift[2:]).max() < 1e-4


def _unequal(mounted: MountedWheelset, apart: float) -> MountedWheelset:
    """The wheelset with a left wheel that is larger by so much in radius [m]."""
    own = mounted.wheelset
    left, right = (replace(w, radius=w.radius + 0.5 * d) for w, d in ((own.left, apart), (own.right, -apart)))
    return replace(mounted, wheelset=replace(own, left=left, right=right))


def test_where_there_is_no_such_place_the_message_says_what_is_asked_of_the_wheelset():
    setup = wheelset(500.0, 420.0)
    with pytest.raises(SimulationError) as refused:
        run_in_time(setup)
    words = str(refused.value)
    assert "no steady motion to start from at 0 m and 54 km/h" in words
    assert "The right wheel is the smaller one by 80 mm of radius: to roll straight" in words
