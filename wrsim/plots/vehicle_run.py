"""Histories of a vehicle: guiding forces, steering and loads of its wheelsets, motion of its bodies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wrsim.plots.colours import GROUP_LINE, INK
from wrsim.plots.histories import crowded, history, stacked
from wrsim.plots.marks import draw_line, wheel_entries
from wrsim.plots.style import abscissa, shown
from wrsim.results import CHANNELS
from wrsim.results.table import with_unit
from wrsim.results.wheelsets import numbered, of_wheelset, wheelsets

COLOURS = (INK, "#0072B2", "#D55E00", "#009E73", "#9467A9", "#B8860B")
"""Colours of wheelsets, bodies and points, in their order."""


PICTURES = {
    "vehicle_guiding": ("wheelset", "Y"),
    "vehicle_shifting": ("wheelset", "sum_Y"),
    "vehicle_loads": ("wheelset", "Q"),
    "vehicle_derailment": ("wheelset", "Y_over_Q"),
    "vehicle_steering": ("wheelset", "lateral_shift yaw"),
    "vehicle_bodies": ("body", "body_roll body_yaw body_vertical"),
    "vehicle_accelerations": ("point", "point_ay point_az"),
    "vehicle_couplings": (
        "coupling",
        "coupling_force coupling_fy_ahead coupling_fy_behind coupling_offset coupling_yaw",
    ),
    "vehicle_external_loads": ("external_load", "external_fx external_fy external_fz"),
}
"""Dimension and channels of every picture, by file name without ending."""


def vehicle_figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Makers of the ``PICTURES`` of a run of which there are data; those of wheelsets where there are several."""
    figures: dict[str, Callable[[], Figure]] = {}
    if dataset.sizes.get("time", 0) < 2 or "resolved_with" in dataset.attrs:
        return figures
    for picture, (dim, words) in PICTURES.items():
        if not (len(wheelsets(dataset)) > 1 if dim == "wheelset" else dim in dataset.dims):
            continue
        names = [name for name in words.split() if name in dataset]
        if names and "wheel" in dataset[names[0]].dims:
            figures[picture] = partial(wheelsets_figure, dataset, names[0])
        elif names:
            figures[picture] = partial(together_figure, dataset, dim, names)
    return figures


def wheelsets_figure(dataset: xr.Dataset, name: str) -> Figure:
    """A channel of the wheels, a panel for each wheelset against its own distance, on one scale."""
    values, channel, names = shown(dataset, name), CHANNELS[name], numbered(wheelsets(dataset))
    low, high = (float(f(values, initial=0.0)) for f in (np.nanmin, np.nanmax))
    space = 0.05 * max(high - low, 1e-9)
    label = with_unit(f"${channel.symbol}$", channel.shown.symbol)

    def panel(axes: Axes, _: xr.Dataset, wheelset: str) -> None:
        history(axes, of_wheelset(dataset, wheelset), name, largest=max(-low, high))
        limited = any(line.get_gid() == "limit" for line in axes.lines)
        top = max(axes.get_ylim()[1], high + space) if limited else high + space
        axes.set(ylim=(low - space, top), title=names[wheelset], ylabel=label)
        return

    panels = [partial(panel, wheelset=wheelset) for wheelset in names]
    track = _track_of(dataset)
    track.attrs["title"] += f": {channel.long_name}"
    return stacked(track, panels, panel_height_mm=28.0, legend=wheel_entries(), titled=True)


def together_figure(dataset: xr.Dataset, dim: str, channels: Sequence[str]) -> Figure:
    """Channels of wheelsets, bodies or points, a panel each, and a line for each of them, the smallest in front."""
    looks: list[dict[str, Any]] = [
        {"color": COLOURS[i % len(COLOURS)], "linestyle": GROUP_LINE[i % len(GROUP_LINE)]}
        for i in range(dataset.sizes[dim])
    ]

    def panel(axes: Axes, _: xr.Dataset, name: str) -> None:
        x, _name = abscissa(dataset)
        values = shown(dataset, name)
        for i in np.argsort(-np.ptp(values, axis=0), kind="stable"):  # small ones last, or large ones hide them
            at = dataset["wheelset_distance"].values[:, i] if dim == "wheelset" else x
            draw_line(axes, at, values[:, i], **(looks[i] | crowded(values[:, i])))
        axes.set_ylabel(CHANNELS[name].label.replace(" of the body", "").replace(" [", "\n["))
        return

    names = [str(n) for n in dataset[dim].values]
    labels = numbered(names).values() if dim == "wheelset" else names
    legend = [Line2D([], [], label=label, **look) for label, look in zip(labels, looks, strict=True)]
    panels = [partial(panel, name=name) for name in channels]
    return stacked(_track_of(dataset), panels, legend=legend)


def _track_of(dataset: xr.Dataset) -> xr.Dataset:
    """The first wheelset's dataset for the track beneath the panels, without moments, under the vehicle's title."""
    first = of_wheelset(dataset, wheelsets(dataset)[0]).drop_dims("snapshot", errors="ignore")
    return first.assign_attrs(title=dataset.attrs["title"])
