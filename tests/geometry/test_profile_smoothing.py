"""Laws of smoothing: its frequency response, what it keeps, what it removes."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from wrsim.errors import InputError
from wrsim.geometry.profile.models import load_profile
from wrsim.geometry.profile.points import CUTOFF, ProfilePoints, smoothed, smoothing_spline
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.profile.sections import circle

S1002 = load_profile(Path(__file__).parents[2] / "models/wheels/S1002.toml")


def points(u: np.ndarray, w: np.ndarray) -> ProfilePoints:
    """Points as if read from a file, one a line."""
    return ProfilePoints("measured.csv", u, w, np.arange(1, u.size + 1))


def measured(profile: Profile, noise: float, step: float = 1e-4, seed: int = 1) -> ProfilePoints:
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


@settings(max_examples=20, deadline=None)
@given(coefficients=st.tuples(*[st.floats(-1.0, 1.0)] * 3), cutoff=st.floats(1e-3, 0.1), seed=st.integers(0, 100))
def test_parabolas_pass_unchanged_to_their_very_ends(coefficients, cutoff, seed):
    s = np.sort(np.random.default_rng(seed).uniform(0.0, 0.1, 400))
    p = np.polynomial.polynomial.polyval(s, coefficients)
    np.testing.assert_allclose(smoothing_spline(s, p[:, None], cutoff)(s)[:, 0], p, atol=1e-9)


def test_an_arc_keeps_its_radius():
    arc = circle("arc", "rail", 0.013, 0.010)
    profile = smoothed(measured(arc, 0.0), "arc", "rail")
    L = np.linspace(0.0, profile.length, 2001)
    radius = np.hypot(profile.at(L)[0], profile.at(L)[1] + 0.013)
    # The arc's own wavelength 2 pi R loses only 5e-8 of its amplitude; at the ends an arc is not quite a parabola.
    inner = np.abs(L - 0.5 * profile.length) < 0.5 * profile.length - CUTOFF
    np.testing.assert_allclose(radius[inner], 0.013, rtol=0, atol=5e-8)
    np.testing.assert_allclose(radius, 0.013, rtol=0, atol=5e-7)
    np.testing.assert_allclose(profile.curvature(L[inner]), -1 / 0.013, rtol=5e-3)
    np.testing.assert_allclose(profile.curvature(L), -1 / 0.013, rtol=3e-2)


def test_curvature_of_a_noisy_wheel_is_a_thousand_times_better_than_interpolated():
    noisy = measured(S1002, 5e-6)
    profile = smoothed(noisy, "S1002", "wheel")
    tread = np.linspace(-0.015, 0.050, 1001)
    true = S1002.curvature(S1002.arclength_of(tread))
    error = np.std(profile.curvature(profile.arclength_of(tread)) - true)

    s = np.concatenate([[0.0], np.cumsum(noisy.chords)])
    spline = CubicSpline(s, np.column_stack([noisy.u, noisy.w]))
    v, a = spline(s, 1), spline(s, 2)
    bare = (v[:, 0] * a[:, 1] - v[:, 1] * a[:, 0]) / np.hypot(*v.T) ** 3
    on_tread = (noisy.u > tread[0]) & (noisy.u < tread[-1])
    bare_error = np.std(bare[on_tread] - np.interp(noisy.u[on_tread], tread, true))

    assert error < 1.5  # 1/m
    assert bare_error > 1000.0 * error


def test_smoothing_keeps_the_shape():
    profile = smoothed(measured(S1002, 5e-6), "S1002", "wheel")
    for u, most in ((np.linspace(-0.020, 0.055, 501), 4e-6), (np.linspace(-0.060, 0.055, 501), 10e-6)):
        L = profile.arclength_of(u)
        (mu, mw), (tu, tw) = profile.at(L), S1002.normal(S1002.arclength_of(u))
        across = (mu - u) * tu + (mw - S1002.at(S1002.arclength_of(u))[1]) * tw
        # 4 um on the tread: what is left of 5 um of noise. 10 um at the flange, whose arcs of 13 and 20 mm are
        # separated by a straight of 4 mm only: jumps of curvature are spread over the cut-off of 5 mm.
        assert np.abs(across).max() < most


def test_noise_does_not_lengthen_the_profile():
    # The polygon of the noisy points is longer by 0.3 %; arclength is measured on the smoothed curve.
    noisy = measured(S1002, 5e-6)
    assert noisy.chords.sum() > S1002.length * 1.002
    assert smoothed(noisy, "S1002", "wheel").length == pytest.approx(S1002.length, abs=2e-5)


def test_uneven_spacing_does_not_bias_the_shape():
    # Twice as many points on one half: weights are spacings, so the dense half pulls no harder.
    rows, _ = circle("arc", "rail", 0.08, 0.03).table(5e-5)
    keep = np.ones(len(rows), dtype=bool)
    keep[: len(rows) // 2 : 2] = False
    profile = smoothed(points(rows[keep, 0], rows[keep, 1]), "arc", "rail")
    u, w = profile.at(np.linspace(0.0, profile.length, 1001))
    np.testing.assert_allclose(np.hypot(u, w + 0.08), 0.08, rtol=0, atol=2e-9)


def test_points_too_far_apart_for_the_cutoff_are_refused():
    u = np.linspace(-0.03, 0.03, 21)
    with pytest.raises(InputError, match=r"measured.csv:2: 3.005 mm from .* line 1; .*at most 2.5 mm apart"):
        smoothed(points(u, -(u**2)), "coarse", "rail")
