"""Pictures that can be published: nothing overlaps, nothing is hidden, cut short or left unexplained."""

from functools import partial
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.text import Text
from PIL import Image
from support import synthetic_result
from support.commands import ok, refusal
from support.rows import rows_of
from typer.main import get_command

import wrsim
from wrsim import InputError, Result, load, load_profile, run
from wrsim.cli import application
from wrsim.plots import patch_gallery, section_gallery, standard_figures
from wrsim.plots.drawing import save_all
from wrsim.plots.histories import channels_figure, overview_figure
from wrsim.plots.profile import profile_figure
from wrsim.plots.stability import stability_figures
from wrsim.plots.static import static_figure
from wrsim.plots.theme import LOOK, STOP_COLOUR, look_of, style

table = rows_of(__file__)


@pytest.fixture(scope="module")
def curve_wheelset() -> xr.Dataset:
    return Result(synthetic_result.curve_run(samples=120)).wheelset()


@pytest.fixture(scope="module")
def conicity() -> Result:
    return run(load(Path(__file__).parents[2] / "scenarios/conicity_s1002.toml"))


def rows_of(figure) -> list:
    return [axes for axes in figure.axes if axes.get_title("left")]


@pytest.mark.parametrize("radius", [300.0, 150.0])
def test_the_derailment_quotient_has_its_limit_where_there_is_one(curve_wheelset, radius) -> None:
    """EN 14363 sets none in curves below 250 m."""
    dataset = curve_wheelset.assign(curvature=("time", np.where(curve_wheelset["distance"] > 100.0, 1.0 / radius, 0.0)))
    dataset["Y_over_Q"] = dataset["Y_over_Q"] * (0.5 / float(np.nanmax(dataset["Y_over_Q"])))
    figure = channels_figure(dataset, ("Y_over_Q",))
    (limit,) = [line for axes in figure.axes for line in axes.lines if line.get_gid() == "limit"]
    assert limit.get_color() == STOP_COLOUR
    values = np.asarray(limit.get_ydata())
    assert np.nanmax(values) == 0.8
    assert np.isfinite(values).all() == (radius >= 250.0)
    assert np.isfinite(values[curve_wheelset["distance"].values < 100.0]).all()
    assert limit.axes.get_ylim()[1] > 0.8


def stability(ending: list[str]) -> xr.Dataset:
    """Two modes of one name; limit cycles that ended so."""
    speed, damping = np.array([10.0, 20.0]), np.array([[0.1, 0.2], [0.05, 0.15]])
    modes = {"damping": damping, "growth": -damping, "frequency": np.array([[1.0, 5.0], [1.2, 5.2]])}
    cycles = np.arange(20.0, 20.0 + len(ending))
    return xr.Dataset(
        {f"mode_{name}": (("pose", "mode"), values) for name, values in modes.items()}
        | {
            "pose_speed": ("pose", speed),
            "mode_branch": (("pose", "mode"), np.array([[1, 2], [1, 2]])),
            "mode_name": (("pose", "mode"), np.full((2, 2), "bogie lateral")),
            "cycle_speed": ("cycle", cycles),
            "cycle_amplitude": (("cycle", "wheelset"), np.full((len(ending), 1), 8e-3)),
            "cycle_branch": ("cycle", np.full(len(ending), "from above")),
            "cycle_ending": ("cycle", np.array(ending)),
        },
        attrs={"title": "stability", "critical_note": ""},
    )


def test_no_line_runs_over_a_motion_that_has_not_settled() -> None:
    drawn = stability_figures(stability(["cycle", "cycle", "unsettled", "cycle", "cycle"]))["bifurcation"]()
    (axes,) = drawn.axes
    (line,) = [line for line in axes.lines if line.get_gid() == "from above"]
    assert np.isfinite(np.asarray(line.get_ydata())).tolist() == [True, True, False, True, True]


def test_nothing_that_is_written_beneath_panels_leaves_the_picture(curve_wheelset) -> None:
    """Of one moment a gallery has two panels, and is narrower than others."""
    stopped = curve_wheelset.assign_attrs(status="stopped", stop_reason="a reason that takes more than one line " * 4)
    for gallery in (patch_gallery, section_gallery):
        figure = gallery(stopped, [0])
        figure.draw_without_rendering()
        for text in figure.texts:
            box = text.get_window_extent()
            assert box.x0 >= 0.0 and box.x1 <= figure.bbox.width and box.y0 >= 0.0, text.get_text()


def test_pictures_have_the_width_the_font_and_the_kinds_that_are_chosen(curve_wheelset, tmp_path) -> None:
    (tmp_path / "mine.mplstyle").write_text("lines.linewidth: 3")
    look = look_of("png, pdf,svg", 85.0, "DejaVu Serif", str(tmp_path / "mine.mplstyle"))
    token = LOOK.set(look)
    try:
        figure = standard_figures(curve_wheelset)["overview"]()
        files = save_all({"forces": lambda: channels_figure(curve_wheelset, ("Q",))}, tmp_path)
    finally:
        LOOK.reset(token)
    assert [file.suffix for file in files] == [".png", ".pdf", ".svg"]
    assert files[1].read_bytes().startswith(b"%PDF") and b"<svg" in files[2].read_bytes()
    assert figure.get_size_inches()[0] == pytest.approx(85.0 / 25.4)
    assert figure.axes[0].yaxis.label.get_fontfamily() == ["DejaVu Serif", "DejaVu Sans"]
    assert len(figure.axes) > 5 and figure.axes[0].get_position().width > 0.5  # one column: too narrow for two


def test_without_titles_and_captions_the_rest_of_a_picture_is_as_large_and_a_stop_is_still_told(
    curve_wheelset, conicity
) -> None:
    stopped = curve_wheelset.assign_attrs(status="stopped", stop_reason="derailed")
    makers = {
        name: partial(make, stopped) for name, make in (("overview", overview_figure), ("patches", patch_gallery))
    }
    makers |= standard_figures(conicity.dataset) | {
        "profile": lambda: profile_figure(load_profile("wheels/S1002.toml"))
    }
    titled = {name: make() for name, make in makers.items()}
    with wrsim.look(no_title=True):
        bare = {name: make() for name, make in makers.items()}
    for name, figure in bare.items():
        assert titled[name].get_suptitle() and not figure.get_suptitle().strip(), name
        gone = set(t.get_text() for t in titled[name].texts) - set(t.get_text() for t in figure.texts)
        assert not any("stopped" in text for text in gone), name
    sizes = [[figure.get_size_inches()[1] * 25.4 for figure in (titled[n], bare[n])] for n in ("overview", "patches")]
    assert all(before - after >= 5.0 - 1e-9 for before, after in sizes)
    for before, after in zip(titled["overview"].axes, bare["overview"].axes, strict=True):
        heights = [axes.get_position().height * axes.figure.get_size_inches()[1] for axes in (before, after)]
        assert heights[0] == pytest.approx(heights[1])


DRAWING = {"run", "study", "wear", "compare", "resolve", "plot", "diff", "assess", "ride", "spectra"}
DRAWING |= {"conicity", "recording", "optimise", "validate", "calibrate"}
NAMED = {"profile", "track", "vehicle"}
"""Commands whose pictures are named as a whole: the ending is their kind."""


def test_commands_that_draw_have_the_options_of_pictures_and_draw_in_that_width(tmp_path: Path) -> None:
    options = {name: {p.name for p in each.params} for name, each in get_command(application()).commands.items()}
    assert {
        name for name, parameters in options.items() if {"width_mm", "font", "style", "no_title"} <= parameters
    } == DRAWING | NAMED
    assert {name for name, parameters in options.items() if "formats" in parameters} == DRAWING
    ok("profile", "wheels/S1002.toml", "-o", tmp_path / "p.png", "--width-mm", "80")
    with Image.open(tmp_path / "p.png") as picture:
        assert picture.width == pytest.approx(80.0 / 25.4 * 220, abs=1.0)
    assert "--width-mm 20: must be from 60 to 500" in refusal(
        "profile", "wheels/S1002.toml", "-o", tmp_path / "p.png", "--width-mm", "20"
    )
    told = refusal("profile", "wheels/S1002.toml", "-o", tmp_path / "p.png", "--gauge-mm", "1430")
    assert "--gauge-mm without --on" in told


def drawn_texts(figure, patch: pytest.MonkeyPatch) -> list[Text]:
    """All words of a picture that are drawn: ticks beyond the ends of an axis are not."""
    drawn, draw = dict[int, Text](), Text.draw
    with patch.context() as patched, style():
        patched.setattr(Text, "draw", lambda text, renderer: (drawn.update({id(text): text}), draw(text, renderer)))
        figure.draw_without_rendering()
    return [text for text in drawn.values() if text.get_visible() and text.get_text().strip()]


@pytest.mark.parametrize(
    ("width", "look", "moments"),
    [
        (80.0, {"font": "DejaVu Sans Mono"}, 2),
        pytest.param(80.0, {"font": "DejaVu Sans Mono"}, None, marks=pytest.mark.campaign),
        pytest.param(125.0, {"style": "big"}, None, marks=pytest.mark.campaign),
        pytest.param(80.0, {}, None, marks=pytest.mark.campaign),
        pytest.param(180.0, {"style": "ggplot"}, None, marks=pytest.mark.campaign),
    ],
    ids=str,
)
def test_no_word_is_cut_off_or_over_another_one_whatever_the_width_the_style_and_the_font(
    curve_wheelset, conicity, width, look, moments, tmp_path, monkeypatch
) -> None:
    curve_wheelset = curve_wheelset.isel(snapshot=slice(moments))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "big").write_text("font.size: 20\naxes.labelsize: 30\nfigure.figsize: 1, 1\nsavefig.bbox: tight")
    token = LOOK.set(look_of(width=width, **look))
    try:
        cycles = stability(["cycle"]).assign_attrs(critical_note="stable at all speeds, " * 8)
        makers = stability_figures(cycles) | standard_figures(conicity.dataset) | standard_figures(curve_wheelset)
        for name, make in makers.items():
            figure = make()
            figure.set_dpi(220)
            drawn = drawn_texts(figure, monkeypatch)
            for text in (*drawn, *figure.legends):
                box = text.get_window_extent()
                outside = max(-box.x0, -box.y0, box.x1 - figure.bbox.width, box.y1 - figure.bbox.height)
                assert outside <= 2.0, (name, text, outside)
            level = [text for text in drawn if text.get_rotation() == 0.0]
            for (label, box), (neighbour, beside) in combinations([(t, t.get_window_extent()) for t in level], 2):
                across = min(box.x1, beside.x1) - max(box.x0, beside.x0)
                up = min(box.y1, beside.y1) - max(box.y0, beside.y0)  # extents reach above and beneath the letters
                assert across < 2.0 or up < 0.3 * min(box.height, beside.height), (name, label, neighbour)
    finally:
        LOOK.reset(token)


@pytest.mark.parametrize("chosen", table("what_pictures_cannot_be_is_refused"), ids=str)
def test_what_pictures_cannot_be_is_refused(chosen, tmp_path) -> None:
    (tmp_path / "bad").write_text("lines.linewidht: 3")
    with pytest.raises(
        InputError, match=r"none of png|dark background|font not found|did you mean 'ggplot'|line 1.*lines\.linewidth"
    ):
        look_of(**{key: str(tmp_path / "bad") if value == "BAD" else value for key, value in chosen.items()})


def test_poses_that_no_railway_has_are_left_out_of_the_axes() -> None:
    poses = synthetic_result.static_poses(shifts_mm=(0.0, 2.0, 4.0, 6.0), yaws_mrad=(0.0,))
    dataset = Result(poses).wheelset().copy(deep=True)
    dataset["N"][-1] = 172e3  # each of two patches
    figure = static_figure(dataset)
    (force,) = [axes for axes in figure.axes if "Normal force" in axes.get_ylabel()]
    assert force.get_ylim()[1] < 200.0
    assert any("1 of 4 poses" in text.get_text() and "kN" in text.get_text() for text in figure.texts)
