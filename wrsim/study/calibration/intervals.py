"""What a calibration tells of its keys: intervals, correlations, and what the channels cannot tell."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.special import stdtrit

from wrsim.results.moments import Array
from wrsim.study.calibration.fit import TOLERANCE, Fit
from wrsim.study.calibration.reading import Target

NARROWER = 0.7
"""Part of the interval of the prior, or of the bounds, below which an interval is narrower: below 1 / sqrt 2 the
measurement tells more than was known before."""
TOGETHER = 0.9
"""Coefficient of correlation from which two keys are told together only."""
SHARE = 0.3
"""Part of the largest entry of a direction from which a key belongs to it."""
PROFILE_FITS, PROFILE_STEPS, CLOSE = 4, 4, 0.05
"""Most fits for an end of a profile and their steps; how near the root of its chi2 comes."""


@dataclass(frozen=True)
class Interval:
    """Of one key: value, ends, standard deviation in scaled units, told: whether it is narrower than the prior or the
    bounds; at_bound: ends beyond which the bounds lie."""

    value: float
    low: float
    high: float
    deviation: float
    told: bool
    at_bound: tuple[str, ...] = ()


@dataclass(frozen=True)
class Knowledge:
    """Intervals of all keys; correlation (keys, keys); directions that the channels tell less than the priors, or than
    a quarter of the bounds, each as names with their shares; groups of keys that are told together; chi2 over the
    degrees of freedom; uneven: see `Fit.uneven`."""

    intervals: tuple[Interval, ...]
    correlation: Array
    directions: tuple[dict[str, float], ...]
    groups: tuple[tuple[str, ...], ...]
    misfit: float
    freedom: float
    uneven: tuple[tuple[int, Target], ...]


def knowledge(fit: Fit) -> Knowledge:
    """Intervals by the derivatives at the optimum, with Student's t. Raises SimulationError."""
    u, names = fit.optimum, [var.name for var in fit.calibration.candidates.varied]
    jacobian, residual = fit.derivatives(u, central=True), fit.chi2(u)
    priors = int(np.isfinite(fit.priors).sum())
    counts = sum(t.measured.size / w.neighbours for t, w in zip(fit.targets, fit.weights, strict=True))
    freedom = max(counts + priors - u.size, 1.0)
    misfit = float(residual @ residual) / freedom
    spread = max(misfit, 1.0)
    values, directions = np.linalg.eigh(jacobian.T @ jacobian)
    covariance = spread * (directions / np.maximum(values, 1e-12)) @ directions.T
    deviation = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(deviation, deviation)
    quantile = float(stdtrit(freedom, 0.5 + 0.005 * fit.calibration.spec.confidence_percent))
    ends = np.column_stack([u - quantile * deviation, u + quantile * deviation])
    if fit.calibration.spec.intervals == "profile":
        ends = _profiles(fit, covariance, quantile, spread)
    data = jacobian[: jacobian.shape[0] - priors] / spread**0.5
    _, sizes, axes = np.linalg.svd(data, full_matrices=False)
    weak = tuple(_direction(axis, names) for size, axis in zip(sizes, axes, strict=True) if size < 1.0)
    intervals = tuple(_interval(fit, i, ends[i], float(deviation[i]), quantile) for i in range(u.size))
    groups, uneven = _groups(correlation, names), tuple(fit.uneven(u))
    return Knowledge(intervals, correlation, weak, groups, misfit, freedom, uneven)


def _interval(fit: Fit, i: int, ends: Array, deviation: float, quantile: float) -> Interval:
    scale, bounds = fit.scales[i], (fit.bounds[0][i], fit.bounds[1][i])
    beyond = [name for name, out in (("low", ends[0] <= bounds[0]), ("high", ends[1] >= bounds[1])) if out]
    low, high = np.clip(ends, *bounds)
    whole = 2.0 * quantile if scale.prior is not None else bounds[1] - bounds[0]
    told = bool((ends[1] - ends[0] if scale.prior is not None else high - low) < NARROWER * whole)
    value, low, high = (scale.value(float(v)) for v in (fit.optimum[i], low, high))
    return Interval(value, low, high, deviation, told, tuple(beyond))


def _direction(axis: Array, names: Sequence[str]) -> dict[str, float]:
    """Names and shares of the keys of a direction, the largest share positive."""
    largest = axis[np.argmax(np.abs(axis))]
    shares = {name: float(a / largest) for name, a in zip(names, axis, strict=True)}
    return {name: share for name, share in shares.items() if abs(share) >= SHARE}


def _groups(correlation: Array, names: Sequence[str]) -> tuple[tuple[str, ...], ...]:
    """Keys that hang together by large coefficients of correlation."""
    linked = np.abs(correlation) >= TOGETHER
    groups: list[set[int]] = []
    for i in range(len(names)):
        together = {int(j) for j in np.flatnonzero(linked[i])}
        touched = [g for g in groups if g & together]
        groups = [g for g in groups if not g & together] + [together.union(*touched)]
    return tuple(tuple(names[j] for j in sorted(g)) for g in groups if len(g) > 1)


def _profiles(fit: Fit, covariance: Array, quantile: float, spread: float) -> Array:
    """Ends at which the least chi2 over all other keys is by the square of the quantile above that of the optimum."""
    least = float(np.sum(fit.chi2(fit.optimum) ** 2))
    ends = np.empty((fit.optimum.size, 2))
    for i in range(fit.optimum.size):
        for side, sign in enumerate((-1.0, 1.0)):
            bound = fit.bounds[side][i]
            step = sign * quantile * covariance[i, i] ** 0.5
            low, high = 0.0, np.inf
            for _ in range(PROFILE_FITS):
                place = fit.optimum[i] + step
                beyond = sign * (place - bound) >= 0.0
                step = bound - fit.optimum[i] if beyond else step
                rise = (_others(fit, i, step, covariance) - least) / spread
                root = max(rise, 0.0) ** 0.5
                if abs(root - quantile) < CLOSE * quantile or (beyond and root < quantile):
                    break
                low, high = (max(low, abs(step)), high) if root < quantile else (low, min(high, abs(step)))
                wanted = abs(step) * float(np.clip(quantile / max(root, 1e-6), 0.3, 3.0))
                step = sign * (wanted if low < wanted < high else 0.5 * (low + min(high, 3.0 * abs(step))))
            ends[i, side] = fit.optimum[i] + step
        fit.notify(f"profile of {fit.calibration.candidates.varied[i].name}")
    return ends


def _others(fit: Fit, i: int, step: float, covariance: Array) -> float:
    """Least chi2 over all keys but one, which lies by a step from its optimum."""
    u = np.clip(fit.optimum + covariance[i] / covariance[i, i] * step, *fit.bounds)
    u[i] = fit.optimum[i] + step
    free = [k for k in range(u.size) if k != i]
    if not free:
        return float(np.sum(fit.chi2(u) ** 2))

    def whole(part: Array) -> Array:
        point = u.copy()
        point[free] = part
        return point

    bounds = tuple(b[free] for b in fit.bounds)
    solution = least_squares(
        lambda part: fit.chi2(whole(part)), np.clip(u[free], *bounds),
        lambda part: fit.derivatives(whole(part), keys=free), bounds, xtol=10.0 * TOLERANCE, ftol=10.0 * TOLERANCE,
        gtol=None, max_nfev=PROFILE_STEPS,
    )  # fmt: skip
    return 2.0 * float(solution.cost)
