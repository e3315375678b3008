"""Pictures of an assessment: how much of each limit is used, and the evaluated signals against distance."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wrsim.plots.colours import FAINT, GROUP_LINE, INK, QUIET, STOP_COLOUR, WHEEL_COLOUR
from wrsim.plots.estimates import estimated, estimates_figure
from wrsim.plots.marks import note, note_above, wheel_entries
from wrsim.plots.style import FULL_WIDTH, new_figure, save, style
from wrsim.results.assessment import Assessment, Section, Value
from wrsim.results.wheelsets import numbered

ZONE_SHADE = {
    "straight": "none",
    "transition": "#fbf1da",
    "large radius": "#eef6f2",
    "small radius": "#e3f1ec",
    "very small radius": "#d3e8e0",
    "tight": "#c0ddd1",
}
"""Background of a class of track against distance."""
WITHIN, BEYOND = "#0072B2", "#D55E00"
MOST = 1.5
"""Part of a limit at which bars and points are cut off."""


def assessment_pictures(found: Assessment, directory: str | Path) -> list[Path]:
    """Write ``assessment.png`` (limits), ``assessment_history.png`` (of several runs with their numbers) and where
    values are estimated by influences ``assessment_estimates.png``; returns their paths.
    """
    directory = Path(directory)
    files = []
    for i, run in enumerate(found.signals, 1):
        name = f"assessment_history_{i}.png" if run else "assessment_history.png"
        files.append(save(history_figure(found, run), directory / name))
    if estimated(found):
        files.append(save(estimates_figure(found), directory / "assessment_estimates.png"))
    if any(v.limit is not None for v in found.values):
        files.insert(0, save(limits_figure(found), directory / "assessment.png"))
    return files


def limits_figure(found: Assessment) -> Figure:
    """For every quantity with a limit and every class of track: all sections as points, the worst as a bar."""
    with style():
        rows = _rows(found)
        figure = new_figure(FULL_WIDTH, 26.0 + 4.6 * len(rows))
        axes = figure.add_subplot()
        used_of(axes, rows)
        figure.suptitle(found.title, x=0.01, ha="left", fontsize=8.5)
        axes.set_title("Part of the limit that is used: bar: worst; points: every section, wheelset and wheel")
    return figure


def used_of(axes: Axes, rows: Sequence[tuple[str, Sequence[Value]]]) -> Axes:
    """Horizontal bars of value over limit, one a row, with the limit as a line."""
    for i, (label, values) in enumerate(rows):
        used = np.array([v.value / v.limit.value for v in values if v.limit is not None])
        worst = float(np.nanmax(used))
        colour = BEYOND if worst > 1.0 else WITHIN
        axes.barh(i, min(worst, MOST), height=0.62, color=colour, alpha=0.35, linewidth=0.0, zorder=2.0)
        axes.plot(np.clip(used, 0.0, MOST), np.full(used.size, i), ".", color=colour, markersize=3.0, zorder=3.0)
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.6}
        colour = STOP_COLOUR if worst > 1.0 else QUIET
        note(axes, label, (min(worst, MOST), i), (4.0, 0.0), va="center", fontsize=6.3, color=colour, bbox=box)
    names = [f"{values[0].quantity.symbol}   {values[0].section.zone}" for _, values in rows]
    axes.set_yticks(range(len(rows)), names)
    axes.axvline(1.0, color=INK, linewidth=0.9, zorder=2.5)
    axes.set_xlim(0.0, 1.75)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_xlabel("Value over limit")
    axes.grid(axis="y", visible=False)
    return axes


def _rows(found: Assessment) -> list[tuple[str, list[Value]]]:
    """Label at the bar and all values of every quantity with a limit in every class of track."""
    rows = []
    for zone in found.zones():
        worst = zone.worst
        if worst.limit is None:
            continue
        factor, unit = worst.quantity.shown.factor, worst.quantity.shown.symbol
        unit = "" if unit == "1" else f" {unit}"
        label = f"{worst.value * factor:z.3g} of {worst.limit.value * factor:.3g}{unit}, section {worst.section.number}"
        values = [
            v for v in found.of(worst.quantity.key) if v.section.zone == worst.section.zone and v.limit is not None
        ]
        rows.append((label + (f": {worst.place}" if worst.place else ""), values))
    return rows


def history_figure(found: Assessment, run: str = "") -> Figure:
    """Sum Y, Y/Q, Q and Y of a run as they were evaluated, with their limits, over shaded sections."""
    signals, sections = found.signals[run], [s for s in found.sections if s.run == run]
    panels: tuple[tuple[str, str, float, tuple[str, ...]], ...] = (
        ("sum_Y", "ΣY, 20 Hz, 2 m\n[kN]", 1e-3, ("sum_Y",)),
        ("Y_over_Q", "Y/Q, 20 Hz, 2 m", 1.0, ("Y_over_Q",)),
        ("Q", "Q, 20 Hz\n[kN]", 1e-3, ("Q",)),
        ("Y", "Y, 20 Hz\n[kN]", 1e-3, ("Y_qst", "Y_qst_reduced")),
    )
    with style():
        figure = new_figure(FULL_WIDTH, 34.0 * len(panels) + 24.0)
        rows = figure.subplots(len(panels), 1, sharex=True)
        for axes, (signal, label, factor, quantities) in zip(rows, panels, strict=True):
            shade_sections(axes, sections)
            signal_of(axes, signals, signal, factor)
            limited = [v for quantity in quantities for v in found.of(quantity) if v.section.run == run]
            limit_of(axes, limited, factor, both=signal == "sum_Y")
            axes.set_ylabel(label)
        _number_sections(rows[0], sections)
        rows[-1].set_xlabel("Distance along the track [m]")
        place = signals["place"].values
        rows[-1].set_xlim(place[0], place[-1])
        figure.align_ylabels(list(rows))
        title = f"{found.title}\nrun {run}" if run else found.title
        figure.suptitle(title, x=0.01, ha="left", fontsize=8.5)
        figure.legend(handles=_legend(signals), loc="outside lower center", ncols=4)
    return figure


def signal_of(axes: Axes, signals: xr.Dataset, name: str, factor: float) -> Axes:
    """One signal: a line a wheelset, or a wheelset and wheel."""
    place = signals["place"].values
    data = signals[name].values
    for i in range(data.shape[0]):
        line = GROUP_LINE[i % len(GROUP_LINE)]
        own = [(INK, data[i])] if data.ndim == 2 else list(zip(WHEEL_COLOUR.values(), data[i].T, strict=True))
        for colour, values in own:
            values = np.where(np.isfinite(values), values, np.nan) * factor
            axes.plot(place, values, color=colour, linestyle=line, linewidth=0.9)
    return axes


def limit_of(axes: Axes, values: Sequence[Value], factor: float, *, both: bool) -> Axes:
    """Limits as red lines over their sections, where the picture stays readable with them; else in words."""
    limits = [(v.section, v.limit.value * factor) for v in values if v.limit is not None]
    reach = max(abs(y) for y in axes.get_ylim())
    least = min((limit for _, limit in limits), default=0.0)
    if least > 6.0 * reach:
        corner: Any = {"xycoords": "axes fraction", "ha": "right", "va": "bottom", "color": STOP_COLOUR}
        note(axes, f"limit {'±' if both else ''}{least:.3g}", (1.0, 1.0), (0.0, 1.5), **corner)
        return axes
    for section, limit in limits:
        for y in (limit, -limit) if both else (limit,):
            axes.plot([section.start, section.end], [y, y], color=STOP_COLOUR, linewidth=0.9, zorder=2.2)
    return axes


def shade_sections(axes: Axes, sections: Sequence[Section]) -> Axes:
    """Background by class of track, a fine line between sections."""
    for s in sections:
        axes.axvspan(s.start, s.end, color=ZONE_SHADE[s.zone], linewidth=0.0, zorder=0.5)
        axes.axvline(s.end, color=FAINT, linewidth=0.5, zorder=0.6)
    axes.grid(axis="x", visible=False)
    return axes


def _number_sections(axes: Axes, sections: Sequence[Section]) -> None:
    """Numbers above the sections; where they are narrow, of every few only."""
    whole = sections[-1].end - sections[0].start
    last = -np.inf
    for s in sections:
        middle = 0.5 * (s.start + s.end)
        if middle - last < 0.02 * whole:
            continue
        last = middle
        note_above(axes, str(s.number), middle)


def _legend(signals: xr.Dataset) -> list[Artist]:
    entries = wheel_entries()
    names = [str(name) for name in signals["wheelset"].values]
    if len(names) > 1:
        for i, label in enumerate(numbered(names).values()):
            line = GROUP_LINE[i % len(GROUP_LINE)]
            entries.append(Line2D([], [], color=INK, linestyle=line, label=f"wheelset {label}"))
    return [*entries, Line2D([], [], color=STOP_COLOUR, linewidth=0.9, label="limit")]
