"""Quasi-static forces and poses of every wheelset over the curves of a steady analysis."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wrsim.plots.colours import GROUP_LINE, QUIET, SERIES_COLOURS, STOP_COLOUR
from wrsim.plots.style import FULL_WIDTH, headline, new_figure, shown, style
from wrsim.results import CHANNELS

PANELS = ("lateral_shift", "yaw", "Y", "Q", "Y_over_Q", "T_gamma")
FEW = 1.25
"""Largest over smallest size of a radius from which curvature is the abscissa."""
LINES = GROUP_LINE[:4]


def figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Maker of the picture of a steady analysis, by file name without ending."""
    return {"steady": lambda: steady_figure(dataset)}


def steady_figure(dataset: xr.Dataset) -> Figure:
    """Shift, angle of attack, Y, Q, Y/Q and wear number; of the wheels the outer one of each wheelset.

    Over curvature, or over cant deficiency where the curves are alike; a line a wheelset, a dash pattern a series of
    curves with one cant and speed (or one radius and cant).
    """
    radius = dataset["pose_radius"].values
    sizes = np.abs(radius)
    by_curvature = sizes.max() > FEW * sizes.min() or np.unique(np.sign(radius)).size > 1
    if by_curvature:
        x, label = 1e3 / radius, "Curvature [1/km]"
        series = np.stack([dataset["pose_cant"].values, dataset["pose_speed"].values], axis=1)
    else:
        x, label = shown(dataset, "cant_deficiency"), CHANNELS["cant_deficiency"].label
        series = np.stack([dataset["pose_cant"].values, radius], axis=1)
    found, which = np.unique(series.round(9), axis=0, return_inverse=True)
    which = which.ravel()
    messages = dataset["pose_message"].values
    failed = np.flatnonzero(messages != "")
    with style():
        figure = new_figure(FULL_WIDTH, 150.0)
        note = f"{failed.size} of {messages.size} curves have no steady motion" if failed.size else ""
        axes = [figure.add_subplot(ceil(len(PANELS) / 2), 2, i + 1) for i in range(len(PANELS))]
        for one, name in zip(axes, PANELS, strict=True):
            _panel(one, dataset, name, x, which, len(found))
            one.set_xlabel(label)
            for i in failed:
                one.axvline(x[i], color=STOP_COLOUR, linewidth=0.5, linestyle=(0, (1, 2)))
        handles, labels = axes[0].get_legend_handles_labels()
        if len(found) > 1:
            second = "km/h" if by_curvature else "m"
            for k, (cant, other) in enumerate(found):
                other *= 3.6 if by_curvature else 1.0
                handles.append(Line2D([], [], color=QUIET, linewidth=0.9, linestyle=LINES[k % len(LINES)]))
                labels.append(f"{1e3 * cant:.4g} mm, {other:.5g} {second}")
        figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=6.5)
        figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 0.94))  # type: ignore[union-attr, call-arg]
        headline(figure, str(dataset.attrs["title"]), note)
    return figure


def _panel(axes: Axes, dataset: xr.Dataset, name: str, x: np.ndarray, which: np.ndarray, count: int) -> None:
    """One channel of every wheelset."""
    values = shown(dataset, name)
    if values.ndim == 3:  # the outer wheel: the right one in curves to the left
        outer = (dataset["pose_radius"].values > 0.0).astype(int)
        values = np.take_along_axis(values, outer[:, None, None], axis=2)[..., 0]
    for w, wheelset in enumerate(dataset["wheelset"].values):
        for k in range(count):
            own = np.flatnonzero(which == k)
            own = own[np.argsort(x[own])]
            colour, line = SERIES_COLOURS[w % len(SERIES_COLOURS)], LINES[k % len(LINES)]
            look: Any = {"color": colour, "linestyle": line, "marker": "o", "markersize": 2.2, "linewidth": 0.9}
            axes.plot(x[own], values[own, w], label=str(wheelset) if k == 0 else None, **look)
    if name != "Q":
        axes.axhline(0.0, color=QUIET, linewidth=0.5)
    channel = CHANNELS[name]
    unit = f" [{channel.shown.symbol}]" if channel.shown.suffix else ""
    axes.set_ylabel(channel.label if dataset[name].ndim == 2 else f"Outer wheel: ${channel.symbol}${unit}")
