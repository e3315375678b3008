"""Static analyses: contact quantities against lateral shift, a line for every yaw and load."""

from collections.abc import Sequence
from functools import partial
from itertools import cycle
from math import ceil
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from wrsim.plots.histories import ANGLE_JUMP
from wrsim.plots.marks import broken, draw_line, panels, stop_note, wheel_entries
from wrsim.plots.moments import beyond_railways, ends_of, pose_abscissa, pose_groups
from wrsim.plots.theme import GROUP_LINE, GROUP_MARK, QUIET, WHEEL_COLOUR, shown
from wrsim.results import CHANNELS

PANELS = ("contact_angle", "p0", "N", "area")


def against_pose(axes: Axes, dataset: xr.Dataset, name: str) -> Axes:
    """A channel of the wheels (or of their patches) against the varied pose; later patches as hollow marks."""
    across = pose_abscissa(dataset)
    x, values = shown(dataset, across), shown(dataset, name)
    angle = shown(dataset, "contact_angle") if "contact_angle" in dataset else None
    values = values.reshape(*values.shape[:2], -1)
    for g, (_, member) in enumerate(pose_groups(dataset)):
        line, mark = GROUP_LINE[g % len(GROUP_LINE)], GROUP_MARK[g % len(GROUP_MARK)]
        for j, wheel in enumerate(dataset["wheel"].values):
            colour = WHEEL_COLOUR[str(wheel)]
            main = values[member, j, 0]
            by = angle[member, j, 0] if angle is not None else np.zeros(main.shape)
            line_x, line_y = broken(x[member], main, ANGLE_JUMP, by=by)
            draw_line(axes, line_x, line_y, color=colour, linestyle=line, marker=mark, markersize=2.2)
            hollow: Any = {"markerfacecolor": "none", "markeredgewidth": 0.7, "markersize": 3.6}
            for k in range(1, values.shape[2]):
                axes.plot(x[member], values[member, j, k], mark, color=colour, gid=f"patch {k}", **hollow)
    axes.set(xlabel=CHANNELS[across].label, ylabel=CHANNELS[name].label)
    return axes


def static_figure(dataset: xr.Dataset, names: Sequence[str] = PANELS) -> Figure:
    """Contact angle, largest pressure, normal force and area against lateral shift, for every yaw and load."""
    present = [name for name in names if name in dataset]
    groups = pose_groups(dataset)
    forces = np.nan_to_num(shown(dataset, "N")) if "N" in dataset else np.zeros((dataset.sizes["pose"], 1, 1))
    beyond, left_out = beyond_railways(forces.reshape(*forces.shape[:2], -1).sum(axis=-1))
    banded = {"contact_angle_min", "contact_angle_max"} <= set(dataset) and "contact_angle" in present

    def draw(axes: Axes, name: str) -> None:
        against_pose(axes, dataset, name)
        for j, wheel in enumerate(dataset["wheel"].values if name == "contact_angle" and banded else ()):
            x, low, high = (shown(dataset, n) for n in (pose_abscissa(dataset), f"{name}_min", f"{name}_max"))
            look: Any = {"color": WHEEL_COLOUR[str(wheel)], "alpha": 0.25, "linewidth": 2.0, "zorder": 1.8}
            axes.vlines(x, low[:, j, 0], high[:, j, 0], **look)
        if beyond.any():
            axes.set_ylim(ends_of(shown(dataset, name)[~beyond]))
        if name != "contact_angle" and axes.dataLim.y0 >= 0.0:
            axes.set_ylim(0.0, axes.get_ylim()[1] if beyond.any() else 1.06 * max(axes.dataLim.y1, 1e-9))

    legend = wheel_entries(dataset["wheel"].values)
    if banded:
        legend.append(Patch(facecolor=QUIET, alpha=0.3, label="angles over the main patch"))
    if len(groups) > 1:
        for (label, _), line, mark in zip(groups, cycle(GROUP_LINE), cycle(GROUP_MARK)):
            legend.append(Line2D([], [], color=QUIET, linestyle=line, marker=mark, label=label))
    if any(np.isfinite(dataset[n].values[:, :, 1:]).any() for n in present if dataset[n].ndim == 3):
        hollow: Any = {"linestyle": "none", "marker": "o", "markerfacecolor": "none"}
        legend.append(Line2D([], [], color=QUIET, label="further patch", **hollow))
    unsolved = int((dataset["pose_message"].values != "").sum()) if "pose_message" in dataset else 0
    poses = f"{unsolved} of {dataset.sizes['pose']} poses without a solution" if unsolved else ""
    note = "; ".join(filter(None, (stop_note(dataset), poses, left_out)))
    title, draws = dataset.attrs.get("title", ""), [partial(draw, name=name) for name in present]
    height = 54.0 * ceil(len(present) / 2) + 22.0
    return panels(title, draws, height, columns=2, share=False, legend=legend, across=5, note=note)
