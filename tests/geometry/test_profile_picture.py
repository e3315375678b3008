"""The picture of a profile says what it shows, in units, at equal scales."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from wrsim.geometry.profile.models import load_profile
from wrsim.plots.profile import draw_curvature, profile_figure

MODELS = Path(__file__).parents[2] / "models"
ALL = sorted(p for folder in ("wheels", "rails") for p in (MODELS / folder).glob("*.toml"))


@pytest.mark.parametrize("path", ALL, ids=lambda p: p.stem)
def test_the_figure_shows_shape_slope_and_curvature_over_the_whole_profile(path):
    profile = load_profile(path)
    figure = profile_figure(profile)
    shape, slope, curvature = figure.axes[:3]
    assert [axes.get_ylabel() for axes in (shape, slope, curvature)] == [
        "Height w [mm]",
        "Slope angle [°]",
        "Curvature [1/m]",
    ]
    assert curvature.get_xlabel() == "Outward u [mm]"
    low, high = shape.get_xlim()
    assert low < 1e3 * profile.u.min() and high > 1e3 * profile.u.max()
    # One millimetre is as long upward as it is across.
    box = shape.get_position()
    across, up = figure.get_size_inches()
    per_mm = box.width * across / (high - low), box.height * up / np.diff(shape.get_ylim())[0]
    assert per_mm[0] == pytest.approx(per_mm[1], rel=1e-9)
    assert profile.name in figure.texts[0].get_text()


def test_curvature_is_drawn_with_its_jumps():
    profile = load_profile(MODELS / "rails/60E1.toml")
    axes = Figure().subplots()
    assert draw_curvature(profile, axes) is axes
    u, k = axes.lines[0].get_data()
    jump = np.flatnonzero((np.diff(u) == 0.0) & (np.abs(np.diff(k)) > 1.0))
    assert jump.size == 6  # three arcs on either side
    np.testing.assert_allclose(np.abs(u[jump]), [35.9998, 26.0265, 10.228, 10.228, 26.0265, 35.9998], atol=1e-3)
