"""One look for all pictures: sizes, fonts, units, colours, dashes and marks. No pyplot, no global state.

Colours are from Okabe and Ito's set: they differ with any common colour vision deficiency and in grey. The left wheel
is blue and the right one vermilion in every picture.
"""

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from textwrap import fill
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib import font_manager
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, LinearSegmentedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.text import Text
from matplotlib.textpath import TextPath
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from wrsim.errors import InputError, suggest
from wrsim.plots.units import show_in_units
from wrsim.results import CHANNELS, write_atomically
from wrsim.results.moments import Strips

WHEEL_COLOUR = {"left": "#0072B2", "right": "#D55E00"}
INK = "#222222"
QUIET = "#6b6b6b"
FAINT = "#d9d9d9"
CANT_COLOUR = "#9467A9"
STOP_COLOUR = "#B00020"
RAIL_FILL = "#e4e7eb"
WHEEL_FILL = "#f4efe4"
Dashes = tuple[float, tuple[float, ...]]

DOTS: Dashes = (0, (1, 2))
GROUP_LINE: tuple[Dashes | Literal["-"], ...] = (
    "-", (0, (4, 1.2)), (0, (1, 1)), (0, (5, 1, 1, 1)), (0, (2, 2)), (0, (7, 1, 1, 1, 1, 1)),
)  # fmt: skip
"""Line style of the first, second, ... patch, wheelset, yaw or load."""
GROUP_MARK = ("o", "s", "^", "D", "v", "x")
SERIES_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", CANT_COLOUR, QUIET)
"""Colours of the first, second, ... mode or wheelset."""

MM = 1.0 / 25.4  # inches in a millimetre
KINDS = ("png", "svg", "pdf")
NARROW, WIDE = 60.0, 500.0  # widths that pictures may have [mm]
TWO_COLUMNS = 130.0  # width from which pictures have panels beside each other [mm]


@dataclass(frozen=True)
class Look:
    """What a user chooses of pictures: kinds of files (of ``KINDS``), width [mm] (by default that of a page of a
    journal), whether they have a title and captions, settings of matplotlib over those of ``STYLE``. `look_of` checks
    them."""

    kinds: tuple[str, ...] = ("png",)
    width: float = 170.0
    titled: bool = True
    settings: tuple[tuple[str, Any], ...] = ()


LAID_OUT = re.compile(
    r"(?!lines\.)(.*(size|pad|spacing|length|usetex|layout.*|title[xy])$)"
    r"|(figure|savefig)\.(?!facecolor|edgecolor)|[xy]tick\.(alignment|label|top|right|direction)"
)
"""Settings of matplotlib that the pictures are laid out with: those of a style would clip their letters."""

LOOK: ContextVar[Look] = ContextVar("look", default=Look())  # noqa: B039 (frozen)
"""Choice for the pictures that are drawn."""

STYLE: Any = {
    "font.family": ["DejaVu Sans"], "font.size": 7.5, "mathtext.fontset": "dejavusans",
    "axes.titlesize": 7.5, "axes.titlelocation": "left", "axes.labelsize": 7.5, "axes.labelcolor": INK,
    "axes.edgecolor": INK, "axes.linewidth": 0.6, "axes.spines.top": False, "axes.spines.right": False,
    "axes.grid": True, "axes.axisbelow": True, "axes.unicode_minus": True,
    "grid.color": "#e6e6e6", "grid.linewidth": 0.5,
    "xtick.labelsize": 7.0, "ytick.labelsize": 7.0, "xtick.color": INK, "ytick.color": INK,
    "xtick.direction": "out", "ytick.direction": "out", "xtick.major.size": 2.5, "ytick.major.size": 2.5,
    "xtick.major.width": 0.6, "ytick.major.width": 0.6,
    "lines.linewidth": 1.1, "lines.markersize": 2.6, "lines.solid_capstyle": "round",
    "legend.frameon": False, "legend.fontsize": 7.0, "legend.handlelength": 2.2, "legend.columnspacing": 1.4,
    "figure.dpi": 100, "savefig.dpi": 220, "figure.facecolor": "white",
}  # fmt: skip


def pressure_map() -> Colormap:
    """Colours of contact pressure: pale where it is low, dark where it is high, even in lightness."""
    stops = mpl.colormaps["magma_r"](np.linspace(0.06, 0.9, 256))
    return LinearSegmentedColormap.from_list("pressure", stops)


def look_of(
    formats: str = "png", width: float | None = None, font: str = "", style: str = "", titled: bool = True
) -> Look:
    """formats: kinds of files with commas between; width [mm]; font: the name of a family; style: a style file of
    matplotlib or the name of one of its styles: its colours, lines, grids and families of letters, not its sizes
    (``LAID_OUT``). Raises InputError for what there is not."""
    kinds = tuple(dict.fromkeys(part.strip().lower() for part in formats.split(",")))
    if unknown := [kind for kind in kinds if kind not in KINDS]:
        raise InputError(f"--format {formats}: {unknown[0]!r} is none of {', '.join(KINDS)}")
    settings: dict[str, Any] = {}
    if style:
        from matplotlib import style as styles  # reads them all, which takes time

        is_file = Path(style).is_file()
        if not is_file and style not in styles.available:
            known = suggest(style, styles.available)
            raise InputError(f"--style {style}: is no file and no style of matplotlib{known}")
        try:
            for number, line in enumerate(Path(style).read_text("utf-8").splitlines() if is_file else (), 1):
                key = line.partition("#")[0].partition(":")[0].strip()
                if key and key not in mpl.rcParams:
                    known = suggest(key, list(mpl.rcParams))
                    raise InputError(f"--style {style}, line {number}: matplotlib has no setting {key!r}{known}")
            chosen: Any = mpl.rc_params_from_file(style, True, False) if is_file else styles.library[style]
            settings |= {key: value for key, value in chosen.items() if not LAID_OUT.match(key)}
            grounds = (settings.get(key, "white") for key in ("figure.facecolor", "axes.facecolor"))
            if any(np.dot(to_rgb(ground), LUMA) < 0.5 for ground in grounds):
                raise InputError(f"--style {style}: dark background is not supported, letters are dark")
        except (KeyError, ValueError, UnicodeError, OSError) as problem:
            why = str(problem).strip("' ").splitlines()
            raise InputError(f"--style {style}: is no style file of matplotlib: {why[0] if why else problem}") from None
    if font:
        try:
            font_manager.findfont(font, fallback_to_default=False)
        except ValueError:
            raise InputError(f"--font {font}: font not found{suggest(font, font_manager.get_font_names())}") from None
        settings["font.family"] = [font, *STYLE["font.family"]]  # for the letters that it lacks
    return Look(kinds, width or Look.width, titled, tuple(settings.items()))


def full_width() -> float:
    """Width of pictures of the whole width of a page [mm]."""
    return LOOK.get().width


@contextmanager
def style() -> Iterator[None]:
    """Matplotlib settings of all pictures, for the time of the block."""
    chosen: Any = STYLE | dict(LOOK.get().settings)
    with mpl.rc_context(chosen):
        yield


LUMA = (0.2126, 0.7152, 0.0722)  # brightness of red, green and blue (ITU-R BT.709)
SAMPLE = "Distance along the track [m], largest pressure 0123456789"


@cache
def _narrowing(family: str) -> float:
    """Size of letters of a family over that of the pictures' own, so that words are no wider than they are laid out."""
    if [family] == STYLE["font.family"]:
        return 1.0
    fonts = (FontProperties(family=[name]) for name in (*STYLE["font.family"], family))
    reference, width = (TextPath((0.0, 0.0), SAMPLE, 100, prop=font).get_extents().width for font in fonts)
    return min(1.0, float(reference / max(width, 1e-9)))


class Picture(Figure):
    """A figure that notebooks show by themselves, without pyplot. narrowing: of its letters, which get it once; legends
    beneath have it from the start."""

    narrowing = 1.0

    def draw(self, renderer: Any) -> None:
        if self.narrowing < 1.0:
            for axes in self.axes:  # makes the ticks
                axes.get_xticklabels(), axes.get_yticklabels()
            done = {text for legend in self.legends for text in legend.get_texts()}
            for text in set(self.findobj(Text)) - done:
                text.set_fontsize(self.narrowing * float(text.get_fontsize()))
            self.narrowing = 1.0
        super().draw(renderer)

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        with style():
            show_in_units(self)
            self.savefig(stream, format="png", dpi=120)
        return stream.getvalue()


def new_figure(width_mm: float, height_mm: float, *, constrained: bool = True) -> Figure:
    """Empty figure on an Agg canvas, of a size in mm."""
    figure = Picture(figsize=(width_mm * MM, height_mm * MM), layout="constrained" if constrained else None)
    figure.narrowing = _narrowing(mpl.rcParams["font.family"][0])
    FigureCanvasAgg(figure)
    return figure


class InView(MaxNLocator):
    """Ticks within an axis, without those next beyond, which are made and not drawn: a third of all. From a single one
    the digits of its number would not be known."""

    def tick_values(self, vmin: float, vmax: float) -> Any:
        places: Any = super().tick_values(vmin, vmax)
        (low, high), margin = sorted((vmin, vmax)), 1e-10 * abs(vmax - vmin)  # as they are drawn
        seen = places[(low - margin <= places) & (places <= high + margin)]
        return seen if seen.size > 1 else places


def mm_axes(figure: Figure, left: float, top: float, width: float, height: float) -> Axes:
    """Axes of a size in mm, ``top`` measured down from the upper edge of the figure."""
    across, down = figure.get_size_inches() / MM
    axes = figure.add_axes((left / across, 1.0 - (top + height) / down, width / across, height / down))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(InView("auto", steps=[1, 2, 2.5, 5, 10]))
    return axes


def write_text(figure: Figure, left: float, top: float, text: str, **options: Any) -> None:
    """Words whose upper left corner is at a place in mm, ``top`` measured down from the upper edge of the figure."""
    across, down = figure.get_size_inches() / MM
    figure.text(left / across, 1.0 - top / down, text, **({"va": "top", "ha": "left"} | options))


LINE, TITLE = 3.6, 5.0  # height of a line of a title or a note, and of the room of a title of one line, mm


def wrapped(text: str, width: float, size: float = 7.5) -> str:
    """Words in as many lines as they need in a width of mm, in letters of that size in points; none on its own."""
    letters = max(int(width / (0.195 * size)), 10)
    tied = ("\N{NO-BREAK SPACE}".join(line.rsplit(" ", 1)) for line in text.split("\n"))
    return "\n".join(fill(line, letters) for line in tied).replace("\N{NO-BREAK SPACE}", " ")


def caption(text: str) -> str:
    """A title, or words on how to read a picture; none where the user wants pictures without them."""
    return text if LOOK.get().titled else ""


def headline(figure: Figure, title: str, note: str = "") -> None:
    """Title of a picture at its upper left; beneath it, in red, a note about a stopped analysis. Of `head_height`."""
    across, down = figure.get_size_inches() / MM
    title, note = (wrapped(text, 0.97 * across, size) for text, size in ((caption(title), 8.5), (note, 7.5)))
    if title:
        figure.suptitle(title, x=0.012, y=1.0 - 2.0 / down, ha="left", va="top", fontsize=8.5)
    if note:
        top = 6.5 + LINE * title.count("\n") if title else 6.5 - TITLE
        write_text(figure, 0.012 * across, top, note, color=STOP_COLOUR)


def head_height(title: str, note: str, across: float) -> float:
    """Height of the title and the note of a picture of that width, mm, less that of a title of one line."""
    more = wrapped(title, 0.97 * across, 8.5).count("\n") if caption(title) else -TITLE / LINE
    return LINE * (more + (1 + wrapped(note, 0.97 * across).count("\n") if note else 0))


def save(figure: Figure, path: str | Path) -> Path:
    """Write the figure as PNG, or SVG or PDF by its name, whole or not at all; the same figure gives the same bytes."""
    kind = Path(path).suffix.lower().removeprefix(".")
    return write_atomically(path, rendered(figure, kind if kind in KINDS else "png"))


def rendered(figure: Figure, kind: str = "png", dpi: int = 220) -> bytes:
    """The figure as PNG with so many dots an inch, SVG or PDF."""
    stream = io.BytesIO()
    output: Any = {"svg.hashsalt": "wrsim", "svg.fonttype": "path", "pdf.fonttype": 42, "savefig.dpi": dpi}
    with style(), mpl.rc_context(output):
        show_in_units(figure)
        if (layout := figure.get_layout_engine()) is not None:
            # matplotlib draws a figure twice to lay it out; once is enough
            layout.execute(figure)
            figure.set_layout_engine("none")
        for axes in figure.axes:
            for axis in (axes.xaxis, axes.yaxis):
                if not axis.get_label_text():  # its place beside the ticks would be looked for
                    axis.set_label_coords(0.0, 0.0)
        if kind == "png":  # a tenth more bytes than at the usual level, a fifth less time
            figure.savefig(stream, format="png", metadata={"Software": None}, pil_kwargs={"compress_level": 1})
        else:
            figure.savefig(stream, format=kind, metadata={"Date" if kind == "svg" else "CreationDate": None})
    return stream.getvalue()


def shown(dataset: xr.Dataset | Strips, name: str) -> NDArray[np.float64]:
    """Values of a channel in the unit for readers; not-a-number, which is not drawn, also for infinite ones."""
    values = np.asarray(dataset.variables[name], dtype=float) * CHANNELS[name].shown.factor
    return np.where(np.isfinite(values), values, np.nan)


def abscissa(dataset: xr.Dataset) -> tuple[NDArray[np.float64], str]:
    """Values and name of the channel to draw a run against: distance, or time when the wheelset rests."""
    distance = dataset["distance"].values if "distance" in dataset.variables else np.zeros(2)
    name = "distance" if distance.size < 2 or np.ptp(distance) > 1e-9 else "time"
    return shown(dataset, name), name
