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
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from wrsim.geometry.piecewise import Array, Piecewise, integrals, subdivided

GAUSS_POINTS = 16
MAX_TURN = 0.5
"""Largest change of heading within one piece of the quadrature [rad]."""


@dataclass(frozen=True, eq=False)
class CentreLine:
    """Curve of given curvature [1/m] and angle of slope [rad] over its own length, from a start point [m] and heading
    [rad]."""

    curvature_law: Piecewise
    pitch_law: Piecewise
    start: tuple[float, float, float]
    start_heading: float

    @cached_property
    def _anchors(self) -> Array:
        """Distances between which the quadrature is exact [m], (k,)."""
        edges = np.union1d(self.curvature_law.breaks, self.pitch_law.breaks)
        inside = (np.abs(self.curvature_law(edges[:-1] + x * np.diff(edges))) for x in (0.0, 0.5, 1.0))
        return subdivided(edges, np.ceil(np.diff(edges) * np.maximum.reduce([*inside]) / MAX_TURN))

    @cached_property
    def _anchor_points(self) -> Array:
        """Exact positions there, (k, 3)."""
        steps = self._advance(self._anchors[:-1], self._anchors[1:])
        return np.asarray(self.start) + np.concatenate((np.zeros((1, 3)), np.cumsum(steps, axis=0)))

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
        i = np.searchsorted(self._anchors, inside, side="right") - 1
        points = self._anchor_points[i] + self._advance(self._anchors[i], inside)
        points += (s.ravel() - inside)[:, None] * self.tangent(inside)
        return points.reshape((*s.shape, 3))

    def tangent(self, s: ArrayLike) -> Array:
        """Unit tangent (..., 3)."""
        heading, pitch = self.heading(s), self.pitch_law(s)
        level = np.cos(pitch)
        return np.stack((level * np.cos(heading), level * np.sin(heading), np.sin(pitch)), axis=-1)

    def _advance(self, a: Array, b: Array) -> Array:
        """Integral of the tangent from a to b (m,), each within one piece: (m, 3)."""
        return integrals(self.tangent, a, b, GAUSS_POINTS)
