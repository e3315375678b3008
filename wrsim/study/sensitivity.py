"""Which keys decide on an output: designs of cases for Sobol's indices, Morris' effects and regression, and these.

Numbers of keys d, samples n. Designs are rows of numbers between 0 and 1, which `sampled_values` makes values of keys:

- sobol: matrices A and B of n scrambled Sobol points, and A with one column after the other from B: n (d + 2) cases.
  First and total indices (Saltelli 2010, Jansen 1999), as scipy has them, intervals by bootstrap.
- morris: n trajectories along which one key moves at a time: n (d + 1) cases. mu*, the mean magnitude of the effects
  over the ranges, and their deviation sigma (Campolongo 2007), as SALib has them.
- regression: a Latin hypercube of n cases. Standardised coefficients of a linear fit, intervals by Student's t.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from wrsim.errors import InputError, suggest
from wrsim.results.table import finite
from wrsim.study.axes import AxisPoints, sampled_values
from wrsim.study.spec import SensitivitySection

Array = NDArray[np.float64]

CONFIDENCE = 0.95
RESAMPLES = 400
"""Samples of a bootstrap: ends of an interval scatter by a tenth of its length then."""
LEVELS = 4
"""Values that a key takes in trajectories of Morris."""
FLAT = 1e-9
"""Range of an output over its largest magnitude below which it does not vary: rounding errors of a case."""


@dataclass(frozen=True)
class Sensitivity:
    """Indices of one output (keys, 3) by their kind: value with lower and upper end of its interval; note: why there
    are none, or what there is to say."""

    output: str
    indices: Mapping[str, Array] = field(default_factory=dict)
    note: str = ""


def design(spec: SensitivitySection) -> Array:
    """Rows of the cases (cases, keys), from 0 to 1. Raises InputError without SALib where it is needed."""
    n, d = spec.samples, len(spec.over)
    if spec.method == "regression":
        return np.asarray(scipy.stats.qmc.LatinHypercube(d, rng=np.random.default_rng(spec.seed)).random(n))
    if spec.method == "morris":
        sample, _ = _morris()
        return np.asarray(sample(_problem(d), n, num_levels=LEVELS, seed=spec.seed))
    samples = scipy.stats.qmc.Sobol(2 * d, rng=np.random.default_rng(spec.seed)).random(n)
    a, b = samples[:, :d], samples[:, d:]
    mixed = np.repeat(a[None], d, axis=0)
    for i in range(d):
        mixed[i, :, i] = b[:, i]
    return np.concatenate([a, b, *mixed])


def axis_of(spec: SensitivitySection, where: str) -> AxisPoints:
    """The cases of a design as an axis of a study; where: file and line, for messages."""
    columns = (sampled_values(part, key) for part, key in zip(design(spec).T, spec.over, strict=True))
    values = tuple(zip(*columns, strict=True))
    return AxisPoints(spec.name, tuple(key.key for key in spec.over), values, (where,) * len(values), listed=True)


def sensitivity(spec: SensitivitySection, name: str, values: Array) -> Sensitivity:
    """How the keys decide on an output. values (cases,): in the order of `design`, not-a-number where there is none."""
    n, d = spec.samples, len(spec.over)
    good = np.isfinite(values)
    enough = good.sum() >= d + 3 if spec.method == "regression" else good.all()
    why = "" if enough else f"{int((~good).sum())} of {values.size} cases have no value"
    if not why and float(np.ptp(values[good])) <= FLAT * float(np.abs(values[good]).max()):
        why = f"does not vary: {values[good][0]:.6g} in every case"
    if why:
        return Sensitivity(name, note=why)
    rows = design(spec)
    if spec.method == "regression":
        coefficients, explained = _regression(rows[good], values[good])
        return Sensitivity(
            name, {"coefficient": coefficients}, f"a linear fit explains {100.0 * explained:.0f} % of the variance"
        )
    if spec.method == "morris":
        _, analyse = _morris()
        effects = analyse(_problem(d), rows, values, conf_level=CONFIDENCE, num_levels=LEVELS, seed=spec.seed)
        mean, half, sigma = (np.asarray(effects[key], dtype=float) for key in ("mu_star", "mu_star_conf", "sigma"))
        empty = np.full(d, np.nan)
        columns = {"mu_star": [mean, mean - half, mean + half], "sigma": [sigma, empty, empty]}
        return Sensitivity(name, {kind: np.stack(each, axis=1) for kind, each in columns.items()})
    f_a, f_b, *f_ab = values.reshape(d + 2, 1, n)
    parts = {"f_A": f_a, "f_B": f_b, "f_AB": np.stack(f_ab)}

    def indices(rows: NDArray[np.int64]) -> Array:
        result = scipy.stats.sobol_indices(func={part: each[..., rows] for part, each in parts.items()}, n=n)
        return np.stack([np.ravel(result.first_order), np.ravel(result.total_order)])

    generator, ends = np.random.default_rng(spec.seed), 50.0 * (1.0 + CONFIDENCE * np.array([-1.0, 1.0]))
    drawn = [indices(generator.integers(n, size=n)) for _ in range(RESAMPLES)]
    first, total = np.stack([indices(np.arange(n)), *np.percentile(drawn, ends, axis=0)], axis=2)
    return Sensitivity(name, {"first": first, "total": total})


def _regression(rows: Array, values: Array) -> tuple[Array, float]:
    """Standardised coefficients (keys, 3) with their intervals, and the part of the variance that they explain."""
    matrix = np.column_stack([np.ones(len(rows)), (rows - rows.mean(axis=0)) / rows.std(axis=0)])
    scaled = (values - values.mean()) / values.std()
    fit = np.linalg.lstsq(matrix, scaled, rcond=None)[0]
    left = float(np.sum((scaled - matrix @ fit) ** 2))
    freedom = matrix.shape[0] - matrix.shape[1]
    error = np.sqrt(left / freedom * np.diag(np.linalg.inv(matrix.T @ matrix)))
    half = scipy.stats.t.ppf(0.5 + 0.5 * CONFIDENCE, freedom) * error
    return np.stack([fit, fit - half, fit + half], axis=1)[1:], 1.0 - left / scaled.size


def _problem(d: int) -> dict[str, Any]:
    return {"num_vars": d, "names": [str(i) for i in range(d)], "bounds": [[0.0, 1.0]] * d}


def _morris() -> tuple[Any, Any]:
    try:
        from SALib.analyze import morris as analysis
        from SALib.sample import morris as sampling
    except ImportError:
        raise InputError('method = "morris" needs SALib: pip install "wrsim[type-test]"') from None
    return sampling.sample, analysis.analyze


def sensitivities(spec: SensitivitySection, outputs: Mapping[str, Array]) -> dict[str, Any]:
    """Indices of the outputs that are asked for, or of all, as `wrsim.results.sensitivity` has them."""
    results = [
        sensitivity(spec, name, outputs[name])
        if name in outputs
        else Sensitivity(name, note=f"is no output{suggest(name, list(outputs))}; there are {', '.join(outputs)}")
        for name in spec.outputs or outputs
    ]
    rows = [
        {"output": result.output, "key": key.key[0], "index": kind}
        | dict(zip(("value", "low", "high"), map(finite, numbers), strict=True))
        for result in results
        for kind, each in result.indices.items()
        for key, numbers in zip(spec.over, each.tolist(), strict=True)
    ]
    return {
        "method": spec.method,
        "indices": rows,
        "notes": {result.output: result.note for result in results if result.note},
    }
