"""Rolling radius difference, contact points and angles over the lateral shift; equivalent conicity over amplitude and
gauge."""

from collections.abc import Callable
from functools import partial

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim.plots.marks import broken, minus, note, panels, remark
from wrsim.plots.theme import INK, QUIET, TWO_COLUMNS, WHEEL_COLOUR, full_width, pressure_map, shown
from wrsim.results import CHANNELS
from wrsim.results.conicity import ConicityMap, steering_summary
from wrsim.results.table import formatted, quantity
from wrsim.results.wheelsets import of_wheelset, wheelsets

LINES = 6  # as many pairs of profiles are drawn as lines over the gauge
JUMP = 1.5
"""Millimetres between two shifts beyond which a contact point has jumped elsewhere: the line is interrupted."""
ROLL_LABELS = {
    "none": "wheelset without roll (EN 15302)",
    "rail-top": "wheelset rolled, shift at the rail tops",
    "centre": "wheelset rolled, shift of its centre",
}


def conicity_figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Maker of the picture of a conicity analysis, by file name without ending."""
    return {"conicity": partial(_figure, of_wheelset(dataset, wheelsets(dataset)[0]))}


def _figure(dataset: xr.Dataset) -> Figure:
    about = dataset.attrs
    gauge, apart = (quantity(1e3 * float(about[name]), "mm", ".6g") for name in ("gauge_m", "profile_spacing_m"))
    wheels = [formatted(2e3 * float(about[f"radius_{side}_m"]), ".6g") for side in ("left", "right")]
    setting = f"gauge {gauge}, profile origins {apart} apart, wheels {' / '.join(dict.fromkeys(wheels))} mm, "
    setting += ROLL_LABELS.get(str(about["roll"]), "")
    draws = [partial(draw, dataset=dataset) for draw in (radius_difference, conicity_curve, contact_points, angles)]
    return panels(f"{about['title']}\n{setting}", draws, 132.0, columns=2, share=False)


def radius_difference(axes: Axes, dataset: xr.Dataset) -> None:
    """Delta r over the lateral shift, with the place where the wheelset is in balance."""
    y, difference = shown(dataset, "lateral_shift"), shown(dataset, "rolling_radius_difference")
    axes.plot(*broken(y, difference, JUMP), color=INK)
    axes.axhline(0.0, color=QUIET, linewidth=0.5)
    place = 1e3 * float(dataset.attrs["equilibrium_shift_m"])
    axes.plot([place], [0.0], "o", markerfacecolor="white", markeredgecolor=INK, markersize=4.0, zorder=3.0)
    if abs(place) > 5e-3:
        note(axes, quantity(place, "mm", ".2f"), (place, 0.0), (6.0, -10.0), color=INK)
    for i, curve in enumerate(steering_summary(dataset).get("radial_steering", [])):
        place = y.min() + 0.17 * (i % 3) * np.ptp(y)
        for sign in (1.0, -1.0):
            axes.axhline(sign * curve["needed_mm"], color=QUIET, linewidth=0.7, linestyle=(0, (4, 2)))
        note(axes, f"R {curve['curve_radius_m']:g} m", (place, curve["needed_mm"]), (2.0, 2.0), fontsize=6.5)
    axes.set(xlabel=CHANNELS["lateral_shift"].label, ylabel="Rolling radius difference $\\Delta r$ [mm]")
    remark(axes, "left minus right")


def conicity_curve(axes: Axes, dataset: xr.Dataset) -> None:
    """tan gamma_e over the amplitude; the value at 3 mm is written beside it."""
    amplitude, values = shown(dataset, "amplitude"), dataset["equivalent_conicity"].values
    axes.plot(amplitude, values, color=INK)
    for i in np.flatnonzero((np.abs(amplitude - 3.0) < 1e-6) & np.isfinite(values)):
        axes.plot([amplitude[i]], [values[i]], "o", color=INK, markersize=3.5)
        label = formatted(float(values[i]), ".3f")
        note(axes, label, (amplitude[i], values[i]), (0.0, 6.0), fontsize=7.0, ha="center", color=INK)
    axes.set_ylim(0.0, 1.12 * max(float(np.nanmax(values, initial=0.0)), 1e-3))
    axes.set(xlabel=CHANNELS["amplitude"].label, ylabel=r"Equivalent conicity $\tan\gamma_e$")


def contact_points(axes: Axes, dataset: xr.Dataset) -> None:
    """Where the contact is, on the wheel profile (solid) and on the rail profile (dashed)."""
    y = shown(dataset, "lateral_shift")
    for j, wheel in enumerate(dataset["wheel"].values):
        for name, line in (("u_wheel", "-"), ("u_rail", (0, (3, 1.5)))):
            points = broken(y, shown(dataset, name)[:, j, 0], JUMP)
            label = f"{wheel} {name.removeprefix('u_')}"
            axes.plot(*points, color=WHEEL_COLOUR[str(wheel)], linestyle=line, label=label)
    axes.set(xlabel=CHANNELS["lateral_shift"].label, ylabel="Contact point, outward u [mm]")
    across = 4 if full_width() >= TWO_COLUMNS else 2
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 0.98), ncols=across, fontsize=6.5, handlelength=1.6)


def angles(axes: Axes, dataset: xr.Dataset) -> None:
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
    remark(axes, "scale: linear within ±2°, logarithmic beyond")
    axes.legend(loc="best", fontsize=6.5)


def conicity_map_figure(conicity: ConicityMap, title: str) -> Figure:
    """Conicity at 3 mm above, nonlinearity parameter below; of many pairs a map of the conicity with a row for each."""
    wheels, rails = ({pair[k] for pair in conicity.pairs} for k in (0, 1))
    labels = [
        w if len(rails) == 1 and len(wheels) > 1 else r if len(wheels) == 1 and len(rails) > 1 else f"{w} on {r}"
        for w, r in conicity.pairs
    ]
    gauges, at_3mm = 1e3 * np.array(conicity.gauges), r"equivalent conicity $\tan\gamma_e$ at 3 mm"

    def lines(axes: Axes, values: np.ndarray, ylabel: str, bottom: float | None) -> None:
        for label, row in zip(labels, values, strict=True):
            axes.plot(gauges, row, ".-", label=label)
        axes.set_ylim(bottom=bottom)
        axes.set(xlabel="gauge [mm]", ylabel=ylabel)

    def rows(axes: Axes) -> None:
        step = gauges[1] - gauges[0] if gauges.size > 1 else 1.0
        extent = (gauges[0] - 0.5 * step, gauges[-1] + 0.5 * step, len(labels) - 0.5, -0.5)
        drawn = axes.imshow(conicity.conicity, aspect="auto", extent=extent, cmap=pressure_map(), vmin=0.0)
        axes.set_yticks(range(len(labels)), labels)
        axes.grid(visible=False)
        axes.set_xlabel("gauge [mm]")
        axes.figure.colorbar(drawn, ax=axes, label=at_3mm)

    if len(labels) > LINES:
        return panels(title, [rows], 45.0 + 6.0 * len(labels))
    quantities = ((conicity.conicity, at_3mm, 0.0), (conicity.nonlinearity, "nonlinearity parameter [1/mm]", None))
    draws = [partial(lines, values=values, ylabel=label, bottom=bottom) for values, label, bottom in quantities]
    return panels(title, draws, 120.0, legend=None if len(labels) > 1 else ())
