"""Labelled runs of a study as a table for training: inputs, outputs, name of the case, a row a case."""

import numpy as np
import xarray as xr

from wrsim.results.exports import parquet_table
from wrsim.results.files import as_json
from wrsim.results.table import Column, Table

INPUT, OUTPUT = "input", "output"


def labelled_columns(study: xr.Dataset) -> dict[str, tuple[np.ndarray, dict[str, str]]]:
    """Columns (cases,) by name with their role, key or unit: what is varied, outputs, case (digest of its scenario and
    of the files that it reads), status."""
    status = study["status"]

    def column(variable: xr.DataArray) -> np.ndarray:
        return np.asarray(variable.broadcast_like(status).transpose(*status.dims)).ravel()

    columns: dict[str, tuple[np.ndarray, dict[str, str]]] = {
        "case": (column(study["name"]).astype(str), {"role": "scenario digest"}),
        "status": (column(status).astype(str), {"role": "status"}),
    }
    for name, coordinate in study.coords.items():
        if key := coordinate.attrs.get("key"):
            columns[str(name)] = column(coordinate), {"role": INPUT, "key": str(key)}
    for name, variable in study.data_vars.items():
        if variable.dtype.kind == "f":
            unit = str(variable.attrs.get("units", "1"))
            columns[str(name)] = column(variable), {"role": OUTPUT, "unit": unit}
    return columns


def as_parquet(study: xr.Dataset) -> bytes:
    """The columns as Parquet; the file's metadata: title, texts of study and scenario, versions. Raises InputError."""
    columns = labelled_columns(study).items()
    table = ((name, v.astype(str) if v.dtype.kind == "O" else v, about) for name, (v, about) in columns)
    texts = {key: value for key, value in study.attrs.items() if isinstance(value, str)}
    return parquet_table("wrsim dataset", table, {"wrsim": as_json(texts)})


def labelled_table(study: xr.Dataset) -> Table:
    """How many rows there are, and what the columns are."""
    columns = labelled_columns(study)
    rows = [(name, about["role"], about.get("key", about.get("unit", ""))) for name, (_, about) in columns.items()]
    completed = int((columns["status"][0] == "completed").sum())
    note = f"{study['status'].size} rows, {completed} completed"
    return Table(str(study.attrs["title"]), (Column("column"), Column("role"), Column("key or unit")), rows, (note,))
