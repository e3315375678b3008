"""Distances to climb over the angle of attack."""

from collections.abc import Callable
from functools import partial
from itertools import cycle

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim.plots.marks import panels
from wrsim.plots.theme import QUIET, SERIES_COLOURS, shown
from wrsim.results import CHANNELS


def climb_figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Maker of the picture, by file name without ending."""
    return {"climb": partial(climb_figure, dataset)}


def climb_figure(dataset: xr.Dataset) -> Figure:
    """A line per Y/Q; open marks: the rail has held the wheel so far; dashed: TCRP Report 71."""
    attack, way, formula = (shown(dataset, name) for name in ("attack", "climb_distance", "climb_distance_tcrp"))
    quotient, climbed = dataset["climb_quotient"].values, dataset["climbed"].values == 1

    def draw(axes: Axes) -> None:
        for value, colour in zip(np.unique(quotient), cycle(SERIES_COLOURS)):
            points = np.flatnonzero(quotient == value)
            points = points[np.argsort(attack[points])]
            done, held = points[climbed[points]], points[~climbed[points]]
            series = f"Y/Q = {value:.3g}"
            if done.size:
                axes.plot(attack[done], way[done], "o-", color=colour, markersize=3, label=series)
            if held.size:
                label = None if done.size else f"{series}: held"
                axes.plot(attack[held], way[held], "^", color=colour, fillstyle="none", markersize=4, label=label)
        order = np.argsort(attack)
        if np.isfinite(formula).any():
            axes.plot(attack[order], formula[order], color=QUIET, linestyle="--", label="TCRP Report 71")
        axes.set(xlabel=CHANNELS["attack"].label, ylabel=CHANNELS["climb_distance"].label, yscale="log")
        axes.legend()

    title = f"{dataset.attrs['title']}; Nadal's limit: Y/Q = {dataset['nadal_limit'].values[0]:.3f}"
    return panels(title, [draw], 110.0)
