"""The step that a run chooses by itself is short enough: half of it changes nothing that matters, from 1 to 100 m/s."""

import numba
import numpy as np
import pytest
import xarray as xr
from numba.core import sigutils
from scipy.interpolate import CubicSpline
from support.runs import FAST, LEADING, STEERING, arc, setup_of, straight, transition
from support.vehicles import ROOT, SHORT

from wrsim.analysis import run
from wrsim.analysis.assessment.filters import low_pass
from wrsim.analysis.motion.run import run_in_time
from wrsim.scenario.loading import load
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


@pytest.mark.campaign  # in the suite: the orders of both integrators, and half the step of short runs
def test_after_the_low_pass_a_coach_over_a_dip_is_within_half_a_percent_and_converges():
    # one rail dips by 3 mm over 2 m. The low-pass of 20 Hz is that of the assessment; what it takes away, wheels that
    # bounce on their contacts at some 200 Hz, is out of phase with a step of 2 ms
    dip = {"kind": "dip", "at_m": 17.0, "length_m": 2.0, "amplitude_mm": 3.0, "rail": "left"}
    keys = {"track.segments": [straight(60.0)], "track.irregularities": [dip], "run.distance_m": 8.0}
    scenario = load(ROOT / "scenarios/manchester_r300.toml").with_values(SHORT | keys | {"run.start_distance_m": 4.0})

    def filtered(step_us, integrator="generalised-alpha"):
        values = {"run.integrator": integrator, "run.output_interval_ms": max(1e-3 * step_us, 0.5)}
        data = run(scenario.with_values(values | {"run.step_us": step_us})).dataset
        times = data["time"].values
        rate = 1.0 / (times[1] - times[0])
        return times, {name: low_pass(data[name].values.reshape(len(times), -1), rate, 20.0) for name in ("Y", "Q")}

    times, truth = filtered(500, "rk44")
    errors = {}
    for step_us in (2000, 1000):
        at, values = filtered(step_us)
        inside = (at > 0.1) & (at < times[-1] - 0.1)
        errors[step_us] = {
            name: np.abs(values[name] - CubicSpline(times, truth[name])(at))[inside].max() / np.abs(truth[name]).max()
            for name in values
        }
    assert implicit_step(60.0 / 3.6, 10e-3) == pytest.approx(2e-3)
    assert max(errors[2000].values()) < 5e-3
    for name in ("Y", "Q"):  # a quarter, and what Newton's method leaves over
        assert errors[1000][name] < 0.5 * errors[2000][name], errors


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
