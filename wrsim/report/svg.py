"""Drawings as SVG text. Every text and attribute is escaped."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from markupsafe import Markup, escape
from numpy.typing import NDArray

Array = NDArray[np.float64]


def element(name: str, *children: object, **attributes: object) -> Markup:
    """An element; ``class_`` stands for class, and _ in an attribute's name for -. Attributes that are None fall."""
    own = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(_plain(value))}"'
        for key, value in attributes.items()
        if value is not None
    )
    inner = Markup("").join(child if isinstance(child, Markup) else escape(child) for child in children)
    return Markup(f"<{name}{own}>{inner}</{name}>") if children else Markup(f"<{name}{own}/>")


def _plain(value: object) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".") if isinstance(value, float | np.floating) else str(value)


def picture(width: float, height: float, title: str, description: str, *children: object, **more: object) -> Markup:
    """A drawing of that many units, with its words for who does not see it."""
    words = (element("title", title), element("desc", description))
    box = f"0 0 {width:g} {height:g}"
    return element("svg", *words, *children, viewBox=box, role="img", aria_label=f"{title}. {description}", **more)


def path(x: Array, y: Array, off: float = 0.15) -> str:
    """Lines through points, interrupted where one is not a number; points that lie on the lines are left out.

    off: how far a point left out may lie beside them.
    """
    finite = np.isfinite(x) & np.isfinite(y)
    ends = np.flatnonzero(np.diff(np.concatenate(([False], finite, [False])).astype(int)))
    parts = []
    for first, last in zip(ends[::2], ends[1::2], strict=True):
        own = slice(int(first), int(last))
        kept = needed(x[own], y[own], off)
        points = zip(x[own][kept].tolist(), y[own][kept].tolist(), strict=True)
        parts.append("M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in points))
    return "".join(parts)


def needed(x: Array, y: Array, off: float) -> NDArray[np.intp]:
    """Indices of the points that a line through them cannot spare (Douglas and Peucker)."""
    keep = np.zeros(x.size, dtype=bool)
    keep[[0, -1]] = True
    open_pieces = [(0, x.size - 1)]
    while open_pieces:
        i, j = open_pieces.pop()
        if j - i < 2:
            continue
        dx, dy = x[j] - x[i], y[j] - y[i]
        u, v = x[i + 1 : j] - x[i], y[i + 1 : j] - y[i]
        length = math.hypot(dx, dy)
        away = np.abs(u * dy - v * dx) / length if length > 0.0 else np.hypot(u, v)
        k = int(np.argmax(away))
        if away[k] > off:
            keep[i + 1 + k] = True
            open_pieces += [(i, i + 1 + k), (i + 1 + k, j)]
    return np.flatnonzero(keep)


def ticks(low: float, high: float, most: int = 6) -> list[float]:
    """Round numbers between two, at most so many of them."""
    span = high - low
    if not span > 0.0 or not math.isfinite(span):
        return []
    step = 10.0 ** math.floor(math.log10(span / most))
    step = next(step * k for k in (1.0, 2.0, 5.0, 10.0, 20.0) if span / (step * k) <= most)
    first = math.ceil(low / step - 1e-9)
    return [step * k for k in range(first, math.floor(high / step + 1e-9) + 1)]


def limits(values: Iterable[Array], least: float = 1e-9) -> tuple[float, float]:
    """Smallest and largest of all values, with some room."""
    finite = [v[np.isfinite(v)] for v in values]
    finite = [v for v in finite if v.size]
    if not finite:
        return 0.0, 1.0
    low, high = min(float(v.min()) for v in finite), max(float(v.max()) for v in finite)
    room = 0.06 * max(high - low, least, 1e-6 * abs(high))
    return low - room, high + room
