"""Pictures draw the data they are given. Artists are inspected; nobody compares pixels."""

from itertools import product

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_hex
from matplotlib.ticker import MaxNLocator
from support import synthetic_result

from wrsim.plots import new_figure, patch_gallery, standard_figures, standard_pictures, style
from wrsim.plots.cross_section import cross_section_zoom
from wrsim.plots.histories import channels_figure, contact_angle, history, track_layout
from wrsim.plots.marks import broken
from wrsim.plots.moments import PatchAt, patches_at
from wrsim.plots.patches import contact_patch, pressure_scale
from wrsim.plots.theme import WHEEL_COLOUR, InView
from wrsim.results import Result


def curve_run(**options) -> xr.Dataset:
    return Result(synthetic_result.curve_run(**options)).wheelset()


def static_poses(*options) -> xr.Dataset:
    return Result(synthetic_result.static_poses(*options)).wheelset()


RUN_PICTURES = ["overview", "forces", "contact", "patches", "sections"]


@pytest.fixture
def axes():
    with style():
        return new_figure(80, 60).add_subplot()


def lines_of(axes, wheel: str) -> list:
    return [line for line in axes.get_lines() if to_hex(line.get_color()).upper() == WHEEL_COLOUR[wheel]]


def one_pose() -> xr.Dataset:
    return static_poses((6.0,), (0.0,))


@pytest.mark.parametrize(("name", "factor"), [("Q", 1e-3), ("Y", 1e-3), ("Y_over_Q", 1.0), ("T_gamma", 1.0)])
def test_histories_of_wheels_are_drawn_in_their_units_and_colours(axes, name, factor):
    dataset = curve_run()
    history(axes, dataset, name)
    for wheel in ("left", "right"):
        (line,) = lines_of(axes, wheel)
        np.testing.assert_array_equal(line.get_xdata(), dataset["distance"])
        np.testing.assert_allclose(line.get_ydata(), dataset[name].sel(wheel=wheel) * factor)


def test_the_contact_angle_shows_main_point_and_mean_and_the_band_between_the_extremes(axes):
    dataset = curve_run()
    contact_angle(axes, dataset, "right")
    angle = np.degrees(dataset["contact_angle"].sel(wheel="right", patch=0))
    drawn = lines_of(axes, "right")[0].get_ydata()
    np.testing.assert_allclose(drawn[np.isfinite(drawn)], angle)
    assert np.isnan(drawn).sum() >= 1  # the jump into the flange root is not bridged by a line
    (band, *_) = axes.collections
    edges = np.concatenate([path.vertices[:, 1] for path in band.get_paths()])
    low, high = (dataset[f"contact_angle_{e}"].sel(wheel="right", patch=0) for e in ("min", "max"))
    assert edges.min() == pytest.approx(float(np.degrees(low.min())))
    assert edges.max() == pytest.approx(float(np.degrees(high.max())))


def test_a_line_is_interrupted_at_jumps_and_curvature_keeps_its_hand_beneath(axes):
    x, y = broken(np.arange(4.0), np.array([0.0, 1.0, 50.0, 51.0]), 6.0)
    np.testing.assert_array_equal(y, [0.0, 1.0, np.nan, 50.0, 51.0])
    np.testing.assert_array_equal(x, [0.0, 1.0, 1.5, 2.0, 3.0])
    dataset = curve_run(radius=-300.0)
    track_layout(axes, dataset)
    np.testing.assert_allclose(axes.get_lines()[0].get_ydata(), dataset["curvature"] * 1e3)
    cant = next(a for a in axes.figure.axes if a is not axes)
    np.testing.assert_allclose(cant.get_lines()[0].get_ydata(), dataset["cant"] * 1e3)
    assert axes.get_ylim()[0] < -3.3


def test_a_patch_is_drawn_with_its_semi_ellipses_of_pressure(axes):
    dataset = curve_run()
    where = PatchAt(3, "right", 0)
    scale = pressure_scale(dataset)
    contact_patch(axes, dataset, where, scale)
    (mesh,) = [c for c in axes.collections if isinstance(c, QuadMesh)]
    points, pressure = mesh.get_coordinates(), np.asarray(mesh.get_array())
    strips = dataset.isel(snapshot=3, patch=0).sel(wheel="right").dropna("strip", subset=["strip_p"])
    assert pressure.max() == pytest.approx(float(strips["strip_p"].max()) / 1e6, rel=1e-9)
    # every strip appears as a column: along it p^2 / p0^2 + (x - x0)^2 / a^2 = 1
    for s, x0, a, p in np.transpose([strips[f"strip_{n}"] for n in "sxap"]):
        column = int(np.argmin(np.abs(points[0, :, 0] - 1e3 * s)))
        assert points[0, column, 0] == pytest.approx(1e3 * s, abs=1e-9)
        law = (pressure[:, column] / (1e-6 * p)) ** 2 + ((points[:, column, 1] - 1e3 * x0) / (1e3 * a)) ** 2
        np.testing.assert_allclose(law, 1.0, rtol=1e-9)
    assert axes.get_aspect() == 1.0
    width = np.ptp(points[..., 0])
    assert width == pytest.approx(1e3 * float(strips["strip_ds"].sum()), rel=1e-6)


def test_all_patches_of_a_gallery_have_one_scale_of_colour_and_length():
    figure = patch_gallery(curve_run())
    panels = [a for a in figure.axes if a.collections and isinstance(a.collections[0], QuadMesh)]
    assert len(panels) >= 10
    scales = {(m.norm.vmin, m.norm.vmax) for a in panels for m in a.collections}
    assert len(scales) == 1
    assert next(iter(scales))[0] == 0.0
    figure.canvas.draw()
    per_mm = {round(a.get_window_extent().width / np.ptp(a.get_xlim()), 3) for a in panels}
    up = {round(a.get_window_extent().height / np.ptp(a.get_ylim()), 3) for a in panels}
    assert per_mm == up
    assert len(per_mm) == 1


def test_the_section_shows_both_outlines_and_the_patch_on_them(axes):
    dataset = one_pose()
    where = PatchAt(0, "left", 0)
    cross_section_zoom(axes, dataset, where, pressure_scale(dataset))
    drawn = {line.get_gid(): line for line in axes.get_lines()}
    of_wheel = dataset.sel(wheel="left")
    values = of_wheel.isel(pose=0)
    for part in ("rail", "wheel"):
        np.testing.assert_allclose(drawn[part].get_xdata()[1:-1], values[f"{part}_profile_y"] * 1e3)
        np.testing.assert_allclose(drawn[part].get_ydata()[1:-1], values[f"{part}_profile_z"] * 1e3)
    (patch,) = [c for c in axes.collections if isinstance(c, QuadMesh)]
    centre = patch.get_coordinates().mean(axis=0)
    strips = of_wheel.isel(pose=0, patch=0)
    for y, z in np.transpose([strips["strip_y"], strips["strip_z"]]) * 1e3:
        assert np.hypot(*(centre - [y, z]).T).min() < 1e-9
    x0, x1 = axes.get_xlim()
    y0, y1 = axes.get_ylim()
    assert x0 < centre[:, 0].min() < centre[:, 0].max() < x1
    assert y0 < centre[:, 1].min() < centre[:, 1].max() < y1


@pytest.mark.parametrize(
    ("dataset", "names"),
    [
        (lambda: curve_run(), RUN_PICTURES),
        (lambda: curve_run(stopped=True), RUN_PICTURES),
        (lambda: curve_run().isel(time=slice(0, 2)).drop_dims("snapshot"), RUN_PICTURES[:-2]),
        (lambda: curve_run().isel(time=[100], snapshot=[3]), ["patches", "sections"]),
        (lambda: curve_run().isel(time=slice(0, 0)).drop_dims("snapshot"), []),
        (lambda: static_poses(), ["contact", "patches", "sections"]),
        (one_pose, ["patches", "sections"]),
        (lambda: static_poses((0.0, 7.0), (0.0,), ("left",), 24e3), ["contact", "patches", "sections"]),
        (lambda: static_poses().isel(pose=[41]), []),
    ],
)
def test_every_kind_of_result_gets_its_pictures(dataset, names):
    assert list(standard_figures(dataset())) == names


@pytest.mark.parametrize(
    "span", [(-0.3, 7.1), (0.0, 0.9), (3.1, 3.4), (2.4, -2.4), (12.4, 23.1), (1e5 + 0.2, 1e5 + 3.0)]
)
def test_ticks_within_an_axis_have_the_places_and_numbers_that_they_have_among_all(axes, span):
    axes.set_xlim(span)
    every, seen = [], []
    for locator, ticks in ((MaxNLocator(4), every), (InView(4), seen)):
        axes.xaxis.set_major_locator(locator)
        ticks += [(label.get_position()[0], label.get_text()) for label in axes.get_xticklabels()]
    assert seen == [(place, text) for place, text in every if min(span) <= place <= max(span)]
    assert 1 < len(seen) < len(every)


def test_pictures_have_the_same_bytes_for_the_same_data_and_leave_settings_alone(tmp_path):
    dataset = static_poses((7.0,), (0.0,), ("left",))
    paths = standard_pictures(dataset, tmp_path)
    first = {p.name: p.read_bytes() for p in paths}
    assert all(content.startswith(b"\x89PNG") for content in first.values())
    again = {p.name: p.read_bytes() for p in standard_pictures(dataset, tmp_path)}
    assert first == again
    before = dict(mpl.rcParams)
    channels_figure(curve_run(), ("Q",))
    assert dict(mpl.rcParams) == before


def test_drawn_contact_angles_are_slopes_of_the_rail_and_positive_on_the_flange(axes):
    dataset = static_poses((-7.0, 6.0, 7.0), (0.0,))  # right flange, left flange root, left flange
    angles = ("contact_angle_min", "contact_angle", "contact_angle_max")
    largest = {}
    for pose, wheel in product(range(3), ("left", "right")):
        (where,) = patches_at(dataset, pose, wheel)
        axes.clear()
        cross_section_zoom(axes, dataset, where, pressure_scale(dataset))
        (fan,) = [c for c in axes.collections if c.get_gid() == "normals"]
        foot, tip = np.transpose(fan.get_segments(), (1, 0, 2))
        rail = next(line for line in axes.get_lines() if line.get_gid() == "rail").get_xydata()[1:-1]
        nearest = np.argmin(np.hypot(*(rail[:, None] - foot).transpose(2, 0, 1)), axis=0)
        climb = rail[nearest + 1] - rail[nearest - 1]
        slope = np.degrees(np.arctan2(climb[:, 1], climb[:, 0]))
        lean = np.degrees(np.arctan2(*((tip - foot) * (-1.0, 1.0)).T))  # of the normals to the middle of the track
        np.testing.assert_allclose(lean, slope, atol=5.0)  # strips lie between rail and wheel
        history = [float(np.degrees(dataset[name].sel(wheel=wheel)[pose, 0])) for name in angles]
        assert history[0] - 1.0 < lean.min() <= history[1] <= lean.max() < history[2] + 1.0
        largest[pose, wheel] = lean.max()
    assert largest[0, "right"] > 60.0 and largest[2, "left"] > 60.0
    assert largest[0, "left"] < 5.0 and largest[2, "right"] < 5.0
