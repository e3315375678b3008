"""Pictures of a ride: power spectral densities and third-octaves of accelerations, one panel an axis."""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim.plots.marks import panels
from wrsim.plots.theme import GROUP_LINE, GROUP_MARK, SERIES_COLOURS
from wrsim.results.moments import Array
from wrsim.results.ride import Ride

DIRECTIONS = {"x": "longitudinal", "y": "lateral", "z": "vertical"}
TICKS = (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)
PICTURES = {
    "ride_spectra": ("frequency", "density", "density\n[(m/s²)²/Hz]", 0.3, 6, 0.0),
    "ride_bands": ("band", "band_rms", "rms\n[m/s²] in 1/3 octave", 0.0, 4, 2.4),
}
"""Variables, label, least frequency drawn [Hz], decades drawn beneath the highest value, size of the marks; the rms of
third-octaves is a root of density."""

Rides = Mapping[str, Ride]
"""By the names of their runs."""


def ride_figures(ride: Ride) -> dict[str, Callable[[], Figure]]:
    """Makers of the pictures of a ride, by file name without ending."""
    drawn = (name for name, (across, *_) in PICTURES.items() if ride.data.sizes[across])
    return {name: partial(ride_figure, {"": ride}, name) for name in drawn}


def ride_figure(rides: Rides, picture: str) -> Figure:
    """One of ``PICTURES``: all directions against frequency."""
    titles = "\n".join(dict.fromkeys(f"{ride.title}: {ride.stretch}" for ride in rides.values()))
    draws = [partial(ride_spectra, rides=rides, axis=axis, picture=picture) for axis in DIRECTIONS]
    figure = panels(titles, draws, 150.0, legend=None, across=5)
    frequency_ticks(figure.axes[-1])
    return figure


def frequency_ticks(axes: Axes, upright: bool = False) -> None:
    """Plain numbers at an axis of frequencies, across or upright."""
    low, high = axes.get_ylim() if upright else axes.get_xlim()
    ticks = [f for f in TICKS if low <= f <= high]
    axis = axes.yaxis if upright else axes.xaxis
    axis.set_ticks(ticks, [f"{f:g}" for f in ticks])
    axis.set_minor_formatter("")
    axis.set_label_text("Frequency [Hz]")


def ride_spectra(axes: Axes, rides: Rides, axis: str, picture: str) -> None:
    """One of ``PICTURES`` in one direction: a line a point on logarithmic scales; with marks, if they have a size."""
    across, name, label, lowest, decades, markersize = PICTURES[picture]
    axes.set_ylabel(f"{DIRECTIONS[axis].capitalize()} {label}")
    lines = {
        f"{run}: {point}" if len(rides) > 1 else point: (
            data[across].values,
            data[name].sel(point=point, axis=axis).values,
        )
        for run, ride in rides.items()
        for point, data in ((point, ride.data) for point in ride.points)
    }
    over_frequency(axes, lines, lowest, decades, markersize)


def over_frequency(
    axes: Axes, lines: Mapping[str, tuple[Array, Array]], lowest: float, decades: float, markersize: float
) -> None:
    """Values over the frequency by names, on logarithmic scales; the rest as of ``PICTURES``."""
    highest = 0.0
    for i, (label, (x, values)) in enumerate(lines.items()):
        values = np.maximum(values[x >= lowest], 1e-300)
        highest = max(highest, float(values.max(initial=0.0)))
        colour, line = SERIES_COLOURS[i % len(SERIES_COLOURS)], GROUP_LINE[i // len(SERIES_COLOURS) % len(GROUP_LINE)]
        (drawn,) = axes.loglog(x[x >= lowest], values, color=colour, linestyle=line, linewidth=0.8, label=label)
        drawn.set(marker=GROUP_MARK[i % len(GROUP_MARK)], markersize=markersize)
    if highest > 1e-300:
        axes.set_ylim(highest * 10.0**-decades, highest * 3.0)
