"""The step that a run chooses by itself is short enough: half of it changes nothing that matters, from 1 to 100 m/s."""

import numpy as np
import pytest
import xarray as xr
from support.runs import LEADING, STEERING, arc, setup_of, straight, transition

from wrsim.analysis.motion.run import run_in_time

STIFF = "vehicles/wheelset_s1002.toml"


def both_steps(segments, speed, vehicle, interval_ms) -> tuple[xr.Dataset, xr.Dataset, float]:
    """The run with the step that it chooses and with half of it; the chosen step [s]."""
    values = {"run.output_interval_ms": interval_ms}
    chosen = run_in_time(setup_of(segments, speed, vehicle, values=values)).wheelset()
    step = chosen.attrs["step_s"]
    values["run.step_us"] = round(0.5e6 * step)
    half = run_in_time(setup_of(segments, speed, vehicle, values=values)).wheelset()
    for dataset in (chosen, half):
        assert dataset.attrs["status"] == "completed"
        for name in ("Y", "Q", "lateral_shift", "yaw", "roll", "spin_rate", "T_gamma"):
            assert np.isfinite(dataset[name].values).all(), name
    return chosen, half, step


def peaks(dataset: xr.Dataset) -> list[float]:
    """Largest Y/Q and Q of either wheel."""
    return [float(dataset[name].isel(wheel=w).max()) for name in ("Y_over_Q", "Q") for w in (0, 1)]


@pytest.mark.parametrize("vehicle", [LEADING, STEERING])
def test_half_the_step_changes_the_peak_y_over_q_in_a_sharp_curve_by_less_than_a_hundredth(vehicle):
    # the sharp curve in short: into 150 m within 12 m, flange root contact
    segments = [straight(2.0), transition(12.0), arc(6.0, 150.0, 50.0, 5.0)]
    chosen, half, _ = both_steps(segments, 10.0, vehicle, 5.0)
    assert peaks(chosen)[:2] == pytest.approx(peaks(half)[:2], rel=1e-2)
    assert max(peaks(half)[:2]) > (0.3 if vehicle is LEADING else 0.1)


@pytest.mark.parametrize(
    ("speed", "way", "radius", "vehicle", "parts"),
    [
        (1.0, 0.25, 150.0, STEERING, 30),
        (2.0, 0.5, 150.0, STEERING, 15),
        (5.0, 1.5, 150.0, STEERING, 6),
        (20.0, 10.0, 400.0, STEERING, 2),
        (50.0, 25.0, 2000.0, STIFF, 1),
        (100.0, 50.0, 6000.0, STIFF, 1),
    ],
)
def test_runs_of_any_speed_are_finite_and_agree_with_half_their_step(speed, way, radius, vehicle, parts):
    segments = [straight(0.2 * way), transition(0.3 * way), arc(0.5 * way, radius)]
    chosen, half, step = both_steps(segments, speed, vehicle, 2.0)
    # creep forces damp slip at a rate like 1/V: the slower, the shorter; always a whole part of a millisecond
    assert 1e-3 / step == pytest.approx(parts, rel=1e-9)
    assert peaks(chosen) == pytest.approx(peaks(half), rel=1e-2, abs=1e-4)
    # a step in whole microseconds does not hit the same instants
    shift, times = chosen["lateral_shift"].values, chosen["time"].values
    inside = times < half["time"].values[-1]
    other = np.interp(times, half["time"].values, half["lateral_shift"].values)
    assert shift[inside] == pytest.approx(other[inside], abs=0.01 * np.ptp(other))
    assert np.ptp(other) > 1e-5  # it does move


def test_samples_are_never_farther_apart_than_asked_for():
    often = setup_of([straight(4.0)], 20.0, STEERING, values={"run.output_interval_ms": 0.3})
    dataset = run_in_time(often).wheelset()
    assert dataset.attrs["step_s"] == pytest.approx(0.25e-3)
    assert np.diff(dataset["time"].values).max() < 0.3e-3


def test_a_run_ends_where_its_track_ends():
    dataset = run_in_time(setup_of([straight(3.0), arc(5.0, 500.0)], 13.0, STEERING)).wheelset()
    assert 8.0 - 13.0 * dataset.attrs["step_s"] < dataset["distance"].values[-1] < 8.0 + 1e-3
    # beyond it the track would go straight on, and the centrifugal force would be gone
    assert dataset["Q"].values[-1] == pytest.approx(dataset["Q"].values[-2], rel=1e-3)
