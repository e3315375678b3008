"""Every quantity over the sections of a class of track: its worst value, and its estimated maximum.

That is the mean plus k standard deviations, or comes by regression: the two-dimensional method of EN 14363 and UIC 518
[mem], with one influence or several.

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

import math
from collections.abc import Mapping, Sequence
from typing import get_args

import numpy as np
from scipy.special import ndtr, stdtrit

from wrsim.assessment.limits import SAFETY
from wrsim.assessment.outcome import TRANSITION, Array, AssessedSection, Influence, Regression, Value, ZoneValue
from wrsim.assessment.rules import StatisticsSection
from wrsim.assessment.settings import AssessmentSettings

SPREAD = 1e-6  # an influence that varies by less, as a part of its size, is none
SPARE = 3  # so many sections more than coefficients are needed


def zones_of(
    values: Sequence[Value], settings: AssessmentSettings, statistics: StatisticsSection | None
) -> list[ZoneValue]:
    """Every quantity over every zone: quantities in the order in which they come, zones in that of the track."""
    groups: dict[tuple[str, str], list[Value]] = {}
    first = {v.section.zone: v.section.number for v in sorted(values, key=lambda v: -v.section.number)}
    keys = list(dict.fromkeys(v.quantity.key for v in values))
    for value in sorted(values, key=lambda v: (keys.index(v.quantity.key), first[v.section.zone])):
        groups.setdefault((value.quantity.key, value.section.zone), []).append(value)
    return [_zone(members, settings, statistics) for members in groups.values()]


def _zone(values: Sequence[Value], settings: AssessmentSettings, statistics: StatisticsSection | None) -> ZoneValue:
    sign = -1.0 if values[0].quantity.lowest else 1.0
    worst = min(values, key=lambda v: -sign * v.value if v.margin is None else v.margin)
    largest: dict[AssessedSection, float] = {}
    for v in values:
        if v.section.counts:
            largest[v.section] = max(largest.get(v.section, -math.inf), sign * v.value)
    per_section = sign * np.array(list(largest.values()))
    mean = float(per_section.mean()) if per_section.size > 0 else math.nan
    deviation = float(per_section.std(ddof=1)) if per_section.size > 1 else 0.0
    estimate, fitted = None, None
    if statistics is not None and per_section.size >= statistics.sections and np.isfinite(per_section).all():
        k = statistics.safety if worst.quantity.group == SAFETY else statistics.others
        k = 0.0 if worst.quantity.quasi_static else sign * k
        if settings.estimate_over and worst.section.zone != TRANSITION:
            # what sections differ in: cant deficiency [m], curvature without its hand [1/m], speed [m/s]
            each = [(s.cant_deficiency, abs(1.0 / s.radius), s.speed) for s in largest]
            known = dict(zip(get_args(Influence), np.array(each).T, strict=True))
            fitted = regression(per_section, known, settings.estimate_over, settings.estimate_at, k)
            estimate = None if fitted is None else fitted.estimate
        elif k:
            estimate = mean + k * deviation
    return ZoneValue(worst, len({v.section for v in values}), per_section.size, mean, deviation, estimate, fitted)


def regression(
    values: Array, known: Mapping[Influence, Array], over: Sequence[Influence], point: Mapping[Influence, float],
    k: float,
) -> Regression | None:  # fmt: skip
    """Fit the values (n,) of sections, and estimate one at a place.

    known: influences (n,) on the sections; over: those to go by; those that the sections do not differ in are left out.
    point: where to; the largest of the sections unless given. k: factor of the one-dimensional method. None with too
    few sections, or where the influences cannot be separated.
    """
    differ = [name for name in over if np.ptp(known[name]) > SPREAD * max(np.abs(known[name]).max(), 1e-12)]
    place = tuple(float(point.get(name, known[name].max())) for name in differ)
    columns = [(known[name] - x0) / np.ptp(known[name]) for name, x0 in zip(differ, place, strict=True)]
    matrix = np.column_stack([np.ones(values.size), *columns])
    freedom = values.size - matrix.shape[1]
    if freedom < SPARE or np.linalg.matrix_rank(matrix, tol=1e-6 * values.size**0.5) < matrix.shape[1]:
        return None
    coefficients = np.linalg.lstsq(matrix, values, rcond=None)[0]
    deviation = float(np.sqrt(np.sum((values - matrix @ coefficients) ** 2) / freedom))
    leverage = float(np.linalg.inv(matrix.T @ matrix)[0, 0])
    quantile = float(stdtrit(freedom, ndtr(k)))
    slope = tuple(float(b / np.ptp(known[name])) for b, name in zip(coefficients[1:], differ, strict=True))
    fit = float(coefficients[0])
    estimate = fit + quantile * deviation * float(np.sqrt(1.0 + leverage))
    contribution = matrix[:, 2:] @ coefficients[2:]
    places = known[differ[0]] if differ else np.zeros(values.size)
    return Regression(tuple(differ), place, slope, fit, deviation, estimate, places, values - contribution)
