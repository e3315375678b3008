"""Pictures of an assessment: utilisation of each limit, signals against distance, values estimated by influences."""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import cycle, product
from math import ceil
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wrsim.assessment.outcome import INFLUENCES, AssessedSection, Assessment, Value, ZoneValue
from wrsim.plots.histories import mark_snapshots, track_layout
from wrsim.plots.marks import mark_stop, note, note_above, panels, wheel_entries
from wrsim.plots.theme import FAINT, GROUP_LINE, INK, QUIET, STOP_COLOUR, WHEEL_COLOUR
from wrsim.results.summary import events
from wrsim.results.table import formatted, quantity, with_unit
from wrsim.results.units import converted
from wrsim.results.wheelsets import numbered, of_wheelset, wheelsets

ZONE_SHADE = {
    "straight": "none", "transition": "#fbf1da", "large radius": "#eef6f2", "small radius": "#e3f1ec",
    "very small radius": "#d3e8e0", "tight": "#c0ddd1",
}  # fmt: skip
"""Background of a class of track against distance."""
WITHIN, BEYOND = "#0072B2", "#D55E00"
NADAL_LINE: dict[str, Any] = {"linestyle": (0, (4, 2))}
MOST = 1.5  # part of a limit at which bars and points are cut off


def assessment_figures(assessment: Assessment) -> dict[str, Callable[[], Figure]]:
    """Makers of the pictures of an assessment, by file name without ending; histories of several runs are numbered."""
    figures: dict[str, Callable[[], Figure]] = {}
    if any(v.limit is not None for v in assessment.values):
        figures["assessment"] = partial(limits_figure, assessment)
    for i, run in enumerate(assessment.signals, 1):
        figures[f"assessment_history_{i}" if run else "assessment_history"] = partial(history_figure, assessment, run)
    if estimated(assessment):
        figures["assessment_estimates"] = partial(estimates_figure, assessment)
    return figures


def limits_figure(assessment: Assessment) -> Figure:
    """For every quantity with a limit and every class of track: all sections as points, the worst as a bar."""
    rows = [(zone.worst, zone.worst.limit) for zone in assessment.zones if zone.worst.limit is not None]
    clear = max(1.0, *(min(1.0 - (worst.margin or 0.0), MOST) for worst, _ in rows))  # of bars and of the line at 1

    def draw(axes: Axes) -> None:
        for i, (worst, limit) in enumerate(rows):
            unit, zone = converted(worst.quantity.shown), worst.section.zone
            values = [v for v in assessment.of(worst.quantity.key) if v.section.zone == zone]
            used = np.array([1.0 - v.margin for v in values if v.margin is not None])
            most = float(np.nanmax(used))
            fill, letters = (BEYOND, STOP_COLOUR) if most > 1.0 else (WITHIN, QUIET)
            axes.barh(i, min(most, MOST), height=0.62, color=fill, alpha=0.35, linewidth=0.0, zorder=2.0)
            axes.plot(np.clip(used, 0.0, MOST), np.full(used.size, i), ".", color=fill, markersize=3.0, zorder=3.0)
            label = (
                f"{formatted(worst.value * unit.factor, '.3g')} {'of at least' if worst.quantity.lowest else 'of'} "
                f"{quantity(limit.value * unit.factor, unit.unit, '.3g')}"
            )
            label += f", {worst.where}"
            note(axes, label, (clear, i), (4.0, 0.0), va="center", fontsize=6.3, color=letters)
        axes.set_yticks(range(len(rows)), [f"{worst.quantity.symbol}   {worst.section.zone}" for worst, _ in rows])
        axes.axvline(1.0, color=INK, linewidth=0.9, zorder=2.5)
        axes.set(xlim=(0.0, 1.75 * clear), ylim=(len(rows) - 0.4, -0.6), xlabel="Utilisation")
        axes.grid(axis="y", visible=False)

    explanation = "Utilisation of the limits. Bar: worst; points: every section, wheelset and wheel"
    return panels(f"{assessment.title}\n{explanation}", [draw], 26.0 + 4.6 * len(rows))


HISTORIES = {
    "sum_Y": ("ΣY, {low_pass_Hz:g} Hz, {window_m:g} m\n[kN]", 1e-3, ("sum_Y",)),
    "Y_over_Q": ("Y/Q, {low_pass_Hz:g} Hz, {window_m:g} m", 1.0, ("Y_over_Q", "Y_over_Q_nadal")),
    "Q": ("Q, {low_pass_Hz:g} Hz\n[kN]", 1e-3, ("Q",)),
    "Y": ("Y, {low_pass_Hz:g} Hz\n[kN]", 1e-3, ("Y_qst", "Y_qst_reduced")),
}
"""Signals of the history: label, factor, quantities whose limits are drawn."""


def history_figure(assessment: Assessment, run: str = "") -> Figure:
    """Sum Y, Y/Q, Q and Y of a run as they were evaluated, with their limits, over shaded sections."""
    signals, sections = assessment.signals[run], [s for s in assessment.sections if s.run == run]
    place = signals["place"].values
    wheels: Any = ([(INK, None)], list(zip(WHEEL_COLOUR.values(), (0, 1), strict=True)))

    def draw(axes: Axes, name: str) -> None:
        label, factor, quantities = HISTORIES[name]
        shade_sections(axes, sections)
        for (i, history), (colour, j) in product(enumerate(signals[name].values), wheels[signals[name].ndim - 2]):
            values = history if j is None else history[:, j]
            values = np.where(np.isfinite(values), values, np.nan) * factor
            axes.plot(place, values, color=colour, linestyle=GROUP_LINE[i % len(GROUP_LINE)], linewidth=0.9)
        limited = [v for quantity in quantities for v in assessment.of(quantity) if v.section.run == run]
        _draw_limits(axes, limited, factor, two_sided=name == "sum_Y")
        axes.set(
            xlabel="Distance along the track [m]", ylabel=label.format(**signals.attrs), xlim=(place[0], place[-1])
        )
        last, whole = -np.inf, sections[-1].end - sections[0].start
        for s in sections if name == "sum_Y" else ():
            if (middle := 0.5 * (s.start + s.end)) - last >= 0.02 * whole:  # where they are narrow, every few only
                note_above(axes, str(s.number), last := middle)

    legend, names = wheel_entries(), [str(name) for name in signals["wheelset"].values]
    for label, line in zip(numbered(names).values() if len(names) > 1 else (), cycle(GROUP_LINE)):
        legend.append(Line2D([], [], color=INK, linestyle=line, label=f"wheelset {label}"))
    legend.append(Line2D([], [], color=STOP_COLOUR, linewidth=0.9, label="limit"))
    if any(v.limit is not None for v in assessment.of("Y_over_Q_nadal")):
        legend.append(Line2D([], [], color=STOP_COLOUR, linewidth=0.9, label="limit of Nadal", **NADAL_LINE))
    title = f"{assessment.title}\nrun {run}" if run else assessment.title
    return panels(title, [partial(draw, name=name) for name in HISTORIES], 34.0 * len(HISTORIES) + 24.0, legend=legend)


def track_diagram(dataset: xr.Dataset, sections: Sequence[AssessedSection]) -> Figure:
    """Curvature and cant of a run over its sections; letters: its snapshots, red: events and where it stopped."""
    first = of_wheelset(dataset, wheelsets(dataset)[0])
    place = first["distance"].values

    def draw(axes: Axes) -> None:
        shade_sections(axes, sections)
        for s in sections:
            share = (min(s.end, place[-1]) - max(s.start, place[0])) / np.ptp(place)
            short = s.label.partition(", ")[2].rpartition(" m ")[0] or s.label
            label = next((w for w in (s.label, short, str(s.number)) if 0.009 * len(w) < share), "")
            note_above(axes, label, 0.5 * (max(s.start, place[0]) + min(s.end, place[-1])), lift=8.0)
        track_layout(axes, first)
        mark_snapshots(axes, first)
        mark_stop(axes, first)
        for _, event, _ in events(dataset):
            axes.axvline(event, color=STOP_COLOUR, linewidth=1.0)
        axes.set_xlim(place[0], place[-1])

    return panels("", [draw], 42.0)


def _draw_limits(axes: Axes, values: Sequence[Value], factor: float, *, two_sided: bool) -> None:
    """Limits as red lines over their sections, where the picture stays readable with them; else in words."""
    limits = [(v.section, v.limit.value * factor, "nadal" in v.quantity.key) for v in values if v.limit is not None]
    reach = max(abs(y) for y in axes.get_ylim())
    least = min((limit for _, limit, _ in limits), default=0.0)
    if least > 6.0 * reach:
        corner: Any = {"xycoords": "axes fraction", "ha": "right", "va": "bottom", "color": STOP_COLOUR}
        shown = values[0].quantity.shown
        label = f"limit {'±' if two_sided else ''}{formatted(least / shown.factor * converted(shown).factor, '.3g')}"
        note(axes, label, (1.0, 1.0), (0.0, 1.5), **corner)
        return
    for section, limit, nadal in limits:
        for y in (limit, -limit) if two_sided else (limit,):
            look = NADAL_LINE if nadal else {}
            axes.plot([section.start, section.end], [y, y], color=STOP_COLOUR, linewidth=0.9, zorder=2.2, **look)


def shade_sections(axes: Axes, sections: Sequence[AssessedSection]) -> None:
    """Background by class of track, a fine line between sections."""
    for s in sections:
        axes.axvspan(
            s.start, s.end, color=ZONE_SHADE.get(s.zone, ZONE_SHADE["large radius"]), linewidth=0.0, zorder=0.5
        )
        axes.axvline(s.end, color=FAINT, linewidth=0.5, zorder=0.6)
    axes.grid(axis="x", visible=False)


ESTIMATES, COLUMNS = 12, 3  # panels of the picture of estimates


def estimated(assessment: Assessment) -> list[ZoneValue]:
    """What is estimated by influences: quantities with a limit whose sections differ in one, tightest first."""
    rows = [z for z in assessment.zones if z.worst.limit is not None and z.regression is not None and z.regression.over]
    return sorted(rows, key=lambda z: z.margin or 0.0)[:ESTIMATES]


def estimates_figure(assessment: Assessment) -> Figure:
    """Largest value of every section over the first influence, moved to where the value is estimated in the others."""
    draws = [partial(_fit, row=row) for row in estimated(assessment)]
    explanation = "points: sections; line: fit; bar: from the fit to the estimated value; red: limit"
    height = 16.0 + 52.0 * ceil(len(draws) / COLUMNS)
    return panels(f"{assessment.title}\n{explanation}", draws, height, columns=COLUMNS, share=False)


def _fit(axes: Axes, row: ZoneValue) -> None:
    """Sections, fit, estimated value and limit of one quantity in one class of track."""
    r, limit = row.regression, row.worst.limit
    if r is None or limit is None:
        return
    drawn, unit, factor = row.worst.quantity, INFLUENCES[r.over[0]].symbol, INFLUENCES[r.over[0]].factor
    x, y = factor * r.places, drawn.shown.factor * r.moved
    axes.plot(x, y, ".", color=INK)
    ends = [min(x.min(), factor * r.point[0]), max(x.max(), factor * r.point[0])]
    slope = r.slope[0] / factor
    axes.plot(ends, [drawn.shown.factor * (r.fit + slope * (end - factor * r.point[0])) for end in ends], color=QUIET)
    bounds = [drawn.shown.factor * value for value in (r.fit, r.estimate)]
    axes.plot([factor * r.point[0]] * 2, bounds, "_-", color=INK, markersize=8.0)
    axes.axhline(drawn.shown.factor * limit.value, color=STOP_COLOUR, linewidth=0.8)
    label = with_unit(drawn.symbol, drawn.shown.symbol)
    axes.set(xlabel=f"{r.over[0].replace('_', ' ')} [{unit}]", ylabel=label)
    axes.set_title(f"{row.worst.section.zone} ({row.sections})", fontsize=7.0)
    axes.set_ylim(bottom=min(0.0, float(y.min())))
