"""The shipped rest scenario: a wheelset on straight, level track carries its weight evenly and stands in the middle."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from support.rows import rows_of
from support.runs import FAST, LEADING, SCENARIOS, STEERING, arc, setup_of, straight

from wrsim import InputError, Result, Scenario, SimulationError, load, run
from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.run import run_in_time
from wrsim.analysis.motion.start import start_state
from wrsim.analysis.steady import cant_deficiency
from wrsim.results.tables import tables
from wrsim.scenario.build import Setup, build
from wrsim.scenario.sections.steady import SteadyPoint
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


def test_a_wheelset_that_rests_in_a_canted_curve_leans_to_the_inner_rail():
    radius, cant, widening = -150.0, 60.0, 10.0
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


def test_a_coach_that_rests_where_cant_rises_leans_on_its_rails_with_its_weight():
    scenario = load(SCENARIOS / "manchester_r300.toml")  # 100 mm of cant rise from 40 to 90 m
    scenario = scenario.with_values(FAST | {"analysis": "equilibrium", "run.start_distance_m": 75.0})
    setup, rest = build(scenario), run(scenario).dataset.isel(time=0)
    sine, weight = 0.07 / setup.track.cant_base, setup.vehicle.weight
    assert float(rest.Q.sum()) == pytest.approx(weight * np.sqrt(1.0 - sine**2), rel=1e-4)
    assert float(rest.sum_Y.sum()) == pytest.approx(weight * sine, rel=1e-3)


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
    message = str(refused.value)
    assert "no steady motion to start from at 0 m and 54 km/h" in message
    assert "The right wheel is the smaller one by 80 mm of radius: to roll straight" in message


# Steady curving against time integration, closed forms and symmetry.
def manchester(**values) -> Scenario:
    """The shipped scenario with some keys of [steady] changed, coarse patches."""
    keys = {f"steady.{key}": value for key, value in values.items()}
    return load(SCENARIOS / "steady_manchester.toml").with_values(FAST | keys)


@cache
def curves() -> Result:
    """Two hands, and a curve that no coach runs through at that speed."""
    return run(manchester(combine="rows", radius_m=[600, -600, 150], cant_mm=[100, 100, 0], speed_kmh=[60, 60, 150]))


def test_a_curve_to_the_right_is_the_mirror_image_with_the_same_cant_deficiency() -> None:
    left, right = curves().dataset.isel(pose=0), curves().dataset.isel(pose=1)
    assert left["Y"].values == pytest.approx(
        right["Y"].values[:, ::-1], abs=20.0
    )  # N of some 12 kN: patches are coarse
    assert left["lateral_shift"].values == pytest.approx(-right["lateral_shift"].values, abs=1e-5)
    assert left["Y_over_Q"].values[0, 1] > 0.15  # the leading outer wheel leans on its flange root
    points = [SteadyPoint("", radius, 0.1, 20.0) for radius in (300.0, -300.0)]
    expected = 1.5 * 20.0**2 / (STANDARD_GRAVITY * 300.0) - 0.1
    assert [cant_deficiency(point, 1.5) for point in points] == pytest.approx([expected] * 2)


def test_a_curve_without_steady_motion_says_so_and_the_others_are_there():
    result = curves()
    messages = result.dataset["pose_message"].values
    assert list(messages[:2]) == ["", ""]
    assert "overturn" in messages[2] and "cant deficiency 1770 mm" in messages[2]
    assert np.isnan(result.dataset["Y"].values[2]).all()
    assert (result.dataset["unbalanced"].values[:2] < 1e-4).all()
    summary = result.summary()
    assert summary["extent"] == {"poses": 3, "solved": 2}
    assert list(summary["without_steady_motion"]) == [str(result.dataset["pose"].values[2])]


def test_its_tables_have_a_row_for_every_wheel_and_curve(tmp_path):
    result = curves()
    assert len(tables(result.dataset)["steady"]) == 1 + 2 * 8 + 1
    (steady,) = result.numbers()
    assert any(row[0] == "rear.inner left" for row in steady.rows) and "overturn" in " ".join(steady.notes)
    assert Result.load(result.save(tmp_path / "result.nc")).dataset.identical(result.dataset)


def test_an_interrupted_study_keeps_the_curves_it_has():
    def impatient(fraction: float, left: float) -> None:
        raise KeyboardInterrupt

    result = run(manchester(radius_m=[1500, 1200], speed_kmh=70), impatient)
    assert result.status == "stopped" and "after 1 of 2 curves" in result.stop_reason
    assert result.dataset.sizes["pose"] == 1


@pytest.mark.parametrize(("values", "message"), table("bad_input_is_answered_with_one_clear_line"))
def test_bad_input_is_answered_with_one_clear_line(values, message):
    with pytest.raises(InputError, match=message):
        build(load(SCENARIOS / "steady_manchester.toml").with_values(values))


# Steady curving against statics: forces and moments of the wheels balance weight, centrifugal force and springs.
#
# Left and right curves, with cant deficiency and with cant excess, on wheelsets that steer themselves and that a bogie
# holds. Written for a left curve: outward is to the right, the right wheel is the outer one; right curves are mirrored.
# vehicle, radius [m], cant [mm], speed [m/s]
DEFICIENCY = (STEERING, 300.0, 60.0, 20.0)
EXCESS = (STEERING, 400.0, 100.0, 8.0)
RIGHT = (STEERING, -300.0, 60.0, 20.0)
BOGIE = (LEADING, 160.0, 50.0, 10.0)
CASES = (DEFICIENCY, EXCESS, RIGHT, BOGIE)


@dataclass(frozen=True)
class Curve:
    """Steady curving as if the curve went to the left: the inner and the outer wheel at one moment, and its strips."""

    setup: Setup
    speed: float
    curvature: float
    sample: xr.Dataset
    strips: xr.Dataset

    @property
    def masses(self) -> tuple[float, float]:
        """Of the wheelset and of what it carries [kg]."""
        return self.setup.wheelset.mass, self.setup.vehicle.carried[0].mass

    @property
    def cant_angle(self) -> float:
        """[rad]"""
        return float(np.arcsin(abs(self.setup.track.cant(self.setup.plan.start)) / self.setup.track.cant_base))

    @property
    def outward(self) -> float:
        """Acceleration outward in the track plane that is not balanced by the cant [m/s2]."""
        centrifugal = self.speed**2 * self.curvature
        return centrifugal * np.cos(self.cant_angle) - STANDARD_GRAVITY * np.sin(self.cant_angle)

    @property
    def down(self) -> float:
        """Acceleration normal to the track plane [m/s2]."""
        centrifugal = self.speed**2 * self.curvature
        return STANDARD_GRAVITY * np.cos(self.cant_angle) + centrifugal * np.sin(self.cant_angle)

    @property
    def shift(self) -> float:
        """Of the wheelset, outward [m]."""
        return -float(self.sample["lateral_shift"])

    @property
    def held(self) -> float:
        """What the guide frame takes of the lateral force, inward [N]."""
        return float(self.sample["guide_force_y"])

    def of_both_wheels(self, name: str) -> np.ndarray:
        """A channel of the inner and the outer wheel."""
        return self.sample[name].values


@cache
def steady(vehicle: str, radius: float, cant_mm: float, speed: float) -> Curve:
    """A moment in a full curve."""
    setup = setup_of([arc(30.0, radius, cant_mm)], speed, vehicle, start=10.0, values={"run.distance_m": 0.5})
    dataset = run_in_time(setup).wheelset().isel(time=0, snapshot=0)
    if radius < 0.0:
        dataset = dataset.isel(wheel=[1, 0])
        for name in ("lateral_shift", "yaw", "roll", "y_contact", "guide_force_y"):
            dataset[name] = -dataset[name]
    strips = dataset[[name for name in dataset if str(name).startswith("strip_")]]
    return Curve(setup, speed, 1.0 / abs(radius), dataset, strips)


def overturning(curve: Curve) -> float:
    """Moment outward about the centre line, at the height of the rail tops [N m], of all but the wheels.

    Centrifugal force at the axle and at the sprung mass, springs at the axle, the spin that is carried round the curve,
    and the weight at the shifted centre of mass."""
    wheelset = curve.setup.wheelset
    radius, height = wheelset.mean_radius, curve.setup.vehicle.carried[0].height
    mass, sprung = curve.masses
    return (
        (mass * radius + sprung * (radius + height)) * curve.outward
        - curve.held * radius
        + wheelset.inertia[1] * curve.speed**2 * curve.curvature / radius
        + (mass + sprung) * curve.down * curve.shift
    )


@pytest.mark.parametrize("case", CASES)
def test_forces_of_the_wheels_are_in_balance_with_weight_springs_and_the_curve(case):
    """Vertical and lateral forces, and the moment of all strips about the centre line at the height of the rail tops;
    the frame holds by its springs, of a bogie also forward ones that have turned with it."""
    curve = steady(*case)
    # the wheelset's own centre is a little off the centre line: 1e-5 of the centrifugal force
    assert curve.of_both_wheels("Q").sum() == pytest.approx(sum(curve.masses) * curve.down, rel=1e-5)
    inner, outer = curve.of_both_wheels("Y")
    weight = sum(curve.masses) * STANDARD_GRAVITY
    assert outer - inner == pytest.approx(sum(curve.masses) * curve.outward - curve.held, abs=1e-5 * weight)
    across = np.sin(curve.setup.vehicle.guide_ahead * curve.curvature) * float(curve.sample["guide_force_x"])
    stiffness = 2.0 * curve.setup.vehicle.elements[0].stiffness[1]
    assert curve.held == pytest.approx(stiffness * curve.shift - across, rel=1e-3)
    strips = {name: curve.strips[f"strip_{name}"].values for name in ("N", "Fy", "angle", "y", "z")}
    sine, cosine = np.sin(strips["angle"]), np.cos(strips["angle"])
    outward = -strips["N"] * sine + strips["Fy"] * cosine  # from the centre line, on either wheel
    up = strips["N"] * cosine + strips["Fy"] * sine
    rail = curve.setup.track.left_curve  # both rails are alike
    place = 0.5 * curve.setup.track.nominal_gauge + rail.outward + strips["y"]
    height = rail.height + strips["z"]
    moments = np.nansum(up * place - outward * height, axis=(1, 2))  # of each wheel, tipping towards the other
    static = 0.5 * weight * 0.75
    assert np.diff(moments).item() == pytest.approx(overturning(curve), abs=1e-4 * static)
