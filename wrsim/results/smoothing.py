"""What smoothing did to measured points of a profile, as a table."""

from __future__ import annotations

from collections.abc import Sequence

from wrsim.geometry.profile.smoothing_report import SmoothingReport
from wrsim.results.table import Cell, Column, Table, quantity


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
