"""Rolling radius difference, contact points and angles over the lateral shift; equivalent conicity over amplitude."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim.plots.colours import INK, QUIET, WHEEL_COLOUR
from wrsim.plots.marks import broken, minus, note, remark
from wrsim.plots.style import FULL_WIDTH, new_figure, shown, style
from wrsim.results import CHANNELS
from wrsim.results.steering import steering_summary
from wrsim.results.wheelsets import of_wheelset, wheelsets

JUMP = 1.5
"""Millimetres between two shifts beyond which a contact point has jumped elsewhere: the line is interrupted."""
ROLL_WORDS = {
    "none": "wheelset without roll (EN 15302)",
    "rail-top": "wheelset rolled, shift at the rail tops",
    "centre": "wheelset rolled, shift of its centre",
}


def figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Maker of the picture of a conicity analysis, by file name without ending."""
    return {"conicity": lambda: conicity_figure(of_wheelset(dataset, wheelsets(dataset)[0]))}


def conicity_figure(dataset: xr.Dataset) -> Figure:
    """Four panels on one page."""
    attributes = dataset.attrs
    radii = [2e3 * float(attributes[f"radius_{side}_m"]) for side in ("left", "right")]
    diameters = f"{radii[0]:.6g}" if radii[0] == radii[1] else f"{radii[0]:.6g} / {radii[1]:.6g}"
    facts = (
        f"gauge {1e3 * float(attributes['gauge_m']):.6g} mm, profile origins "
        f"{1e3 * float(attributes['profile_spacing_m']):.6g} mm apart, wheels {diameters} mm, "
        f"{ROLL_WORDS.get(str(attributes['roll']), '')}"
    )
    with style():
        figure = new_figure(FULL_WIDTH, 132.0)
        figure.suptitle(f"{attributes['title']}\n{facts}", x=0.012, ha="left", fontsize=8.0)
        axes = [figure.add_subplot(2, 2, i + 1) for i in range(4)]
        radius_difference(axes[0], dataset)
        conicity_curve(axes[1], dataset)
        contact_points(axes[2], dataset)
        angles(axes[3], dataset)
    return figure


def radius_difference(axes: Axes, dataset: xr.Dataset) -> Axes:
    """Delta r over the lateral shift, with the place where the wheelset is in balance."""
    y, difference = shown(dataset, "lateral_shift"), shown(dataset, "rolling_radius_difference")
    axes.plot(*broken(y, difference, JUMP), color=INK)
    axes.axhline(0.0, color=QUIET, linewidth=0.5)
    place = 1e3 * float(dataset.attrs["equilibrium_shift_m"])
    axes.plot([place], [0.0], "o", markerfacecolor="white", markeredgecolor=INK, markersize=4.0, zorder=3.0)
    if abs(place) > 5e-3:
        note(axes, f"{place:.2f} mm", (place, 0.0), (6.0, -10.0), color=INK)
    for i, curve in enumerate(steering_summary(dataset).get("radial_steering", [])):
        at = y.min() + 0.17 * (i % 3) * np.ptp(y)
        for sign in (1.0, -1.0):
            axes.axhline(sign * curve["needed_mm"], color=QUIET, linewidth=0.7, linestyle=(0, (4, 2)))
        note(axes, f"R {curve['curve_radius_m']:g} m", (at, curve["needed_mm"]), (2.0, 2.0), fontsize=6.5)
    axes.set(xlabel=CHANNELS["lateral_shift"].label, ylabel="Rolling radius difference $\\Delta r$ [mm]")
    remark(axes, "left minus right")
    return axes


def conicity_curve(axes: Axes, dataset: xr.Dataset) -> Axes:
    """tan gamma_e over the amplitude; the value at 3 mm is written beside it."""
    amplitude, values = shown(dataset, "amplitude"), dataset["equivalent_conicity"].values
    axes.plot(amplitude, values, color=INK)
    for i in np.flatnonzero((np.abs(amplitude - 3.0) < 1e-6) & np.isfinite(values)):
        axes.plot([amplitude[i]], [values[i]], "o", color=INK, markersize=3.5)
        note(axes, f"{values[i]:.3f}", (amplitude[i], values[i]), (0.0, 6.0), fontsize=7.0, ha="center", color=INK)
    axes.set_ylim(0.0, 1.12 * max(float(np.nanmax(values, initial=0.0)), 1e-3))
    axes.set(xlabel=CHANNELS["amplitude"].label, ylabel=r"Equivalent conicity $\tan\gamma_e$")
    return axes


def contact_points(axes: Axes, dataset: xr.Dataset) -> Axes:
    """Where the contact is, on the wheel profile (solid) and on the rail profile (dashed)."""
    y = shown(dataset, "lateral_shift")
    for j, wheel in enumerate(dataset["wheel"].values):
        for name, line in (("u_wheel", "-"), ("u_rail", (0, (3, 1.5)))):
            points = broken(y, shown(dataset, name)[:, j, 0], JUMP)
            label = f"{wheel} {name.removeprefix('u_')}"
            axes.plot(*points, color=WHEEL_COLOUR[str(wheel)], linestyle=line, label=label)
    axes.set(xlabel=CHANNELS["lateral_shift"].label, ylabel="Contact point, outward u [mm]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.98), ncols=4, fontsize=6.5, handlelength=1.6)
    return axes


def angles(axes: Axes, dataset: xr.Dataset) -> Axes:
    """Contact angles of both wheels against the track plane."""
    y = shown(dataset, "lateral_shift")
    values, points = shown(dataset, "contact_angle"), shown(dataset, "u_wheel")
    for j, wheel in enumerate(dataset["wheel"].values):
        line = broken(y, values[:, j, 0], JUMP, by=points[:, j, 0])
        axes.plot(*line, color=WHEEL_COLOUR[str(wheel)], label=f"{wheel} wheel")
    axes.set_yscale("asinh", linear_width=2.0)
    axes.set_yticks([-2.0, 0.0, 1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 70.0])
    axes.set_yticks([], minor=True)
    axes.yaxis.set_major_formatter(lambda value, _: minus(f"{value:g}"))
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    axes.set_ylim(min(1.2 * low, 0.0), max(1.2 * high, 2.0))
    axes.set(xlabel=CHANNELS["lateral_shift"].label, ylabel="Contact angle $\\gamma$ [°]")
    axes.legend(loc="best", fontsize=6.5)
    return axes
