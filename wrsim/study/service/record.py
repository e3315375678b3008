"""What a service left: its numbers against the mileage, written and read again."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from wrsim.errors import InputError
from wrsim.results.dataset import faults_of_attributes, faults_of_variable
from wrsim.results.netcdf import read_netcdf
from wrsim.results.render import as_records
from wrsim.results.table import Column, Table

NUMBERS = "wear.nc"
"""File of a service's numbers."""
FORMAT = "wrsim wear"
COLUMNS = {
    "mileage": ("mileage_km", 1e-3, "m", "mileage"),
    "flange_thickness": ("Sd_mm", 1e3, "m", "flange thickness Sd"),
    "flange_height": ("Sh_mm", 1e3, "m", "flange height Sh"),
    "flange_steepness": ("qR_mm", 1e3, "m", "flange steepness qR"),
    "conicity": ("conicity", 1.0, "1", "equivalent conicity"),
    "deepest": ("depth_mm", 1e3, "m", "largest depth worn off"),
    "deepest_u": ("depth_u_mm", 1e3, "m", "where that is"),
    "tread": ("tread_g_per_km", 1e6, "kg/m", "mass lost on the tread in the step that begins here"),
    "flange": ("flange_g_per_km", 1e6, "kg/m", "mass lost on the flange in the step that begins here"),
}
"""Numbers against the mileage: name in tables, factor, SI unit, meaning."""


def is_service(path: Path) -> bool:
    """True for the folder of a service, and for its file of numbers."""
    return path.name == NUMBERS or (path / NUMBERS).is_file()


def read_record(path: Path) -> xr.Dataset:
    """The dataset of a service, from its folder or its ``wear.nc``. Raises InputError for anything else."""
    file = path / NUMBERS if path.is_dir() else path
    dataset = read_netcdf(file, "service")
    if dataset.attrs.get("format") != FORMAT:
        raise InputError(f"{file}: a wrsim file, but no service")
    for fault in _faults(dataset):
        raise InputError(f"{file}: says that it is a service, but {fault}; run it again")
    return dataset


def _faults(dataset: xr.Dataset) -> Iterator[str]:
    """What is wrong with the dataset of a service; see `history`."""
    yield from faults_of_attributes(dataset.attrs, ("title", "law"))
    layout = dict.fromkeys(COLUMNS, ("point",)) | dict.fromkeys(("u", "w", "depth"), ("point", "place"))
    for name, dims in (layout | {"unworn_u": ("place",)}).items():
        yield from faults_of_variable(dataset, name, dims, "number")
    if 0 in dataset.sizes.values():
        yield "holds no numbers"
    for name in ("mileage", "u", "w", "depth", "unworn_u"):
        if not np.isfinite(dataset[name].values).all():
            yield f"its {name} is not finite everywhere"


def table_of(dataset: xr.Dataset) -> Table:
    """Numbers against the mileage, in units for readers."""
    columns = []
    for column, _, _, _ in COLUMNS.values():
        words, _, unit = column.partition("_")
        columns.append(Column(words, unit.replace("_per_", "/").removeprefix("u_"), ".5g", column))
    rows = [
        [factor * float(dataset[name].values[i]) for name, (_, factor, _, _) in COLUMNS.items()]
        for i in range(dataset.sizes["point"])
    ]
    return Table(str(dataset.attrs["title"]), tuple(columns), rows)


def report_of(dataset: xr.Dataset) -> dict[str, Any]:
    """What stands in ``wear.json``: title, law, the numbers at the start and at the end."""
    records = as_records(table_of(dataset))
    ends = {"new": records[0], "worn": records[-1]}
    return {"title": dataset.attrs["title"], "law": dataset.attrs["law"], "steps": dataset.sizes["point"] - 1} | ends
