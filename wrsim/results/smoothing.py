"""Measured points of a profile and what smoothing did to them, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from wrsim.errors import InputError
from wrsim.geometry.profile.models import load_points, load_profile
from wrsim.geometry.profile.profile import Kind, Profile
from wrsim.geometry.profile.smoothing_report import SmoothingReport, report_smoothing
from wrsim.inputs.lookup import model_file
from wrsim.results.table import Cell, Column, Table, quantity

MOST_CUTOFFS = 4
KINDS: dict[str | None, Kind | None] = {None: None, "wheel": "wheel", "rail": "rail"}


def smoothing_table(reports: Sequence[SmoothingReport]) -> Table:
    """Curvature before and after, and how far smoothing moved the points, one line a cut-off."""
    first = reports[0]
    rows: list[Sequence[Cell]] = [("none", first.curvature_before, *[""] * 5)]
    for r in reports:
        most, where, line = r.largest_change
        found = (r.curvature_after, 1e3 * r.sharpest, 1e6 * r.rms_change, 1e6 * most, 1e3 * where, str(line))
        rows.append((quantity(1e3 * r.cutoff, "mm", "g"), *found))
    heads = (
        Column("cut-off"), Column("largest curvature", "1/m"), Column("at u", "mm", ".2f"),
        Column("RMS change", "µm", ".3g"), Column("largest", "µm", ".3g"), Column("at u", "mm", ".2f"), Column("line"),
    )  # fmt: skip
    scatter = quantity(1e6 * first.scatter, "µm", ".3g")
    return Table(f"{len(first.points)} points, which scatter by {scatter} across the curve", heads, rows)


def profile_and_reports(
    name: str, kind: str | None, cutoffs: Sequence[float], models: Sequence[str | Path] | None
) -> tuple[Profile, tuple[SmoothingReport, ...]]:
    """The profile of a file, and a report for every cut-off [mm]; of measured points also without any asked for. Raises
    InputError for a file that holds no points, and for cut-offs that cannot be."""
    if kind not in KINDS:
        raise InputError(f"--kind {kind}: must be wheel or rail")
    file = model_file(name, models)
    for value in cutoffs:
        if not 0.0 < value <= 100.0:
            raise InputError(f"--cutoff {value:g}: must be a number above 0 and at most 100 (mm)")
    if len(cutoffs) > MOST_CUTOFFS:
        raise InputError(f"--cutoff: {len(cutoffs)} of them; must be at most {MOST_CUTOFFS}")
    reading = load_points(file, KINDS[kind])
    if reading is None and cutoffs:
        raise InputError(f"{file}: is a shape by formula, with no points to smooth: leave --cutoff out")
    if reading is None or not (cutoffs or reading.measured):
        return load_profile(file, KINDS[kind]) if reading is None else reading.profile(), ()
    readings = [replace(reading, measured=True, cutoff=1e-3 * value) for value in dict.fromkeys(cutoffs)]
    reports = tuple(report_smoothing(r) for r in readings or [reading])
    return reports[0].profile, reports
