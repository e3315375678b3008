"""Equivalent conicity by EN 15302: the cone that would give a wheelset the wavelength it has on its real profiles.

The centre of an unyawed, massless wheelset that rolls without slip follows

    y'' + Delta r(y) / (2 e r0) = 0,    Delta r = r_left - r_right,

with 2 e = 1.5 m between the contact points and r0 the mean radius. It swings about the place where Delta r = 0. The
first integral of the equation is y'^2 / 2 + P(y) = E with P the integral of Delta r / (2 e r0), so the wavelength of
a swing from y1 to y2 with P(y1) = P(y2) = E is a quadrature,

    lambda = 2 int_y1^y2 dy / sqrt(2 (E - P(y))),

and the equivalent conicity at the amplitude (y2 - y1) / 2 is that of Klingel's cone,

    tan(gamma_e) = (2 pi / lambda)^2 e r0.

No time steps, no tolerance: the quadrature is the exact solution for the piecewise linear Delta r given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PPoly
from scipy.optimize import brentq

from wrsim.results.conicity import CONTACT_DISTANCE, Array

POINTS = 2000  # of the quadrature over a swing


@dataclass(frozen=True, eq=False)
class EquivalentConicity:
    """tan(gamma_e) and wavelength [m] over the amplitude [m], all (m,); not-a-number where the wheelset does not swing
    to and fro with that amplitude. equilibrium: lateral shift with equal rolling radii [m]."""

    amplitude: Array
    conicity: Array
    wavelength: Array
    equilibrium: float


def equivalent_conicity(
    shift: Array, radius_difference: Array, mean_radius: float, amplitude: ArrayLike
) -> EquivalentConicity:
    """Equivalent conicity of a rolling radius difference given at rising shifts (n,), linear in between.

    Not-a-number in ``radius_difference`` (a wheel beside its rail) bounds the range. The equilibrium is the one at the
    foot of the deepest well of P.
    """
    amplitude = np.atleast_1d(np.asarray(amplitude, dtype=float))
    nothing = np.full(amplitude.shape, np.nan)
    known = np.ma.flatnotmasked_contiguous(np.ma.masked_invalid(radius_difference))
    part = max(known, key=lambda own: own.stop - own.start, default=slice(0, 0))
    y, rate = shift[part], radius_difference[part] / (CONTACT_DISTANCE * mean_radius)
    if y.size < 3:
        return EquivalentConicity(amplitude, nothing, nothing, np.nan)
    slope = np.diff(rate) / np.diff(y)
    potential = PPoly(np.array([slope, rate[:-1]]), y).antiderivative()
    # P is lowest at an end of the range or where the rate crosses zero upwards
    crossing = np.flatnonzero((rate[:-1] <= 0.0) & (rate[1:] > 0.0))
    places = y[crossing] - rate[crossing] / slope[crossing]
    bottom = float(places[np.argmin(potential(places))]) if places.size else np.nan
    wavelength = np.array([_wavelength(potential, bottom, a) for a in amplitude])
    conicity = (2.0 * np.pi / wavelength) ** 2 * 0.5 * CONTACT_DISTANCE * mean_radius
    return EquivalentConicity(amplitude, conicity, wavelength, bottom)


def _wavelength(potential: PPoly, bottom: float, amplitude: float) -> float:
    """Of the swing of this amplitude about the bottom of the potential P; not-a-number when there is none."""
    low = max(bottom - 2.0 * amplitude, float(potential.x[0]))
    high = min(bottom, float(potential.x[-1]) - 2.0 * amplitude)

    def unbalance(start: float) -> float:
        return float(potential(start + 2.0 * amplitude) - potential(start))

    if not low < high or unbalance(low) > 0.0 or unbalance(high) < 0.0:
        return np.nan
    start = brentq(unbalance, low, high, xtol=1e-16)
    angle = (np.arange(POINTS) + 0.5) * np.pi / POINTS
    left = 2.0 * (potential(start) - potential(start + amplitude * (1.0 - np.cos(angle))))
    if (left <= 0.0).any():
        return np.nan
    return float(2.0 * np.pi / POINTS * np.sum(amplitude * np.sin(angle) / np.sqrt(left)))
