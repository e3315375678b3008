"""Ride: what was evaluated of the accelerations at the points of a vehicle. Made by ``wrsim.analysis.ride``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.files import as_csv, as_json
from wrsim.results.table import Column, Table, formatted, quantity

AXES = ("x", "y", "z")


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
            "points": {name: self._point(name) for name in self.points},
        }

    def _point(self, name: str) -> dict[str, Any]:
        own = self.data.sel(point=name)
        found: dict[str, Any] = {
            f"{name}_m_s2": {axis: _plain(own[name].sel(axis=axis).item()) for axis in AXES}
            for name in ("rms", "peak", "weighted_rms", "comfort_95")
        }
        return found | {"N_MV": _plain(own["N_MV"].item())}

    def table(self, name: str = "") -> Table:
        """Rows by point and axis. name: of the run, where there are several."""
        keys = ("rms_m_s2", "peak_m_s2", "weighted_rms_m_s2", "comfort_95_m_s2")
        rows = [
            (f"{name}: {point}" if name else point, axis, *(of[key][axis] for key in keys), "" if i else of["N_MV"])
            for point, of in self.as_dict()["points"].items()
            for i, axis in enumerate(AXES)
        ]
        words = ("rms", "peak", "weighted rms", "95 % of 5 s")
        heads = (Column("point"), Column("axis"), *(Column(word, "m/s²") for word in words), Column("N_MV"))
        stretch = f"{formatted(self.start, '.0f')} to {quantity(self.end, 'm', '.0f')}"
        title = f"{self.title}: {stretch}, {quantity(self.duration, 's', '.0f')}"
        blocks = int(self.data.attrs["blocks"])
        note = f"weighted: Wd along x and y, Wb along z; {blocks} blocks of 5 s (EN 12299 asks for 60)"
        return Table(title, heads, rows, (note,))

    def json(self) -> bytes:
        """Content of ``ride.json``."""
        return as_json(self.as_dict(), indent=1)

    def bands_csv(self) -> bytes:
        """Content of ``third_octaves.csv``: a row a band, a column a point and axis, rms in m/s2."""
        low, high = self.data["band_low"].values, self.data["band_high"].values
        head = ["band_Hz", "low_Hz", "high_Hz"]
        rows = np.column_stack((self.data["band"].values, low, high, self._columns("band_rms")))
        return _table([*head, *self._names("m_s2")], rows)

    def spectra_csv(self) -> bytes:
        """Content of ``spectra.csv``: a row a frequency, a column a point and axis, in (m/s2)2/Hz."""
        rows = np.column_stack((self.data["frequency"].values, self._columns("density")))
        return _table(["frequency_Hz", *self._names("m2_s4_per_Hz")], rows)

    def _columns(self, name: str) -> np.ndarray:
        values = self.data[name].values
        return np.asarray(values.reshape(values.shape[0], -1))

    def _names(self, unit: str) -> list[str]:
        return [f"{point} a{axis}_{unit}" for point in self.points for axis in AXES]


def _plain(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _table(head: list[str], rows: np.ndarray) -> bytes:
    return as_csv([head, *([f"{value:.6g}" for value in row] for row in rows)])
