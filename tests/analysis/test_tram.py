"""A tram's wheelset on grooved rails in a curve of 25 m: flange, guard face, and how they share."""

from functools import cache

import numpy as np
import pytest
import xarray as xr
from support.runs import FAST, SCENARIOS

from wrsim import Result, load, run

RADIUS, AHEAD, MASS, SPEED = 25.0, 0.65, 700.0 + 4500.0, 10.0 / 3.6
FACE = -80.538
"""Of the guard face against the track plane [degrees]."""
GAUGES = (1432.0, 1433.35, 1433.4, 1435.0)
"""A wider track takes the gauge face of the outer rail away, and brings the guard face of the inner rail nearer."""


@cache
def in_the_curve(gauge: float) -> xr.Dataset:
    """The shipped scenario at a gauge [mm] from 14.5 m on, half a metre in steady motion."""
    values = {"track.gauge_mm": gauge, "run.start_distance_m": 14.5, "run.distance_m": 0.5}
    result = run(load(SCENARIOS / "tram_r25.toml").with_values(values | FAST))
    assert result.status == "completed"
    return result.wheelset().isel(time=-1)


def pushed(sample: xr.Dataset) -> tuple[float, float]:
    """What the flange of the outer wheel and the back of the inner one press sideways, without friction [N]."""
    angle, normal = np.degrees(sample["contact_angle"].values), sample["N"].values
    flange = np.nansum(np.where(angle[0] > 30.0, normal[0] * np.sin(np.radians(angle[0])), 0.0))
    guard = np.nansum(np.where(angle[1] < -60.0, -normal[1] * np.sin(np.radians(angle[1])), 0.0))
    return float(flange), float(guard)


def test_the_guard_face_takes_over_as_its_gap_closes_and_the_back_of_the_flange_stands_on_it():
    flange, guard = np.array([pushed(in_the_curve(gauge)) for gauge in GAUGES]).T
    assert guard[0] == 0.0 and flange[0] > 5e3  # the outer flange alone
    assert flange[-1] == 0.0 and guard[-1] > 5e3  # the guard face alone
    assert (np.diff(flange) < 0.0).all() and (np.diff(guard) > 0.0).all()
    assert flange[2] > 1e3 and guard[1] > 1e3  # both at once
    sample = in_the_curve(GAUGES[-1])
    angle = np.degrees(sample["contact_angle"].values[1])
    assert np.nanmin(angle) == pytest.approx(FACE, abs=0.2)
    assert sample["lateral_shift"].item() < in_the_curve(GAUGES[0])["lateral_shift"].item() + 1.5e-3


@pytest.mark.parametrize("gauge", GAUGES)
def test_whoever_guides_the_forces_balance(gauge):
    """Level track: Y of the left rail less that of the right one, and the frame's force, carry the curve."""
    sample = in_the_curve(gauge)
    left, right = sample["Y"].values
    outward = MASS * SPEED**2 / RADIUS
    assert left - right - sample["guide_force_y"].item() == pytest.approx(outward, rel=0.01)
    assert sample["Q"].sum().item() == pytest.approx(MASS * 9.80665, rel=1e-3)
    assert sample["yaw"].item() == pytest.approx(AHEAD / RADIUS, abs=1e-3)  # but for the springs of the axle


@cache
def car(contact_of_the_file: bool) -> Result:
    """The shipped car, through the transition and along the curve."""
    result = run(load(SCENARIOS / "tram_car_r25.toml").with_values({} if contact_of_the_file else FAST))
    assert result.status == "completed"
    return result


def test_rails_carry_the_car_around_the_curve():
    """Once it has settled: forces in the axes of the car's middle against masses times V^2 r / R^2, their radii by the
    chords of the car and of its bogies; 1 %, for it sways a little. Wheel loads are its weight."""
    late = car(False).dataset.where(car(False).dataset["distance"] > 33.0, drop=True)
    ahead = (late["wheelset_distance"].values - late["distance"].values[:, None]) / RADIUS
    across = late["Y"].values[..., 0] - late["Y"].values[..., 1]
    inward = across * np.cos(ahead) - late["X"].values.sum(axis=-1) * np.sin(ahead)
    chord = [(2800.0, 0.0), (5000.0, AHEAD), (18000.0, 3.5)]
    turning = (15.0 / 3.6 / RADIUS) ** 2 * sum(m * (RADIUS - half**2 / (2.0 * RADIUS)) for m, half in chord)
    assert inward.sum(axis=1).mean() == pytest.approx(turning, rel=0.01)
    assert late["Q"].sum(("wheelset", "wheel")).mean().item() == pytest.approx(25800.0 * 9.80665, rel=1e-3)


def test_guard_faces_lead_both_bogies_and_independent_wheels_do_not_fight():
    """Backs of both leading inner wheels on the guard face; lengthwise forces an eighth of rigid axles'."""
    last = car(False).dataset.isel(time=-1)
    angle, normal = np.degrees(last["contact_angle"].values), last["N"].values
    on_face = np.nansum(np.where(angle < -70.0, normal, 0.0), axis=-1)
    assert on_face[0, 1] > 30e3
    assert on_face[2, 1] > 10e3
    assert np.delete(on_face.ravel(), [1, 5]).max() == 0.0
    lengthwise = np.abs(last["X"].values)
    assert lengthwise[2:].max() < lengthwise[:2].max() / 8.0


@pytest.mark.parametrize("contact_of_the_file", [False, pytest.param(True, marks=pytest.mark.campaign)])
def test_what_the_pull_gives_creep_takes(contact_of_the_file):
    """Within 1.5 %: two blows on guard faces, in which steps are cut."""
    energy = car(contact_of_the_file).summary()["energy"]
    assert abs(energy["left_over_kJ"]) < 0.015 * energy["work_of_pull_kJ"]
    assert energy["work_of_pull_kJ"] > 100.0


# The light rail vehicle with independent wheels in its curve of 300 m: laws that hold with any profiles.
@cache
def through(contact: str) -> xr.Dataset:
    """The shipped scenario from the full curve on, 3 m in steady motion."""
    keys = {"run.start_distance_m": 150.0, "run.distance_m": 3.0, "vehicle.drive": "train", "contact.normal": contact}
    dataset = run(load(SCENARIOS / "irw_r300.toml").with_values(FAST | keys)).dataset
    assert dataset.attrs["status"] == "completed"
    return dataset


def test_no_creep_forces_lengthwise_steer():
    """The shipped rigid wheelsets have some 10 kN here (GZ18); these have what angle of attack and drag leave."""
    dataset = through("kik-piotrowski")
    assert np.abs(dataset["X"].values).max() < 300.0
    assert np.abs(dataset["X"].diff("wheel").values).max() < 200.0


@pytest.mark.parametrize("normal", ["kik-piotrowski", pytest.param("strips", marks=pytest.mark.campaign)])
def test_it_stays_where_the_search_for_its_steady_motion_puts_it(normal):
    """A run that starts in the full curve: the wheels stay within 20 um and Q within 1 % for 3 m, with the front bogie
    at the outer rail and the rear one at the inner rail."""
    dataset = through(normal)
    shift, load_ = dataset["lateral_shift"].values, dataset["Q"].values
    assert np.abs(shift - shift[0]).max() < 20e-6
    assert np.abs(load_ - load_[0]).max() < 0.01 * load_.mean()
    assert (shift[0, :2] > 9e-3).all()
    assert (shift[0, 2:] < -9e-3).all()
