"""One rail as a curve swept beside the centre line, with its own arclength [S 7-9].

The centre line r(s) turns by psi' = kappa and climbs at the angle theta. With its horizontal left h, v = t x h and the
cross-section rolled by phi,

    n = cos(phi) h + sin(phi) v,    b = -sin(phi) h + cos(phi) v,
    t' = kn n + kb b,    n' = -kn t + tau b,    b' = -kb t - tau n,
    kn = psi' cos(theta) cos(phi) + theta' sin(phi),    kb = -psi' cos(theta) sin(phi) + theta' cos(phi),
    tau = phi' + psi' sin(theta).

A rail at the offsets d(s) along n and h(s) along b, which hold gauge, profile origin and irregularities, is

    p   = r + d n + h b
    p'  = A t + B n + C b,    A = 1 - d kn - h kb,  B = d' - h tau,  C = h' + d tau
    p'' = (A' - B kn - C kb) t + (A kn + B' - C tau) n + (A kb + B tau + C') b.

So cant ramps, gauge widening and irregularities turn the rail's own tangent. The rail's arclength is the integral of
|p'|.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wrsim.geometry.piecewise import Jet, PiecewiseCubic
from wrsim.geometry.track.centre_line import CentreLine, subdivided
from wrsim.geometry.track.irregularities import SMOOTH, RailIrregularity
from wrsim.geometry.track.path import COLUMNS, Path

Array = NDArray[np.float64]

MAX_PIECE = 0.5
"""Longest piece [m] of the quadrature of arclength."""
GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(6)


@dataclass(frozen=True, eq=False)
class SweptCurve:
    """A curve at the side of the centre line: rolled by the cant, d = side (gauge/2 + widening/2 + outward) + lateral
    irregularity, h = height + vertical irregularity.

    side: +1 left rail, -1 right rail, 0 the centre line itself with the roll of the track, which has no
    irregularities. cant: signed cant [m], positive with the right rail higher: phi = -asin(cant / cant_base).
    """

    centre: CentreLine
    cant: PiecewiseCubic
    widening: PiecewiseCubic
    gauge: float
    cant_base: float
    side: int
    outward: float
    height: float
    irregularity: RailIrregularity
    anchors: Array
    anchor_lengths: Array
    anchor_rates: Array

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
        irregularity: RailIrregularity = SMOOTH,
    ) -> SweptCurve:
        """Set the curve up and tabulate its arclength at the breaks of the laws and between."""
        irregularity = irregularity if side else SMOOTH
        laws = (
            *(centre, cant, widening, float(gauge), float(cant_base), side),
            *(float(offset[0]), float(offset[1]), irregularity),
        )
        breaks = [centre.curvature_law.breaks(), centre.pitch_law.breaks(), cant.breaks(), widening.breaks()]
        edges = np.unique(np.concatenate([*breaks, irregularity.breaks(centre.length)]))
        anchors = subdivided(edges, np.ceil(np.diff(edges) / min(MAX_PIECE, irregularity.resolution)))
        none = np.zeros(len(anchors))
        bare = cls(*laws, anchors, none, none)
        lengths = np.concatenate(([0.0], np.cumsum(bare._advance(anchors[:-1], anchors[1:]))))
        return cls(*laws, anchors, lengths, bare._rate(anchors))

    @property
    def length(self) -> float:
        """Own arclength over the whole track [m]."""
        return float(self.anchor_lengths[-1])

    def roll(self, s: ArrayLike) -> Jet:
        """Roll angle phi and its first two derivatives at centre-line distance s [rad, rad/m, rad/m2]."""
        c, dc, ddc = self.cant.jet(s)
        root = np.sqrt(self.cant_base**2 - c**2)
        return -np.arcsin(c / self.cant_base), -dc / root, -(ddc / root + c * dc**2 / root**3)

    def offsets(self, s: ArrayLike) -> tuple[Jet, Jet]:
        """(d, d', d'') along n and (h, h', h'') along b at s [m, 1, 1/m]."""
        s = np.asarray(s, dtype=np.float64)
        if not self.side:
            zero = np.zeros(s.shape)
            return (zero, zero, zero), (zero, zero, zero)
        w, dw, ddw = self.widening.jet(s)
        y, dy, ddy = self.irregularity.lateral(s)
        z, dz, ddz = self.irregularity.vertical(s)
        half = 0.5 * self.side
        d = half * (self.gauge + w) + self.side * self.outward + y
        return (d, half * dw + dy, half * ddw + ddy), (self.height + z, dz, ddz)

    def components(self, s: ArrayLike) -> tuple[Array, Array]:
        """(A, B, C) of p' and the components of p'' in (t, n, b) at s: two arrays (..., 3)."""
        kappa, dkappa = self.centre.curvature(s), self.centre.curvature(s, 1)
        theta, dtheta, ddtheta = self.centre.pitch(s)
        phi, dphi, ddphi = self.roll(s)
        (d, dd, ddd), (h, dh, ddh) = self.offsets(s)
        level, steep = np.cos(theta), np.sin(theta)
        c, sn = np.cos(phi), np.sin(phi)
        turn, dturn = kappa * level, dkappa * level - kappa * dtheta * steep
        kn, kb = turn * c + dtheta * sn, dtheta * c - turn * sn
        tau = dphi + kappa * steep
        dkn = dturn * c + ddtheta * sn + dphi * kb
        dkb = ddtheta * c - dturn * sn - dphi * kn
        dtau = ddphi + dkappa * steep + kappa * dtheta * level
        a, da = 1.0 - d * kn - h * kb, -(dd * kn + d * dkn + dh * kb + h * dkb)
        b, db = dd - h * tau, ddd - dh * tau - h * dtau
        e, de = dh + d * tau, ddh + dd * tau + d * dtau
        first = np.stack((a, b, e), axis=-1)
        second = np.stack((da - b * kn - e * kb, a * kn + db - e * tau, a * kb + b * tau + de), axis=-1)
        return first, second

    def arclength(self, s: ArrayLike) -> Array:
        """Own arclength at centre-line distance s [m]; outside of the track at unit rate."""
        s = np.asarray(s, dtype=np.float64)
        if self.side == 0:
            return s
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
        s = self._foretold(inside)
        for _ in range(12):
            step = (inside - self.arclength(s)) / self._rate(s)
            s = np.clip(s + step, 0.0, self.centre.length)
            if np.max(np.abs(step), initial=0.0) < 1e-7:  # quadratic: the next one would be rounding
                break
        return s + arclength - inside

    def _foretold(self, arclength: Array) -> Array:
        """Distance at own arclength, from the cubic through arclengths and rates at the anchors' ends."""
        i = np.clip(np.searchsorted(self.anchor_lengths, arclength, side="right") - 1, 0, len(self.anchors) - 2)
        a, b = self.anchor_lengths[i], self.anchor_lengths[i + 1]
        x = (arclength - a) / (b - a)
        start, end = ((b - a) / self.anchor_rates[i + k] for k in (0, 1))
        rise = self.anchors[i + 1] - self.anchors[i]
        return np.asarray(
            self.anchors[i] + x * (start + x * (3.0 * rise - 2.0 * start - end + x * (start + end - 2.0 * rise)))
        )

    def path(self, step: float) -> Path:
        """Table at uniform own arclength, with rows at most ``step`` [m] apart."""
        n = max(2, int(np.ceil(self.length / step - 1e-9)) + 1)
        actual = self.length / (n - 1)
        s = self.distance(np.linspace(0.0, self.length, n))
        s[-1] = self.centre.length

        heading = self.centre.heading(s)
        theta = self.centre.pitch(s)[0]
        phi, dphi, _ = self.roll(s)
        zero = np.zeros(n)
        level, steep = np.cos(theta), np.sin(theta)
        cos, sin = np.cos(heading), np.sin(heading)
        t = np.column_stack((level * cos, level * sin, steep))
        left = np.column_stack((-sin, cos, zero))
        up = np.column_stack((-steep * cos, -steep * sin, level))
        normal = np.cos(phi)[:, None] * left + np.sin(phi)[:, None] * up
        binormal = -np.sin(phi)[:, None] * left + np.cos(phi)[:, None] * up
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
        return Path(np.ascontiguousarray(table), actual)

    def _rate(self, s: ArrayLike) -> Array:
        """d(own arclength)/ds = |p'|."""
        if not self.side:
            return np.ones(np.shape(s))
        return np.asarray(np.linalg.norm(self.components(s)[0], axis=-1))

    def _advance(self, a: Array, b: Array) -> Array:
        """Arclength from a to b, both (m,); every pair within one piece."""
        if not self.side:
            return b - a
        middle, half = 0.5 * (a + b), 0.5 * (b - a)
        total = np.zeros(len(a))
        for point, weight in zip(GAUSS_POINTS, GAUSS_WEIGHTS, strict=True):
            total += weight * self._rate(middle + half * point)
        return total * half
