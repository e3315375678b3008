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

    points: measured; cutoff: wavelength that smoothing halves [m]; profile: smoothed; bare_curvature (n,): of the cubic
    spline through the bare points [1/m]; change (n,): distance of every point from the smoothed curve, positive to its
    left (up on a rail's crown) [m]. Largest curvatures before and after, without sign [1/m]; sharpest: u of the latter
    [m]; scatter: of neighbouring points across the curve, as of independent errors [m]; rms_change [m]; largest_change:
    its size [m], u [m] and line of the file.
    """

    points: ProfilePoints
    cutoff: float
    profile: Profile
    bare_curvature: Array
    change: Array
    curvature_before: float
    curvature_after: float
    sharpest: float
    scatter: float
    rms_change: float
    largest_change: tuple[float, float, int]

    def numbers(self) -> dict[str, float]:
        """The figures in the units of the table."""
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
    points, profile = reading.points, reading.profile()
    p = points.places
    spline = CubicSpline(np.concatenate([[0.0], np.cumsum(points.chords)]), p)
    bare = curvature_of(spline(spline.x, 1), spline(spline.x, 2))
    L = profile.arclength[cKDTree(np.column_stack([profile.u, profile.w])).query(p)[1]]
    for _ in range(3):  # to the foot: nodes are 0.1 mm apart and nearly there
        t = np.stack(profile.tangent(L), axis=-1)
        L = np.clip(L + ((p - np.stack(profile.at(L), axis=-1)) * t).sum(axis=1), 0.0, profile.length)
    change = plane_cross(np.stack(profile.tangent(L), axis=-1), p - np.stack(profile.at(L), axis=-1))
    after, most = np.abs(profile.curvature_after), int(np.argmax(np.abs(change)))
    return SmoothingReport(
        points,
        reading.cutoff,
        profile,
        bare,
        change,
        curvature_before=float(np.abs(bare).max()),
        curvature_after=float(max(np.abs(profile.curvature_before).max(), after.max())),
        sharpest=float(profile.u[int(np.argmax(after))]),
        scatter=scatter(points),
        rms_change=float(np.sqrt(np.mean(change**2))),
        largest_change=(float(abs(change[most])), float(points.u[most]), int(points.line[most])),
    )
