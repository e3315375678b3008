"""Histories of one run or several as charts over one abscissa: numbers that the page's script draws."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.plots.histories import ANGLE_JUMP
from wrsim.plots.marks import jumps
from wrsim.plots.theme import INK, SERIES_COLOURS, WHEEL_COLOUR, shown
from wrsim.results import CHANNELS
from wrsim.results.channels import PATCHES
from wrsim.results.moments import Array, is_history
from wrsim.results.table import quantity
from wrsim.results.units import conversion, heading_in, in_text
from wrsim.results.wheelsets import numbered, wheelsets, worst_wheelset

PIECES = 400  # pieces that a history is cut into; each gives two points

NAMED = ("body", "point", "coupling", "span")
"""Dimensions, besides that of wheelsets, whose labels name the curves of a chart."""

DASHES = ("", "5 3", "1 3", "8 3 2 3", "12 4")
"""Dashes of the left and the right wheel; of several results, which colours distinguish, those of ``NAMED``."""

LEFT = "positive to the left"
OF_TWO = f"of two vehicles: that ahead against that behind, {LEFT}"
CHARTS = {
    "Y": "positive: the wheel pushes its rail outward",
    "Q": "positive: the wheel presses its rail down",
    "Y_over_Q": "",
    "sum_Y": f"Y of the left wheel less that of the right one, {LEFT}",
    "lateral_shift": LEFT,
    "yaw": "positive: turned to the left",
    "curvature": LEFT,
    "cant": "positive: the right rail is the higher one",
    "p0": "of every patch",
    "temperature": "largest of every patch",
    "contact_angle": "main point of every patch",
    "T_gamma": "",
    "guide_force_y": f"of the frame on the wheelset, {LEFT}",
    "body_lateral": "", "body_roll": "", "body_yaw": "", "point_ay": "", "point_az": "",
    "deck_deflection": "downward", "deck_moment": "", "deck_acceleration": "up",
    "coupling_force": "pull is positive",
    "coupling_offset": OF_TWO,
    "coupling_yaw": OF_TWO,
}  # fmt: skip
"""Channels in the order of their charts, and what their signs mean."""


class Curve(NamedTuple):
    """look: label, part (wheelset in a chart of them), run, colour, dash; places: abscissae; values: for readers;
    jumps: samples at which its contact is elsewhere than at the one ahead of them."""

    look: dict[str, Any]
    places: Array
    values: Array
    jumps: NDArray[np.intp]


def charts_of(
    datasets: Sequence[xr.Dataset], names: Sequence[str], across: Mapping[str, Sequence[dict[str, Any]]]
) -> dict[str, Any] | None:
    """Charts of runs over distance, or time where nothing moves: abscissae ``x``, ``parts`` (wheelsets and what they
    are called, ``worst`` the first to look at), ``charts`` with words and curves; not-a-number as null.

    names: short ones of the results; across: limits of a channel: words, values for readers and where they hold. None
    where one of the results is no run of several samples.
    """
    if not all(map(is_history, datasets)):
        return None
    moves = all("distance" in d.coords and np.ptp(d["distance"].values) > 1e-9 for d in datasets)
    sets = [wheelsets(d) for d in datasets]
    parts = list(dict.fromkeys(name for members in sets for name in members))
    called = numbered(parts) if len(set(sets)) == 1 else dict(zip(parts, parts, strict=True))
    curves: dict[str, list[Curve]] = {}
    for key in CHARTS:
        drawn = (_curves(d, key, moves, run, names, called) for run, d in enumerate(datasets) if key in d)
        members = [curve for of_run in drawn for curve in of_run]
        if any(np.nan_to_num(curve.values).any() for curve in members):
            curves[key] = members
    if not curves:
        return None
    pieces = pieces_of([curve.places for members in curves.values() for curve in members])
    unit = "m" if moves else "s"
    page: dict[str, Any] = {
        "x": [round(v, 3) for v in (pieces[:-1, None] + np.diff(pieces)[:, None] * (0.25, 0.75)).ravel().tolist()],
        "unit": unit,
        "label": "distance along the track [m]" if moves else "time [s]",
        "parts": called,
        "worst": worst_wheelset(datasets[0]),
        "charts": [_chart(key, members, pieces, unit, across.get(key, ())) for key, members in curves.items()],
    }
    return _in_units(page)


def _in_units(charts: dict[str, Any]) -> dict[str, Any]:
    """The charts in the units in use."""
    if (along := conversion(charts["unit"])) is not None:
        label = heading_in(charts["label"])[0]
        charts |= {"x": [round(along.forward(v), 3) for v in charts["x"]], "unit": along.symbol, "label": label}
    for chart in charts["charts"]:
        chart["peak"] = in_text(chart["peak"])
        if (unit := conversion(chart["unit"])) is None:
            continue
        chart["unit"] = unit.symbol
        for limit in chart["limits"]:
            limit["value"] = unit.forward(limit["value"])
        for line in chart["lines"]:
            line["y"] = [None if v is None else float(f"{unit.forward(v):.5g}") for v in line["y"]]
    return charts


def _chart(
    key: str, curves: Sequence[Curve], pieces: Array, along: str, across: Sequence[dict[str, Any]]
) -> dict[str, Any]:
    channel = CHANNELS[key]
    title = channel.long_name[0].upper() + channel.long_name[1:].replace(" of the body", "")
    best = max(curves, key=lambda c: float(np.nanmax(np.abs(c.values), initial=0.0)))
    peak = int(np.nanargmax(np.abs(best.values)))
    whose = f", {best.look['label']}" if len(curves) > 1 else ""
    place = quantity(float(best.places[peak]), along, ".1f")
    return {
        "key": key,
        "title": f"{title} {key}" if len(key) == 1 else title,
        "unit": channel.shown.unit,
        "note": CHARTS[key],
        "peak": f"largest magnitude {quantity(float(best.values[peak]), channel.shown.unit)} at {place}{whose}",
        "limits": list(across) if along == "m" else [],
        "lines": [_line(c, pieces) for c in curves],
    }


def _line(curve: Curve, pieces: Array) -> dict[str, Any]:
    ends = envelope(curve.places, curve.values, pieces)
    apart = interruptions(curve.places, curve.values, curve.jumps, pieces)
    return curve.look | {"y": _numbers(ends)} | ({"breaks": apart} if apart else {})


def _numbers(values: Array) -> list[float | None]:
    return [float(f"{v:.5g}") if np.isfinite(v) else None for v in values.tolist()]


def _curves(
    dataset: xr.Dataset, key: str, moves: bool, run: int, names: Sequence[str], called: Mapping[str, str]
) -> Iterator[Curve]:
    """The curves of one channel of one result: of wheelsets, bodies, ...; of wheels; of patches that are in use."""
    data, several = dataset[key], len(names) > 1
    owner = next((d for d in ("wheelset", *NAMED) if d in data.dims), "")
    parts = [str(p) for p in np.atleast_1d(dataset[owner].values)] if owner else [""]
    wheels = [str(w) for w in dataset["wheel"].values] if "wheel" in data.dims else [""]
    values = data.values.astype(float).reshape(data.sizes["time"], len(parts), len(wheels), -1)
    if on_track := key in ("curvature", "cant"):  # that of one wheelset is enough
        parts = parts[:1]
    patches = np.flatnonzero(np.isfinite(values).any(axis=(0, 1, 2))).tolist() if "patch" in data.dims else [0]
    of_patches = "patch" in data.dims and "contact_angle" in dataset
    angles = shown(dataset, "contact_angle").reshape(values.shape) if of_patches else None
    lone = not several and len(parts) == 1
    for i, part in enumerate(parts):
        places = dataset["distance" if moves else "time"].values
        if moves and owner == "wheelset" and "wheelset_distance" in dataset:
            places = dataset["wheelset_distance"].values[:, i]
        label = called.get(part, part) if len(parts) > 1 or owner in NAMED else ""
        for (j, wheel), k in product(enumerate(wheels), patches):
            patch = f"{PATCHES[k]} patch" if len(patches) > 1 else ""
            names_of_curve = [w for w in (names[run] if several else "", label, wheel, patch) if w]
            of_series = SERIES_COLOURS[(run if several else i) % len(SERIES_COLOURS)]
            look = {
                "label": ", ".join(names_of_curve) or CHANNELS[key].long_name,
                "part": part if owner == "wheelset" and not on_track else "",
                "run": run,
                "colour": of_series if several or (owner in NAMED and not lone) else WHEEL_COLOUR.get(wheel, INK),
                "dash": DASHES[(i if several and owner in NAMED else j + 2 * k if several else 2 * k) % len(DASHES)],
            }
            apart = jumps(angles[:, i, j, k], ANGLE_JUMP) if angles is not None else np.empty(0, np.intp)
            yield Curve(look, places, values[:, i, j, k] * CHANNELS[key].shown.factor, apart)


def pieces_of(places: list[Array]) -> Array:
    """Ends (n + 1,) of equal pieces over all places, never shorter than two samples of the longest row."""
    low, high = min(float(p.min()) for p in places), max(float(p.max()) for p in places)
    count = min(PIECES, max(max(p.size for p in places) // 2, 1))
    return np.linspace(low, high if high > low else low + 1e-9, count + 1)


def envelope(places: Array, values: Array, pieces: Array) -> Array:
    """Least and largest value (2 n,) of every piece, in the order in which a rise or a fall meets them. places, values:
    (samples,), places in any order. A piece without a sample takes the value between its neighbours; outside of the
    samples, and where a piece holds nothing but not-a-number, there is none."""
    order = np.argsort(places, kind="stable")
    ordered, signal = places[order], values[order]
    piece = np.clip(np.searchsorted(pieces, ordered, side="right") - 1, 0, pieces.size - 2)
    starts = np.searchsorted(piece, np.arange(pieces.size - 1))
    counts = np.diff(np.append(starts, ordered.size))
    ends = np.full((pieces.size - 1, 2), np.nan)
    full = counts > 0
    low, high = (f.reduceat(signal, starts[full]) for f in (np.fmin, np.fmax))
    falls = signal[starts[full]] > signal[starts[full] + counts[full] - 1]
    ends[full] = np.where(falls[:, None], np.stack((high, low), 1), np.stack((low, high), 1))
    if not full.all():
        middles = 0.5 * (pieces[:-1] + pieces[1:])[~full]
        ends[~full] = np.interp(middles, ordered, signal, left=np.nan, right=np.nan)[:, None]
    return ends.ravel()


def interruptions(places: Array, values: Array, starts: NDArray[np.intp], pieces: Array) -> list[int]:
    """Points of an ``envelope`` after which its line is interrupted: values are missing between two samples, or the
    second of them is one of ``starts``, where contact has jumped elsewhere."""
    known = np.flatnonzero(np.isfinite(values))
    apart = (np.diff(known) > 1) | (np.diff(np.searchsorted(starts, known, side="right")) > 0)
    piece = np.clip(np.searchsorted(pieces, places[known], side="right") - 1, 0, pieces.size - 2)
    points: set[int] = set()
    for low, high in np.sort(np.stack((piece[:-1], piece[1:]), 1)[apart], axis=1).tolist():
        if low < high:
            points |= set(range(2 * low + 1, 2 * high))
        elif 2 * low in points:  # twice in one piece, whose points are of different lines then
            points |= {2 * low - 1, 2 * low + 1}
        else:
            points.add(2 * low)
    return sorted(points)
