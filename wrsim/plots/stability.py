"""Root locus, damping and frequency of the modes over speed, and the bifurcation diagram of the limit cycles."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from wrsim.plots.marks import large_and_small, legend_beneath, note, panels
from wrsim.plots.theme import INK, QUIET, SERIES_COLOURS, STOP_COLOUR, pressure_map, shown, style
from wrsim.results import CHANNELS
from wrsim.results.stability import summarise_stability
from wrsim.results.table import formatted, quantity

DAMPED = 0.5
"""Modes with a larger damping ratio than this at all speeds are left out of the curves over speed."""
NAMED = 5  # modes that the legend names: those that come closest to instability
BRANCHES = {"from above": (STOP_COLOUR, "v"), "from below": ("#0072B2", "^")}


def stability_figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Makers of the pictures of a stability analysis, by file name without ending: modes, bifurcation."""
    makers: dict[str, Callable[[], Figure]] = {"modes": partial(modes_figure, dataset)}
    if "cycle" in dataset.dims:
        makers["bifurcation"] = partial(panels, _title(dataset), [partial(bifurcation, dataset=dataset)], 90.0)
    return makers


@style()
def modes_figure(dataset: xr.Dataset) -> Figure:
    """Root locus on the left; damping and frequency over speed on the right."""
    curves = [partial(over_speed, dataset=dataset, name=f"mode_{name}") for name in ("damping", "frequency")]
    figure = large_and_small(_title(dataset), partial(root_locus, dataset=dataset), curves, 118.0, 1.15)
    legend_beneath(figure, figure.axes[-2].get_legend_handles_labels()[0], 2, "right", fontsize=6.5)
    return figure


def root_locus(axes: Axes, dataset: xr.Dataset) -> None:
    """Eigenvalues in the complex plane, dark at high speed; the critical one is ringed."""
    speed = shown(dataset, "pose_speed")
    damping = dataset["mode_damping"].values
    growth, frequency = dataset["mode_growth"].values, dataset["mode_frequency"].values
    colours = pressure_map()
    scale = Normalize(speed[0] - 0.15 * np.ptp(speed), speed[-1] if speed[-1] > speed[0] else speed[0] + 1.0)
    retained = np.isfinite(growth) & (damping < DAMPED)
    many = np.broadcast_to(speed[:, None], growth.shape)
    axes.axvline(0.0, color=QUIET, linewidth=0.6)
    axes.scatter(
        growth[retained], frequency[retained], c=colours(scale(many[retained])), s=7.0, linewidths=0.0, zorder=2.0
    )
    if (critical := summarise_stability(dataset)["critical_frequency_Hz"] or 0.0) > 0.0:
        ring: Any = {"markerfacecolor": "none", "markeredgecolor": STOP_COLOUR, "zorder": 3.0}
        axes.plot([0.0], [critical], "o", markersize=7.0, **ring)
    axes.set(xlabel=CHANNELS["mode_growth"].label, ylabel=CHANNELS["mode_frequency"].label)
    bar = axes.figure.colorbar(ScalarMappable(scale, colours), ax=axes, pad=0.02, aspect=40)
    bar.set_label("Speed [km/h]", fontsize=7.0)
    bar.ax.set_ylim(speed[0], max(speed[-1], speed[0] + 1e-6))


def over_speed(axes: Axes, dataset: xr.Dataset, name: str) -> None:
    """A channel of the modes over speed, a line a mode; those nearest to instability are coloured and named."""
    speed, branch = shown(dataset, "pose_speed"), dataset["mode_branch"].values
    values, damping = shown(dataset, name), dataset["mode_damping"].values
    order = sorted((float(np.min(damping[branch == number])), number) for number in np.unique(branch[branch > 0]))
    for rank, number in enumerate(number for least, number in order if least < DAMPED):
        i, j = np.nonzero(branch == number)
        line: dict[str, Any] = {"color": "#c4c4c4", "linewidth": 0.8, "zorder": 1.5}
        if rank < NAMED:
            lowest = int(np.argmin(damping[i, j]))
            frequency = quantity(float(dataset["mode_frequency"].values[i[lowest], j[lowest]]), "Hz", ".2f")
            mode = f"{dataset['mode_name'].values[i[lowest], j[lowest]]}, {frequency}"
            label = f"{mode} at {quantity(float(speed[i[lowest]]), 'km/h', '.0f')}"
            line = {"color": SERIES_COLOURS[rank], "zorder": 3.0, "label": label}
        axes.plot(speed[i], values[i, j], marker="o" if len(i) == 1 else None, markersize=2.0, **line)
    if name == "mode_damping":
        axes.axhline(0.0, color=QUIET, linewidth=0.6)
    if (critical := summarise_stability(dataset)["linear_critical_speed_kmh"]) is not None:
        axes.axvline(critical, color=STOP_COLOUR, linewidth=0.8, linestyle=(0, (3, 2)))
    axes.set(xlabel=CHANNELS["pose_speed"].label, ylabel=CHANNELS[name].label)


def bifurcation(axes: Axes, dataset: xr.Dataset) -> None:
    """Amplitude of the wheelset that moves most over speed, from above and from below; hollow where not converged."""
    speed = shown(dataset, "cycle_speed")
    amplitude = np.max(shown(dataset, "cycle_amplitude"), axis=1)
    branch, ending = dataset["cycle_branch"].values, dataset["cycle_ending"].values
    amplitude = np.where(ending == "rest", 0.0, amplitude)
    for name, (colour, mark) in BRANCHES.items():
        points = np.flatnonzero((branch == name) & (ending != "derailed"))
        points = points[np.argsort(speed[points])]
        if not points.size:
            continue
        alive = (amplitude[points] > 0.0) & (ending[points] == "cycle")
        axes.plot(speed[points], np.where(alive, amplitude[points], np.nan), color=colour, linewidth=0.9, gid=name)
        converged = ~np.isin(ending[points], ("not converged", "unsettled"))  # the second in older files
        closed, open_ = points[converged], points[~converged]
        axes.plot(speed[closed], amplitude[closed], mark, color=colour, markersize=4.0, label=name)
        if open_.size:
            hollow: Any = {"markerfacecolor": "white", "markeredgecolor": colour, "label": f"{name}, not converged"}
            axes.plot(speed[open_], amplitude[open_], mark, markersize=4.0, **hollow)
    lost = np.flatnonzero(ending == "derailed")
    if lost.size:
        axes.plot(speed[lost], np.zeros(lost.size), "x", color=INK, markersize=5.0, label="derailed")
    top = axes.get_ylim()[1]
    for kind in ("linear", "nonlinear"):
        value = summarise_stability(dataset)[f"{kind}_critical_speed_kmh"]
        if value is not None and speed.min() - 50.0 <= value <= speed.max() + 50.0:
            axes.axvline(value, color=QUIET, linewidth=0.8, linestyle=(0, (3, 2)))
            label = f"{kind} {formatted(value, '.1f')}"
            note(axes, label, (value, 0.4 * top), (-2.0, 0.0), rotation=90, ha="right", va="center")
    axes.set_ylim(bottom=-0.03 * top, top=top)
    axes.set(xlabel=CHANNELS["cycle_speed"].label, ylabel="Amplitude of the wheelset that moves most [mm]")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=6.5)


def _title(dataset: xr.Dataset) -> str:
    facts = summarise_stability(dataset)
    lines = [str(dataset.attrs["title"])]
    if (linear := facts["linear_critical_speed_kmh"]) is not None:
        frequency = quantity(facts["critical_frequency_Hz"], "Hz", ".2f")
        lines.append(f"linear critical speed {quantity(linear, 'km/h', '.1f')}, {frequency}, {facts['critical_mode']}")
    elif "critical_note" in facts:
        lines.append(facts["critical_note"])
    if (nonlinear := facts["nonlinear_critical_speed_kmh"]) is not None:
        lines[-1] += f"; nonlinear {quantity(nonlinear, 'km/h', '.1f')}"
    return "\n".join(lines)
