"""Summary and table of a steady analysis."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.rows import Row, long
from wrsim.results.summary import extent

COLUMNS = (
    "pose", "wheelset", "wheel", "pose_radius", "pose_cant", "pose_speed", "cant_deficiency", "unbalanced",
    "lateral_shift", "yaw", "roll", "Y", "Q", "X", "Y_over_Q", "T_gamma", "n_patches",
    "N", "contact_angle", "p0", "xi", "eta", "phi", "pose_message",
)  # fmt: skip
"""Columns of the table of steady motions; those of patches are of the one with the largest normal force."""


def summary(dataset: xr.Dataset) -> dict[str, Any]:
    """How many curves have a steady motion, which have none, and the largest Y/Q with its place."""
    messages = zip(dataset["pose"].values, dataset["pose_message"].values, strict=True)
    quotient = dataset["Y_over_Q"]
    worst = quotient.isel(quotient.argmax(dim=quotient.dims))  # type: ignore[arg-type]
    place = {name: str(worst[name].item()) for name in ("pose", "wheelset", "wheel")}
    return {
        "extent": extent(dataset),
        "without_steady_motion": {str(name): str(message) for name, message in messages if message},
        "Y_over_Q_max": {"value": worst.item(), **place},
    }


def tables(dataset: xr.Dataset) -> Iterator[tuple[str, list[Row]]]:
    """One row per curve, wheelset and wheel; a curve without a steady motion keeps one row, with its message."""
    solved = np.broadcast_to((dataset["pose_message"].values == "")[:, None, None], dataset["Y"].shape).copy()
    failed = ~solved[:, 0, 0]
    solved[failed, 0, 0] = True
    said = [name for name in ("contact_remark",) if name in dataset]
    table = long(dataset.isel(patch=0), [*COLUMNS, *said], solved, ("pose", "wheelset", "wheel"))
    message = len(COLUMNS) - 1
    for row in table[1:]:
        if row[message]:
            row[1:3], row[8:message] = ["", ""], [""] * (message - 8)
    yield "steady", table
