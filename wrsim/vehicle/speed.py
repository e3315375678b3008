"""The speed along the line: constant, or pieces of constant acceleration over time or distance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf, sqrt

import numpy as np

from wrsim.vehicle.elements import Array

Row = tuple[float, float]

PIECE, LONGEST = 0.05, 1e4
"""Length of the pieces of a motion that motors and brakes decide, and of all together [s]."""


@dataclass(frozen=True)
class SpeedProfile:
    """Where the frame of the track is, from the start of a run on: pieces of constant acceleration.

    pieces: rows (time [s], way from the start [m], speed [m/s], acceleration [m/s2]) of their beginnings, the first at
    the time 0; the last piece has no end. stands_after: way after which braking has reached the lowest speed [m].
    """

    pieces: tuple[tuple[float, float, float, float], ...]
    stands_after: float = inf

    @classmethod
    def constant(cls, speed: float) -> SpeedProfile:
        """One speed [m/s]."""
        return cls(((0.0, 0.0, speed, 0.0),))

    @classmethod
    def over_time(cls, rows: Sequence[Row]) -> SpeedProfile:
        """rows (time [s], speed [m/s]), rising: linear between them, constant before the first and behind the last."""
        times, speeds = zip(*rows, strict=True)
        corners = [(0.0, float(np.interp(0.0, times, speeds))), *(row for row in rows if row[0] > 0.0)]
        pieces, way = [], 0.0
        for (t, v), (later, w) in pairwise(corners):
            pieces.append((t, way, v, (w - v) / (later - t)))
            way += 0.5 * (v + w) * (later - t)
        t, v = corners[-1]
        return cls((*pieces, (t, way, v, 0.0)))

    @classmethod
    def over_distance(cls, rows: Sequence[Row], start: float) -> SpeedProfile:
        """rows (distance [m], speed above 0 [m/s]), rising: constant acceleration between them, so that the square of
        the speed is linear; constant before the first and behind the last. start: of the run [m]."""
        places, speeds = zip(*rows, strict=True)
        first = sqrt(float(np.interp(start, places, np.square(speeds))))
        corners = [(start, first), *(row for row in rows if row[0] > start)]
        pieces, t = [], 0.0
        for (s, v), (further, w) in pairwise(corners):
            pieces.append((t, s - start, v, 0.5 * (w * w - v * v) / (further - s)))
            t += 2.0 * (further - s) / (v + w)
        s, v = corners[-1]
        return cls((*pieces, (t, s - start, v, 0.0)))

    @classmethod
    def under(
        cls, acceleration: Callable[[float, float], float], speed: float, start: float, end: float, lowest: float
    ) -> SpeedProfile:
        """Pieces of ``PIECE`` seconds under an acceleration of (time [s], distance [m]) in their middles [m/s2].

        They end where the speed would fall below the lowest [m/s], and behind the end [m]."""
        pieces, t, way, v = [], 0.0, 0.0, speed
        while start + way < end and t < LONGEST:
            a = acceleration(t + 0.5 * PIECE, start + way + 0.5 * PIECE * v)
            for _ in range(2):  # the middle moves with the acceleration
                a = acceleration(t + 0.5 * PIECE, start + way + 0.5 * PIECE * (v + 0.25 * PIECE * a))
            if v + PIECE * a < lowest:
                way_left = 0.5 * (lowest * lowest - v * v) / a
                pieces.append((t, way, v, a))
                t, way, v = t + (lowest - v) / a, way + way_left, lowest
                return cls((*pieces, (t, way, v, 0.0)), way)
            pieces.append((t, way, v, a))
            t, way, v = t + PIECE, way + PIECE * (v + 0.5 * PIECE * a), v + PIECE * a
        return cls((*pieces, (t, way, v, 0.0)))

    @property
    def varies(self) -> bool:
        return any(piece[3] != 0.0 for piece in self.pieces)

    def until(self, time: float) -> tuple[float, float]:
        """The lowest and the highest speed from the start to a time [m/s]."""
        seen = [v for t, _, v, _ in self.pieces if t <= time] + [float(self.speed(time))]
        return min(seen), max(seen)

    def way(self, time: float | Array) -> Array:
        """Way from the start [m] at times [s]."""
        t, way, v, a = self._at(time)
        return np.asarray(way + t * (v + 0.5 * a * t))

    def speed(self, time: float | Array) -> Array:
        """Speed [m/s] at times [s]."""
        t, _, v, a = self._at(time)
        return np.asarray(v + a * t)

    def time(self, way: float) -> float:
        """The time at which so much way is made [s]; infinite where it never is."""
        t, begin, v, a = self.pieces[max(sum(piece[1] <= way for piece in self.pieces) - 1, 0)]
        root = v * v + 2.0 * a * (way - begin)
        if root < 0.0 or v + sqrt(root) == 0.0:
            return 0.0 if way == begin == 0.0 else inf
        return t + 2.0 * (way - begin) / (v + sqrt(root))

    def _at(self, time: float | Array) -> tuple[Array, Array, Array, Array]:
        """Time since the beginning of the piece, and the piece's other numbers."""
        begin, way, speed, acceleration = np.transpose(self.pieces)
        piece = np.maximum(np.searchsorted(begin, time, side="right") - 1, 0)
        return np.asarray(time - begin[piece]), way[piece], speed[piece], acceleration[piece]
