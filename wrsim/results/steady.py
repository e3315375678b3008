"""Table and summary of a steady analysis."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.channels import CHANNELS

CURVE = ("pose_radius", "pose_cant", "pose_speed", "cant_deficiency", "unbalanced")
WHEELSET = ("lateral_shift", "yaw", "roll")
WHEEL = ("Y", "Q", "X", "Y_over_Q", "T_gamma", "n_patches")
PATCH = ("N", "contact_angle", "p0", "xi", "eta", "phi")
"""Of the patch with the largest normal force."""


def is_steady(dataset: xr.Dataset) -> bool:
    """True for the dataset of a steady analysis."""
    return "pose_radius" in dataset


def steady_table(dataset: xr.Dataset) -> list[list[str]]:
    """One row per curve, wheelset and wheel; a curve without a steady motion keeps one row, with its message."""
    names = (*CURVE, *WHEELSET, *WHEEL, *PATCH)
    head = [CHANNELS[name].column for name in names]
    rows = [["pose", "wheelset", "wheel", *head, "pose_message"]]
    shown = {name: dataset[name].values * CHANNELS[name].shown.factor for name in names}
    for i, pose in enumerate(dataset["pose"].values):
        message = str(dataset["pose_message"].values[i])
        curve = [_cell(shown[name][i]) for name in CURVE]
        if message:
            rows.append([str(pose), "", "", *curve, *[""] * (len(names) - len(CURVE)), message])
            continue
        for w, wheelset in enumerate(dataset["wheelset"].values):
            for j, wheel in enumerate(dataset["wheel"].values):
                cells = [*curve, *(_cell(shown[name][i, w]) for name in WHEELSET)]
                cells += [_cell(shown[name][i, w, j]) for name in WHEEL]
                cells += [_cell(shown[name][i, w, j, 0]) for name in PATCH]
                rows.append([str(pose), str(wheelset), str(wheel), *cells, ""])
    return rows


def steady_summary(dataset: xr.Dataset) -> dict[str, Any]:
    """How many curves have a steady motion, which have none, and the largest Y/Q with its place."""
    messages = dataset["pose_message"].values
    quotient = dataset["Y_over_Q"].values
    i, w, j = np.unravel_index(int(np.nanargmax(quotient)), quotient.shape)
    return {
        "extent": {"poses": int(messages.size), "solved": int((messages == "").sum())},
        "without_steady_motion": {str(n): str(m) for n, m in zip(dataset["pose"].values, messages, strict=True) if m},
        "Y_over_Q_max": {
            "value": float(quotient[i, w, j]),
            "pose": str(dataset["pose"].values[i]),
            "wheelset": str(dataset["wheelset"].values[w]),
            "wheel": str(dataset["wheel"].values[j]),
        },
    }


def _cell(value: float) -> str:
    return "" if value != value else f"{float(value):.10g}"
