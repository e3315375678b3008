"""Stress below the surface: sections along and across with isolines, lines over the depth, fatigue by depth."""

from functools import partial
from math import ceil

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wrsim.plots.marks import panels, stop_note
from wrsim.plots.moments import PatchAt, moment_title
from wrsim.plots.theme import INK, SERIES_COLOURS, pressure_map, shown
from wrsim.results import CHANNELS
from wrsim.results.channels import PATCHES
from wrsim.results.moments import moment_dim
from wrsim.results.table import quantity

LEVELS = 9  # isolines of a section
LINES = ("von_mises", "tresca", "principal_1", "principal_2", "principal_3")
FATIGUE = ("dang_van", "crossland")


def subsurface_figure(dataset: xr.Dataset) -> Figure:
    """Stresses below the patch of one wheelset that has the largest of von Mises."""
    largest = np.nan_to_num(dataset["von_mises_max"].values)
    moment, w, patch = (int(i) for i in np.unravel_index(int(largest.argmax()), largest.shape))
    stresses = dataset.isel({moment_dim(dataset): moment, "wheel": w, "patch": patch}, missing_dims="ignore")
    stresses = stresses.isel(time=moment, missing_dims="ignore")
    where = PatchAt(moment, str(dataset["wheel"].values[w]), patch)
    draws = [
        partial(_section, stresses=stresses, name="von_mises_along", across="section_x"),
        partial(_section, stresses=stresses, name="von_mises_across", across="section_s"),
        partial(_lines, stresses=stresses),
    ]
    criteria = [f"{name}_across" for name in FATIGUE if f"{name}_across" in stresses]
    draws += [partial(_section, stresses=stresses, name=name, across="section_s") for name in criteria]
    title = f"{dataset.attrs.get('title', '')}: {dataset.attrs.get('subsurface_body', 'rail')}, {where.wheel} wheel, "
    title += f"{PATCHES[patch]} patch, {moment_title(dataset, moment, 0).replace(chr(10), ', ')}"
    height = 62.0 * ceil(len(draws) / 2)
    return panels(title, draws, height, columns=2, share=False, legend=None, note=stop_note(dataset))


def _section(axes: Axes, stresses: xr.Dataset, name: str, across: str) -> None:
    x, z, values = (shown(stresses, channel) for channel in (across, "section_depth", name))
    filled = axes.contourf(x, z, values, LEVELS, cmap=pressure_map(), alpha=0.75)
    lines = axes.contour(x, z, values, filled.levels, colors=INK, linewidths=0.5)
    axes.clabel(lines, fontsize=6.0, fmt="%.4g")
    if name.startswith("von_mises"):
        point = (float(shown(stresses, f"von_mises_{across[-1]}")), float(shown(stresses, "von_mises_depth")))
        top = quantity(float(shown(stresses, "von_mises_max")), CHANNELS[name].shown.symbol, ".0f")
        axes.plot(*point, "+", color=INK, markersize=6.0, clip_on=False)
        axes.set_title(f"Largest {top}, {quantity(point[1], 'mm', '.2f')} deep")
    else:
        axes.set_title(f"Largest {float(shown(stresses, name.replace('_across', '_max'))):.3g}, limit 1")
    axes.set(xlabel=CHANNELS[across].label, ylabel=f"{CHANNELS[name].label}\n{CHANNELS['section_depth'].label}")
    axes.set_aspect("equal")
    axes.invert_yaxis()


def _lines(axes: Axes, stresses: xr.Dataset) -> None:
    z = shown(stresses, "section_depth")
    for name, colour in zip(LINES, SERIES_COLOURS, strict=False):
        channel = CHANNELS[f"{name}_below"]
        axes.plot(shown(stresses, channel.name), z, color=colour, label=channel.long_name)
    axes.set(xlabel=f"Stress [{channel.shown.symbol}]", ylabel=CHANNELS["section_depth"].label)
    axes.legend(fontsize=6.0)
    axes.invert_yaxis()
