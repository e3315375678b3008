"""Ride: what was evaluated of the accelerations at the points of a vehicle. Made by ``wrsim.analysis.ride``."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.files import as_csv, as_json
from wrsim.results.table import Column, Table, as_rows, finite, formatted, quantity

AXES = ("x", "y", "z")
OF_AXES = {"rms": "rms", "peak": "peak", "weighted_rms": "weighted rms", "comfort_95": "95 % of 5 s"}
"""Numbers of every axis, and their headings."""


@dataclass(frozen=True, eq=False)
class Ride:
    """Spectra, third-octaves and comfort of every point.

    start, end [m]: stretch that was evaluated; duration [s]; segments: averaged for the spectra; data: variables

    - ``density`` (frequency, point, axis) [(m/s2)2/Hz], one-sided; ``frequency`` [Hz];
    - ``band_rms`` (band, point, axis) [m/s2]; ``band``: nominal middle [Hz], ``band_low``, ``band_high``: edges [Hz];
    - ``rms``, ``weighted_rms`` (point, axis) [m/s2]; ``peak`` (point, axis) [m/s2]: largest magnitude, unfiltered;
    - ``comfort_95`` (point, axis) [m/s2]: 95 % percentile of the weighted rms over blocks of 5 s; ``N_MV`` (point);
      not-a-number for a run shorter than a block; ``blocks`` is an attribute.
    """

    title: str
    start: float
    end: float
    duration: float
    segments: int
    data: xr.Dataset

    @property
    def points(self) -> tuple[str, ...]:
        """Names of the points."""
        return tuple(str(p) for p in self.data["point"].values)

    @property
    def stretch(self) -> str:
        """The stretch in words."""
        return f"{formatted(self.start, '.0f')} to {quantity(self.end, 'm', '.0f')}"

    def as_dict(self) -> dict[str, Any]:
        """What ``ride.json`` holds: numbers by point and axis, SI units in the keys."""
        return {
            "title": self.title,
            "from_m": self.start,
            "to_m": self.end,
            "duration_s": self.duration,
            "segments_of_spectra": self.segments,
            "blocks_of_5_s": int(self.data.attrs["blocks"]),
            "weightings": dict(zip(AXES, str(self.data.attrs["weightings"]).split(), strict=True)),
            "points": {
                point: {f"{name}_m_s2": dict(zip(AXES, map(finite, row[name].values), strict=True)) for name in OF_AXES}
                | {"N_MV": finite(row["N_MV"].item())}
                for point in self.points
                for row in (self.data.sel(point=point),)
            },
        }

    def table(self, name: str = "") -> Table:
        """Rows by point and axis. name: of the run, where there are several."""
        name += ": " * bool(name)
        rows = [
            (name + point, axis, *(of[f"{key}_m_s2"][axis] for key in OF_AXES), "" if i else of["N_MV"])
            for point, of in self.as_dict()["points"].items()
            for i, axis in enumerate(AXES)
        ]
        heads = (Column("point"), Column("axis"), *(Column(word, "m/s²") for word in OF_AXES.values()), Column("N_MV"))
        title = f"{self.title}: {self.stretch}, {quantity(self.duration, 's', '.0f')}"
        blocks = int(self.data.attrs["blocks"])
        note = f"weighted: Wd along x and y, Wb along z; {blocks} blocks of 5 s (EN 12299 asks for 60)"
        return Table(title, heads, rows, (note,))

    def files(self) -> dict[str, bytes]:
        """Contents of files by names: numbers; third-octaves [m/s2], spectra [(m/s2)2/Hz], a column a point, axis."""
        names = [f"{point} a{axis}" for point in self.points for axis in AXES]
        return {"ride.json": as_json(self.as_dict(), indent=1), **csv_files(self.data, names, "m_s2", "m2_s4_per_Hz")}


def csv_files(data: xr.Dataset, names: Iterable[str], unit: str, of_density: str, behind: str = "") -> dict[str, bytes]:
    """Third-octaves and spectra: a row a frequency, a column for each of the names. behind: the names of the files."""
    files = {}
    for file, variable, symbol, heads in (
        ("third_octaves", "band_rms", unit, {"band_Hz": "band", "low_Hz": "band_low", "high_Hz": "band_high"}),
        ("spectra", "density", of_density, {"frequency_Hz": "frequency"}),
    ):
        first: list[Any] = [data[name].values for name in heads.values()]
        rows = np.column_stack((*first, data[variable].values.reshape(first[0].size, -1))).tolist()
        columns = tuple(Column(key=key) for key in (*heads, *(f"{name}_{symbol}" for name in names)))
        files[f"{file}{behind}.csv"] = as_csv(as_rows(Table("", columns, rows)))
    return files
