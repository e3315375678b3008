"""Contact models side by side: names, differences, samples, files."""

import csv
import json
from functools import cache

import numpy as np
import pytest
from support.commands import call, ok
from support.hertz import Ellipse
from support.rows import rows_of
from support.runs import FAST, SCENARIOS
from support.scenario_texts import CURVE, STATIC

from wrsim import InputError, Result, load, load_text, run
from wrsim.analysis.compare import (
    _at_samples,
    _ellipses,
    compare_models,
    comparison_report,
    comparison_tables,
    of_wheels,
)
from wrsim.analysis.resolve import resolve_contacts
from wrsim.plots.compare import values_figure
from wrsim.scenario.contact_choice import split_names, with_contact_model

table = rows_of(__file__)

POSES = STATIC.replace("lateral_mm = 0\n", "lateral_mm = [0, 5.4, -100]\n")
SHORT = CURVE.replace("[run]\n", "[run]\nstart_distance_m = 60\ntime_s = 0.06\n")


@cache
def static_comparison():
    return compare_models(load_text(POSES), ("kik-piotrowski", "half-space", "kik-piotrowski+strips=20"), "half-space")


def test_differences_are_those_of_the_results():
    c = static_comparison()
    tables = {m.name: of_wheels(m.result.dataset) for m in c.models}
    exact, paper = tables["half-space"], tables["kik-piotrowski"]
    told = c.values.sel(model="kik-piotrowski")
    assert told["p0_difference"].values[:2] == pytest.approx(paper["p0"][:2] / exact["p0"][:2] - 1.0)
    assert told["Y_difference"].values[:2] == pytest.approx((paper["Y"] - exact["Y"])[:2] / exact["N"][:2])
    assert told["contact_angle_difference"].values[:2] == pytest.approx(
        (paper["contact_angle"] - exact["contact_angle"])[:2]
    )
    # Kik-Piotrowski's peaks are too low and its patches too large (docs/theory/normal_contact.md)
    assert (told["p0_difference"].values[:2] < -0.05).all()
    assert (told["area_difference"].values[:2] > 0.03).all()
    of_reference = c.values.sel(model="half-space")
    assert (np.nanmax(abs(of_reference["p0_difference"])), np.nanmax(abs(of_reference["Y_difference"]))) == (0.0, 0.0)
    assert np.nanmax(abs(told["N_difference"])) < 0.02
    # the contact jumps to the flange between both poses: no line crosses the jump
    lines = [line for axes in values_figure(c.values, "half-space", "").axes for line in axes.lines]
    assert all(np.isnan(line.get_ydata()[2]) for line in lines if line.get_marker() == "o")


def test_runs_are_compared_at_the_reference_s_samples():
    text = SHORT.replace("[contact]\n", "[contact]\nstrips = 12\ncells = 6\n")
    c = compare_models(load_text(text), ("file", "strips", "file+friction=0.2"))
    assert np.abs(c.values["Y_difference"].sel(model="strips").values).max() == 0.0
    assert np.nanmax(abs(c.values["X_difference"].sel(model="file+friction=0.2"))) > 0.01
    assert c.values["time"].values == pytest.approx(c.main.result.dataset["time"].values)
    assert (np.diff(c.values["distance"].values) > 0.0).all()
    dataset = c.main.result.dataset  # other samples, which end earlier
    resampled = _at_samples(dataset.isel(time=slice(0, -1, 2)), dataset)["Q"].values
    force = of_wheels(dataset)["Q"].values
    assert np.array_equal(resampled[0:-2:2], force[0:-2:2]) and np.isnan(resampled[-1]).all()
    assert resampled[1:-2:2] == pytest.approx(0.5 * (force[0:-3:2] + force[2:-1:2]), rel=1e-12)


def chosen(name, contact=""):
    return with_contact_model(load_text(f"{STATIC}[contact]\n{contact}"), name).spec.contact.settings()


def test_names_choose_models():
    assert (chosen("half-space").normal, chosen("half-space").tangential) == ("half-space", "half-space")
    assert chosen("half-space+fastsim").tangential == "fastsim"
    assert chosen("half-space", 'tangential = "none"').tangential == "none"
    assert chosen("kik-piotrowski", 'normal = "half-space"').creep_forces == "fastsim"
    assert chosen("strips", 'normal = "half-space"\ntangential = "half-space"').creep_forces == "fastrip"
    assert chosen("strips", 'tangential = "fastsim"').creep_forces == "fastsim"
    assert chosen("polach", 'normal = "kik-piotrowski"\nstrips = 30').strips == 30
    assert chosen("kik-piotrowski+strips=80+approach=constant").approach == "constant"
    assert chosen("half-space+half_space.resolution=20").half_space.resolution == 20
    assert chosen("file", "strips = 77").strips == 77
    paper = 'normal = "kik-piotrowski"\napproach = "constant"\nstrip_width_mm = 0.1'
    assert chosen("strips+approach=+strip_width_mm=", paper).strip_width is None


@pytest.mark.parametrize(("names", "message"), table("wrong_names_are_one_clear_error"))
def test_wrong_names_are_one_clear_error(tmp_path, names, message):
    with pytest.raises(InputError, match=r"model|--contact") as error:
        compare_models(load_text(STATIC), split_names(names))
    assert message in str(error.value)
    (tmp_path / "case.toml").write_text(STATIC)
    ended = call("compare", tmp_path / "case.toml", "--contact", names)
    assert ended.exit_code == 2
    assert message in ended.output + ended.stderr
    assert "Traceback" not in ended.output


def test_ellipses_of_hertz_are_those_with_their_curvatures_and_of_a_wheel_on_a_rail_of_arcs():
    for ellipse in (Ellipse(6e-3, 1e-3), Ellipse(3e-3, 3e-3), Ellipse(1e-3, 8e-3)):
        along, across = (2.0 * np.array([bend]) for bend in ellipse.curvatures)
        told = _ellipses(np.array([ellipse.force]), along, across, ellipse.modulus)
        expected = {"p0": ellipse.p0, "length": 2.0 * ellipse.a, "width": 2.0 * ellipse.b, "approach": ellipse.approach}
        assert {name: told[name][0] for name in expected} == pytest.approx(expected, rel=1e-9)
    # at 8 mm the paper's contact is one of two arcs: strips give the ellipse, 0.04 % in p0
    paper = load(SCENARIOS / "static_paper.toml").with_values({"static.lateral_mm": 8})
    c = compare_models(paper, ("hertz", "strips+approach=+strip_width_mm="), "strips+approach=+strip_width_mm=")
    told = c.values.sel(model="hertz").isel(pose=0, wheel=0)
    assert abs(float(told["p0_difference"])) < 1e-3 and float(told["N_difference"]) == 0.0
    notes = comparison_tables(c, comparison_report(c, ""))[0].notes
    assert np.isnan(float(told["Y"])) and "N, contact point" in notes[0]


@pytest.mark.usefixtures("sketched")
def test_the_command_leaves_tables_and_pictures(tmp_path):
    (tmp_path / "case.toml").write_text(POSES.replace(", -100", "") + "[contact.half_space]\nresolution = 12\n")
    models = ["--contact", "half-space,kik-piotrowski", "--reference", "half-space"]
    ended = ok("compare", tmp_path / "case.toml", *models, "-o", tmp_path / "out", "--json")
    report = json.loads(ended.stdout)
    assert report["reference"] == "half-space"
    assert report["models"]["kik-piotrowski"]["differences"]["p0_percent"]["median"] > 5.0
    rows = list(csv.DictReader((tmp_path / "out/comparison.csv").read_text().splitlines()))
    assert len(rows) == 4
    ratio = float(rows[1]["p0_MPa"]) / float(rows[0]["p0_MPa"]) - 1.0
    assert float(rows[1]["p0_difference_percent"]) == pytest.approx(100.0 * ratio)
    for name in ("compare_values.png", "compare_patches.png", "half-space/result.nc", "kik-piotrowski/result.nc"):
        assert (tmp_path / "out" / name).is_file()


def test_every_wheel_of_a_vehicle_is_compared():
    keys = "[run]\noutput_interval_ms = 5\ntime_s = 0.01\n"
    text = (
        CURVE[: CURVE.index("[run]")]
        .replace("wheelset_s1002", "manchester_1")
        .replace("friction = 0.35", "strips = 12\ncells = 6")
        + keys
    )
    c = compare_models(load_text(text), ("file", "kik-piotrowski+strips=20+friction=0.3"))
    assert c.values["wheel"].values.tolist()[:2] == ["front.outer left", "front.outer right"]
    assert c.values.sizes["wheel"] == 8
    vehicle = resolve_contacts(c.main.result, load_text(text), wheelset="rear.inner", moments=[0]).wheelset()
    assert vehicle["Q"].values[0] == pytest.approx(c.values["Q"].sel(model="file").values[-1, 4:6], rel=1e-3)
    with pytest.raises(InputError, match=r"choose a wheelset: 1 front\.outer, 2 front"):
        resolve_contacts(c.main.result, load_text(text))


# What rings between two samples is told, and is what finer samples show.
SCENARIO = SCENARIOS / "lrv_curve.toml"


def test_a_force_between_samples_is_that_of_finer_samples() -> None:
    """A flange meets its rail and rings at some 100 Hz: samples every 10 ms miss the peak, not the integration."""
    part = FAST | {"run.start_distance_m": 5.5, "run.distance_m": 2.6, "run.step_us": 500, "output.patches_at_m": []}
    fine, coarse = (run(load(SCENARIO).with_values(part | {"run.output_interval_ms": ms})) for ms in (0.5, 10.0))
    every = round(10.0 / 0.5)
    force = fine.dataset["Q"].values[:, 0]
    kept = coarse.dataset["Q"].values[:-1, 0]
    # contacts of a sample are solved from those of the one before: strips end within some 1e-8 of the load
    assert force[::every][: len(kept)] == pytest.approx(kept, rel=1e-7), "the same motion"
    beyond = np.zeros(2)
    for i in range(every, len(force) - every, every):
        ends, inside = force[[i, i + every]], force[i + 1 : i + every]
        above, below = inside.max(axis=0) - ends.max(axis=0), ends.min(axis=0) - inside.min(axis=0)
        beyond = np.maximum(beyond, np.maximum(above, below))
    (event,) = coarse.summary()["events"]
    assert f"{beyond.max() / 1e3:.3g} kN beyond both: run.fast_channels" in event["event"]
    assert beyond.max() > 1e3
    assert "events" not in fine.summary(), "a sample at every step misses nothing"


# Kept moments of a result solved again by another contact model.
SHORTER = CURVE.replace("[run]\n", "[run]\nstart_distance_m = 80\ntime_s = 0.02\n")
WET = "[[contact.friction_sections]]\nfrom_m = 40\nfriction = 0.1\n"
SHORTER += "[track.structure]\nkind = 'rigid'\n"  # poses have no velocities of rails
RAMP = SHORTER.replace("start_distance_m = 80", "start_distance_m = 50") + WET
TWO_POSES = STATIC.replace("lateral_mm = 0\n", "lateral_mm = [0, 5.06]\nyaw_mrad = 5\n")
MOMENTS = ("strip_p", "strip_N", "strip_Fx", "strip_xi", "wheel_origin", "wheel_profile_y")


@cache
def ran(text):
    return run(load_text(text))


def samples(result):
    d = result.wheelset()
    if "pose" in d.dims:
        return np.arange(d.sizes["pose"])
    return np.searchsorted(d["time"].values, d["snapshot_time"].values - 1e-9)


@pytest.mark.parametrize("text", [SHORTER, RAMP, TWO_POSES], ids=["curve", "wet ramp", "poses"])
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


def test_the_exact_solver_takes_over_the_load():
    text = SHORTER
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


def test_a_height_kept_gives_another_load_and_needs_poses():
    # at equal approach Kik-Piotrowski carries 2 to 5 % more than Hertz (docs/theory/normal_contact.md)
    text = TWO_POSES + '[contact]\nnormal = "kik-piotrowski"\n'
    after = resolve_contacts(ran(text), load_text(text), keep="pose", moments=[0]).wheelset()
    assert after["pose"].values.tolist() == ran(text).wheelset()["pose"].values[:1].tolist()
    assert 0.85 < after["Q"].values[0, 0] / ran(text).wheelset()["Q"].values[0, 0] < 0.99
    bare = Result(ran(TWO_POSES).dataset.drop_vars("wheel_origin"))
    with pytest.raises(InputError, match="run its scenario anew"):
        resolve_contacts(bare, load_text(TWO_POSES))


@pytest.mark.usefixtures("sketched")
def test_the_command_writes_a_result_of_the_moments(tmp_path):
    ran(SHORTER).save(tmp_path / "result.nc")
    command = ["resolve", str(tmp_path), "--contact", "half-space+fastsim", "--at"]
    ok(*command, "80.2")
    saved = Result.load(tmp_path / "half-space+fastsim").dataset
    assert saved.attrs["resolved_with"] == "half-space+fastsim"
    assert saved.sizes["time"] == 1
    assert (tmp_path / "half-space+fastsim/patches.png").exists()
    assert call(*command, "500").exit_code == 2
    assert "must be load or pose" in call(*command, "80.2", "--same", "N").output


@pytest.mark.usefixtures("sketched")
def test_the_command_finds_stresses_and_fatigue_below_a_patch(tmp_path):
    text = TWO_POSES + "[contact]\nstrips = 12\ncells = 6\n"
    ran(text).save(tmp_path / "result.nc")
    command = ["resolve", str(tmp_path), "--contact", "file", "--at", "y+0", "-o", str(tmp_path / "below")]
    limits = ["--bending-limit-mpa", "320", "--torsion-limit-mpa", "200"]
    assert "Below the surface of the rail" in call(*command, "--subsurface", *limits).output
    d = Result.load(tmp_path / "below").wheelset()
    assert d.attrs["torsion_limit_MPa"] == 200.0
    in_contact = np.isfinite(d["N"].values)
    assert np.array_equal(np.isfinite(d["von_mises_max"].values), in_contact)
    # a Hertzian contact has 0.56 to 0.65 of its peak (line to point); friction at 0.35 and two patches add to it
    ratio = d["von_mises_max"].values[in_contact] / d["p0"].values[in_contact]
    assert ((ratio > 0.5) & (ratio < 1.1)).all()
    inner = d["von_mises_across"].values[in_contact].max(axis=(-2, -1))
    assert (inner <= d["von_mises_max"].values[in_contact] * 1.001).all()
    assert (d["crossland_max"].values[in_contact] > 0.1).all()
    assert (tmp_path / "below/subsurface.png").exists()
    ok("report", str(tmp_path / "below"))
    page = next((tmp_path / "below").glob("*.html")).read_text(encoding="utf-8")
    assert "stresses below the surface" in page
    assert "needs both" in call(*command, "--subsurface", *limits[:2]).output
    assert "need --subsurface" in call(*command, *limits).output
    assert "--body track: must be rail or wheel" in call(*command, "--subsurface", "--body", "track").output
