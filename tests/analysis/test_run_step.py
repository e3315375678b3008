"""The step that a run chooses by itself is short enough: half of it changes nothing that matters, from 1 to 100 m/s."""

import numba
import numpy as np
import pytest
import xarray as xr
from numba.core import sigutils
from support.runs import FAST, LEADING, STEERING, arc, setup_of, straight, transition

from wrsim.analysis.motion.run import run_in_time
from wrsim.simulation.ahead import LARGE
from wrsim.simulation.step_size import implicit_step

STIFF = "vehicles/wheelset_s1002.toml"


def both_steps(segments, speed, vehicle, interval_ms, integrator, contact=FAST) -> tuple[xr.Dataset, xr.Dataset, float]:
    """The run with the step that it chooses and with half of it; the chosen step [s]."""
    values = contact | {"run.output_interval_ms": interval_ms, "run.integrator": integrator}
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


@pytest.mark.parametrize(
    ("vehicle", "integrator", "contact"),
    [
        (LEADING, "generalised-alpha", FAST),
        pytest.param(LEADING, "generalised-alpha", {}, marks=pytest.mark.campaign),
        pytest.param(LEADING, "rk44", {}, marks=pytest.mark.campaign),
        pytest.param(STEERING, "generalised-alpha", {}, marks=pytest.mark.campaign),
    ],
)
def test_half_the_step_changes_the_peak_y_over_q_in_a_sharp_curve_by_less_than_a_hundredth(
    vehicle, integrator, contact
):
    # the sharp curve in short: into 150 m within 12 m, flange root contact
    segments = [straight(2.0), transition(12.0), arc(6.0, 150.0, 50.0, 5.0)]
    chosen, half, _ = both_steps(segments, 10.0, vehicle, 5.0, integrator, contact)
    assert peaks(chosen)[:2] == pytest.approx(peaks(half)[:2], rel=1e-2)
    assert max(peaks(half)[:2]) > (0.3 if vehicle is LEADING else 0.1)


SPEEDS = ((1.0, 0.1, 150.0, STEERING, 26), (5.0, 1.5, 150.0, STEERING, 6), (20.0, 10.0, 400.0, STEERING, 2),
          (100.0, 50.0, 6000.0, STIFF, 1))  # fmt: skip
SHORT_FORMS = [(*of, "generalised-alpha", FAST) for of in (SPEEDS[0], *SPEEDS[2:])] + [(*SPEEDS[3], "rk44", FAST)]
BOTH = ("generalised-alpha", "rk44")
LONG_FORMS = [pytest.param(*of, by, {}, marks=pytest.mark.campaign) for of in SPEEDS for by in BOTH]


@pytest.mark.parametrize(
    ("speed", "way", "radius", "vehicle", "parts", "integrator", "contact"), [*SHORT_FORMS, *LONG_FORMS]
)
def test_runs_of_any_speed_are_finite_and_agree_with_half_their_step(
    speed, way, radius, vehicle, parts, integrator, contact
):
    segments = [straight(0.2 * way), transition(0.3 * way), arc(0.5 * way, radius)]
    chosen, half, step = both_steps(segments, speed, vehicle, 2.0, integrator, contact)
    # creep forces damp slip at a rate like 1/V. To RK44 that means: the slower, the shorter
    assert 1e-3 / step == pytest.approx(parts if integrator == "rk44" else 0.5, rel=1e-9)
    assert peaks(chosen) == pytest.approx(peaks(half), rel=1e-2, abs=1e-4)
    # a step in whole microseconds does not hit the same instants
    shift, times = chosen["lateral_shift"].values, chosen["time"].values
    inside = times < half["time"].values[-1]
    other = np.interp(times, half["time"].values, half["lateral_shift"].values)
    assert shift[inside] == pytest.approx(other[inside], abs=0.01 * np.ptp(other))
    assert np.ptp(other) > 1e-5  # it does move


def test_samples_are_never_farther_apart_than_asked_for():
    for integrator, step in (("rk44", 0.25e-3), ("generalised-alpha", 0.3e-3)):
        values = FAST | {"run.output_interval_ms": 0.3, "run.integrator": integrator}
        dataset = run_in_time(setup_of([straight(2.0)], 20.0, STEERING, values=values)).wheelset()
        assert dataset.attrs["step_s"] == pytest.approx(step)
        assert np.diff(dataset["time"].values).max() < 0.3e-3 * (1.0 + 1e-9)


@pytest.mark.parametrize(
    ("speed", "interval_ms", "step_ms"), [(50.0, 5, 5 / 3), (16.0, 10, 2), (12, 5, 2.5), (1, 50, 5)]
)
def test_the_implicit_step_divides_the_time_between_two_samples(speed, interval_ms, step_ms):
    assert implicit_step(speed, 1e-3 * interval_ms) == pytest.approx(1e-3 * step_ms)


def test_a_run_ends_where_its_track_ends():
    dataset = run_in_time(setup_of([straight(3.0), arc(5.0, 500.0)], 13.0, STEERING)).wheelset()
    assert 8.0 - 13.0 * dataset.attrs["step_s"] < dataset["distance"].values[-1] < 8.0 + 1e-3
    # beyond it the track would go straight on, and the centrifugal force would be gone
    # which loads the outer wheel by 8 %
    assert dataset["Q"].values[-1] == pytest.approx(dataset["Q"].values[-2], rel=1e-2)


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_large_kernels_are_compiled_for_the_types_that_a_run_calls_them_with():
    setup = setup_of([straight(30.0)], 10.0, STIFF, values=FAST | {"run.distance_m": 0.1})
    run_in_time(setup)
    for kernel, types in LARGE:
        assert list(kernel.overloads) == [sigutils.normalize_signature(types)[0]]
