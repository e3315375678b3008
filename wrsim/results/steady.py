"""Summary and table of a steady analysis."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.channels import CHANNELS
from wrsim.results.summary import extent
from wrsim.results.table import Column, Table
from wrsim.results.tables import Row, long

COLUMNS = (
    "pose", "wheelset", "wheel", "pose_radius", "pose_cant", "pose_speed", "cant_deficiency", "unbalanced",
    "lateral_shift", "yaw", "roll", "Y", "Q", "X", "Y_over_Q", "T_gamma", "n_patches",
    "N", "contact_angle", "p0", "xi", "eta", "phi", "pose_message",
)  # fmt: skip
"""Columns of the table of steady motions; those of patches are of the one with the largest normal force."""

SHOWN = {
    "pose_radius": ("R", ".5g"), "pose_cant": ("cant", ".4g"), "pose_speed": ("speed", ".4g"),
    "lateral_shift": ("shift", ".2f"), "yaw": ("attack", ".2f"), "Y": ("Y", ".2f"), "Q": ("Q", ".2f"),
    "Y_over_Q": ("Y/Q", ".3f"), "T_gamma": ("Tγ", ".0f"),
}  # fmt: skip
"""Channels in the table for people, with headings and formats."""


def summarise_steady(dataset: xr.Dataset) -> dict[str, Any]:
    """How many curves have a steady motion, which have none, the largest Y/Q with its place."""
    messages = zip(dataset["pose"].values, dataset["pose_message"].values, strict=True)
    quotient = dataset["Y_over_Q"]
    worst = quotient.isel(quotient.argmax(dim=quotient.dims))  # type: ignore[arg-type]
    place = {name: str(worst[name].item()) for name in ("pose", "wheelset", "wheel")}
    return {
        "extent": extent(dataset),
        "without_steady_motion": {str(name): str(message) for name, message in messages if message},
        "Y_over_Q_max": {"value": worst.item(), **place},
    }


def csv_of_steady(dataset: xr.Dataset) -> Iterator[tuple[str, list[Row]]]:
    """One row per curve, wheelset and wheel; a curve without a steady motion keeps one row, with its message."""
    solved = np.broadcast_to((dataset["pose_message"].values == "")[:, None, None], dataset["Y"].shape).copy()
    failed = ~solved[:, 0, 0]
    solved[failed, 0, 0] = True
    remarks = [name for name in ("contact_remark",) if name in dataset]
    table = long(dataset.isel(patch=0), [*COLUMNS, *remarks], solved, ("pose", "wheelset", "wheel"))
    message = len(COLUMNS) - 1
    for row in (row for row in table[1:] if row[message]):
        row[1:3], row[8:message] = ["", ""], [""] * (message - 8)
    yield "steady", table


def steady_tables(dataset: xr.Dataset, summary: dict[str, Any]) -> list[Table]:
    """One line a curve: the wheel with the largest Y/Q; curves without a steady motion with the reason."""
    rows = []
    for i in np.flatnonzero(dataset["pose_message"].values == "").tolist():
        curve = dataset.isel(pose=i)
        curve = curve.isel(curve["Y_over_Q"].argmax(dim=curve["Y_over_Q"].dims))  # type: ignore[arg-type]
        values = (curve[name].item() * CHANNELS[name].shown.factor for name in SHOWN)
        rows.append((f"{curve['wheelset'].item()} {curve['wheel'].item()}", *values))
    heads = (Column.of(CHANNELS[name], label, form) for name, (label, form) in SHOWN.items())
    notes = (f"{name}: {message}" for name, message in summary["without_steady_motion"].items())
    return [Table(str(dataset.attrs["title"]), (Column("largest Y/Q on"), *heads), rows, tuple(notes))]
