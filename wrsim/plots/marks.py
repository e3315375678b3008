"""What pictures write and draw alike on their axes: small words, ticks, entries of legends, lines with gaps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from wrsim.plots.colours import QUIET, WHEEL_COLOUR


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


def legend_beneath(figure: Figure, entries: Sequence[Artist], columns: int) -> None:
    """One legend beneath all panels, in so many columns, or in as many as the figure is wide enough for."""
    loc: Any = "lower center" if figure.get_layout_engine() is None else "outside lower center"
    for ncols in range(columns, 0, -1):
        legend = figure.legend(handles=list(entries), loc=loc, ncols=ncols)
        if ncols == 1 or legend.get_window_extent().width <= figure.bbox.width:
            return
        legend.remove()


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


def broken(
    x: NDArray[Any], y: NDArray[Any], jump: float, *, by: NDArray[Any] | None = None
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Copies of (x, y) for a line that is interrupted where neighbours in ``by`` differ by more than ``jump``.

    ``by`` is ``y`` itself unless given.
    """
    with np.errstate(invalid="ignore"):
        at = np.flatnonzero(np.abs(np.diff(y if by is None else by)) > jump) + 1
    return np.insert(x.astype(float), at, 0.5 * (x[at - 1] + x[at])), np.insert(y.astype(float), at, np.nan)
