"""Piecewise cubic functions of distance: curvature, cant, gauge and pitch along a track."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Jet = tuple[Array, Array, Array]
"""Value, slope and second derivative."""


def linear(start: float, end: float) -> tuple[float, float, float, float]:
    """Coefficients of a straight ramp in xi = 0..1."""
    return (start, end - start, 0.0, 0.0)


def bloss(start: float, end: float) -> tuple[float, float, float, float]:
    """Coefficients of the Bloss ramp start + (end - start)(3 xi^2 - 2 xi^3): slope zero at both ends.

    A. E. Bloss, Der Uebergangsbogen mit geschwungener Ueberhoehungsrampe, Organ fuer die Fortschritte des
    Eisenbahnwesens 73 (1936) 319-320.
    """
    return (start, 0.0, 3.0 * (end - start), -2.0 * (end - start))


@dataclass(frozen=True, eq=False)
class PiecewiseCubic:
    """f(s) = c0 + c1 xi + c2 xi^2 + c3 xi^3 with xi = (s - starts[i]) / lengths[i] in piece i.

    starts, lengths: (m,) [m], pieces follow each other from s = 0. coefficients: (m, 4).
    At a joint the value of the piece behind it holds. Outside, the value of the nearer end is held.

    kinks: (m + 1, 2), for the start of every piece and the end of the last one the jump of slope J that is rounded
    there and the half width w [m] of the rounding, no longer than the pieces beside it; J = 0 where there is none.
    Each adds J w (1 - a)^3 (3 + a) / 16 with a = |s - position| / w < 1: the kink |s| J / 2 convolved with a
    parabola of support +-w. It takes the kink out, leaves value, slope and second derivative continuous and the
    function beyond +-w untouched; it changes the value by at most 3/16 J w.
    """

    starts: Array
    lengths: Array
    coefficients: Array
    kinks: Array = field(default_factory=lambda: np.empty((0, 2)))

    @property
    def end(self) -> float:
        """Distance of the end of the last piece [m]."""
        return float(self.starts[-1] + self.lengths[-1])

    @cached_property
    def is_zero(self) -> bool:
        """True when the function is zero everywhere."""
        return not self.coefficients.any()

    def _locate(self, s: ArrayLike) -> tuple[Array, NDArray[np.intp]]:
        s = np.clip(np.asarray(s, dtype=np.float64), 0.0, self.end)
        return s, np.clip(np.searchsorted(self.starts, s, side="right") - 1, 0, len(self.starts) - 1)

    def __call__(self, s: ArrayLike, derivative: int = 0) -> Array:
        """Value (derivative = 0), slope (1) or second derivative (2) at s; shape of s."""
        return self.jet(s)[derivative]

    def jet(self, s: ArrayLike) -> Jet:
        """Value, slope and second derivative at s, each of its shape."""
        if self.is_zero:
            zero = np.zeros(np.shape(s))
            return zero, zero, zero
        s, i = self._locate(s)
        length = self.lengths[i]
        xi = (s - self.starts[i]) / length
        c0, c1, c2, c3 = self.coefficients[i].T.reshape((4, *s.shape))
        value = c0 + xi * (c1 + xi * (c2 + xi * c3))
        slope = (c1 + xi * (2.0 * c2 + xi * 3.0 * c3)) / length
        bend = (2.0 * c2 + xi * 6.0 * c3) / length**2
        if len(self.kinks):
            for joint in (i, i + 1):
                jump, width = self.kinks[joint].T.reshape((2, *s.shape))
                position = np.append(self.starts, self.end)[joint]
                offset = (s - position) / width
                a = np.minimum(np.abs(offset), 1.0)
                side = np.where(offset >= 0.0, 1.0, -1.0)  # at the joint the piece behind holds: +1
                value = value + jump * width * (1.0 - a) ** 3 * (3.0 + a) / 16.0
                slope = slope - side * jump * (1.0 - a) ** 2 * (2.0 + a) / 4.0
                bend = bend + 0.75 * jump / width * (1.0 - a**2)
        return np.asarray(value), np.asarray(slope), np.asarray(bend)

    @cached_property
    def _integrals(self) -> Array:
        """Integral from 0 to the start of every piece."""
        pieces = self.lengths * (self.coefficients @ _POWERS)
        return np.concatenate(([0.0], np.cumsum(pieces)))[:-1]

    def integral(self, s: ArrayLike) -> Array:
        """Integral from 0 to s, exact; constant outside. Only for functions without rounded kinks."""
        s, i = self._locate(s)
        length = self.lengths[i]
        xi = (s - self.starts[i]) / length
        c0, c1, c2, c3 = (self.coefficients[i] * _POWERS).T.reshape((4, *s.shape))
        return np.asarray(self._integrals[i] + length * xi * (c0 + xi * (c1 + xi * (c2 + xi * c3))))

    def jumps(self, derivative: int = 0) -> Array:
        """Jump of the value or the slope at each inner joint, shape (m - 1,)."""
        c, length = self.coefficients, self.lengths
        if derivative == 0:
            return np.asarray(c[1:, 0] - c[:-1].sum(axis=1))
        left = (c[:-1, 1] + 2.0 * c[:-1, 2] + 3.0 * c[:-1, 3]) / length[:-1]
        return np.asarray(c[1:, 1] / length[1:] - left)

    def rounded(self, half_width: float) -> PiecewiseCubic:
        """The function with its kinks rounded over +-half_width [m], never beyond a neighbour."""
        jumps = self.jumps(1)
        scale = np.max(np.abs(self.coefficients), initial=0.0) / np.min(self.lengths)
        width = np.minimum(half_width, np.minimum(self.lengths[:-1], self.lengths[1:]))
        real = np.abs(jumps) > 1e-14 * scale
        if not real.any():
            return self
        kinks = np.zeros((len(self.starts) + 1, 2))
        kinks[:, 1] = half_width
        kinks[1:-1, 0] = np.where(real, jumps, 0.0)
        kinks[1:-1, 1] = width
        return PiecewiseCubic(self.starts, self.lengths, self.coefficients, kinks)

    def breaks(self) -> Array:
        """Distances between which the function is smooth, from 0 to the end."""
        edges = [self.starts, np.array([self.end])]
        if len(self.kinks):
            real = self.kinks[:, 0] != 0.0
            positions, widths = np.append(self.starts, self.end)[real], self.kinks[real, 1]
            edges += [positions - widths, positions + widths]
        return np.unique(np.clip(np.concatenate(edges), 0.0, self.end))


_POWERS = np.array([1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0])
