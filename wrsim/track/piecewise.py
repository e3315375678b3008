"""Piecewise polynomials of distance: curvature, cant, gauge and pitch along a track."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from math import factorial, perm

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Jet = tuple[Array, Array, Array]  # value, slope and second derivative

DEGREE = 22  # of the interpolation of laws that are no polynomials
NODES: Array = 0.5 + 0.5 * chebyshev.chebpts1(DEGREE + 1)
"""Shares of a piece at which `interpolant` takes values: Chebyshev's nodes."""
_FIT = chebyshev.chebvander(2.0 * NODES - 1.0, DEGREE) * np.append(1.0, np.full(DEGREE, 2.0)) / (DEGREE + 1)


def interpolant(values: ArrayLike) -> Array:
    """Polynomials of the share xi = 0..1 through values (..., n) at the NODES: coefficients of rising powers (..., n).

    Terms of the Chebyshev series within the rounding of the values, 1e-14 of the largest, are left out.
    """
    series = np.asarray(values, dtype=np.float64) @ _FIT
    series[np.abs(series) < 1e-14 * np.abs(series).max(axis=-1, keepdims=True)] = 0.0
    return np.asarray(series @ _chebyshev_powers())


@cache
def _chebyshev_powers() -> Array:
    """Coefficients of rising powers of xi in Chebyshev's polynomials of 2 xi - 1, one a row."""
    bases = [chebyshev.Chebyshev.basis(k, [0.0, 1.0]).convert(kind=np.polynomial.Polynomial) for k in range(DEGREE + 1)]
    return np.array([np.pad(each.coef, (0, DEGREE + 1 - each.coef.size)) for each in bases])


SLIVER = 1e-7  # shortest piece between breaks of different laws [m]


def merged(*breaks: Array) -> Array:
    """Breaks of several laws of one range in order, without pieces shorter than SLIVER."""
    places = np.unique(np.concatenate(breaks))
    inner = places[(places > places[0] + SLIVER) & (places < places[-1] - SLIVER)]
    inner = inner[np.append(True, np.diff(inner) > SLIVER)[: inner.size]]
    return np.concatenate((places[:1], inner, places[-1:]))


@dataclass(frozen=True, eq=False)
class Polynomials:
    """Polynomials between the places x (m + 1,): coefficients c (k, m) of falling powers of the distance from the
    beginning of a piece. As scipy's PPoly, which takes longer to import than a track to lay."""

    c: Array
    x: Array

    def derivative(self, order: int) -> Polynomials:
        c = self.c
        for _ in range(order):
            c = c[:-1] * np.arange(len(c) - 1, 0, -1)[:, None]
        return Polynomials(c if len(c) else np.zeros_like(self.c[:1]), self.x)

    def antiderivative(self) -> Polynomials:
        """The integral from the first place on."""
        c = np.vstack([self.c / np.arange(len(self.c), 0, -1)[:, None], np.zeros_like(self.c[:1])])
        c[-1, 1:] = np.cumsum(np.polyval(c, np.diff(self.x)))[:-1]
        return Polynomials(c, self.x)

    def __call__(self, s: ArrayLike, order: int = 0) -> Array:
        """Value or a derivative at s; beyond the ends that of the first or the last piece."""
        s = np.asarray(s, dtype=float)
        i = self.x[1:-1].searchsorted(s, "right")
        return np.asarray(np.polyval(self.derivative(order).c[:, i], s - self.x[i]))


@dataclass(frozen=True, eq=False)
class Piecewise:
    """A polynomial in each piece, of tracks from s = 0 [m] on.

    At a joint the piece behind it holds. Outside, value and derivatives of the nearer end are held.
    """

    pieces: Polynomials
    rounding: tuple[float, float] = (0.0, 0.0)
    """Half length over which kinks are rounded, and the largest change of the value by it."""

    @classmethod
    def of_rows(cls, edges: Array, rows: ArrayLike) -> Piecewise:
        """c0 + c1 xi + c2 xi^2 + ... with xi = 0..1 in each piece; edges: (m + 1,) [m], rows: (m, k)."""
        coefficients = np.array(rows, dtype=np.float64).T
        powers = np.arange(len(coefficients))[:, None]
        return cls(Polynomials((coefficients / np.diff(edges) ** powers)[::-1], edges))

    @classmethod
    def interpolated(cls, edges: Array, values: Array) -> Piecewise:
        """Through values (m, n) at the NODES of each piece."""
        rows = interpolant(values)
        used = np.flatnonzero(np.any(rows != 0.0, axis=0))
        return cls.of_rows(edges, rows[:, : int(used.max(initial=1)) + 1])

    @classmethod
    def through(cls, s: Array, values: Array) -> Piecewise:
        """Straight lines through values (m + 1,) at rising s [m]."""
        return cls.of_rows(s, np.column_stack((values[:-1], np.diff(values))))

    @property
    def end(self) -> float:
        """Distance of the end of the last piece [m]."""
        return float(self.pieces.x[-1])

    @property
    def breaks(self) -> Array:
        """Distances between which the function is smooth, from the start to the end."""
        return np.asarray(self.pieces.x)

    @cached_property
    def is_zero(self) -> bool:
        """True when the function is zero everywhere."""
        return not self.pieces.c.any()

    @cached_property
    def _integral(self) -> Polynomials:
        return self.pieces.antiderivative()

    def __call__(self, s: ArrayLike, derivative: int = 0) -> Array:
        """Value (derivative = 0), slope (1) or second derivative (2) at s; shape of s."""
        if self.is_zero:
            return np.zeros(np.shape(s))
        return np.asarray(self.pieces(np.minimum(np.maximum(s, self.breaks[0]), self.end), derivative))

    def jet(self, s: ArrayLike) -> Jet:
        """Value, slope and second derivative at s, each of its shape."""
        return self(s), self(s, 1), self(s, 2)

    def integral(self, s: ArrayLike) -> Array:
        """Integral from the first break to s, exact; constant outside."""
        return np.asarray(self._integral(np.clip(s, self.breaks[0], self.end)))

    def joints(self, derivative: int = 0) -> tuple[Array, Array]:
        """Value or slope just before and just behind each inner joint, (m - 1,) each."""
        law = self.pieces.derivative(derivative)
        return np.asarray(np.polyval(law.c[:, :-1], np.diff(law.x)[:-1])), law.c[-1, 1:]

    def scaled(self, factor: float) -> Piecewise:
        """The function times a factor."""
        return Piecewise(Polynomials(factor * self.pieces.c, self.breaks))

    def absolute(self) -> Piecewise:
        """The size of the function, with a break wherever its sign changes."""
        edges, share = self.breaks, np.linspace(0.0, 1.0, 9)
        places = np.unique(edges[:-1, None] + share * np.diff(edges)[:, None])
        crossing = np.flatnonzero(np.diff(np.sign(self(places))))
        low, high = places[crossing], places[crossing + 1]
        first = np.sign(self(low))
        for _ in range(60):  # bisection down to rounding
            middle = 0.5 * (low + high)
            before = np.sign(self(middle)) == first
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        beside = np.abs(low[:, None] - edges).min(axis=1, initial=np.inf) > SLIVER  # not the rounding of a zero at one
        parts = np.unique(np.concatenate([edges, low[beside]]))
        sign = np.sign(self(0.5 * (parts[1:] + parts[:-1])))
        return Piecewise(Polynomials(sign * self._taylor(parts), parts))

    def _taylor(self, parts: Array, least: int = 0) -> Array:
        """Coefficients of falling powers in parts (m + 1,) of the pieces, of the degree ``least`` at least."""
        orders = range(max(least, len(self.pieces.c) - 1), -1, -1)
        return np.array([self.pieces(parts[:-1], n) / factorial(n) for n in orders])

    def rounded(self, half_width: float) -> Piecewise:
        """The function with its kinks rounded over +-half_width [m], never beyond a neighbour.

        A kink is convolved with a parabola of that support (docs/theory/track.md): value, slope and second derivative
        are continuous, the function beyond is the same. A jump J of the slope changes the value by at most 3/16 J w.
        """
        edges = self.breaks
        before, behind = self.joints(1)
        length = np.diff(edges)
        scale = np.abs(self.pieces.c * length ** np.arange(len(self.pieces.c))[::-1, None]).max() / length.min()
        real = np.abs(behind - before) > 1e-14 * scale
        joint, jump = edges[1:-1][real], (behind - before)[real]
        width = np.minimum(half_width, np.minimum(length[:-1], length[1:]))[real]
        parts = np.unique(np.clip(np.concatenate([edges, joint - width, joint + width]), edges[0], self.end))
        c, orders = self._taylor(parts, 4), range(4, -1, -1)
        # (1 - a)^3 (3 + a) from s - w to s and from s to s + w, in falling powers of the distance from there over w
        halves = np.array([[-1.0, -1.0], [4.0, 0.0], [0.0, 6.0], [0.0, -8.0], [0.0, 3.0]])
        first, last = (np.searchsorted(parts[:-1], joint + sign * width) for sign in (-1.0, 1.0))
        joint_index = np.repeat(np.arange(joint.size), last - first)  # joint whose bump goes over each part
        neighbours = np.arange(joint_index.size) + np.repeat(last - np.cumsum(last - first), last - first)
        s, w, half = joint[joint_index], width[joint_index], (parts[neighbours] >= joint[joint_index]).astype(int)
        powers = np.cumprod([np.ones(neighbours.size), *[parts[neighbours] - np.where(half, s, s - w)] * 4], axis=0)
        bump = (jump * width / 16.0)[joint_index] * halves[:, half] / w ** np.array(orders)[:, None]
        for row, n in zip(c[-5:], orders, strict=True):
            slopes = sum(bump[4 - k] * powers[k - n] * perm(k, n) for k in range(n, 5))
            np.add.at(row, neighbours, slopes / factorial(n))
        change = 3.0 / 16.0 * float(np.abs(jump * width).max(initial=0.0))
        return Piecewise(Polynomials(c, parts), (half_width, change)) if real.any() else self
