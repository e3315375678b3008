"""What is told about the best candidate: its numbers, what limits it, how sensitive it is; the history as a dataset."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.optimize import nnls

from wrsim.results.dataset import versions
from wrsim.results.table import Column, Table, finite, formatted
from wrsim.study.collect import FORMAT, labels_of
from wrsim.study.optimisation.reading import Judged, Optimisation
from wrsim.study.optimisation.search import LEAST, Search
from wrsim.study.plan import value_text
from wrsim.study.task import COMPLETED

Array = NDArray[np.float64]
STEP = 0.01
"""Distance of the neighbours of the best candidate, as a part of the distance between the bounds."""
ROUNDS = 3
"""How often a neighbour that is better takes the place of the best candidate."""
MOST_SHOWN = 20
"""Points of a front in a table."""
NOTES = (
    "A candidate that keeps all constraints is better than one that does not; of two that do not, the one that exceeds "
    "them less, as parts of the limits (Deb 2000); one without a result is behind all others.",
    "Multiplier: how much the cost changes for each part by which a limit is widened, or for each part of the distance "
    "between the bounds by which a bound is moved.",
)
OUTSIDE, LACKING = "exceeds a constraint", "lacks an output"
"""Further statuses of a candidate."""


@dataclass(frozen=True)
class Neighbour:
    """A candidate beside the best one: position of its key, distance in the file's unit or in steps."""

    key: int
    distance: float
    judged: Judged


def status_of(judged: Judged) -> str:
    """What became of a candidate: a status of its cases, or what it lacks or exceeds."""
    if not judged.candidate.completed:
        return judged.candidate.status
    return LACKING if not judged.complete else OUTSIDE if not judged.feasible else COMPLETED


def neighbours(search: Search) -> list[Neighbour]:
    """Candidates beside the best one along every key; one that is better becomes the best one.

    None where that goes on: then slopes would be those of another candidate."""
    for _ in range(ROUNDS):
        best = search.best()
        rows = list(_beside(search, search.point(best)))
        judged = search.evaluate([point for _, _, point in rows])
        beside = [Neighbour(key, distance, trial) for (key, distance, _), trial in zip(rows, judged, strict=True)]
        if search.best() is best:
            return beside
    return []


def _beside(search: Search, point: Sequence[float]) -> Iterator[tuple[int, float, list[float]]]:
    """Position of the key, distance and numbers of all neighbours within the bounds."""
    for i, var in enumerate(search.optimisation.candidates.varied):
        for side in (-1.0, 1.0):
            if var.stepped:
                x = point[i] + side
            else:
                x = var.number(min(max(var.share(point[i]) + side * STEP, 0.0), 1.0))
            if var.low <= x <= var.high and x != point[i]:
                yield i, x - point[i], [*point[:i], x, *point[i + 1 :]]


def limits(search: Search, beside: Sequence[Neighbour]) -> list[str]:
    """What keeps the best candidate from being better, in sentences."""
    best = search.best()
    if not best.feasible:
        return ["no candidate keeps all constraints" if best.complete else "no candidate has a result"]
    lines = []
    if not beside:
        lines.append("not converged: candidates beside it are better; allow more evaluations")
    for n in beside:
        varied = search.optimisation.candidates.varied[n.key]
        values = (value_text(trial.candidate.values[n.key]) for trial in (best, n.judged))
        way = f"{varied.name} {' -> '.join(values)}"
        if LEAST.order(n.judged) < LEAST.order(best):
            lines.append(f"not converged: {way} is better; allow more evaluations")
        elif not n.judged.complete:
            lines.append(f"{way}: {status_of(n.judged)}")
    lines += [f"{name} (multiplier {multiplier:.3g})" for name, multiplier in multipliers(search, beside)]
    return lines or ["no bound and no constraint"]


def multipliers(search: Search, beside: Sequence[Neighbour]) -> list[tuple[str, float]]:
    """Constraints and bounds that hold the best candidate, each with its multiplier of Lagrange: by how much the cost
    falls for each part of the limit, or of the distance between the bounds, by which it is widened.

    They are the non-negative ones that come nearest to balancing the slopes of the cost (Karush, Kuhn and Tucker), of
    what a neighbour exceeds and of bounds nearer than a neighbour."""
    best, varied = search.best(), search.optimisation.candidates.varied
    keys = [i for i, var in enumerate(varied) if not var.stepped]
    slopes = {i: _slopes(search, best, [n for n in beside if n.key == i and n.judged.complete]) for i in keys}
    if not keys or not all(np.isfinite(each).all() for each in slopes.values()):
        return []
    table = np.array([slopes[i] for i in keys])  # keys, cost and margins
    held: list[tuple[str, np.ndarray]] = []
    for j, name in enumerate(search.optimisation.margin_names):
        if any(n.judged.complete and n.judged.margins[j] < 0.0 for n in beside):
            held.append((name, -table[:, 1 + j]))
    shares = [varied[i].share(x) for i, x in enumerate(search.point(best)) if i in keys]
    for row, (i, share) in enumerate(zip(keys, shares, strict=True)):
        for bound, value, inside, sign in (
            ("low", varied[i].low, share, -1.0),
            ("high", varied[i].high, 1 - share, 1.0),
        ):
            if inside < STEP:
                held.append((f"{varied[i].name} {bound} = {value:g}", sign * np.eye(len(keys))[row]))
    if not held:
        return []
    solution, _ = nnls(np.column_stack([column for _, column in held]), -table[:, 0])
    return [(name, float(value)) for (name, _), value in zip(held, solution, strict=True) if value > 0.0]


def _slopes(search: Search, best: Judged, beside: Sequence[Neighbour]) -> Array:
    """Slopes of the cost and of the margins along a key, for the whole distance between its bounds: of the parabola
    through three candidates, or from one to the other where the best one is at a bound."""
    if not beside:
        return np.full(1, np.nan)
    var = search.optimisation.candidates.varied[beside[0].key]
    x = np.array([var.share(search.point(each)[beside[0].key]) for each in (best, *(n.judged for n in beside))])
    y = np.array([(each.costs[0], *each.margins) for each in (best, *(n.judged for n in beside))])
    return np.asarray(np.polynomial.polynomial.polyfit(x - x[0], y, len(beside))[1])


def optimisation_report(search: Search, beside: Sequence[Neighbour]) -> dict[str, Any]:
    """Content of ``optimisation.json``."""
    optimisation, best = search.optimisation, search.best()
    start, sign = next(iter(search.known.values())), optimisation.shown_costs[0][1]
    report = {
        "title": optimisation.candidates.title,
        "evaluations": len(search.known),
        "status": Counter(map(status_of, search.known.values())),
        "end": search.ends,
        "start": _record(optimisation, start),
        "best": _record(optimisation, best),
        "limits": limits(search, beside) if optimisation.spec.search.front is None else [],
        "sensitivity": [
            {
                "key": optimisation.candidates.varied[n.key].keys[0],
                "value": n.judged.candidate.values[n.key],
                "cost": optimisation.shown(n.judged),
                "slope": finite(sign * (n.judged.costs[0] - best.costs[0]) / n.distance),
                "status": status_of(n.judged),
            }
            for n in beside
        ],
    }
    if optimisation.spec.search.front is not None:
        report["front"] = [_record(optimisation, trial) for trial in search.front()]
    return report


def _record(optimisation: Optimisation, judged: Judged) -> dict[str, Any]:
    """A candidate as plain numbers."""
    candidate = judged.candidate
    sought = (*optimisation.objectives, *optimisation.constraints)
    return {
        "number": judged.number,
        "values": optimisation.candidates.changes(candidate.values),
        "cost": optimisation.shown(judged),
        "outputs": {each.label(optimisation.several): finite(each.value(candidate)) for each in sought},
        "margins": dict(zip(optimisation.margin_names, map(finite, judged.margins), strict=True)),
        "status": status_of(judged),
        "message": candidate.message,
    }


def history(search: Search) -> xr.Dataset:
    """All candidates in the order of evaluation, as a study with the axis ``evaluation`` (``study.nc``)."""
    optimisation, judged = search.optimisation, list(search.known.values())
    candidates = optimisation.candidates
    variables: dict[str, Any] = {}
    for i, (_, sign) in enumerate(optimisation.shown_costs):
        name = f"cost_{i + 1}" if len(optimisation.shown_costs) > 1 else "cost"
        attributes = {"units": "1", "long_name": optimisation.shown_costs[i][0], "sign": sign}
        variables[name] = ("evaluation", np.array([trial.costs[i] for trial in judged]), attributes)
    units = {
        (scenario.name, name): unit
        for trial in judged
        for scenario in candidates.scenarios
        for name, unit in trial.candidate.cases[scenario.name].units.items()
    }
    for (scenario, name), unit in units.items():
        column = [trial.candidate.cases[scenario].numbers.get(name) for trial in judged]
        label = f"{name}_{scenario}" if optimisation.several else name
        variables[label] = ("evaluation", np.array(column, dtype=float), {"units": unit or "1"})
    for i, name in enumerate(optimisation.margin_names):
        attributes = {"units": "1", "long_name": f"margin: {name}"}
        variables[f"margin_{i + 1}"] = ("evaluation", np.array([trial.margins[i] for trial in judged]), attributes)
    texts = {
        "status": [status_of(trial) for trial in judged],
        "message": [trial.candidate.message for trial in judged],
        "name": [" ".join(case.name for case in trial.candidate.cases.values() if case.name) for trial in judged],
    }
    variables |= {name: ("evaluation", np.array(column, dtype=object)) for name, column in texts.items()}
    coords: dict[str, Any] = {"evaluation": ("evaluation", np.arange(1.0, len(judged) + 1.0))}
    for i, var in enumerate(candidates.varied):
        values = labels_of([each.candidate.values[i] for each in judged])
        coords[var.keys[0].replace(" ", "_")] = ("evaluation", values, {"key": ", ".join(var.keys)})
    first = candidates.scenarios[0].base
    attributes = {"format": FORMAT, "title": candidates.title, "analysis": first.analysis}
    attributes |= {
        "study_text": candidates.source.text,
        "scenario_text": first.text,
        "vehicle": first.spec.vehicle.model,
    }
    return xr.Dataset(variables, coords, attributes | versions())


def verdict_text(report: dict[str, Any]) -> str:
    """How far it came, in one sentence."""
    if "front" in report:
        return f"A Pareto front of {len(report['front'])} of {report['evaluations']} candidates"
    best, held = report["best"]["cost"], "; ".join(report["limits"])
    ends = [
        f"{name} {formatted(cost, '.6g')} -> {formatted(best[name], '.6g')}"
        for name, cost in report["start"]["cost"].items()
    ]
    return f"{', '.join(ends)}: {report['evaluations']} candidates, {'; '.join(report['end'])}; held by: {held}"


def optimisation_tables(report: dict[str, Any]) -> dict[str, Table]:
    """Tables by their headings: the best candidate beside the start, limits, sensitivity, front."""
    start, best = report["start"], report["best"]
    keys = [(key, start["values"][key], value) for key, value in best["values"].items()]
    numbers = [(label, start["outputs"][label], value) for label, value in best["outputs"].items()]
    heads = (Column("quantity"), Column("start", "", ".6g"), Column("best", "", ".6g"))
    costs = [(name, start["cost"][name], value) for name, value in best["cost"].items() if name not in best["outputs"]]
    counts = ", ".join(f"{count} {status}" for status, count in report["status"].items())
    told = f"{report['evaluations']} candidates ({counts}); {'; '.join(dict.fromkeys(report['end']))}"
    tables = {
        "Best candidate": Table(report["title"], heads, [*keys, *numbers, *costs], (told,)),
    }
    if report["limits"]:
        tables["What limits it"] = Table("", notes=tuple(report["limits"]))
    rows = [
        (
            each["key"],
            each["value"],
            *each["cost"].values(),
            each["slope"],
            "" if each["status"] == COMPLETED else each["status"],
        )
        for each in report["sensitivity"]
    ]
    names = ("key", "value", *best["cost"], "slope", "")
    if rows:
        tables["Beside the best candidate"] = Table("", tuple(Column(name, "", ".6g") for name in names), rows)
    if front := report.get("front"):
        columns = [*front[0]["values"], *front[0]["cost"]]
        shown = np.unique(np.linspace(0, len(front) - 1, min(len(front), MOST_SHOWN)).round().astype(int))
        rows = [(*front[i]["values"].values(), *front[i]["cost"].values()) for i in shown]
        tables["Pareto front"] = Table("", tuple(Column(name, "", ".5g") for name in columns), rows)
    return tables
