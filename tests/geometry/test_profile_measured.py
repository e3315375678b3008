"""Measured profiles from the file to the contact: noise, smoothing, what the report says of it, and garbage."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.commands import call, ok
from support.contacts import bench, contact_model, rail_profile, settle, wheel_profile

from wrsim.errors import InputError
from wrsim.geometry.profile.files import read_points, read_profile
from wrsim.geometry.profile.models import load_profile
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.profile.smoothing_report import report_smoothing

NOISE = 10e-6  # of every coordinate, standard deviation [m]
MODELS = Path(__file__).parents[2] / "models"
SCANS = Path(__file__).parents[2] / "scenarios/measured"


def measured(profile: Profile, step: float, seed: int) -> np.ndarray:
    """Points (n, 2) [mm] of a profile, resampled and with noise, as a device writes them: to 0.1 um."""
    rows, _ = profile.table(step)
    return 1e3 * (rows[:, :2] + NOISE * np.random.default_rng(seed).normal(size=(len(rows), 2)))


def written(points: np.ndarray, path: Path, head: str = "") -> Path:
    """A file of points."""
    path.write_text(head + "".join(f"{u:.4f} {w:.4f}\n" for u, w in points), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def files():
    """The shipped scans: the worn wheel as a MiniProf file, the worn rail in two columns, points 0.11 mm apart."""
    return SCANS / "wheel.whl", SCANS / "rail.csv"


# y [mm] of: field side of the hollow, its gauge side, worn root in the worn corner, flank, and beyond
SHIFTS = (-5.0, -4.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0)


def contacts(wheel: Profile, rail: Profile) -> np.ndarray:
    """p0, area, N and contact angle at 60 kN over the shifts."""
    stand = bench(contact_model(wheel, rail))
    rows = []
    for shift in SHIFTS:
        solved, contact = settle(stand, 1e-3 * shift, 0.0, 60e3)
        assert not solved.message
        p = contact.patches
        rows.append((p["p0"].max(), p["area"].sum(), p["N"].sum(), p["angle"][0]))
    return np.array(rows)


def test_a_noisy_worn_pair_gives_the_contact_of_the_exact_one_within_a_few_per_cent(files):
    exact = contacts(wheel_profile("worn"), rail_profile("worn", 40))
    wheel = read_profile(files[0])
    rail = read_profile(files[1], "rail", measured=True).inclined(1 / 40)
    found = contacts(wheel, rail)
    p0, area, force = np.abs(found / exact - 1.0)[:, :3].T
    # curvature is what noise spoils: pressures follow it. Measured over 6 seeds: median 3.5 %, 95 % 9.6 %
    assert np.median(p0) < 0.05 and p0.max() < 0.13
    assert np.median(area) < 0.045 and area.max() < 0.13
    assert force.max() < 0.01
    assert np.abs(found[:, 3] - exact[:, 3]).max() < np.radians(1.0)


def test_the_report_tells_noise_from_shape(files):
    reading = read_points(files[1], "rail", measured=True)
    report = report_smoothing(reading)
    assert report.scatter == pytest.approx(NOISE, rel=0.1)
    # what was taken away is the noise, and no more
    assert report.rms_change == pytest.approx(NOISE, rel=0.1)
    assert report.curvature_before > 5e3  # 1/m: a radius of 0.2 mm
    # the sharpest of the worn corner, R 13 and the wear on it
    assert report.curvature_after == pytest.approx(90.0, rel=0.1)
    assert report.sharpest == pytest.approx(-28e-3, abs=2e-3)
    most, where, line = report.largest_change
    assert 2.5 * NOISE < most < 6.0 * NOISE
    u = float(files[1].read_text().splitlines()[line - 1].split()[0])
    assert 1e3 * where == pytest.approx(u, abs=1e-9)
    # a cut-off that is too long takes shape away: the change exceeds the scatter
    blunt = report_smoothing(read_points(files[1], "rail", measured=True, cutoff=15e-3))
    assert blunt.rms_change > 1.5 * blunt.scatter


def test_the_change_is_the_distance_from_the_curve(tmp_path):
    # an arc of 80 mm with every point moved outward by 3 um, every other by 1 um more and less
    angle = np.linspace(-0.4, 0.4, 641)
    radius = 80.0 + 3e-3 + 1e-3 * np.where(np.arange(641) % 2, 1.0, -1.0)
    path = written(np.column_stack([radius * np.sin(angle), radius * np.cos(angle) - 80.0]), tmp_path / "arc.csv")
    report = report_smoothing(read_points(path, "rail", measured=True))
    inner = slice(60, -60)
    np.testing.assert_allclose(np.abs(report.change[inner]), 1e-6, atol=0.08e-6)  # digits of 0.1 um
    assert (np.sign(report.change[inner][::2]) == -1.0).all() and (np.sign(report.change[inner][1::2]) == 1.0).all()
    assert report.curvature_after == pytest.approx(1 / 0.080003, rel=0.02)


# --- the command --------------------------------------------------------------------------------------
def test_the_command_compares_cutoffs(files, tmp_path):
    result = ok(
        "profile", files[1], "--kind", "rail", "--cutoff", 3.5, "--cutoff", 10, "-o", tmp_path / "rail.png", "--json"
    )
    found = json.loads(result.stdout)
    assert Path(found["files"][0]).read_bytes().startswith(b"\x89PNG")
    fine, coarse = found["smoothing"]
    assert (fine["cutoff_mm"], coarse["cutoff_mm"]) == (3.5, 10.0)
    assert fine["rms_change_um"] < coarse["rms_change_um"]
    assert fine["largest_curvature_before_1_per_m"] == coarse["largest_curvature_before_1_per_m"]


def test_a_scan_is_reported_without_being_asked(files, tmp_path):
    result = ok("profile", files[0], "-o", tmp_path / "wheel.png")
    assert "scatter by 10" in result.stdout and "5 mm" in result.stdout
    assert call("profile", files[0], "-o", tmp_path / "wheel.jpg").exit_code == 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((MODELS / "rails/60E1.toml", "--cutoff", 5), "is a shape by formula, with no points to smooth"),
        (("rail", "--cutoff", 0), "--cutoff 0: must be a number above 0 and at most 100"),
        (("rail", "--cutoff", "nan"), "--cutoff nan: must be"),
        (("rail", "--cutoff", 0.15), "smoothing with a cut-off of 0.15 mm needs points at most 0.075 mm apart"),
        (("rail", *["--cutoff", 5] * 5), "5 of them; must be at most 4"),
        (("rail",), "measured = true"),
    ],
)
def test_what_cannot_be_smoothed_is_answered(files, tmp_path, words, message):
    words = [files[1] if word == "rail" else word for word in words]
    result = call("profile", *words, "--kind", "rail", "-o", tmp_path / "out.png")
    assert result.exit_code == 2
    assert message in " ".join(result.stderr.split())
    assert not (tmp_path / "out.png").exists()


# --- garbage ------------------------------------------------------------------------------------------

SCAN = "".join(f"{u:.4f} {w:.4f}\n" for u, w in measured(load_profile(MODELS / "rails/60E1.toml"), 5e-4, 3))
LINES = SCAN.splitlines(keepends=True)

cuts = st.tuples(st.just("cut"), st.integers(0, len(SCAN)), st.integers(0, len(SCAN)))
swaps = st.tuples(st.just("swap"), st.integers(0, len(LINES) - 1), st.integers(0, len(LINES) - 1))
words = st.tuples(st.just("word"), st.integers(0, len(LINES)), st.text(max_size=12))
values = st.tuples(st.just("value"), st.integers(0, len(LINES) - 1), st.floats(allow_nan=True))


@settings(max_examples=50, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(slips=st.lists(cuts | swaps | words | values, min_size=1, max_size=3), measure=st.booleans())
def test_a_spoiled_scan_is_read_or_refused_with_its_file(tmp_path, slips, measure):
    text = SCAN
    for what, a, b in slips:
        rows = text.splitlines(keepends=True)
        if what == "cut":
            text = text[: min(a, b)] + text[max(a, b) :]
        elif what == "swap" and max(a, b) < len(rows):
            rows[a], rows[b] = rows[b], rows[a]
            text = "".join(rows)
        elif what == "word":
            rows.insert(min(a, len(rows)), f"{b}\n")
            text = "".join(rows)
        elif what == "value" and a < len(rows):
            rows[a] = f"{b} {rows[a].split()[0] if rows[a].split() else 0}\n"
            text = "".join(rows)
    path = tmp_path / "scan.csv"
    path.write_text(text, encoding="utf-8", errors="replace")
    try:
        profile = read_profile(path, "rail", measured=measure)
    except InputError as error:
        assert str(path) in str(error)
        return
    assert np.isfinite(profile.curvature_after).all()
    assert 0.005 <= profile.length <= 1.0


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.binary(max_size=300), suffix=st.sampled_from([".csv", ".prr", ".prw", ".ban", ".whl", ".toml"]))
def test_any_bytes_are_refused_with_their_file(tmp_path, data, suffix):
    path = tmp_path / f"garbage{suffix}"
    path.write_bytes(data)
    with pytest.raises(InputError, match="garbage"):
        load_profile(path, "wheel" if suffix in (".csv", ".prw", ".whl", ".toml") else "rail")
