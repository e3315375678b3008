"""A vehicle from the side, from behind and from above; loops of stationary tests of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyBboxPatch, Rectangle

from wrsim.plots.colours import FAINT, INK, QUIET, RAIL_FILL, WHEEL_FILL
from wrsim.plots.marks import panels
from wrsim.plots.style import FULL_WIDTH, new_figure, place, style

Triple = tuple[float, float, float]

MARGIN, GAP, TITLE, FOOT = 14.0, 9.0, 12.0, 14.0
"""mm."""


@dataclass(frozen=True)
class BoxSketch:
    """A body as a box: centre and edges [m]."""

    name: str
    centre: Triple
    size: Triple


@dataclass(frozen=True)
class WheelSketch:
    """A wheel: centre, radius, width [m]."""

    centre: Triple
    radius: float
    width: float = 0.13


@dataclass(frozen=True)
class ElementSketch:
    """A suspension element: kind, its two ends [m], mark and its colour, whether the mark is hollow."""

    kind: str
    ends: tuple[Triple, Triple]
    mark: str
    colour: str
    hollow: bool = False


@dataclass(frozen=True)
class VehicleSketch:
    """What is drawn of a vehicle, in its axes; points are marked with a cross."""

    name: str
    boxes: Sequence[BoxSketch]
    wheels: Sequence[WheelSketch]
    elements: Sequence[ElementSketch]
    points: Sequence[Triple] = ()


VIEWS = {"from the side": (0, 2), "from behind": (1, 2), "from above": (0, 1)}
"""Horizontal and vertical axis of every view."""


def vehicle_view(axes: Axes, sketch: VehicleSketch, view: str) -> Axes:
    """Draw one of ``VIEWS``."""
    h, v = VIEWS[view]
    sign = -1.0 if view == "from behind" else 1.0  # y runs to the left
    for box in sorted(sketch.boxes, key=lambda b: -b.size[h] * b.size[v]):
        width, height = box.size[h], box.size[v]
        corner = (sign * box.centre[h] - 0.5 * width, box.centre[v] - 0.5 * height)
        look: Any = {"facecolor": RAIL_FILL, "edgecolor": QUIET, "linewidth": 0.7, "alpha": 0.8}
        axes.add_patch(FancyBboxPatch(corner, width, height, "round,pad=0,rounding_size=0.06", **look))
        axes.plot(sign * box.centre[h], box.centre[v], marker="+", color=INK, markersize=5.0, markeredgewidth=0.7)
    for wheel in sketch.wheels:
        x, y = sign * wheel.centre[h], wheel.centre[v]
        if view == "from the side":
            axes.add_patch(Circle((x, y), wheel.radius, facecolor=WHEEL_FILL, edgecolor=INK, linewidth=0.6))
        else:
            width = wheel.width if h == 1 else 2.0 * wheel.radius
            height = wheel.width if v == 1 else 2.0 * wheel.radius
            corner = (x - 0.5 * width, y - 0.5 * height)
            axes.add_patch(Rectangle(corner, width, height, facecolor=WHEEL_FILL, edgecolor=INK, linewidth=0.6))
    for element in sketch.elements:
        ends = np.array(element.ends)
        axes.plot(sign * ends[:, h], ends[:, v], color=element.colour, linewidth=1.0, solid_capstyle="round")
        middle = ends.mean(axis=0)
        size = 4.6 if element.hollow else 2.2
        axes.plot(sign * middle[h], middle[v], markersize=size, markeredgewidth=0.7, **_mark(element))
    for point in sketch.points:
        axes.plot(sign * point[h], point[v], marker="x", color=QUIET, markersize=3.5, markeredgewidth=0.7)
    if v == 2:
        axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.set_aspect("equal")
    axes.set_title(view)
    axes.set(xlabel="xyz"[h] + " [m]" if h == 0 else "y [m]", ylabel="xyz"[v] + " [m]")
    axes.grid(True, color=FAINT)
    return axes


@style()
def vehicle_figure(sketch: VehicleSketch) -> Figure:
    """All three views on one scale."""
    low, high = _extent(sketch)
    length, width, height = high - low
    scale = (FULL_WIDTH - 2.0 * MARGIN - GAP - 8.0) / (length + width)
    rows = (height * scale, width * scale)
    figure = new_figure(FULL_WIDTH, TITLE + rows[0] + GAP + 8.0 + rows[1] + FOOT, constrained=False)
    places = {
        "from the side": (MARGIN, TITLE, length * scale, rows[0]),
        "from behind": (MARGIN + length * scale + GAP + 4.0, TITLE, width * scale, rows[0]),
        "from above": (MARGIN, TITLE + rows[0] + GAP + 8.0, length * scale, rows[1]),
    }
    for view, where in places.items():
        h, v = VIEWS[view]
        axes = place(figure, *where)
        vehicle_view(axes, sketch, view)
        ends = (-high[1], -low[1]) if h == 1 else (low[h], high[h])
        axes.set_xlim(*ends)
        axes.set_ylim(low[v], high[v])
        if h == 1:
            ticks = np.arange(np.ceil(low[1]), np.floor(high[1]) + 0.5)
            axes.set_xticks(-ticks, [f"{t:g}" for t in ticks])
            axes.set(xlabel="y [m]", ylabel="")
    kinds = {element.kind: element for element in reversed(sketch.elements)}
    handles = [Line2D([], [], markersize=4.0, label=kind, **_mark(e)) for kind, e in reversed(kinds.items())]
    figure.legend(handles=handles, loc="lower right", ncols=1, frameon=False, fontsize=7.0)
    figure.suptitle(sketch.name, x=MARGIN / FULL_WIDTH, ha="left", fontsize=9.0)
    return figure


def _mark(element: ElementSketch) -> dict[str, Any]:
    face = "none" if element.hollow else element.colour
    return {"marker": element.mark, "color": element.colour, "linestyle": "none", "markerfacecolor": face}


def _extent(sketch: VehicleSketch) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest coordinates of everything, with a margin."""
    corners = [np.array(b.centre) + s * 0.5 * np.array(b.size) for b in sketch.boxes for s in (-1.0, 1.0)]
    corners += [np.array(w.centre) + s * w.radius for w in sketch.wheels for s in (-1.0, 1.0)]
    corners += [np.array(end) for e in sketch.elements for end in e.ends]
    low, high = np.min(corners, axis=0) - 0.3, np.max(corners, axis=0) + 0.3
    low[2] = -0.15
    return low, high


@dataclass(frozen=True)
class Loop:
    """Lines (label, x, y) of one panel, and what stands at its axes."""

    x: str
    y: str
    lines: Sequence[tuple[str, Any, Any]]


def loops_figure(title: str, loops: Sequence[Loop]) -> Figure:
    """Loops of stationary tests beside each other: wheel loads over the twist, moment over the angle of a bogie."""

    def draw(axes: Axes, loop: Loop) -> None:
        for label, x, y in loop.lines:
            axes.plot(x, y, label=label)
        axes.set(xlabel=loop.x, ylabel=loop.y)
        axes.legend(fontsize=6.5)

    return panels(title, [partial(draw, loop=loop) for loop in loops], 80.0, columns=len(loops), share=False)
