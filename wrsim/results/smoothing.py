"""What smoothing did to measured points: curvature before and after, and how far the shape moved.

A cut-off is right when the curvature after it is that of the steel and the change is that of the measurement: an RMS
change well above the scatter of the points means that shape was smoothed away, a largest curvature far above that of
the drawing that noise was left.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from wrsim.contact.profiles.files import Reading
from wrsim.contact.profiles.points import ProfilePoints, scatter
from wrsim.contact.profiles.profile import Array, Kind, Profile, curvature_of, plane_cross
from wrsim.errors import InputError
from wrsim.results.table import Cell, Column, Table, quantity

MOST_CUTOFFS = 4
KINDS: dict[str | None, Kind | None] = {None: None, "wheel": "wheel", "rail": "rail"}


@dataclass(frozen=True)
class SmoothingReport:
    """Measured points beside the profile smoothed from them.

    points: measured; cutoff: wavelength that smoothing halves [m]; profile: smoothed; bare_curvature (n,): of the cubic
    spline through the bare points [1/m]; change (n,): distance of every point from the smoothed curve, positive to its
    left (up on a rail's crown) [m].
    """

    points: ProfilePoints
    cutoff: float
    profile: Profile
    bare_curvature: Array
    change: Array

    def numbers(self) -> dict[str, float]:
        """Scatter of neighbouring points across the curve, as of independent errors; largest curvatures before and
        after, without sign, and u of the latter; the change."""
        p, after, most = self.profile, np.abs(self.profile.curvature_after), int(np.argmax(np.abs(self.change)))
        return {
            "cutoff_mm": 1e3 * self.cutoff,
            "points": len(self.points),
            "scatter_um": 1e6 * scatter(self.points),
            "largest_curvature_before_1_per_m": float(np.abs(self.bare_curvature).max()),
            "largest_curvature_after_1_per_m": float(max(np.abs(p.curvature_before).max(), after.max())),
            "at_u_mm": 1e3 * float(p.u[int(np.argmax(after))]),
            "rms_change_um": 1e6 * float(np.sqrt(np.mean(self.change**2))),
            "largest_change_um": 1e6 * float(abs(self.change[most])),
            "largest_change_at_u_mm": 1e3 * float(self.points.u[most]),
            "largest_change_at_line": int(self.points.line[most]),
        }


def report_smoothing(reading: Reading) -> SmoothingReport:
    """Compare a reading's points with its smoothed curve. Raises InputError for a shape without points."""
    points, profile = reading.points, reading.profile
    if points is None:
        raise InputError(f"{profile.name}: is a shape by formula, with no points to smooth: leave --cutoff out")
    p = points.places
    spline = scipy.interpolate.CubicSpline(np.concatenate([[0.0], np.cumsum(points.chords)]), p)
    bare = curvature_of(spline(spline.x, 1), spline(spline.x, 2))
    L = profile.arclength[scipy.spatial.cKDTree(np.column_stack([profile.u, profile.w])).query(p)[1]]
    for _ in range(3):  # to the foot: nodes are 0.1 mm apart and nearly there
        t = np.stack(profile.tangent(L), axis=-1)
        L = np.clip(L + ((p - np.stack(profile.at(L), axis=-1)) * t).sum(axis=1), 0.0, profile.length)
    change = plane_cross(np.stack(profile.tangent(L), axis=-1), p - np.stack(profile.at(L), axis=-1))
    return SmoothingReport(points, reading.cutoff, profile, bare, change)


def smoothing_table(reports: Sequence[SmoothingReport]) -> Table:
    """Curvature before and after, and how far smoothing moved the points, one line a cut-off."""
    numbers = [report.numbers() for report in reports]
    rows: list[Sequence[Cell]] = [("none", numbers[0]["largest_curvature_before_1_per_m"], *[""] * 5)]
    for row in numbers:
        *_, after, at_u, rms, most, where, line = row.values()
        rows.append((quantity(row["cutoff_mm"], "mm", "g"), after, at_u, rms, most, where, str(line)))
    heads = (
        Column("cut-off"), Column("largest curvature", "1/m"), Column("at u", "mm", ".2f"),
        Column("RMS change", "µm", ".3g"), Column("largest", "µm", ".3g"), Column("at u", "mm", ".2f"), Column("line"),
    )  # fmt: skip
    spread = quantity(numbers[0]["scatter_um"], "µm", ".3g")
    return Table(f"{numbers[0]['points']} points, which scatter by {spread} across the curve", heads, rows)


def body_of(kind: str | None) -> Kind | None:
    """The body of ``--kind``. Raises InputError."""
    if kind not in KINDS:
        raise InputError(f"--kind {kind}: must be wheel or rail")
    return KINDS[kind]


def check_cutoffs(cutoffs: Sequence[float]) -> None:
    """Raise InputError for cut-offs [mm] that cannot be."""
    for value in cutoffs:
        if not 0.0 < value <= 100.0:
            raise InputError(f"--cutoff {value:g}: must be a number above 0 and at most 100 (mm)")
    if len(cutoffs) > MOST_CUTOFFS:
        raise InputError(f"--cutoff: {len(cutoffs)} of them; must be at most {MOST_CUTOFFS}")


def smoothing_reports(reading: Reading, cutoffs: Sequence[float]) -> tuple[SmoothingReport, ...]:
    """A report for every cut-off [mm]; of measured points also without any given. Raises InputError for a shape without
    points."""
    if not (cutoffs or reading.measured):
        return ()
    readings = [reading.smoothed(1e-3 * value) for value in dict.fromkeys(cutoffs)]
    return tuple(report_smoothing(r) for r in readings or [reading])
