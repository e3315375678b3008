"""The moments of which a result holds contact patches: kept instants of a run, or poses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.errors import InputError, suggest

NEAR = 1.0
"""Distance to the place asked for at which kept patches still count as being there [m]."""


def has_patches(dataset: xr.Dataset) -> bool:
    """True when the dataset holds strips of at least one moment."""
    return "strip_p" in dataset and bool(np.isfinite(dataset["strip_p"].values).any())


def with_patches(dataset: xr.Dataset) -> NDArray[np.bool_]:
    """Of every moment, whether it holds strips."""
    strips = np.isfinite(dataset["strip_p"].values)
    return strips.reshape(strips.shape[0], -1).any(axis=1)


def order_of_strips(s: NDArray[np.float64], p: NDArray[np.float64]) -> NDArray[np.intp]:
    """Places of strips that have a pressure, by increasing s."""
    used = np.flatnonzero(np.isfinite(p))
    return used[np.argsort(s[used], kind="stable")]


def moment_dim(dataset: xr.Dataset) -> str:
    """``"snapshot"`` in runs, ``"pose"`` in static analyses."""
    return "snapshot" if "time" in dataset.dims else "pose"


def sample_of(dataset: xr.Dataset, moment: int) -> int:
    """Index along ``time`` or ``pose`` of the values that belong to the moment."""
    if moment_dim(dataset) == "pose":
        return moment
    return int(np.argmin(np.abs(dataset["time"].values - dataset["snapshot_time"].values[moment])))


def moments_at(dataset: xr.Dataset, at: Sequence[str | float], key: str) -> list[int]:
    """Indices of the moments at these distances along the track [m], or of the poses of these names.

    key: what the places were given as, for messages. Raises InputError.
    """
    if not has_patches(dataset):
        raise InputError(f"{key}: this result holds no contact patches; choose places with [output] patches_at_m")
    if "pose" in dataset.dims:
        names = [str(name) for name in dataset["pose"].values]
        asked = [str(place) for place in at]
        for name in asked:
            if name not in names:
                raise InputError(f"{key} {name}: there is no such pose{suggest(name, names)}; {_some(names)}")
        return [names.index(name) for name in asked]
    distances = [float(d) for d in dataset["snapshot_distance"].values]
    moments = []
    for place in at:
        try:
            offsets = [abs(d - float(place)) for d in distances]
        except (TypeError, ValueError):
            raise InputError(f"{key} {place}: must be a distance in m") from None
        if not min(offsets) <= NEAR:
            kept = _some([f"{d:.1f}" for d in distances])
            raise InputError(f"{key} {place}: no patches are kept within {NEAR:g} m of there; {kept}")
        moments.append(offsets.index(min(offsets)))
    return moments


def _some(names: list[str], most: int = 12) -> str:
    """What there is, cut short."""
    return "there are " + ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
