"""Points of a file on their way to a profile: ordered, checked, joined by a spline over arclength [S 12].

Every point has the number of its line, for messages. Exact points are interpolated, measured ones smoothed with a fixed
cut-off wavelength over arclength (surf-smooth), on B-splines with evenly spaced knots (P. H. C. Eilers, B.
D. Marx, Flexible smoothing with B-splines and penalties, Statistical Science 11, 1996).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from wrsim.contact.profiles.curves import arclengths, subdivided
from wrsim.contact.profiles.profile import Array, Kind, Profile, curvature_of, plane_cross
from wrsim.errors import InputError

FEWEST_POINTS = 10
SAME_POINT = 1e-10  # neighbours closer than this are one point, m
LARGEST_GAP = 1.0 / 25.0  # largest distance of neighbours, as a part of the curve's length
LARGEST_TURN = np.radians(20.0)
"""Largest turn at a point of a profile that is to be interpolated, rad: 4 mm on the 13 mm arc of a rail."""
LARGEST_CURVATURE_SCATTER = 2.0
"""Largest scatter of curvature that rounding or measuring may leave in interpolated points, 1/m."""
SHORTEST, LONGEST = 0.005, 1.0  # length of a profile, m: outside of this the unit is probably wrong
NODE_DISTANCE = 1e-4
"""Largest distance of nodes along a profile, m. The curve between nodes is a quintic; 0.1 mm leaves 1e-15 m."""


@dataclass(frozen=True)
class ProfilePoints:
    """Points of a file: outward coordinate u and height w, m, and their lines; all (n,)."""

    file: str
    u: Array
    w: Array
    line: NDArray[np.intp]

    def __len__(self) -> int:
        return int(self.u.size)

    @property
    def places(self) -> Array:
        """The coordinates, (n, 2)."""
        return np.column_stack([self.u, self.w])

    @property
    def chords(self) -> Array:
        """Distances of neighbours, (n - 1,)."""
        return np.hypot(np.diff(self.u), np.diff(self.w))

    def __getitem__(self, chosen: NDArray[Any] | slice) -> ProfilePoints:
        return replace(self, u=self.u[chosen], w=self.w[chosen], line=self.line[chosen])

    def turned(self, angle: float) -> ProfilePoints:
        """Turned about the origin, positive from u towards w."""
        c, s = np.cos(angle), np.sin(angle)
        return replace(self, u=c * self.u - s * self.w, w=s * self.u + c * self.w)

    def in_order(self) -> ProfilePoints:
        """In the order of increasing u (overall)."""
        return self[::-1] if len(self) and self.u[-1] < self.u[0] else self

    def without_duplicates(self, resolution: float = 0.0, least: float = 0.0) -> ProfilePoints:
        """Without neighbours closer than ``least`` [m], or too close for the last digit of the file's numbers [m].

        Points closer than the square root of that digit (in metres) give a curvature that is off by more than 1/m; of
        those the ones far closer than usual are dropped.
        """
        if len(self) < 2:
            return self
        near = min(np.sqrt(max(resolution, 0.0)), 0.1 * float(np.median(self.chords)))
        least = max(SAME_POINT, near, least)
        keep = [0]
        for i in range(1, len(self)):
            if np.hypot(self.u[i] - self.u[keep[-1]], self.w[i] - self.w[keep[-1]]) >= least:
                keep.append(i)
        if len(keep) > 1:
            keep[-1] = len(self) - 1  # the end stays where it is
        return self[np.array(keep)]

    def clipped(self, first: float, last: float) -> ProfilePoints:
        """The longest run of points with first <= u <= last, m."""
        inside = (self.u >= first) & (self.u <= last)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
        if not edges.size:
            reach = f"the points go from {1e3 * self.u.min():.6g} to {1e3 * self.u.max():.6g} mm"
            raise InputError(f"{self.file}: clip from {1e3 * first:g} to {1e3 * last:g} mm leaves no point; {reach}")
        best = 2 * int(np.argmax(edges[1::2] - edges[::2]))
        return self[edges[best] : edges[best + 1]]


def check_count(points: ProfilePoints) -> None:
    if len(points) < FEWEST_POINTS:
        raise InputError(f"{points.file}: {len(points)} different points; a profile needs at least {FEWEST_POINTS}")


def check_points(points: ProfilePoints) -> None:
    """Raise InputError unless the points are a plain curve: no steps back, no gaps, no crossings."""
    file, line = points.file, points.line
    check_count(points)
    turn = turns(points)
    i = int(np.argmax(np.abs(turn)))
    if abs(turn[i]) > 0.5 * np.pi:
        reason = "points out of order, a zig-zag, or two scans in one file; those of a scan are joined (--measured)"
        angle = f"it turns by {np.degrees(turn[i]):.0f} degrees"
        raise InputError(f"{file}:{line[i + 1]}: the curve goes back on itself here ({angle}): {reason}")
    chords = points.chords
    length, i = float(chords.sum()), int(np.argmax(chords))
    if chords[i] > LARGEST_GAP * length:
        allowed = f"allowed: {1e3 * LARGEST_GAP * length:.4g} mm (1/{1 / LARGEST_GAP:.0f} of the profile's length)"
        far = f"{1e3 * chords[i]:.4g} mm from the point of line {line[i]}"
        raise InputError(f"{file}:{line[i + 1]}: too coarse: {far}; {allowed}")
    if not SHORTEST <= length <= LONGEST:
        allowed = f"allowed: {1e3 * SHORTEST:g} to {1e3 * LONGEST:g} mm. Is the unit right?"
        raise InputError(f"{file}: the profile is {1e3 * length:.4g} mm long; {allowed}")
    if crossing := first_crossing(points):
        i, j = crossing
        pair = f"lines {line[i]}-{line[i + 1]} and {line[j]}-{line[j + 1]} intersect"
        raise InputError(f"{file}:{line[j]}: the curve crosses itself: {pair}")


def turns(points: ProfilePoints) -> Array:
    """Signed angle between the chords before and after every inner point, (n - 2,), rad."""
    d = np.diff(points.places, axis=0)
    return np.arctan2(plane_cross(d[:-1], d[1:]), (d[:-1] * d[1:]).sum(axis=1))


def first_crossing(points: ProfilePoints) -> tuple[int, int] | None:
    """Two segments i < j that intersect, each named by its first point, or None."""
    p = points.places
    middle, d = 0.5 * (p[1:] + p[:-1]), p[1:] - p[:-1]
    # Segments that intersect have middles no farther apart than the longest segment.
    pairs = scipy.spatial.cKDTree(middle).query_pairs(float(points.chords.max()) * (1.0 + 1e-9), output_type="ndarray")
    pairs = pairs[np.abs(pairs[:, 0] - pairs[:, 1]) > 1]
    i, j = pairs.min(axis=1), pairs.max(axis=1)

    def side(a: Array, b: Array, c: Array) -> Array:
        return np.sign(plane_cross(b - a, c - a))

    apart_j = side(p[i], p[i] + d[i], p[j]) * side(p[i], p[i] + d[i], p[j] + d[j])
    apart_i = side(p[j], p[j] + d[j], p[i]) * side(p[j], p[j] + d[j], p[i] + d[i])
    hits = np.flatnonzero((apart_i < 0) & (apart_j < 0))
    if not hits.size:
        return None
    k = hits[np.argmin(i[hits])]
    return int(i[k]), int(j[k])


def scatter(points: ProfilePoints) -> float:
    """Scatter of the points across a smooth curve, m: robust deviation from cubics through neighbours."""
    s = np.concatenate([[0.0], np.cumsum(points.chords)])
    x = np.stack([s[:-4], s[1:-3], s[3:-1], s[4:]]) - s[2:-2]
    weight = np.ones_like(x)
    for a, b in permutations(range(4), 2):
        weight[a] *= -x[b] / (x[a] - x[b])
    p = points.places
    left = p[2:-2] - np.einsum("an,anc->nc", weight, np.stack([p[:-4], p[1:-3], p[3:-1], p[4:]]))
    left /= np.sqrt(1.0 + (weight**2).sum(axis=0))[:, None]
    d = p[3:-1] - p[1:-3]
    across = plane_cross(left, d) / np.hypot(*d.T)
    return 1.4826 * float(np.median(np.abs(across)))


def curvature_scatter(points: ProfilePoints, digit: float = 0.0) -> float:
    """Scatter of the curvature of a curve through the points, or its error by rounding to a last digit [m], if larger
    [1/m]; 0 where it may be."""
    bend = max(float(np.sqrt(6.0)) * scatter(points), 2.0 * digit) / float(np.median(points.chords)) ** 2
    return bend if bend > LARGEST_CURVATURE_SCATTER else 0.0


def cutoff_for(points: ProfilePoints, digit: float) -> float:
    """Cut-off [m] at which smoothing leaves the curvature that scatter it may have, up to the usual one.

    digit: last one of the coordinates [m]. Rounding errs by half of it with any wavelength; of a wave as long as the
    cut-off half passes, with (2 pi / l)^2 times its amplitude as curvature.

    Independent errors s at distances h are white: of the curvature of what passes 1 / (1 + (l / x)^6) the standard
    deviation is s sqrt(h) (2 pi)^2 l^-2.5 (2 I)^0.5 with I, the integral of x^4 / (1 + x^6)^2 from 0, pi / 18.
    """
    error = scatter(points) * np.sqrt(np.median(points.chords)) * (2.0 * np.pi) ** 2 * np.sqrt(np.pi / 9.0)
    white = (error / LARGEST_CURVATURE_SCATTER) ** 0.4
    rounding = 2.0 * np.pi * np.sqrt(0.25 * digit / LARGEST_CURVATURE_SCATTER)
    return float(max(2.01 * float(points.chords.max()), min(CUTOFF, max(white, rounding))))


def interpolated(points: ProfilePoints, name: str, kind: Kind, source: str = "") -> Profile:
    """Profile through the points: cubic spline, its parameter iterated until it is arclength [S 12].

    For exact points: designed shapes, exported splines. Points that scatter are refused: their curvature is noise.
    """
    turn = turns(points)
    i = int(np.argmax(np.abs(turn)))
    if abs(turn[i]) > LARGEST_TURN:
        corner = f"a corner of {np.degrees(turn[i]):.1f} degrees; allowed: {np.degrees(LARGEST_TURN):.0f}"
        hint = "More points are needed here, or measured = true (--measured) to smooth it"
        raise InputError(f"{points.file}:{points.line[i + 1]}: {corner}. {hint}")
    if bend := curvature_scatter(points):
        raise InputError(
            f"{points.file}: the points scatter by {1e6 * scatter(points):.3g} um, so their curvature would be off by "
            f"{bend:.3g} 1/m; allowed: {LARGEST_CURVATURE_SCATTER:g}. Smooth them with measured = true (--measured)"
        )
    p = points.places
    s = np.concatenate([[0.0], np.cumsum(points.chords)])
    for _ in range(50):
        spline = scipy.interpolate.CubicSpline(s, p)
        new = arclengths(spline.derivative(), s)
        done = np.abs(new - s).max() <= 1e-15 * new[-1]
        s = new
        if done:
            break
    return profile_from_curve(scipy.interpolate.CubicSpline(s, p), s, name, kind, source)


def profile_from_curve(curve: Callable[..., Array], t: Array, name: str, kind: Kind, source: str) -> Profile:
    """Profile of a spline curve(t, nu) -> (n, 2), smooth between the parameters t, roughly arclength."""
    t = subdivided(t, np.ceil(np.diff(t) / NODE_DISTANCE - 1e-6))
    r, v, a = (curve(t, nu) for nu in range(3))
    bend, angle = curvature_of(v, a), np.unwrap(np.arctan2(v[:, 1], v[:, 0]))
    return Profile(name, kind, arclengths(lambda x: curve(x, 1), t), r[:, 0], r[:, 1], angle, bend, bend, source)


CUTOFF = 5e-3  # usual cut-off wavelength, m. A jump of curvature (arc to straight) spreads over about this length.
DEGREE = 5
KNOTS_PER_CUTOFF = 16
ROUNDS = 6  # rounds of smoothing and measuring arclength anew: a noisy polygon is longer than its curve


def smoothed(points: ProfilePoints, name: str, kind: Kind, source: str = "", cutoff: float = CUTOFF) -> Profile:
    """Profile of measured points, smoothed; cutoff: wavelength over arclength that passes with half its amplitude [m].

    Raises InputError where the points are too far apart for the cut-off.
    """
    chords = points.chords
    i = int(np.argmax(chords))
    if chords[i] > 0.5 * cutoff:
        place = f"{points.file}:{points.line[i + 1]}: {1e3 * chords[i]:.4g} mm from the point of line {points.line[i]}"
        needed = f"needs points at most {500.0 * cutoff:g} mm apart; or set cutoff_mm = {2.02e3 * chords[i]:.3g}"
        raise InputError(f"{place}; smoothing with a cut-off of {1e3 * cutoff:g} mm {needed}")
    p = points.places
    s = np.concatenate([[0.0], np.cumsum(chords)])
    for _ in range(ROUNDS):
        curve = smoothing_spline(s, p, cutoff)
        # Each point's own place on the curve, by its foot, in true arclength.
        for _ in range(2):
            v = curve(s, 1)
            s = s + ((p - curve(s)) * v).sum(axis=1) / (v * v).sum(axis=1)
        order = np.argsort(s, kind="stable")
        p, s = p[order], s[order]
        s = arclengths(lambda t, c=curve: c(t, 1), s)  # type: ignore[misc]
        apart = np.concatenate([[True], np.diff(s) > 0.0])
        p, s = p[apart], s[apart]
    curve = smoothing_spline(s, p, cutoff)
    knots = curve.t[DEGREE:-DEGREE]
    return profile_from_curve(curve, np.clip(knots, s[0], s[-1]), name, kind, source)


def smoothing_spline(s: Array, p: Array, cutoff: float) -> scipy.interpolate.BSpline:
    """Smoothing spline of degree five over evenly spaced knots through points p (n, m) at increasing s (n,) [m].

    cutoff: wavelength that passes with half its amplitude [m].
    """
    count = max(int(np.ceil((s[-1] - s[0]) / cutoff * KNOTS_PER_CUTOFF)), 1)
    step = (s[-1] - s[0]) / count
    knots = s[0] + step * np.arange(-DEGREE, count + DEGREE + 1)
    n = count + DEGREE
    x = np.clip(s, s[0], knots[-DEGREE - 1])
    basis = scipy.interpolate.BSpline.design_matrix(x, knots, DEGREE)
    gaps = np.diff(s)
    weight = scipy.sparse.diags_array(0.5 * (np.concatenate([gaps[:1], gaps]) + np.concatenate([gaps, gaps[-1:]])))
    # The third derivative is a spline of degree two with the third differences over step^3 as coefficients;
    # three Gauss points on every interval integrate its square exactly.
    gauss, gauss_weight = np.polynomial.legendre.leggauss(3)
    place = (s[0] + step * (np.arange(count)[:, None] + 0.5 + 0.5 * gauss)).ravel()
    differences = scipy.sparse.diags_array(
        [np.full(n - 3, c) / step**3 for c in (-1.0, 3.0, -3.0, 1.0)], offsets=[0, 1, 2, 3], shape=(n - 3, n)
    )
    third = scipy.interpolate.BSpline.design_matrix(place, knots[3:-3], DEGREE - 3) @ differences
    penalty = third.T @ scipy.sparse.diags_array(np.tile(0.5 * step * gauss_weight, count)) @ third
    matrix = (basis.T @ weight @ basis + (cutoff / (2.0 * np.pi)) ** 6 * penalty).tocsr()
    bands = [np.concatenate([matrix.diagonal(k), np.zeros(k)]) for k in range(DEGREE + 1)]
    coefficients = scipy.linalg.solveh_banded(np.stack(bands), basis.T @ (weight @ p), lower=True)
    return scipy.interpolate.BSpline(knots, coefficients, DEGREE)
