"""Estimated values by regression over the sections of a class of track: the two-dimensional method of EN 14363 and
UIC 518 [mem], with one influence or several.

The values y of n sections are fitted by y = b_0 + sum b_j (x_j - x_j0) over influences x (cant deficiency, curvature,
speed), with x_0 the place at which the value is estimated. With X the matrix of 1 and x - x_0, p columns, and s^2 the
squared residuals over n - p,

    estimated value = b_0 + t s sqrt(1 + [(X'X)^-1]_00),

the upper bound of one more section at x_0: t is the quantile of Student's distribution of n - p degrees of freedom at
the probability that belongs to the factor k of the one-dimensional method (mean + k s) in a normal distribution. So
without influences, and with many sections, it is that method. Quasi-static values have k = 0: the fit itself.
Source of bounds for one more observation: any text on linear regression, such as Draper and Smith, Applied Regression
Analysis (1998), section 3.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, stdtrit

Array = NDArray[np.float64]

Influence = Literal["cant_deficiency", "curvature", "speed"]

SHOWN: dict[Influence, tuple[str, float]] = {
    "cant_deficiency": ("mm", 1e3),
    "curvature": ("1/km", 1e3),
    "speed": ("km/h", 3.6),
}
"""Unit and factor in which people read an influence."""

SPREAD = 1e-6
"""An influence that varies by less, as a part of its size, is none."""

SPARE = 3
"""So many sections more than coefficients are needed."""


@dataclass(frozen=True, eq=False)
class Regression:
    """over: influences that the sections differ in; at: where the value is estimated; slope: of the value, for each of
    them; fit: value there; deviation: s; estimate: the upper bound. For pictures: places (n,) of the sections along the
    first influence, and their values (n,) moved to where the others are when estimated. SI units.
    """

    over: tuple[Influence, ...]
    at: tuple[float, ...]
    slope: tuple[float, ...]
    fit: float
    deviation: float
    estimate: float
    places: Array
    moved: Array


def regression(
    values: Array,
    known: Mapping[Influence, Array],
    over: Sequence[Influence],
    at: Mapping[Influence, float],
    k: float,
) -> Regression | None:
    """Fit the values (n,) of sections, and estimate one at a place.

    known: influences (n,) on the sections; over: those to go by; those that the sections do not differ in are left out.
    at: where to; the largest of the sections unless given. k: factor of the one-dimensional method. None with too few
    sections, or where the influences cannot be told apart.
    """
    differ = [name for name in over if np.ptp(known[name]) > SPREAD * max(np.abs(known[name]).max(), 1e-12)]
    place = tuple(float(at.get(name, known[name].max())) for name in differ)
    columns = [(known[name] - x0) / np.ptp(known[name]) for name, x0 in zip(differ, place, strict=True)]
    matrix = np.column_stack([np.ones(values.size), *columns])
    freedom = values.size - matrix.shape[1]
    if freedom < SPARE or np.linalg.matrix_rank(matrix, tol=1e-6 * values.size**0.5) < matrix.shape[1]:
        return None
    found = np.linalg.lstsq(matrix, values, rcond=None)[0]
    deviation = float(np.sqrt(np.sum((values - matrix @ found) ** 2) / freedom))
    leverage = float(np.linalg.inv(matrix.T @ matrix)[0, 0])
    quantile = float(stdtrit(freedom, ndtr(k)))
    slope = tuple(float(b / np.ptp(known[name])) for b, name in zip(found[1:], differ, strict=True))
    fit = float(found[0])
    estimate = fit + quantile * deviation * float(np.sqrt(1.0 + leverage))
    others = matrix[:, 2:] @ found[2:]
    places = known[differ[0]] if differ else np.zeros(values.size)
    return Regression(tuple(differ), place, slope, fit, deviation, estimate, places, values - others)
