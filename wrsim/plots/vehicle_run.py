"""Histories of a vehicle: guiding forces, steering and loads of its wheelsets, motion of its bodies."""

from __future__ import annotations

from collections.abc import Callable
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
from wrsim.results.wheelsets import numbered, of_wheelset, wheelsets

COLOURS = (INK, "#0072B2", "#D55E00", "#009E73", "#9467A9", "#B8860B")
"""Colours of wheelsets, bodies and points, in their order."""


def vehicle_figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Makers of the pictures of a vehicle's run, by file name without ending.

    Of several wheelsets: guiding, shifting, loads, derailment, steering; of bodies, points, couplings and loads:
    bodies, accelerations, couplings, external_loads.
    """
    figures: dict[str, Callable[[], Figure]] = {}
    if dataset.sizes.get("time", 0) < 2 or "resolved_with" in dataset.attrs:
        return figures
    if len(wheelsets(dataset)) > 1:
        figures = {
            "vehicle_guiding": lambda: wheelsets_figure(dataset, "Y"),
            "vehicle_shifting": lambda: together_figure(dataset, "wheelset", ("sum_Y",)),
            "vehicle_loads": lambda: wheelsets_figure(dataset, "Q"),
            "vehicle_derailment": lambda: wheelsets_figure(dataset, "Y_over_Q"),
            "vehicle_steering": lambda: together_figure(dataset, "wheelset", ("lateral_shift", "yaw")),
        }
    if "sum_Y" not in dataset:  # of a result from before there was this channel
        figures.pop("vehicle_shifting", None)
    if "body" in dataset.dims:
        figures["vehicle_bodies"] = lambda: together_figure(dataset, "body", ("body_roll", "body_yaw", "body_vertical"))
    if "point" in dataset.dims:
        figures["vehicle_accelerations"] = lambda: together_figure(dataset, "point", ("point_ay", "point_az"))
    if "coupling" in dataset.dims:
        of_couplings = ("coupling_force", "coupling_fy_ahead", "coupling_fy_behind", "coupling_offset", "coupling_yaw")
        figures["vehicle_couplings"] = lambda: together_figure(dataset, "coupling", of_couplings)
    if "external_load" in dataset.dims:
        forces = ("external_fx", "external_fy", "external_fz")
        figures["vehicle_external_loads"] = lambda: together_figure(dataset, "external_load", forces)
    return figures


def wheelsets_figure(dataset: xr.Dataset, name: str) -> Figure:
    """A channel of the wheels, a panel for each wheelset against its own distance, on one scale."""
    values, channel, names = shown(dataset, name), CHANNELS[name], numbered(wheelsets(dataset))
    low, high = (float(f(values, initial=0.0)) for f in (np.nanmin, np.nanmax))
    space = 0.05 * max(high - low, 1e-9)
    unit = "" if channel.shown.symbol == "1" else f" [{channel.shown.symbol}]"

    def panel(axes: Axes, _: xr.Dataset, wheelset: str) -> Axes:
        history(axes, of_wheelset(dataset, wheelset), name, largest=max(-low, high))
        limited = any(line.get_gid() == "limit" for line in axes.lines)
        top = max(axes.get_ylim()[1], high + space) if limited else high + space
        axes.set(ylim=(low - space, top), title=names[wheelset], ylabel=f"${channel.symbol}${unit}")
        return axes

    panels = [partial(panel, wheelset=wheelset) for wheelset in names]
    track = _track_of(dataset)
    track.attrs["title"] += f": {channel.long_name}"
    return stacked(track, panels, panel_height_mm=28.0, legend=wheel_entries(), titled=True)


def together_figure(dataset: xr.Dataset, dim: str, channels: tuple[str, ...]) -> Figure:
    """Channels of wheelsets, bodies or points, a panel each, and a line for each of them, the smallest in front."""
    looks: list[dict[str, Any]] = [
        {"color": COLOURS[i % len(COLOURS)], "linestyle": GROUP_LINE[i % len(GROUP_LINE)]}
        for i in range(dataset.sizes[dim])
    ]

    def panel(axes: Axes, _: xr.Dataset, name: str) -> Axes:
        x, _name = abscissa(dataset)
        values = shown(dataset, name)
        for i in np.argsort(-np.ptp(values, axis=0), kind="stable"):  # small ones last, or large ones hide them
            at = dataset["wheelset_distance"].values[:, i] if dim == "wheelset" else x
            draw_line(axes, at, values[:, i], **(looks[i] | crowded(values[:, i])))
        axes.set_ylabel(CHANNELS[name].label.replace(" of the body", "").replace(" [", "\n["))
        return axes

    names = [str(n) for n in dataset[dim].values]
    labels = numbered(names).values() if dim == "wheelset" else names
    legend = [Line2D([], [], label=label, **look) for label, look in zip(labels, looks, strict=True)]
    panels = [partial(panel, name=name) for name in channels if name in dataset]
    return stacked(_track_of(dataset), panels, legend=legend)


def _track_of(dataset: xr.Dataset) -> xr.Dataset:
    """The first wheelset's dataset for the track beneath the panels, without moments, under the vehicle's title."""
    first = of_wheelset(dataset, wheelsets(dataset)[0]).drop_dims("snapshot", errors="ignore")
    return first.assign_attrs(title=dataset.attrs["title"])
