"""Results side by side: patches of contact models at the same moments, their values with the differences beside them;
histories of several results over each other."""

from __future__ import annotations

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

from wrsim.plots.colours import GROUP_LINE, INK, QUIET, SERIES_COLOURS, WHEEL_COLOUR
from wrsim.plots.gallery import colour_bar
from wrsim.plots.marks import draw_line, few_ticks, panels, wheel_entries
from wrsim.plots.moments import PatchAt, choose_moments, moment_title, patches_of, pose_abscissa, pose_groups, select
from wrsim.plots.patches import contact_patch, extent
from wrsim.plots.style import FULL_WIDTH, abscissa, headline, new_figure, place, shown, style, write
from wrsim.results import CHANNELS
from wrsim.results.moments import moment_dim
from wrsim.results.table import with_unit

MODEL_COLOUR = (INK, *SERIES_COLOURS[:6])
"""Colours of the models; more than seven begin again."""
HISTORIES = ("Q", "Y", "contact_angle", "p0", "T_gamma")
STATIC = ("p0", "area", "approach", "contact_angle", "Y", "X")
MOST_MOMENTS = 6
NEAR = 1.0
"""Distance within which snapshots of two runs are the same place [m]."""
LEAST_DIFFERENCE = 0.2
"""Least span of an axis of differences [%, degrees]."""
LEFT, GAP, TITLES, BENEATH, FOOT = 24.0, 5.0, 8.0, 11.0, 17.0


@style()
def patches_figure(results: Mapping[str, xr.Dataset], title: str, moments: Sequence[int] | None = None) -> Figure:
    """Patches of every model (rows, by wheel) at the same moments (columns), to one scale.

    results: datasets by the models' names, the reference first; a moment that one lacks stays empty. Across: the rail's
    arclength from the reference's largest patch, so that shifts between models are seen.
    """
    names = list(results)
    first = results[names[0]]
    chosen = list(moments) if moments is not None else choose_moments(first, MOST_MOMENTS)
    wheels = [str(w) for w in first["wheel"].values]
    rows = [(wheel, name) for wheel in wheels for name in names]
    same = {(n, m): _same_moment(results[n], first, m) for n in names for m in chosen}
    drawn = {(w, n, m): _placed(results[n], first, m, same[n, m], w) for w, n in rows for m in chosen}
    drawn = {key: patches for key, patches in drawn.items() if patches}
    reach_s, reach_x = {}, {}
    for wheel in wheels:
        found = extent((results[n], *patch) for (w, n, _), p in drawn.items() if w == wheel for patch in p)
        s, x = found or ((-5.0, 5.0), (-5.0, 5.0))
        reach_s[wheel], reach_x[wheel] = (s[0] - 1.0, s[1] + 1.0), (x[0] - 1.0, x[1] + 1.0)
    across = max(high - low for low, high in reach_s.values())
    panel = min((FULL_WIDTH - LEFT - 4.0) / len(chosen) - GAP, 42.0)
    per_mm = min(panel / across, 60.0 / max(high - low for low, high in reach_x.values()))
    heights = {w: per_mm * (high - low) for w, (low, high) in reach_x.items()}
    total = 8.0 + sum(heights[w] + BENEATH for w, _ in rows) + TITLES * len(wheels) + FOOT
    shapes = [shown(select(results[n], where), "strip_p") for (_, n, _), p in drawn.items() for where, _ in p]
    scale = Normalize(0.0, max((float(p.max()) for p in shapes), default=1.0))
    figure = new_figure(FULL_WIDTH, total, constrained=False)
    headline(figure, title)
    top = 8.0
    for i, (wheel, name) in enumerate(rows):
        if i % len(names) == 0:
            for j, moment in enumerate(chosen):
                write(figure, LEFT + j * (panel + GAP), top, moment_title(first, moment, j), fontsize=6.2)
            top += TITLES
        label = name.replace("+", "\n+") + (f"\n{wheel} wheel" if len(wheels) > 1 else "")
        colour = MODEL_COLOUR[names.index(name) % len(MODEL_COLOUR)]
        write(figure, 1.5, top + 0.3 * heights[wheel], label, fontsize=6.0, color=colour)
        for j, moment in enumerate(chosen):
            patches = drawn.get((wheel, name, moment))
            if patches is None:
                continue
            axes = place(figure, LEFT + j * (panel + GAP), top, panel, heights[wheel])
            for where, shift in patches:
                contact_patch(axes, results[name], where, scale, shift=shift)
            middle, half = sum(reach_s[wheel]) / 2.0, 0.5 * panel / per_mm
            axes.set(xlim=(middle - half, middle + half), ylim=reach_x[wheel])
            few_ticks(axes, 4, 5.6, 1.2)
            axes.set_xlabel(_note(results[name], patches), fontsize=5.8, color=QUIET, labelpad=1.0)
        top += heights[wheel] + BENEATH
    reading = "Across: arclength on the rail from the reference's\nmain point [mm]. Up: rolling direction $x$ [mm]."
    colour_bar(figure, scale, top + 1.0, reading)
    return figure


def values_figure(values: xr.Dataset, reference: str, title: str) -> Figure:
    """Quantities of all models (left) and their differences from the reference (right), against distance or pose.

    values: as `analysis.compare.Comparison.values`.
    """
    runs = "time" in values.dims
    names = [str(n) for n in values["model"].values]
    quantities = [q for q in (HISTORIES if runs else STATIC) if np.isfinite(values[q].values).any()]
    groups = [("", np.arange(values.sizes["time"]))] if runs else pose_groups(values)
    across = ("distance" if "distance" in values.coords else "time") if runs else pose_abscissa(values)
    x = shown(values, across)
    wheels = [str(w) for w in values["wheel"].values]
    colours = dict(zip(names, cycle(MODEL_COLOUR)))
    lines = [(label, member, w, wheel) for label, member in groups for w, wheel in enumerate(wheels)]
    looks = dict(enumerate(islice(cycle(GROUP_LINE), len(lines))))

    def draw(axes: Axes, quantity: str, differences: bool) -> None:
        channel, (factor, unit) = CHANNELS[quantity], _difference_unit(quantity)
        y = factor * values[f"{quantity}_difference"].values if differences else shown(values, quantity)
        for i, name in enumerate(names):
            if differences and name == reference:
                continue
            for n, (_, member, w, _) in enumerate(lines):
                look: Any = {"color": colours[name], "linestyle": looks[n], "lw": 0.9, "markersize": 1.8}
                draw_line(axes, x[member], y[i, member, w], marker="" if runs else "o", **look)
        axes.set_xlabel(CHANNELS[across].label)
        if differences:
            axes.set_ylabel(f"$\\Delta$ {unit}")
            axes.axhline(0.0, color=INK, lw=0.6)
            axes.set_title(f'difference from "{reference}"' if quantity == quantities[0] else "", fontsize=7.0)
        else:
            axes.set_ylabel(f"${channel.symbol}$ [{channel.shown.symbol}]")
        _widen(axes, LEAST_DIFFERENCE if differences else 0.02 * max(abs(end) for end in axes.get_ylim()))

    legend = [Line2D([], [], color=colour, label=name) for name, colour in colours.items()]
    for n, (label, _, _, wheel) in enumerate(lines if len(lines) > 1 else ()):
        words = (label, f"{wheel} wheel".strip() if len(wheels) > 1 else "")
        legend.append(Line2D([], [], color=QUIET, linestyle=looks[n], label=", ".join(filter(None, words))))
    draws = [partial(draw, quantity=q, differences=d) for q in quantities for d in (False, True)]
    return panels(title, draws, 36.0 * len(quantities) + 24.0, columns=2, legend=legend)


def _widen(axes: Axes, span: float) -> None:
    """Let an axis show at least this span: differences too small to matter look small."""
    low, high = axes.get_ylim()
    if high - low < span:
        axes.set_ylim(0.5 * (low + high - span), 0.5 * (low + high + span))


def _difference_unit(quantity: str) -> tuple[float, str]:
    """Factor and words of a difference."""
    if quantity.startswith("contact_angle"):
        return CHANNELS[quantity].shown.factor, "[°]"
    return 100.0, "[% of $N$]" if quantity in ("X", "Y", "Q") else "[%]"


def _same_moment(dataset: xr.Dataset, first: xr.Dataset, moment: int) -> int | None:
    """The pose of the same name, or the snapshot taken at the same place, of another dataset."""
    if moment_dim(first) == "pose":
        found = np.flatnonzero(dataset["pose"].values == first["pose"].values[moment])
        return int(found[0]) if found.size else None
    offsets = np.abs(dataset["snapshot_distance"].values - first["snapshot_distance"].values[moment])
    return int(np.argmin(offsets)) if offsets.size and offsets.min() <= NEAR else None


def _placed(
    dataset: xr.Dataset, first: xr.Dataset, reference: int, moment: int | None, wheel: str
) -> list[tuple[PatchAt, float]]:
    """Patches of a wheel and what to add to their s, so that all lie on the arclength of the rail [mm].

    reference: the moment in the dataset of the reference, whose main point is zero.
    """
    if moment is None:
        return []
    origin = patches_of(first, reference, wheel)
    zero = _arc(first, origin[0]) if origin else 0.0
    return [(where, _arc(dataset, where) - zero) for where in patches_of(dataset, moment, wheel)]


def _arc(dataset: xr.Dataset, where: PatchAt) -> float:
    """Arclength on the rail's outline of the place where a patch has s = 0 [mm]."""
    strips = select(dataset, where)
    here = dataset.sel(wheel=where.wheel).isel({moment_dim(dataset): where.moment})
    y, z = (shown(here, f"rail_profile_{n}") for n in ("y", "z"))
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(y), np.diff(z)))])
    at = int(np.argmin(np.abs(strips["strip_s"].values)))
    point = shown(strips, "strip_y")[at], shown(strips, "strip_z")[at]
    return float(arc[np.argmin(np.hypot(y - point[0], z - point[1]))] - shown(strips, "strip_s")[at])


def _note(dataset: xr.Dataset, patches: Sequence[tuple[PatchAt, float]]) -> str:
    """Largest pressure and force of the strips drawn."""
    at = {moment_dim(dataset): patches[0][0].moment}
    strips = dataset[["strip_p", "strip_N"]].isel(at).sel(wheel=patches[0][0].wheel)
    return f"{float(strips['strip_p'].max()) / 1e6:.0f} MPa, {float(strips['strip_N'].sum()) / 1e3:.1f} kN"


CHANNELS_DRAWN = ("Y", "Q", "Y_over_Q", "T_gamma", "lateral_shift", "yaw")


def has_curves(dataset: xr.Dataset) -> bool:
    """True if there is something to lay over each other: a run of several samples, or poses."""
    return any(n in dataset for n in CHANNELS_DRAWN) and max(dataset.sizes.get(d, 0) for d in ("time", "pose")) > 1


def overlay_figure(datasets: Sequence[xr.Dataset], names: Sequence[str]) -> Figure:
    """Forces, wear number, shift and angle of attack of one wheelset in several results over each other: the
    first drawn through, the second dashed, and so on; names: what these are called."""
    lines = GROUP_LINE * 2

    def draw(axes: Axes, name: str) -> None:
        for dataset, line in zip(datasets, lines, strict=False):
            poses = "pose" in dataset.dims
            x, along = (np.arange(dataset.sizes["pose"]), "pose") if poses else abscissa(dataset)
            values = shown(dataset, name).reshape(x.size, -1)
            wheels = dataset["wheel"].values if "wheel" in dataset[name].dims else [""]
            for own, wheel in zip(values.T, wheels, strict=True):
                axes.plot(x, own, color=WHEEL_COLOUR.get(str(wheel), INK), linestyle=line, linewidth=0.9)
        channel = CHANNELS[name]
        axes.set_xlabel("Pose" if along == "pose" else CHANNELS[along].label)
        axes.set_ylabel(with_unit(f"${channel.symbol}$", channel.shown.symbol) if channel.symbol else channel.label)

    present = [name for name in CHANNELS_DRAWN if all(name in dataset for dataset in datasets)]
    entries = [Line2D([], [], color=INK, linestyle=line, label=name) for line, name in zip(lines, names, strict=False)]
    return panels(
        " | ".join(str(dataset.attrs["title"]) for dataset in datasets),
        [partial(draw, name=name) for name in present],
        20.0 + 33.0 * len(present),
        legend=[*entries, *wheel_entries(datasets[0]["wheel"].values)],
    )
