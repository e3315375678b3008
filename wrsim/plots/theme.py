"""One look for all pictures: sizes, fonts, units, colours, dashes and marks. No pyplot, no global state.

Colours are from Okabe and Ito's set: they differ with any common colour vision deficiency and in grey. The left wheel
is blue and the right one vermilion in every picture.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, LinearSegmentedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from wrsim.results import CHANNELS, write_atomically

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
FULL_WIDTH = 170.0  # width of a page of a journal, mm

STYLE: Any = {
    "font.family": "DejaVu Sans", "font.size": 7.5, "mathtext.fontset": "dejavusans",
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


@contextmanager
def style() -> Iterator[None]:
    """Matplotlib settings of all pictures, for the time of the block."""
    with mpl.rc_context(STYLE):
        yield


class Picture(Figure):
    """A figure that notebooks show by themselves, without pyplot."""

    def _repr_png_(self) -> bytes:
        stream = io.BytesIO()
        with style():
            self.savefig(stream, format="png", dpi=120)
        return stream.getvalue()


def new_figure(width_mm: float, height_mm: float, *, constrained: bool = True) -> Figure:
    """Empty figure on an Agg canvas, of a size in mm."""
    figure = Picture(figsize=(width_mm * MM, height_mm * MM), layout="constrained" if constrained else None)
    FigureCanvasAgg(figure)
    return figure


def mm_axes(figure: Figure, left: float, top: float, width: float, height: float) -> Axes:
    """Axes of a size in mm, ``top`` measured down from the upper edge of the figure."""
    across, down = figure.get_size_inches() / MM
    return figure.add_axes((left / across, 1.0 - (top + height) / down, width / across, height / down))


def write_words(figure: Figure, left: float, top: float, words: str, **options: Any) -> None:
    """Words whose upper left corner is at a place in mm, ``top`` measured down from the upper edge of the figure."""
    across, down = figure.get_size_inches() / MM
    figure.text(left / across, 1.0 - top / down, words, **({"va": "top", "ha": "left"} | options))


def headline(figure: Figure, title: str, note: str = "") -> None:
    """Title of a picture at its upper left; beneath it, in red, a note about a stopped analysis."""
    across, down = figure.get_size_inches() / MM
    figure.suptitle(title, x=0.012, y=1.0 - 2.0 / down, ha="left", va="top", fontsize=8.5)
    if note:
        write_words(figure, 0.012 * across, 6.5, note, color=STOP_COLOUR)


def save(figure: Figure, path: str | Path) -> Path:
    """Write the figure as PNG, or SVG by its name, whole or not at all; the same figure gives the same bytes."""
    return write_atomically(path, rendered(figure, vector=Path(path).suffix.lower() == ".svg"))


def rendered(figure: Figure, vector: bool = False, dpi: int = 220) -> bytes:
    """The figure as PNG with so many dots an inch, or SVG."""
    stream = io.BytesIO()
    with style(), mpl.rc_context({"svg.hashsalt": "wrsim", "svg.fonttype": "path", "savefig.dpi": dpi}):
        if (layout := figure.get_layout_engine()) is not None:
            # matplotlib draws a figure twice to lay it out; once is enough
            layout.execute(figure)
            figure.set_layout_engine("none")
        if vector:
            figure.savefig(stream, format="svg", metadata={"Date": None})
        else:  # a tenth more bytes than at the usual level, a fifth less time
            figure.savefig(stream, format="png", metadata={"Software": None}, pil_kwargs={"compress_level": 1})
    return stream.getvalue()


def shown(dataset: xr.Dataset, name: str) -> NDArray[np.float64]:
    """Values of a channel in the unit for readers; not-a-number, which is not drawn, also for infinite ones."""
    values = np.asarray(dataset.variables[name].values, dtype=float) * CHANNELS[name].shown.factor
    return np.where(np.isfinite(values), values, np.nan)


def abscissa(dataset: xr.Dataset) -> tuple[NDArray[np.float64], str]:
    """Values and name of the channel to draw a run against: distance, or time when the wheelset rests."""
    distance = dataset["distance"].values if "distance" in dataset.variables else np.zeros(2)
    name = "distance" if distance.size < 2 or np.ptp(distance) > 1e-9 else "time"
    return shown(dataset, name), name
