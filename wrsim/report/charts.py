"""Histories of one run or several, as charts over one abscissa: first as SVG, then as numbers for the page's script."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup

from wrsim.plots.colours import FAINT, INK, QUIET, SERIES_COLOURS, STOP_COLOUR, WHEEL_COLOUR
from wrsim.report.envelope import envelope, pieces_of, points_of
from wrsim.report.svg import Array, element, limits, path, picture, ticks
from wrsim.results import CHANNELS
from wrsim.results.channels import PATCHES
from wrsim.results.wheelsets import numbered, wheelsets, worst_wheelset

WIDTH, HEIGHT, LEFT, RIGHT, TOP, FOOT = 1000.0, 190.0, 62.0, 12.0, 8.0, 24.0
"""Units of a chart's drawing."""

OF_WHEELS = ("Y", "Q", "Y_over_Q", "sum_Y")
OF_WHEELSETS = ("lateral_shift", "yaw", "curvature", "cant")
FURTHER = ("p0", "contact_angle", "T_gamma", "guide_force_y")
OF_BODIES = ("body_lateral", "body_roll", "body_yaw")
OF_POINTS = ("point_ay", "point_az")
OF_COUPLINGS = ("coupling_force", "coupling_offset", "coupling_yaw")
"""Channels in the order of their charts."""

NAMED = ("body", "point", "coupling")
"""Dimensions, besides that of wheelsets, whose labels tell the curves of a chart."""

DASHES = ("", "5 3", "1 3", "8 3 2 3", "12 4")
"""Of the left and the right wheel; of several results those of ``NAMED``, whose colours tell the results."""

SIGNS = {
    "Y": "positive: the wheel pushes its rail outward",
    "sum_Y": "Y of the left wheel less that of the right one, positive to the left",
    "Q": "positive: the wheel presses its rail down",
    "lateral_shift": "positive to the left",
    "yaw": "positive: turned to the left",
    "curvature": "positive to the left",
    "cant": "positive: leans to the inside",
    "contact_angle": "main point of every patch",
    "p0": "of every patch",
    "guide_force_y": "of the frame on the wheelset, positive to the left",
    "coupling_force": "pull is positive",
    "coupling_offset": "of two vehicles: that ahead against that behind, positive to the left",
    "coupling_yaw": "of two vehicles: that ahead against that behind, positive to the left",
}


@dataclass(frozen=True)
class Line:
    """One curve: what it is called, its wheelset (or body, point), which result it is of, its look, its points.

    places: abscissae of the samples; values: in the unit for readers.
    """

    label: str
    part: str
    run: int
    colour: str
    dash: str
    places: Array
    values: Array


@dataclass(frozen=True)
class Chart:
    """Curves of one channel; along: unit of the abscissa; limits: words and values of lines across."""

    key: str
    title: str
    unit: str
    note: str
    along: str
    lines: tuple[Line, ...]
    limits: tuple[tuple[str, float], ...] = ()

    def peak(self) -> str:
        """Largest magnitude and its place, in words."""
        best: tuple[float, float, str] | None = None
        for line in self.lines:
            if np.isfinite(line.values).any():
                i = int(np.nanargmax(np.abs(line.values)))
                if best is None or abs(line.values[i]) > abs(best[0]):
                    best = float(line.values[i]), float(line.places[i]), line.label
        if best is None:
            return "no values"
        value = f"{best[0]:.4g} {self.unit}".strip()
        whose = f", {best[2]}" if len(self.lines) > 1 else ""
        return f"largest magnitude {value} at {best[1]:.1f} {self.along}{whose}"


@dataclass(frozen=True)
class Charts:
    """All charts over one abscissa. abscissa: "distance" or "time"; parts: wheelsets in all charts of them, and how
    they are called there."""

    charts: tuple[Chart, ...]
    abscissa: str
    parts: dict[str, str]
    worst: str
    pieces: Array = field(repr=False)

    @property
    def unit(self) -> str:
        """Of the abscissa."""
        return "m" if self.abscissa == "distance" else "s"

    @property
    def label(self) -> str:
        """Words for the abscissa."""
        return "distance along the track [m]" if self.abscissa == "distance" else "time [s]"

    def script_data(self) -> dict[str, Any]:
        """What the page's script draws: abscissae and curves, not-a-number as null."""
        x = points_of(self.pieces)
        return {
            "x": [round(float(v), 3) for v in x],
            "unit": self.unit,
            "label": self.label,
            "parts": self.parts,
            "charts": [
                {
                    "key": chart.key,
                    "title": chart.title,
                    "unit": chart.unit,
                    "limits": [{"label": words, "value": value} for words, value in chart.limits],
                    "lines": [
                        {"label": line.label, "part": line.part, "run": line.run, "colour": line.colour}
                        | {"dash": line.dash, "y": _numbers(envelope(line.places, line.values, self.pieces))}
                        for line in chart.lines
                    ],
                }
                for chart in self.charts
            ],
        }


def _numbers(values: Array) -> list[float | None]:
    """Five digits of each; null for not-a-number."""
    return [float(f"{v:.5g}") if np.isfinite(v) else None for v in values.tolist()]


def charts_of(
    datasets: Sequence[xr.Dataset], names: Sequence[str], across: Mapping[str, Sequence[tuple[str, float]]]
) -> Charts | None:
    """Charts of runs; None where one of the results is no run of several samples.

    names: short ones of the results; across: limits of a channel, in the unit for readers.
    """
    if any(d.sizes.get("time", 0) < 2 or "resolved_with" in d.attrs for d in datasets):
        return None
    moves = all("distance" in d.coords and np.ptp(d["distance"].values) > 1e-9 for d in datasets)
    along, parts = "m" if moves else "s", called(datasets)
    found = []
    for key in (*OF_WHEELS, *OF_WHEELSETS, *FURTHER, *OF_BODIES, *OF_POINTS, *OF_COUPLINGS):
        lines = [line for run, d in enumerate(datasets) for line in _lines(d, key, moves, run, names, parts)]
        if lines and any(np.nan_to_num(line.values).any() for line in lines):
            channel = CHANNELS[key]
            title = channel.long_name[0].upper() + channel.long_name[1:].replace(" of the body", "")
            title += f" {key}" if len(key) == 1 else ""
            unit = "" if channel.shown.symbol == "1" else channel.shown.symbol
            found.append(Chart(key, title, unit, SIGNS.get(key, ""), along, tuple(lines), tuple(across.get(key, ()))))
    if not found:
        return None
    places = [line.places for chart in found for line in chart.lines]
    worst = worst_wheelset(datasets[0])
    return Charts(tuple(found), "distance" if moves else "time", parts, worst, pieces_of(places))


def called(datasets: Sequence[xr.Dataset]) -> dict[str, str]:
    """Wheelsets of all results and what they are called: with their numbers, where all results have the same ones."""
    sets = [wheelsets(d) for d in datasets]
    names = list(dict.fromkeys(name for own in sets for name in own))
    return numbered(names) if len(set(sets)) == 1 else {name: name for name in names}


def _lines(
    dataset: xr.Dataset, key: str, moves: bool, run: int, names: Sequence[str], called: dict[str, str]
) -> list[Line]:
    """The curves of one channel of one result."""
    if key not in dataset:
        return []
    if "patch" in dataset[key].dims:
        used = [k for k in range(dataset.sizes["patch"]) if np.isfinite(dataset[key].values[..., k]).any()]
        patches = [(dataset[key].isel(patch=k), f"{PATCHES[k]} patch" if len(used) > 1 else "", k) for k in used]
    else:
        patches = [(dataset[key], "", 0)]
    return [line for patch in patches for line in _lines_of(dataset, key, *patch, moves, run, names, called)]


def _lines_of(
    dataset: xr.Dataset, key: str, data: xr.DataArray, patch: str, rank: int,
    moves: bool, run: int, names: Sequence[str], called: dict[str, str],
) -> list[Line]:  # fmt: skip
    """Those of one patch, or of a channel without patches. patch: its name; rank: its number."""
    several = len(names) > 1
    values = data.values.astype(float) * CHANNELS[key].shown.factor
    of = next((d for d in ("wheelset", *NAMED) if d in data.dims), "")
    parts = [str(p) for p in np.atleast_1d(dataset[of].values)] if of else [""]
    if key in ("curvature", "cant"):  # of the track: that of one wheelset says it all
        values, parts = values[:, :1], parts[:1]
    wheels = [str(w) for w in dataset["wheel"].values] if "wheel" in data.dims else [""]
    values = values.reshape(len(values), len(parts), len(wheels))
    lines = []
    for i, part in enumerate(parts):
        own = dataset["wheelset_distance"].values[:, i] if of == "wheelset" and "wheelset_distance" in dataset else None
        places = dataset["distance" if moves else "time"].values if own is None or not moves else own
        colour = SERIES_COLOURS[(run if several else i) % len(SERIES_COLOURS)]
        if not several and len(parts) == 1 and len(wheels) == 1:
            colour = INK
        for j, wheel in enumerate(wheels):
            shown = called.get(part, part) if len(parts) > 1 or of in NAMED else ""
            words = [w for w in (names[run] if several else "", shown, wheel, patch) if w]
            label = ", ".join(words) or CHANNELS[key].long_name
            group = part if of == "wheelset" and key not in ("curvature", "cant") else ""
            if wheel and not several and len(parts) == 1:
                colour = WHEEL_COLOUR[wheel]
            dash = DASHES[i % len(DASHES)] if several and of in NAMED else DASHES[(j + 2 * rank) % len(DASHES)]
            lines.append(Line(label, group, run, colour, dash, places, values[:, i, j]))
    return lines


def drawing(charts: Charts, chart: Chart, part: str = "") -> Markup:
    """A chart as SVG; part: the only wheelset to draw, where there are several results."""
    x = points_of(charts.pieces)
    lines = [line for line in chart.lines if part in ("", line.part) or not line.part]
    curves = [envelope(line.places, line.values, charts.pieces) for line in lines]
    low, high = limits(curves, 1e-6)
    reach = high - low
    marks = [(words, v) for words, v in chart.limits if low - reach < v < high + reach]
    if marks:
        low = min(low, *(v - 0.06 * reach for _, v in marks))
        high = max(high, *(v + 0.06 * reach for _, v in marks))
    start, end = float(charts.pieces[0]), float(charts.pieces[-1])
    across, down = WIDTH - LEFT - RIGHT, HEIGHT - TOP - FOOT

    def to_x(v: Any) -> Any:
        return LEFT + (v - start) / (end - start) * across

    def to_y(v: Any) -> Any:
        return TOP + (high - v) / (high - low) * down

    grid: list[Markup] = []
    for v in ticks(start, end, 10):
        grid.append(element("path", d=f"M{to_x(v):.1f} {TOP}V{TOP + down}", stroke=FAINT, fill="none"))
        grid.append(element("text", f"{v:g}", x=to_x(v), y=HEIGHT - 8.0, text_anchor="middle"))
    for v in ticks(low, high, 5):
        grid.append(element("path", d=f"M{LEFT} {to_y(v):.1f}H{LEFT + across}", stroke=FAINT, fill="none"))
        grid.append(element("text", f"{v:.6g}".replace("-", "−"), x=LEFT - 6.0, y=to_y(v) + 4.0, text_anchor="end"))
    if low < 0.0 < high:
        grid.append(element("path", d=f"M{LEFT} {to_y(0.0):.1f}H{LEFT + across}", stroke=QUIET, fill="none"))
    for words, v in marks:
        look: dict[str, Any] = {"stroke": STOP_COLOUR, "stroke_dasharray": "2 3", "fill": "none"}
        grid.append(element("path", d=f"M{LEFT} {to_y(v):.1f}H{LEFT + across}", **look))
        at = {"x": LEFT + across - 4.0, "y": to_y(v) - 4.0}
        grid.append(element("text", words, text_anchor="end", fill=STOP_COLOUR, **at))
    strokes = [
        element(
            "path", d=path(to_x(x), to_y(curve)), fill="none", stroke=line.colour, stroke_width=1.3,
            stroke_dasharray=line.dash or None, stroke_linejoin="round",
        )
        for line, curve in zip(lines, curves, strict=True)
    ]  # fmt: skip
    title = f"{chart.title} [{chart.unit}]" if chart.unit else chart.title
    words = f"Over {charts.label}; {len(lines)} curves; {chart.peak()}"
    body = element("g", *grid, font_size=12, fill=INK)
    return picture(WIDTH, HEIGHT, title, words, body, *strokes, class_="plot")
