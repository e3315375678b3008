"""The centre line of a track: curvature and slope integrated to heading and position, to machine precision.

Over the distance s along the line its horizontal projection turns by kappa ds and it climbs at the angle theta(s):

    heading psi = psi0 + int kappa ds,    r = r0 + int (cos theta cos psi, cos theta sin psi, sin theta) ds.

Curvature is a polynomial of at most third degree in each segment, so the heading is a polynomial of fourth degree,
known exactly. Position is integrated by Gauss-Legendre quadrature with 16 points on pieces that turn by at most half
a radian and lie within one segment: the truncation error is far below rounding. The heading is not wrapped: after a
full circle it has grown by 2 pi.
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
    """Curve of given curvature and angle of slope over its own length.

    anchors: distances [m] (k,); anchor_points: (k, 3) exact positions there.
    """

    curvature_law: PiecewiseCubic
    pitch_law: PiecewiseCubic
    start: tuple[float, float, float]
    start_heading: float
    anchors: Array
    anchor_points: Array

    @classmethod
    def build(
        cls,
        curvature: PiecewiseCubic,
        pitch: PiecewiseCubic,
        start: tuple[float, float, float],
        heading: float,
    ) -> CentreLine:
        """Integrate laws of curvature [1/m] and slope [rad] from a start point [m] and heading [rad]."""
        edges = np.union1d(curvature.breaks(), pitch.breaks())
        largest = np.maximum.reduce([np.abs(curvature(edges[:-1] + x * np.diff(edges))) for x in (0.0, 0.5, 1.0)])
        nodes = subdivided(edges, np.ceil(np.diff(edges) * largest / MAX_TURN))
        bare = cls(curvature, pitch, start, float(heading), nodes, np.zeros((len(nodes), 3)))
        steps = bare._advance(nodes[:-1], nodes[1:])
        points = np.asarray(start) + np.concatenate((np.zeros((1, 3)), np.cumsum(steps, axis=0)))
        return cls(curvature, pitch, start, float(heading), nodes, points)

    @property
    def length(self) -> float:
        """Length [m]."""
        return self.curvature_law.end

    def curvature(self, s: ArrayLike, derivative: int = 0) -> Array:
        """Turn of the heading per metre [1/m], positive to the left, or its derivatives; zero outside of the track."""
        s = np.asarray(s, dtype=np.float64)
        inside = (s >= 0.0) & (s <= self.length)
        return np.where(inside, self.curvature_law(s, derivative), 0.0)

    def pitch(self, s: ArrayLike) -> tuple[Array, Array, Array]:
        """Angle of slope [rad], positive uphill, and its first two derivatives; held outside of the track."""
        return self.pitch_law.jet(s)

    def heading(self, s: ArrayLike) -> Array:
        """Heading [rad] against the global x-axis, positive to the left, not wrapped."""
        return self.start_heading + self.curvature_law.integral(s)

    def position(self, s: ArrayLike) -> Array:
        """Position (..., 3) [m]; straight continuation outside of the track."""
        s = np.asarray(s, dtype=np.float64)
        inside = np.clip(s, 0.0, self.length).ravel()
        i = np.clip(np.searchsorted(self.anchors, inside, side="right") - 1, 0, len(self.anchors) - 1)
        points = self.anchor_points[i] + self._advance(self.anchors[i], inside)
        points += (s.ravel() - inside)[:, None] * self.tangent(inside)
        return points.reshape((*s.shape, 3))

    def tangent(self, s: ArrayLike) -> Array:
        """Unit tangent (..., 3)."""
        heading, pitch = self.heading(s), self.pitch_law(s)
        level = np.cos(pitch)
        return np.stack((level * np.cos(heading), level * np.sin(heading), np.sin(pitch)), axis=-1)

    def _advance(self, a: Array, b: Array) -> Array:
        """Integral of the tangent from a to b (m,), each within one piece: (m, 3)."""
        middle, half = 0.5 * (a + b), 0.5 * (b - a)
        level = self.pitch_law.is_zero
        total = np.zeros((len(a), 3))
        for point, weight in zip(GAUSS_POINTS, GAUSS_WEIGHTS, strict=True):
            s = middle + half * point
            heading = self.heading(s)
            if level:
                total[:, 0] += weight * np.cos(heading)
                total[:, 1] += weight * np.sin(heading)
            else:
                pitch = self.pitch_law(s)
                along = weight * np.cos(pitch)
                total[:, 0] += along * np.cos(heading)
                total[:, 1] += along * np.sin(heading)
                total[:, 2] += weight * np.sin(pitch)
        return total * half[:, None]


def subdivided(edges: Array, pieces: Array) -> Array:
    """The edges (n + 1,) and equally spaced points that part interval i into pieces[i] (at least one)."""
    count = np.maximum(1, np.asarray(pieces)).astype(int)
    first = np.repeat(np.cumsum(count) - count, count)
    share = (np.arange(count.sum()) - first) / np.repeat(count, count)
    begin, length = np.repeat(edges[:-1], count), np.repeat(np.diff(edges), count)
    return np.append(begin + share * length, edges[-1])
