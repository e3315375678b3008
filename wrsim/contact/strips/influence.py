"""What strips of pressure do to the surface, from one function of two arguments.

A strip presses the surface down by differences of PHI (strip-phi), however wide it is, near or far. PHI/t is a cubic
spline at equal steps of the octaves of t and of y + sqrt(y^2 + 1), y = SHARP (xi^2 - 1), which is fine beside the end
of the line, xi = 1, where (strip-line) bends within t. `wrsim.contact.tables` has its coefficients; the last row are
those of the spline at xi = 0.
"""

from math import copysign, sqrt
from typing import NamedTuple

import numpy as np

from wrsim.contact.strips.records import RESTS, V
from wrsim.jit import Array, inlined, kernel, noalias_kernel
from wrsim.jit.arena import bits_of, number_of
from wrsim.jit.spline import differences, differences_in_row, terms, terms_in_row

LOWEST, HIGHEST, STEPS = -12, 12, 6
"""Octaves of t in the table, and steps in each; below the first t counts as its start."""
INNER, OUTER, STEPS_BESIDE = -8, 24, 8
"""Octaves of xi = 0 and of the end of its axis, and steps in each."""
SHARP = 0.5 * (2.0**-INNER - 2.0**INNER)  # fineness of that axis at xi = 1
_MOST_T = (HIGHEST - LOWEST) * STEPS - 1e-6
_MOST_XI = (OUTER - INNER) * STEPS_BESIDE - 1e-6
_LEAST_T = 2.0**LOWEST
_ONE = 1023 << 52
_MANTISSA = (1 << 52) - 1
RISE = 942.0 / 651.0, -472.0 / 651.0, 272.0 / 651.0, -112.0 / 651.0, 21.0 / 651.0  # within an octave


@inlined
def octave(x: float) -> float:
    """The logarithm of x > 0 to base 2, to 0.0005: exact at powers of two, between them the quintic of the mantissa
    that leaves no step in the first four derivatives."""
    bits = bits_of(x)
    z = number_of((bits & _MANTISSA) | _ONE) - 1.0
    return (bits >> 52) - 1023.0 + z * (RISE[0] + z * (RISE[1] + z * (RISE[2] + z * (RISE[3] + z * RISE[4]))))


@inlined
def _octave_rate(x: float) -> float:
    """Derivative of the octave by the natural logarithm of x."""
    z = number_of((bits_of(x) & _MANTISSA) | _ONE) - 1.0
    slope = RISE[0] + z * (2.0 * RISE[1] + z * (3.0 * RISE[2] + z * (4.0 * RISE[3] + z * 5.0 * RISE[4])))
    return (1.0 + z) * slope


@inlined
def _coordinate_t(t: float) -> float:
    """Steps of the table up to t."""
    return min((octave(max(abs(t), _LEAST_T)) - LOWEST) * STEPS, _MOST_T)


@inlined
def _coordinate_xi(xi: float) -> float:
    """Steps of the table up to xi."""
    y = SHARP * (xi * xi - 1.0)
    return min(max((octave(y + sqrt(y * y + 1.0)) - INNER) * STEPS_BESIDE, 0.0), _MOST_XI)


@noalias_kernel
def _find_ends(
    start: Array, end: Array, inverse: Array, s: float, low: Array, low_z: Array, high: Array, high_z: Array
) -> None:
    """Coordinates t of both ends of strips, (n,), seen from s; _z: what of them is beyond their last whole step."""
    for j in range(inverse.size):
        lo = _coordinate_t((start[j] - s) * inverse[j])
        hi = _coordinate_t((end[j] - s) * inverse[j])
        low[j], low_z[j], high[j], high_z[j] = lo, lo - np.floor(lo), hi, hi - np.floor(hi)


@noalias_kernel
def _find_middles(middle: Array, inverse: Array, x: float, beside: Array, beside_z: Array) -> None:
    """Coordinates xi of the point x, (n,), seen from the middles of strips; _z: as in ``_find_ends``."""
    for j in range(inverse.size):
        xi = _coordinate_xi((x - middle[j]) * inverse[j])
        beside[j], beside_z[j] = xi, xi - np.floor(xi)


@noalias_kernel
def _find_levers(start: Array, end: Array, inverse: Array, push: Array, s: float, lo: Array, hi: Array) -> None:
    """Distances of both ends of strips from s, times amplitudes and half lengths, (n,)."""
    for j in range(inverse.size):
        lo[j] = (start[j] - s) * (push[j] * inverse[j])
        hi[j] = (end[j] - s) * (push[j] * inverse[j])


@noalias_kernel
def _find_rates(start: Array, end: Array, inverse: Array, s: float, low: Array, high: Array) -> None:
    """Slopes of the coordinates of both ends over the logarithm of t, (n,)."""
    for j in range(inverse.size):
        low[j] = STEPS * _octave_rate(max(abs((start[j] - s) * inverse[j]), _LEAST_T))
        high[j] = STEPS * _octave_rate(max(abs((end[j] - s) * inverse[j]), _LEAST_T))


@noalias_kernel
def _scale_by_rate(middle: Array, inverse: Array, x: float, p: Array) -> None:
    """Multiply by the slope of the coordinate over xi, (n,)."""
    for j in range(inverse.size):
        xi = (x - middle[j]) * inverse[j]
        y = SHARP * (xi * xi - 1.0)
        root = sqrt(y * y + 1.0)
        p[j] *= STEPS_BESIDE * _octave_rate(y + root) * 2.0 * SHARP * xi / root


@inlined
def turned_influence(vectors: Array, j: int, no: float, nb: float, s: float) -> float:
    """Share of what strip j does along its normal that is felt along another normal (no, nb), at s (strip-turned)."""
    level = vectors[V.NO, j] * no + vectors[V.NB, j] * nb
    if vectors[V.SIDE, j] == 0.0:
        return level
    t = (0.5 * (vectors[V.FROM, j] + vectors[V.TO, j]) - s) * vectors[V.INVERSE, j]
    # a force along s acts as one along n does and nu/(1 - nu) s^2/r^2 of it, roughly with the mean r over the strip
    return level + (vectors[V.NB, j] * no - vectors[V.NO, j] * nb) * (
        vectors[V.SIDE, j] + vectors[V.LIFT, j] * abs(t) / sqrt(t * t + 0.5)
    )


@inlined
def turned_rates(
    vectors: Array, j: int, no: float, nb: float, s: float, turn: float, side_s: float, turn_here: float
) -> tuple[float, float]:
    """Derivatives of `turned_influence` by the places of strip j and of s, with the slopes of the angles of both
    normals and of strip j's lateral force."""
    level = vectors[V.NO, j] * no + vectors[V.NB, j] * nb
    across = vectors[V.NB, j] * no - vectors[V.NO, j] * nb
    side, lift, inverse = vectors[V.SIDE, j], vectors[V.LIFT, j], vectors[V.INVERSE, j]
    t = (0.5 * (vectors[V.FROM, j] + vectors[V.TO, j]) - s) * inverse
    root = 1.0 / sqrt(t * t + 0.5)
    whole = side + lift * abs(t) * root
    steep = copysign(0.5 * lift * root * root * root * inverse, t)
    slope = side_s * (whole / side if side != 0.0 else 1.0)
    rate = level * whole - across
    return turn * rate + across * (slope + steep), -turn_here * rate - across * steep


class Displacements(NamedTuple):
    """Displacements at a point and beside it along the rail [m], or times pi E*."""

    middle: float
    fore: float
    aft: float


@kernel
def displacement_at(
    table: Array, vectors: Array, first: int, last: int, s: float, x: float, r: float, points: int, no: float,
    nb: float, turned: bool, aligned: bool,
) -> Displacements:  # fmt: skip
    """Displacements (strip-sum), times pi E*, under strips that follow each other at (x, s), x + r and x - r, or the
    first ``points`` of these; no, nb: the normal there, if it counts (turned); aligned: x is the middle of all strips,
    for two points at most.

    The coordinates in the table are computed for several strips at a time.
    """
    # from 0 on: where a number may be negative the compiler gathers
    start, end, inverse, middles, pushes = (
        vectors[V.FROM, first:last], vectors[V.TO, first:last], vectors[V.INVERSE, first:last],
        vectors[V.MIDDLE, first:last], vectors[V.PUSH, first:last],
    )  # fmt: skip
    n = last - first
    low, high, low_z, high_z, lo, hi = (
        vectors[V.TERMS, :n], vectors[V.TERMS + 1, :n], vectors[V.TERMS + 2, :n], vectors[V.TERMS + 3, :n],
        vectors[V.TERMS + 4, :n], vectors[V.TERMS + 5, :n],
    )  # fmt: skip
    here, here_z, before, before_z, behind, behind_z = (
        vectors[V.TERMS + 6, :n], vectors[V.TERMS + 7, :n], vectors[V.TERMS + 8, :n], vectors[V.TERMS + 9, :n],
        vectors[V.TERMS + 10, :n], vectors[V.TERMS + 11, :n],
    )  # fmt: skip
    _find_levers(start, end, inverse, pushes, s, lo, hi)
    if turned:
        for j in range(n):
            felt = turned_influence(vectors, first + j, no, nb, s)
            lo[j] *= felt
            hi[j] *= felt
    _find_ends(start, end, inverse, s, low, low_z, high, high_z)
    if not aligned:
        _find_middles(middles, inverse, x, here, here_z)
    ends = lo, low, low_z, hi, high, high_z
    if points == 1 and not aligned:
        return Displacements(differences(table, ends, (here, here_z))[0], 0.0, 0.0)
    _find_middles(middles, inverse, x + r, before, before_z)
    if aligned:
        middle, fore = differences_in_row(table, ends, (before, before_z))
        return Displacements(middle, fore, fore)
    if points > 2:
        _find_middles(middles, inverse, x - r, behind, behind_z)
        middle, fore, aft = differences(table, ends, (here, here_z, before, before_z, behind, behind_z))
        return Displacements(middle, fore, aft)
    middle, fore = differences(table, ends, (here, here_z, before, before_z))
    return Displacements(middle, fore, fore)


@kernel
def find_terms(
    table: Array, vectors: Array, first: int, last: int, s: float, x: float, aligned: bool, p: Array, p_xi: Array,
    lever: Array, f0: Array, f1: Array,
) -> None:  # fmt: skip
    """Terms of the derivatives of (strip-sum) at (x, s) by strips that follow each other, each (>= last,).

    Differences of PHI, and of its slope by xi; of t f; f(1, xi, t) at both ends. aligned: as in ``displacement_at``.
    """
    start, end, inverses, middles = (
        vectors[V.FROM, first:last], vectors[V.TO, first:last], vectors[V.INVERSE, first:last],
        vectors[V.MIDDLE, first:last],
    )  # fmt: skip
    p, p_xi, lever, f0, f1 = p[first:last], p_xi[first:last], lever[first:last], f0[first:last], f1[first:last]
    in_middle = table[table.shape[0] - 1]
    f0_z, f1_z, p_z = vectors[RESTS], vectors[RESTS + 1], vectors[RESTS + 2]
    _find_ends(start, end, inverses, s, f0, f0_z, f1, f1_z)
    _find_rates(start, end, inverses, s, lever, p_xi)
    if not aligned:
        _find_middles(middles, inverses, x, p, p_z)
    for j in range(last - first):
        lo, hi = (start[j] - s) * inverses[j], (end[j] - s) * inverses[j]
        if aligned:
            p[j], f0[j], f1[j] = terms_in_row(in_middle, lo, f0[j], f0_z[j], lever[j], hi, f1[j], f1_z[j], p_xi[j])
            p_xi[j] = 0.0
        else:
            p[j], p_xi[j], f0[j], f1[j] = terms(
                table, p[j], p_z[j], lo, f0[j], f0_z[j], lever[j], hi, f1[j], f1_z[j], p_xi[j]
            )
        lever[j] = hi * f1[j] - lo * f0[j]
    if not aligned:
        _scale_by_rate(middles, inverses, x, p_xi)
