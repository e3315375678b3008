"""Measured track: a CSV table of geometry and irregularities against distance.

Columns: distance and at least one more of ``COLUMNS``; signs as everywhere, left and up positive. Curvature and grade
are taken as straight between the rows, cant, gauge and irregularities as cubic splines, so that rails have continuous
tangents and curvatures.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy

from wrsim.errors import InputError
from wrsim.inputs.csv_tables import check_rising, read_columns
from wrsim.inputs.values import number
from wrsim.jit.butterworth import butterworth, zero_phase
from wrsim.track.irregularities import WEIGHTS, Disturbance, Sampled
from wrsim.track.piecewise import Array, Piecewise
from wrsim.track.segments import MAX_CANT, MAX_WIDENING, Laws

GEOMETRY = ("curvature_per_km", "cant_mm", "gauge_mm", "grade_permille")
IRREGULARITIES = {
    "alignment_mm": WEIGHTS["alignment"],
    "level_mm": WEIGHTS["level"],
    "cross_level_mm": WEIGHTS["cross-level"],
    "gauge_deviation_mm": WEIGHTS["gauge"],
    "left_lateral_mm": (1.0, 0.0, 0.0, 0.0),
    "left_vertical_mm": (0.0, 1.0, 0.0, 0.0),
    "right_lateral_mm": (0.0, 0.0, 1.0, 0.0),
    "right_vertical_mm": (0.0, 0.0, 0.0, 1.0),
}
"""Columns of irregularities and their weights on both rails."""

COLUMNS = {
    "distance_m": Annotated[float, number(-1e7, 1e7)],
    "curvature_per_km": Annotated[float, number(-100, 100, "1000 / radius in m, positive to the left")],
    "cant_mm": Annotated[float, number(-1e3 * MAX_CANT, 1e3 * MAX_CANT, "positive: right rail higher")],
    "gauge_mm": Annotated[float, number(400, 2000)],
    "grade_permille": Annotated[float, number(-150, 150, "positive: uphill")],
} | dict.fromkeys(IRREGULARITIES, Annotated[float, number(-200, 200, "mm")])

ROWS_A_WAVE = 2.0  # fewest rows of a table within a wave that it can resolve (Nyquist)


@dataclass(frozen=True, eq=False)
class TrackTable:
    """Columns of a table by name, in the file's units; distance from its first row on [m]."""

    path: Path
    distance: Array
    columns: dict[str, Array]

    @classmethod
    def read(cls, path: str | Path) -> TrackTable:
        """Read and check a table. Raises InputError with file, line, column and what is allowed."""
        path = Path(path)
        columns, lines = read_columns(path, COLUMNS, ("distance_m",))
        distance = columns.pop("distance_m")
        if not columns:
            raise InputError(f"{path}: nothing but distance_m; add one of {', '.join(list(COLUMNS)[1:])}")
        if distance.size < 4:
            raise InputError(f"{path}: {distance.size} rows; a track needs at least 4")
        check_rising(path, "distance_m", distance, lines)
        return cls(path, distance - distance[0], columns)

    @property
    def length(self) -> float:
        return float(self.distance[-1])

    def laws(self, gauge: float) -> Laws:
        """Curvature, cant, gauge and grade; what has no column is straight, level, at the nominal gauge [m].

        Raises InputError when there is no column of geometry, or the gauge strays too far.
        """
        if not set(GEOMETRY) & set(self.columns):
            raise InputError(f"{self.path}: has no geometry; a track needs one of the columns {', '.join(GEOMETRY)}")
        zero = np.zeros(self.distance.size)
        widening = self.columns.get("gauge_mm", 1e3 * gauge + zero) / 1e3 - gauge
        if np.abs(widening).max() > MAX_WIDENING:
            most = 1e3 * (gauge + widening[np.argmax(np.abs(widening))])
            allowed = f"within {1e3 * MAX_WIDENING:g} of gauge_mm = {1e3 * gauge:g} of the track"
            raise InputError(f"{self.path}: gauge_mm reaches {most:g}; must stay {allowed}")
        grade = self.columns.get("grade_permille", zero) / 1e3
        return Laws(
            curvature=Piecewise.through(self.distance, self.columns.get("curvature_per_km", zero) / 1e3),
            cant=Piecewise(scipy.interpolate.CubicSpline(self.distance, self.columns.get("cant_mm", zero) / 1e3)),
            widening=Piecewise(scipy.interpolate.CubicSpline(self.distance, widening)),
            pitch=Piecewise.through(self.distance, np.arctan(grade)),
        )

    def disturbances(
        self, start: float, fade: float, scale: float = 1.0, band: tuple[float, float] | None = None
    ) -> tuple[Disturbance, ...]:
        """The irregularities, with the table's first row at ``start`` [m].

        fade: length over which they begin and end [m]; band: shortest and longest wavelength that pass [m] (two
        Butterworth filters of fourth order, run forward and back for zero phase).
        Raises InputError when there is no such column, or the rows do not resolve the band.
        """
        names = [name for name in IRREGULARITIES if name in self.columns]
        if not names:
            raise InputError(f"{self.path}: has no irregularities; columns: {', '.join(IRREGULARITIES)}")
        steps = np.diff(self.distance)
        shortest, widest = ROWS_A_WAVE * float(np.median(steps)), float(steps.max())
        if band is not None and band[0] < ROWS_A_WAVE * widest:
            rows = f"its rows are up to {widest:g} m apart and resolve no waves shorter than {ROWS_A_WAVE * widest:g} m"
            raise InputError(f"{self.path}: {rows}; wavelength_m begins at {band[0]:g}")
        disturbances = []
        for name in names:
            distance, values = self.distance, scale * self.columns[name] / 1e3
            if band is not None:
                distance, values = _filtered(distance, values, band)
            shape = Sampled.through(start + distance, values, min(fade, 0.5 * self.length), shortest)
            disturbances.append(Disturbance(shape, IRREGULARITIES[name]))
        return tuple(disturbances)


def _filtered(distance: Array, values: Array, band: tuple[float, float]) -> tuple[Array, Array]:
    """Values at even distances, with the waves in the band alone."""
    count = distance.size
    even = np.linspace(distance[0], distance[-1], count)
    values = scipy.interpolate.CubicSpline(distance, values)(even)
    per_metre = (count - 1) / (distance[-1] - distance[0])
    high = min(1.0 / band[0], 0.499 * per_metre)
    filters = (1.0 / band[1], True), (high, False)
    sections = np.concatenate([butterworth(4, edge, highpass, per_metre) for edge, highpass in filters])
    return even, zero_phase(sections, values, min(count - 1, int(3.0 * band[1] * per_metre)))
