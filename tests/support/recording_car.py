"""A recording car by geometry alone: points of the swept rails, chords between them, noise, a CSV."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wrsim import Arc, Straight, Track, Transition
from wrsim.geometry.track.spectra import Realisation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Car:
    """Runs along a track with a row every ``step`` [m]; noise: standard deviation of each length that it measures
    [m].
    """

    track: Track
    step: float = 0.25
    noise: float = 0.0
    margin: float = 30.0
    seed: int = 1

    @property
    def distance(self) -> Array:
        """Of the rows [m]: where every chord lies on the track."""
        return np.arange(self.margin, self.track.length - self.margin, self.step)

    def frames(self, side: str, s: Array) -> Array:
        """Points and axes (r, t, n, b) of a rail beside the centre line's distances s, (n, 4, 3)."""
        path = {"left": self.track.left, "right": self.track.right}[side]
        return path.frame(self.track.rail_distance(side, s))

    def versine(self, side: str, behind: float, ahead: float) -> tuple[Array, Array]:
        """How far the rail lies to the left of and above a chord that ends on it [m], in the axes of its
        cross-section.
        """
        s = self.distance
        here, rear, front = (self.frames(side, s + x) for x in (0.0, -behind, ahead))
        along = front[:, 0] - rear[:, 0]
        along /= np.linalg.norm(along, axis=1)[:, None]
        off = here[:, 0] - rear[:, 0]
        off -= np.sum(off * along, axis=1)[:, None] * along
        return np.sum(off * here[:, 2], axis=1), np.sum(off * here[:, 3], axis=1)

    def curvature(self, base: float) -> Array:
        """Of the circle through three points of the middle between the rails, ``base`` [m] from the first to the last,
        seen from above.
        """
        points = [
            0.5 * sum(self.frames(side, self.distance + x)[:, 0, :2] for side in ("left", "right"))
            for x in (-0.5 * base, 0.0, 0.5 * base)
        ]
        a, b, c = points[1] - points[0], points[2] - points[1], points[2] - points[0]
        cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        return 2.0 * cross / (np.linalg.norm(a, axis=1) * np.linalg.norm(b, axis=1) * np.linalg.norm(c, axis=1))

    def cant(self) -> Array:
        """Height of the right rail above the left one, by both rails' points, over the cant base [m]."""
        track = self.track
        left, right = (self.frames(side, self.distance)[:, 0] for side in ("left", "right"))
        between = left - right
        wide = np.linalg.norm(between, axis=1)
        return -between[:, 2] / wide * track.cant_base

    def gauge(self) -> Array:
        """Between the gauge points [m]."""
        return self.track.gauge(self.distance)

    def write(self, path: Path, columns: dict[str, Array], digits: int = 6) -> Path:
        """A CSV of these columns, in mm but for distance_m and curvature_per_km; lengths with the car's noise."""
        random = np.random.default_rng(self.seed)
        rows = {"distance_m": self.distance}
        for name, values in columns.items():
            if name.startswith("curvature"):
                rows[name] = 1e3 * values
            else:
                rows[name] = 1e3 * (values + self.noise * random.standard_normal(values.size))
        text = [",".join(rows)] + [
            ",".join(f"{v:.{digits}f}" for v in row) for row in np.stack([*rows.values()], axis=1)
        ]
        path.write_text("\n".join(text) + "\n")
        return path


def shipped_line() -> tuple[Car, dict[str, Array]]:
    """The car and the columns of ``scenarios/recorded/line.csv``: a left curve of 500 m, a chord of 4 + 6 m.

    Write it anew by ``car.write(path, columns, 2)``.
    """
    line = [Straight(180.0), Transition(60.0), Arc(140.0, 500.0, 0.11, 0.005), Transition(60.0), Straight(160.0)]
    uneven = Realisation("FRA-5", 4, 3.0, 60.0, 0.0, 600.0, 0.7, 20.0).disturbances()
    apart = (0.0325, 0.0)
    car = Car(Track.build(line, irregularities=uneven, left_offset=apart, right_offset=apart), 0.5, 30e-6)
    columns = {"curvature_per_km": car.curvature(20.0), "cant_mm": car.cant(), "gauge_mm": car.gauge()}
    for side in ("left", "right"):
        columns[f"alignment_{side}_mm"], columns[f"level_{side}_mm"] = car.versine(side, 4.0, 6.0)
    return car, columns
