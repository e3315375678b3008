"""Rails that change along the track: the crossing 56E1-R245-1:9.25 of the reference folder, and simple shapes."""

import csv
import gzip
from dataclasses import replace
from functools import cache
from itertools import groupby, pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from support.contacts import PLAIN, RADIUS, contact_model
from wrsim import ContactModel, Profile
from wrsim.contact.surfaces.rail_surface import RailSection, RailSurface, read_sections
from wrsim.contact.surfaces.rolled_rail import rolled_rail

NOSE_DEPTH = -30.0  # [mm]
OUTER_EDGE = (31.0, 25.0, 3.8)  # of the head: where it is, at least so far from the corner; how far it falls off [mm]


def lifted(rail: Profile, places: NDArray[np.float64], heights: NDArray[np.float64]) -> RailSurface:
    """A rail whose height changes along the track and whose profile does not."""
    return RailSurface(
        "lifted",
        tuple(RailSection(float(s), rail.shifted(0.0, float(z))) for s, z in zip(places, heights, strict=True)),
    )


def on(surface: RailSurface, normal: str, wheel: Profile, **choices: Any) -> ContactModel:
    """A wheel on a rail of sections, without creep forces if not told otherwise."""
    model = contact_model(wheel, surface.sections[0].profile, normal=normal, **PLAIN | choices)
    return replace(model, rolled=rolled_rail(surface, RADIUS))


def turning(rail: Profile, places: NDArray[np.float64], twist: float) -> RailSurface:
    """A rail whose section turns about its origin; twist: positive where its outer side rises [rad/m]."""
    return RailSurface("turning", tuple(RailSection(float(s), rail.rotated(twist * float(s))) for s in places))


@cache
def crossing(folder: Path, start: float, end: float) -> RailSurface:
    """The sections of the crossing between two places [m]; features: edges of the nose, foot of the gap, wing's
    corner. folder: of its tables."""
    with TemporaryDirectory() as scratch:
        table = Path(scratch) / "crossing.csv"
        write_crossing(folder, table, start, end)
        return RailSurface("56E1 crossing", tuple(read_sections(table)))


@cache
def write_crossing(folder: Path, path: Path, start: float, end: float) -> None:
    """The same as a table of sections for [[track.rail_sections]]; the gauge face is that of the reference, whose
    origin lies 750 mm from the middle of its track."""
    with gzip.open(folder / "sections.csv.gz", "rt") as file:
        rows = [
            (float(r["position_m"]), float(r["y_mm"]), -float(r["z_mm"]))
            for r in csv.DictReader(line for line in file if not line.startswith("#"))
            if r["part"] == "crossing"
        ]
    lines = ["at_m,outward_mm,up_mm,feature"]
    for place, points in groupby(rows, key=lambda row: row[0]):
        if start <= place <= end:
            p = np.array([(y, z) for _s, y, z in points])
            p = p[np.append(True, np.hypot(*np.diff(p, axis=0).T) > 1e-2)]
            arc, features = _features(p)
            marks = {a: " ".join(str(k) for k, f in enumerate(features, 1) if f == a) for a in features}
            # a feature that lies within reach of a point takes it along
            places = np.array([*(a for a in arc if np.abs(np.array(features) - a).min() > 0.05), *marks])
            places.sort()
            curve = CubicSpline(arc, p)
            lines += [
                f"{place!r},{y:.9f},{z:.9f},{marks.get(a, '')}" for a, (y, z) in zip(places, curve(places), strict=True)
            ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _features(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], tuple[float, ...]]:
    """Arclengths of the points of a section, and of its features [mm]: a nose is there where the outline has a deep
    place between its ends."""
    knots = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    curve = CubicSpline(knots, points)
    arc = np.concatenate(
        [np.linspace(a, b, int(np.ceil(10 * (b - a))), endpoint=False) for a, b in pairwise(knots)] + [knots[-1:]]
    )
    (u, w), along = curve(arc).T, curve(arc, 1)
    angle = np.degrees(np.unwrap(np.arctan2(along[:, 1], along[:, 0])))
    inner = (u > u.min() + 10.0) & (u < u.max() - 20.0)
    foot = int(np.flatnonzero(inner)[np.argmin(w[inner])])
    nose = w[foot] < w[:foot].max(initial=-1e3) - 20.0
    foot = foot if nose else 0
    corner = foot + int(np.flatnonzero((angle[foot:] < 45.0) & (w[foot:] > -20.0))[0])
    # a planed top runs out at a place that stays: its outer edge, and what falls off beyond it
    top = np.append(
        np.flatnonzero((np.arange(u.size) > corner) & (u > max(OUTER_EDGE[0], u[corner] + OUTER_EDGE[1]))), u.size - 1
    )[0]
    beyond = np.append(np.flatnonzero((np.arange(u.size) > top) & (u > u[top] + OUTER_EDGE[2])), u.size - 1)[0]
    edges = [0, 0]
    if nose:
        left = int(np.flatnonzero(angle[:foot] < 20.0)[0])
        right = int(np.flatnonzero((angle[:foot] > -45.0) & (w[:foot] > NOSE_DEPTH))[-1])
        edges = [left, right]
    return knots, tuple(float(arc[i]) for i in (*edges, foot, corner, int(top), int(beyond)))


def branches_that_cross(count: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Rows (u, w, tangent) of a curve parallel to a parabola, beyond its centre of curvature: branches cross at u = 0,
    half way between the ends of a loop at t = -.866 and .866 of -1.2 to 1.2 along it."""
    t = np.linspace(-1.2, 1.2, count)
    root = np.sqrt(1.0 + 4.0 * t * t)
    return np.column_stack((t - 2.0 * t / root, t * t + 1.0 / root, 1.0 / root, 2.0 * t / root))
