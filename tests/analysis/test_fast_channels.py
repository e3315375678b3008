"""Channels of a run that are stored more often than the others."""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from support.rows import rows_of
from support.runs import SCENARIOS

from wrsim import InputError, Result, load, run
from wrsim.analysis import between, cost_of, exact_run_warning
from wrsim.analysis.run_times import learn
from wrsim.results.exports import export_result
from wrsim.scenario.build import build

table = rows_of(__file__)

QUICK = {"contact.normal": "kik-piotrowski", "run.step_us": 100}
FAST = {"run.fast_channels": ["Q", "rail_displacement_z", "axle_box_acceleration", "vertical_shift", "roll"]}


def sleepers(**more):
    keys = QUICK | {"vehicle.out_of_round[0].at_deg": 37.0, "run.start_distance_m": 6.2, "run.distance_m": 0.6}
    keys |= {"run.output_interval_ms": 2.0, "run.channels_at_hz": 5000.0}
    return load(SCENARIOS / "flat_on_sleepers.toml").with_values(keys | more)


@cache
def at_each_step(step):
    """With a sample each step."""
    return run(sleepers(**FAST | {"run.channels_at_hz": 1e6 / step})).dataset


@cache
def struck():
    return run(sleepers(**FAST))


def test_the_other_channels_stay_to_the_bit_and_common_instants_have_the_same_numbers():
    plain, fast = run(sleepers()).dataset, struck().dataset
    assert "fast_time" not in plain.dims
    for name in plain.data_vars:
        assert plain[name].identical(fast[name]), name
    assert fast.sizes["fast_time"] == pytest.approx(10 * fast.sizes["time"], abs=10)
    assert_allclose(np.diff(fast["fast_time"]), 2e-4, rtol=1e-9)
    common = np.searchsorted(fast["time"], fast["fast_time"][::10])
    for name in ("Q", "rail_displacement_z", "vertical_shift", "distance"):
        assert_array_equal(fast[f"fast_{name}"][::10], fast[name].values[common])
    between = np.interp(fast["fast_time"], fast["time"], fast["Q"][:, 0, 0])
    assert np.abs(fast["fast_Q"][:, 0, 0] - between).max() > 5e3


def test_the_rail_is_bent_where_the_wheel_strikes_at_the_largest_force_of_all_steps():
    data = at_each_step(QUICK["run.step_us"])
    place = data.attrs["bent_at_m"]
    left = data["fast_Q"].isel(wheelset=0).sel(wheel="left").values
    assert data.attrs["bent_by"] == "wheelset left"
    peak = int(np.argmax(left))
    assert place == pytest.approx(float(data["fast_distance"][peak]), abs=0.01)
    # the nodes lack what the rail yields in the element beneath the wheel, some 2 %
    moved = data["fast_rail_displacement_z"].isel(wheelset=0).values[peak]
    displaced = [np.interp(place, data["bent_place"], data["bent_rail"].sel(wheel=side)) for side in ("left", "right")]
    assert_allclose(displaced, moved, rtol=0.05)
    assert np.abs(data["bent_rail"].values[[0, -1]]).max() < 1e-3 * np.abs(moved).max()
    axes = Result(data).plot("bent").axes[0]
    assert_allclose(axes.lines[0].get_ydata(), 1e3 * data["bent_rail"].sel(wheel="left"))
    assert re.match(r"magnified \d+000 times; vertical lines: wheelsets", axes.get_title(loc="left"))


def test_the_axle_box_accelerates_as_the_axle_moves():
    """Second differences of the height and of the roll of a rigid axle, at a wave that the samples resolve."""
    wave = {"kind": "harmonic", "wheel": "left", "order": 6, "amplitude_mm": 0.05}
    keys = {"vehicle.out_of_round": [wave], "run.output_interval_ms": 1.0, "run.channels_at_hz": 10_000.0}
    scenario = load(SCENARIOS / "flat.toml").with_values(QUICK | FAST | keys)
    data = run(scenario).fast("wheelset")
    height, roll = (data[name].values for name in ("vertical_shift", "roll"))
    half = 0.5 * build(scenario).wheelset.profile_spacing
    box_heights = np.stack([height + half * np.sin(roll), height - half * np.sin(roll)], axis=1)
    accelerations = data["axle_box_acceleration"].values[1:-1]
    expected = np.diff(box_heights, n=2, axis=0) / 1e-4**2
    late = slice(len(accelerations) // 2, None)
    assert np.abs(accelerations[late]).max() > 5.0
    assert_allclose(accelerations[late], expected[late], atol=0.02 * np.abs(accelerations[late]).max())


@pytest.mark.parametrize("integrator, step", [("rk44", 2.5e-4), ("generalised-alpha", 2.5e-4)])
def test_a_step_that_is_chosen_divides_the_time_between_two_samples(integrator, step):
    keys = {"run.integrator": integrator, "run.channels_at_hz": 4000.0, "run.time_s": 0.01, "run.output_interval_ms": 1}
    keys |= {"output.patches_at_m": []}
    keys |= {"run.fast_channels": ["Q"], "track.segments": [{"kind": "straight", "length_m": 20}]}
    data = run(load(SCENARIOS / "curve_r300.toml").with_values(keys | {"contact.normal": "kik-piotrowski"})).dataset
    assert data.attrs["step_s"] <= step
    assert_allclose(np.diff(data["fast_time"]), 2.5e-4, rtol=1e-9)
    assert data.sizes["fast_time"] == 41


def test_the_table_has_a_row_a_sample(tmp_path):
    export_result(struck(), "tables", tmp_path)
    rows = (tmp_path / "fast.csv").read_text().splitlines()
    assert rows[0].split(",")[:2] == ["fast_time_s", "fast_distance_m"]
    assert "fast_Q_left_kN" in rows[0] and "fast_axle_box_acceleration_right_m_s2" in rows[0]
    assert len(rows) == 1 + struck().dataset.sizes["fast_time"]


@pytest.mark.parametrize("keys, message", table("what_cannot_be_stored_is_refused_with_its_key"))
def test_what_cannot_be_stored_is_refused_with_its_key(keys, message):
    with pytest.raises(InputError) as error:
        build(sleepers(**FAST | keys))
    assert message in str(error.value) and "\n" not in str(error.value)


def test_channels_of_parts_that_are_not_there_are_refused():
    rigid = load(SCENARIOS / "curve_r300.toml").with_values({"run.fast_channels": ["Q", "rail_displacement_z"]})
    with pytest.raises(InputError, match=r"fast_channels = .*: entry \[1\] rail_displacement_z .* no elastic rails"):
        build(rigid)
    with pytest.raises(InputError, match=r"no fast channels: .* run.fast_channels"):
        run(load(Path(SCENARIOS / "curve_r300.toml")).with_values({"run.time_s": 0.01})).fast()


def test_the_last_run_on_this_machine_tells_the_time_of_the_next(monkeypatch, tmp_path):
    """Its forecast is a range; what the file of the last run holds that is no number counts for nothing."""
    file = tmp_path / "factors.json"
    monkeypatch.setattr("wrsim.analysis.run_times._file", lambda: file)
    setup = build(load(SCENARIOS / "curve_r300.toml"))
    first = cost_of(setup)
    time = first["expected_time_s"]
    assert first["expected_by"] == "a common processor"
    assert first["expected_range_s"] == pytest.approx([time / 2.0, 2.0 * time], rel=0.05)
    for wall in (5.0 * time, 5.0 * time):  # what is learnt is learnt from
        learn(setup.contact.normal, cost_of(setup)["expected_time_s"], wall)
        assert cost_of(setup)["expected_time_s"] == pytest.approx(5.0 * time, rel=0.06)
    assert cost_of(setup)["expected_by"] == "the last run on this machine"
    learn(setup.contact.normal, time, 0.5)  # too short to tell
    assert cost_of(setup)["expected_time_s"] == pytest.approx(5.0 * time, rel=0.06)
    for odd in ("", "[]", "{", '{"strips": "x"}', '{"strips": -1.0}', '{"strips": 1e9}'):
        file.write_text(odd)
        assert cost_of(setup) == first


def test_the_time_of_a_run_counts_its_fast_samples_and_the_exact_solver_warns_of_them():
    exact = {"contact.normal": "half-space", "run.distance_m": 20, "run.output_interval_ms": 5.0}
    scenario = load(SCENARIOS / "curve_r300.toml").with_values(exact)
    plain = build(scenario)
    fast = build(scenario.with_values({"run.fast_channels": ["Q"], "run.channels_at_hz": 10_000}))
    samples = plain.plan.duration * 10_000
    assert cost_of(fast)["evaluations"] > cost_of(plain)["evaluations"] + samples
    assert "fast_channels" not in exact_run_warning(plain)[0]
    without = between(cost_of(plain)["expected_range_s"])
    assert f"(without run.fast_channels {without})" in exact_run_warning(fast)[0]
