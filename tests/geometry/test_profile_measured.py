"""Measured profiles from the file to the contact: noise, smoothing, what the report says of it, and garbage."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from support.commands import call, ok
from support.contacts import bench, contact_model, rail_profile, settle, wheel_profile
from support.examples import examples

from wrsim.errors import InputError
from wrsim.geometry.profile.files import read_points
from wrsim.geometry.profile.models import load_profile
from wrsim.geometry.profile.points import CUTOFF, ProfilePoints, smoothed, smoothing_spline
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.profile.sections import circle
from wrsim.results.smoothing import report_smoothing

NOISE = 10e-6  # of every coordinate, standard deviation [m]
MODELS = Path(__file__).parents[2] / "models"
SCANS = Path(__file__).parents[2] / "scenarios/measured"


def measured(profile: Profile, step: float, seed: int) -> np.ndarray:
    """Points (n, 2) [mm] of a profile, resampled and with noise, as a device writes them: to 0.1 um."""
    rows, _ = profile.table(step)
    return 1e3 * (rows[:, :2] + NOISE * np.random.default_rng(seed).normal(size=(len(rows), 2)))


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
    wheel = read_points(files[0]).profile()
    rail = read_points(files[1], "rail", measured=True).profile().inclined(1 / 40)
    found = contacts(wheel, rail)
    p0, area, force = np.abs(found / exact - 1.0)[:, :3].T
    # curvature is what noise spoils: pressures follow it. Measured over 6 seeds: median 3.5 %, 95 % 9.6 %
    assert np.median(p0) < 0.05 and p0.max() < 0.13
    assert np.median(area) < 0.045 and area.max() < 0.13
    assert force.max() < 0.01
    assert np.abs(found[:, 3] - exact[:, 3]).max() < np.radians(1.0)


def test_the_report_tells_noise_from_shape(files):
    reading = read_points(files[1], "rail", measured=True)
    found = report_smoothing(reading).numbers()
    assert 1e-6 * found["scatter_um"] == pytest.approx(NOISE, rel=0.1)
    # what was taken away is the noise, and no more
    assert 1e-6 * found["rms_change_um"] == pytest.approx(NOISE, rel=0.1)
    assert found["largest_curvature_before_1_per_m"] > 5e3  # a radius of 0.2 mm
    # the sharpest of the worn corner, R 13 and the wear on it
    assert found["largest_curvature_after_1_per_m"] == pytest.approx(90.0, rel=0.1)
    assert found["at_u_mm"] == pytest.approx(-28.0, abs=2.0)
    assert 2.5 * NOISE < 1e-6 * found["largest_change_um"] < 6.0 * NOISE
    u = float(files[1].read_text().splitlines()[int(found["largest_change_at_line"]) - 1].split()[0])
    assert found["largest_change_at_u_mm"] == pytest.approx(u, abs=1e-9)
    # a cut-off that is too long takes shape away: the change exceeds the scatter
    blunt = report_smoothing(read_points(files[1], "rail", measured=True, cutoff=15e-3)).numbers()
    assert blunt["rms_change_um"] > 1.5 * blunt["scatter_um"]


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


@settings(max_examples=examples(50), suppress_health_check=[HealthCheck.function_scoped_fixture])
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
        profile = read_points(path, "rail", measured=measure).profile()
    except InputError as error:
        assert str(path) in str(error)
        return
    assert np.isfinite(profile.curvature_after).all()
    assert 0.005 <= profile.length <= 1.0


@settings(max_examples=examples(40), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.binary(max_size=300), suffix=st.sampled_from([".csv", ".prr", ".prw", ".ban", ".whl", ".toml"]))
def test_any_bytes_are_refused_with_their_file(tmp_path, data, suffix):
    path = tmp_path / f"garbage{suffix}"
    path.write_bytes(data)
    with pytest.raises(InputError, match="garbage"):
        load_profile(path, "wheel" if suffix in (".csv", ".prw", ".whl", ".toml") else "rail")


# Laws of smoothing: its frequency response, what it keeps, what it removes.
S1002 = load_profile(Path(__file__).parents[2] / "models/wheels/S1002.toml")


def points(u: np.ndarray, w: np.ndarray) -> ProfilePoints:
    """Points as if read from a file, one a line."""
    return ProfilePoints("measured.csv", u, w, np.arange(1, u.size + 1))


def scanned(profile: Profile, noise: float, step: float = 1e-4, seed: int = 1) -> ProfilePoints:
    """Points of a profile with independent noise across and along it."""
    rows, _ = profile.table(step)
    shift = noise * np.random.default_rng(seed).normal(size=(len(rows), 2))
    return points(rows[:, 0] + shift[:, 0], rows[:, 1] + shift[:, 1])


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0, 4.0])
def test_a_wave_passes_with_the_stated_amplitude(ratio):
    # Steel ruler of 150 mm with a wave of 2 um; far from the ends the response is the docstring's.
    wave = ratio * CUTOFF
    u = np.arange(0.0, 0.15, 1e-4)
    profile = smoothed(points(u, 2e-6 * np.sin(2 * np.pi * u / wave)), "ruler", "rail")
    inner = np.linspace(0.04, 0.11, 3001)
    w = profile.at(profile.arclength_of(inner))[1]
    basis = np.column_stack([np.sin(2 * np.pi * inner / wave), np.cos(2 * np.pi * inner / wave)])
    (amplitude, shift), *_ = np.linalg.lstsq(basis, w, rcond=None)
    assert amplitude / 2e-6 == pytest.approx(1.0 / (1.0 + (1.0 / ratio) ** 6), abs=2e-3)
    assert shift / 2e-6 == pytest.approx(0.0, abs=2e-3)  # nothing moves sideways


@settings(max_examples=examples(20), deadline=None)
@given(coefficients=st.tuples(*[st.floats(-1.0, 1.0)] * 3), cutoff=st.floats(1e-3, 0.1), seed=st.integers(0, 100))
def test_parabolas_pass_unchanged_to_their_very_ends(coefficients, cutoff, seed):
    s = np.sort(np.random.default_rng(seed).uniform(0.0, 0.1, 400))
    p = np.polynomial.polynomial.polyval(s, coefficients)
    np.testing.assert_allclose(smoothing_spline(s, p[:, None], cutoff)(s)[:, 0], p, atol=1e-9)


def test_an_arc_keeps_its_radius():
    arc = circle("arc", "rail", 0.013, 0.010)
    profile = smoothed(scanned(arc, 0.0), "arc", "rail")
    L = np.linspace(0.0, profile.length, 2001)
    radius = np.hypot(profile.at(L)[0], profile.at(L)[1] + 0.013)
    # The arc's own wavelength 2 pi R loses only 5e-8 of its amplitude; at the ends an arc is not quite a parabola.
    inner = np.abs(L - 0.5 * profile.length) < 0.5 * profile.length - CUTOFF
    np.testing.assert_allclose(radius[inner], 0.013, rtol=0, atol=5e-8)
    np.testing.assert_allclose(radius, 0.013, rtol=0, atol=5e-7)
    np.testing.assert_allclose(profile.curvature(L[inner]), -1 / 0.013, rtol=5e-3)
    np.testing.assert_allclose(profile.curvature(L), -1 / 0.013, rtol=3e-2)


def test_curvature_of_a_noisy_wheel_is_that_of_its_shape():
    profile = smoothed(scanned(S1002, 5e-6), "S1002", "wheel")
    tread = np.linspace(-0.015, 0.050, 1001)
    true = S1002.curvature(S1002.arclength_of(tread))
    error = np.std(profile.curvature(profile.arclength_of(tread)) - true)
    assert error < 1.5  # 1/m; a spline through all points is a thousand times as far off


def test_smoothing_keeps_the_shape():
    profile = smoothed(scanned(S1002, 5e-6), "S1002", "wheel")
    for u, most in ((np.linspace(-0.020, 0.055, 501), 4e-6), (np.linspace(-0.060, 0.055, 501), 10e-6)):
        L = profile.arclength_of(u)
        (mu, mw), (tu, tw) = profile.at(L), S1002.normal(S1002.arclength_of(u))
        across = (mu - u) * tu + (mw - S1002.at(S1002.arclength_of(u))[1]) * tw
        # 4 um on the tread: what is left of 5 um of noise. 10 um at the flange, whose arcs of 13 and 20 mm are
        # separated by a straight of 4 mm only: jumps of curvature are spread over the cut-off of 5 mm.
        assert np.abs(across).max() < most


def test_points_too_far_apart_for_the_cutoff_are_refused():
    u = np.linspace(-0.03, 0.03, 21)
    with pytest.raises(InputError, match=r"measured.csv:2: 3.005 mm from .* line 1; .*at most 2.5 mm apart"):
        smoothed(points(u, -(u**2)), "coarse", "rail")
