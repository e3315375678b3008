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

from wrsim.results.channels import CHANNELS
from wrsim.results.files import write_atomically
from wrsim.results.result import Result
from wrsim.results.wheelsets import of_wheelset, wheelsets

Row = list[str]

MODES = ("pose_speed", "mode_branch", "mode_frequency", "mode_damping", "mode_growth", "mode_name")
STEADY = (
    "pose", "wheelset", "wheel", "pose_radius", "pose_cant", "pose_speed", "cant_deficiency", "unbalanced",
    "lateral_shift", "yaw", "roll", "Y", "Q", "X", "Y_over_Q", "T_gamma", "n_patches",
    "N", "contact_angle", "p0", "xi", "eta", "phi", "pose_message",
)  # fmt: skip
"""Columns of the table of steady motions; those of patches are of the one with the largest normal force."""

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
    if "mode" in dataset.dims:
        yield "modes", _long(dataset, MODES, np.isfinite(dataset["mode_growth"].values), ("pose", "mode"))
        if "cycle" in dataset.dims:
            yield "cycles", _wide(dataset, "cycle", ("wheelset",))
        return
    if "pose_radius" in dataset:
        yield "steady", _steady_table(dataset)
        return
    names = wheelsets(dataset)
    if "time" in dataset.dims and (len(names) > 1 or {"body", "point", "suspension"} & set(dataset.dims)):
        yield "vehicle", _in_blocks(lambda part: _wide(part, "time", ("body", "point", "suspension")), dataset)
    for name in names:
        own = f"_{name}" if len(names) > 1 else ""
        yield from ((table + own, rows) for table, rows in _of_wheelset(of_wheelset(dataset, name)))


def _of_wheelset(one: xr.Dataset) -> Iterator[tuple[str, Iterable[Row]]]:
    """The tables of one wheelset."""
    if "time" in one.dims:
        yield "history", _in_blocks(lambda part: _wide(part, "time", ("wheel",)), one)
    if any("patch" in variable.dims and "strip" not in variable.dims for variable in one.values()):
        yield "patches", _in_blocks(_patch_table, one)
    if "strip" in one.dims:
        yield "strips", _strip_table(one)
    if "amplitude" in one.dims:
        yield "conicity", _wide(one, "amplitude")


def _in_blocks(table: Callable[[xr.Dataset], list[Row]], dataset: xr.Dataset) -> Iterator[Row]:
    """The rows of a table, those of a run some instants at a time."""
    for begin in range(0, max(dataset.sizes.get("time", 0), 1), BLOCK):
        rows = table(dataset.isel(time=slice(begin, begin + BLOCK), missing_dims="ignore"))
        yield from rows[1:] if begin else rows


def _patch_table(one: xr.Dataset) -> list[Row]:
    """One row per sample, wheel and patch in contact; every wheel keeps a row in static analyses."""
    sample = "time" if "time" in one.dims else "pose"
    channels = _present(one, (sample, "wheel", "patch"))
    contact = _chosen(one, channels)
    if sample == "pose":
        contact[:, :, 0] = True
    context = ["distance"] if "distance" in one.coords else []
    pose = [*_present(one, ("pose",)), *_present(one, ("pose", "wheel"))]
    return _long(one, [sample, *context, "wheel", "patch", *pose, *channels], contact, (sample, "wheel", "patch"))


def _strip_table(one: xr.Dataset) -> list[Row]:
    """One row per strip of every pose or snapshot."""
    moment = "snapshot" if "snapshot" in one.dims else "pose"
    dims = (moment, "wheel", "patch", "strip")
    channels = _present(one, dims)
    context = [name for name in ("snapshot_time", "snapshot_distance") if name in one]
    return _long(one, [moment, *context, *dims[1:], *channels], _chosen(one, channels), dims)


def _steady_table(dataset: xr.Dataset) -> list[Row]:
    """One row per curve, wheelset and wheel; a curve without a steady motion keeps one row, with its message."""
    solved = np.broadcast_to((dataset["pose_message"].values == "")[:, None, None], dataset["Y"].shape).copy()
    failed = ~solved[:, 0, 0]
    solved[failed, 0, 0] = True
    table = _long(dataset.isel(patch=0), STEADY, solved, ("pose", "wheelset", "wheel"))
    for row in table[1:]:
        if row[-1]:
            row[1:3], row[8:-1] = ["", ""], [""] * len(row[8:-1])
    return table


def _wide(dataset: xr.Dataset, dim: str, others: Iterable[str] = ()) -> list[Row]:
    """One row per label of a dimension; channels with another dimension as well have a column for each of its labels,
    such as ``Y_left_kN``."""
    channels = [dim] if dim in CHANNELS else []
    channels += _present(dataset, (dim,))
    columns = [(CHANNELS[name].column, _text(name, dataset[name].values)) for name in channels]
    for other in others:
        for name in _present(dataset, (dim, other)):
            for label in dataset[other].values:
                words = [name, str(label), CHANNELS[name].shown.suffix]
                header = "_".join(word for word in words if word).replace(" ", "_")
                columns.append((header, _text(name, dataset[name].sel({other: label}).values)))
    return _rows(columns)


def _long(dataset: xr.Dataset, names: Iterable[str], chosen: NDArray[np.bool_], dims: tuple[str, ...]) -> list[Row]:
    """One row per chosen place in these dimensions; a channel may have some of the dimensions only."""
    at = dict(zip(dims, np.nonzero(chosen), strict=True))
    columns = []
    for name in names:
        if name in CHANNELS:
            values = dataset[name]
            columns.append((CHANNELS[name].column, _text(name, values.values[tuple(at[str(d)] for d in values.dims)])))
        else:
            columns.append((name, [str(i) for i in at[name]]))
    return _rows(columns)


def _rows(columns: list[tuple[str, list[str]]]) -> list[Row]:
    """Rows, the header first, from columns with their headers."""
    return [[header for header, _ in columns], *(list(row) for row in zip(*(c for _, c in columns), strict=True))]


def _present(dataset: xr.Dataset, dims: tuple[str, ...]) -> list[str]:
    """Channels of the dataset with exactly these dimensions, in the register's order; labels left out."""
    return [n for n in CHANNELS if n in dataset.variables and dataset[n].dims == dims and n not in dataset.dims]


def _chosen(dataset: xr.Dataset, channels: list[str]) -> NDArray[np.bool_]:
    """True where one of these channels, alike in their dimensions, has a finite value, or a count above zero."""
    arrays = ((CHANNELS[name].kind, dataset[name].values) for name in channels)
    return np.any([values > 0 if kind == "count" else np.isfinite(values) for kind, values in arrays], axis=0)


def _text(name: str, values: NDArray[Any]) -> list[str]:
    """Cells of a channel in the unit for readers, ten digits; empty for not-a-number."""
    if CHANNELS[name].kind != "number":
        return [str(v) for v in values]
    return ["" if v != v else f"{v:.10g}" for v in (values * CHANNELS[name].shown.factor + 0.0).tolist()]


def _csv(rows: Iterable[Row]) -> bytes:
    """Rows as comma-separated values (RFC 4180 quoting, line feeds, UTF-8)."""
    stored = io.BytesIO()
    stream = io.TextIOWrapper(stored, encoding="utf-8", newline="")
    csv.writer(stream, lineterminator="\n").writerows(rows)
    stream.flush()
    return stored.getvalue()
