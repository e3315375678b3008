"""What smoothing did to measured points: curvature before and after, and how far the shape moved.

A cut-off is right when the curvature after it is that of the steel and the change is that of the measurement: an RMS
change well above the scatter of the points says that shape was smoothed away, a largest curvature far above that of the
drawing that noise was left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from wrsim.geometry.profile.files import Reading
from wrsim.geometry.profile.points import ProfilePoints, scatter
from wrsim.geometry.profile.profile import Array, Profile, curvature_of, plane_cross


@dataclass(frozen=True)
class SmoothingReport:
    """Measured points beside the profile smoothed from them.

    reading: the points; profile: smoothed; bare_curvature (n,): of the cubic spline through the bare points [1/m];
    change (n,): distance of every point from the smoothed curve, positive to its left (up on a
    rail's crown) [m].
    """

    reading: Reading
    profile: Profile
    bare_curvature: Array
    change: Array

    @property
    def points(self) -> ProfilePoints:
        """The measured points."""
        return self.reading.points

    @property
    def cutoff(self) -> float:
        """Wavelength that smoothing halves [m]."""
        return self.reading.cutoff

    @property
    def curvature_before(self) -> float:
        """Largest curvature of the spline through the bare points, without sign [1/m]."""
        return float(np.abs(self.bare_curvature).max())

    @property
    def curvature_after(self) -> float:
        """Largest curvature of the smoothed profile, without sign [1/m]."""
        p = self.profile
        return float(max(np.abs(p.curvature_before).max(), np.abs(p.curvature_after).max()))

    @property
    def sharpest(self) -> float:
        """u of the largest curvature of the smoothed profile [m]."""
        return float(self.profile.u[int(np.argmax(np.abs(self.profile.curvature_after)))])

    @property
    def scatter(self) -> float:
        """Scatter of neighbouring points across the curve, as of independent errors [m]."""
        return scatter(self.points)

    @property
    def rms_change(self) -> float:
        """Root mean square of the change [m]."""
        return float(np.sqrt(np.mean(self.change**2)))

    @property
    def largest_change(self) -> tuple[float, float, int]:
        """Largest change [m], without sign, where it is (u) [m], and the line of the file."""
        i = int(np.argmax(np.abs(self.change)))
        return float(abs(self.change[i])), float(self.points.u[i]), int(self.points.line[i])

    def numbers(self) -> dict[str, float]:
        """The figures in the units people read."""
        most, where, line = self.largest_change
        return {
            "cutoff_mm": 1e3 * self.cutoff,
            "points": len(self.points),
            "scatter_um": 1e6 * self.scatter,
            "largest_curvature_before_1_per_m": self.curvature_before,
            "largest_curvature_after_1_per_m": self.curvature_after,
            "at_u_mm": 1e3 * self.sharpest,
            "rms_change_um": 1e6 * self.rms_change,
            "largest_change_um": 1e6 * most,
            "largest_change_at_u_mm": 1e3 * where,
            "largest_change_at_line": line,
        }


def report_smoothing(reading: Reading) -> SmoothingReport:
    """Smooth a reading's points and compare. Raises InputError where they are too far apart for the cut-off."""
    points = reading.points
    profile = reading.profile()
    s = np.concatenate([[0.0], np.cumsum(points.chords)])
    spline = CubicSpline(s, points.places)
    return SmoothingReport(reading, profile, curvature_of(spline(s, 1), spline(s, 2)), _change(profile, points))


def _change(profile: Profile, points: ProfilePoints) -> Array:
    """Signed distance of points from a profile (n,), positive to the left of the curve."""
    p = points.places
    L = profile.arclength[cKDTree(np.column_stack([profile.u, profile.w])).query(p)[1]]
    for _ in range(3):  # to the foot: nodes are 0.1 mm apart and nearly there
        t = np.stack(profile.tangent(L), axis=-1)
        L = np.clip(L + ((p - np.stack(profile.at(L), axis=-1)) * t).sum(axis=1), 0.0, profile.length)
    t = np.stack(profile.tangent(L), axis=-1)
    away = p - np.stack(profile.at(L), axis=-1)
    return plane_cross(t, away)
