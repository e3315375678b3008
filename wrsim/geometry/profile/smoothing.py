"""Measured profiles: smoothed with a fixed cut-off wavelength over arclength, never interpolated.

Interpolated noise has no meaningful curvature: 5 um of scatter at points 0.1 mm apart are 1000 1/m, as of a
radius of 1 mm. The smoothing spline f of the points p_i minimises

    sum_i h_i |p_i - f(s_i)|^2 + (cutoff/(2 pi))^6 integral |f'''(s)|^2 ds,

h_i being the spacing of the points. Away from the ends it passes a wave of wavelength l with the amplitude

    1 / (1 + (cutoff/l)^6)

and no shift: one half at the cut-off, 98.5 % at twice and 1.5 % at half of it. The third derivative is
penalised rather than the usual second one, so that arcs are kept: parabolas pass unchanged, also at the ends.
It is solved on B-splines with evenly spaced knots (P. H. C. Eilers, B. D. Marx, Flexible smoothing with
B-splines and penalties, Statistical Science 11, 1996).
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline
from scipy.linalg import solveh_banded
from scipy.sparse import diags_array

from wrsim.errors import InputError
from wrsim.geometry.piecewise import arclengths
from wrsim.geometry.profile.points import Points, profile_from_curve
from wrsim.geometry.profile.profile import Array, Kind, Profile

CUTOFF = 5e-3
"""Usual cut-off wavelength, m. A jump of curvature (arc to straight) spreads over about this length."""

DEGREE = 5
KNOTS_PER_CUTOFF = 16
ROUNDS = 6
"""Rounds of smoothing and measuring arclength anew: a noisy polygon is longer than its curve."""


def smoothed(points: Points, name: str, kind: Kind, source: str = "", cutoff: float = CUTOFF) -> Profile:
    """Profile of measured points, smoothed; cutoff: wavelength over arclength that passes with half its amplitude [m].

    Raises InputError where the points are too far apart for the cut-off.
    """
    chords = points.chords
    i = int(np.argmax(chords))
    if chords[i] > 0.5 * cutoff:
        raise InputError(
            f"{points.file}:{points.line[i + 1]}: {1e3 * chords[i]:.4g} mm from the point of line "
            f"{points.line[i]}; smoothing with a cut-off of {1e3 * cutoff:g} mm needs points at most "
            f"{500.0 * cutoff:g} mm apart"
        )
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


def smoothing_spline(s: Array, p: Array, cutoff: float) -> BSpline:
    """Smoothing spline of degree five over evenly spaced knots through points p (n, m) at increasing s (n,) [m].

    cutoff: wavelength that passes with half its amplitude [m].
    """
    count = max(int(np.ceil((s[-1] - s[0]) / cutoff * KNOTS_PER_CUTOFF)), 1)
    step = (s[-1] - s[0]) / count
    knots = s[0] + step * np.arange(-DEGREE, count + DEGREE + 1)
    n = count + DEGREE
    x = np.clip(s, s[0], knots[-DEGREE - 1])
    basis = BSpline.design_matrix(x, knots, DEGREE)
    gaps = np.diff(s)
    weight = diags_array(0.5 * (np.concatenate([gaps[:1], gaps]) + np.concatenate([gaps, gaps[-1:]])))
    # The third derivative is a spline of degree two with the third differences over step^3 as coefficients;
    # three Gauss points on every interval integrate its square exactly.
    gauss, gauss_weight = np.polynomial.legendre.leggauss(3)
    place = (s[0] + step * (np.arange(count)[:, None] + 0.5 + 0.5 * gauss)).ravel()
    differences = diags_array(
        [np.full(n - 3, c) / step**3 for c in (-1.0, 3.0, -3.0, 1.0)], offsets=[0, 1, 2, 3], shape=(n - 3, n)
    )
    third = BSpline.design_matrix(place, knots[3:-3], DEGREE - 3) @ differences
    penalty = third.T @ diags_array(np.tile(0.5 * step * gauss_weight, count)) @ third
    matrix = (basis.T @ weight @ basis + (cutoff / (2.0 * np.pi)) ** 6 * penalty).tocsr()
    bands = [np.concatenate([matrix.diagonal(k), np.zeros(k)]) for k in range(DEGREE + 1)]
    return BSpline(knots, solveh_banded(np.stack(bands), basis.T @ (weight @ p), lower=True), DEGREE)
