"""Unloading of wheels over the speed, and limits of the speed over the wind."""

from collections.abc import Callable
from functools import partial
from itertools import cycle
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim.plots.marks import panels
from wrsim.plots.theme import QUIET, SERIES_COLOURS
from wrsim.results import CHANNELS
from wrsim.results.overturning import UNLOADING, summarise_overturning


def overturning_figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Makers of the pictures, by file name without ending; that over the wind where there are several winds."""
    several = np.unique(dataset["wind_speed"].values).size > 1
    makers: dict[str, Callable[[], Figure]] = {"overturning": partial(unloading_over_speed, dataset)}
    return makers | ({"overturning_wind": partial(over_wind, dataset)} if several else {})


def unloading_over_speed(dataset: xr.Dataset) -> Figure:
    """Unloading of the most unloaded wheel over the speed, a line a wind."""
    speed, wind = 3.6 * dataset["pose_speed"].values, dataset["wind_speed"].values
    largest = dataset["wheel_unloading"].max(["wheel", "wheelset"]).values

    def draw(axes: Axes) -> None:
        for value, colour in zip(np.unique(wind), cycle(SERIES_COLOURS)):
            axes.plot(speed[wind == value], largest[wind == value], color=colour, label=f"wind {value:g} m/s")
        axes.axhline(UNLOADING, color=QUIET, linewidth=0.7, linestyle="--")
        axes.set(xlabel=CHANNELS["pose_speed"].label, ylabel=CHANNELS["wheel_unloading"].label)
        axes.legend()

    return panels(str(dataset.attrs["title"]), [draw], 110.0)


def over_wind(dataset: xr.Dataset) -> Figure:
    """Limits of the speed over the wind."""
    limits = summarise_overturning(dataset)["limits"]
    labels = {"unloaded_kmh": f"unloading {UNLOADING:g}", "lifts_kmh": "a wheel lifts", "overturns_kmh": "overturns"}

    def draw(axes: Axes) -> None:
        for (key, label), colour in zip(labels.items(), cycle(SERIES_COLOURS)):
            points: list[Any] = [(limit["wind_m_s"], limit[key]) for limit in limits if limit[key] is not None]
            if points:
                axes.plot(*zip(*points, strict=True), "o-", color=colour, markersize=3, label=label)
        axes.set(xlabel=CHANNELS["wind_speed"].label, ylabel=CHANNELS["pose_speed"].label)
        axes.legend()

    return panels(str(dataset.attrs["title"]), [draw], 110.0)
