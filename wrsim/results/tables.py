"""Tables for people and spreadsheets: comma-separated values, units at the end of every column name."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.results.channels import CHANNELS, Channel
from wrsim.results.files import write_atomically
from wrsim.results.result import Result
from wrsim.results.stability import cycle_table, is_stability, mode_table
from wrsim.results.steady import is_steady, steady_table
from wrsim.results.wheelsets import of_wheelset, wheelsets

Row = list[str]

BLOCK = 2000
"""Instants of a run that stand in memory as text at once."""


def write_run(result: Result, directory: str | Path) -> list[Path]:
    """Write ``result.nc``, ``summary.json`` and the tables into ``directory``; returns what was written.

    Runs get ``history.csv`` (one row per instant), ``patches.csv`` (one row per instant, wheel and patch
    in contact) and ``strips.csv`` (the strips of the snapshots). Static analyses get ``patches.csv`` (one
    row per pose, wheel and patch; a wheel without contact keeps one row) and ``strips.csv``;
    conicity analyses add ``conicity.csv`` (one row per amplitude). Stability analyses get ``modes.csv`` (one row per
    speed and mode) and ``cycles.csv`` (one row per held speed), steady ones ``steady.csv`` (one row per curve,
    wheelset and wheel). Where there are several wheelsets, each has tables under its name, such as
    ``history_front.outer.csv``; bodies, points and suspension elements stand in ``vehicle.csv``. The dataset
    goes first, so that a full disk costs the tables before the numbers. A stopped analysis is written like
    any other.
    Raises ``WrsimError`` when something cannot be written.
    """
    directory = Path(directory)
    written = [result.save(directory / "result.nc")]
    summary = json.dumps(result.summary(), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    written.append(write_atomically(directory / "summary.json", summary.encode()))
    for name, rows in _each(result.dataset):
        written.append(write_atomically(directory / f"{name}.csv", _csv(rows)))
    return written


def write_table(dataset: xr.Dataset, name: str, path: str | Path) -> Path:
    """Write one of the `tables` of a result. Raises ``WrsimError`` when it cannot be written."""
    return write_atomically(path, _csv(dict(_each(dataset))[name]))


def tables(dataset: xr.Dataset) -> dict[str, list[Row]]:
    """All tables of a result by name; the first row of each is the header."""
    return {name: list(rows) for name, rows in _each(dataset)}


def _each(dataset: xr.Dataset) -> Iterator[tuple[str, Iterable[Row]]]:
    """The tables one after the other; rows of runs are made while they are taken, as they outweigh the numbers."""
    if is_stability(dataset):
        yield "modes", mode_table(dataset)
        if "cycle" in dataset.dims:
            yield "cycles", cycle_table(dataset)
        return
    if is_steady(dataset):
        yield "steady", steady_table(dataset)
        return
    names = wheelsets(dataset)
    if "time" in dataset.dims and (len(names) > 1 or {"body", "point", "suspension"} & set(dataset.dims)):
        yield "vehicle", _in_blocks(vehicle_table, dataset)
    for name in names:
        own = f"_{name}" if len(names) > 1 else ""
        yield from ((table + own, rows) for table, rows in _of_wheelset(of_wheelset(dataset, name)))


def _of_wheelset(one: xr.Dataset) -> Iterator[tuple[str, Iterable[Row]]]:
    """The tables of one wheelset."""
    if "time" in one.dims:
        yield "history", _in_blocks(history_table, one)
    if any("patch" in variable.dims and "strip" not in variable.dims for variable in one.values()):
        yield "patches", _in_blocks(patch_table, one)
    if "strip" in one.dims:
        yield "strips", strip_table(one)
    if "amplitude" in one.dims:
        yield "conicity", conicity_table(one)


def _in_blocks(table: Callable[[xr.Dataset], list[Row]], dataset: xr.Dataset) -> Iterator[Row]:
    """The rows of a table, those of a run some instants at a time."""
    if "time" not in dataset.dims:
        yield from table(dataset)
        return
    for begin in range(0, max(dataset.sizes["time"], 1), BLOCK):
        rows = table(dataset.isel(time=slice(begin, begin + BLOCK)))
        yield from rows[1:] if begin else rows


def vehicle_table(dataset: xr.Dataset) -> list[Row]:
    """One row per instant: the vehicle's channels, those of its bodies as ``body_yaw_carbody_mrad`` and so on."""
    headers, columns = ["time_s"], [_text(CHANNELS["time"], dataset["time"].values)]
    for channel in _present(dataset, ("time",)):
        headers.append(channel.column)
        columns.append(_text(channel, dataset[channel.name].values))
    for dim in ("body", "point", "suspension"):
        for channel in _present(dataset, ("time", dim)):
            for label in dataset[dim].values:
                headers.append(f"{channel.name}_{label}_{channel.shown.suffix}".replace(" ", "_"))
                columns.append(_text(channel, dataset[channel.name].sel({dim: label}).values))
    return [headers, *(list(row) for row in zip(*columns, strict=True))]


def conicity_table(dataset: xr.Dataset) -> list[Row]:
    """One row per amplitude."""
    channels = [CHANNELS["amplitude"], *_present(dataset, ("amplitude",))]
    columns = [_text(channel, dataset[channel.name].values) for channel in channels]
    return [[channel.column for channel in channels], *(list(row) for row in zip(*columns, strict=True))]


def history_table(dataset: xr.Dataset) -> list[Row]:
    """One row per instant: track and wheelset channels, then the wheels' channels as ``Y_left_kN``, ..."""
    headers, columns = ["time_s"], [_text(CHANNELS["time"], dataset["time"].values)]
    for channel in _present(dataset, ("time",)):
        headers.append(channel.column)
        columns.append(_text(channel, dataset[channel.name].values))
    for channel in _present(dataset, ("time", "wheel")):
        for wheel in dataset["wheel"].values:
            suffix = f"_{channel.shown.suffix}" if channel.shown.suffix else ""
            headers.append(f"{channel.name}_{wheel}{suffix}")
            columns.append(_text(channel, dataset[channel.name].sel(wheel=wheel).values))
    return [headers, *(list(row) for row in zip(*columns, strict=True))]


def patch_table(dataset: xr.Dataset) -> list[Row]:
    """One row per sample, wheel and patch in contact; every wheel keeps a row in static analyses."""
    sample = "time" if "time" in dataset.dims else "pose"
    channels = _present(dataset, (sample, "wheel", "patch"))
    contact = _in_contact(dataset, sample)
    if sample == "pose":
        contact[:, :, 0] = True
    if sample == "time":
        context = [CHANNELS[n] for n in ("time", "distance") if n in dataset.coords]
    else:
        context = [CHANNELS["pose"], *_present(dataset, ("pose",)), *_present(dataset, ("pose", "wheel"))]
    headers = [channel.column for channel in context]
    where = headers.index("pose") + 1 if sample == "pose" else len(headers)
    headers[where:where] = ["wheel", "patch"]
    headers += [channel.column for channel in channels]
    i, j, k = np.nonzero(contact)
    cells = [_text(c, _at(dataset[c.name].values, i, j)) for c in context]
    cells[where:where] = [
        [str(w) for w in dataset["wheel"].values[j]],
        [str(p) for p in dataset["patch"].values[k]],
    ]
    cells += [_text(c, dataset[c.name].values[i, j, k]) for c in channels]
    return [headers, *(list(row) for row in zip(*cells, strict=True))]


def strip_table(dataset: xr.Dataset) -> list[Row]:
    """One row per strip of every pose or snapshot."""
    moment = "snapshot" if "snapshot" in dataset.dims else "pose"
    dims = (moment, "wheel", "patch", "strip")
    channels = _present(dataset, dims)
    if not channels:
        return [[moment, "wheel", "patch", "strip"]]
    used = np.zeros(dataset[channels[0].name].shape, dtype=bool)
    for channel in channels:
        used |= np.isfinite(dataset[channel.name].values)
    i, j, k, m = np.nonzero(used)
    context = [CHANNELS[moment]]
    if moment == "snapshot":
        context += [CHANNELS[n] for n in ("snapshot_time", "snapshot_distance") if n in dataset]
    headers = [c.column for c in context] + ["wheel", "patch", "strip"] + [c.column for c in channels]
    cells = [_text(c, dataset[c.name].values[i]) for c in context]
    cells += [
        [str(w) for w in dataset["wheel"].values[j]],
        [str(p) for p in dataset["patch"].values[k]],
        [str(n) for n in m],
    ]
    cells += [_text(c, dataset[c.name].values[i, j, k, m]) for c in channels]
    return [headers, *(list(row) for row in zip(*cells, strict=True))]


def _present(dataset: xr.Dataset, dims: tuple[str, ...]) -> list[Channel]:
    """Channels of the dataset with exactly these dimensions, in the register's order; labels left out."""
    return [
        channel
        for name, channel in CHANNELS.items()
        if name in dataset.variables and dataset[name].dims == dims and name not in dataset.dims
    ]


def _in_contact(dataset: xr.Dataset, sample: str) -> NDArray[np.bool_]:
    """(sample, wheel, patch) true where some channel of the patch has a finite, non-zero value."""
    contact = np.zeros(tuple(dataset.sizes[d] for d in (sample, "wheel", "patch")), dtype=bool)
    for channel in _present(dataset, (sample, "wheel", "patch")):
        values = dataset[channel.name].values
        contact |= values > 0 if channel.kind == "count" else np.isfinite(values)
    return contact


def _at(values: NDArray[Any], i: NDArray[Any], j: NDArray[Any]) -> NDArray[Any]:
    """Values of a (sample,) or (sample, wheel) channel for every row."""
    return values[i] if values.ndim == 1 else values[i, j]


def _text(channel: Channel, values: NDArray[Any]) -> list[str]:
    """Cells in the unit for readers, ten digits; empty for not-a-number."""
    if channel.kind != "number":
        return [str(v) for v in values]
    return ["" if v != v else f"{v:.10g}" for v in (values * channel.shown.factor + 0.0).tolist()]


def _csv(rows: Iterable[Row]) -> bytes:
    """Rows as comma-separated values (RFC 4180 quoting, line feeds, UTF-8)."""
    stored = io.BytesIO()
    stream = io.TextIOWrapper(stored, encoding="utf-8", newline="")
    csv.writer(stream, lineterminator="\n").writerows(rows)
    stream.flush()
    return stored.getvalue()
