"""The centre line of a track, and one rail as a curve swept beside it, with its own arclength [S 7-9].

The equations are those of docs/theory/track.md. A rail p = r + d n + h b has offsets d(s) and h(s), which hold gauge,
profile origin and irregularities, and p' = A t + B n + C b, so that

    p'' = (A' - B kn - C kb) t + (A kn + B' - C tau) n + (A kb + B tau + C') b.

Its arclength is the integral of |p'|. The heading psi is not wrapped.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from wrsim.contact.profiles.curves import gauss_integrals, subdivided
from wrsim.track.cant import cant_angle
from wrsim.track.irregularities import SMOOTH, RailIrregularity
from wrsim.track.path import COLUMNS, Path
from wrsim.track.piecewise import Array, Jet, Piecewise

HEADING_POINTS, GAUSS_POINTS = 16, 6  # of the quadratures of position (exact to rounding) and of arclength
MAX_TURN = 0.5  # largest change of heading within one piece of the quadrature [rad]
MAX_PIECE = 0.5  # longest piece of the quadrature of arclength [m]


@dataclass(frozen=True, eq=False)
class CentreLine:
    """Curve of given curvature [1/m] and angle of slope [rad] (positive uphill) over its own length, from a start point
    [m] and heading [rad]."""

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
        return self.curvature_law.end

    def curvature(self, s: ArrayLike, derivative: int = 0) -> Array:
        """Turn of the heading per metre [1/m], positive to the left, or its derivatives; zero outside of the track."""
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
        return gauss_integrals(self.tangent, a, b, HEADING_POINTS)


@dataclass(frozen=True, eq=False)
class SweptCurve:
    """A curve at the side of the centre line: rolled by the cant, d = side (gauge/2 + widening/2 + outward) + lateral
    irregularity, h = height + vertical irregularity.

    side: +1 left rail, -1 right rail, 0 the centre line itself with the roll of the track, which has no
    irregularities. cant: signed cant [m], positive with the right rail higher: phi = -cant_angle(cant, cant_base).
    """

    centre: CentreLine
    cant: Piecewise
    widening: Piecewise
    gauge: float
    cant_base: float
    side: int
    outward: float = 0.0
    height: float = 0.0
    irregularity: RailIrregularity = SMOOTH

    @cached_property
    def _anchors(self) -> Array:
        """Distances at which the arclength is tabulated [m]: the breaks of the laws and between."""
        laws = (self.centre.curvature_law, self.centre.pitch_law, self.cant, self.widening)
        edges = np.unique(np.concatenate([*(a.breaks for a in laws), self.irregularity.breaks(self.centre.length)]))
        return subdivided(edges, np.ceil(np.diff(edges) / min(MAX_PIECE, self.irregularity.resolution)))

    @cached_property
    def _anchor_lengths(self) -> Array:
        return np.concatenate(([0.0], np.cumsum(self._advance(self._anchors[:-1], self._anchors[1:]))))

    @property
    def length(self) -> float:
        return float(self._anchor_lengths[-1])

    def roll(self, s: ArrayLike) -> Jet:
        """Roll angle phi and its first two derivatives at centre-line distance s [rad, rad/m, rad/m2]."""
        c, dc, ddc = self.cant.jet(s)
        root = np.sqrt(self.cant_base**2 - c**2)
        return -cant_angle(c, self.cant_base), -dc / root, -(ddc / root + c * dc**2 / root**3)

    def offsets(self, s: ArrayLike, order: int = 2) -> tuple[Jet, Jet]:
        """(d, d', d'') along n and (h, h', h'') along b at s [m, 1, 1/m]; of the irregularity up to the order."""
        w, dw, ddw = self.widening.jet(s)
        y, dy, ddy = self.irregularity.lateral(s, order)
        z, dz, ddz = self.irregularity.vertical(s, order)
        half = 0.5 * self.side
        d = half * (self.gauge + w) + self.side * self.outward + y
        return (d, half * dw + dy, half * ddw + ddy), (self.height + z, dz, ddz)

    def components(self, s: ArrayLike, order: int = 2) -> Array:
        """(A, B, C) of p', and of p'' up to the order 2, in (t, n, b) at s: (order, ..., 3)."""
        kappa = self.centre.curvature(s)
        theta, dtheta, ddtheta = self.centre.pitch_law.jet(s)
        phi, dphi, ddphi = self.roll(s)
        (d, dd, ddd), (h, dh, ddh) = self.offsets(s, order)
        level, steep = np.cos(theta), np.sin(theta)
        c, sn = np.cos(phi), np.sin(phi)
        turn, tau = kappa * level, dphi + kappa * steep
        kn, kb = turn * c + dtheta * sn, dtheta * c - turn * sn
        a, b, e = 1.0 - d * kn - h * kb, dd - h * tau, dh + d * tau
        first = np.stack((a, b, e), axis=-1)
        if order == 1:
            return first[None]
        dkappa = self.centre.curvature(s, 1)
        dturn = dkappa * level - kappa * dtheta * steep
        dkn = dturn * c + ddtheta * sn + dphi * kb
        dkb = ddtheta * c - dturn * sn - dphi * kn
        dtau = ddphi + dkappa * steep + kappa * dtheta * level
        da = -(dd * kn + d * dkn + dh * kb + h * dkb)
        db, de = ddd - dh * tau - h * dtau, ddh + dd * tau + d * dtau
        second = np.stack((da - b * kn - e * kb, a * kn + db - e * tau, a * kb + b * tau + de), axis=-1)
        return np.stack((first, second))

    def arclength(self, s: ArrayLike) -> Array:
        """Own arclength at centre-line distance s [m]; outside of the track at unit rate."""
        s = np.asarray(s, dtype=np.float64)
        if self.side == 0:
            return s
        inside = np.clip(s, 0.0, self.centre.length).ravel()
        i = np.searchsorted(self._anchors, inside, side="right") - 1
        out = self._anchor_lengths[i] + self._advance(self._anchors[i], inside)
        return (out + s.ravel() - inside).reshape(s.shape)

    def distance(self, arclength: ArrayLike) -> Array:
        """Centre-line distance at own arclength [m]: the inverse of `arclength` by Newton's method."""
        arclength = np.asarray(arclength, dtype=np.float64)
        if self.side == 0:
            return arclength
        inside = np.clip(arclength, 0.0, self.length)
        s = np.interp(inside, self._anchor_lengths, self._anchors)
        for _ in range(12):
            step = (inside - self.arclength(s)) / self._rate(s)
            s = np.clip(s + step, 0.0, self.centre.length)
            if np.max(np.abs(step), initial=0.0) < 1e-7:  # quadratic: the next one would be rounding
                break
        return s + arclength - inside

    def path(self, step: float, reach: float = np.inf) -> Path:
        """Table at uniform own arclength with rows at most ``step`` [m] apart, up to a distance of the centre line [m],
        on which its rows do not depend."""
        n = max(2, int(np.ceil(self.length / step - 1e-9)) + 1)
        actual = self.length / (n - 1)
        whole = reach >= self.centre.length
        rows = np.linspace(0.0, self.length, n)[: None if whole else int(self.arclength(reach) / actual) + 2]
        s, n = self.distance(rows), rows.size
        s[-1] = self.centre.length if whole else s[-1]

        heading = self.centre.heading(s)
        phi, dphi, _ = self.roll(s)
        t = self.centre.tangent(s)
        left = np.column_stack((-np.sin(heading), np.cos(heading), np.zeros(n)))
        up, c, sn = np.cross(t, left), np.cos(phi)[:, None], np.sin(phi)[:, None]
        normal, binormal = c * left + sn * up, -sn * left + c * up
        axes = np.stack((t, normal, binormal), axis=1)  # (n, axis, xyz)

        first, second = self.components(s)
        rate = np.linalg.norm(first, axis=1)
        tangent = first / rate[:, None]
        bend = (second - np.sum(second * tangent, axis=1)[:, None] * tangent) / (rate**2)[:, None]

        table = np.empty((n, len(COLUMNS)))
        (d, _, _), (h, _, _) = self.offsets(s)
        table[:, 0:3] = self.centre.position(s) + d[:, None] * normal + h[:, None] * binormal
        table[:, 3:6] = np.einsum("ni,nij->nj", tangent, axes)
        table[:, 6] = phi
        table[:, 7] = dphi / rate
        table[:, 8:11] = np.einsum("ni,nij->nj", bend, axes)
        return Path(table, actual)

    def _rate(self, s: ArrayLike) -> Array:
        """d(own arclength)/ds = |p'|."""
        return np.asarray(np.linalg.norm(self.components(s, 1)[0], axis=-1))

    def _advance(self, a: Array, b: Array) -> Array:
        """Arclength from a to b, both (m,); every pair within one piece."""
        if not self.side:
            return b - a
        return gauss_integrals(self._rate, a, b, GAUSS_POINTS)
