"""Pictures of a ride: power spectral densities and third-octaves of accelerations, one panel an axis."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim.plots.colours import GROUP_LINE, GROUP_MARK
from wrsim.plots.style import FULL_WIDTH, new_figure, save, style
from wrsim.results.ride import Ride

POINT_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Okabe and Ito's set, in the order of the points."""
DIRECTIONS = {"x": "longitudinal", "y": "lateral", "z": "vertical"}
LOWEST = 0.3
"""Least frequency drawn [Hz]."""
TICKS = (0.5, 1, 2, 5, 10, 20, 50, 100, 200)
DECADES = 6
"""Decades of density beneath the highest that are drawn."""
BAND_DECADES = 4
"""The same for third-octaves, whose rms is a root of density."""


def ride_pictures(found: Ride, directory: str | Path) -> list[Path]:
    """Write ``ride_spectra.png`` and ``ride_bands.png``; returns their paths."""
    directory = Path(directory)
    files = [save(ride_figure(found, density), directory / "ride_spectra.png")]
    if found.data.sizes["band"]:
        files.append(save(ride_figure(found, bands), directory / "ride_bands.png"))
    return files


def ride_figure(found: Ride, draw: Callable[[Axes, Ride, str], Axes]) -> Figure:
    """``density`` or ``bands`` of all directions against frequency."""
    with style():
        figure = new_figure(FULL_WIDTH, 150.0)
        rows = figure.subplots(3, 1, sharex=True)
        for axes, axis in zip(rows, DIRECTIONS, strict=True):
            draw(axes, found, axis)
        low, high = rows[-1].get_xlim()
        ticks = [f for f in TICKS if low <= f <= high]
        rows[-1].set_xticks(ticks, [f"{f:g}" for f in ticks])
        rows[-1].set_xlabel("Frequency [Hz]")
        figure.suptitle(f"{found.title}: {found.start:z.0f} to {found.end:.0f} m", x=0.01, ha="left", fontsize=8.5)
        handles, labels = rows[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(5, len(labels)))
        figure.align_ylabels(list(rows))
    return figure


def density(axes: Axes, found: Ride, axis: str) -> Axes:
    """Power spectral density of one direction at every point."""
    frequency = found.data["frequency"].values
    shown = frequency >= LOWEST
    highest = 0.0
    for i, point in enumerate(found.points):
        values = found.data["density"].sel(point=point, axis=axis).values[shown]
        highest = max(highest, float(values.max(initial=0.0)))
        colour, line = POINT_COLOURS[i % len(POINT_COLOURS)], GROUP_LINE[i // len(POINT_COLOURS) % len(GROUP_LINE)]
        values = np.maximum(values, 1e-300)
        axes.loglog(frequency[shown], values, color=colour, linestyle=line, linewidth=0.8, label=point)
    if highest > 0.0:
        axes.set_ylim(highest * 10.0**-DECADES, highest * 3.0)
    axes.set_ylabel(f"{DIRECTIONS[axis].capitalize()} density\n[(m/s²)²/Hz]")
    return axes


def bands(axes: Axes, found: Ride, axis: str) -> Axes:
    """rms of one direction in third-octaves at every point."""
    middle = found.data["band"].values
    for i, point in enumerate(found.points):
        values = found.data["band_rms"].sel(point=point, axis=axis).values
        colour = POINT_COLOURS[i % len(POINT_COLOURS)]
        marker = GROUP_MARK[i % len(GROUP_MARK)]
        values = np.maximum(values, 1e-300)
        axes.loglog(middle, values, color=colour, marker=marker, markersize=2.4, linewidth=0.8, label=point)
    highest = float(found.data["band_rms"].sel(axis=axis).max())
    if highest > 0.0:
        axes.set_ylim(highest * 10.0**-BAND_DECADES, highest * 2.0)
    axes.set_ylabel(f"{DIRECTIONS[axis].capitalize()} rms\n[m/s²] in 1/3 octave")
    return axes
