"""One wheelset out of the dataset of a whole vehicle, as the dataset of a lone one."""

from __future__ import annotations

import numpy as np
import xarray as xr

from wrsim.errors import InputError, suggest
from wrsim.results.channels import CHANNELS


def is_vehicle(dataset: xr.Dataset) -> bool:
    """True for the dataset of a whole vehicle."""
    return "wheelset" in dataset.dims


def wheelsets(dataset: xr.Dataset) -> tuple[str, ...]:
    """Names of the wheelsets of a whole vehicle, front first; none for a lone one."""
    return tuple(str(name) for name in dataset["wheelset"].values) if is_vehicle(dataset) else ()


def of_wheelset(dataset: xr.Dataset, name: str) -> xr.Dataset:
    """What a vehicle's dataset holds of one wheelset, with the layout that the result of a lone wheelset has.

    ``distance`` is that of the wheelset. What belongs to bodies, points, suspension and events is left out.
    Raises InputError for a name that is none of its wheelsets.
    """
    names = wheelsets(dataset)
    if name not in names:
        there = f"there are {', '.join(names)}" if names else "this is the result of a lone wheelset"
        raise InputError(f"no wheelset is called '{name}'{suggest(name, names)}; {there}")
    kept = [v for v in dataset.data_vars if CHANNELS[str(v)].of_wheelset or _common(dataset[str(v)])]
    one = dataset[[*kept, "wheelset_distance"]].sel(wheelset=name).drop_vars("wheelset")
    one = one.drop_vars([c for c in one.coords if c in ("body", "point", "suspension")])
    own = one["wheelset_distance"].values
    variable = xr.Variable(("time",), own, dict(dataset["distance"].attrs))
    if "snapshot_distance" in one:
        at = np.interp(one["snapshot_time"].values, one["time"].values, own)
        one["snapshot_distance"] = ("snapshot", at, dict(one["snapshot_distance"].attrs))
    one = one.drop_vars("wheelset_distance").assign_coords(distance=variable)
    one.attrs["title"] = f"{dataset.attrs['title']}: {name}"
    return one


def worst_wheelset(dataset: xr.Dataset) -> str:
    """The wheelset of a whole vehicle with the largest derailment quotient; the first one where there is none."""
    quotient = np.nan_to_num(dataset["Y_over_Q"].values, nan=-np.inf).max(axis=(0, 2))
    return wheelsets(dataset)[int(np.argmax(quotient))]


def _common(variable: xr.DataArray) -> bool:
    """True for what belongs neither to a wheelset nor to other parts of the vehicle."""
    return not {"wheelset", "body", "point", "suspension", "event"} & set(variable.dims)
