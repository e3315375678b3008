"""Pictures of measured series beside models: over the distance, as spectra, and value against value."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wrsim.plots.marks import panels
from wrsim.plots.theme import FAINT, INK, QUIET, SERIES_COLOURS, STOP_COLOUR
from wrsim.results.moments import Array

Lines = Mapping[str, tuple[Array, Array]]
"""Abscissa (n,) and values (n,) by the name of a line; the measured ones first."""
MOST_PANELS = 12
DECADES = 1e-7
"""Densities from this part of the largest on are shown."""
COLOURS = (INK, *SERIES_COLOURS[:2], SERIES_COLOURS[2])


class Panel(NamedTuple):
    """label: of the vertical axis, across: of the horizontal one; lines by their names."""

    label: str
    across: str
    lines: Lines
    log: bool = False


def lines_figure(title: str, shown: Sequence[Panel]) -> Figure:
    """A panel for every series, of which the first dozen are drawn."""

    def draw(axes: Axes, panel: Panel) -> None:
        for i, (name, (x, y)) in enumerate(panel.lines.items()):
            many = np.size(x) > 40
            look: Any = {"color": COLOURS[i % len(COLOURS)], "label": name, "linewidth": 1.1 if i == 0 else 0.9}
            axes.plot(x, y, marker="" if many else "o", markersize=2.5, linestyle="-" if many else "none", **look)
        if panel.log:
            top = max(float(np.max(y)) for _, y in panel.lines.values())
            axes.set(xscale="log", yscale="log", ylim=(top * DECADES, 3.0 * top))
        axes.set(xlabel=panel.across, ylabel=panel.label)

    names = list(dict.fromkeys(name for panel in shown for name in panel.lines))
    legend = [Line2D([], [], color=COLOURS[i % len(COLOURS)], label=name) for i, name in enumerate(names)]
    draws: list[Callable[[Axes], object]] = [partial(draw, panel=panel) for panel in shown[:MOST_PANELS]]
    columns = 2 if shown[0].log and len(draws) > 1 else 1
    rows = -(-len(draws) // columns)
    return panels(title, draws, 24.0 + 36.0 * rows, columns=columns, share=False, legend=legend)


def scatter_figure(title: str, shown: Mapping[str, tuple[Array, Array]], groups: Mapping[str, Sequence[str]]) -> Figure:
    """Model against measurement. shown: measured and model's values (n,) by quantity; groups: class of each value."""
    names = list(dict.fromkeys(group for each in groups.values() for group in each))
    colour = dict(zip(names, SERIES_COLOURS * 8, strict=False))

    def draw(axes: Axes, label: str) -> None:
        measured, model = shown[label]
        for name in dict.fromkeys(groups[label]):
            members = np.array(groups[label]) == name
            axes.plot(measured[members], model[members], "o", markersize=2.8, color=colour[name], alpha=0.8)
        values = np.concatenate([measured, model])
        low, high = values.min() - 0.05 * np.ptp(values), values.max() + 0.05 * np.ptp(values)
        axes.plot([low, high], [low, high], color=QUIET, linewidth=0.8)
        axes.set(xlabel=f"{label}, measured", ylabel="model")

    legend = [Line2D([], [], color=c, marker="o", linestyle="none", label=name) for name, c in colour.items()]
    draws: list[Callable[[Axes], object]] = [partial(draw, label=label) for label in list(shown)[:MOST_PANELS]]
    rows = -(-len(draws) // 3)
    return panels(title, draws, 24.0 + 52.0 * rows, columns=3, share=False, legend=legend)


Bar = tuple[tuple[float, float], tuple[float, float], float, bool]
"""Interval before, interval after, value, whether it is told."""


def intervals_figure(title: str, bars: Mapping[str, Bar]) -> Figure:
    """What was known of every key before (grey) and after, over the middle of what was known before."""

    def draw(axes: Axes) -> None:
        for row, (before, after, value, told) in enumerate(bars.values()):
            middle, half = 0.5 * sum(before), 0.5 * (before[1] - before[0])
            axes.plot([-1.0, 1.0], [row, row], color=FAINT, linewidth=7.0, solid_capstyle="butt")
            colour = SERIES_COLOURS[0] if told else STOP_COLOUR
            axes.plot([(end - middle) / half for end in after], [row, row], color=colour, linewidth=2.0)
            axes.plot((value - middle) / half, row, "o", color=colour, markersize=4.0)
        axes.set_yticks(range(len(bars)), list(bars))
        axes.invert_yaxis()
        axes.set(xlabel="-1 to 1: tolerance of the data sheet, or bounds")

    looks = (("before", FAINT), ("calibrated", SERIES_COLOURS[0]), ("not told by the channels", STOP_COLOUR))
    legend = [Line2D([], [], color=colour, label=name, linewidth=3.0) for name, colour in looks]
    return panels(title, [draw], 32.0 + 7.0 * len(bars), legend=legend)
