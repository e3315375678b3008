"""One look for all pictures: sizes, fonts, colours, units. No pyplot, no global state.

Colours are from Okabe and Ito's set, told apart with any common colour vision deficiency and in grey. The
left wheel is blue and the right one vermilion in every picture.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from wrsim.results import CHANNELS, write_atomically

MM = 1.0 / 25.4
"""Inches in a millimetre."""
FULL_WIDTH = 170.0
"""Width of a page of a journal, mm."""

WHEEL_COLOUR = {"left": "#0072B2", "right": "#D55E00"}
INK = "#222222"
QUIET = "#6b6b6b"
FAINT = "#d9d9d9"
CANT_COLOUR = "#9467A9"
STOP_COLOUR = "#B00020"
RAIL_FILL = "#e4e7eb"
WHEEL_FILL = "#f4efe4"
Dashes = tuple[float, tuple[float, ...]]

GROUP_LINE: tuple[Dashes | Literal["-"], ...] = (
    "-",
    (0, (4, 1.2)),
    (0, (1, 1)),
    (0, (5, 1, 1, 1)),
    (0, (2, 2)),
    (0, (7, 1, 1, 1, 1, 1)),
)
"""Line style of the first, second, ... yaw or load."""
PATCH_LINE = GROUP_LINE[:3]
"""Line style of patch 0, 1, 2."""
GROUP_MARK = ("o", "s", "^", "D", "v", "x")
SERIES_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", CANT_COLOUR, QUIET)
"""Colours of the first, second, ... mode or wheelset."""

STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 7.5,
    "mathtext.fontset": "dejavusans",
    "axes.titlesize": 7.5,
    "axes.titlelocation": "left",
    "axes.labelsize": 7.5,
    "axes.labelcolor": INK,
    "axes.edgecolor": INK,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.5,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.1,
    "lines.markersize": 2.6,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 7.0,
    "legend.handlelength": 2.2,
    "legend.columnspacing": 1.4,
    "figure.dpi": 100,
    "savefig.dpi": 220,
    "figure.facecolor": "white",
}


def pressure_map() -> Colormap:
    """Colours of contact pressure: pale where it is low, dark where it is high, even in lightness."""
    stops = mpl.colormaps["magma_r"](np.linspace(0.06, 0.9, 256))
    return LinearSegmentedColormap.from_list("pressure", stops)


@contextmanager
def style() -> Iterator[None]:
    """Matplotlib settings of all pictures, for the time of the block."""
    with mpl.rc_context(STYLE):
        yield


def new_figure(width_mm: float, height_mm: float, *, constrained: bool = True) -> Figure:
    """Empty figure on an Agg canvas, of a size in mm."""
    size = (width_mm * MM, height_mm * MM)
    figure = Figure(figsize=size, layout="constrained") if constrained else Figure(figsize=size)
    FigureCanvasAgg(figure)
    return figure


def place(figure: Figure, left: float, top: float, width: float, height: float) -> Axes:
    """Axes of a size in mm, ``top`` measured down from the upper edge of the figure."""
    across, down = figure.get_size_inches() / MM
    return figure.add_axes((left / across, 1.0 - (top + height) / down, width / across, height / down))


def write(figure: Figure, left: float, top: float, words: str, **options: Any) -> None:
    """Words whose upper left corner is at a place in mm, ``top`` measured down from the upper edge of the figure."""
    across, down = figure.get_size_inches() / MM
    figure.text(left / across, 1.0 - top / down, words, **({"va": "top", "ha": "left"} | options))


def note(axes: Axes, text: str, at: tuple[float, float], offset: tuple[float, float], **options: Any) -> None:
    """Small words beside a point of the data; offset: from the point, in points."""
    settings: dict[str, Any] = {"textcoords": "offset points", "fontsize": 6.5, "color": QUIET} | options
    axes.annotate(minus(text), at, xytext=offset, **settings)


def note_above(axes: Axes, text: str, x: float, lift: float = 1.5, **options: Any) -> None:
    """Small words above the axes, over x."""
    note(axes, text, (x, 1.0), (0.0, lift), xycoords=("data", "axes fraction"), ha="center", va="bottom", **options)


def remark(axes: Axes, words: str) -> None:
    """How to read the axes, small above them."""
    axes.set_title(words, fontsize=6.5, color=QUIET, pad=2.0)


def minus(words: str) -> str:
    """Words of a number with a minus sign for a hyphen."""
    return words.replace("-", "\N{MINUS SIGN}")


def few_ticks(axes: Axes, most: int, size: float, pad: float = 1.5) -> None:
    """At most so many round ticks on both axes, with small numbers."""
    axes.tick_params(labelsize=size, pad=pad)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(most, steps=[1, 2, 5, 10]))


def right_axis(axes: Axes) -> Axes:
    """A second vertical axis at the right."""
    right = axes.twinx()
    right.spines["right"].set_visible(True)
    right.grid(False)
    return right


def wheel_entries(wheels: Iterable[Any] = ("left", "right")) -> list[Artist]:
    """Entries of a legend for the wheels."""
    return [Line2D([], [], color=WHEEL_COLOUR[str(w)], label=f"{w} wheel") for w in wheels]


def headline(figure: Figure, title: str, note: str = "") -> None:
    """Title of a picture at its upper left; beneath it, in red, a note about a stopped analysis."""
    left = 0.012 * figure.get_figwidth() / MM
    write(figure, left, 2.0, title, fontsize=8.5)
    if note:
        write(figure, left, 6.5, note, color=STOP_COLOUR)


def save(figure: Figure, path: str | Path) -> Path:
    """Write the figure as PNG, or SVG by its name, whole or not at all; the same figure gives the same bytes."""
    stream = io.BytesIO()
    vector = Path(path).suffix.lower() == ".svg"
    with style(), mpl.rc_context({"svg.hashsalt": "wrsim", "svg.fonttype": "path"}):
        metadata = {"Date": None} if vector else {"Software": None}
        figure.savefig(stream, format="svg" if vector else "png", metadata=metadata)
    return write_atomically(path, stream.getvalue())


def shown(dataset: xr.Dataset, name: str) -> NDArray[np.float64]:
    """Values of a channel in the unit for readers."""
    return np.asarray(dataset[name].values, dtype=float) * CHANNELS[name].shown.factor


def draw_line(axes: Axes, x: NDArray[Any], y: NDArray[Any], **options: Any) -> None:
    """Line through the finite values; a value without neighbours becomes a dot, so that none goes unseen."""
    (line,) = axes.plot(x, y, **options)
    alone = without_neighbours(x + y)
    if alone.any() and line.get_marker() in ("None", None, "", " "):
        look: Any = {"color": line.get_color(), "zorder": line.get_zorder()}
        axes.plot(x[alone], y[alone], "o", markersize=1.8, label="_dots", **look)


def without_neighbours(values: NDArray[Any]) -> NDArray[np.bool_]:
    """Where a value is finite and its neighbours are not."""
    finite = np.pad(np.isfinite(values), 1)
    return np.asarray(finite[1:-1] & ~finite[:-2] & ~finite[2:])


def abscissa(dataset: xr.Dataset) -> tuple[NDArray[np.float64], str]:
    """Values and name of the channel to draw a run against: distance, or time when the wheelset rests."""
    name = "time"
    if "distance" in dataset.variables:
        distance = dataset["distance"].values
        if distance.size < 2 or np.ptp(distance) > 1e-9:
            name = "distance"
    return shown(dataset, name), name


def broken(
    x: NDArray[Any], y: NDArray[Any], jump: float, *, by: NDArray[Any] | None = None
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Copies of (x, y) for a line that is interrupted where neighbours in ``by`` differ by more than ``jump``.

    ``by`` is ``y`` itself unless given.
    """
    with np.errstate(invalid="ignore"):
        at = np.flatnonzero(np.abs(np.diff(y if by is None else by)) > jump) + 1
    return np.insert(x.astype(float), at, 0.5 * (x[at - 1] + x[at])), np.insert(y.astype(float), at, np.nan)
