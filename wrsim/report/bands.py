"""Third-octave spectra of the accelerations at the points of a vehicle, drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wrsim.plots.colours import FAINT, INK, SERIES_COLOURS
from wrsim.report.svg import Array, element, path, picture
from wrsim.results.ride import AXES, Ride

WIDTH, HEIGHT, LEFT, RIGHT, TOP, FOOT = 1000.0, 190.0, 70.0, 12.0, 20.0, 26.0
FLOOR = 1e-4
"""Least rms that is drawn, as a part of the largest."""


def bands_drawing(rides: Sequence[Ride | None], names: Sequence[str]) -> list[dict[str, Any]]:
    """One drawing an axis, on logarithmic scales, a curve a point; with what its colours mean."""
    found = []
    for axis in AXES:
        curves: list[tuple[str, Array, Array]] = []
        for ride, name in zip(rides, names, strict=True):
            for point in ride.points if ride else ():
                own = ride.data["band_rms"].sel(point=point, axis=axis).values if ride else np.zeros(0)
                label = f"{name}: {point}" if len(names) > 1 else point
                curves.append((label, ride.data["band"].values if ride else np.zeros(0), own))
        curves = [c for c in curves if np.nan_to_num(c[2]).max(initial=0.0) > 0.0]
        if curves:
            found.append(_drawn(axis, curves))
    return found


def _drawn(axis: str, curves: list[tuple[str, Array, Array]]) -> dict[str, Any]:
    most = max(float(np.nanmax(p)) for *_, p in curves)
    least = max(FLOOR * most, min(float(np.nanmin(p[p > 0.0])) for *_, p in curves))
    low, high = np.floor(np.log10(least)), np.ceil(np.log10(most))
    first, last = (np.log10(f(c[1][c[1] > 0.0])) for f, c in ((np.min, curves[0]), (np.max, curves[0])))
    across, down = WIDTH - LEFT - RIGHT, HEIGHT - TOP - FOOT

    def to_x(f: Any) -> Any:
        return LEFT + (np.log10(f) - first) / (last - first) * across

    def to_y(v: Any) -> Any:
        return TOP + (high - np.log10(np.maximum(v, 10.0**low))) / (high - low) * down

    parts = []
    for k in range(int(low), int(high) + 1):
        parts.append(element("path", d=f"M{LEFT} {to_y(10.0**k):.1f}h{across}", stroke=FAINT))
        parts.append(element("text", f"{10.0**k:g}", x=LEFT - 6.0, y=float(to_y(10.0**k)) + 4.0, text_anchor="end"))
    for f in (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0):
        if first <= np.log10(f) <= last:
            parts.append(element("path", d=f"M{to_x(f):.1f} {TOP}v{down}", stroke=FAINT))
            parts.append(element("text", f"{f:g} Hz", x=float(to_x(f)), y=HEIGHT - 8.0, text_anchor="middle"))
    lines = []
    for i, (label, bands, values) in enumerate(curves):
        colour = SERIES_COLOURS[i % len(SERIES_COLOURS)]
        look: dict[str, Any] = {"fill": "none", "stroke": colour, "stroke_width": 1.5}
        parts.append(element("path", d=path(to_x(bands), to_y(np.where(values > 0.0, values, np.nan))), **look))
        lines.append({"label": label, "colour": colour, "dash": ""})
    title = f"Third-octaves of the acceleration along {axis} [m/s²]"
    words = f"{len(curves)} points; largest {most:.3g} m/s²"
    group = element("g", *parts, font_size=12, fill=INK)
    return {"title": title, "svg": picture(WIDTH, HEIGHT, title, words, group, class_="plot"), "lines": lines}
