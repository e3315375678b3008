"""Class of track of a recording by 49 CFR 213, subparts A and C, for every 100 ft.

Uniform is the design of the recorded track: a deviation from uniformity is the mid-chord offset of a rail beside it.
In curves and spirals the outer rail counts for alinement, on tangents the worse one.
"""

from collections.abc import Mapping
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d, uniform_filter1d

from wrsim.inputs.us_units import FOOT
from wrsim.recording.restoring import Restored
from wrsim.results.channels import table
from wrsim.results.table import Column, Table
from wrsim.track.piecewise import Array

INCH = 0.0254
WINDOW = 100.0 * FOOT  # [m]
STANDARD_GAGE = 56.5  # [in]
SPEEDS = ((0, 0), (10, 15), (25, 30), (40, 60), (60, 80), (80, 90))
"""Freight and passenger trains over classes 0 (none) to 5 [mph]: 213.9(a) [read]."""
UNBALANCE = 3.0  # cant deficiency for which all vehicles are qualified [in]: 213.57(c) [read]
BODY = 155.0 * FOOT  # length over which elevation and curvature are averaged [m]: 213.57(b), footnotes [read]
HIGH = 6.0  # elevation from which on another limit of warp holds [in]: 213.63(a), footnote 1 [read]
STRAIGHT = 1e-5  # curvature of the design below which track is tangent [1/m]: R = 100 km
CLASSES = "track_class.csv"
MOST_LISTED = 40  # windows that the terminal lists
Key: TypeAlias = tuple[str, int, str]
Quantities: TypeAlias = Mapping[Key, Array]
LIMITS: dict[Key, list[float]] = {
    (row["deviation"], int(row["chord_ft"]), row["course"]): [float(row[str(c)] or "inf") for c in range(1, 6)]
    for row in table("wrsim.scenario", "data/track_classes.csv")
}
"""Limits of classes 1 to 5 [in] by quantity, chord and course; infinite where there is none."""
COLUMNS = (
    Column("from", "m", ".5g", "from_m"), Column("to", "m", ".5g", "to_m"), Column("class", "", "d", "track_class"),
    Column("limited by", key="limited_by"), Column("value", "in", ".3f", "value_in"),
    Column("limit", "in", ".4g", "limit_in"), Column("place", "m", ".5g", "place_m"),
    Column("freight", "mph", "d", "freight_mph"), Column("passenger", "mph", "d", "passenger_mph"),
    Column("Vmax of curve", "mph", ".3g", "curve_mph"),
)  # fmt: skip


class ClassWindow(NamedTuple):
    """Verdict on 100 ft.

    from_m, to_m, place_m: distances in the recording; track_class: highest class whose limits all hold, 0 for none;
    limited_by: quantity with the lowest class; value_in, limit_in: the worst value, and the limit of the next class
    (of class 5 its own); freight_mph, passenger_mph: of the class; curve_mph: Vmax of 213.57(b), None on tangents.
    """

    from_m: float
    to_m: float
    track_class: int
    limited_by: str
    value_in: float
    limit_in: float
    place_m: float
    freight_mph: int
    passenger_mph: int
    curve_mph: float | None


def curve_speed(elevation: Array, curvature: Array) -> Array:
    """Vmax [mph] of 213.57(b) for elevations [in] and curvatures [1/m] at 3 in of unbalance."""
    degrees = np.degrees(2.0 * np.arcsin(np.minimum(50.0 * FOOT * np.abs(curvature), 1.0)))
    return np.asarray(np.sqrt(np.maximum(elevation + UNBALANCE, 0.0) / (7e-4 * np.maximum(degrees, 1e-9))))


def quantities(restored: Restored) -> Quantities:
    """What the law limits, by the keys of `LIMITS` (n,) [in]; not-a-number where it does not apply or is unknown."""
    recording, law = restored.recording, restored.law
    s, step = recording.distance, recording.step
    curvature = law.curvature(s)
    outer = np.where(curvature > STRAIGHT, 1, np.where(curvature < -STRAIGHT, 0, -1))  # row of the outer rail
    tangent, curved = np.where(outer < 0, 1.0, np.nan), np.where(outer < 0, np.nan, 1.0)
    kinds = {channel.kind for channel, _ in recording.records}
    values: dict[Key, Array] = {}

    def offsets(shape: Array, feet: int) -> Array:
        """Size of the mid-chord offsets of both rails (2, n); unknown where the chord ends beyond the recording."""
        half = 0.5 * feet * FOOT
        ends = [[np.interp(s + way, s, rail, np.nan, np.nan) for rail in shape] for way in (-half, half)]
        return np.asarray(np.abs(shape - np.mean(ends, axis=0)) / INCH)

    for kind, name, shape in (("alignment", "alinement", restored.lateral), ("level", "surface", restored.vertical)):
        for feet in (31, 62) if kind in kinds else ():
            rails = offsets(shape, feet)
            of_outer = np.where(outer > 0, rails[1], rails[0]) if kind == "alignment" else rails.max(axis=0)
            values |= {(name, feet, "tangent"): tangent * rails.max(axis=0), (name, feet, "curved"): curved * of_outer}
    if kinds & {"gauge", "gauge_deviation"}:
        gauge = recording.columns.gauge_mm / 1e3 + law.widening(s) + restored.lateral[0] - restored.lateral[1]
        values |= {("gage at least", 0, "both"): gauge / INCH, ("gage at most", 0, "both"): gauge / INCH}
    if kinds & {"cant", "twist"}:
        cant = (law.cant(s) + restored.vertical[1] - restored.vertical[0]) / INCH  # right rail higher
        outward = cant * np.where(outer > 0, 1.0, -1.0)
        rows = 2 * int((0.5 * 62.0 * FOOT - 1e-9) / step) + 1
        higher = maximum_filter1d(outward, 2 * rows - 1, mode="nearest") - outward
        values |= {
            ("crosslevel", 0, "tangent"): tangent * np.abs(cant),
            ("reverse crosslevel", 0, "curved"): curved * np.maximum(-outward, 0.0),
            ("elevation", 0, "curved"): curved * outward,
            ("warp", 62, "both"): maximum_filter1d(cant, rows) - minimum_filter1d(cant, rows),
            ("warp, elevation of 6 in", 62, "curved"): np.where(curved * outward >= HIGH, higher, np.nan),
        }
    return {key: row for key, row in values.items() if key in LIMITS}


def curve_speeds(restored: Restored) -> Array:
    """Vmax in the bodies of curves (n,) [mph], of means over 155 ft or the body; infinite elsewhere."""
    s, law = restored.recording.distance, restored.law
    cant = (law.cant(s) + restored.vertical[1] - restored.vertical[0]) / INCH
    speeds = np.full(s.size, np.inf)
    for p in restored.plateaus:
        body = np.flatnonzero((s >= p.start) & (s <= p.end))
        if not p.is_straight and body.size:
            count = min(body.size, round(BODY / restored.recording.step))
            outward, bend = np.sign(p.curvature) * cant[body], law.curvature(s[body])
            speeds[body] = curve_speed(*(uniform_filter1d(row, count, mode="nearest") for row in (outward, bend)))
    return speeds


def track_classes(restored: Restored, values: Quantities) -> tuple[ClassWindow, ...]:
    """Verdicts by these `quantities` along a recording, one for every 100 ft, the last one for the rest."""
    s, start = restored.recording.distance, restored.recording.start
    speeds, windows = curve_speeds(restored), []
    for begin in np.arange(0.0, s[-1], WINDOW).tolist():
        window = (s >= begin) & (s < begin + WINDOW)
        worst: tuple[int, float, str, float, float, float] = (6, 0.0, "", 0.0, 0.0, 0.0)
        for key, row in values.items():
            if (known := np.flatnonzero(window & np.isfinite(row))).size:
                least = key[0].endswith("at least")
                i = known[np.argmin(row[known]) if least else np.argmax(row[known])]
                holds = [(row[i] >= limit) if least else (row[i] <= limit) for limit in LIMITS[key]]
                track_class = holds.index(False) if False in holds else 5
                limit = LIMITS[key][min(track_class, 4)]
                off = STANDARD_GAGE if key[0].startswith("gage") else 0.0
                used = (row[i] - off) / (limit - off)
                name = key[0] + (f" over {key[1]} ft" if key[1] else "")
                worst = min(worst, (track_class, -float(used), name, float(row[i]), limit, float(start + s[i])))
        track_class, _, name, value, limit, place = worst
        speed = float(speeds[window].min())
        ends = start + begin, start + min(begin + WINDOW, float(s[-1]))
        curve = speed if np.isfinite(speed) else None
        if name:
            windows.append(ClassWindow(*ends, track_class, name, value, limit, place, *SPEEDS[track_class], curve))
    return tuple(windows)


def missing(values: Quantities) -> tuple[str, ...]:
    """Quantities that the recording does not have: they are not assessed."""
    assessed = dict.fromkeys(name for (name, *_), limits in LIMITS.items() if min(limits) < np.inf)
    return tuple(name for name in assessed if name not in {key[0] for key in values})


def class_table(windows: tuple[ClassWindow, ...], most: int = MOST_LISTED, lacking: tuple[str, ...] = ()) -> Table:
    """The windows, of more than ``most`` those of the lowest classes, and how many there are of each class; lacking:
    quantities that are not assessed."""
    counts = {c: sum(w.track_class == c for w in windows) for c in range(6)}
    numbers = ", ".join(f"{n} of class {c}" if c else f"{n} below class 1" for c, n in counts.items() if n)
    lowest = min((w.track_class for w in windows), default=0)
    listed = sorted(sorted(windows, key=lambda w: w.track_class)[:most], key=lambda w: w.from_m)
    notes = (
        f"{len(windows)} windows of 100 ft: {numbers}; the whole is {f'class {lowest}' if lowest else 'below class 1'}",
        f"listed: the {most} lowest; {CLASSES} has all" if len(windows) > most else "",
        f"not recorded and not assessed: {', '.join(lacking)}" if lacking else "",
        "by 213.9(a), .53, .55(a), .57 and .63(a) at 3 in of unbalance; uniform is the design; run-offs of raises, "
        "joints and 213.59 are not assessed; limit: of the next class, of class 5 its own",
    )
    return Table("class of track, 49 CFR 213", COLUMNS, listed, tuple(filter(None, notes)))
