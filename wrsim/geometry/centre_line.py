"""The centre line of a track: curvature integrated to heading and position, to machine precision.

Curvature is a polynomial of at most third degree in each segment, so the heading is a polynomial of fourth
degree, known exactly. Position is the integral of (cos, sin) of the heading, by Gauss-Legendre quadrature
with 16 points on pieces that turn by at most half a radian: the truncation error is far below rounding.
The heading is not wrapped: after a full circle it has grown by 2 pi.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wrsim.geometry.piecewise import PiecewiseCubic

Array = NDArray[np.float64]

GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(16)
MAX_TURN = 0.5
"""Largest change of heading within one piece of the quadrature [rad]."""


@dataclass(frozen=True, eq=False)
class CentreLine:
    """Plane curve of given curvature at constant height z.

    anchors: distances [m] (k,); anchor_points: (k, 2) exact positions there.
    """

    curvature_law: PiecewiseCubic
    start: tuple[float, float, float]
    start_heading: float
    anchors: Array
    anchor_points: Array

    @classmethod
    def build(cls, curvature: PiecewiseCubic, start: tuple[float, float, float], heading: float) -> CentreLine:
        """Integrate a curvature law [1/m] from a start point [m] and heading [rad]."""
        anchors = [np.zeros(1)]
        for begin, length, row in zip(curvature.starts, curvature.lengths, curvature.coefficients, strict=True):
            turn = length * max(abs(row[0]), abs(row.sum()))  # the ramps are monotone
            pieces = max(1, int(np.ceil(turn / MAX_TURN)))
            anchors.append(begin + length * np.arange(1, pieces + 1) / pieces)
        nodes = np.concatenate(anchors)
        bare = cls(curvature, start, float(heading), nodes, np.zeros((len(nodes), 2)))
        steps = bare._advance(nodes[:-1], nodes[1:])
        points = np.asarray(start[:2]) + np.concatenate((np.zeros((1, 2)), np.cumsum(steps, axis=0)))
        return cls(curvature, start, float(heading), nodes, points)

    @property
    def length(self) -> float:
        """Length [m]."""
        return self.curvature_law.end

    def curvature(self, s: ArrayLike, derivative: int = 0) -> Array:
        """Curvature [1/m], positive to the left, or its derivatives; zero outside of the track."""
        s = np.asarray(s, dtype=np.float64)
        inside = (s >= 0.0) & (s <= self.length)
        return np.where(inside, self.curvature_law(s, derivative), 0.0)

    def heading(self, s: ArrayLike) -> Array:
        """Heading [rad] against the global x-axis, positive to the left, not wrapped."""
        return self.start_heading + self.curvature_law.integral(s)

    def position(self, s: ArrayLike) -> Array:
        """Position (..., 3) [m]; straight continuation outside of the track."""
        s = np.asarray(s, dtype=np.float64)
        inside = np.clip(s, 0.0, self.length).ravel()
        i = np.clip(np.searchsorted(self.anchors, inside, side="right") - 1, 0, len(self.anchors) - 1)
        xy = self.anchor_points[i] + self._advance(self.anchors[i], inside)
        heading = self.heading(inside)
        beyond = s.ravel() - inside
        out = np.empty((s.size, 3))
        out[:, 0] = xy[:, 0] + beyond * np.cos(heading)
        out[:, 1] = xy[:, 1] + beyond * np.sin(heading)
        out[:, 2] = self.start[2]
        return out.reshape((*s.shape, 3))

    def _advance(self, a: Array, b: Array) -> Array:
        """Integral of (cos, sin) of the heading from a to b (m,), each within one piece: (m, 2)."""
        middle, half = 0.5 * (a + b), 0.5 * (b - a)
        total = np.zeros((len(a), 2))
        for point, weight in zip(GAUSS_POINTS, GAUSS_WEIGHTS, strict=True):
            heading = self.heading(middle + half * point)
            total[:, 0] += weight * np.cos(heading)
            total[:, 1] += weight * np.sin(heading)
        return total * half[:, None]
