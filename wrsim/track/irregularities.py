"""Irregularities of a track: how far each rail lies beside its designed place, over the distance along the centre line.

Four channels as of track recording cars, ``WEIGHTS``: both rails to the left (alignment), both up (level), right rail
above left (cross-level), rails apart (gauge). A disturbance is one shape over the distance, times a weight on each
rail's lateral (n) and vertical (b) offset. A shape has ``jet`` (value and derivatives up to an order, so that the
rail's tangent and curvature follow exactly), ``breaks`` (distances at which its slope or curvature may jump) and
``resolution`` (largest distance of a path's rows that follows it) [m].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy
from numpy.typing import ArrayLike

from wrsim.track.piecewise import Array, Jet, Piecewise

Channel = Literal["alignment", "level", "cross-level", "gauge"]
Rail = Literal["both", "left", "right"]

CHANNELS: tuple[Channel, ...] = ("alignment", "level", "cross-level", "gauge")
WEIGHTS: dict[str, tuple[float, float, float, float]] = {
    "alignment": (1.0, 0.0, 1.0, 0.0),
    "level": (0.0, 1.0, 0.0, 1.0),
    "cross-level": (0.0, -0.5, 0.0, 0.5),
    "gauge": (0.5, 0.0, -0.5, 0.0),
}
"""Lateral and vertical weight on the left, then on the right rail."""
ROWS_A_WAVE = 4.0
"""Rows of a path within the shortest wave: the quintic between them then follows it within half a percent."""


@dataclass(frozen=True)
class Disturbance:
    """A shape and its weights: lateral and vertical on the left rail, then on the right one."""

    shape: Shape
    weights: tuple[float, float, float, float]

    @classmethod
    def of(cls, shape: Shape, channel: Channel, rail: Rail = "both") -> Disturbance:
        """The shape in a channel, of both rails or one."""
        a, b, c, d = WEIGHTS[channel]
        return cls(shape, {"both": (a, b, c, d), "left": (a, b, 0.0, 0.0), "right": (0.0, 0.0, c, d)}[rail])


@dataclass(frozen=True)
class RailIrregularity:
    """Irregularity of one rail: pairs of weight and shape; where it begins and over what length it fades in [m]."""

    lateral_parts: tuple[tuple[float, Shape], ...] = ()
    vertical_parts: tuple[tuple[float, Shape], ...] = ()
    fade: tuple[float, float] | None = None

    def lateral(self, s: ArrayLike, order: int = 2) -> Jet:
        """Offset to the left [m] at s and its first two derivatives; those beyond the order may be left at 0."""
        return self._faded(_sum(self.lateral_parts, s, order), s)

    def vertical(self, s: ArrayLike, order: int = 2) -> Jet:
        """Offset upward [m] at s and its first two derivatives; those beyond the order may be left at 0."""
        return self._faded(_sum(self.vertical_parts, s, order), s)

    def _faded(self, jet: Jet, s: ArrayLike) -> Jet:
        if self.fade is None:
            return jet
        (value, slope, bend), length = jet, self.fade[1]
        x = np.clip((np.asarray(s) - self.fade[0]) / length, 0.0, 1.0)
        w, dw = smooth_step(x), 30.0 * (x * (1.0 - x)) ** 2 / length
        ddw = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / length**2
        return w * value, w * slope + dw * value, w * bend + 2.0 * dw * slope + ddw * value

    @classmethod
    def of(cls, disturbances: Sequence[Disturbance], side: int) -> RailIrregularity:
        """That of the left (+1) or right (-1) rail."""
        first = 0 if side > 0 else 2
        columns = (first, first + 1)
        lateral, vertical = (tuple((d.weights[k], d.shape) for d in disturbances if d.weights[k]) for k in columns)
        return cls(lateral, vertical)

    @property
    def shapes(self) -> list[Shape]:
        """All its shapes."""
        return [shape for _, shape in (*self.lateral_parts, *self.vertical_parts)]

    @property
    def resolution(self) -> float:
        """Largest distance of a path's rows that follows it [m]."""
        return min((shape.resolution for shape in self.shapes), default=np.inf)

    def breaks(self, length: float) -> Array:
        """Distances between 0 and length at which slope or curvature may jump [m]."""
        return np.unique(np.clip(np.concatenate([np.zeros(1), *(s.breaks() for s in self.shapes)]), 0.0, length))


SMOOTH = RailIrregularity()  # A rail exactly in its place


def _sum(parts: Sequence[tuple[float, Shape]], s: ArrayLike, order: int) -> Jet:
    s = np.asarray(s, dtype=np.float64)
    jet = np.zeros((3, *s.shape))
    for weight, shape in parts:
        for i, values in enumerate(shape.jet(s, order)):
            jet[i] += weight * values
    return jet[0], jet[1], jet[2]


@dataclass(frozen=True, eq=False)
class Sampled:
    """A cubic spline through samples, zero beyond them."""

    spline: scipy.interpolate.CubicSpline
    resolution: float

    @classmethod
    def through(cls, distance: Array, values: Array, fade: float, shortest: float) -> Sampled:
        """Spline through values (n,) [m] at rising distances [m], faded in and out over ``fade`` [m] at both ends.

        shortest: wavelength that has to be followed [m].
        """
        window = smooth_step((distance - distance[0]) / fade) * smooth_step((distance[-1] - distance) / fade)
        # value, slope and curvature vanish at the ends, where the zero beyond begins
        spline = scipy.interpolate.CubicSpline(distance, values * window, bc_type="clamped")
        return cls(spline, shortest / ROWS_A_WAVE)

    def jet(self, s: Array, order: int = 2) -> tuple[Array, ...]:
        inside = (s >= self.spline.x[0]) & (s <= self.spline.x[-1])
        return tuple(np.where(inside, self.spline(s, nu), 0.0) for nu in range(order + 1))

    def breaks(self) -> Array:
        return np.array([self.spline.x[0], self.spline.x[-1]])


@dataclass(frozen=True)
class Bump:
    """1-cosine: amplitude/2 (1 - cos(2 pi (s - start) / length)) from start to start + length."""

    start: float
    length: float
    amplitude: float

    @property
    def resolution(self) -> float:
        """Fine, for its curvature begins with a jump [m]."""
        return self.length / 16.0

    def jet(self, s: Array, order: int = 2) -> tuple[Array, ...]:
        k, half = 2.0 * np.pi / self.length, 0.5 * self.amplitude
        x = s - self.start
        inside = (x >= 0.0) & (x <= self.length)  # a small part of a track, which may have a thousand bumps
        x = x[inside]
        jet = np.zeros((3, *s.shape))
        jet[:, inside] = half * (1.0 - np.cos(k * x)), half * k * np.sin(k * x), half * k * k * np.cos(k * x)
        return tuple(jet)

    def breaks(self) -> Array:
        return np.array([self.start, self.start + self.length])


@dataclass(frozen=True, eq=False)
class Polygon:
    """Straight lines with rounded corners."""

    law: Piecewise
    resolution: float

    @classmethod
    def through(cls, distance: Sequence[float], values: Sequence[float], rounding: float) -> Polygon:
        """Through points at rising distances from 0 on; the last value is held. Corners are rounded over +-rounding,
        or what the shortest line allows [m]."""
        s, y = np.asarray(distance, dtype=float), np.asarray(values, dtype=float)
        rounding = min(rounding, 0.5 * float(np.diff(s)[1:-1].min(initial=np.inf)))
        return cls(Piecewise.through(s, y).rounded(rounding), rounding / 4.0)

    def jet(self, s: Array, order: int = 2) -> tuple[Array, ...]:
        return self.law.jet(s)

    def breaks(self) -> Array:
        return self.law.breaks


Shape = Sampled | Bump | Polygon


def smooth_step(x: Array) -> Array:
    """0 below 0, 1 above 1, between them x^3 (10 - 15 x + 6 x^2): slope and curvature vanish at both ends."""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x**3 * (10.0 + x * (-15.0 + 6.0 * x)))
