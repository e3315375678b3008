"""Pictures of measured series beside models: over the distance, as spectra, and value against value."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wrsim.plots.marks import panels
from wrsim.plots.theme import INK, QUIET, SERIES_COLOURS
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
            of = np.array(groups[label]) == name
            axes.plot(measured[of], model[of], "o", markersize=2.8, color=colour[name], alpha=0.8)
        both = np.concatenate([measured, model])
        low, high = both.min() - 0.05 * np.ptp(both), both.max() + 0.05 * np.ptp(both)
        axes.plot([low, high], [low, high], color=QUIET, linewidth=0.8)
        axes.set(xlabel=f"{label}, measured", ylabel="model")

    legend = [Line2D([], [], color=c, marker="o", linestyle="none", label=name) for name, c in colour.items()]
    draws: list[Callable[[Axes], object]] = [partial(draw, label=label) for label in list(shown)[:MOST_PANELS]]
    rows = -(-len(draws) // 3)
    return panels(title, draws, 24.0 + 52.0 * rows, columns=3, share=False, legend=legend)
