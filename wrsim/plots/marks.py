"""What pictures write and draw alike: small words, ticks, entries of legends, lines with gaps, where a run stopped."""

from collections.abc import Callable, Iterable, Sequence
from math import ceil
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from wrsim.plots import theme
from wrsim.results import CHANNELS
from wrsim.results.table import finite, quantity

SUDDEN, SMALL = 8.0, 1.0 / 12.0
"""A line is interrupted where it moves between two samples so many times as far as between those beside them, and by
more than this part of what is a jump anywhere."""


def note(axes: Axes, text: str, point: tuple[float, float], offset: tuple[float, float], **options: Any) -> None:
    """Small words beside a point of the data; offset: from the point, in points."""
    settings: dict[str, Any] = {"textcoords": "offset points", "fontsize": 6.5, "color": theme.QUIET} | options
    axes.annotate(minus(text), point, xytext=offset, **settings)


def note_above(axes: Axes, text: str, x: float, lift: float = 1.5) -> None:
    """Small words above the axes, over x."""
    note(axes, text, (x, 1.0), (0.0, lift), xycoords=("data", "axes fraction"), ha="center", va="bottom")


def remark(axes: Axes, text: str) -> None:
    """How to read the axes, small above them, in as many lines as it needs there."""
    across = axes.get_window_extent().width / axes.figure.dpi / theme.MM
    axes.set_title(theme.wrapped(theme.caption(text), across, 6.5), fontsize=6.5, color=theme.QUIET, pad=2.0)


@theme.style()
def panels(
    title: str,
    draws: Sequence[Callable[[Axes], object]],
    height: float,
    *,
    columns: int = 1,
    share: bool = True,
    legend: Sequence[Artist] | None = (),
    across: int = 4,
    note: str = "",
) -> Figure:
    """A figure of so many mm height under a title (and, in red, a note), with a panel for each function, row by row.
    share: panels share their horizontal axis, which only the lowest name; legend: entries beneath all panels, in so
    many columns ``across``; None: those of the first panel. Narrow figures have half the columns."""
    narrow = max(columns // 2, 1) if theme.full_width() < theme.TWO_COLUMNS else columns
    rows, drawn = ceil(len(draws) / narrow), list[Axes]()
    figure = theme.new_figure(theme.full_width(), height * rows / ceil(len(draws) / columns))
    columns = narrow
    for i, draw in enumerate(draws):
        axes = figure.add_subplot(rows, columns, i + 1, sharex=drawn[0] if share and drawn else None)
        drawn.append(axes)
        draw(axes)
        if share and i + columns < len(draws):
            axes.tick_params(labelbottom=False)
            axes.set_xlabel("")
    width = 0.97 * theme.full_width()
    title, note = (theme.wrapped(text, width, size) for text, size in ((theme.caption(title), 8.5), (note, 7.5)))
    if title or note:  # lines of the title that are empty make room for the note
        room = "\n" * (note.count("\n") + (1 if title else 0)) + (" " if note else "")
        figure.suptitle(title + room, x=0.012, ha="left", fontsize=8.5)
    theme.write_text(figure, 2.0, 5.5 + theme.LINE * title.count("\n") if title else 2.0, note, color=theme.STOP_COLOUR)
    if entries := drawn[0].get_legend_handles_labels()[0] if legend is None else legend:
        legend_beneath(figure, entries, across)
    figure.align_ylabels(drawn)
    return figure


@theme.style()
def large_and_small(
    title: str, large: Callable[[Axes], object], small: Sequence[Callable[[Axes], object]], height: float, width: float
) -> Figure:
    """A figure of so many mm height: a large panel, so many times as wide as small ones to its right with one axis, or,
    twice as high, above them in narrow figures."""
    narrow = theme.full_width() < theme.TWO_COLUMNS
    figure = theme.new_figure(theme.full_width(), height * (2.0 if narrow else 1.0))
    if title := theme.caption(theme.wrapped(title, 0.97 * theme.full_width(), 8.0)):
        figure.suptitle(title, x=0.012, ha="left", fontsize=8.0)
    if narrow:
        grid = figure.add_gridspec(2 * len(small), 1)
        places = [grid[: len(small), 0], *(grid[len(small) + i, 0] for i in range(len(small)))]
    else:
        grid = figure.add_gridspec(len(small), 2, width_ratios=(width, 1.0))
        places = [grid[:, 0], *(grid[i, 1] for i in range(len(small)))]
    large(figure.add_subplot(places[0]))
    for i, draw in enumerate(small):
        axes = figure.add_subplot(places[1 + i], sharex=figure.axes[-1] if i else None)
        draw(axes)
        if i + 1 < len(small):
            axes.set_xlabel("")
            axes.tick_params(labelbottom=False)
    return figure


def legend_beneath(
    figure: Figure, entries: Sequence[Artist], columns: int, side: str = "center", **options: Any
) -> None:
    """One legend beneath all panels, in so many columns, or in as many as the figure is wide enough for; words that are
    wider than it are wrapped."""
    loc: Any = f"lower {side}" if figure.get_layout_engine() is None else f"outside lower {side}"
    narrowing = getattr(figure, "narrowing", 1.0)
    for ncols in range(columns, 0, -1):
        legend = figure.legend(handles=list(entries), loc=loc, ncols=ncols, **options)
        for text in (texts := legend.get_texts()):
            text.set_fontsize(narrowing * float(text.get_fontsize()))
        over = legend.get_window_extent().width - figure.bbox.width
        if over > 0.0 and ncols > 1:
            legend.remove()
            continue
        room = (max(text.get_window_extent().width for text in texts) - over) / figure.dpi / theme.MM
        for text in texts if over > 0.0 else ():
            text.set_text(theme.wrapped(text.get_text(), room, float(text.get_fontsize()) / narrowing))
        return


def minus(text: str) -> str:
    """Words of a number with a minus sign for a hyphen."""
    return text.replace("-", "\N{MINUS SIGN}")


def few_ticks(axes: Axes, most: int, size: float, pad: float = 1.5) -> None:
    """At most so many round ticks on both axes, with small numbers, upwards no more than the panel has lines for."""
    axes.tick_params(labelsize=size, pad=pad)
    lines = 72.0 * axes.get_window_extent().height / axes.figure.dpi / (1.6 * size)
    for axis, count in ((axes.xaxis, most), (axes.yaxis, max(1, min(most, int(lines))))):
        axis.set_major_locator(theme.InView(count, steps=[1, 2, 5, 10], min_n_ticks=1))


def right_axis(axes: Axes) -> Axes:
    """A second vertical axis at the right."""
    right = axes.twinx()
    right.spines["right"].set_visible(True)
    right.grid(False)
    return right


def wheel_entries(wheels: Iterable[Any] = ("left", "right")) -> list[Artist]:
    """Entries of a legend for the wheels."""
    return [Line2D([], [], color=theme.WHEEL_COLOUR[str(w)], label=f"{w} wheel") for w in wheels]


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


def jumps(values: NDArray[Any], jump: float) -> NDArray[np.intp]:
    """Samples that lie elsewhere than the one ahead of them: by more than ``jump``, or suddenly (``SUDDEN``)."""
    with np.errstate(invalid="ignore"):
        step = np.abs(np.diff(values))
        known = np.pad(np.where(np.isnan(step), np.inf, step), 1, constant_values=np.inf)  # ends are never sudden
        beside = np.maximum(known[:-2], known[2:])
        return np.flatnonzero((step > jump) | (step > np.maximum(SUDDEN * beside, SMALL * jump))) + 1


def broken(
    x: NDArray[Any], y: NDArray[Any], jump: float, *, by: NDArray[Any] | None = None
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Copies of (x, y) for a line interrupted at the ``jumps`` of ``by`` (default: y)."""
    gaps = jumps(y if by is None else by, jump)
    return np.insert(x.astype(float), gaps, 0.5 * (x[gaps - 1] + x[gaps])), np.insert(y.astype(float), gaps, np.nan)


def is_stopped(dataset: xr.Dataset) -> bool:
    """True when the analysis ended before its time."""
    return dataset.attrs.get("status") == "stopped"


def mark_stop(axes: Axes, dataset: xr.Dataset) -> Axes:
    """A red line where a stopped run ended."""
    if is_stopped(dataset):
        axes.axvline(_place(dataset)[0], color=theme.STOP_COLOUR, linewidth=1.0, zorder=4.0, gid="stop")
    return axes


def stop_note(dataset: xr.Dataset) -> str:
    """Where and why the analysis stopped, for a picture; empty for a completed one."""
    if not is_stopped(dataset):
        return ""
    reason = dataset.attrs.get("stop_reason", "")
    known = "time" not in dataset.dims or "along the track" in reason  # the reason holds the place
    place = "" if known else f" at {quantity(*_place(dataset), '.5g')}"
    return f"Stopped{place}: {reason}"


def _place(dataset: xr.Dataset) -> tuple[float, str]:
    x, name = theme.abscissa(dataset)
    unit = CHANNELS[name].shown.symbol
    stop = finite(dataset.attrs.get(f"stop_{name}_{unit}"))
    return (stop if stop is not None else float(x[-1]) if x.size else 0.0), unit
