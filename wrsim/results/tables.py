"""Tables for people and spreadsheets: comma-separated values, units at the end of every column name."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.inputs.file_kinds import resolved
from wrsim.register import ANALYSES
from wrsim.results.channels import CHANNELS, Channel
from wrsim.results.dataset import OF_VEHICLE
from wrsim.results.table import csv_numbers
from wrsim.results.units import converted
from wrsim.results.wheelsets import of_wheelset, wheelset_folder, wheelsets

if TYPE_CHECKING:
    from pandas import DataFrame

Row = list[str]

BLOCK = 2000  # instants of a run that are in memory as text at once


def tables(dataset: xr.Dataset) -> dict[str, list[Row]]:
    """All tables of a result by name, each with a header."""
    return {name: list(rows) for name, rows in each_table(dataset)}


def each_table(dataset: xr.Dataset) -> Iterator[tuple[str, Iterable[Row]]]:
    """The tables one after the other; rows of runs are made while they are taken, as they outweigh the numbers."""
    yield from resolved(ANALYSES[str(dataset.attrs["analysis"])].csv_files)(dataset)


def csv_of_contacts(dataset: xr.Dataset) -> Iterator[tuple[str, Iterable[Row]]]:
    """The tables of a run or of poses: those of the vehicle, then those of every wheelset."""
    names = wheelsets(dataset)
    if "time" in dataset.dims and (len(names) > 1 or set(OF_VEHICLE) & set(dataset.dims)):
        yield "vehicle", _in_blocks(lambda part: wide(part, "time", OF_VEHICLE), dataset)
        if any(present(dataset, ("fast_time", dim)) for dim in OF_VEHICLE):
            yield "vehicle_fast", _in_blocks(lambda part: wide(part, "fast_time", OF_VEHICLE), dataset, "fast_time")
    for name in names:
        folder, data = wheelset_folder(names, name), of_wheelset(dataset, name)
        if "time" in data.dims:
            yield f"{folder}history", _in_blocks(lambda part: wide(part, "time", ("wheel",)), data)
        if "fast_time" in data.dims:
            yield f"{folder}fast", _in_blocks(lambda part: wide(part, "fast_time", ("wheel",)), data, "fast_time")
        if any("patch" in variable.dims and "strip" not in variable.dims for variable in data.values()):
            yield f"{folder}patches", _in_blocks(_patch_table, data)
        if "strip" in data.dims:
            yield f"{folder}strips", _strip_table(data)


def _in_blocks(table: Callable[[xr.Dataset], list[Row]], dataset: xr.Dataset, along: str = "time") -> Iterator[Row]:
    """The rows of a table, those of a run some instants at a time."""
    for begin in range(0, max(dataset.sizes.get(along, 0), 1), BLOCK):
        rows = table(dataset.isel({along: slice(begin, begin + BLOCK)}, missing_dims="ignore"))
        yield from rows[1:] if begin else rows


def _patch_table(data: xr.Dataset) -> list[Row]:
    """One row per sample, wheel and patch in contact; every wheel keeps a row in static analyses."""
    sample = "time" if "time" in data.dims else "pose"
    channels = present(data, (sample, "wheel", "patch"))
    contact = chosen(data, channels)
    if sample == "pose":
        contact[:, :, 0] = True
    context = ["distance"] if "distance" in data.coords else []
    pose = [*present(data, ("pose",)), *present(data, ("pose", "wheel"))]
    return long(data, [sample, *context, "wheel", "patch", *pose, *channels], contact, (sample, "wheel", "patch"))


def _strip_table(data: xr.Dataset) -> list[Row]:
    moment = "snapshot" if "snapshot" in data.dims else "pose"
    dims = (moment, "wheel", "patch", "strip")
    channels = present(data, dims)
    context = [name for name in ("snapshot_time", "snapshot_distance") if name in data]
    return long(data, [moment, *context, *dims[1:], *channels], chosen(data, channels), dims)


def wide(dataset: xr.Dataset, dim: str, dims: Iterable[str] = ()) -> list[Row]:
    """One row per label of a dimension, a column for each label of ``dims`` that a channel has (``Y_left_kN``)."""
    names = [dim] if dim in CHANNELS else []
    names += present(dataset, (dim,))
    names += [name for label_dim in dims for name in present(dataset, (dim, label_dim))]
    return rows_of([(head, channel_cells(name, values)) for name in names for head, values in _flat(dataset, name)])


def columns(dataset: xr.Dataset) -> Iterator[tuple[str, Channel, NDArray[Any]]]:
    """Columns of one wide table, a row a sample: names as ``Y_front.outer_left_kN``, channels, values for readers."""
    sample = "time" if "time" in dataset.dims else "pose"
    for name, channel in CHANNELS.items():
        if name in dataset.variables and dataset[name].dims[:1] == (sample,) and "strip" not in dataset[name].dims:
            for head, values in _flat(dataset, name):
                yield head, channel, values * converted(channel.shown).factor if channel.kind == "number" else values


class Units(dict[Any, str]):
    """Units by column, shared by all that is taken from a table: pandas copies the attributes for every column."""

    def __deepcopy__(self, memo: object) -> Units:
        return self


def frame(dataset: xr.Dataset) -> DataFrame:
    """The same as a data frame; ``attrs["units"]`` holds the unit of every column."""
    import pandas as pd

    named = list(columns(dataset))
    table = pd.DataFrame({name: values for name, _, values in named})
    units = {name: converted(channel.shown).symbol for name, channel, _ in named if channel.kind == "number"}
    table.attrs["units"] = Units(units)
    return table


def indexed_frame(dataset: xr.Dataset) -> DataFrame:
    """The same by the distance along the track [m] of its first wheelset, or by the pose; columns by wheelset, wheel
    and channel, the last with patch, body ... behind it. Units by column in ``attrs["units"]``."""
    import pandas as pd

    sample = "time" if "time" in dataset.dims else "pose"
    named: dict[tuple[str, str, str], NDArray[Any]] = {}
    units = {}
    for name, channel in CHANNELS.items():
        if name not in dataset.variables or dataset[name].dims[:1] != (sample,) or "strip" in dataset[name].dims:
            continue
        dims = dataset[name].dims[1:]
        for labels, values in _places(dataset, name):
            of = {str(dim): str(label) for dim, label in zip(dims, labels, strict=True)}
            key = of.pop("wheelset", ""), of.pop("wheel", ""), "_".join((name, *of.values()))
            named[key] = values * converted(channel.shown).factor if channel.kind == "number" else values
            units[key] = converted(channel.shown).symbol if channel.kind == "number" else ""
    table = pd.DataFrame(named)
    table.columns = pd.MultiIndex.from_tuples(named, names=("wheelset", "wheel", "channel"))
    table.attrs["units"] = Units(units)
    if "distance" in dataset:
        along = dataset["distance"]
        along = along.isel(wheelset=0) if "wheelset" in along.dims else along
        table.index = pd.Index(along.values, name="distance_m")
    else:
        table.index = pd.Index(dataset[sample].values, name=sample)
    return table


def _flat(dataset: xr.Dataset, name: str) -> Iterator[tuple[str, NDArray[Any]]]:
    """Columns of a channel with their names: one for each combination of the labels of its further dimensions."""
    for place, values in _places(dataset, name):
        parts = (name, *map(str, place), converted(CHANNELS[name].shown).suffix)
        yield "_".join(word.replace(" ", "_") for word in parts if word), values


def _places(dataset: xr.Dataset, name: str) -> Iterator[tuple[tuple[Any, ...], NDArray[Any]]]:
    """Values of a channel over the samples for each combination of the labels of its further dimensions."""
    data = dataset.variables[name]
    labels = [dataset[dim].values if dim in dataset.coords else range(dataset.sizes[dim]) for dim in data.dims[1:]]
    places = list(product(*labels))
    values = data.values.reshape(data.shape[0], len(places))
    for i, place in enumerate(places):
        yield place, values[:, i]


def long(dataset: xr.Dataset, names: Iterable[str], chosen: NDArray[np.bool_], dims: tuple[str, ...]) -> list[Row]:
    """One row per chosen place in these dimensions; a channel may have some of the dimensions only."""
    indices = dict(zip(dims, np.nonzero(chosen), strict=True))
    columns = []
    for name in names:
        if name in CHANNELS:
            values = dataset.variables[name]
            at_rows = values.values[tuple(indices[str(d)] for d in values.dims)]
            columns.append((_head(name), channel_cells(name, at_rows)))
        else:
            columns.append((name, [str(i) for i in indices[name]]))
    return rows_of(columns)


def _head(name: str) -> str:
    """Name of a channel with its unit in use."""
    return "_".join(filter(None, (name, converted(CHANNELS[name].shown).suffix)))


def rows_of(columns: list[tuple[str, list[str]]]) -> list[Row]:
    """Rows, the header first, from columns with their headers."""
    return [[header for header, _ in columns], *(list(row) for row in zip(*(c for _, c in columns), strict=True))]


def present(dataset: xr.Dataset, dims: tuple[str, ...]) -> list[str]:
    """Channels of the dataset with exactly these dimensions, in the register's order; labels left out."""
    variables = dataset.variables
    return [n for n in CHANNELS if n in variables and variables[n].dims == dims and n not in dataset.dims]


def chosen(dataset: xr.Dataset, channels: list[str]) -> NDArray[np.bool_]:
    """True where one of these channels, alike in their dimensions, has a finite value, or a count above zero."""
    arrays = ((CHANNELS[name].kind, dataset.variables[name].values) for name in channels)
    return np.any([values > 0 if kind == "count" else np.isfinite(values) for kind, values in arrays], axis=0)


def channel_cells(name: str, values: NDArray[Any]) -> list[str]:
    """Cells of a channel in the unit for readers."""
    if CHANNELS[name].kind != "number":
        return [str(v) for v in values]
    return csv_numbers((values * converted(CHANNELS[name].shown).factor).tolist())
