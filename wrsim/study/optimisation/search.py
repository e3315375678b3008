"""Searches for the best candidate.

Candidates are compared as K. Deb does (An efficient constraint handling method for genetic algorithms, Computer Methods
in Applied Mechanics and Engineering 186, 2000): one that keeps all constraints is better than one that does not, of two
that keep them the one of lower cost is, of two that do not the one that exceeds them less, as parts of the limits; a
candidate without a result is behind all others. No factor weighs costs against constraints.

Several keys: covariance matrix adaptation (N. Hansen, The CMA evolution strategy: a tutorial, 2016), which is told
costs in that order. One key: Brent's method between bounds. A Pareto front: the first cost is minimised with a ceiling
on the second one (epsilon-constraint), from end to end of the front: weighted sums find no point of a concave part.

Samples come from a generator of the search, costs from markers on disk: a search that was killed takes the same way.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from types import ModuleType
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from wrsim.errors import InputError
from wrsim.study.optimisation.reading import Judged, Optimisation
from wrsim.study.task import Work


class Goal(NamedTuple):
    """Which cost is minimised; ceiling of the other one and the length of its axis, for points of a front."""

    cost: int = 0
    ceiling: float = np.inf
    length: float = 1.0

    def excess(self, judged: Judged) -> float:
        """By how much constraints and ceiling are exceeded."""
        over = 0.0 if np.isinf(self.ceiling) else max(judged.costs[1 - self.cost] - self.ceiling, 0.0) / self.length
        return judged.violation + over

    def order(self, judged: Judged) -> tuple[int, float]:
        """Smaller for the better candidate."""
        if not judged.complete:
            return 2, 0.0
        excess = self.excess(judged)
        return (1, excess) if excess > 0.0 else (0, judged.costs[self.cost])


LEAST = Goal()
"""The first cost, or the only one."""


@dataclass
class Search:
    """What has been evaluated, and why the search ended."""

    optimisation: Optimisation
    work: Work
    notify: Callable[[str], None] = lambda line: None
    known: dict[tuple[object, ...], Judged] = field(default_factory=dict)
    ends: list[str] = field(default_factory=list)

    def evaluate(self, points: Sequence[Sequence[float]]) -> list[Judged]:
        """What the candidates at some points come to."""
        before = len(self.known)
        candidates = self.optimisation.candidates.evaluated(points, self.work)
        for candidate in candidates:
            if candidate.values not in self.known:
                self.known[candidate.values] = self.optimisation.judged(len(self.known) + 1, candidate)
        if len(self.known) > before:
            self.notify(f"{len(self.known)} candidates, best: {self._text(self.best())}")
        return [self.known[candidate.values] for candidate in candidates]

    def _text(self, judged: Judged) -> str:
        costs = self.optimisation.shown(judged)
        if not judged.complete:
            return "none has a result"
        if judged.violation:
            return f"none keeps all constraints, {judged.violation:.3g} beyond"
        return ", ".join(f"{name} {cost:.6g}" for name, cost in costs.items())

    def best(self, goal: Goal = LEAST) -> Judged:
        """The best candidate of all, the first of several alike."""
        return min(self.known.values(), key=goal.order)

    def point(self, judged: Judged) -> tuple[float, ...]:
        """The numbers of a candidate's values."""
        pairs = zip(self.optimisation.candidates.varied, judged.candidate.values, strict=True)
        return tuple(float(var.choices.index(value)) if var.choices else float(value) for var, value in pairs)

    def run(self) -> None:
        """Search to the end."""
        spec = self.optimisation.spec.search
        self.evaluate([self.optimisation.candidates.start])
        if spec.front is None:
            self._minimise(LEAST, spec.evaluations)
            return
        share = spec.evaluations // spec.front
        ends = []
        for cost in (0, 1):
            self._minimise(Goal(cost), len(self.known) + share)
            ends.append(self.best(Goal(cost)))
        low, high = ends[1].costs[1], ends[0].costs[1]
        if not all(end.feasible for end in ends) or not low < high:
            self.ends.append("no front: one candidate is the best in both objectives, or none keeps the constraints")
            return
        for ceiling in np.linspace(high, low, spec.front)[1:-1].tolist():
            self._minimise(Goal(0, ceiling, high - low), len(self.known) + share)

    def front(self) -> list[Judged]:
        """Candidates than which none is better in one objective and not worse in the other, by the first one."""
        feasible = sorted((trial for trial in self.known.values() if trial.feasible), key=lambda trial: trial.costs)
        front: list[Judged] = []
        for trial in feasible:
            if not front or trial.costs[1] < front[-1].costs[1]:
                front.append(trial)
        return front

    def _minimise(self, goal: Goal, most: int) -> None:
        """Search for one goal until so many candidates are known."""
        method = _bounded if len(self.optimisation.candidates.varied) == 1 else _cma
        self.ends.append(method(self, goal, most))


def _bounded(search: Search, goal: Goal, most: int) -> str:
    """Brent's method on the one key; the bounds count, which it never evaluates. Gives why it ended."""
    (varied,), spec = search.optimisation.candidates.varied, search.optimisation.spec.search
    feasible = [judged.costs[goal.cost] for judged in search.evaluate([[varied.low], [varied.high]]) if judged.feasible]
    worst = max(feasible, default=0.0)

    def merit(share: float) -> float:
        nonlocal worst
        (judged,) = search.evaluate([[varied.number(float(share))]])
        place, value = goal.order(judged)
        worst = max(worst, value) if place == 0 else worst
        return (value, worst + value, np.inf)[place]

    options = {"xatol": spec.tolerance, "maxiter": max(most - len(search.known), 1)}
    with np.errstate(invalid="ignore"):  # a parabola through a candidate without a result is none
        end = minimize_scalar(merit, bounds=(0.0, 1.0), method="bounded", options=options)
    return "converged" if end.success else "evaluations used up"


def _cma(search: Search, goal: Goal, most: int) -> str:
    """Covariance matrix adaptation from the best that is known, and its restarts. Gives why it ended.

    Its coordinates are shares of the way between the bounds; of whole numbers and choices the numbers, which it samples
    no closer than their steps."""
    cma = cma_package()
    varied, spec = search.optimisation.candidates.varied, search.optimisation.spec.search
    generator = np.random.default_rng((spec.seed, len(search.ends)))
    stepped = [i for i, var in enumerate(varied) if var.stepped]
    low = np.array([var.low - 0.499 if var.stepped else 0.0 for var in varied])
    high = np.array([var.high + 0.499 if var.stepped else 1.0 for var in varied])
    best = search.point(search.best(goal))
    start = np.array([x if var.stepped else var.share(x) for var, x in zip(varied, best, strict=True)])
    population, why = spec.generation(len(varied)), ""
    for restart in range(spec.restarts + 1):
        options = {
            "bounds": [low.tolist(), high.tolist()], "CMA_stds": (high - low).tolist(), "integer_variables": stepped,
            "popsize": population * 2**restart, "tolx": spec.tolerance, "seed": np.nan, "verbose": -9, "verb_log": 0,
            "randn": lambda rows, columns: generator.standard_normal((rows, columns)),
        }  # fmt: skip
        strategy = cma.CMAEvolutionStrategy(start.tolist(), spec.step, options)
        while not (ends := strategy.stop()):
            if len(search.known) + strategy.popsize > most:
                return "evaluations used up"
            samples = strategy.ask()
            shares = [zip(varied, sample, strict=True) for sample in samples]
            judged = search.evaluate([[x if var.stepped else var.number(x) for var, x in pairs] for pairs in shares])
            strategy.tell(samples, _told([goal.order(trial) for trial in judged]))
        why = "converged" if "tolx" in ends else f"no progress: {', '.join(ends)}"
        start = generator.uniform(low, high)
    return why


def _told(orders: Sequence[tuple[int, float]]) -> list[float]:
    """Values for the strategy: costs as they are, in the order of the candidates."""
    worst = max((value for place, value in orders if place == 0), default=0.0)
    excess = max((value for place, value in orders if place == 1), default=0.0)
    return [(value, worst + value, worst + excess + 1.0)[place] for place, value in orders]


def cma_package() -> ModuleType:
    """The package cma. Raises InputError without it."""
    try:
        import cma
    except ModuleNotFoundError:
        raise InputError("several keys need the package cma: pip install 'wrsim[decide]'") from None
    return cma  # type: ignore[no-any-return]
