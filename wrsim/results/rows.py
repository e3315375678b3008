"""Rows of tables from a labelled dataset: units at the end of every column name."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.results.channels import CHANNELS

Row = list[str]


def wide(dataset: xr.Dataset, dim: str, others: Iterable[str] = ()) -> list[Row]:
    """One row per label of a dimension; channels with another dimension as well have a column for each of its labels,
    such as ``Y_left_kN``."""
    channels = [dim] if dim in CHANNELS else []
    channels += present(dataset, (dim,))
    columns = [(CHANNELS[name].column, cells_of(name, dataset[name].values)) for name in channels]
    for other in others:
        for name in present(dataset, (dim, other)):
            for label in dataset[other].values:
                words = [name, str(label), CHANNELS[name].shown.suffix]
                header = "_".join(word for word in words if word).replace(" ", "_")
                columns.append((header, cells_of(name, dataset[name].sel({other: label}).values)))
    return rows_of(columns)


def long(dataset: xr.Dataset, names: Iterable[str], chosen: NDArray[np.bool_], dims: tuple[str, ...]) -> list[Row]:
    """One row per chosen place in these dimensions; a channel may have some of the dimensions only."""
    at = dict(zip(dims, np.nonzero(chosen), strict=True))
    columns = []
    for name in names:
        if name in CHANNELS:
            values = dataset[name]
            columns.append(
                (CHANNELS[name].column, cells_of(name, values.values[tuple(at[str(d)] for d in values.dims)]))
            )
        else:
            columns.append((name, [str(i) for i in at[name]]))
    return rows_of(columns)


def rows_of(columns: list[tuple[str, list[str]]]) -> list[Row]:
    """Rows, the header first, from columns with their headers."""
    return [[header for header, _ in columns], *(list(row) for row in zip(*(c for _, c in columns), strict=True))]


def present(dataset: xr.Dataset, dims: tuple[str, ...]) -> list[str]:
    """Channels of the dataset with exactly these dimensions, in the register's order; labels left out."""
    return [n for n in CHANNELS if n in dataset.variables and dataset[n].dims == dims and n not in dataset.dims]


def chosen(dataset: xr.Dataset, channels: list[str]) -> NDArray[np.bool_]:
    """True where one of these channels, alike in their dimensions, has a finite value, or a count above zero."""
    arrays = ((CHANNELS[name].kind, dataset[name].values) for name in channels)
    return np.any([values > 0 if kind == "count" else np.isfinite(values) for kind, values in arrays], axis=0)


def cells_of(name: str, values: NDArray[Any]) -> list[str]:
    """Cells of a channel in the unit for readers."""
    if CHANNELS[name].kind != "number":
        return [str(v) for v in values]
    return number_cells(values * CHANNELS[name].shown.factor)


def number_cells(values: NDArray[Any]) -> list[str]:
    """Ten digits; empty for not-a-number."""
    return ["" if v != v else f"{v:.10g}" for v in (values + 0.0).tolist()]
