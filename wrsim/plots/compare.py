"""Results side by side: patches of contact models, their values and differences; histories over each other."""

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import cycle, islice
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wrsim.errors import InputError
from wrsim.plots.gallery import GalleryColumn, GalleryRow, Page, draw_gallery, most_moments
from wrsim.plots.histories import ANGLE_JUMP
from wrsim.plots.marks import broken, draw_line, few_ticks, panels, wheel_entries
from wrsim.plots.moments import (
    PatchAt,
    beyond_railways,
    choose_moments,
    ends_of,
    patches_at,
    pose_abscissa,
    pose_groups,
    select,
)
from wrsim.plots.patches import contact_patch, extent_of_patches
from wrsim.plots.theme import GROUP_LINE, INK, QUIET, SERIES_COLOURS, WHEEL_COLOUR, abscissa, shown
from wrsim.results import CHANNELS
from wrsim.results.moments import moment_dim, moments_at
from wrsim.results.table import quantity

MODEL_COLOUR = (INK, *SERIES_COLOURS[:6])  # more than seven begin again
HISTORIES = ("Q", "Y", "contact_angle", "p0", "T_gamma")
STATIC = ("p0", "area", "approach", "contact_angle", "Y", "X")
LEAST_DIFFERENCE = 0.2  # least span of an axis of differences [%, degrees]


def patches_figure(results: Mapping[str, xr.Dataset], title: str, moments: Sequence[int] | None = None) -> Figure:
    """Patches of every model (rows, by wheel) at the same moments (columns), to one scale. results: datasets by the
    models' names, the reference first; a moment that one lacks stays empty. Across: the rail's arclength from the
    reference's largest patch, so that shifts between models are seen."""
    names = list(results)
    first = results[names[0]]
    columns = [GalleryColumn(m, i) for i, m in enumerate(moments or choose_moments(first, most_moments()))]
    page = Page(len(columns), left=24.0, gap=6.0, widest=42.0, upright=False)
    wheels = [str(w) for w in first["wheel"].values]
    drawn = {(w, n, c.order): _placed(results[n], first, c.moment, w) for w in wheels for n in names for c in columns}
    reaches = {}
    for wheel in wheels:
        extent = extent_of_patches((results[n], *patch) for (w, n, _), p in drawn.items() if w == wheel for patch in p)
        reaches[wheel] = np.add(extent or ((-5.0, 5.0), (-5.0, 5.0)), (-1.0, 1.0))
    wide, tall = np.max([np.ptp(reach, axis=1) for reach in reaches.values()], axis=0)
    per_mm = min(page.panel / wide, 60.0 / tall)
    shapes = [shown(select(results[n], where), "strip_p") for (_, n, _), p in drawn.items() for where, _ in p]
    scale = Normalize(0.0, max((float(p.max()) for p in shapes), default=1.0))

    def draw(axes: Axes, wheel: str, name: str, column: int) -> None:
        patches = drawn[wheel, name, column]
        for where, shift in patches:
            contact_patch(axes, results[name], where, scale, shift=shift)
        middle, half = np.mean(reaches[wheel][0]), 0.5 * page.panel / per_mm
        axes.set(xlim=(middle - half, middle + half), ylim=reaches[wheel][1])
        few_ticks(axes, 4, 5.6, 1.2)
        strips = results[name].isel({moment_dim(first): patches[0][0].moment}).sel(wheel=wheel)
        most, force = float(strips["strip_p"].max()) / 1e6, float(strips["strip_N"].sum()) / 1e3
        note = f"{quantity(most, 'MPa', '.0f')}, {quantity(force, 'kN', '.1f')}"
        axes.set_xlabel(note, fontsize=5.8, color=QUIET, labelpad=1.0)

    def row(wheel: str, name: str, colour: str) -> GalleryRow:
        label = name.replace("+", "\n+") + (f"\n{wheel} wheel" if len(wheels) > 1 else "")
        orders = [c.order for c in columns if drawn[wheel, name, c.order]]
        cells = {j: partial(draw, wheel=wheel, name=name, column=j) for j in orders}
        return GalleryRow(label, colour, per_mm * float(np.ptp(reaches[wheel][1])), 11.0, cells)

    rows = [(columns, [row(wheel, *pair) for pair in zip(names, cycle(MODEL_COLOUR))]) for wheel in wheels]
    reading = "Across: arclength on the rail from the reference's\nmain point [mm]. Up: rolling direction $x$ [mm]."
    return draw_gallery(title, "", first, page, rows, scale, reading)


def values_figure(values: xr.Dataset, reference: str, title: str) -> Figure:
    """Quantities of all models (left) and their differences from the reference (right), against distance or pose.
    values: as `analysis.compare.Comparison.values`."""
    runs = "time" in values.dims
    names = [str(n) for n in values["model"].values]
    quantities = [q for q in (HISTORIES if runs else STATIC) if np.isfinite(values[q].values).any()]
    groups = [("", np.arange(values.sizes["time"]))] if runs else pose_groups(values)
    across = ("distance" if "distance" in values.coords else "time") if runs else pose_abscissa(values)
    x, angles = shown(values, across), shown(values, "contact_angle")
    wheels = [str(w) for w in values["wheel"].values]
    colours = dict(zip(names, cycle(MODEL_COLOUR)))
    lines = [(label, member, w, wheel) for label, member in groups for w, wheel in enumerate(wheels)]
    looks = dict(enumerate(islice(cycle(GROUP_LINE), len(lines))))
    samples = values["N"].transpose("time" if runs else "pose", ...).values
    beyond, left_out = (np.zeros(len(samples), bool), "") if runs else beyond_railways(1e-3 * samples)

    def draw(axes: Axes, name: str, differences: bool) -> None:
        channel = CHANNELS[name]
        factor, unit = 100.0, "[% of $N$]" if name in ("X", "Y", "Q") else "[%]"
        if name.startswith("contact_angle"):
            factor, unit = channel.shown.factor, "[°]"
        y = factor * values[f"{name}_difference"].values if differences else shown(values, name)
        for i, model in enumerate(names):
            if differences and model == reference:
                continue
            for n, (_, member, w, _) in enumerate(lines):
                look: Any = {"color": colours[model], "linestyle": looks[n], "lw": 0.9, "markersize": 1.8}
                look["zorder"] = 3.0 if model == reference else 2.0
                line = broken(x[member], y[i, member, w], ANGLE_JUMP, by=angles[i, member, w])
                draw_line(axes, *line, marker="" if runs else "o", **look)
        axes.set_xlabel(CHANNELS[across].label)
        if differences:
            axes.set_ylabel(f"$\\Delta$ {unit}")
            axes.axhline(0.0, color=INK, lw=0.6)
            axes.set_title(f'difference from "{reference}"' if name == quantities[0] else "", fontsize=7.0)
        else:
            axes.set_ylabel(channel.short_label)
        if beyond.any() and np.isfinite(seen := y[:, ~beyond]).any():
            axes.set_ylim(ends_of(seen))
        low, high = axes.get_ylim()
        span = LEAST_DIFFERENCE if differences else 0.02 * max(abs(low), abs(high))
        if high - low < span:  # differences too small to matter look small
            axes.set_ylim(0.5 * (low + high - span), 0.5 * (low + high + span))

    legend = [Line2D([], [], color=colour, label=name) for name, colour in colours.items()]
    for n, (label, _, _, wheel) in enumerate(lines if len(lines) > 1 else ()):
        parts = (label, f"{wheel} wheel".strip() if len(wheels) > 1 else "")
        legend.append(Line2D([], [], color=QUIET, linestyle=looks[n], label=", ".join(filter(None, parts))))
    draws = [partial(draw, name=q, differences=d) for q in quantities for d in (False, True)]
    return panels(title, draws, 36.0 * len(quantities) + 24.0, columns=2, legend=legend, note=left_out)


def _placed(dataset: xr.Dataset, first: xr.Dataset, reference: int, wheel: str) -> list[tuple[PatchAt, float]]:
    """Patches of a wheel at the pose of the same name or the snapshot at the same place, and what to add to their s to
    get the rail's arclength from the main point of the reference [mm], of which ``reference`` is the moment."""
    try:
        place = first["pose"].values if moment_dim(first) == "pose" else first["snapshot_distance"].values
        (moment,) = moments_at(dataset, [place[reference]], "at")
    except InputError:
        return []
    origin = patches_at(first, reference, wheel)
    zero = _arc(first, origin[0]) if origin else 0.0
    return [(where, _arc(dataset, where) - zero) for where in patches_at(dataset, moment, wheel)]


def _arc(dataset: xr.Dataset, where: PatchAt) -> float:
    """Arclength on the rail's outline of the place where a patch has s = 0 [mm]."""
    strips = select(dataset, where)
    section = dataset.sel(wheel=where.wheel).isel({moment_dim(dataset): where.moment})
    y, z = (shown(section, f"rail_profile_{n}") for n in ("y", "z"))
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(y), np.diff(z)))])
    middle = int(np.argmin(np.abs(strips.variables["strip_s"])))
    point = shown(strips, "strip_y")[middle], shown(strips, "strip_z")[middle]
    return float(arc[np.argmin(np.hypot(y - point[0], z - point[1]))] - shown(strips, "strip_s")[middle])


CHANNELS_DRAWN = ("Y", "Q", "Y_over_Q", "T_gamma", "lateral_shift", "yaw")


def has_curves(dataset: xr.Dataset) -> bool:
    """True if there is something to lay over each other: a run of several samples, or poses."""
    return any(n in dataset for n in CHANNELS_DRAWN) and max(dataset.sizes.get(d, 0) for d in ("time", "pose")) > 1


def overlay_figure(datasets: Sequence[xr.Dataset], names: Sequence[str]) -> Figure:
    """Forces, wear number, shift and angle of attack of one wheelset in several results over each other: the
    first drawn through, the second dashed, and so on; names: what these are called."""
    lines = GROUP_LINE * 2

    def draw(axes: Axes, name: str) -> None:
        for order, (dataset, line) in enumerate(zip(datasets, lines, strict=False)):
            poses = "pose" in dataset.dims
            x, along = (np.arange(dataset.sizes["pose"]), "pose") if poses else abscissa(dataset)
            values = shown(dataset, name).reshape(x.size, -1)
            wheels = dataset["wheel"].values if "wheel" in dataset[name].dims else [""]
            for line_values, wheel in zip(values.T, wheels, strict=True):
                look: Any = {"linestyle": line, "linewidth": 0.9, "zorder": 3.0 - 0.1 * order}  # the first is on top
                axes.plot(x, line_values, color=WHEEL_COLOUR.get(str(wheel), INK), **look)
        axes.set_xlabel("Pose" if along == "pose" else CHANNELS[along].label)
        axes.set_ylabel(CHANNELS[name].short_label)

    present = [name for name in CHANNELS_DRAWN if all(name in dataset for dataset in datasets)]
    entries = [Line2D([], [], color=INK, linestyle=line, label=name) for line, name in zip(lines, names, strict=False)]
    title, draws = (
        " | ".join(dict.fromkeys(str(d.attrs["title"]) for d in datasets)),
        [partial(draw, name=name) for name in present],
    )
    legend = [*entries, *wheel_entries(datasets[0]["wheel"].values)]
    return panels(title, draws, 20.0 + 33.0 * len(present), legend=legend)
