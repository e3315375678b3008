"""Pictures of a ride: power spectral densities and third-octaves of accelerations, one panel an axis."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim.plots.marks import panels
from wrsim.plots.theme import GROUP_LINE, GROUP_MARK, SERIES_COLOURS
from wrsim.results.ride import Ride

DIRECTIONS = {"x": "longitudinal", "y": "lateral", "z": "vertical"}
LOWEST = 0.3  # least frequency drawn [Hz]
TICKS = (0.5, 1, 2, 5, 10, 20, 50, 100, 200)
DECADES, BAND_DECADES = 6, 4
"""Decades beneath the highest density that are drawn; of third-octaves, whose rms is a root of density."""

Rides = Mapping[str, Ride]
"""By the names of their runs."""


def ride_figures(found: Ride) -> dict[str, Callable[[], Figure]]:
    """Makers of the pictures of a ride, by file name without ending."""
    draws = {"ride_spectra": density} | ({"ride_bands": bands} if found.data.sizes["band"] else {})
    return {name: partial(ride_figure, {"": found}, draw) for name, draw in draws.items()}


def ride_figure(rides: Rides, draw: Callable[[Rides, str, Axes], object]) -> Figure:
    """``density`` or ``bands`` of all directions against frequency."""
    titles = "\n".join(dict.fromkeys(f"{one.title}: {one.stretch}" for one in rides.values()))
    figure = panels(titles, [partial(draw, rides, axis) for axis in DIRECTIONS], 150.0, legend=None, across=5)
    lowest = figure.axes[-1]
    low, high = lowest.get_xlim()
    ticks = [f for f in TICKS if low <= f <= high]
    lowest.set_xticks(ticks, [f"{f:g}" for f in ticks])
    lowest.set_xlabel("Frequency [Hz]")
    return figure


def density(found: Rides, axis: str, axes: Axes) -> None:
    """Power spectral density of one direction at every point."""
    axes.set_ylabel(f"{DIRECTIONS[axis].capitalize()} density\n[(m/s²)²/Hz]")
    _spectra(axes, found, axis, ("frequency", "density"), LOWEST, DECADES)


def bands(found: Rides, axis: str, axes: Axes) -> None:
    """rms of one direction in third-octaves at every point."""
    axes.set_ylabel(f"{DIRECTIONS[axis].capitalize()} rms\n[m/s²] in 1/3 octave")
    _spectra(axes, found, axis, ("band", "band_rms"), 0.0, BAND_DECADES, markersize=2.4)


def _spectra(
    axes: Axes, found: Rides, axis: str, names: tuple[str, str], lowest: float, decades: int, markersize: float = 0.0
) -> None:
    """A line a point on logarithmic scales; with marks, if they have a size."""
    highest = 0.0
    lines = [(name, point, one.data) for name, one in found.items() for point in one.points]
    for i, (name, point, data) in enumerate(lines):
        x = data[names[0]].values
        values = np.maximum(data[names[1]].sel(point=point, axis=axis).values[x >= lowest], 1e-300)
        highest = max(highest, float(values.max(initial=0.0)))
        colour, line = SERIES_COLOURS[i % len(SERIES_COLOURS)], GROUP_LINE[i // len(SERIES_COLOURS) % len(GROUP_LINE)]
        label = f"{name}: {point}" if len(found) > 1 else point
        (drawn,) = axes.loglog(x[x >= lowest], values, color=colour, linestyle=line, linewidth=0.8, label=label)
        drawn.set(marker=GROUP_MARK[i % len(GROUP_MARK)], markersize=markersize)
    if highest > 1e-300:
        axes.set_ylim(highest * 10.0**-decades, highest * 3.0)
