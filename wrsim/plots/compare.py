"""Contact models side by side: their patches at the same moments, and their values with the differences beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wrsim.plots.colours import GROUP_LINE, INK, QUIET
from wrsim.plots.gallery import colour_bar
from wrsim.plots.marks import draw_line, few_ticks
from wrsim.plots.moments import PatchAt, choose_moments, moment_title, patches_of, select
from wrsim.plots.patches import contact_patch, extent
from wrsim.plots.poses import pose_abscissa, pose_groups
from wrsim.plots.style import FULL_WIDTH, headline, new_figure, place, shown, style, write
from wrsim.results import CHANNELS
from wrsim.results.moments import moment_dim

MODEL_COLOUR = ("#222222", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Colours of the models (Okabe and Ito); more than seven begin again."""
HISTORIES = ("Q", "Y", "contact_angle", "p0", "T_gamma")
STATIC = ("p0", "area", "approach", "contact_angle", "Y", "X")
MOST_MOMENTS = 6
NEAR = 1.0
"""Distance within which snapshots of two runs are the same place [m]."""
LEAST_DIFFERENCE = 0.2
"""Least span of an axis of differences [%, degrees]."""
LEFT, GAP, TITLES, BENEATH, FOOT = 24.0, 5.0, 8.0, 11.0, 17.0


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
    with style():
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
    lines = [(g, w) for g in range(len(groups)) for w in range(len(wheels))]
    with style():
        figure = new_figure(FULL_WIDTH, 36.0 * len(quantities) + 24.0)
        figure.suptitle(title, x=0.012, ha="left", fontsize=8.5)
        panels = figure.subplots(len(quantities), 2, sharex=True, squeeze=False)
        for row, quantity in zip(panels, quantities, strict=True):
            factor, unit = _difference_unit(quantity)
            for i, name in enumerate(names):
                colour = MODEL_COLOUR[i % len(MODEL_COLOUR)]
                for n, (g, w) in enumerate(lines):
                    member = groups[g][1]
                    options = {"color": colour, "linestyle": GROUP_LINE[n % len(GROUP_LINE)], "lw": 0.9}
                    both = (shown(values, quantity)[i, :, w], factor * values[f"{quantity}_difference"].values[i, :, w])
                    for axes, y in zip(row, both, strict=True):
                        if axes is row[1] and name == reference:
                            continue
                        draw_line(axes, x[member], y[member], marker="" if runs else "o", markersize=1.8, **options)
            channel = CHANNELS[quantity]
            row[0].set_ylabel(f"${channel.symbol}$ [{channel.shown.symbol}]")
            row[1].set_ylabel(f"$\\Delta$ {unit}")
            row[1].axhline(0.0, color=INK, lw=0.6)
            _widen(row[0], 0.02 * max(abs(y) for y in row[0].get_ylim()))
            _widen(row[1], LEAST_DIFFERENCE)
        panels[0, 1].set_title(f'difference from "{reference}"', fontsize=7.0)
        for axes in panels[-1]:
            axes.set_xlabel(CHANNELS[across].label)
        legend = [Line2D([], [], color=MODEL_COLOUR[i % len(MODEL_COLOUR)], label=n) for i, n in enumerate(names)]
        if len(lines) > 1:
            for n, (g, w) in enumerate(lines):
                words = [groups[g][0]] if groups[g][0] else []
                words += [f"{wheels[w]} wheel".strip()] if len(wheels) > 1 else []
                line = GROUP_LINE[n % len(GROUP_LINE)]
                legend.append(Line2D([], [], color=QUIET, linestyle=line, label=", ".join(words)))
        figure.legend(handles=legend, loc="outside lower center", ncols=min(len(legend), 4))
    return figure


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
