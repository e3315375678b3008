"""Dropouts and spikes of a recording: found, bridged where they are short, or what the recording is split at.

A spike is a value, or up to three in a row, that stands out from the running median by more than white noise of the
record would in so many rows, sqrt(2 ln n) deviations, and by more than a rail can: over a length l a rail that is bent
until it yields lies kappa l^2 / 2 off, a dipped joint of angle alpha alpha l / 2. A spike of curvature counts where it
would show in the design, behind the smoothing there.
"""

import re

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.ndimage import median_filter

from wrsim.recording.design import LEAST_CURVATURE, SMOOTHING, noise_of
from wrsim.track.piecewise import Array

Mask = NDArray[np.bool_]

YIELDING = 0.026  # curvature of a rail [1/m] at 500 MPa in a fibre 91 mm off the middle, E = 210 GPa
JOINT = 0.02  # angle of a badly dipped joint [rad], that of the P2 force in British rules
WIDEST = 3  # rows of a spike
CODE = re.compile(r"9{2,}(\.9+)?|3276[78]|65535|214748364[78]|\d(\.\d+)?e\+(\d\d+)")
"""Numbers that stand for none: nines, ends of whole numbers of a computer, and huge ones."""


def codes(values: Array) -> Mask:
    """Where a column has a number such as -999 that stands for none: far outside of all others, by their own range."""
    known = np.unique(values[np.isfinite(values)])
    listed = known[[CODE.fullmatch(f"{abs(v):.9g}") is not None for v in known.tolist()]]
    rest = values[np.isfinite(values) & ~np.isin(values, listed)]
    if not listed.size or not rest.size:
        return np.zeros(values.size, dtype=bool)
    low, high = np.quantile(rest, (0.01, 0.99))
    return np.isin(values, listed[(listed > 2.0 * high - low) | (listed < 2.0 * low - high)])


def spikes(record: Array, step: float, kind: str) -> Mask:
    """Where a record [SI] of a kind, with rows every step [m], has values that no rail can follow."""
    good = np.isfinite(record)
    filled = np.interp(np.arange(record.size), np.flatnonzero(good), record[good]) if good.any() else record
    mask = np.zeros(record.size, dtype=bool)
    narrower = filled
    many = np.sqrt(2.0 * np.log(max(record.size, 2)))
    for rows in range(1, WIDEST + 1):
        length = rows * step
        if kind == "curvature":
            limit = LEAST_CURVATURE * np.sqrt(2.0 * np.pi) * SMOOTHING / length
        else:
            rails = 1.0 if kind in ("alignment", "level") else 2.0
            limit = rails * 0.5 * (YIELDING * length + JOINT) * length
        limit = max(limit, many * noise_of(filled, rows, 0.0))
        smooth = median_filter(filled, 2 * rows + 1, mode="nearest")
        mask |= np.abs(narrower - smooth) > limit  # of just so many rows
        narrower = smooth
    return mask & good


def runs(mask: Mask) -> NDArray[np.intp]:
    """First row of every run of true ones and the row behind it, (n, 2)."""
    return np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(int), [0])))).reshape(-1, 2)


def bridged(distance: Array, record: Array, longest: float) -> Array:
    """A record with its gaps filled, by monotone cubics, where their rows span no more than ``longest`` [m]."""
    good = np.isfinite(record)
    if good.all() or good.sum() < 2:
        return record
    filled = np.where(good, record, PchipInterpolator(distance[good], record[good], extrapolate=False)(distance))
    for begin, end in runs(~good):
        if begin and end < good.size and distance[end - 1] - distance[begin] > longest:
            filled[begin:end] = np.nan
    return filled
