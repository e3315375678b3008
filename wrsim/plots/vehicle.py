"""A vehicle from the side, from behind and from above; loops of stationary tests of it."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyBboxPatch, Rectangle

from wrsim.plots import theme
from wrsim.plots.marks import panels
from wrsim.vehicle.couplings import GLYPHS
from wrsim.vehicle.element_tables import KINDS, Glyph
from wrsim.vehicle.elements import Element
from wrsim.vehicle.vehicle import Vehicle

MARGIN, GAP, TITLE, FOOT = 14.0, 9.0, 12.0, 14.0  # mm
WHEEL_WIDTH = 0.13  # m
VIEWS = {"from the side": (0, 2), "from behind": (1, 2), "from above": (0, 1)}
"""Horizontal and vertical axis of every view."""


def vehicle_view(axes: Axes, vehicle: Vehicle, view: str) -> None:
    """Draw one of ``VIEWS``: bodies as the boxes of equal mass and inertia, wheels, elements, points as crosses."""
    h, v = VIEWS[view]
    sign = -1.0 if view == "from behind" else 1.0  # y runs to the left
    for body in sorted(vehicle.bodies, key=lambda b: -b.box[h] * b.box[v]):
        width, height = body.box[h], body.box[v]
        corner = (sign * body.centre[h] - 0.5 * width, body.centre[v] - 0.5 * height)
        look: Any = {"facecolor": theme.RAIL_FILL, "edgecolor": theme.QUIET, "linewidth": 0.7, "alpha": 0.8}
        axes.add_patch(FancyBboxPatch(corner, width, height, "round,pad=0,rounding_size=0.06", **look))
        axes.plot(
            sign * body.centre[h], body.centre[v], marker="+", color=theme.INK, markersize=5.0, markeredgewidth=0.7
        )
    for centre, radius in _wheels(vehicle):
        x, y = sign * centre[h], centre[v]
        look = {"facecolor": theme.WHEEL_FILL, "edgecolor": theme.INK, "linewidth": 0.6}
        if view == "from the side":
            axes.add_patch(Circle((x, y), radius, **look))
        else:
            width, height = (WHEEL_WIDTH if axis == 1 else 2.0 * radius for axis in (h, v))
            axes.add_patch(Rectangle((x - 0.5 * width, y - 0.5 * height), width, height, **look))
    for element, glyph in _drawn_elements(vehicle):
        ends = np.array(element.points)
        axes.plot(sign * ends[:, h], ends[:, v], color=glyph.colour, linewidth=1.0, solid_capstyle="round")
        middle = ends.mean(axis=0)
        size = 4.6 if glyph.hollow else 2.2
        axes.plot(sign * middle[h], middle[v], markersize=size, markeredgewidth=0.7, **_mark(glyph))
    for point in vehicle.points:
        axes.plot(sign * point.at[h], point.at[v], marker="x", color=theme.QUIET, markersize=3.5, markeredgewidth=0.7)
    if v == 2:
        axes.axhline(0.0, color=theme.INK, linewidth=0.8)
    axes.set_aspect("equal")
    axes.set_title(view)
    axes.set(xlabel="xyz"[h] + " [m]" if h == 0 else "y [m]", ylabel="xyz"[v] + " [m]")
    axes.grid(True, color=theme.FAINT)


@theme.style()
def vehicle_figure(vehicle: Vehicle) -> Figure:
    """All three views on one scale."""
    low, high = _extent(vehicle)
    length, width, height = high - low
    scale = (theme.full_width() - 2.0 * MARGIN - GAP - 8.0) / (length + width)
    rows, top = (height * scale, width * scale), TITLE + theme.head_height(vehicle.name, "", theme.full_width())
    figure = theme.new_figure(theme.full_width(), top + rows[0] + GAP + 8.0 + rows[1] + FOOT, constrained=False)
    places = (
        (MARGIN, top, length * scale, rows[0]),
        (MARGIN + length * scale + GAP + 4.0, top, width * scale, rows[0]),
        (MARGIN, top + rows[0] + GAP + 8.0, length * scale, rows[1]),
    )
    for view, where in zip(VIEWS, places, strict=True):
        h, v = VIEWS[view]
        axes = theme.mm_axes(figure, *where)
        vehicle_view(axes, vehicle, view)
        axes.set(xlim=(-high[1], -low[1]) if h == 1 else (low[h], high[h]), ylim=(low[v], high[v]))
        if h == 1:
            ticks = np.arange(np.ceil(low[1]), np.floor(high[1]) + 0.5)
            axes.set_xticks(-ticks, [f"{t:g}" for t in ticks])
            axes.set(xlabel="y [m]", ylabel="")
    kinds = {element.kind: glyph for element, glyph in _drawn_elements(vehicle)}
    handles = [Line2D([], [], markersize=4.0, label=kind, **_mark(glyph)) for kind, glyph in kinds.items()]
    figure.legend(handles=handles, loc="lower right", ncols=1, frameon=False, fontsize=7.0)
    figure.suptitle(theme.caption(vehicle.name), x=MARGIN / theme.full_width(), ha="left", fontsize=9.0)
    return figure


def _wheels(vehicle: Vehicle) -> list[tuple[tuple[float, float, float], float]]:
    return [
        ((mounted.x, side * 0.5 * mounted.wheelset.profile_spacing, mounted.height), wheel.radius)
        for mounted in vehicle.wheelsets
        for side, wheel in ((1.0, mounted.wheelset.left), (-1.0, mounted.wheelset.right))
    ]


def _drawn_elements(vehicle: Vehicle) -> list[tuple[Element, Glyph]]:
    known = {kind: table.glyph for kind, table in KINDS.items()} | GLYPHS
    pairs = ((element, known[element.kind]) for element in vehicle.elements)
    return [(element, glyph) for element, glyph in pairs if glyph is not None]


def _mark(glyph: Glyph) -> dict[str, Any]:
    face = "none" if glyph.hollow else glyph.colour
    return {"marker": glyph.mark, "color": glyph.colour, "linestyle": "none", "markerfacecolor": face}


def _extent(vehicle: Vehicle) -> tuple[np.ndarray, np.ndarray]:
    corners = [np.array(b.centre) + s * 0.5 * np.array(b.box) for b in vehicle.bodies for s in (-1.0, 1.0)]
    corners += [np.array(centre) + s * radius for centre, radius in _wheels(vehicle) for s in (-1.0, 1.0)]
    corners += [np.array(end) for element, _ in _drawn_elements(vehicle) for end in element.points]
    low, high = np.min(corners, axis=0) - 0.3, np.max(corners, axis=0) + 0.3
    low[2] = -0.15
    return low, high


def loops_figure(title: str, loops: Sequence[tuple[str, str, Sequence[tuple[str, Any, Any]]]]) -> Figure:
    """Loops of stationary tests beside each other: wheel loads over the twist, moment over the angle of a bogie. loops:
    labels of both axes and lines (label, x, y) of every panel."""

    def draw(axes: Axes, xlabel: str, ylabel: str, lines: Sequence[tuple[str, Any, Any]]) -> None:
        for label, x, y in lines:
            axes.plot(x, y, label=label)
        axes.set(xlabel=xlabel, ylabel=ylabel)
        axes.legend(fontsize=6.5)

    draws = [partial(draw, xlabel=x, ylabel=y, lines=lines) for x, y, lines in loops]
    return panels(title, draws, 80.0, columns=len(loops), share=False)


def campbell_figure(title: str, axles: Sequence[Mapping[str, Any]]) -> Figure:
    """Natural frequencies of free axles over the speed, a panel for each: modes that whirl backward and forward.
    axles: numbers of ``campbell``."""

    def draw(axes: Axes, axle: Mapping[str, Any]) -> None:
        for way, look in (("backward", "--"), ("forward", "-")):
            for k, frequencies in enumerate(np.array(axle[f"{way}_Hz"]).T):
                label = way if k == 0 else None
                axes.plot(
                    axle["speed_kmh"],
                    frequencies,
                    look,
                    color=theme.SERIES_COLOURS[k % len(theme.SERIES_COLOURS)],
                    label=label,
                )
        axes.set(xlabel="speed [km/h]", ylabel="frequency [Hz]", ylim=(0.0, None), title=axle["wheelset"])
        axes.legend()

    return panels(title, [partial(draw, axle=axle) for axle in axles], 90.0, columns=len(axles), share=False)
