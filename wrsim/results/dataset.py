"""From plain arrays to the labelled dataset of a Result."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from wrsim import __version__
from wrsim.errors import InputError, suggest
from wrsim.inputs.toml_files import parse_toml
from wrsim.results.channels import CHANNELS, WHEELS, Channel

FORMAT = "wrsim result"
FORMAT_VERSION = 3
COUNTS = ("steps", "evaluations", "jacobians", "cut_steps", "explicit_steps")
"""What the integration of a run took, among the attributes of its result."""
REQUIRED_ATTRIBUTES = ("title", "analysis", "status", "scenario_text")
OF_VEHICLE = ("body", "point", "suspension", "coupling", "external_load")
OF_WEAR = ("wear_law", "wear_zone")
NAMED = ("wheelset", *OF_VEHICLE, *OF_WEAR)
"""Dimensions labelled by names: those of a vehicle and of its wear."""
SINGLE = "wheelset"
"""Name of a wheelset that runs alone."""
STATUSES = ("completed", "stopped")


def versions() -> dict[str, str]:
    """Versions of what shapes the numbers, as attributes: ``wrsim_version``, ``numpy_version``, ..."""
    found = {"wrsim_version": __version__, "python_version": platform.python_version()}
    for package in ("numpy", "numba", "exudyn", "scipy"):
        try:
            found[f"{package}_version"] = version(package)
        except PackageNotFoundError:
            found[f"{package}_version"] = "not installed"
    return found


def assemble(
    coords: Mapping[str, ArrayLike],
    channels: Mapping[str, ArrayLike],
    attributes: Mapping[str, str | float | int],
    *,
    copy: bool = True,
) -> xr.Dataset:
    """Build the dataset of a Result; names and shapes are checked against the register.

    coords: either ``time`` (n,) in seconds for a run or ``pose`` (n,) names for a static analysis; ``wheel`` (default
    ``("left", "right")``) names the wheels present; ``amplitude`` (m,) in metres goes with poses; ``wheelset``,
    ``body``, ``point``, ``suspension``, ``coupling``, ``external_load`` are the names of a vehicle's parts,
    ``wear_law`` and ``wear_zone`` those of its wear. Where ``wheelset`` is one name (default ``"wheelset"``) instead of
    a list, the arrays come without that dimension.

    channels: arrays by channel name, in SI units, shaped as the register says (sample first, then wheelset, wheel,
    patch, strip). The sizes of ``patch``, ``snapshot``, ``strip``, ``rail_point`` and ``wheel_point`` follow from the
    arrays. A scalar fills its channel. Counts may come as floats; not-a-number becomes 0.

    attributes: ``title``, ``analysis``, ``status`` ("completed" or "stopped"), ``scenario_text``; a stopped analysis
    adds ``stop_reason`` and, over time, ``stop_time_s`` and ``stop_distance_m``. More attributes (text or numbers)
    are kept. The versions are added here.

    ``Y_over_Q`` (where Q > 0), ``sum_Y`` (of both wheels), ``contact_angle_variation`` and the ``wheelset_distance`` of
    a single wheelset are derived when they are not given.

    copy: False gives the arrays away: they become those of the dataset, where their type is that of their channel.
    Those that are variables of a file (`wrsim.results.netcdf`) stay there.

    Raises ``ValueError`` for an unknown name, a wrong shape or a missing attribute: these are mistakes of the
    calling code, not of the user.
    """
    if ("time" in coords) == ("pose" in coords):
        raise ValueError("coords needs either 'time' (runs) or 'pose' (static analyses)")
    sample = "time" if "time" in coords else "pose"
    arrays = with_derived(channels, coords.get("wheel", WHEELS))
    if isinstance(coords.get("wheelset", SINGLE), str):
        arrays = _of_single_wheelset(arrays)
    sizes, labels = _labels(sample, coords)
    variables: dict[str, xr.Variable] = {}
    scalars: list[tuple[Channel, NDArray[Any]]] = []
    for name, values in arrays.items():
        channel = _registered(name)
        array = _typed(channel, values, copy)
        if array.ndim == 0 and channel.dims:
            scalars.append((channel, array))
            continue
        variables[name] = _variable(channel, sample, array, sizes)
    for channel, array in scalars:
        dims = channel.dims_in(sample)
        unknown = [d for d in dims if d not in sizes]
        if unknown:
            raise ValueError(f"channel '{channel.name}': the size of '{unknown[0]}' is unknown")
        filled = np.full(tuple(sizes[d] for d in dims), array[()])
        variables[channel.name] = _variable(channel, sample, filled, sizes)
    for name in ("patch", "snapshot"):
        if name in sizes:
            labels[name] = np.arange(sizes[name])
    coordinates = {name: _variable(CHANNELS[name], sample, values, sizes) for name, values in labels.items()}
    for name in [n for n in variables if CHANNELS[n].coordinate]:
        coordinates[name] = variables.pop(name)
    ordered = {name: variables[name] for name in CHANNELS if name in variables}
    return xr.Dataset(ordered, coords=coordinates, attrs=_attributes(attributes, sample))


def _labels(sample: str, coords: Mapping[str, ArrayLike]) -> tuple[dict[str, int], dict[str, NDArray[Any]]]:
    """Sizes and labels of the dimensions that the caller names: sample, wheel, parts of the vehicle."""
    for name in coords:
        if name not in (sample, "wheel", "amplitude", *NAMED):
            raise ValueError(f"coords: '{name}' is not a dimension that the caller labels")
    wheels = tuple(str(w) for w in np.atleast_1d(np.asarray(coords.get("wheel", WHEELS))))
    if len(set(wheels)) != len(wheels) or not wheels or not set(wheels) <= set(WHEELS):
        raise ValueError(f"coords: wheel is {wheels}; allowed are 'left', 'right' or both")
    labels = {sample: _typed(CHANNELS[sample], coords[sample]), "wheel": np.array(wheels)}
    if "amplitude" in coords:
        labels["amplitude"] = _typed(CHANNELS["amplitude"], coords["amplitude"])
    for name in [n for n in NAMED if n in coords or n == "wheelset"]:
        labels[name] = np.atleast_1d(_typed(CHANNELS[name], coords.get(name, SINGLE)))
        if labels[name].ndim != 1 or np.unique(labels[name]).size != labels[name].size:
            raise ValueError(f"coords: '{name}' must be a row of names, each once")
    if labels[sample].ndim != 1:
        raise ValueError(f"coords: '{sample}' must be one-dimensional, not {labels[sample].shape}")
    if sample == "pose" and np.unique(labels["pose"]).size != labels["pose"].size:
        raise ValueError("coords: every pose needs a name of its own")
    return {name: values.size for name, values in labels.items()}, labels


def _registered(name: str) -> Channel:
    """Channel of that name that an array may be given for."""
    if name not in CHANNELS:
        raise ValueError(f"no channel is called '{name}'{suggest(name, list(CHANNELS))}")
    channel = CHANNELS[name]
    if channel.coordinate and name != "distance":
        raise ValueError(f"'{name}' labels a dimension; it belongs in coords")
    return channel


def typed(name: str, values: ArrayLike) -> NDArray[Any]:
    """The values in the type of a channel, without a copy if they have it."""
    return _typed(CHANNELS[name], values, copy=False)


def _typed(channel: Channel, values: ArrayLike, copy: bool = True) -> NDArray[Any]:
    """The values in the channel's type, a private copy unless numbers of that type are given away."""
    if isinstance(values, xr.Variable):
        return values  # type: ignore[return-value]
    if channel.kind == "text":
        array: NDArray[Any] = np.array(values, dtype=str)
        return array if array.dtype.itemsize else array.astype("<U1")
    if channel.kind == "count":
        return np.nan_to_num(np.array(values, dtype=np.float64), nan=0.0).astype(np.int64)
    return np.array(values, dtype=np.float64, copy=True if copy else None)


def _variable(channel: Channel, sample: str, array: NDArray[Any], sizes: dict[str, int]) -> xr.Variable:
    """Variable with its dimensions and attributes; ``sizes`` learns the dimensions met for the first time."""
    dims = channel.dims_in(sample)
    if sample not in dims and sample == "pose" and {"time", "snapshot"} & set(dims):
        raise ValueError(f"channel '{channel.name}' belongs to runs over time, not to poses")
    if sample == "time" and "pose" in dims:
        raise ValueError(f"channel '{channel.name}' belongs to static poses, not to runs")
    expected = [sizes.get(d) for d in dims]
    if array.ndim != len(dims) or any(e not in (None, n) for e, n in zip(expected, array.shape, strict=True)):
        wanted = ", ".join(f"{d} {'any' if e is None else e}" for d, e in zip(dims, expected, strict=True))
        raise ValueError(f"channel '{channel.name}' has shape {array.shape}; expected ({wanted})")
    sizes.update(zip(dims, array.shape, strict=True))
    return array if isinstance(array, xr.Variable) else xr.Variable(dims, array, channel.attributes)


def with_derived(channels: Mapping[str, ArrayLike], wheels: ArrayLike = WHEELS) -> dict[str, ArrayLike]:
    """The channels, of some samples or of all, with Y/Q, the track shifting force and the variation of the contact
    angle where they follow."""
    arrays = dict(channels)
    if "Y" in arrays and "sum_Y" not in arrays and tuple(np.atleast_1d(wheels)) == WHEELS and np.ndim(arrays["Y"]) > 1:
        left_and_right = np.asarray(arrays["Y"], dtype=float)
        arrays["sum_Y"] = left_and_right[..., 0] - left_and_right[..., -1]
    if "Y_over_Q" not in arrays and {"Y", "Q"} <= arrays.keys():
        force, load = (np.asarray(arrays[name], dtype=float) for name in ("Y", "Q"))
        if force.shape == load.shape:
            arrays["Y_over_Q"] = np.divide(force, load, out=np.full(force.shape, np.nan), where=load > 0.0)
    ends = ("contact_angle_min", "contact_angle_max")
    if "contact_angle_variation" not in arrays and set(ends) <= arrays.keys():
        low, high = (np.asarray(arrays[name], dtype=float) for name in ends)
        if low.shape == high.shape:
            arrays["contact_angle_variation"] = high - low
    return arrays


def _of_single_wheelset(channels: Mapping[str, ArrayLike]) -> dict[str, ArrayLike]:
    """The channels of a wheelset that runs alone, with the dimension ``wheelset``."""
    arrays = dict(channels)
    if "distance" in arrays:
        arrays.setdefault("wheelset_distance", arrays["distance"])
    for name, values in arrays.items():
        if name in CHANNELS and "wheelset" in CHANNELS[name].dims and np.ndim(values) > 0:
            arrays[name] = np.expand_dims(np.asarray(values), 1)
    return arrays


def _attributes(given: Mapping[str, str | float | int], sample: str) -> dict[str, str | float | int]:
    """Attributes in a fixed order: what it is, what the caller said, the versions."""
    for name in REQUIRED_ATTRIBUTES:
        if name not in given:
            raise ValueError(f"attributes: '{name}' is missing")
    if given["status"] not in STATUSES:
        raise ValueError(f"attributes: status is {given['status']!r}; allowed are {STATUSES}")
    if given["status"] == "stopped":
        needed = ("stop_reason", "stop_time_s", "stop_distance_m") if sample == "time" else ("stop_reason",)
        for name in needed:
            if name not in given:
                raise ValueError(f"attributes: a stopped analysis needs '{name}'")
    attributes: dict[str, str | float | int] = {"format": FORMAT, "format_version": FORMAT_VERSION}
    for name, value in given.items():
        if isinstance(value, bool) or not isinstance(value, str | float | int | np.floating | np.integer):
            raise ValueError(f"attributes: '{name}' must be a text or a number, not {type(value).__name__}")
        attributes[name] = value
    for name, text in versions().items():
        attributes.setdefault(name, text)
    return attributes


def table_of_scenario(dataset: xr.Dataset, name: str) -> dict[str, Any] | None:
    """One table of the scenario that a result carries; empty where it has none, None where it cannot be read."""
    try:
        found = parse_toml(str(dataset.attrs.get("scenario_text", "")), "scenario").get(name, {})
    except InputError:
        return None
    return found if isinstance(found, dict) else None
