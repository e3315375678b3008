"""One wheelset, or the fast channels, out of the dataset of a result."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from wrsim.errors import InputError, suggest
from wrsim.results.dataset import OF_VEHICLE
from wrsim.results.netcdf import parts_of


def wheelsets(dataset: xr.Dataset) -> tuple[str, ...]:
    """Names of the wheelsets, front first."""
    return tuple(str(name) for name in np.atleast_1d(dataset["wheelset"].values))


def numbered(names: Sequence[str]) -> dict[str, str]:
    """Names of several wheelsets with their numbers from the front, as the trade counts them: ``1 front.outer``."""
    if len(names) < 2:
        return {name: name for name in names}
    return {name: name if name == str(i) else f"{i} {name}" for i, name in enumerate(names, 1)}


def wheelset_folder(names: Sequence[str], name: str) -> str:
    """Where files of one of several wheelsets are, with a stroke at the end: ``wheelset_1/``; empty for a lone one."""
    return f"wheelset_{names.index(name) + 1}/" if len(names) > 1 else ""


def of_wheelset(dataset: xr.Dataset, name: str | None = None) -> xr.Dataset:
    """What a dataset holds of one wheelset, without the dimension ``wheelset``; of the only one without a name.

    name: its number from the front, from 1, does as well.
    ``distance`` is that of the wheelset, ``snapshot_distance`` that of the vehicle. What belongs to
    bodies, points, suspension, loads and events is left out.
    Raises InputError for a name that is none of the wheelsets, and when there are several to choose from.
    """
    names = wheelsets(dataset)
    if name is None and len(names) == 1:
        name = names[0]
    if name is not None and name not in names and name in map(str, range(1, len(names) + 1)):
        name = names[int(name) - 1]
    if name not in names:
        fault = f"no wheelset is called '{name}'{suggest(name, names)}; there are" if name else "choose a wheelset:"
        raise InputError(f"{fault} {', '.join(numbered(names).values())}")
    if "wheelset" not in dataset.dims:
        return dataset
    data = dataset.drop_dims([*OF_VEHICLE, "event"], errors="ignore").sel(wheelset=name)
    if len(names) > 1:
        data.attrs["title"] = f"{dataset.attrs['title']}: wheelset {numbered(names)[name]}"
    if "wheelset_distance" not in data:
        return data
    wheelset_place = data["wheelset_distance"].values
    if len(names) > 1 and (place := data.get("fast_distance")) is not None:
        distances = np.interp(data["fast_time"].values, data["time"].values, wheelset_place)
        data["fast_distance"] = (place.dims, distances, dict(place.attrs))
    distance = xr.Variable(("time",), wheelset_place, dict(dataset["distance"].attrs))
    return data.drop_vars("wheelset_distance").assign_coords(distance=distance)


def fast_of(dataset: xr.Dataset) -> xr.Dataset:
    """The fast channels of a dataset in place of those over ``time``, by the names of these. Raises InputError where
    there are none."""
    if "fast_time" not in dataset.dims:
        raise InputError("the result has no fast channels: run its scenario with run.fast_channels")
    fast = dataset.drop_dims("time", errors="ignore")
    return fast.rename({name: str(name).removeprefix("fast_") for name in fast.variables})


def matched(dataset: xr.Dataset, first: xr.Dataset) -> xr.Dataset:
    """A dataset whose wheelsets go by the names of another's, by their order from the front; others by their own."""
    labels, ahead = wheelsets(dataset), wheelsets(first)
    names = [*ahead[: len(labels)], *labels[len(ahead) :]]
    if len(set(names)) < len(names) or tuple(names) == labels:
        return dataset
    return dataset.assign_coords(wheelset=names if "wheelset" in dataset.dims else names[0])


def worst_wheelset(dataset: xr.Dataset) -> str:
    """The wheelset with the largest derailment quotient; the first one where there is none."""
    names = wheelsets(dataset)
    if "Y_over_Q" not in dataset or len(names) == 1:
        return names[0]
    parts = (np.nan_to_num(part, nan=-np.inf).max(axis=(0, 2)) for _, part in parts_of(dataset.variables["Y_over_Q"]))
    return names[int(np.argmax(np.max(list(parts), axis=0)))]
