"""One rail as a curve swept beside the centre line, with its own arclength [S 7-9].

With the centre line r(s), its frame (t, n, b) rolled by phi, and the offsets d(s) along n and h along b
(constant),

    p   = r + d n + h b
    p'  = A t + B n + C b,    A = 1 - kappa (d cos phi - h sin phi),  B = d' - h phi',  C = d phi'
    p'' = (A' - kappa cos phi B + kappa sin phi C) t + (A kappa cos phi + B' - phi' C) n
          + (C' - A kappa sin phi + phi' B) b

from t' = kappa (cos phi n - sin phi b), n' = -kappa cos phi t + phi' b, b' = kappa sin phi t - phi' n.
So cant ramps and gauge widening turn the rail's own tangent. The rail's arclength is the integral of |p'|.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wrsim.geometry.centre_line import GAUSS_POINTS, GAUSS_WEIGHTS, CentreLine
from wrsim.geometry.path import COLUMNS, Path
from wrsim.geometry.piecewise import PiecewiseCubic

Array = NDArray[np.float64]

MAX_PIECE = 5.0
"""Longest piece [m] of the quadrature of arclength (16 Gauss points each)."""


@dataclass(frozen=True, eq=False)
class SweptCurve:
    """A curve at the side of the centre line: rolled by the cant, d = side (gauge/2 + widening/2 + outward),
    h = height.

    side: +1 left rail, -1 right rail, 0 the centre line itself with the roll of the track.
    cant: signed cant [m], positive with the right rail higher: phi = -asin(cant / cant_base).
    """

    centre: CentreLine
    cant: PiecewiseCubic
    widening: PiecewiseCubic
    gauge: float
    cant_base: float
    side: int
    outward: float
    height: float
    anchors: Array
    anchor_lengths: Array

    @classmethod
    def build(
        cls,
        centre: CentreLine,
        cant: PiecewiseCubic,
        widening: PiecewiseCubic,
        gauge: float,
        cant_base: float,
        side: int,
        offset: tuple[float, float],
    ) -> SweptCurve:
        """Set the curve up and tabulate its arclength at the breaks of the laws."""
        breaks = np.union1d(cant.breaks(), widening.breaks())
        pieces = np.maximum(1, np.ceil(np.diff(breaks) / MAX_PIECE)).astype(int)
        anchors = np.concatenate(
            [[0.0]]
            + [a + (b - a) * np.arange(1, n + 1) / n for a, b, n in zip(breaks, breaks[1:], pieces, strict=False)]
        )
        laws = (
            centre,
            cant,
            widening,
            float(gauge),
            float(cant_base),
            side,
            float(offset[0]),
            float(offset[1]),
        )
        bare = cls(*laws, anchors, np.zeros(len(anchors)))
        lengths = np.concatenate(([0.0], np.cumsum(bare._advance(anchors[:-1], anchors[1:]))))
        return cls(*laws, anchors, lengths)

    @property
    def length(self) -> float:
        """Own arclength over the whole track [m]."""
        return float(self.anchor_lengths[-1])

    def roll(self, s: ArrayLike) -> tuple[Array, Array, Array]:
        """Roll angle phi and its first two derivatives at centre-line distance s [rad, rad/m, rad/m2]."""
        c, dc, ddc = (self.cant(s, derivative) for derivative in range(3))
        root = np.sqrt(self.cant_base**2 - c**2)
        return -np.arcsin(c / self.cant_base), -dc / root, -(ddc / root + c * dc**2 / root**3)

    def components(self, s: ArrayLike) -> tuple[Array, Array]:
        """(A, B, C) of p' and the components of p'' in (t, n, b) at s: two arrays (..., 3)."""
        kappa, dkappa = self.centre.curvature(s), self.centre.curvature(s, 1)
        phi, dphi, ddphi = self.roll(s)
        half = 0.5 * self.side
        h = self.height if self.side else 0.0
        d = self._lateral(s)
        dd, ddd = half * self.widening(s, 1), half * self.widening(s, 2)
        c, sn = np.cos(phi), np.sin(phi)
        a = 1.0 - kappa * (d * c - h * sn)
        da = -dkappa * (d * c - h * sn) - kappa * (dd * c - (d * sn + h * c) * dphi)
        b = dd - h * dphi
        db = ddd - h * ddphi
        e = d * dphi
        de = dd * dphi + d * ddphi
        first = np.stack((a, b, e), axis=-1)
        second = np.stack(
            (
                da - kappa * c * b + kappa * sn * e,
                a * kappa * c + db - dphi * e,
                de - a * kappa * sn + dphi * b,
            ),
            axis=-1,
        )
        return first, second

    def arclength(self, s: ArrayLike) -> Array:
        """Own arclength at centre-line distance s [m]; outside of the track at unit rate."""
        s = np.asarray(s, dtype=np.float64)
        inside = np.clip(s, 0.0, self.centre.length).ravel()
        i = np.clip(np.searchsorted(self.anchors, inside, side="right") - 1, 0, len(self.anchors) - 1)
        out = self.anchor_lengths[i] + self._advance(self.anchors[i], inside)
        return (out + s.ravel() - inside).reshape(s.shape)

    def distance(self, arclength: ArrayLike) -> Array:
        """Centre-line distance at own arclength [m]: the inverse of `arclength` by Newton's method."""
        arclength = np.asarray(arclength, dtype=np.float64)
        if self.side == 0:
            return arclength
        inside = np.clip(arclength, 0.0, self.length)
        s = np.interp(inside, self.anchor_lengths, self.anchors)
        for _ in range(12):
            step = (inside - self.arclength(s)) / self._rate(s)
            s = np.clip(s + step, 0.0, self.centre.length)
            if np.max(np.abs(step), initial=0.0) < 1e-10:  # quadratic: the next one would be rounding
                break
        return s + arclength - inside

    def path(self, step: float) -> Path:
        """Table at uniform own arclength, with rows at most ``step`` [m] apart."""
        n = max(2, int(np.ceil(self.length / step - 1e-9)) + 1)
        actual = self.length / (n - 1)
        s = self.distance(np.linspace(0.0, self.length, n))
        s[-1] = self.centre.length

        heading = self.centre.heading(s)
        phi, dphi, _ = self.roll(s)
        zero = np.zeros(n)
        t = np.column_stack((np.cos(heading), np.sin(heading), zero))
        left = np.column_stack((-np.sin(heading), np.cos(heading), zero))
        up = np.array([0.0, 0.0, 1.0])
        normal = np.cos(phi)[:, None] * left + np.sin(phi)[:, None] * up
        binormal = -np.sin(phi)[:, None] * left + np.cos(phi)[:, None] * up
        axes = np.stack((t, normal, binormal), axis=1)  # (n, axis, xyz)

        first, second = self.components(s)
        rate = np.linalg.norm(first, axis=1)
        tangent = first / rate[:, None]
        bend = (second - np.sum(second * tangent, axis=1)[:, None] * tangent) / (rate**2)[:, None]

        table = np.empty((n, len(COLUMNS)))
        h = self.height if self.side else 0.0
        table[:, 0:3] = self.centre.position(s) + self._lateral(s)[:, None] * normal + h * binormal
        table[:, 3:6] = np.einsum("ni,nij->nj", tangent, axes)
        table[:, 6] = phi
        table[:, 7] = dphi / rate
        table[:, 8:11] = np.einsum("ni,nij->nj", bend, axes)
        return Path(np.ascontiguousarray(table), actual)

    def _lateral(self, s: ArrayLike) -> Array:
        """Offset d along n [m]."""
        return np.asarray(self.side * (0.5 * (self.gauge + self.widening(s)) + self.outward))

    def _rate(self, s: ArrayLike) -> Array:
        """d(own arclength)/ds = |p'|."""
        return np.asarray(np.linalg.norm(self.components(s)[0], axis=-1))

    def _advance(self, a: Array, b: Array) -> Array:
        """Arclength from a to b, both (m,); every pair within one piece."""
        middle, half = 0.5 * (a + b), 0.5 * (b - a)
        total = np.zeros(len(a))
        for point, weight in zip(GAUSS_POINTS, GAUSS_WEIGHTS, strict=True):
            total += weight * self._rate(middle + half * point)
        return total * half
