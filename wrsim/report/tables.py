"""Words and tables of a report: verdict, identity, assessment, peaks, contacts, wear, events. Nothing is drawn here."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import xarray as xr

from wrsim.assessment.outcome import NO_VERDICT, Assessment, ZoneValue
from wrsim.errors import InputError
from wrsim.plots.moments import moment_title, patches_at, snapshot_letter
from wrsim.plots.wear import LAW_LABELS
from wrsim.report.document import basis, is_lone
from wrsim.results import CHANNELS, Result
from wrsim.results.channels import PATCHES
from wrsim.results.dataset import table_of_scenario
from wrsim.results.differences import LISTED, beyond, difference_table, differences, inputs_apart, one_sided
from wrsim.results.files import from_json
from wrsim.results.moments import sample_of
from wrsim.results.summary import summarise_wear
from wrsim.results.summary_tables import (
    Summary,
    curve_tables,
    extent_text,
    integration,
    numbers_of,
    wheelset_tables,
)  # fmt: skip
from wrsim.results.table import SIGNIFICANT_CHANGE, Cell, Column, Table, formatted, quantity
from wrsim.results.units import converted
from wrsim.results.wheelsets import numbered, wheelsets

T = TypeVar("T")

PATCH_CHANNELS = ("N", "p0", "contact_angle", "contact_angle_variation", "area", "temperature")
"""Channels in the table of contacts."""

GOOD, BAD, OPEN = "good", "bad", "open"
"""States of a verdict: within all limits; beyond one, or stopped; none."""

MOST_CURVES = 10  # full curves of a result that are listed; summary.json has all of them
APART = 1.05  # limits that differ by less are one line in a chart


class ReportVerdict(NamedTuple):
    """One line: state and sentence."""

    state: str
    sentence: str


def evaluated(evaluate: Callable[[Result], T], result: Result) -> tuple[T | None, str]:
    """The assessment or the ride of a run, or why there is none."""
    try:
        return evaluate(result), ""
    except InputError as problem:
        return None, str(problem)


def verdict(result: Result, assessment: Assessment | None, why: str) -> ReportVerdict:
    """Within all limits or not, with the worst margin and what it rests on; how the analysis ended, if early."""
    stop = f"Stopped early: {result.stop_reason}. " if result.status == "stopped" else ""
    state, worst = OPEN, assessment.tightest() if assessment is not None else None
    if "time" in result.dataset.dims and is_lone(result.dataset):
        sentence = f"{NO_VERDICT[0].upper()}{NO_VERDICT[1:]}."
    elif assessment is None:
        sentence = f"Not assessed: {why}." if "time" in result.dataset.dims else "" if stop else "Completed."
    elif worst is None:
        sentence = "No limit applies to anything that was assessed."
    else:
        sentence = assessment.verdict.replace("A LIMIT IS EXCEEDED", "a limit is exceeded").replace("every", "Every")
        state = BAD if not assessment.passed else OPEN if assessment.unlimited else GOOD
        sentence = f"{sentence}; {_tightest(worst)}. {basis(result.dataset, assessment)}"
    return ReportVerdict(BAD if stop else state, stop + sentence)


def _tightest(row: ZoneValue) -> str:
    value, judged, margin = row.worst, row.worst.quantity, row.margin or 0.0
    at_most = quantity(value.limit.value * judged.shown.factor, judged.shown.unit) if value.limit else ""
    number, kind = value.value, ""
    if margin < (value.margin or 0.0) and row.estimate is not None:
        number, kind = row.estimate, ", estimated maximum"
    part_of = "of at least" if judged.lowest else "of"
    worst = f"{judged.symbol} = {quantity(number * judged.shown.factor, judged.shown.unit)}{kind} {part_of} {at_most}"
    place = f"{judged.meaning}; {value.section.label}, {value.where}"
    return f"worst margin {quantity(100.0 * margin, '%', '.0f')}: {worst} ({place})"


def identity(results: Sequence[Result], sources: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Rows of the table of who is who: a name, and a text for every result. sources: short names of the results."""
    columns = [{"title": r.title, "result": source} | _identity(r) for r, source in zip(results, sources, strict=True)]
    rows = [(name, [column[name] for column in columns]) for name in columns[0]]
    return [(name, values) for name, values in rows if any(values)]


def _identity(result: Result) -> dict[str, str]:
    of_vehicle = table_of_scenario(result.dataset, "vehicle") or {}
    vehicle, speed = str(of_vehicle.get("model", "")), of_vehicle.get("speed_kmh")
    if vehicle and isinstance(speed, int | float):
        vehicle += f", {quantity(float(speed), 'km/h', 'g')}"
    status = result.status + (f": {result.stop_reason}" if result.stop_reason else "")
    about = {"analysis": result.analysis, "status": status, "extent": extent_text(result.dataset)}
    return about | {"vehicle": vehicle}


def version_rows(results: Sequence[Result], summaries: Sequence[Summary]) -> list[tuple[str, list[str]]]:
    """What computed the results: integration of the runs, versions of the programs."""
    rows = [("integration", [" ".join(integration(summary)) for summary in summaries])]
    keys = {k for r in results for k in r.dataset.attrs if k.endswith("_version") and k != "format_version"}
    ordered = sorted(keys, key=lambda k: (not k.startswith("wrsim"), k))
    rows += [(k.removesuffix("_version"), [str(r.dataset.attrs.get(k, "")) for r in results]) for k in ordered]
    return [(name, values) for name, values in rows if any(values)]


def inputs(result: Result) -> list[tuple[str, str]]:
    """Files that the result was computed from, without folders of a machine, each with its SHA-256; none for a
    result of an older wrsim."""
    digests = {
        Path(name): digest for name, digest in (from_json(str(result.dataset.attrs.get("inputs", ""))) or {}).items()
    }
    return [(path.name if path.is_absolute() else path.as_posix(), str(digest)) for path, digest in digests.items()]


def assessment_rows(assessments: Sequence[Assessment | None]) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Rows by quantity and class of track, with cells of every assessment that has them; sources of limits by letter.
    first: how many rows the quantity has, in the first of them, and 0 in the others."""
    quantities: dict[str, dict[str, dict[str, Any]]] = {}
    letters: dict[str, str] = {}
    for i, each in enumerate(assessments):
        for row in each.zones if each is not None else ():
            q, zone, limit = row.worst.quantity, row.worst.section.zone, row.worst.limit
            about = {"quantity": q, "unit": converted(q.shown).unit, "zone": zone, "first": 0}
            line = quantities.setdefault(q.key, {}).setdefault(zone, about | {"cells": [None] * len(assessments)})
            letter = letters.setdefault(limit.source, snapshot_letter(len(letters))) if limit is not None else ""
            cells = row.cells() | ({"verdict": ""} if each is not None and each.lone else {})
            marks = {"letter": letter, "star": limit.star if limit is not None else ""}
            line["cells"][i] = {**cells, **marks, "passed": row.passed if cells["verdict"] else None}
    for zones in quantities.values():
        next(iter(zones.values()))["first"] = len(zones)
    rows = [row for zones in quantities.values() for row in zones.values()]
    return rows, {letter: source for source, letter in letters.items()}


CHART_LIMITS = {
    "sum_Y": ("sum_Y", "limit"), "Y_over_Q": ("Y_over_Q", "limit"), "Y_over_Q_nadal": ("Y_over_Q", "Nadal"),
    "Q": ("Q", "limit"), "Y_qst": ("Y", "limit, quasi-static,"),
}  # fmt: skip
"""Quantities whose limits are drawn across histories, the channel of each, and what the limit is called."""


def chart_limits(assessments: Sequence[Assessment | None]) -> dict[str, list[dict[str, Any]]]:
    """Limits to draw across histories, over the sections in which they hold [m]; those of the track shifting force both
    ways. Of limits that lie as near each other as those of wheelsets of nearly one load, the least."""
    drawn: dict[str, list[dict[str, Any]]] = {}
    for key, (channel, label) in CHART_LIMITS.items():
        apart: dict[float, dict[float, float]] = {}
        values = [v for each in assessments if each is not None for v in each.of(key) if v.limit is not None]
        pairs = [(round(v.limit.value * v.quantity.shown.factor, 3), v.section) for v in values if v.limit is not None]
        for limit, section in sorted(pairs, key=lambda pair: pair[0]):
            last = max(apart, default=0.0)
            apart.setdefault(limit if limit > APART * last else last, {})[section.start] = section.end
        for limit, spans in apart.items():
            for y in (limit, -limit) if key == "sum_Y" else (limit,):
                about = {"label": f"{label} {formatted(y)}", "value": y, "spans": sorted(spans.items())}
                drawn.setdefault(channel, []).append(about)
    return drawn


def cards(summaries: Sequence[Summary], names: Sequence[str]) -> list[tuple[str, list[Table]]]:
    """For every wheelset a card: its name, tables of its peaks."""
    by_result = [summary.get("wheelsets", {}) for summary in summaries]
    sets = list(dict.fromkeys(name for peaks in by_result for name in peaks))
    labels = numbered(sets) if len(set(map(tuple, by_result))) == 1 else dict(zip(sets, sets, strict=True))
    return [(labels[name], wheelset_tables([peaks.get(name) for peaks in by_result], names)) for name in sets]


def curves(summaries: Sequence[Summary], names: Sequence[str]) -> list[Table]:
    """Medians in full curves, of every result; of several results curve by curve."""
    sets = [summary.get("wheelsets", {}) for summary in summaries]
    tables = [curve_tables(list(numbered(tuple(peaks)).values()), list(peaks.values()), MOST_CURVES) for peaks in sets]
    named = [_named([peaks], [name]) for peaks, name in zip(tables, names, strict=True)]
    return [table for of_curve in zip_longest(*named) for table in of_curve if table is not None]


def apart(results: Sequence[Result], names: Sequence[str]) -> list[Table]:
    """What the later results were asked otherwise than the first, and the numbers that differ most, in percent."""
    tables = []
    for name, result in zip(names[1:], results[1:], strict=True):
        letters = names[0][0], name[0]
        asked = inputs_apart(results[0], result, letters)
        try:
            changes = differences(results[0], result, (), SIGNIFICANT_CHANGE)
            off, alone = one_sided(beyond(changes, SIGNIFICANT_CHANGE), letters)
            asked += alone
        except InputError as problem:  # analyses of two kinds
            off, asked = [], [*asked, str(problem)]
        if not off and not asked:
            asked = [f"no difference of more than {100.0 * SIGNIFICANT_CHANGE:g} %"]
        if len(off) > LISTED:
            part = 100.0 * SIGNIFICANT_CHANGE
            asked.append(f"the largest {LISTED} of {len(off)} differences of more than {part:g} %")
        tables.append(difference_table(off[:LISTED], letters, f"{letters[1]} against {letters[0]}", asked))
    return tables


def numbers(results: Sequence[Result], summaries: Sequence[Summary], names: Sequence[str]) -> list[Table]:
    """The tables of results without wheelsets (stability, steady, conicity)."""
    if any("wheelsets" in summary for summary in summaries):
        return []
    return _named([numbers_of(r.dataset, of_result) for r, of_result in zip(results, summaries, strict=True)], names)


def _named(tables: Sequence[Sequence[Table]], names: Sequence[str]) -> list[Table]:
    """The tables of all results, with the names of these in their titles where there are several."""
    pairs = [(name, table) for name, of_result in zip(names, tables, strict=True) for table in of_result]
    return [replace(table, title=f"{name}: {table.title}" if name else table.title) for name, table in pairs]


def contacts(dataset: xr.Dataset, moments: Sequence[int]) -> Table:
    """Every patch of one wheelset at some of its snapshots."""
    dim = "time" if "time" in dataset.dims else "pose"
    names = [name for name in PATCH_CHANNELS if name in dataset]
    rows: list[list[Cell]] = []
    for i, moment in enumerate(moments):
        pose = f"({snapshot_letter(i)}) {dataset['pose'].values[moment]}" if dim == "pose" else ""
        title = pose or moment_title(dataset, moment, i).replace("\n", ", ")
        for where in [patch for wheel in dataset["wheel"].values for patch in patches_at(dataset, moment, str(wheel))]:
            data = dataset[names].isel({dim: sample_of(dataset, moment), "patch": where.patch}).sel(wheel=where.wheel)
            values = [float(data[name]) * CHANNELS[name].shown.factor for name in names]
            rows.append([title, f"{where.wheel}, {PATCHES[where.patch]} patch", *values])
            title = ""
    return Table("", (Column("at"), Column("wheel"), *(Column.of(CHANNELS[name]) for name in names)), rows)


def event_table(results: Sequence[Result], summaries: Sequence[Summary], names: Sequence[str]) -> Table | None:
    """What happened on the way, and where a run stopped."""
    rows: list[tuple[str, ...]] = []
    for result, summary, name in zip(results, summaries, names, strict=True):
        happened = [(e["distance_m"], e["time_s"], e["event"]) for e in summary.get("events", ())]
        if result.status == "stopped" and "stop_distance_m" in result.dataset.attrs:
            s, t = (float(result.dataset.attrs[f"stop_{key}"]) for key in ("distance_m", "time_s"))
            happened.append((s, t, f"stopped: {result.stop_reason}"))
        who = (name,) if len(names) > 1 else ()
        rows += [(quantity(s, "m", ".1f"), quantity(t, "s", ".3f"), event, *who) for s, t, event in happened]
    heads = ("place", "time", "what happened", *(("result",) if len(names) > 1 else ()))
    return Table("", tuple(map(Column, heads)), rows) if rows else None


WORN_WHEELS = {
    "tread_g_per_km": Column("tread", "g/km"), "flange_g_per_km": Column("flange", "g/km"),
    "wear_wheel_depth_max_um_per_km": Column("deepest", "µm/km"), "wear_wheel_u_mm": Column("at u", "mm"),
}  # fmt: skip
WORN_RAILS = {"wear_rail_depth_max_nm": Column("deepest, one passage", "nm"), "wear_rail_u_mm": Column("at u", "mm")}
FATIGUE = {
    "rail_damage_max": Column("largest damage, one passage"), "wear_rail_u_mm": Column("at u", "mm"),
    "fatigue_index_max": Column("largest fatigue index"),
}  # fmt: skip
"""Columns of the tables of wear by keys of a summary."""


def wear_tables(dataset: xr.Dataset) -> list[Table]:
    """What wheels lose by every law, what rails lose, fatigue of the rails."""
    wear, called = summarise_wear(dataset), numbered(wheelsets(dataset))
    parts: list[tuple[str, str, dict[str, Column], dict[str, Any]]] = []
    for law, losses in wear["laws"].items():
        wheels = {f"{called[name]}, {w}": row for name, pair in losses["wheelsets"].items() for w, row in pair.items()}
        parts.append((f"Wheels, {LAW_LABELS[law]}", "wheel", WORN_WHEELS, wheels))
        parts.append((f"Rails, {LAW_LABELS[law]}", "rail", WORN_RAILS, losses["rails"]))
    parts.append(("Fatigue of the rails", "rail", FATIGUE, wear["fatigue"]))
    return [
        Table(title, (Column(body), *heads.values()), [(n, *(row[key] for key in heads)) for n, row in rows.items()])
        for title, body, heads, rows in parts
    ]
