"""Pictures of wheels that wear in service: profiles, depths, flange and conicity against the mileage."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from wrsim.plots.colours import GROUP_LINE, INK, SERIES_COLOURS
from wrsim.plots.marks import panels
from wrsim.plots.style import save

MOST_LINES = 7
"""Profiles that are drawn, the first and the last among them."""
BESIDE = 3.0
"""Room beside what is worn [mm]."""
SEEN = 0.02
"""Part of the largest depth from which on a place counts as worn."""


def service_pictures(dataset: xr.Dataset, directory: Path) -> list[Path]:
    """Write ``wear_profiles.png`` and ``wear_mileage.png``; returns their paths."""
    return [save(make(dataset), directory / f"{name}.png") for name, make in FIGURES.items()]


def profiles_figure(dataset: xr.Dataset) -> Figure:
    """Profiles and depths at some mileages."""
    count = dataset.sizes["point"]
    chosen = np.unique(np.linspace(0, count - 1, min(count, MOST_LINES)).round().astype(int))
    mileage, unworn = 1e-3 * dataset["mileage"].values, 1e3 * dataset["unworn_u"].values
    u, w, depth = (1e3 * dataset[name].values for name in ("u", "w", "depth"))
    deepest = depth.max(axis=0)
    worn = unworn[deepest > SEEN * deepest.max()] if deepest.max() > 0.0 else unworn
    low, high = worn.min() - BESIDE, worn.max() + BESIDE
    heights = w[:, (u[0] >= low) & (u[0] <= high)]

    def draw(axes: Axes, x: NDArray[np.float64], y: NDArray[np.float64], label: str, ylim: Any) -> None:
        colours = mpl.colormaps["viridis_r"](np.linspace(0.1, 1.0, chosen.size))
        for i, colour in zip(chosen, colours, strict=True):
            axes.plot(x[i], y[i], color=colour, label=f"{mileage[i]:.4g} km", linewidth=0.9)
        axes.set(xlim=(low, high), ylim=ylim, ylabel=label, xlabel="Position on the wheel profile $u_w$ [mm]")

    draws = [
        partial(draw, x=u, y=w, label="Wheel profile [mm]", ylim=(heights.min() - 1.0, heights.max() + 1.0)),
        partial(draw, x=np.tile(unworn, (count, 1)), y=depth, label="Depth worn off [mm]", ylim=(0.0, None)),
    ]
    return panels(dataset.attrs["title"], draws, 120.0, legend=None, across=MOST_LINES)


LEAST_CHANGE = 0.05
"""Change of the flange that is drawn at least [mm]: below it lies the round-off of the profile's nodes."""


def mileage_figure(dataset: xr.Dataset) -> Figure:
    """Changes of the flange's dimensions, conicity, largest depth and mass lost against the mileage."""
    return panels(dataset.attrs["title"], [partial(_mileage, dataset, key) for key in MILEAGE], 115.0, columns=2)


MILEAGE = {
    "flange": "Flange against the new one [mm]",
    "conicity": "Equivalent conicity",
    "deepest": "Largest depth [mm]",
    "mass": "Mass lost [g/km]",
}
"""Panels against the mileage."""


def _mileage(dataset: xr.Dataset, key: str, axes: Axes) -> None:
    """One of ``MILEAGE``."""
    x = 1e-3 * dataset["mileage"].values
    line: Any = {"marker": "o", "markersize": 2.2, "linewidth": 0.9}
    axes.set(xlabel="Mileage [km]", ylabel=MILEAGE[key])
    if key == "flange":
        sizes = (("thickness", "Sd"), ("height", "Sh"), ("steepness", "qR"))
        for colour, dashes, (name, short) in zip(SERIES_COLOURS, GROUP_LINE, sizes, strict=False):
            values = 1e3 * dataset[f"flange_{name}"].values
            if np.isfinite(values).any():
                label = f"{short} - {values[0]:.2f}"
                axes.plot(x, values - values[0], color=colour, label=label, linestyle=dashes, **line)
        if axes.lines:
            low, high = axes.get_ylim()
            axes.set_ylim(min(low, -LEAST_CHANGE), max(high, LEAST_CHANGE))
            axes.legend()
    elif key == "mass":
        for colour, zone in zip(SERIES_COLOURS, ("tread", "flange"), strict=False):
            values = 1e6 * dataset[zone].values
            values[-1:] = values[-2:-1]  # of the last step
            axes.step(x, values, where="post", color=colour, label=zone, linewidth=0.9)
        axes.set_ylim(bottom=0.0)
        axes.legend()
    else:
        values = dataset[key].values * (1e3 if key == "deepest" else 1.0)
        axes.plot(x, values, color=INK, **line)
        if key == "conicity":
            axes.set_ylim(0.0, 1.15 * float(np.nanmax(values, initial=0.1)))
            axes.set_ylabel(f"{MILEAGE[key]}, {1e3 * dataset.attrs['conicity_amplitude_m']:g} mm")


FIGURES = {"wear_profiles": profiles_figure, "wear_mileage": mileage_figure}
"""Pictures of a service, by file name without ending."""
