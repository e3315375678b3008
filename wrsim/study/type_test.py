"""The verdict of a type test: every clause in every state, from the runs that have come to an end."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import stdtrit

from wrsim.analysis.stationary.at_rest import conicity, leaning, settling, stationary_tests, weighing
from wrsim.analysis.stationary.statics import static_state
from wrsim.assessment.assess import assess_runs
from wrsim.assessment.limits import Limit
from wrsim.assessment.outcome import TO_CONFIRM, Assessment, ZoneValue
from wrsim.errors import InputError, SimulationError
from wrsim.inputs.section import given
from wrsim.results import Result, write_atomically
from wrsim.results.files import as_csv, as_json, from_json
from wrsim.results.table import Cell, Column, Table, as_rows, formatted, quantity
from wrsim.results.units import converted
from wrsim.scenario.build import Setup, build
from wrsim.study.collect import MISSING
from wrsim.study.plan import Case
from wrsim.study.programme import Programme, ProgrammeFile
from wrsim.study.task import COMPLETED, RESULT, Marker

OUTPUTS = ("type_test.json", "type_test.csv", "type_test.html", "plan.json")
"""Files of a type test in its folder."""
AT_REST = "stationary.json"  # in the folder of the first run of a state
CONFIDENCE = 0.95  # of the interval of a mean
ROTATION_RADIUS = 150.0  # of the curve of the rotation test [m]


@dataclass(frozen=True)
class Verdict:
    """One clause in one state.

    clause: its name in the rule set; zone: class of track, with the number of sections of those that the standard asks
    for; worst: value; interval: of the mean over sections, at 95 %, empty for fewer than two; estimate: estimated
    maximum; margin: what is left to the limit, share: the same as a number; source: of the limit, with "*" where it is
    from memory; where: section, wheelset; ok: whether it is within.
    """

    state: str
    clause: str
    symbol: str
    unit: str
    zone: str
    worst: str
    interval: str
    estimate: str
    limit: str
    margin: str
    source: str
    where: str
    ok: bool
    share: float

    @property
    def word(self) -> str:
        return "ok" if self.ok else "EXCEEDED"


COLUMNS = {
    "state": "state", "clause": "clause", "quantity": "symbol", "unit": "unit", "class (sections)": "zone",
    "worst": "worst", "mean, 95 %": "interval", "estimate": "estimate", "limit": "limit", "margin": "margin",
    "verdict": "word", "source": "source", "where": "where",
}  # fmt: skip
"""Heads of columns, and what of a verdict stands in them."""
SHORT = [head for head in COLUMNS if head not in ("quantity", "mean, 95 %", "source", "where")]
"""Columns for the terminal."""


def verdicts(programme: Programme, markers: Sequence[Marker]) -> tuple[list[Verdict], list[str]]:
    """The verdict of every clause in every state, and remarks. Raises InputError for runs that cannot be assessed."""
    clauses: list[Verdict] = []
    notes: list[str] = []
    plan = programme.plan
    for i, state in enumerate(programme.spec.states):
        runs = [
            (programme.names[case.place[1]], case, marker)
            for case, marker in zip(plan.cases, markers, strict=True)
            if case.place[0] == i
        ]
        lost = [f"{state.name}, {name}: {m.message or m.status}" for name, _, m in runs if m.status != COMPLETED]
        notes += lost
        stopped = sum(m.status not in (COMPLETED, MISSING) for _, _, m in runs)
        clauses.append(
            Verdict(state.name, "every run comes to its end", "runs", "", "", f"{len(runs) - stopped} of {len(runs)}",
                    "", "", str(len(runs)), "", "", lost[0] if lost else "", not stopped, -1.0 if stopped else 1.0)
        )  # fmt: skip
        if programme.spec.stationary:
            clauses += _at_rest(programme, state.name, runs[0][1])
        whole = {name: Result.load(plan.folder_of(case) / RESULT) for name, case, m in runs if m.status == COMPLETED}
        if not whole:
            continue
        try:
            judged = assess_runs([*whole.values()], None, [*whole], programme.rules)
        except InputError as error:
            raise InputError(f"state {state.name}: {error}") from None
        clauses += [_of_zone(state.name, judged, zone, limit) for zone in judged.zones if (limit := zone.worst.limit)]
        notes += [f"{state.name}: {note}" for note in judged.notes]
    return clauses, list(dict.fromkeys(notes))


def _of_zone(state: str, judged: Assessment, zone: ZoneValue, limit: Limit) -> Verdict:
    measured, cells = zone.worst.quantity, zone.cells()
    clause = judged.rules.about(measured.key)
    needed = judged.rules.needed.get(zone.worst.section.zone)
    sections = f"{zone.counted}" + (f" of {needed}" if needed else "")
    return Verdict(
        state, measured.key if clause is None else clause.id, measured.symbol, converted(measured.shown).unit,
        f"{zone.worst.section.zone} ({sections})", cells["worst"], interval(zone), cells["estimate"], cells["limit"],
        cells["margin"], limit.source + limit.star, cells["where"], bool(zone.passed), zone.margin or 0.0,
    )  # fmt: skip


def interval(zone: ZoneValue) -> str:
    """Student's interval of the mean over the sections of a class, in words; empty for fewer than two sections."""
    n = zone.counted
    if n < 2 or not np.isfinite(zone.mean):
        return ""
    half = float(stdtrit(n - 1, 0.5 + 0.5 * CONFIDENCE)) * zone.deviation / n**0.5
    factor = converted(zone.worst.quantity.shown).factor
    return f"{formatted(factor * (zone.mean - half))} to {formatted(factor * (zone.mean + half))}"


def _at_rest(programme: Programme, state: str, case: Case) -> list[Verdict]:
    """Stationary tests of the vehicle of a case, which are stored beside its run."""
    file = programme.plan.folder_of(case) / AT_REST
    spec = programme.spec
    asked: dict[str, Any] = {"tests": list(spec.stationary), "cant_deficiency_mm": spec.deficiency}
    asked |= {"payload_kg": spec.payload_kg, "speed": spec.speed, "flexibility": spec.flexibility_coefficient}
    stored = from_json(file.read_bytes()) if file.exists() else None
    if stored is None or any(stored.get(key) != value for key, value in asked.items()):
        stored = asked | {"found": _tests_at_rest(programme, case)}
        write_atomically(file, as_json(stored))
    return [
        Verdict(state, test["clause"], test["symbol"], test["unit"], "at rest", formatted(test["value"]), "", "",
                "at least " * test["lowest"] + formatted(test["limit"]), quantity(100.0 * test["margin"], "%", ".0f"),
                test["limit_source"], where, test["passed"], test["margin"])
        if "value" in test
        else Verdict(state, test["clause"], "", "", "at rest", "no rest", "", "", "", "", "", where, False, -1.0)
        for test, where in stored["found"]
    ]  # fmt: skip


def _tests_at_rest(programme: Programme, case: Case) -> list[tuple[dict[str, Any], str]]:
    """The worst of each stationary test that is wanted, and what it is of; where the vehicle finds no rest, why."""
    setup = build(programme.plan.scenario(case))
    held = replace(setup, vehicle=replace(setup.vehicle, loads=()))
    outcomes: list[tuple[dict[str, Any], str]] = []
    for test in programme.spec.stationary:
        try:
            outcomes += _test_at_rest(test, held, programme.spec)
        except (SimulationError, InputError) as error:
            outcomes.append(({"clause": test}, str(error)))
    return outcomes


def _test_at_rest(test: str, setup: Setup[Any], spec: ProgrammeFile) -> list[tuple[dict[str, Any], str]]:
    """The worst of one of them. Raises SimulationError where the vehicle finds no rest, InputError where its wheelsets
    have no place on the rails to swing about."""
    vehicle = setup.vehicle
    if test == "cant":
        place = f"on {quantity(spec.deficiency, 'mm', '.0f')} of cant"
        most = None if (s := spec.flexibility_coefficient) is None else Limit(s, "design of the vehicle", "file")
        verdicts = leaning(vehicle, static_state(vehicle), spec.deficiency, most)["verdicts"]
        return [(verdict, place) for verdict in verdicts]
    if test == "weighing":
        return [(weighing(static_state(vehicle)), "on level track")]
    if test == "settling":
        return [(settling(vehicle, given(spec.payload_kg)), f"under {quantity(spec.payload_kg, 'kg', 'g')}")]
    if test == "conicity":
        gauge = setup.track.nominal_gauge
        return [(conicity(vehicle, setup.rails, gauge, spec.speed), f"gauge {quantity(1e3 * gauge, 'mm', 'g')}")]
    numbers, _, _ = stationary_tests(vehicle, test == "twist", None, test == "rotation", ROTATION_RADIUS)
    if test == "twist":
        return [(numbers["twist_test"], "twist test")]
    turned = numbers.get("rotation_test", [])
    worst = max(turned, key=lambda outcome: float(outcome["value"]), default=None)
    return [(worst, f"bogie {worst['bogie']}, {formatted(worst['rate_deg_per_s'], 'g')} °/s")] if worst else []


def whole_table(title: str, clauses: Sequence[Verdict]) -> Table:
    """Every clause with a limit, in every class of track."""
    star = (TO_CONFIRM,) if any(v.source.endswith("*") for v in clauses) else ()
    note = "sections: those of the test, of those that the rules ask for; mean: over the sections"
    return _table(title, clauses, COLUMNS, (note, *star))


def _table(title: str, clauses: Iterable[Verdict], heads: Iterable[str], notes: tuple[str, ...] = ()) -> Table:
    rows = [[getattr(v, COLUMNS[head]) for head in heads] for v in clauses]
    return Table(title, tuple(map(Column, heads)), rows, notes)


def state_table(clauses: Sequence[Verdict]) -> Table:
    """The same of one state for a page: every clause is named once."""
    whole, last = whole_table("", clauses), ""
    rows: list[list[Cell]] = []
    for v, row in zip(clauses, whole.rows, strict=True):
        head: list[Cell] = ["", "", ""] if v.clause == last else [v.clause, v.symbol, v.unit]
        rows.append([*head, *row[4:]])
        last = v.clause
    return Table("", whole.columns[1:], rows, whole.notes)


def worst_tables(title: str, clauses: Sequence[Verdict], notes: Sequence[str]) -> list[Table]:
    """For the terminal: of every clause and state the class of track with the least margin; the verdict."""
    least: dict[tuple[str, str], Verdict] = {}
    for v in clauses:
        key = v.state, v.clause
        if key not in least or v.share < least[key].share:
            least[key] = v
    return [
        _table(title, least.values(), SHORT),
        Table("", notes=(*(f"note: {note}" for note in notes), verdict_text(clauses))),
    ]


def summary_text(programme: Programme) -> str:
    """What is tested, in a few sentences."""
    spec, vehicle = programme.spec, programme.plan.vehicle
    states, runs = ", ".join(s.name for s in spec.states), ", ".join(programme.names)
    uneven = "smooth track" if spec.irregularities is None else f"uneven track, {spec.irregularities.spectrum}"
    rest = f" At rest: {', '.join(spec.stationary)}." if spec.stationary else ""
    return f"Vehicle {vehicle}; states: {states}. Runs on {uneven}: {runs}.{rest} Rules: {programme.rules.title}."


def verdict_text(clauses: Sequence[Verdict]) -> str:
    """The verdict in one sentence."""
    red = [v for v in clauses if not v.ok]
    if not red:
        return f"{len(clauses)} values, each within its limit"
    names = list(dict.fromkeys(f"{v.clause} ({v.state})" for v in red))
    return f"LIMITS EXCEEDED: {len(red)} of {len(clauses)} values: {'; '.join(names)}"


def verdict_numbers(title: str, clauses: Sequence[Verdict], notes: Sequence[str]) -> dict[str, Any]:
    """Content of ``type_test.json``."""
    return {
        "title": title,
        "passed": all(v.ok for v in clauses),
        "verdicts": [vars(v) for v in clauses],
        "notes": list(notes),
    }


def write_verdicts(folder: Path, numbers: dict[str, Any], table: Table, page: str) -> list[Path]:
    """Write ``type_test.json``, ``type_test.csv`` and ``type_test.html``."""
    files = [folder / name for name in OUTPUTS[:3]]
    contents = as_json(numbers, indent=1), as_csv(as_rows(table)), page.encode()
    for path, content in zip(files, contents, strict=True):
        write_atomically(path, content)
    return files
