"""Summary and table of an analysis of flange climbing."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.channels import CHANNELS
from wrsim.results.summary import extent
from wrsim.results.table import Column, Table
from wrsim.results.tables import Row, long

COLUMNS = (
    "pose", "attack", "climb_quotient", "nadal_limit", "climbed", "climb_distance", "climb_distance_tcrp",
    "climb_shift", "climb_lift", "pose_message",
)  # fmt: skip
SHOWN = {
    "attack": ("attack", "g"), "climb_quotient": ("Y/Q", ".3f"), "climb_distance": ("distance", ".3f"),
    "climb_distance_tcrp": ("TCRP 71", ".3f"),
}  # fmt: skip
"""Channels in the table for people, with headings and formats."""


def summarise_climb(dataset: xr.Dataset) -> dict[str, Any]:
    """Nadal's limit, the flange, the shortest way of a climb and how many points the rail has held."""
    climbed = dataset["climbed"].values == 1
    ways = dataset["climb_distance"].values[climbed]
    messages = zip(dataset["pose"].values, dataset["pose_message"].values, strict=True)
    return {
        "extent": extent(dataset),
        "nadal_limit": dataset["nadal_limit"].values[0].item(),
        "flange_angle_deg": float(np.degrees(dataset["flange_angle"].values[0])),
        "flange_length_mm": 1e3 * dataset["flange_length"].values[0].item(),
        "climbed": int(climbed.sum()),
        "climb_distance_min_m": float(ways.min()) if ways.size else None,
        "without_result": {str(name): str(message) for name, message in messages if message},
    }


def csv_of_climb(dataset: xr.Dataset) -> Iterator[tuple[str, list[Row]]]:
    """One row per angle of attack and Y/Q."""
    yield "climb", long(dataset, [*COLUMNS], np.ones(dataset.sizes["pose"], dtype=bool), ("pose",))


def climb_tables(dataset: xr.Dataset, summary: dict[str, Any]) -> list[Table]:
    """One line per angle of attack and Y/Q."""
    rows = []
    for i in np.flatnonzero(dataset["pose_message"].values == "").tolist():
        pose = dataset.isel(pose=i)
        values = (pose[name].item() * CHANNELS[name].shown.factor for name in SHOWN)
        rows.append((*values, "climbs" if pose["climbed"].item() else "is held"))
    heads = (Column.of(CHANNELS[name], label, form) for name, (label, form) in SHOWN.items())
    label = (
        f"flange of {summary['flange_angle_deg']:.1f}° and {summary['flange_length_mm']:.1f} mm, "
        f"Nadal's limit {summary['nadal_limit']:.3f}"
    )
    notes = (label, *(f"{name}: {message}" for name, message in summary["without_result"].items()))
    return [Table(str(dataset.attrs["title"]), (*heads, Column("wheel")), rows, notes)]
