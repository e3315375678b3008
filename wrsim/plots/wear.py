"""Pictures of wear: depths and rolling contact fatigue of a run; evolution of profiles, flange and conicity."""

from collections.abc import Callable
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from wrsim.plots.marks import large_and_small, legend_beneath, panels
from wrsim.plots.theme import GROUP_LINE, INK, QUIET, SERIES_COLOURS, STOP_COLOUR, WHEEL_COLOUR, shown, style
from wrsim.results import CHANNELS
from wrsim.results.summary import worst_worn
from wrsim.results.table import formatted, quantity, with_unit
from wrsim.results.wheelsets import numbered, wheelsets

LAW_LABELS = {"usfd": "USFD", "archard": "Archard", "brr": "BRR"}
BESIDE = 4.0  # room beside what is worn, mm of the profile
MOST_POINTS = 4000  # patches of a wheel in the shakedown map
LARGEST_FRICTION = 0.6

MOST_LINES = 7  # profiles of an evolution that are drawn, the first and the last among them
SEEN = 0.02  # part of the largest depth from which on a place counts as worn


def wear_figure(dataset: xr.Dataset) -> Figure:
    """Depths worn off the wheels of the wheelset that loses most, and off the rails, over their profiles."""
    name, called = worst_worn(dataset), numbered(wheelsets(dataset))
    laws = [str(law) for law in dataset["wear_law"].values]
    whose = f": wheels of wheelset {called[name]}" if len(called) > 1 else ""

    def draw(axes: Axes, body: str) -> None:
        for law, line in zip(laws, GROUP_LINE, strict=False):
            losses = dataset.sel(wheelset=name, wear_law=law)
            _over_profile(axes, losses, f"wear_{body}_depth", body, linestyle=line)
        heading = "Depth worn off the wheel" if body == "wheel" else "Depth worn off the rail\nby one passage"
        label = with_unit(heading, CHANNELS[f"wear_{body}_depth"].shown.symbol)
        axes.set(ylabel=label, xlabel=CHANNELS[f"wear_{body}_u"].label)
        axes.set_ylim(bottom=0.0)

    draws = [partial(draw, body=body) for body in ("wheel", "rail")]
    return panels(dataset.attrs["title"] + whose, draws, 120.0, share=False, legend=_legend(laws), across=5)


@style()
def fatigue_figure(dataset: xr.Dataset) -> Figure:
    """Shakedown map of all patches of the run; T-gamma and damage over the rails by one passage."""
    passage = {
        "wear_rail_energy": "T-gamma over the width of the rail [N/mm]",
        "rail_damage": "RCF damage per passage (Burstow)",
    }

    def draw(axes: Axes, name: str) -> None:
        _over_profile(axes, dataset, name, "rail")
        axes.set(title=f"{passage[name]}, one passage", xlabel=CHANNELS["wear_rail_u"].label)

    small = [partial(draw, name=name) for name in passage]
    figure = large_and_small(dataset.attrs["title"], partial(shakedown_map, dataset=dataset), small, 100.0, 0.87)
    legend_beneath(figure, _legend([]), 2)
    return figure


def shakedown_map(axes: Axes, dataset: xr.Dataset) -> None:
    """Hertz's pressure 3 N / (2 A) over the yield stress in shear against the utilised friction, patch by patch."""
    highest = 2.0
    for i, wheel in enumerate(str(name) for name in dataset["wheel"].values):
        used, index = (dataset[n].sel(wheel=wheel).values.ravel() for n in ("traction_coefficient", "fatigue_index"))
        known = np.flatnonzero(np.isfinite(used) & np.isfinite(index))
        known = known[:: max(known.size // MOST_POINTS, 1)]
        # k / p0 is what the index takes away from the friction
        pressure = 1.0 / np.maximum((used - index)[known], 1e-9)
        if pressure.size:
            highest = max(highest, float(pressure.max()))
        look: Any = {"markersize": 1.6, "color": WHEEL_COLOUR[wheel], "alpha": 0.5, "rasterized": True, "zorder": 2 + i}
        axes.plot(used[known], pressure, ".", **look)
    highest = 1.1 * highest
    mu = np.linspace(1.0 / highest, LARGEST_FRICTION, 100)
    axes.plot(mu, 1.0 / mu, color=STOP_COLOUR, linewidth=0.9)
    axes.fill_between(mu, 1.0 / mu, highest, color=STOP_COLOUR, alpha=0.06, linewidth=0.0)
    axes.text(0.97, 0.97, "surface fatigue", transform=axes.transAxes, ha="right", va="top", color=STOP_COLOUR)
    axes.text(0.03, 0.03, "shakes down at the surface", transform=axes.transAxes, color=QUIET, zorder=1)
    axes.set(xlim=(0.0, LARGEST_FRICTION), xlabel="Utilised friction $T/N$", title="Shakedown map")
    axes.set(ylim=(0.0, highest), ylabel="Load factor $p_0/k$, $p_0 = 3N/(2A)$")


def _over_profile(axes: Axes, dataset: xr.Dataset, name: str, body: str, **look: object) -> None:
    """A channel over the lateral place on wheels or rails; only where there is something."""
    edges = []
    for wheel in (str(side) for side in dataset["wheel"].values):
        u, values = (shown(dataset.sel(wheel=wheel), channel) for channel in (f"wear_{body}_u", name))
        axes.plot(u, values, color=WHEEL_COLOUR[wheel], **look)  # type: ignore[arg-type]
        energy = dataset[f"wear_{body}_energy"].sel(wheel=wheel).values
        worn = u[np.nan_to_num(energy) > 0.0]
        edges += [worn.min() - BESIDE, worn.max() + BESIDE] if worn.size else []
    if edges:
        axes.set_xlim(min(edges), max(edges))


def _legend(laws: list[str]) -> list[Line2D]:
    sides = [Line2D([], [], color=colour, label=f"{side} side") for side, colour in WHEEL_COLOUR.items()]
    lines = zip(laws, GROUP_LINE, strict=False)
    return sides + [Line2D([], [], color=INK, linestyle=line, label=LAW_LABELS[law]) for law, line in lines]


def evolution_figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Makers of the pictures of profile evolution, by file name without ending."""
    return {"wear_profiles": partial(worn_profiles_figure, dataset), "wear_mileage": partial(mileage_figure, dataset)}


def worn_profiles_figure(dataset: xr.Dataset) -> Figure:
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
            axes.plot(x[i], y[i], color=colour, label=quantity(float(mileage[i]), "km"), linewidth=0.9)
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
    x = 1e-3 * dataset["mileage"].values
    line: Any = {"marker": "o", "markersize": 2.2, "linewidth": 0.9}

    def flange(axes: Axes) -> None:
        sizes = (("thickness", "Sd"), ("height", "Sh"), ("steepness", "qR"))
        for colour, dashes, (name, short) in zip(SERIES_COLOURS, GROUP_LINE, sizes, strict=False):
            values = 1e3 * dataset[f"flange_{name}"].values
            if np.isfinite(values).any():
                label = f"{short} - {formatted(float(values[0]), '.2f')}"
                axes.plot(x, values - values[0], color=colour, label=label, linestyle=dashes, **line)
        if axes.lines:
            low, high = axes.get_ylim()
            axes.set_ylim(min(low, -LEAST_CHANGE), max(high, LEAST_CHANGE))
            axes.legend()

    def conicity(axes: Axes) -> None:
        values = dataset["conicity"].values
        axes.plot(x, values, color=INK, **line)
        axes.set_ylim(0.0, 1.15 * float(np.nanmax(values, initial=0.1)))

    def deepest(axes: Axes) -> None:
        axes.plot(x, 1e3 * dataset["deepest"].values, color=INK, **line)

    def mass(axes: Axes) -> None:
        for colour, zone in zip(SERIES_COLOURS, ("tread", "flange"), strict=False):
            values = 1e6 * dataset[zone].values
            values[-1:] = values[-2:-1]  # of the last step
            axes.step(x, values, where="post", color=colour, label=zone, linewidth=0.9)
        axes.set_ylim(bottom=0.0)
        axes.legend()

    def panel(axes: Axes, draw: Callable[[Axes], None], label: str) -> None:
        axes.set(xlabel="Mileage [km]", ylabel=label)
        draw(axes)

    amplitude = quantity(1e3 * float(dataset.attrs["conicity_amplitude_m"]), "mm", "g")
    headings = ("Flange against the new one [mm]", f"Equivalent conicity, {amplitude}", "Largest depth [mm]")
    labels = zip((flange, conicity, deepest, mass), (*headings, "Mass lost [g/km]"), strict=True)
    draws = [partial(panel, draw=draw, label=label) for draw, label in labels]
    return panels(dataset.attrs["title"], draws, 115.0, columns=2)
