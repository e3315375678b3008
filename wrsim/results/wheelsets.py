"""One wheelset out of the dataset of a result."""

from __future__ import annotations

import numpy as np
import xarray as xr

from wrsim.errors import InputError, suggest
from wrsim.results.dataset import OF_VEHICLE


def wheelsets(dataset: xr.Dataset) -> tuple[str, ...]:
    """Names of the wheelsets, front first."""
    return tuple(str(name) for name in np.atleast_1d(dataset["wheelset"].values))


def of_wheelset(dataset: xr.Dataset, name: str | None = None) -> xr.Dataset:
    """What a dataset holds of one wheelset, without the dimension ``wheelset``; of the only one without a name.

    ``distance`` is that of the wheelset. What belongs to bodies, points, suspension, loads and events is left out.
    Raises InputError for a name that is none of the wheelsets, and when there are several to choose from.
    """
    names = wheelsets(dataset)
    if name is None and len(names) == 1:
        name = names[0]
    if name not in names:
        what = f"no wheelset is called '{name}'{suggest(name, names)}" if name else "choose one of the wheelsets"
        raise InputError(f"{what}; there are {', '.join(names)}" if name else f"{what}: {', '.join(names)}")
    if "wheelset" not in dataset.dims:
        return dataset
    one = dataset.sel(wheelset=name).drop_dims([*OF_VEHICLE, "event"], errors="ignore")
    if len(names) > 1:
        one.attrs["title"] = f"{dataset.attrs['title']}: {name}"
    if "wheelset_distance" not in one:
        return one
    own = one["wheelset_distance"].values
    if "snapshot_distance" in one and len(names) > 1:
        at = np.interp(one["snapshot_time"].values, one["time"].values, own)
        one["snapshot_distance"] = ("snapshot", at, dict(one["snapshot_distance"].attrs))
    distance = xr.Variable(("time",), own, dict(dataset["distance"].attrs))
    return one.drop_vars("wheelset_distance").assign_coords(distance=distance)


def worst_wheelset(dataset: xr.Dataset) -> str:
    """The wheelset with the largest derailment quotient; the first one where there is none."""
    names = wheelsets(dataset)
    if "Y_over_Q" not in dataset or len(names) == 1:
        return names[0]
    quotient = np.nan_to_num(dataset["Y_over_Q"].values, nan=-np.inf).max(axis=(0, 2))
    return names[int(np.argmax(quotient))]
