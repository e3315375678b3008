"""Least squares of a calibration: candidates, weights of the series, derivatives.

Minimised is chi2 = sum over the targets i of w_i |m_i(x) - y_i|^2 / (s_i^2 t_i) + sum over the priors of
((x - x0) / s0)^2. s_i: noise; t_i: integrated autocorrelation of the residual, so that of neighbours that go together
only every t-th counts; w_i: weight of the scenario. Noise that is not given and t_i come from the residual: the least
squares run again with them until they change no more.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import exp, log
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from wrsim.errors import SimulationError
from wrsim.results import Result
from wrsim.results.moments import Array
from wrsim.study.calibration.reading import Calibration, Target
from wrsim.study.candidates import Candidate
from wrsim.study.measurement.alignment import Shift
from wrsim.study.task import Work

STEP = 0.25
"""Step of the derivatives, in the scale of a key: the standard deviation of its prior, or a quarter of its bounds. Runs
have small jumps over their keys, where a contact begins or ends between two steps; against those it is large."""
ROUNDS, CHANGED, STILL = 6, 0.05, 2e-3
"""Most rounds of weights; change of a weight, and of a scaled key, by which another one is needed."""
LEAST_NOISE = 1e-4
"""Least noise of a series without a given one, of its largest value: a model that is exact has no residual."""
TOLERANCE = 3e-4
"""Change of the scaled keys, and of chi2, at which the least squares end."""
FIRST_NOISE = 0.1
"""Largest noise that is not given in the first round, over the spread of the series: the misfit of a start is no noise,
and would leave the keys at their priors."""
FACTOR = 2.0
"""By which derivatives over a key may change from one step to the next."""
FAR = 10.0
"""Norm of the residual of a candidate without a result, over that at the start."""


class Weight(NamedTuple):
    """noise: standard deviation in SI units; neighbours: integrated autocorrelation t; rms: of the residual."""

    noise: float
    neighbours: float
    rms: float


@dataclass(frozen=True)
class Scale:
    """A key as it is searched: u = (g(x) - g(start)) / size, g the logarithm where steps are even in that."""

    start: float
    size: float
    log: bool
    prior: float | None

    def value(self, u: float) -> float:
        """The number of the key."""
        g = (log(self.start) if self.log else self.start) + self.size * u
        return exp(g) if self.log else g

    def scaled(self, x: float) -> float:
        """u of a number of the key."""
        return (log(x) - log(self.start) if self.log else x - self.start) / self.size


def autocorrelation_time(residual: Array) -> float:
    """1 + 2 sum of the coefficients of autocorrelation up to the first below 0; 1 for white noise."""
    n = residual.size
    centred = residual - residual.mean()
    power = float(centred @ centred)
    if n < 4 or power == 0.0:
        return 1.0
    size = 2 ** int(np.ceil(np.log2(2 * n)))
    spectrum = np.fft.rfft(centred, size)
    rho = np.fft.irfft(spectrum * spectrum.conj(), size)[1 : n // 2] / power
    below = np.flatnonzero(rho < 2.0 / n**0.5)  # what white noise has by chance
    return 1.0 + 2.0 * float(rho[: below[0] if below.size else rho.size].sum())


@dataclass(eq=False)
class Fit:
    """A calibration while it runs, and its end: u at the optimum, weights, shifts, targets."""

    calibration: Calibration
    work: Work
    notify: Callable[[str], None]
    scales: tuple[Scale, ...] = ()
    targets: list[Target] = field(default_factory=list)
    weights: list[Weight] = field(default_factory=list)
    shifts: dict[str, Shift] = field(default_factory=dict)
    start: Array = field(default_factory=lambda: np.zeros(0))
    optimum: Array = field(default_factory=lambda: np.zeros(0))
    converged: bool = False
    rounds: int = 0
    worst: float = 1.0
    _models: dict[tuple[object, ...], list[Array] | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        spec, varied = self.calibration.spec.vary, self.calibration.candidates.varied
        scales = []
        for var, key in zip(varied, spec, strict=True):
            low, high = (log(v) if var.log else v for v in (var.low, var.high))
            size = 0.25 * (high - low)
            if key.prior is not None and key.tolerance is not None:
                size = 0.5 * key.tolerance / (key.prior if var.log else 1.0)
            scales.append(Scale(var.start, size, var.log, key.prior))
        self.scales = tuple(scales)
        self.bounds = tuple(
            np.array([scale.scaled(getattr(var, end)) for scale, var in zip(scales, varied, strict=True)])
            for end in ("low", "high")
        )
        self.priors = np.array([np.nan if s.prior is None else s.scaled(s.prior) for s in scales])

    @property
    def candidates(self) -> int:
        """How many candidates were evaluated."""
        return len(self._models)

    def values(self, u: Sequence[float] | Array) -> tuple[float, ...]:
        """Numbers of the keys."""
        return tuple(scale.value(float(x)) for scale, x in zip(self.scales, u, strict=True))

    def evaluated(self, points: Sequence[Array]) -> list[Candidate]:
        """The candidates at some points."""
        return self.calibration.candidates.evaluated([self.values(u) for u in points], self.work)

    def models(self, points: Sequence[Array]) -> list[list[Array] | None]:
        """Values of the targets at some points; None of a candidate without a result."""
        rows = [self.calibration.candidates.values(self.values(u)) for u in points]
        if new := {row: u for row, u in zip(rows, points, strict=True) if row not in self._models}:
            for candidate in self.evaluated([*new.values()]):
                results = _results(candidate)
                model = self.calibration.model(results, self.targets) if results else None
                self._models[candidate.values] = model
        return [self._models[row] for row in rows]

    def residual(self, model: Sequence[Array], u: Array) -> Array:
        """Weighted residual of all targets and priors."""
        parts = [
            (m - t.measured) * (t.weight**0.5 / (w.noise * w.neighbours**0.5))
            for m, t, w in zip(model, self.targets, self.weights, strict=True)
        ]
        return np.concatenate([*parts, (u - self.priors)[np.isfinite(self.priors)]])

    def chi2(self, u: Array) -> Array:
        """Weighted residual at a point; far away where the candidate has no result."""
        (model,) = self.models([u])
        if model is None:
            size = sum(t.measured.size for t in self.targets) + int(np.isfinite(self.priors).sum())
            return np.full(size, FAR * self.worst / size**0.5)
        return self.residual(model, u)

    def derivatives(self, u: Array, central: bool = False, keys: Sequence[int] | None = None) -> Array:
        """Derivatives of the weighted residual (n, keys) by differences. Raises SimulationError where no neighbour of a
        point has a result."""
        columns = range(u.size) if keys is None else keys
        steps = [
            s * STEP * np.eye(u.size)[i] for i in columns for s in ((1.0, -1.0) if central else (self._side(u, i),))
        ]
        within = [np.clip(u + step, *self.bounds) for step in steps]
        models = self.models([u, *within])
        failed = [k for k, model in enumerate(models[1:]) if model is None]  # tried on the other side
        if failed and not central:
            for k, model in zip(failed, self.models([2.0 * u - within[k] for k in failed]), strict=True):
                within[k], models[1 + k] = 2.0 * u - within[k], model
        residuals = [None if m is None else self.residual(m, p) for m, p in zip(models, [u, *within], strict=True)]
        jacobian = []
        for place, i in enumerate(columns):
            ends = [(0, u)] + [(1 + k, within[k]) for k in range(place * (1 + central), (place + 1) * (1 + central))]
            pairs = [(residuals[k], p[i]) for k, p in ends if residuals[k] is not None]
            pairs = pairs[1:] if central and len(pairs) == 3 else pairs
            if len(pairs) < 2 or pairs[0][1] == pairs[-1][1]:
                name = self.calibration.candidates.varied[i].name
                raise SimulationError(
                    f"{name}: no derivative: candidates beside {self.values(u)[i]:.6g} have no result"
                )
            (first, a), (last, b) = pairs[0], pairs[-1]
            jacobian.append((last - first) / (b - a))  # type: ignore[operator]
        return np.column_stack(jacobian)

    def uneven(self, u: Array) -> list[tuple[int, Target]]:
        """Keys, and series of which the derivatives over them do not hold: between the steps to both sides of a point
        they change by a factor of two, and by more than their noise."""
        rows = []
        for i, step in enumerate(STEP * np.eye(u.size)):
            points = [np.clip(u + side, *self.bounds) for side in (-step, step)]
            before, middle, behind = self.models([points[0], u, points[1]])
            if before is None or middle is None or behind is None or not points[0][i] < u[i] < points[1][i]:
                continue
            for target, weight, *values in zip(self.targets, self.weights, before, middle, behind, strict=True):
                low, high = (float(np.linalg.norm(b - a)) / weight.noise for a, b in pairwise(values))
                low, high = sorted((low / (u - points[0])[i], high / (points[1] - u)[i]))
                if high > max(FACTOR * low, 1.0 / STEP):
                    rows.append((i, target))
        return rows

    def _side(self, u: Array, i: int) -> float:
        return -1.0 if u[i] + STEP > self.bounds[1][i] else 1.0

    def begin(self) -> None:
        """Targets and weights at the start. Raises SimulationError where that has no result."""
        u = np.zeros(len(self.scales))
        (candidate,) = self.evaluated([u])
        if not candidate.completed:
            raise SimulationError(f"the start has no result: {candidate.message}")
        self.start, results = u, _results(candidate)
        self.shifts = self.calibration.shifts(results)
        self.targets = self.calibration.targets(results, self.shifts)
        self._weigh(u, [], 0)

    def _weigh(self, u: Array, before: Sequence[Weight], keys: int) -> bool:
        """New weights from the residual at a point; whether they are those before."""
        (model,) = self.models([u])
        assert model is not None
        weights = []
        for m, target in zip(model, self.targets, strict=True):
            off = m - target.measured
            t = autocorrelation_time(off) if target.neighbours else 1.0
            free = max(1.0 - keys * t / off.size, 0.1)
            rms = float(np.sqrt(np.mean(off**2) / free))
            floor = LEAST_NOISE * float(np.abs(target.measured).max()) + 1e-300
            if not before:
                t, spread = 1.0, float(target.measured.std())
                rms = min(rms, FIRST_NOISE * spread) if spread > 0.0 else rms
            weights.append(Weight(max(rms, floor) if target.noise is None else target.noise, t, rms))
        self.weights = weights
        pairs = zip(before, weights, strict=False)
        return bool(before) and all(
            abs(log(b.noise / a.noise)) < CHANGED and abs(log(b.neighbours / a.neighbours)) < 4 * CHANGED
            for a, b in pairs
        )

    def run(self) -> None:
        """Rounds of least squares until the weights change no more."""
        u, keys = self.start.copy(), len(self.scales)
        self.worst = float(np.linalg.norm(self.chi2(u)))
        for self.rounds in range(1, ROUNDS + 1):
            solution = least_squares(
                self.chi2, np.clip(u, *self.bounds), self.derivatives, self.bounds, xtol=TOLERANCE, ftol=TOLERANCE,
                gtol=None, max_nfev=self.calibration.spec.iterations,
            )  # fmt: skip
            moved = float(np.abs(solution.x - u).max())
            u, before = solution.x, self.weights
            same = self._weigh(u, before, keys) or moved < STILL
            values = ", ".join(
                f"{s.name} {v:.5g}" for s, v in zip(self.calibration.candidates.varied, self.values(u), strict=True)
            )
            self.notify(f"round {self.rounds}, {solution.nfev} steps: {values}")
            if same:
                break
        self.optimum, self.converged = u, bool(solution.status > 0 and same)
        self.shifts = self.calibration.shifts(_results(self.evaluated([u])[0]))


def _results(candidate: Candidate) -> dict[str, Result]:
    """The results of a candidate by scenario; none where one of them did not come to its end."""
    return {name: Result(case.dataset()) for name, case in candidate.cases.items()} if candidate.completed else {}
