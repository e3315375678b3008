"""From the samples of a channel to one number."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def _peak(values: Array, percentile: float) -> Array:
    """The value of largest magnitude, with its sign."""
    at = np.argmax(np.where(np.isfinite(values), np.abs(values), -1.0), axis=0)
    return np.take_along_axis(values, at[None], axis=0)[0]


def _last(values: Array, percentile: float) -> Array:
    """The last finite value."""
    back = np.isfinite(values)[::-1]
    return np.take_along_axis(values[::-1], np.argmax(back, axis=0)[None], axis=0)[0]


REDUCTIONS: dict[str, Callable[[Array, float], Any]] = {
    "max": lambda values, p: np.nanmax(values, axis=0),
    "min": lambda values, p: np.nanmin(values, axis=0),
    "peak": _peak,
    "mean": lambda values, p: np.nanmean(values, axis=0),
    "median": lambda values, p: np.nanmedian(values, axis=0),
    "rms": lambda values, p: np.sqrt(np.nanmean(values**2, axis=0)),
    "deviation": lambda values, p: np.nanstd(values, axis=0),
    "range": lambda values, p: np.nanmax(values, axis=0) - np.nanmin(values, axis=0),
    "percentile": lambda values, p: np.nanpercentile(values, p, axis=0),
    "last": _last,
}
"""Functions of samples (n, k), with no column without a finite value, and of a percentile, to (k,)."""


def reduced(values: Array, how: str, percentile: float = 50.0) -> float:
    """One number of samples (n, ...): along the first axis, then the worst of all others.

    The worst is the smallest for "min", else the largest; for "peak" the one of largest magnitude. Not-a-number where
    there is no finite value.
    """
    flat = values.reshape(values.shape[0], -1)
    flat = flat[:, np.isfinite(flat).any(axis=0)]
    if flat.size == 0:
        return float("nan")
    each = np.asarray(REDUCTIONS[how](flat, percentile))
    if how == "min":
        return float(each.min())
    return float(each[np.argmax(np.abs(each))] if how == "peak" else each.max())
