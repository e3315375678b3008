"""Pictures of a track: plan view; curvature, cant, gauge, height and irregularities against distance."""

from collections.abc import Callable
from functools import partial
from itertools import groupby, pairwise
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.markers import MarkerStyle
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

from wrsim.plots.marks import note, note_above
from wrsim.plots.theme import CANT_COLOUR, INK, QUIET, WHEEL_COLOUR, InView, full_width, new_figure, style
from wrsim.results.channels import SHOWN
from wrsim.results.table import quantity
from wrsim.results.units import converted
from wrsim.track.track import Feature, Track

Law = Callable[[NDArray[np.float64]], NDArray[np.float64]]

KIND_COLOUR = {"straight": INK, "transition": "#E69F00", "arc": "#009E73", "table": INK}
"""Line of a segment in the plan view; Okabe and Ito's set, as all pictures."""
KIND_SHADE = {"straight": "none", "transition": "#fbf1da", "arc": "#e3f1ec", "table": "none"}
"""Background of a segment against distance."""
SAMPLES, TABLE_STEP, IRREGULARITY_STEP = 400, 0.5, 0.25
"""Points a segment; distance of the points of measured track, and of irregularities [m]."""


@style()
def track_figure(track: Track) -> Figure:
    """Plan view above curvature, cant, gauge, height and grade, and irregularities against distance. A level track has
    no panel of height, an even one none of irregularities."""
    draws: list[Callable[[Axes, Track], object]] = [partial(_law, look=law) for law in LAWS]
    draws += [] if track.lift is None else [rail_heights]
    draws += [] if track.centre_line.pitch_law.is_zero else [height]
    draws += [partial(irregularity, way=way) for way in ("vertical", "lateral")] if track.is_uneven else []
    figure = new_figure(full_width(), 84.0 + 27.0 * len(draws))
    grid = figure.add_gridspec(1 + len(draws), 1, height_ratios=(2.6, *(1.0 for _ in draws)))
    plan_view(figure.add_subplot(grid[0]), track)
    panels: list[Axes] = []
    for k, draw in enumerate(draws, 1):
        panels.append(figure.add_subplot(grid[k], sharex=panels[0] if panels else None))
        draw(panels[-1], track)
        panels[-1].tick_params(axis="x", labelbottom=k == len(draws))
    for feature in track.features():
        share = (feature.end - feature.start) / track.length
        if share > 0.0085 * len(feature.label):  # a letter is about 0.85 % of the panel's width
            note_above(panels[0], feature.label, 0.5 * (feature.start + feature.end), lift=3.0)
    panels[-1].set_xlabel("Distance along the centre line [m]")
    panels[0].set_xlim(0.0, track.length)
    figure.align_ylabels(panels)
    return figure


def plan_view(axes: Axes, track: Track) -> None:
    """Centre line from above at equal scales: one colour a kind of segment, distances beside it."""
    drawn: set[str] = set()
    for feature in track.features():
        x, y, _ = track.centre_line.position(_samples(feature)).T
        label = feature.kind if feature.kind not in drawn else "_more"
        drawn.add(feature.kind)
        axes.plot(x, y, color=KIND_COLOUR[feature.kind], linewidth=2.0, solid_capstyle="butt", label=label)

    joints = np.array([feature.start for feature in track.features()[1:]])
    points = track.centre_line.position(joints)
    axes.plot(points[:, 0], points[:, 1], "o", color="white", markeredgecolor=INK, markersize=3.0, zorder=3.0)
    for s, shape, size in ((0.0, _ARROW, 15.0), (track.length, "|", 9.0)):
        x, y, _ = track.centre_line.position(s)
        marker = MarkerStyle(shape, transform=Affine2D().rotate(float(track.heading(s))))
        axes.plot(x, y, marker=marker, color=INK, markersize=size, zorder=3.0)

    shown = converted(SHOWN["m"])
    marks = np.asarray(MaxNLocator(nbins=8, steps=[1, 2, 5, 10]).tick_values(0.0, shown.factor * track.length))
    ticks = marks[(marks >= 0.0) & (marks <= shown.factor * track.length)] / shown.factor
    for s, (x, y, _), turn in zip(ticks, track.centre_line.position(ticks), track.heading(ticks), strict=True):
        across = np.array((-np.sin(turn), np.cos(turn)))
        label = f"{s:g} {shown.symbol}" if s == 0.0 else f"{s * shown.factor:.6g}"
        note(axes, label, (x, y), tuple(9.0 * across), ha="center", va="center")
        note(axes, "", (x, y), tuple(4.5 * across), arrowprops=_TICK, zorder=2.0)

    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.06, 0.2)
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.legend(loc="best", ncols=len(drawn))


LAWS = (
    ("curvature", INK, 1.0, "Curvature\n[1/km]"),
    ("cant", CANT_COLOUR, 20.0, "Cant [mm]\n(+ right rail up)"),
    ("gauge", INK, 10.0, "Gauge\n[mm]"),
)
"""Laws of a track against distance: colours, smallest spans of the axes, labels."""


def _law(axes: Axes, track: Track, look: tuple[str, str, float, str]) -> None:
    """One of ``LAWS``, a thin line at its usual value; a jump is a vertical line."""
    law, colour, least, label = look
    _against_distance(axes, track, lambda s: 1e3 * getattr(track, law)(s), colour, least)
    axes.axhline(1e3 * track.nominal_gauge if law == "gauge" else 0.0, color=QUIET, linewidth=0.5, zorder=1.5)
    axes.ticklabel_format(axis="y", useOffset=False)
    axes.set_ylabel(label)


def rail_heights(axes: Axes, track: Track) -> None:
    """Designed heights of both rail tops above the grade line, where the cant does not turn about the centre line."""

    def top(side: int, s: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1e3 * track.rail_heights(s)[side]

    for k, side in enumerate(("left", "right")):
        _against_distance(axes, track, partial(top, k), WHEEL_COLOUR[side], 20.0)
        axes.lines[-1].set_label(f"{side} rail")
    axes.legend(loc="best", ncols=2, fontsize=6.5)
    axes.set_ylabel("Rails above grade\nline [mm]")


def height(axes: Axes, track: Track) -> None:
    """Height of the centre line; grades per thousand are written along it."""
    _against_distance(axes, track, lambda s: track.centre_line.position(s)[:, 2], INK, 1.0)
    law = track.centre_line.pitch_law

    def constant(piece: tuple[float, float]) -> float | None:
        slopes = 1e3 * np.tan(law(np.linspace(*piece, 4)))
        return round(float(slopes[0]), 3) if np.ptp(slopes) < 1e-3 else None

    for grade, pieces in groupby(pairwise(law.breaks.tolist()), constant):  # the law has breaks at joints of the plan
        start, *_, end = (place for piece in pieces for place in piece)
        if grade is not None and end - start > 0.06 * track.length:
            middle = 0.5 * (start + end)
            point = middle, float(track.centre_line.position(middle)[2])
            note(axes, "+" * (grade >= 0.0) + quantity(grade, "‰", ".3g"), point, (0.0, 7.0), ha="center")
    axes.set_ylabel("Height\n[m]")


def irregularity(axes: Axes, track: Track, way: Literal["lateral", "vertical"]) -> None:
    """How far both rails lie to the left of their designed place, or above it."""
    s = np.arange(0.0, track.length, IRREGULARITY_STEP)
    sides: tuple[Literal["left", "right"], ...] = ("left", "right")
    for side in sides:
        values = 1e3 * track.irregularity(side, s)[int(way == "vertical")]
        axes.plot(s, values, color=WHEEL_COLOUR[side], linewidth=0.6, label=f"{side} rail")
    _limits(axes, 1.0)
    axes.legend(loc="upper right", ncols=2, fontsize=6.5)
    axes.set_ylabel("Vertical\n[mm]" if way == "vertical" else "Lateral\n[mm] (+ left)")


_ARROW = Path([(-1.6, 0.6), (0.0, 0.0), (-1.6, -0.6), (-1.6, 0.6)])  # tip at the start of the track
_TICK = {"arrowstyle": "-", "color": QUIET, "linewidth": 0.5, "shrinkA": 0.0, "shrinkB": 0.0}


def _samples(feature: Feature) -> NDArray[np.float64]:
    """Distances along one segment, its end a hair before the joint."""
    span = feature.end - feature.start
    count = SAMPLES if feature.kind != "table" else max(SAMPLES, int(span / TABLE_STEP))
    return feature.start + span * np.append(np.arange(count) / count, 1.0 - 1e-9)


def _against_distance(axes: Axes, track: Track, function: Law, colour: str, least: float) -> None:
    """Line of a function of distance above the shaded segments; least: see `_limits`."""
    for feature in track.features():
        axes.axvspan(feature.start, feature.end, color=KIND_SHADE[feature.kind], linewidth=0.0, zorder=0.0)
    s = np.concatenate([_samples(feature) for feature in track.features()])
    axes.plot(s, function(s), color=colour)
    _limits(axes, least)


def _limits(axes: Axes, least: float) -> None:
    """Room above and below the line; a range of at least ``least`` for a constant."""
    axes.autoscale_view()
    low, high = axes.dataLim.y0, axes.dataLim.y1
    if high - low < 1e-9 * least:
        low, high = low - 0.5 * least, high + 0.5 * least
    space = 0.12 * (high - low)
    axes.set_ylim(low - space, high + space)
    axes.yaxis.set_major_locator(InView(4))
