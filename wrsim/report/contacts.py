"""Contacts at the kept moments of a result: every wheel on its rail, close to the patch, and the patch from above."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import pairwise

import numpy as np
import xarray as xr
from markupsafe import Markup
from matplotlib.colors import Normalize, to_hex

from wrsim.plots.colours import FAINT, INK, QUIET, RAIL_FILL, WHEEL_FILL
from wrsim.plots.cross_section import OVERVIEW, has_outlines, pressed_curve, zoom_window
from wrsim.plots.moments import PatchAt, choose_moments, patches_of, select, snapshot_letter, touching_runs
from wrsim.plots.patches import islands, pressure_scale
from wrsim.plots.style import pressure_map, shown
from wrsim.report.svg import Array, element, path, picture
from wrsim.results import CHANNELS
from wrsim.results.moments import has_patches, moment_dim, sample_of
from wrsim.results.wheelsets import numbered, of_wheelset, wheelsets, worst_wheelset

MOST = 6
"""Moments that are drawn."""
PANEL, GAP = 220.0, 14.0
OVERVIEW_WIDTH = 300.0
STEPS = 16
"""Colours of pressure."""


@dataclass(frozen=True)
class Contact:
    """The contacts of one wheel at one moment, drawn, with their numbers."""

    wheel: str
    drawing: Markup
    words: str


@dataclass(frozen=True)
class Moment:
    """A kept moment: letter, words, contacts of both wheels."""

    letter: str
    words: str
    contacts: tuple[Contact, ...]


@dataclass(frozen=True)
class OfWheelset:
    """Moments of one wheelset; open: shown at once."""

    name: str
    open: bool
    moments: tuple[Moment, ...]


def kept_contacts(dataset: xr.Dataset) -> tuple[tuple[OfWheelset, ...], int]:
    """Contacts of all wheelsets at kept moments, and how many moments there are altogether."""
    if not has_patches(dataset) or not has_outlines(dataset):
        return (), 0
    found = []
    worst = worst_wheelset(dataset)
    total = 0
    for name, label in numbered(wheelsets(dataset)).items():
        one = of_wheelset(dataset, name)
        total = max(total, one.sizes[moment_dim(one)])
        scale = pressure_scale(one)
        moments = [_moment(one, m, scale) for m in choose_moments(one, MOST)]
        found.append(OfWheelset(label, name == worst, tuple(moments)))
    return tuple(found), total


def _moment(dataset: xr.Dataset, moment: int, scale: Normalize) -> Moment:
    if moment_dim(dataset) == "pose":
        words = str(dataset["pose"].values[moment])
    else:
        at = f"{float(dataset['snapshot_distance'].values[moment]):.1f} m"
        label = str(dataset["snapshot_label"].values[moment]) if "snapshot_label" in dataset else ""
        words = at if not label or label.startswith("at ") else f"{at}, {label}"
    wheels = [str(w) for w in dataset["wheel"].values]
    contacts = tuple(Contact(w, _drawn(dataset, moment, w, scale), _words(dataset, moment, w)) for w in wheels)
    return Moment(snapshot_letter(moment), words, contacts)


def _words(dataset: xr.Dataset, moment: int, wheel: str) -> str:
    """Numbers of the patches of a wheel."""
    sample_dim = "time" if "time" in dataset.dims else "pose"
    found = []
    for where in patches_of(dataset, moment, wheel):
        row = dataset.isel({sample_dim: sample_of(dataset, moment), "patch": where.patch}).sel(wheel=wheel)
        parts = []
        for name, form in (
            ("N", "N {:.1f} kN"),
            ("p0", "p₀ {:.0f} MPa"),
            ("contact_angle", "γ {:.1f}°"),
            ("contact_angle_variation", "Δγ {:.1f}°"),
            ("area", "{:.0f} mm²"),
        ):
            if name in row and np.isfinite(row[name]):
                parts.append(form.format(float(row[name]) * CHANNELS[name].shown.factor))
        found.append(", ".join(parts))
    return "; ".join(found) or "no contact"


def _drawn(dataset: xr.Dataset, moment: int, wheel: str, scale: Normalize) -> Markup:
    """Three panels: the section, the largest patch closely, the patches from above."""
    places = patches_of(dataset, moment, wheel)
    panels = [_panel(dataset, moment, wheel, OVERVIEW, 0.0, OVERVIEW_WIDTH, scale, places, 4.0, 0.0)]
    start = OVERVIEW_WIDTH + GAP
    if places:
        o, b, half = zoom_window(dataset, places[0])
        window = (o - half, o + half, b - half, b + half)
        panels.append(_panel(dataset, moment, wheel, window, start, PANEL, scale, places, 0.05 * half, 0.76 * half))
        panels.append(_from_above(dataset, places, start + PANEL + GAP, scale))
    width = start + 2.0 * PANEL + GAP
    title = f"{wheel} wheel on its rail"
    words = "Section to scale, the largest patch closely with its pressure along the normals, and patches from above: "
    return picture(width, PANEL + 18.0, title, words + _words(dataset, moment, wheel), *panels, class_="contact")


@cache
def _colours() -> list[str]:
    """Colours of pressure in steps, the palest first."""
    return [to_hex(colour) for colour in pressure_map()((np.arange(STEPS) + 0.5) / STEPS)]


def _pieces(p: Array, scale: Normalize) -> Iterator[tuple[str, slice]]:
    """Neighbouring points of one colour: the colour and the points, ends shared."""
    between = np.asarray(scale(0.5 * (p[:-1] + p[1:])))
    steps = np.clip((between * STEPS).astype(int), 0, STEPS - 1)
    ends = [0, *(np.flatnonzero(np.diff(steps)) + 1).tolist(), steps.size]
    for first, last in pairwise(ends):
        yield _colours()[steps[first]], slice(first, last + 1)


def _panel(
    dataset: xr.Dataset,
    moment: int,
    wheel: str,
    window: tuple[float, float, float, float],
    left: float,
    width: float,
    scale: Normalize,
    places: list[PatchAt],
    thickness: float,
    fan: float,
) -> Markup:
    """The section in a window (o, o, b, b) in mm; fan: length of the largest pressure [mm]."""
    per_mm = width / (window[1] - window[0])
    height = per_mm * (window[3] - window[2])

    def to_x(o: Array) -> Array:
        return (np.asarray(o) - window[0]) * per_mm

    def to_y(b: Array) -> Array:
        return (window[3] - np.asarray(b)) * per_mm

    inner = [element("rect", width=width, height=height, fill="white")]
    of_wheel = dataset.sel(wheel=wheel)
    for part, fill, beyond in (("rail", RAIL_FILL, height + 9.0), ("wheel", WHEEL_FILL, -9.0)):
        chosen = of_wheel[[f"{part}_profile_y", f"{part}_profile_z"]]
        if moment_dim(dataset) in chosen.dims:
            chosen = chosen.isel({moment_dim(dataset): moment})
        o, b = (shown(chosen, f"{part}_profile_{n}") for n in "yz")
        finite = np.isfinite(o) & np.isfinite(b)
        x, y = to_x(o[finite]), to_y(b[finite])
        if x.size:
            closed = f"M{x[0]:.1f} {beyond:.0f}L{path(x, y)[1:]}L{x[-1]:.1f} {beyond:.0f}Z"
            inner.append(element("path", d=closed, fill=fill, stroke=INK, stroke_width=0.8))
    for run in _runs(dataset, places):
        curve, normal, p = pressed_curve(run)
        x, y = to_x(curve[:, 0]), to_y(curve[:, 1])
        if fan > 0.0:
            tips = curve + normal * (fan * p / float(scale.vmax or 1.0))[:, None]
            u, v = to_x(tips[:, 0]), to_y(tips[:, 1])
            shape = path(u, v) + "L" + path(x[::-1], y[::-1])[1:] + "Z"
            inner.append(element("path", d=shape, fill="#fffc", stroke=INK, stroke_width=0.8))
            few = range(4, len(p) - 4, max(1, len(p) // 16))
            rays = "".join(f"M{x[i]:.1f} {y[i]:.1f}L{u[i]:.1f} {v[i]:.1f}" for i in few)
            inner.append(element("path", d=rays, stroke=QUIET, stroke_width=0.5, fill="none"))
        wide = max(per_mm * thickness, 3.0)
        bands = [element("path", d=path(x[of], y[of]), stroke=colour) for colour, of in _pieces(p, scale)]
        inner.append(element("g", *bands, stroke_width=wide, fill="none"))
    bar = 20.0 if fan == 0.0 else 5.0 if per_mm * 5.0 < 0.6 * width else 2.0
    inner.append(_scale_bar(6.0, height - 8.0, bar * per_mm, f"{bar:g} mm"))
    inner.append(element("rect", width=width, height=height, fill="none", stroke=FAINT))
    return element("svg", *inner, x=left, y=2.0, width=width, height=height)


def _runs(dataset: xr.Dataset, places: list[PatchAt]) -> Iterator[xr.Dataset]:
    for where in places:
        yield from touching_runs(select(dataset, where))


def _scale_bar(x: float, y: float, length: float, words: str) -> Markup:
    line = element("path", d=f"M{x} {y}h{length:.1f}M{x} {y - 3}v6M{x + length:.1f} {y - 3}v6", stroke=INK, fill="none")
    return element("g", line, element("text", words, x=x + length + 5.0, y=y + 4.0, font_size=11, fill=INK))


def _from_above(dataset: xr.Dataset, places: list[PatchAt], left: float, scale: Normalize) -> Markup:
    """The largest patch over curved axis s (across, field side to the right) and rolling direction x (up)."""
    drawn = islands(dataset, places[0])
    inner = [element("rect", width=PANEL, height=PANEL, fill="white")]
    if drawn:
        low, high = min(s.min() for s, *_ in drawn), max(s.max() for s, *_ in drawn)
        back, front = min((x - a).min() for _, x, a, *_ in drawn), max((x + a).max() for _, x, a, *_ in drawn)
        per_mm = 0.84 * PANEL / max(high - low, front - back, 1.0)
        middle = 0.5 * (low + high), 0.5 * (back + front)
        for s, x, a, p, _ in drawn:
            u = 0.5 * PANEL + (s - middle[0]) * per_mm
            top, foot = (0.5 * PANEL - (x + end * a - middle[1]) * per_mm for end in (1.0, -1.0))
            for colour, of in _pieces(p, scale):
                round_it = np.concatenate((u[of], u[of][::-1])), np.concatenate((top[of], foot[of][::-1]))
                inner.append(element("path", d=path(*round_it) + "Z", fill=colour, stroke=colour))
            edge = path(u, top) + "L" + path(u[::-1], foot[::-1])[1:] + "Z"
            inner.append(element("path", d=edge, fill="none", stroke=INK, stroke_width=0.8))
        bar = next(b for b in (10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.0) if b * per_mm < 0.5 * PANEL)
        inner.append(_scale_bar(6.0, PANEL - 8.0, bar * per_mm, f"{bar:g} mm"))
    inner.append(element("rect", width=PANEL, height=PANEL, fill="none", stroke=FAINT))
    return element("svg", *inner, x=left, y=2.0, width=PANEL, height=PANEL)


def pressure_key(dataset: xr.Dataset) -> Markup:
    """The colours of pressures of a dataset."""
    scale = pressure_scale(dataset)
    wide = 240.0 / STEPS
    boxes = [
        element("rect", x=10.0 + wide * i, y=4, width=wide + 0.5, height=12, fill=colour)
        for i, colour in enumerate(_colours())
    ]
    most = float(scale.vmax or 0.0)
    words = [
        element("text", "0", x=10, y=30, font_size=11),
        element("text", f"{most:.0f} MPa", x=250, y=30, font_size=11, text_anchor="end"),
    ]
    return picture(
        270, 34, "Colours of the pressure", f"pale: none; dark: {most:.0f} MPa", *boxes, *words, class_="key"
    )
