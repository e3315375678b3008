"""Rails that change along the track: the crossing 56E1-R245-1:9.25 of the reference folder, and simple shapes."""

from __future__ import annotations

import csv
import gzip
from functools import cache
from itertools import groupby
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from wrsim.geometry.profile.points import profile_from_curve
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.track.rail_surface import RailSection, RailSurface

CROSSING = Path(__file__).parents[3] / "shared" / "reference" / "crossing_56e1"
NOSE_DEPTH = -0.03  # [m]


def lifted(rail: Profile, places: NDArray[np.float64], heights: NDArray[np.float64]) -> RailSurface:
    """A rail whose height changes along the track and whose profile does not."""
    return RailSurface(
        "lifted",
        tuple(RailSection(float(s), rail.shifted(0.0, float(z))) for s, z in zip(places, heights, strict=True)),
    )


@cache
def crossing(start: float, end: float) -> RailSurface:
    """The sections of the crossing between two places [m]; features: edges of the nose, foot of the gap, wing's
    corner."""
    with gzip.open(CROSSING / "sections.csv.gz", "rt") as file:
        rows = [
            (float(r["position_m"]), float(r["y_mm"]), float(r["z_mm"]))
            for r in csv.DictReader(line for line in file if not line.startswith("#"))
            if r["part"] == "crossing"
        ]
    sections = []
    for place, points in groupby(rows, key=lambda row: row[0]):
        if start <= place <= end:
            p = 1e-3 * np.array([(y, -z) for _s, y, z in points])
            p = p[np.append(True, np.hypot(*np.diff(p, axis=0).T) > 1e-5)]
            sections.append(_section(place, p))
    return RailSurface("56E1 crossing", tuple(sections))


def _section(place: float, points: NDArray[np.float64]) -> RailSection:
    """A section with its features: a nose is there where the outline has a deep place between its ends."""
    arc = np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
    profile = profile_from_curve(CubicSpline(arc, points), arc, f"section at {place:g} m", "rail", "")
    u, w, angle = profile.u, profile.w, np.degrees(profile.angle)
    inner = (u > u.min() + 0.01) & (u < u.max() - 0.02)
    foot = int(np.flatnonzero(inner)[np.argmin(w[inner])])
    nose = w[foot] < w[:foot].max(initial=-1.0) - 0.02
    foot = foot if nose else 0
    corner = foot + int(np.flatnonzero((angle[foot:] < 45.0) & (w[foot:] > -0.02))[0])
    edges = [0, 0]
    if nose:
        left = int(np.flatnonzero(angle[:foot] < 20.0)[0])
        right = int(np.flatnonzero((angle[:foot] > -45.0) & (w[:foot] > NOSE_DEPTH))[-1])
        edges = [left, right]
    return RailSection(place, profile, tuple(float(profile.arclength[i]) for i in (*edges, foot, corner)))
