"""A single wheelset is a vehicle: every analysis, elastic rails, drives, bump stops and points serve it too."""

from pathlib import Path

import numpy as np
import pytest
from support.runs import FAST, LEADING, SCENARIOS, STEERING, arc, ride, setup_of, straight

from wrsim.analysis import recorded, run
from wrsim.analysis.motion.run import run_in_time
from wrsim.analysis.ride import evaluate_ride
from wrsim.analysis.steady import steady_in_curve
from wrsim.plots import standard_pictures
from wrsim.scenario.build import build
from wrsim.scenario.loading import Scenario, load
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

FILE = (Path(__file__).parents[1] / "data/axle.toml").read_text()


def study(analysis: str, **values: object) -> dict[str, object]:
    """Keys of a study of the steering wheelset."""
    keys = {f"{analysis}.{key}": value for key, value in values.items()}
    return FAST | {"vehicle.model": STEERING} | keys


def test_the_steady_motion_of_a_wheelset_is_where_its_run_starts() -> None:
    keys = study("steady", radius_m=300, cant_mm=60, speed_kmh=54, combine="rows") | {"contact.friction": 0.35}
    setup = build(load(SCENARIOS / "steady_manchester.toml").with_values(keys))
    found = steady_in_curve(setup, setup.plan.points[0])
    started = run_in_time(
        setup_of([arc(40.0, 300.0, 60.0)], 15.0, STEERING, start=10.0, values=FAST | {"run.distance_m": 0.1})
    )
    first = started.wheelset().isel(time=0)
    found.law(0.0, found.q, found.q_t, np.zeros(found.law.size))
    totals = [wheel.model.arrays.total for wheel in found.law.wheels[0]]
    assert [-total["Fo"] for total in totals] == pytest.approx(first["Y"].values, rel=1e-5)
    assert [total["Fb"] for total in totals] == pytest.approx(first["Q"].values, rel=1e-6)


def test_a_steady_table_of_a_wheelset_has_its_messages_and_pictures(tmp_path: Path) -> None:
    keys = study("steady", radius_m=[600, -600, 40], cant_mm=60, speed_kmh=80, combine="grid")
    result = run(load(SCENARIOS / "steady_manchester.toml").with_values(keys))
    dataset = result.wheelset()
    assert [bool(m) for m in dataset["pose_message"].values] == [False, False, True]
    assert "overturn" in str(dataset["pose_message"].values[2])
    assert dataset["lateral_shift"].values[0] == pytest.approx(-dataset["lateral_shift"].values[1], rel=1e-6)
    assert standard_pictures(result.dataset, tmp_path)


def test_a_wheelset_hunts_from_its_critical_speed_on() -> None:
    keys = study("stability", speed_kmh=[60, 100, 140], nonlinear=False) | {"contact.friction": 0.35}
    scenario = load(SCENARIOS / "stability_manchester.toml")
    attributes = run(scenario.with_values(keys)).dataset.attrs
    critical = attributes["critical_speed_m_s"]
    assert 20.0 < critical < 35.0
    assert "lateral" in attributes["critical_mode"] or "yaw" in attributes["critical_mode"]
    # a run says the same: a small swing dies below this speed and grows above it
    for factor in (0.8, 1.3):
        going = ride(setup_of([straight(400.0)], factor * critical, STEERING, start=20.0, values=FAST))
        start = going.steady(("z", "x", "y", "heading", "roll", "spin"))
        q = start.q.copy()
        q[2] += 2e-4
        swing = going.run(q, start.q_t, 1.5).q[:, 2]
        early, late = np.ptp(swing[100:200]), np.ptp(swing[-100:])
        assert (late > early) == (factor > 1.0), factor


@pytest.mark.parametrize("drive", ["train", "wheels"])
def test_a_drive_holds_the_speed_of_a_wheelset_too(drive: str) -> None:
    keys = FAST | {"vehicle.drive": drive, "run.distance_m": 5.0}
    dataset = run_in_time(setup_of([arc(40.0, 300.0, 60.0)], 15.0, LEADING, start=10.0, values=keys)).wheelset()
    assert dataset["speed"].values == pytest.approx(15.0, rel=1e-3)


def over_a_dip(folder: Path, **values: object) -> Scenario:
    """The axle of ``FILE`` over a dip, at 20 m/s."""
    (folder / "axle.toml").write_text(FILE)
    dip = {"kind": "dip", "at_m": 20.0, "length_m": 2.0, "amplitude_mm": 3.0, "rail": "left"}
    keys = FAST | {"vehicle.model": str(folder / "axle.toml"), "vehicle.speed_kmh": 72.0, "run.start_distance_m": 5.0}
    keys |= {"track.segments": [straight(120.0)], "track.irregularities": [dip]}
    keys |= {"ride.from_m": 15.0, "output.patches_at_m": [20.0]}
    return load(SCENARIOS / "manchester_ride_160.toml").with_values(keys | values)


def test_the_points_of_a_wheelset_ride_and_its_bump_stop_is_an_event(tmp_path: Path) -> None:
    result = run(over_a_dip(tmp_path))
    assert result.status == "completed"
    even = result.dataset["distance"].values < 15.0
    acceleration = result.dataset["point_az"].sel(point="box").values
    # an accelerometer on the axle box does not spin with the wheelset
    assert np.abs(acceleration[even]).max() < 1e-3
    assert np.abs(acceleration).max() > 1.0
    assert evaluate_ride(result).as_dict()["points"]["box"]["rms_m_s2"]["z"] > 0.0
    assert any("bump stop stop is beyond the end of its table" in str(e) for e in result.dataset["event_label"].values)


def test_the_events_of_a_run_in_its_file_are_those_that_it_noted(tmp_path: Path) -> None:
    # samples so far apart that none of them sees the stop at its end
    seldom = over_a_dip(tmp_path, **{"run.distance_m": 60.0, "run.output_interval_ms": 1500.0})
    result = run(seldom, record=tmp_path / "x.part")
    assert result.dataset.sizes["event"] > 0
    assert recorded(tmp_path / "x.part").dataset.identical(result.dataset)


def test_an_accelerometer_on_the_axle_box_shows_the_unbalanced_acceleration(tmp_path: Path) -> None:
    (tmp_path / "axle.toml").write_text(FILE)
    keys = FAST | {"run.distance_m": 0.5}
    setup = setup_of([arc(40.0, 400.0, 60.0)], 20.0, str(tmp_path / "axle.toml"), start=10.0, values=keys)
    dataset = run_in_time(setup).dataset.isel(time=0)
    cant = np.arcsin(0.06 / setup.track.cant_base)
    outward = 400.0 / 400.0 * np.cos(cant) - STANDARD_GRAVITY * np.sin(cant)
    # the axle rolls against the track by some tenths of a milliradian
    assert dataset["point_ay"].item() == pytest.approx(outward, abs=0.02)


@pytest.mark.parametrize("model", [STEERING, pytest.param("vehicles/manchester_1.toml", marks=pytest.mark.campaign)])
def test_a_run_with_the_exact_solver_starts_in_balance_and_keeps_it(model: str) -> None:
    values = {"contact.normal": "half-space", "contact.tangential": "half-space", "contact.half_space.resolution": 12}
    values |= {"run.distance_m": 0.02, "run.output_interval_ms": 0.5, "output.patches_at_m": []}
    result = run_in_time(setup_of([straight(60.0)], 20.0, model, start=20.0, values=values))
    assert result.status == "completed"
    dataset = result.dataset
    weight = build(load(SCENARIOS / "curve_r300.toml").with_values({"vehicle.model": model})).vehicle.weight
    assert dataset["Q"].sum(dim=("wheel", "wheelset")).values == pytest.approx(weight, rel=1e-4)
    assert dataset["Q"].values == pytest.approx(dataset["Q"].values[:1].repeat(dataset.sizes["time"], axis=0), rel=1e-3)
    assert np.isfinite(dataset["element_p"].values).any(axis=(0, 2, 3, 4, 5)).all()  # of every wheelset
