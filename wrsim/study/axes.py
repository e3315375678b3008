"""The values of an axis of a study."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.errors import InputError
from wrsim.inputs.csv_tables import csv_cells, separator_of, table_lines
from wrsim.inputs.lookup import Finder
from wrsim.inputs.section import given
from wrsim.inputs.toml_files import parse_value
from wrsim.study.spec import Axis, CsvAxis, GridAxis, LatinHypercubeAxis, SampledKey, SobolAxis, axis_name

ID = "id"
"""Column of a table that names its rows."""


@dataclass(frozen=True)
class AxisPoints:
    """The points of one axis.

    name: of its dimension; keys: groups of dotted keys, those of one group take the same value; values (n, groups);
    places: where each point is given, for messages; labels: names of points, if any; listed: rows or samples, no grid.
    """

    name: str
    keys: tuple[tuple[str, ...], ...]
    values: tuple[tuple[Any, ...], ...]
    places: tuple[str, ...]
    labels: tuple[str, ...] = ()
    listed: bool = False

    @property
    def columns(self) -> tuple[str, ...]:
        """One name a group: that of the axis for a grid, else the first key."""
        return (self.name,) if not self.listed else tuple(group[0] for group in self.keys)


def axis_points(axis: Axis, finder: Finder, where: str) -> AxisPoints:
    """The points of an axis. where: file and line of its table. Raises InputError for a table that does not do."""
    if isinstance(axis, GridAxis):
        values = tuple((value,) for value in axis.values)
        return AxisPoints(axis_name(axis), (axis.key,), values, (where,) * len(values))
    if isinstance(axis, CsvAxis):
        try:
            path = finder.find(axis.file)
        except InputError as error:
            raise InputError(f'{where}: vary.file = "{axis.file}": {error}') from None
        return _rows(path, axis.name)
    values = tuple(zip(*_sampled(axis), strict=True))
    return AxisPoints(axis.name, tuple(key.key for key in axis.over), values, (where,) * len(values), listed=True)


def _sampled(axis: SobolAxis | LatinHypercubeAxis) -> list[list[float]]:
    """Samples of every key: the same for the same seed."""
    from scipy.stats import qmc

    generator = np.random.default_rng(axis.seed)
    sampler = (qmc.Sobol if isinstance(axis, SobolAxis) else qmc.LatinHypercube)(len(axis.over), rng=generator)
    unit = sampler.random(axis.samples)
    return [sampled_values(part, key) for part, key in zip(unit.T, axis.over, strict=True)]


def sampled_values(part: NDArray[np.float64], key: SampledKey) -> list[float]:
    """Values of a key from parts (n,) of its range or of its distribution, from 0 to 1."""
    from scipy.stats import norm

    if key.mean is not None:
        values = norm.ppf(np.clip(part, 1e-9, 1.0 - 1e-9), key.mean, key.deviation)
    elif key.spacing == "log":
        low, high = np.log(given(key.low)), np.log(given(key.high))
        values = np.exp(low + part * (high - low))
    else:
        values = given(key.low) + part * (given(key.high) - given(key.low))
    return [round(v) if key.whole else v for v in values.tolist()]


def _rows(path: Path, name: str) -> AxisPoints:
    """The rows of a table; cells are values as in TOML, and bare words are texts."""
    lines = table_lines(path)
    if len(lines) < 2:
        where = f"{path}:{lines[0][0]}: is all that is there" if lines else f"{path}: is empty"
        raise InputError(f"{where}; must have a header of dotted keys and a row for every case")
    (first, header), *rows = (csv_cells(path, *line, separator_of(lines[0][1])) for line in lines)
    for column in header:
        if not column:
            raise InputError(f"{path}:{first}: a column has no name; must be a dotted key such as vehicle.speed_kmh")
        if header.count(column) > 1:
            raise InputError(f"{path}:{first}: column {column}: duplicate key")
    keys = [column for column in header if column != ID]
    if not keys:
        raise InputError(f"{path}:{first}: no column varies a key; must be dotted keys such as vehicle.speed_kmh")
    values: list[tuple[Any, ...]] = []
    labels: dict[str, int] = {}
    for number, row in rows:
        where = f"{path}:{number}"
        if len(row) != len(header):
            raise InputError(f"{where}: has {len(row)} cells; must have {len(header)} like the header")
        cells = dict(zip(header, row, strict=True))
        if empty := [key for key in header if not cells[key]]:
            raise InputError(f"{where}: {empty[0]}: the cell is empty; must be a value for that key")
        if ID in cells and labels.setdefault(cells[ID], number) != number:
            raise InputError(f"{where}: id = {cells[ID]}: is the name of another row")
        values.append(tuple(parse_value(cells[key]) for key in keys))
    places = tuple(f"{path}:{number}" for number, _ in rows)
    return AxisPoints(name, tuple((key,) for key in keys), tuple(values), places, tuple(labels), listed=True)
