"""A profile for the command ``profile``: loaded, and smoothed with every cut-off that is asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from wrsim.errors import InputError
from wrsim.geometry.profile.models import load_points, load_profile
from wrsim.geometry.profile.profile import Kind, Profile
from wrsim.geometry.profile.smoothing_report import SmoothingReport, report_smoothing

MOST_CUTOFFS = 4


def loaded_and_smoothed(
    file: Path, kind: Kind | None, cutoffs: Sequence[float]
) -> tuple[Profile, tuple[SmoothingReport, ...]]:
    """The profile of a file, and a report for every cut-off [mm]; of measured points also without any asked for.

    Raises InputError for a file that holds no points, and for cut-offs that cannot be.
    """
    for value in cutoffs:
        if not 0.0 < value <= 100.0:
            raise InputError(f"--cutoff {value:g}: must be a number above 0 and at most 100 (mm)")
    if len(cutoffs) > MOST_CUTOFFS:
        raise InputError(f"--cutoff: {len(cutoffs)} of them; must be at most {MOST_CUTOFFS}")
    reading = load_points(file, kind)
    if reading is None:
        if cutoffs:
            raise InputError(f"{file}: is a shape by formula, with no points to smooth: leave --cutoff out")
        return load_profile(file, kind), ()
    if cutoffs:
        readings = [replace(reading, measured=True, cutoff=1e-3 * value) for value in dict.fromkeys(cutoffs)]
    elif reading.measured:
        readings = [reading]
    else:
        return reading.profile(), ()
    reports = tuple(report_smoothing(r) for r in readings)
    return reports[0].profile, reports
