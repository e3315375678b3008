"""The labelled dataset of a Result: built from plain arrays, and checked against the register of channels."""

import platform
from collections.abc import Hashable, Iterator, Mapping, Sequence
from functools import cache
from importlib.metadata import version
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from wrsim import __version__
from wrsim.errors import InputError, suggest
from wrsim.inputs.toml_files import parse_toml
from wrsim.register import ANALYSES
from wrsim.results.channels import CHANNELS, WHEELS, Channel, Kind
from wrsim.results.netcdf import parts_of

FORMAT = "wrsim result"
FORMAT_VERSION = 3
COUNTS = ("steps", "evaluations", "jacobians", "cut_steps", "explicit_steps", "refined_steps")
"""What the integration of a run took, among the attributes of its result."""
ASSUMPTIONS = {
    "alignment": "track", "structure": "rails", "cant": "cant", "irregularities": "irregularities", "train": "train",
}  # fmt: skip
"""Attributes that say what is assumed of track and train, and words for them."""
REQUIRED_ATTRIBUTES = ("title", "analysis", "status", "scenario_text")
OF_VEHICLE = ("body", "point", "suspension", "coupling", "external_load")
OF_WEAR = ("wear_law", "wear_zone")
NAMED = ("wheelset", *OF_VEHICLE, *OF_WEAR)
"""Dimensions labelled by names: those of a vehicle and of its wear."""
LABELLED = ("time", "fast_time", "pose", "wheel", "snapshot", *NAMED)
"""Dimensions with labels, of which no file has none."""
SINGLE = "wheelset"  # name of a wheelset that runs alone
STATUSES = ("completed", "stopped")


@cache
def versions() -> dict[str, str]:
    """Versions of what shapes the numbers, as attributes: ``wrsim_version``, ``numpy_version``, ..."""
    programs = {"wrsim_version": __version__, "python_version": platform.python_version()}
    return programs | {f"{package}_version": version(package) for package in ("numpy", "numba", "exudyn", "scipy")}


def assemble(
    coords: Mapping[str, ArrayLike],
    channels: Mapping[str, ArrayLike],
    attributes: Mapping[str, str | float | int],
    *,
    copy: bool = True,
) -> xr.Dataset:
    """Build the dataset of a Result; names, shapes and types are checked against the register.

    coords: either ``time`` (n,) in seconds for a run or ``pose`` (n,) names for a static analysis; names of the
    ``wheel`` (default ``("left", "right")``), of a vehicle's parts and of its wear; ``amplitude`` (m,) in metres. Where
    ``wheelset`` is one name (default ``"wheelset"``) instead of a list, the arrays come without that dimension.

    channels: arrays by channel name, in SI units, shaped as in the register (sample first, then wheelset, wheel,
    patch, strip); sizes of dimensions without labels follow from them. A scalar fills its channel. Counts may come as
    floats; not-a-number becomes 0. ``Y_over_Q`` (where Q > 0), ``sum_Y`` (of both wheels), ``contact_angle_variation``
    and the ``wheelset_distance`` of a single wheelset are derived when they are not given.

    attributes: ``title``, ``analysis``, ``status`` ("completed" or "stopped"), ``scenario_text``; of a stopped analysis
    ``stop_reason`` and, over time, ``stop_time_s`` and ``stop_distance_m``; further texts and numbers. The versions are
    added.

    copy: False gives the arrays away: they become those of the dataset, where their type is that of their channel.
    Variables of a file (`wrsim.results.netcdf`) stay there.

    Raises ``ValueError`` for an unknown name, a wrong shape or a missing attribute: mistakes of the calling code.
    """
    if ("time" in coords) == ("pose" in coords):
        raise ValueError("coords needs either 'time' (runs) or 'pose' (static analyses)")
    sample = "time" if "time" in coords else "pose"
    arrays = with_derived(channels, coords.get("wheel", WHEELS))
    if isinstance(coords.get("wheelset", SINGLE), str):
        arrays = _of_single_wheelset(arrays)
    labels: dict[str, ArrayLike] = {sample: coords[sample], "wheel": WHEELS, "wheelset": SINGLE, **coords}
    columns = {name: np.atleast_1d(typed(name, values, copy=True)) for name, values in labels.items()}
    columns |= {name: typed(name, values, copy) for name, values in arrays.items()}
    sizes: dict[str, int] = {}
    for name, values in columns.items():
        for dim, size in zip(CHANNELS[name].dims_in(sample), values.shape, strict=False):
            sizes.setdefault(dim, size)
    columns |= {name: np.arange(sizes[name]) for name in ("patch", "snapshot") if name in sizes}
    variables = {name: _variable(CHANNELS[name], sample, columns[name], sizes) for name in CHANNELS if name in columns}
    coordinates = {name: variable for name, variable in variables.items() if CHANNELS[name].coordinate}
    ordered = {name: variable for name, variable in variables.items() if name not in coordinates}
    dataset = xr.Dataset(ordered, coordinates, _attributes(attributes, sample))
    for fault in _faults_of_layout(dataset):
        raise ValueError(f"the dataset {fault}")
    return dataset


def typed(name: str, values: ArrayLike, copy: bool = False) -> NDArray[Any]:
    """The values in the type of a channel; without a copy, numbers that have it are given away."""
    if name not in CHANNELS:
        raise ValueError(f"no channel is called '{name}'{suggest(name, list(CHANNELS))}")
    kind = CHANNELS[name].kind
    if isinstance(values, xr.Variable):
        return values  # type: ignore[return-value]
    if kind == "text":
        array: NDArray[Any] = np.array(values, dtype=str)
        return array if array.dtype.itemsize else array.astype("<U1")
    if kind == "count":
        return np.nan_to_num(np.array(values, dtype=np.float64), nan=0.0).astype(np.int64)
    return np.array(values, dtype=np.float64, copy=True if copy else None)


def _variable(channel: Channel, sample: str, array: NDArray[Any], sizes: Mapping[str, int]) -> xr.Variable:
    if isinstance(array, xr.Variable):
        return array
    dims = channel.dims_in(sample)
    shape = tuple(sizes.get(dim, 0) for dim in dims)
    if array.ndim == 0:
        array = np.full(shape, array[()])
    if array.shape != shape:
        wanted = ", ".join(f"{dim} {size}" for dim, size in zip(dims, shape, strict=True))
        raise ValueError(f"channel '{channel.name}' has shape {array.shape}; expected ({wanted})")
    # an array as it is; else xarray imports dask to ask whether it is one of its own
    return xr.Variable(dims, array, channel.attributes, fastpath=True)


def with_derived(channels: Mapping[str, ArrayLike], wheels: ArrayLike = WHEELS) -> dict[str, ArrayLike]:
    """The channels with Y/Q, the track shifting force and the variation of the contact angle where they follow."""
    arrays = dict(channels)

    def sources(derived: str, *names: str) -> list[NDArray[np.float64]]:
        """Channels of one shape that one follows from; none where that is given or they are not."""
        values = [np.asarray(arrays[n], dtype=float) for n in names if n in arrays and derived not in arrays]
        return values if len(values) == len(names) and values[0].shape == values[-1].shape else []

    is_wheelset = tuple(np.atleast_1d(wheels)) == WHEELS and np.ndim(arrays.get("Y", 0.0)) > 1
    for force in sources("sum_Y", "Y") if is_wheelset else ():
        arrays["sum_Y"] = force[..., 0] - force[..., -1]
    if parts := sources("Y_over_Q", "Y", "Q"):
        arrays["Y_over_Q"] = np.divide(parts[0], parts[1], out=np.full(parts[0].shape, np.nan), where=parts[1] > 0.0)
    if parts := sources("contact_angle_variation", "contact_angle_min", "contact_angle_max"):
        arrays["contact_angle_variation"] = parts[1] - parts[0]
    return arrays


def _of_single_wheelset(channels: Mapping[str, ArrayLike]) -> dict[str, ArrayLike]:
    """The channels of a wheelset that runs alone, with the dimension ``wheelset``."""
    arrays = dict(channels)
    if "distance" in arrays:
        arrays.setdefault("wheelset_distance", arrays["distance"])
    of_wheelsets = [n for n in arrays if n in CHANNELS and "wheelset" in CHANNELS[n].dims and np.ndim(arrays[n]) > 0]
    return arrays | {name: np.expand_dims(np.asarray(arrays[name]), 1) for name in of_wheelsets}


def _attributes(attributes: Mapping[str, str | float | int], sample: str) -> dict[str, str | float | int]:
    """Attributes in a fixed order: what it is, what the caller gave, the versions."""
    stop = ("stop_reason", "stop_time_s", "stop_distance_m") if sample == "time" else ("stop_reason",)
    for name in REQUIRED_ATTRIBUTES + (stop if attributes.get("status") == "stopped" else ()):
        if name not in attributes:
            raise ValueError(f"attributes: '{name}' is missing")
    plain = {name: value.item() if isinstance(value, np.generic) else value for name, value in attributes.items()}
    return {"format": FORMAT, "format_version": FORMAT_VERSION, **plain} | {**versions(), **plain}


def table_of_scenario(dataset: xr.Dataset, name: str) -> dict[str, Any] | None:
    """One table of the scenario that a result carries; empty where it has none, None where it cannot be read."""
    try:
        table = parse_toml(str(dataset.attrs.get("scenario_text", "")), "scenario").get(name, {})
    except InputError:
        return None
    return table if isinstance(table, dict) else None


_TYPES = {"number": ("f", "float64"), "count": ("i", "int64"), "text": ("UOT", "text")}


def faults_of_result(dataset: xr.Dataset) -> Iterator[str]:
    """What is wrong with a dataset that claims to be a result. A right checksum does not prove that wrsim wrote a file:
    what readers of results rely on is checked at loading."""
    yield from _faults_of_layout(dataset)
    needed = ("wheel", "distance") if "time" in dataset.dims else ()
    yield from (f"has no {name}" for name in needed if name not in dataset.variables)
    yield from (f"its {name} is empty" for name, size in dataset.sizes.items() if name in LABELLED and not size)
    for group in dict.fromkeys(channel.together for channel in CHANNELS.values() if channel.together):
        names = [name for name, channel in CHANNELS.items() if channel.together == group]
        members = [name for name in names if name in dataset.variables]
        yield from (f"has {members[0]} and no {name}" for name in names if members and name not in members)


def _faults_of_layout(dataset: xr.Dataset) -> Iterator[str]:
    yield from faults_of_attributes(dataset.attrs, REQUIRED_ATTRIBUTES)
    for name, allowed in (("analysis", tuple(ANALYSES)), ("status", STATUSES)):
        if dataset.attrs[name] not in allowed:
            yield f"its {name} is {dataset.attrs[name]!r:.40}, none of {', '.join(allowed)}"
    sample = "time" if "time" in dataset.dims else "pose"
    labels = [name for name in (*LABELLED, "patch") if name in dataset.dims]
    yield from (f"has no {name}" for name in (sample, *labels, "wheelset") if name not in dataset.variables)
    for name in map(str, dataset.variables):
        channel = CHANNELS.get(name)
        if channel is None:
            yield f"has {name!r:.40}, which is no channel"
        else:
            yield from faults_of_variable(dataset, name, channel.dims_in(sample), channel.kind)
    yield from _faults_of_labels(dataset, sample, labels)


def _faults_of_labels(dataset: xr.Dataset, sample: str, labels: Sequence[str]) -> Iterator[str]:
    for name in labels:
        values = dataset.variables[name].values
        if len(np.unique(values)) < values.size:
            yield f"its {name} has a value twice"
    wheels = tuple(map(str, dataset["wheel"].values)) if "wheel" in labels else WHEELS
    if wheels not in (WHEELS, *((wheel,) for wheel in WHEELS)):
        yield f"its wheel is {', '.join(wheels)!r:.40}, must be {', '.join(WHEELS)} or one of them"
    for name in ("time", "distance", "speed", "wheelset_distance", "snapshot_time", "snapshot_distance"):
        if name in dataset.variables and not all(np.isfinite(p).all() for _, p in parts_of(dataset.variables[name])):
            yield f"its {name} is not finite everywhere"
    if sample == "time" and (np.diff(dataset["time"].values) <= 0.0).any():
        yield "its time does not increase from sample to sample"


LISTS = ("curve_radii_m",)  # attributes that are numbers with blanks between


def faults_of_attributes(attributes: Mapping[str, Any], texts: Sequence[str]) -> Iterator[str]:
    """What is wrong with the attributes of a file of results, of which some have to be texts."""
    yield from (f"has no {name}" for name in texts if not isinstance(attributes.get(name), str))
    for name, value in attributes.items():
        whole, number = name in COUNTS, name.endswith(("_m", "_s", "_rad", "_Hz")) and name not in LISTS
        if not isinstance(value, int if whole else int | float if number else int | float | str):
            requirement = "a whole number" if whole else "a number" if number else "a number or a text"
            yield f"its {name!s:.40} is {value!r:.40}, must be {requirement}"


def faults_of_variable(dataset: xr.Dataset, name: str, dims: Sequence[Hashable], kind: Kind) -> Iterator[str]:
    """What is wrong with a variable, of which layout and type are known."""
    if name not in dataset.variables:
        yield f"has no {name}"
        return
    variable = dataset.variables[name]
    letters, requirement = _TYPES[kind]
    if variable.dims != tuple(dims):
        layout, required = (", ".join(map(str, names)) for names in (variable.dims, dims))
        yield f"its {name} is laid out along ({layout}), must be along ({required})"
    if variable.dtype.kind not in letters or (kind != "text" and variable.dtype.itemsize != 8):
        yield f"its {name} holds {variable.dtype}, must be {requirement}"
    if not isinstance(variable.attrs.get("units", ""), str):
        yield f"its {name} has units that are no text"
