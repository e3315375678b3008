"""A run of a whole vehicle: its result has every wheelset, and each reads like a lone one."""

import logging
from pathlib import Path

import numba
import numpy as np
import pytest
import xarray as xr
from numba.core import sigutils
from support.runs import FAST, SCENARIOS, STEERING, arc, setup_of, straight, transition
from support.vehicles import ROOT, SHORT, into_the_curve, manchester

from wrsim import InputError, Scenario, load, run
from wrsim.analysis import recorded
from wrsim.analysis.motion.run import run_in_time
from wrsim.analysis.motion.start import straight_before
from wrsim.analysis.ride import evaluate_ride
from wrsim.results import CHANNELS
from wrsim.results.tables import tables
from wrsim.scenario.build import build
from wrsim.simulation.precompile import LARGE
from wrsim.simulation.step_size import implicit_step
from wrsim.vehicle.wheelset import STANDARD_GRAVITY


def test_every_wheelset_of_the_result_can_be_taken_out() -> None:
    result = into_the_curve()
    assert result.status == "completed"
    dataset = result.dataset
    names = [m.name for m in manchester().wheelsets]
    assert list(dataset["wheelset"].values) == names
    assert dataset["Y"].dims == ("time", "wheelset", "wheel")
    second = result.wheelset(names[1])
    for name, variable in second.data_vars.items():
        assert variable.dims == tuple(d for d in CHANNELS[str(name)].dims_in("time") if d != "wheelset"), name
    assert np.array_equal(second["Q"].values, dataset["Q"].values[:, 1])
    assert np.array_equal(second["distance"].values, dataset["wheelset_distance"].values[:, 1])
    names_of_second = {name.removeprefix("wheelset_2/") for name in tables(dataset) if name.startswith("wheelset_2/")}
    assert names_of_second == set(tables(second))
    assert set(result.summary()["wheelsets"]) == set(names)
    with pytest.raises(InputError, match="did you mean 'front"):
        result.wheelset("front.oter")
    with pytest.raises(InputError, match=r"choose a wheelset: 1 front\.outer, 2 "):
        result.wheelset()


def test_driven_axles_hold_the_speed_as_a_pull_does() -> None:
    """Moments on the axles show as longitudinal creep forces; together they are the pull that the coach needs."""
    keys = SHORT | {"vehicle.drive": "wheels", "run.distance_m": 24.0}
    dataset = run(load(ROOT / "scenarios/manchester_r300.toml").with_values(keys)).dataset
    assert np.allclose(dataset["speed"].values, 60.0 / 3.6, rtol=2e-3)
    samples = dataset.sizes["time"]
    last = slice(samples - 20, samples)
    driven, pulled = (d.isel(time=last).mean(dim="time") for d in (dataset, into_the_curve().dataset))
    # the curve takes power, and as much of it either way
    pull = pulled["drive_force"].item()
    assert pull > 300.0
    assert driven["drive_force"].item() == pytest.approx(pull, rel=2e-3)
    # without a pull every axle pushes its quarter itself, against the rails
    more = (pulled["X"] - driven["X"]).sum(dim="wheel").values
    assert more.sum() == pytest.approx(pull, rel=0.01)
    assert more[:3] == pytest.approx(0.25 * pull, rel=0.01)
    assert more[3] == pytest.approx(0.25 * pull, rel=0.03)  # still on its way into the curve


def test_a_run_may_start_in_a_transition_as_one_does_that_has_come_there(caplog: pytest.LogCaptureFixture) -> None:
    """The search for a balance finds none there; a run from the straight track behind passes the same place.

    What goes on before the first step of the run is told."""
    coarse = {key: value for key, value in SHORT.items() if key.startswith("contact.")}
    curve = load(ROOT / "scenarios/manchester_r150.toml").with_values(coarse | {"run.output_interval_ms": 2.0})
    in_transition = curve.with_values({"run.start_distance_m": 28.0, "run.distance_m": 0.5})
    straight = straight_before(build(in_transition))
    assert straight is not None and 10.0 < straight < 28.0
    with caplog.at_level(logging.INFO, "wrsim.start"):
        begun = run(in_transition).dataset
    way = f"of {28.0 - straight:.0f} m"
    ways = [line for line in caplog.messages if "runs in" in line and line.endswith(way)]
    assert ways and ways[-1].endswith(f"{28.0 - straight:.0f} {way}") and not caplog.messages[-1]
    passed = run(curve.with_values({"run.start_distance_m": straight, "run.distance_m": 28.6 - straight})).dataset
    places, behind = begun["distance"].values, passed["distance"].values
    for name in ("Q", "Y"):
        begun_values, expected = begun[name].values, passed[name].values
        for wheel in np.ndindex(begun_values.shape[1:]):
            passed_values = np.interp(places, behind, expected[:, *wheel])
            assert np.abs(begun_values[:, *wheel] - passed_values).max() < 0.005 * np.abs(expected).max(), (name, wheel)


def test_irregularities_are_kept_under_every_wheelset_at_its_own_place() -> None:
    dip = {"kind": "dip", "at_m": 23.78, "length_m": 2.0, "amplitude_mm": 3.0, "rail": "left"}
    keys = SHORT | {"track.irregularities": [dip], "run.distance_m": 2.4}
    dataset = run(load(ROOT / "scenarios/manchester_r300.toml").with_values(keys)).dataset
    vertical = dataset["rail_vertical"]
    assert vertical.dims == ("time", "wheelset", "wheel")
    assert vertical.values[:, 0, 0].min() == pytest.approx(-3e-3, rel=0.02)  # the first wheelset passes its middle
    assert np.abs(vertical.values[:, 1:]).max() < 1e-3  # the others are not there yet
    assert np.abs(vertical.values[..., 1]).max() == 0.0


# A single wheelset is a vehicle: every analysis, elastic rails, drives, bump stops and points serve it too.
FILE = (Path(__file__).parents[1] / "data/axle.toml").read_text()


def over_a_dip(folder: Path, **values: object) -> Scenario:
    """The axle of ``FILE`` over a dip, at 20 m/s."""
    (folder / "axle.toml").write_text(FILE)
    dip = {"kind": "dip", "at_m": 20.0, "length_m": 2.0, "amplitude_mm": 3.0, "rail": "left"}
    keys = FAST | {"vehicle.model": str(folder / "axle.toml"), "vehicle.speed_kmh": 72.0, "run.start_distance_m": 5.0}
    keys |= {"track.segments": [straight(120.0)], "track.irregularities": [dip]}
    keys |= {"ride.from_m": 15.0, "output.patches_at_m": [20.0]}
    return load(SCENARIOS / "manchester_ride_160.toml").with_values(keys | values)


def test_points_ride_with_their_wheelset_and_events_in_the_file_are_those_noted(tmp_path: Path) -> None:
    result = run(over_a_dip(tmp_path))
    assert result.status == "completed"
    even = result.dataset["distance"].values < 15.0
    acceleration = result.dataset["point_az"].sel(point="box").values
    # an accelerometer on the axle box does not spin with the wheelset
    assert np.abs(acceleration[even]).max() < 1e-3
    assert np.abs(acceleration).max() > 1.0
    assert evaluate_ride(result).as_dict()["points"]["box"]["rms_m_s2"]["z"] > 0.0
    assert any("bump stop stop is beyond the end of its table" in str(e) for e in result.dataset["event_label"].values)
    # samples so far apart that none of them sees the stop at its end
    seldom = over_a_dip(tmp_path, **{"run.distance_m": 40.0, "run.output_interval_ms": 1500.0})
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
    values = {"contact.normal": "half-space", "contact.tangential": "half-space", "contact.half_space.resolution": 8}
    values |= {"run.distance_m": 0.02, "run.output_interval_ms": 0.5, "output.patches_at_m": []}
    result = run_in_time(setup_of([straight(60.0)], 20.0, model, start=20.0, values=values))
    assert result.status == "completed"
    dataset = result.dataset
    weight = build(load(SCENARIOS / "curve_r300.toml").with_values({"vehicle.model": model})).vehicle.weight
    assert dataset["Q"].sum(dim=("wheel", "wheelset")).values == pytest.approx(weight, rel=1e-4)
    assert dataset["Q"].values == pytest.approx(dataset["Q"].values[:1].repeat(dataset.sizes["time"], axis=0), rel=1e-3)
    assert np.isfinite(dataset["element_p"].values).any(axis=(0, 2, 3, 4, 5)).all()  # of every wheelset


# The step that a run chooses by itself is short enough: half of it changes nothing that matters, from 1 to 100 m/s.
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


SPEEDS = ((1.0, 0.1, 150.0, STEERING, 26), (5.0, 1.5, 150.0, STEERING, 6), (20.0, 10.0, 400.0, STEERING, 2),
          (100.0, 50.0, 6000.0, STIFF, 1))  # fmt: skip
SHORT_FORMS = [(*of, "generalised-alpha", FAST) for of in (SPEEDS[0], SPEEDS[3])] + [(*SPEEDS[3], "rk44", FAST)]
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
    of_half_step = np.interp(times, half["time"].values, half["lateral_shift"].values)
    assert shift[inside] == pytest.approx(of_half_step[inside], abs=0.01 * np.ptp(of_half_step))
    assert np.ptp(of_half_step) > 1e-5  # it does move


def test_samples_are_never_farther_apart_than_asked_for_up_to_the_end_of_the_track():
    for integrator, step in (("rk44", 0.25e-3), ("generalised-alpha", 0.3e-3)):
        values = FAST | {"run.output_interval_ms": 0.3, "run.integrator": integrator}
        dataset = run_in_time(setup_of([straight(2.0)], 20.0, STEERING, values=values)).wheelset()
        assert dataset.attrs["step_s"] == pytest.approx(step)
        assert np.diff(dataset["time"].values).max() < 0.3e-3 * (1.0 + 1e-9)
    dataset = run_in_time(setup_of([straight(3.0), arc(5.0, 500.0)], 13.0, STEERING)).wheelset()
    assert 8.0 - 13.0 * dataset.attrs["step_s"] < dataset["distance"].values[-1] < 8.0 + 1e-3
    # beyond it the track would go straight on, and the centrifugal force would be gone
    # which loads the outer wheel by 8 %
    assert dataset["Q"].values[-1] == pytest.approx(dataset["Q"].values[-2], rel=1e-2)


@pytest.mark.parametrize(
    ("speed", "interval_ms", "step_ms"), [(50.0, 5, 5 / 3), (16.0, 10, 2), (12, 5, 2.5), (1, 50, 5)]
)
def test_the_implicit_step_divides_the_time_between_two_samples(speed, interval_ms, step_ms):
    assert implicit_step(speed, 1e-3 * interval_ms) == pytest.approx(1e-3 * step_ms)


@pytest.mark.skipif(numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_large_kernels_are_compiled_for_the_types_that_a_run_calls_them_with():
    setup = setup_of([straight(30.0)], 10.0, STIFF, values=FAST | {"run.distance_m": 0.1})
    run_in_time(setup)
    for kernel, types in LARGE:
        assert list(kernel.overloads) == [sigutils.normalize_signature(types)[0]]
