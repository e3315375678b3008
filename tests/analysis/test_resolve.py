"""Kept moments of a result solved again by another contact model."""

from functools import cache

import numpy as np
import pytest
from support.commands import call, ok
from support.scenario_texts import CURVE, STATIC

from wrsim import run
from wrsim.analysis.resolve import resolve_contacts
from wrsim.errors import InputError
from wrsim.results import Result
from wrsim.scenario.loading import load_text

SHORT = CURVE.replace("[run]\n", "[run]\nstart_distance_m = 80\ntime_s = 0.02\n")
WET = SHORT + "[[contact.friction_sections]]\nfrom_m = 60\nfriction = 0.1\n"
RAMP = SHORT.replace("start_distance_m = 80", "start_distance_m = 50")
POSES = STATIC.replace("lateral_mm = 0\n", "lateral_mm = [0, 5.06]\nyaw_mrad = 5\n")
MOMENTS = ("strip_p", "strip_N", "strip_Fx", "strip_xi", "wheel_origin", "wheel_profile_y")


@cache
def ran(text):
    return run(load_text(text))


def samples(result):
    d = result.wheelset()
    if "pose" in d.dims:
        return np.arange(d.sizes["pose"])
    return np.searchsorted(d["time"].values, d["snapshot_time"].values - 1e-9)


@pytest.mark.parametrize("text", [SHORT, WET, RAMP, POSES], ids=["curve", "wet", "ramp", "poses"])
def test_the_same_model_finds_the_same_contacts(text):
    before = ran(text)
    after = resolve_contacts(before, load_text(text), "file", keep="pose")
    rows = samples(before)
    assert len(rows) == after.wheelset()["Q"].shape[0] > 0
    # a run's contact comes from the one before, this one afresh: alike to what strips are solved to
    for name in ("N", "Fx", "Fy", "p0", "contact_angle", "y_contact", "u_rail", "Q", "T_gamma"):
        assert after.wheelset()[name].values == pytest.approx(
            before.wheelset()[name].values[rows], rel=2e-7, nan_ok=True
        )
    for name in MOMENTS:
        values = before.wheelset()[name].values
        assert after.wheelset()[name].values == pytest.approx(values, abs=2e-7 * np.nanmax(np.abs(values)), nan_ok=True)


@pytest.mark.parametrize("text", [SHORT, POSES])
def test_the_exact_solver_takes_over_the_load(text):
    before = ran(text)
    after = resolve_contacts(before, load_text(text)).wheelset()
    rows = samples(before)
    assert after["Q"].values == pytest.approx(before.wheelset()["Q"].values[rows], rel=1e-4)
    # peaks of strips are near the exact ones (docs/validation/report.md), creepages are those of the same motion
    assert after["p0"].values[..., 0] == pytest.approx(before.wheelset()["p0"].values[rows][..., 0], rel=0.02)
    assert after["xi"].values[..., 0] == pytest.approx(before.wheelset()["xi"].values[rows][..., 0], abs=2e-5)
    assert np.isfinite(after["element_p"].values).any()
    moved = np.abs(after["wheel_origin"].values - before.wheelset()["wheel_origin"].values)
    assert 0.0 < moved[..., 2].max() < 1e-5
    assert moved[..., :2].max() == 0.0


def test_a_height_kept_gives_another_load():
    # at equal approach Kik-Piotrowski carries 2 to 5 % more than Hertz (docs/theory/normal_contact.md)
    text = POSES + '[contact]\nnormal = "kik-piotrowski"\n'
    after = resolve_contacts(ran(text), load_text(text), keep="pose", moments=[0]).wheelset()
    assert after["pose"].values.tolist() == ran(text).wheelset()["pose"].values[:1].tolist()
    assert 0.85 < after["Q"].values[0, 0] / ran(text).wheelset()["Q"].values[0, 0] < 0.99


def test_a_result_without_poses_says_so():
    bare = Result(ran(POSES).dataset.drop_vars("wheel_origin"))
    with pytest.raises(InputError, match="run its scenario anew"):
        resolve_contacts(bare, load_text(POSES))


@pytest.mark.usefixtures("sketched")
def test_the_command_writes_a_result_of_the_moments(tmp_path):
    ran(SHORT).save(tmp_path / "result.nc")
    command = ["resolve", str(tmp_path), "--contact", "half-space+fastsim", "--at"]
    ok(*command, "80.2")
    saved = Result.load(tmp_path / "half-space+fastsim").dataset
    assert saved.attrs["resolved_with"] == "half-space+fastsim"
    assert saved.sizes["time"] == 1
    assert (tmp_path / "half-space+fastsim/patches.png").exists()
    assert call(*command, "500").exit_code == 2
    assert "must be load or pose" in call(*command, "80.2", "--same", "N").output
