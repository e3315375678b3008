"""The track as a strip: what its sections are, curvature and cant, where moments were kept and what happened."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from markupsafe import Markup

from wrsim.plots.colours import CANT_COLOUR, FAINT, INK, STOP_COLOUR
from wrsim.plots.moments import snapshot_letter
from wrsim.plots.track import KIND_SHADE
from wrsim.report.envelope import envelope, pieces_of, points_of
from wrsim.report.svg import element, path, picture, ticks
from wrsim.results.assessment import Section

WIDTH, LEFT, RIGHT = 1000.0, 62.0, 12.0
BAND, PLOT, TOP, FOOT = 24.0, 84.0, 22.0, 24.0


def track_strip(dataset: xr.Dataset, sections: Sequence[Section]) -> Markup | None:
    """The strip of a run; None where it knows no curvature."""
    if "curvature" not in dataset or dataset.sizes.get("time", 0) < 2 or np.ptp(dataset["distance"].values) < 1e-9:
        return None
    place = dataset["wheelset_distance" if "wheelset_distance" in dataset else "distance"].values
    place = place[:, 0] if place.ndim > 1 else place
    pieces = pieces_of([place])
    x, start, end = points_of(pieces), float(pieces[0]), float(pieces[-1])
    across = WIDTH - LEFT - RIGHT

    def to_x(s: float) -> float:
        return LEFT + (min(max(s, start), end) - start) / (end - start) * across

    parts: list[Markup] = []
    for section in sections:
        left, width = to_x(section.start), to_x(section.end) - to_x(section.start)
        kind = section.zone if section.zone in ("straight", "transition") else "arc"
        shade = {"none": "white"}.get(KIND_SHADE[kind], KIND_SHADE[kind])
        box: dict[str, Any] = {"x": left, "y": TOP, "width": width, "height": BAND + PLOT}
        parts.append(element("rect", element("title", _told(section)), fill=shade, stroke=FAINT, **box))
        short = section.label if section.zone in ("straight", "transition") else f"R {abs(section.radius):.0f}"
        room = next((w for w in (section.label, short, str(section.number)) if 6.6 * len(w) < width), "")
        if room:
            middle = left + 0.5 * width
            parts.append(element("text", room, x=middle, y=TOP + 16.0, text_anchor="middle"))
    foot = TOP + BAND + PLOT
    legend = []
    for name, factor, unit, colour, dash in (
        ("curvature", 1e3, "1/km", INK, None),
        ("cant", 1e3, "mm", CANT_COLOUR, "5 3"),
    ):
        if name not in dataset:
            continue
        values = envelope(place, dataset[name].values[:, 0] * factor, pieces)
        most = float(np.nanmax(np.abs(values), initial=0.0)) or 1.0
        y = foot - 0.5 * PLOT * (1.0 + 0.86 * values / most)
        d = path(LEFT + (x - start) / (end - start) * across, y)
        parts.append(element("path", d=d, fill="none", stroke=colour, stroke_width=1.5, stroke_dasharray=dash))
        legend.append((f"{name}, at most {most:.3g} {unit}", colour))
    parts.append(element("path", d=f"M{LEFT} {foot - 0.5 * PLOT}h{across}", stroke=FAINT))
    for i, (words, colour) in enumerate(legend):
        at = {"x": LEFT + 190.0 * i, "y": 14.0}
        parts.append(element("text", words, fill=colour, **at))
    for v in ticks(start, end, 10):
        parts.append(element("text", f"{v:g}", x=to_x(v), y=foot + 16.0, text_anchor="middle"))
    parts.append(element("text", "m", x=LEFT - 8.0, y=foot + 16.0, text_anchor="end"))
    moments = dataset["snapshot_distance"].values if "snapshot_distance" in dataset else np.zeros(0)
    for i, s in enumerate(moments.tolist()):
        x_moment = to_x(s)
        parts.append(element("path", d=f"M{x_moment:.1f} {TOP + BAND}V{foot}", stroke=INK, stroke_dasharray="1 3"))
        parts.append(element("text", snapshot_letter(i), x=x_moment + 2.0, y=foot - 4.0, font_style="italic"))
    marks = dataset["event_distance"].values.tolist() if "event_distance" in dataset else []
    if "stop_distance_m" in dataset.attrs:
        marks.append(float(dataset.attrs["stop_distance_m"]))
    for s in marks:
        if np.isfinite(s):
            parts.append(element("path", d=f"M{to_x(s):.1f} {TOP}V{foot}", stroke=STOP_COLOUR, stroke_width=1.5))
    told = "; ".join(_told(section) for section in sections) or f"from {start:.0f} to {end:.0f} m"
    group = element("g", *parts, font_size=12, fill=INK)
    return picture(WIDTH, foot + FOOT, "Track", told, group, class_="plot")


def _told(section: Section) -> str:
    return f"section {section.number}: {section.label}, {section.start:.0f} to {section.end:.0f} m"
