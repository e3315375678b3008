"""How the poses of a static analysis make lines: what varies along a line, what from line to line."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.plots.style import shown
from wrsim.results import CHANNELS

ABSCISSAE = ("lateral_shift", "yaw", "load")
"""Channels of a pose that may stand on the horizontal axis, in order of preference."""


def pose_abscissa(dataset: xr.Dataset) -> str:
    """The channel on the horizontal axis: lateral shift, unless only yaw or load vary."""
    varied = [n for n in ABSCISSAE if n in dataset and np.ptp(dataset[n].values) > 0.0]
    return varied[0] if varied else "lateral_shift"


def pose_groups(dataset: xr.Dataset) -> list[tuple[str, NDArray[np.intp]]]:
    """Poses that make one line: label and indices in the order of the horizontal axis."""
    across = pose_abscissa(dataset)
    others = [n for n in ABSCISSAE if n in dataset and n != across and np.ptp(dataset[n].values) > 0.0]
    x = dataset[across].values
    if not others:
        return [("", np.argsort(x, kind="stable"))]
    keys = np.column_stack([np.round(shown(dataset, n), 9) for n in others])
    groups = []
    for key in np.unique(keys, axis=0):
        member = np.flatnonzero((keys == key).all(axis=1))
        words = (f"${CHANNELS[n].symbol}$ = " if CHANNELS[n].symbol else "" for n in others)
        label = ", ".join(
            f"{word}{value + 0.0:.4g} {CHANNELS[n].shown.symbol}"
            for word, value, n in zip(words, key, others, strict=True)
        )
        groups.append((label.replace("-", "\N{MINUS SIGN}"), member[np.argsort(x[member], kind="stable")]))
    return groups
