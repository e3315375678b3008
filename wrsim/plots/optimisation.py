"""Pictures of an optimisation: how the costs fell, where the keys went, the Pareto front."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from wrsim.plots.marks import panels
from wrsim.plots.study import COMPLETED, axis_label
from wrsim.plots.theme import INK, SERIES_COLOURS, STOP_COLOUR

DOT: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 2.6, "markeredgewidth": 0.0}
HEIGHT, MOST_KEYS = 40.0, 6
"""Height of a panel [mm]; keys that are drawn."""


def optimisation_figures(dataset: xr.Dataset, front: Sequence[int]) -> dict[str, Callable[[], Figure]]:
    """Makers of the pictures of a history of candidates, by name. front: numbers of those on it, by the first cost."""
    makers: dict[str, Callable[[], Figure]] = {"history": partial(history_figure, dataset)}
    if "cost_2" in dataset:
        makers["front"] = partial(front_figure, dataset, front)
    return makers


def history_figure(dataset: xr.Dataset) -> Figure:
    """Every cost and every varied key over the candidates; the line is the best one so far."""
    costs = [str(name) for name in dataset.data_vars if "sign" in dataset[name].attrs]
    keys = [str(name) for name, c in dataset.coords.items() if "key" in c.attrs and c.dtype.kind == "f"][:MOST_KEYS]
    kept = (dataset["status"] == COMPLETED).values

    def draw(axes: Axes, name: str) -> None:
        number, values = dataset["evaluation"].values, _shown(dataset, name)
        axes.plot(number[~kept], values[~kept], color=STOP_COLOUR, **DOT)
        axes.plot(number[kept], values[kept], color=SERIES_COLOURS[0], **DOT)
        if name in costs:
            best = np.fmin.accumulate(np.where(kept, dataset[name].values, np.nan)) * dataset[name].attrs["sign"]
            axes.plot(number, best, color=INK, linewidth=0.8, drawstyle="steps-post")
            if kept.any():  # what fails may be orders of magnitude away
                axes.set_ylim(_margin(values[kept], best))
        axes.set_ylabel(_label(dataset, name))
        axes.set_xlabel("candidate")

    draws = [partial(draw, name=name) for name in (*costs, *keys)]
    return panels(dataset.attrs["title"], draws, HEIGHT * len(draws), legend=_legend("best so far"))


def front_figure(dataset: xr.Dataset, front: Sequence[int]) -> Figure:
    """All candidates over both costs, and the front."""
    x, y = (_shown(dataset, name) for name in ("cost_1", "cost_2"))
    kept = (dataset["status"] == COMPLETED).values
    best = [number - 1 for number in front]

    def draw(axes: Axes) -> None:
        axes.plot(x[~kept], y[~kept], color=STOP_COLOUR, **DOT)
        axes.plot(x[kept], y[kept], color=SERIES_COLOURS[0], **DOT)
        axes.plot(x[best], y[best], color=INK, linewidth=0.8, marker="o", markersize=3.0)
        axes.set(xlabel=_label(dataset, "cost_1"), ylabel=_label(dataset, "cost_2"))
        if kept.any():
            axes.set(xlim=_margin(x[kept], x[best]), ylim=_margin(y[kept], y[best]))

    return panels(dataset.attrs["title"], [draw], 90.0, legend=_legend("Pareto front"))


def _shown(dataset: xr.Dataset, name: str) -> NDArray[np.float64]:
    return np.asarray(dataset[name].values * dataset[name].attrs.get("sign", 1.0))


def _label(dataset: xr.Dataset, name: str) -> str:
    series = dataset[name].attrs.get("long_name")
    return str(series) if series else axis_label(dataset, name)


def _margin(values: NDArray[np.float64], line: NDArray[np.float64]) -> tuple[float, float]:
    """Limits with room for the line, and for four of five values."""
    low, high = np.nanmin([np.nanmin(values), np.nanmin(line)]), np.nanmax([np.nanpercentile(values, 80), *line])
    room = 0.08 * (high - low) or 0.05 * abs(low) or 1.0
    return float(low - room), float(high + room)


def _legend(line: str) -> list[Line2D]:
    dots = {"keeps all constraints": SERIES_COLOURS[0], "exceeds one, or has no result": STOP_COLOUR}
    return [
        *(Line2D([], [], color=colour, label=label, **DOT) for label, colour in dots.items()),
        Line2D([], [], color=INK, linewidth=0.8, label=line),
    ]
