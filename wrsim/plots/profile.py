"""Pictures of a profile, with slope and curvature beneath, and of several over each other, with their measures."""

from collections.abc import Sequence
from math import ceil
from textwrap import shorten
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from wrsim.contact.profiles.profile import Profile
from wrsim.errors import InputError
from wrsim.plots import theme
from wrsim.plots.marks import minus, note, remark, right_axis
from wrsim.results.smoothing import SmoothingReport
from wrsim.results.table import Table, formatted, quantity

LINE = "#0072B2"
LEFT, RIGHT, TOP, UNTITLED, BOTTOM, GAP = 15.0, 15.0, 13.0, 5.0, 10.0, 6.0
"""Margins of the figure, the upper one with and without a title, and the gap between panels, mm."""
PANEL, TALLEST = 32.0, 110.0
"""Height of the panels of slope and curvature, largest height of the shape, mm; higher shapes are drawn narrower."""
CURVATURES = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
"""Ticks of curvature on either side of zero, 1/m, and of radius, mm."""


@theme.style()
def profile_figure(profile: Profile, smoothing: Sequence[SmoothingReport] = ()) -> Figure:
    """Shape, slope angle and curvature of a profile against the outward coordinate. smoothing: a report for every
    cut-off, for curvatures over that of the bare points and a panel of the points' distances from smoothed curves."""
    u, w = 1e3 * profile.u, 1e3 * profile.w
    pad = 0.03 * np.ptp(u)
    across, up = float(np.ptp(u) + 2.0 * pad), float(np.ptp(w) + 4.0 * pad)
    width = theme.full_width() - LEFT - RIGHT
    height = width * up / across
    if height > TALLEST:
        across, height = across * height / TALLEST, TALLEST
    rows, top = 3 if smoothing else 2, TOP if theme.caption(profile.name) else UNTITLED
    figure = theme.new_figure(theme.full_width(), top + height + rows * (PANEL + GAP) + BOTTOM, constrained=False)
    theme.headline(figure, f"{profile.name} ({profile.kind})")
    source = shorten(profile.source, int(130 * theme.full_width() / 170.0), placeholder=" ...")
    theme.write_text(figure, 0.012 * theme.full_width(), 6.5, theme.caption(source), fontsize=6.5, color=theme.QUIET)
    panels = [theme.mm_axes(figure, LEFT, top, width, height)]
    for row in range(rows):
        panels[-1].tick_params(axis="x", labelbottom=False)
        panels.append(theme.mm_axes(figure, LEFT, top + height + GAP + row * (PANEL + GAP), width, PANEL))
        panels[-1].sharex(panels[0])
    for axes, draw in zip(panels, (draw_shape, draw_slope, draw_curvature), strict=False):
        draw(profile, axes)
    if smoothing:
        draw_smoothing(smoothing, panels[2], panels[3])
    middle_u, middle_w = 0.5 * (u.min() + u.max()), 0.5 * (w.min() + w.max())
    panels[0].set_xlim(middle_u - 0.5 * across, middle_u + 0.5 * across)
    panels[0].set_ylim(middle_w - 0.5 * up, middle_w + 0.5 * up)
    panels[-1].set_xlabel("Outward u [mm]")
    figure.align_ylabels(panels)
    return figure


FINEST = 0.1  # reading of a gauge: measures that differ by less are drawn beside each other [mm]
ROW, SHEET, NAMES = 4.0, 200.0, 34.0
"""Height of a row of measures, largest height of all, width of names beside them, mm."""


@theme.style()
def profiles_figure(profiles: Sequence[Profile], table: Table, unworn: Profile | None = None) -> Figure:
    """Profiles over each other at equal scales, the unworn one dashed; beneath what was measured of each, a row of the
    table a profile and a panel a column."""
    every = [*profiles, *([unworn] if unworn is not None else [])]
    corner = 1e3 * np.array([min(p.u.min() for p in every), min(p.w.min() for p in every)]) - 2.0
    across, up = (
        1e3 * np.array([max(p.u.max() for p in every), max(p.w.max() for p in every)]) + 2.0 - corner
    ).tolist()
    width = theme.full_width() - LEFT - 4.0
    height = min(width * up / across, TALLEST)
    rows, measures = len(profiles), table.columns[1:]
    sheet = min(ROW * rows, SHEET)
    side = min(len(measures), 2) if theme.full_width() < theme.TWO_COLUMNS else len(measures)
    beneath = (sheet + 12.0) * ceil(len(measures) / max(side, 1))
    top = TOP if theme.caption("title") else UNTITLED + 4.0
    figure = theme.new_figure(theme.full_width(), top + height + BOTTOM + beneath, constrained=False)
    many = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.95, rows))
    colours = many if rows > len(theme.SERIES_COLOURS) else theme.SERIES_COLOURS[:rows]
    title = f"{rows} {profiles[0].kind} profiles" + (f", dashed: {unworn.name}" if unworn is not None else "")
    theme.headline(figure, title)
    shape = theme.mm_axes(figure, LEFT, top - 4.0, width, height)
    for profile, colour in zip(profiles, colours, strict=True):
        shape.plot(1e3 * profile.u, 1e3 * profile.w, color=colour, linewidth=0.8)
    if unworn is not None:
        shape.plot(1e3 * unworn.u, 1e3 * unworn.w, color=theme.INK, linewidth=0.8, linestyle=(0, (4, 2)))
    shape.set(aspect="equal", xlim=(corner[0], corner[0] + across), ylim=(corner[1], corner[1] + up))
    shape.set(xlabel="Outward u [mm]", ylabel="Height w [mm]")
    places = np.arange(rows)
    each = (theme.full_width() - NAMES - 4.0) / max(side, 1)
    for i, column in enumerate(measures):
        below = top + height + 14.0 + (sheet + 12.0) * (i // side)
        axes = theme.mm_axes(figure, NAMES + i % side * each, below, each - 7.0, sheet)
        values = np.array([np.nan if row[i + 1] is None else row[i + 1] for row in table.rows], dtype=float)
        axes.scatter(values, places, c=colours, s=10.0, zorder=3.0, clip_on=False)
        axes.set(ylim=(rows - 0.5, -0.5), title=column.heading)
        names = [shorten(str(row[0]), 26, placeholder="...") for row in table.rows] if i % side == 0 else []
        axes.set_yticks(places, names)
        axes.tick_params(labelsize=min(6.5, 1.6 * sheet / rows))
        axes.xaxis.set_major_locator(theme.InView(3 if side == len(measures) else 2))
        low, high = np.nanmin(values, initial=np.inf), np.nanmax(values, initial=-np.inf)
        if column.unit == "mm" and 0.0 <= high - low < FINEST:
            axes.set_xlim(low - FINEST, high + FINEST)
        axes.margins(x=0.15)
    return figure


def draw_smoothing(smoothing: Sequence[SmoothingReport], curvature: Axes, change: Axes) -> None:
    """Curvature of the bare points, grey, behind that of every cut-off; distance of points from smoothed curves, um."""
    curvature.lines[0].remove()
    first = smoothing[0]
    look: Any = {"color": theme.QUIET, "linewidth": 0.4, "alpha": 0.3, "zorder": 1.0}
    curvature.plot(1e3 * first.points.u, first.bare_curvature, label="bare points", **look)
    for report, colour in zip(smoothing, theme.SERIES_COLOURS, strict=False):
        p, label = report.profile, f"cut-off {1e3 * report.cutoff:g} mm"
        curvature.plot(1e3 * p.u, p.curvature_after, color=colour, linewidth=1.0, label=label)
        change.plot(1e3 * report.points.u, 1e6 * report.change, ".", color=colour, markersize=1.6, zorder=2.0)
    across = 2 if theme.full_width() < theme.TWO_COLUMNS else 5
    curvature.legend(loc="upper center", ncols=across, fontsize=6.5, frameon=True, framealpha=0.9, edgecolor="none")
    remark(curvature, "positive: turns upward; as smoothed, and of a spline through the bare points")
    change.axhline(0.0, color=theme.INK, linewidth=0.5)
    remark(change, "distance of the points from the smoothed curve")
    change.set_ylabel("Change [µm]")


def draw_shape(profile: Profile, axes: Axes) -> None:
    """Outline with its material at equal scales, mm; origin, and on rails the top and the gauge point."""
    u, w = 1e3 * profile.u, 1e3 * profile.w
    reach = 10.0 * np.ptp(w) + 10.0
    beyond = w.max() + reach if profile.kind == "wheel" else w.min() - reach
    fill = theme.WHEEL_FILL if profile.kind == "wheel" else theme.RAIL_FILL
    axes.fill(np.pad(u, 1, "edge"), np.pad(w, 1, constant_values=beyond), facecolor=fill, edgecolor="none")
    axes.plot(u, w, color=theme.INK, linewidth=1.2)
    axes.plot([0.0], [0.0], "+", color=theme.INK, markersize=7.0, markeredgewidth=0.8)
    if profile.kind == "rail":
        _gauge(profile, axes)
    axes.set_aspect("equal")
    axes.set_xlim(u.min(), u.max())
    axes.set_ylim(w.min(), w.max())
    axes.yaxis.set_major_locator(theme.InView(7, steps=[1, 2, 5, 10]))
    axes.set_ylabel("Height w [mm]")


def _gauge(profile: Profile, axes: Axes) -> None:
    """Mark top and gauge point and their distance, if the rail is deep enough to have one."""
    try:
        (u, w), (top_u, top_w) = profile.gauge_point(), profile.top
    except InputError:
        return
    u, w, top_u, top_w = (1e3 * x for x in (u, w, top_u, top_w))
    axes.plot([u, top_u], [w, top_w], "o", color=LINE, markersize=3.5, zorder=3.0)
    for x, y in (([u, u], [w, top_w]), ([u, top_u], [top_w, top_w])):
        axes.plot(x, y, color=LINE, linewidth=0.6, linestyle=(0, (4, 2)))
    depth, inside = quantity(1e3 * profile.gauge_depth, "mm", "g"), quantity(top_u - u, "mm", ".3f")
    label = f"gauge point, {depth} below\nand {inside} inside of the top"
    note(axes, label, (u, w), (6.0, 0.0), va="center", color=LINE)


def draw_slope(profile: Profile, axes: Axes) -> None:
    """Tangent angle against u, degrees, positive where the profile rises outward."""
    axes.plot(1e3 * profile.u, np.degrees(profile.angle), color=LINE)
    axes.axhline(0.0, color=theme.INK, linewidth=0.5)
    low, high = float(np.degrees(profile.angle.min())), float(np.degrees(profile.angle.max()))
    if (steep := high - low > 60.0) or high - low < 1e-6:
        space = 6.0 if steep else 1.0
        axes.set_ylim(min(low, 0.0) - space, max(high, 0.0) + space)
    if steep:
        axes.yaxis.set_major_locator(MultipleLocator(30.0))
    axes.set_ylabel("Slope angle [°]")
    remark(axes, "positive: rises outward")


def draw_curvature(profile: Profile, axes: Axes) -> None:
    """Signed curvature against u, 1/m, on a scale that is linear near zero; the radius in mm at the right."""
    u = np.repeat(1e3 * profile.u, 2)
    k = np.column_stack([profile.curvature_before, profile.curvature_after]).ravel()
    axes.plot(u, k, color=LINE)
    axes.axhline(0.0, color=theme.INK, linewidth=0.5)
    axes.set_yscale("asinh", linear_width=1.0)
    reach = [next((c for c in CURVATURES if c >= side), CURVATURES[-1]) for side in (-k.min(), k.max())]
    every = 1 if max(reach) <= 100.0 else 2  # thin out the ticks of a long scale
    curvatures = CURVATURES[::every]
    ticks = [-c for c in curvatures if c <= reach[0]] + [0.0] + [c for c in curvatures if c <= reach[1]]
    axes.set_yticks(ticks, [minus(f"{c:g}") for c in ticks])
    right = right_axis(axes)
    right.set_yscale("asinh", linear_width=1.0)
    radii = [sign * 1e3 / r for r in curvatures for sign in (-1.0, 1.0) if 1e3 / r <= max(reach)]
    right.set_yticks(radii, [formatted(1e3 / abs(c), ".0f") for c in radii])
    for axis in (axes, right):
        axis.minorticks_off()
        axis.set_ylim(-1.4 * reach[0], 1.4 * reach[1])
    right.set_ylabel("Radius [mm]")
    remark(axes, "positive: turns upward")
    axes.set_ylabel("Curvature [1/m]")
