"""Quasi-static forces and poses of every wheelset over the curves of a steady analysis."""

from collections.abc import Callable
from functools import partial
from itertools import cycle
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wrsim.plots.marks import panels
from wrsim.plots.theme import DOTS, GROUP_LINE, QUIET, SERIES_COLOURS, STOP_COLOUR, shown
from wrsim.results import CHANNELS
from wrsim.results.table import quantity

PANELS = ("lateral_shift", "yaw", "Y", "Q", "Y_over_Q", "T_gamma")
FEW = 1.25  # largest over smallest size of a radius from which curvature is the abscissa
LINES = GROUP_LINE[:4]


def steady_figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Maker of the picture of a steady analysis, by file name without ending."""
    return {"steady": partial(steady_figure, dataset)}


def steady_figure(dataset: xr.Dataset) -> Figure:
    """Shift, angle of attack, Y, Q, Y/Q and wear number, of outer wheels. Over curvature, or cant deficiency of curves
    alike; a line a wheelset, a dash pattern a series of curves with one cant and speed (or radius and cant)."""
    radius = dataset["pose_radius"].values
    sizes = np.abs(radius)
    by_curvature = sizes.max() > FEW * sizes.min() or np.unique(np.sign(radius)).size > 1
    if by_curvature:
        x, label = 1e3 / radius, "Curvature [1/km]"
        series = np.stack([dataset["pose_cant"].values, dataset["pose_speed"].values], axis=1)
    else:
        x, label = shown(dataset, "cant_deficiency"), CHANNELS["cant_deficiency"].label
        series = np.stack([dataset["pose_cant"].values, radius], axis=1)
    kinds, kind_index = np.unique(series.round(9), axis=0, return_inverse=True)
    failed = dataset["pose_message"].values != ""
    names = map(str, dataset["wheelset"].values)
    entries = [Line2D([], [], color=c, marker="o", label=name) for name, c in zip(names, cycle(SERIES_COLOURS))]
    factor, unit = (3.6, "km/h") if by_curvature else (1.0, "m")
    for (cant, parameter), line in zip(kinds.tolist() if len(kinds) > 1 else (), cycle(LINES)):
        entry = f"{quantity(1e3 * cant, 'mm')}, {quantity(factor * parameter, unit, '.5g')}"
        entries.append(Line2D([], [], color=QUIET, linewidth=0.9, linestyle=line, label=entry))

    members = [np.flatnonzero(kind_index.ravel() == k) for k in range(len(kinds))]
    lines = [(points[np.argsort(x[points])], line) for points, line in zip(members, cycle(LINES))]
    outer = (radius > 0.0).astype(int)  # the right wheel in curves to the left

    def draw(axes: Axes, name: str) -> None:
        values, channel = shown(dataset, name), CHANNELS[name]
        if of_wheels := values.ndim == 3:
            values = np.take_along_axis(values, outer[:, None, None], axis=2)[..., 0]
        for points, line in lines:
            look: Any = {"linestyle": line, "marker": "o", "markersize": 2.2, "linewidth": 0.9}
            for of_wheelset, colour in zip(values[points].T, cycle(SERIES_COLOURS)):
                axes.plot(x[points], of_wheelset, color=colour, **look)
        if name != "Q":
            axes.axhline(0.0, color=QUIET, linewidth=0.5)
        axes.set(xlabel=label, ylabel=f"Outer wheel: {channel.short_label}" if of_wheels else channel.label)
        for curve in x[failed]:
            axes.axvline(curve, color=STOP_COLOUR, linewidth=0.5, linestyle=DOTS)

    note = f"{failed.sum()} of {failed.size} curves have no steady motion" if failed.any() else ""
    draws = [partial(draw, name=name) for name in PANELS]
    return panels(str(dataset.attrs["title"]), draws, 150.0, columns=2, legend=entries, note=note)
