"""Unloading of wheels over the speed, and limits of the speed over the wind."""

from __future__ import annotations

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
    """Makers of the pictures, by file name without ending."""
    return {"overturning": partial(overturning_figure, dataset)}


def overturning_figure(dataset: xr.Dataset) -> Figure:
    """The most unloaded wheel over the speed, a line a wind; limits of the speed over the wind where there are some."""
    speed, wind = 3.6 * dataset["pose_speed"].values, dataset["wind_speed"].values
    largest = dataset["wheel_unloading"].max(["wheel", "wheelset"]).values
    limits = summarise_overturning(dataset)["limits"]

    def over_speed(axes: Axes) -> None:
        for value, colour in zip(np.unique(wind), cycle(SERIES_COLOURS)):
            own = wind == value
            axes.plot(speed[own], largest[own], color=colour, label=f"wind {value:g} m/s" if len(limits) > 1 else None)
        axes.axhline(UNLOADING, color=QUIET, linewidth=0.7, linestyle="--")
        axes.set(xlabel=CHANNELS["pose_speed"].label, ylabel=CHANNELS["wheel_unloading"].label)
        if len(limits) > 1:
            axes.legend()

    def over_wind(axes: Axes) -> None:
        words = {"unloaded_kmh": f"unloading {UNLOADING:g}", "lifts_kmh": "a wheel lifts", "overturns_kmh": "overturns"}
        for (key, label), colour in zip(words.items(), cycle(SERIES_COLOURS)):
            points: list[Any] = [(own["wind_m_s"], own[key]) for own in limits if own[key] is not None]
            if points:
                axes.plot(*zip(*points, strict=True), "o-", color=colour, markersize=3, label=label)
        axes.set(xlabel=CHANNELS["wind_speed"].label, ylabel=CHANNELS["pose_speed"].label)
        axes.legend()

    draws = [over_speed, over_wind] if len(limits) > 1 else [over_speed]
    return panels(str(dataset.attrs["title"]), draws, 110.0 if len(draws) == 1 else 150.0, columns=len(draws))
