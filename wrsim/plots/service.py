"""Pictures of wheels that wear in service: profiles, depths, flange and conicity against the mileage."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from wrsim.plots.colours import GROUP_LINE, INK, SERIES_COLOURS
from wrsim.plots.style import FULL_WIDTH, new_figure, save, style

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
    mileage = 1e-3 * dataset["mileage"].values
    with style():
        figure = new_figure(FULL_WIDTH, 120.0)
        top, bottom = figure.subplots(2, 1, sharex=True)
        colours = mpl.colormaps["viridis_r"](np.linspace(0.1, 1.0, chosen.size))
        for i, colour in zip(chosen, colours, strict=True):
            look = {"color": colour, "label": f"{mileage[i]:.4g} km", "linewidth": 0.9}
            top.plot(1e3 * dataset["u"].values[i], 1e3 * dataset["w"].values[i], **look)
            bottom.plot(1e3 * dataset["unworn_u"].values, 1e3 * dataset["depth"].values[i], **look)
        depth, u = dataset["depth"].values.max(axis=0), 1e3 * dataset["unworn_u"].values
        worn = u[depth > SEEN * depth.max()] if depth.max() > 0.0 else u
        bottom.set_xlim(worn.min() - BESIDE, worn.max() + BESIDE)
        top.set_ylabel("Wheel profile [mm]")
        low, high = worn.min() - BESIDE, worn.max() + BESIDE
        seen = (1e3 * dataset["u"].values[0] >= low) & (1e3 * dataset["u"].values[0] <= high)
        heights = 1e3 * dataset["w"].values[:, seen]
        top.set_ylim(heights.min() - 1.0, heights.max() + 1.0)
        bottom.set_ylim(bottom=0.0)
        bottom.set_ylabel("Depth worn off [mm]")
        bottom.set_xlabel("Position on the wheel profile $u_w$ [mm]")
        figure.suptitle(dataset.attrs["title"], x=0.01, ha="left", fontsize=8.5)
        figure.legend(*top.get_legend_handles_labels(), loc="outside lower center", ncols=MOST_LINES)
        figure.align_ylabels([top, bottom])
    return figure


LEAST_CHANGE = 0.05
"""Change of the flange that is drawn at least [mm]: below it lies the round-off of the profile's nodes."""


def mileage_figure(dataset: xr.Dataset) -> Figure:
    """Changes of the flange's dimensions, conicity, largest depth and mass lost against the mileage."""
    x = 1e-3 * dataset["mileage"].values
    line = {"marker": "o", "markersize": 2.2, "linewidth": 0.9}
    with style():
        figure = new_figure(FULL_WIDTH, 115.0)
        ((flange, cone), (depth, mass)) = figure.subplots(2, 2, sharex=True)
        sizes = (("thickness", "Sd"), ("height", "Sh"), ("steepness", "qR"))
        for colour, dashes, (name, short) in zip(SERIES_COLOURS, GROUP_LINE, sizes, strict=False):
            values = 1e3 * dataset[f"flange_{name}"].values
            if np.isfinite(values).any():
                flange.plot(
                    x, values - values[0], color=colour, label=f"{short} - {values[0]:.2f}", linestyle=dashes, **line
                )
        if flange.lines:
            low, high = flange.get_ylim()
            flange.set_ylim(min(low, -LEAST_CHANGE), max(high, LEAST_CHANGE))
            flange.legend()
        flange.set_ylabel("Flange against the new one [mm]")
        cone.plot(x, dataset["conicity"].values, color=INK, **line)
        cone.set_ylim(0.0, 1.15 * float(np.nanmax(dataset["conicity"].values, initial=0.1)))
        cone.set_ylabel(f"Equivalent conicity, {1e3 * dataset.attrs['conicity_amplitude_m']:g} mm")
        depth.plot(x, 1e3 * dataset["deepest"].values, color=INK, **line)
        depth.set_ylabel("Largest depth [mm]")
        for colour, zone in zip(SERIES_COLOURS, ("tread", "flange"), strict=False):
            values = 1e6 * dataset[zone].values
            values[-1:] = values[-2:-1]  # of the last step
            mass.step(x, values, where="post", color=colour, label=zone, linewidth=0.9)
        mass.set_ylim(bottom=0.0)
        mass.legend()
        mass.set_ylabel("Mass lost [g/km]")
        for axes in (depth, mass):
            axes.set_xlabel("Mileage [km]")
        figure.suptitle(dataset.attrs["title"], x=0.01, ha="left", fontsize=8.5)
    return figure


FIGURES = {"wear_profiles": profiles_figure, "wear_mileage": mileage_figure}
"""Pictures of a service, by file name without ending."""
