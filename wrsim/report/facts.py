"""What a report says of its results in words and numbers: identity, verdict, tables. Nothing is drawn here."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from wrsim.errors import InputError
from wrsim.plots.moments import snapshot_letter
from wrsim.results import Result
from wrsim.results.assessment import Assessment, ZoneValue
from wrsim.results.dataset import table_of_scenario
from wrsim.results.files import from_json
from wrsim.results.ride import Ride
from wrsim.results.summary_tables import curve_tables, wheelset_tables
from wrsim.results.table import Column, Table, formatted, quantity
from wrsim.results.wheelsets import numbered

GOOD, BAD, OPEN = "good", "bad", "open"
"""States of a verdict: within all limits; beyond one, or stopped; nothing to say."""

MOST_CURVES = 10
"""Full curves of a result that are listed; summary.json has all of them."""

APART = 1.05
"""Limits that differ by less are one line in a chart."""


@dataclass(frozen=True)
class Verdict:
    """One line: state and words."""

    state: str
    words: str


def assessed(result: Result) -> tuple[Assessment | None, str]:
    """The assessment of a run, or why there is none."""
    from wrsim.analysis.assessment import assess

    try:
        return assess(result), ""
    except InputError as problem:
        return None, str(problem)


def ridden(result: Result) -> tuple[Ride | None, str]:
    """The ride of a run with points, or why there is none; no words where nobody expects one."""
    from wrsim.analysis.ride import evaluate_ride

    if "point" not in result.dataset.dims or "time" not in result.dataset.dims:
        return None, ""
    try:
        return evaluate_ride(result), ""
    except InputError as problem:
        return None, str(problem)


def verdict(result: Result, found: Assessment | None, why: str) -> Verdict:
    """Within all limits or not, with the worst margin; how the analysis ended, if early."""
    stop = f"Stopped early: {result.stop_reason}. " if result.status == "stopped" else ""
    if found is None:
        if "time" not in result.dataset.dims:
            words = "Completed." if not stop else ""
            return Verdict(BAD if stop else OPEN, stop + words)
        return Verdict(BAD if stop else OPEN, f"{stop}Not assessed: {why}.")
    worst = found.tightest()
    if worst is None:
        return Verdict(BAD if stop else OPEN, f"{stop}No limit applies to anything that was assessed.")
    words = "Every assessed quantity is within its limit" if found.passed else "A limit is exceeded"
    state = GOOD if found.passed and not stop else BAD
    return Verdict(state, f"{stop}{words}; {_tightest(worst)}.")


def _tightest(row: ZoneValue) -> str:
    """The worst margin in words."""
    value, limit = row.worst, row.worst.limit
    shown, margin = value.quantity.shown, row.margin
    unit = "" if shown.symbol == "1" else shown.symbol
    at_most = quantity(limit.value * shown.factor, unit) if limit else ""
    number, kind = value.value, ""
    if margin is not None and value.margin is not None and margin < value.margin and row.estimate is not None:
        number, kind = row.estimate, ", estimated maximum"
    place = f"{value.section.label}, section {value.section.number}" + (f": {value.place}" if value.place else "")
    return (
        f"worst margin {quantity(100.0 * (margin or 0.0), '%', '.0f')}: {value.quantity.symbol} = "
        f"{quantity(number * shown.factor, unit)}{kind} of {at_most} ({value.quantity.words}; {place})"
    )


def identity(results: Sequence[Result], sources: Sequence[str]) -> list[tuple[str, list[str]]]:
    """Rows of the table of who is who: a name, and a text for every result."""
    rows = [
        ("title", [r.title for r in results]),
        ("file", list(sources)),
        ("analysis", [r.analysis for r in results]),
        ("status", [_status(r) for r in results]),
        ("extent", [_extent(r) for r in results]),
        ("vehicle", [_named_in(r, "vehicle", "model") for r in results]),
        ("contact", [_contact(r) for r in results]),
        ("integration", [_integration(r) for r in results]),
    ]
    versions = sorted({k for r in results for k in r.dataset.attrs if k.endswith("_version") and k != "format_version"})
    ordered = sorted(versions, key=lambda k: not k.startswith("wrsim"))
    rows += [(k.removesuffix("_version"), [str(r.dataset.attrs.get(k, "")) for r in results]) for k in ordered]
    return [(name, values) for name, values in rows if any(values)]


def inputs(result: Result) -> list[tuple[str, str]]:
    """Files that the result was computed from, each with its SHA-256; none for a result of an older wrsim."""
    found = from_json(str(result.dataset.attrs.get("inputs", "{}"))) or {}
    return [(str(name), str(digest)) for name, digest in found.items()]


def _named_in(result: Result, table: str, key: str) -> str:
    found = table_of_scenario(result.dataset, table) or {}
    text, speed = str(found.get(key, "")), found.get("speed_kmh")
    return text + (f", {speed:g} km/h" if text and isinstance(speed, int | float) else "")


def _contact(result: Result) -> str:
    attributes = result.dataset.attrs
    if "resolved_with" in attributes:
        return f"solved again with {attributes['resolved_with']}"
    found = table_of_scenario(result.dataset, "contact") or {}
    return ", ".join(f"{k} = {v}" for k, v in found.items() if k in ("normal", "tangential", "friction"))


def _status(result: Result) -> str:
    return result.status + (f": {result.stop_reason}" if result.stop_reason else "")


def _extent(result: Result) -> str:
    dataset = result.dataset
    if "time" in dataset.dims and dataset.sizes["time"]:
        time = float(dataset["time"].values[-1])
        words = f"{dataset.sizes['time']} samples over {quantity(time, 's')}"
        if "distance" in dataset.coords:
            way = dataset["distance"].values
            words += f", {formatted(float(way[0]), '.1f')} to {quantity(float(way[-1]), 'm', '.1f')}"
        return words
    return f"{dataset.sizes['pose']} poses" if "pose" in dataset.dims else ""


def _integration(result: Result) -> str:
    attributes = result.dataset.attrs
    if not {"integrator", "step_s"} <= attributes.keys():
        return ""
    return f"{attributes['integrator']}, steps of {quantity(1e3 * float(attributes['step_s']), 'ms')}"


def assessment_rows(found: Sequence[Assessment | None]) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Rows by quantity and class of track, with cells of every assessment that has them; sources of limits by letter.

    first: how many rows the quantity has, in the first of them, and 0 in the others.
    """
    keys: dict[tuple[str, str], dict[str, Any]] = {}
    letters: dict[str, str] = {}
    for i, each in enumerate(found):
        for row in each.zones() if each is not None else ():
            quantity, zone = row.worst.quantity, row.worst.section.zone
            own = keys.setdefault(
                (quantity.key, zone),
                {
                    "key": quantity.key,
                    "symbol": quantity.symbol,
                    "words": quantity.words,
                    "unit": "" if quantity.shown.symbol == "1" else quantity.shown.symbol,
                    "zone": zone,
                    "cells": [None] * len(found),
                },
            )
            limit = row.worst.limit
            letter = ""
            if limit is not None:
                letter = letters.setdefault(f"{limit.source} [{limit.mark}]", snapshot_letter(len(letters)))
            own["cells"][i] = {**row.cells(), "sections": row.sections, "passed": row.passed, "letter": letter}
    order = {key: i for i, key in enumerate(dict.fromkeys(key for key, _ in keys))}
    rows = sorted(keys.values(), key=lambda row: order[row["key"]])
    counts = Counter(row["key"] for row in rows)
    for line in rows:
        line["first"] = counts.pop(line["key"], 0)
    return rows, {letter: source for source, letter in letters.items()}


def limits_of(found: Sequence[Assessment | None]) -> dict[str, list[tuple[str, float]]]:
    """Limits to draw across histories: of the track shifting force both ways, of Y/Q.

    Of limits that lie as near each other as those of wheelsets of nearly one load, the least.
    """
    lines: dict[str, set[float]] = {"sum_Y": set(), "Y_over_Q": set(), "Q": set()}
    for each in found:
        for value in each.values if each is not None else ():
            if value.limit is not None and value.quantity.key in lines:
                lines[value.quantity.key].add(round(value.limit.value * value.quantity.shown.factor, 3))
    drawn: dict[str, list[tuple[str, float]]] = {}
    for key, values in lines.items():
        apart: list[float] = []
        for v in sorted(values):
            if not apart or v > APART * apart[-1]:
                apart.append(v)
        both = [*apart, *(-v for v in apart)] if key == "sum_Y" else apart
        drawn[key] = [(f"limit {formatted(v)}", v) for v in both]
    return drawn


def cards(results: Sequence[Result], names: Sequence[str]) -> list[tuple[str, list[Table]]]:
    """For every wheelset a card: its name, tables of its peaks."""
    summaries = [r.summary() for r in results]
    sets = list(dict.fromkeys(name for s in summaries for name in s.get("wheelsets", {})))
    words = numbered(sets) if len({tuple(s.get("wheelsets", {})) for s in summaries}) == 1 else {n: n for n in sets}
    of = {name: [s.get("wheelsets", {}).get(name) for s in summaries] for name in sets}
    return [(words[name], wheelset_tables(of[name], names)) for name in sets]


def curves(results: Sequence[Result], names: Sequence[str]) -> list[Table]:
    """Medians in full curves, of every result."""
    found = []
    for result, name in zip(results, names, strict=True):
        own = result.summary().get("wheelsets", {})
        tables = curve_tables(list(numbered(tuple(own)).values()), list(own.values()), MOST_CURVES)
        found += [replace(t, title=f"{name}: {t.title}" if name else t.title) for t in tables]
    return found


def events(results: Sequence[Result], names: Sequence[str]) -> Table | None:
    """What happened on the way, and where a run stopped."""
    rows: list[tuple[str, ...]] = []
    for result, name in zip(results, names, strict=True):
        dataset = result.dataset
        who = (name,) if len(names) > 1 else ()
        if "event" in dataset.dims:
            columns = (dataset[f"event_{key}"].values for key in ("distance", "time", "label"))
            rows += [(*_place(s, t), str(w), *who) for s, t, w in zip(*columns, strict=True)]
        if result.status == "stopped" and "stop_distance_m" in dataset.attrs:
            s, t = (float(dataset.attrs[f"stop_{key}"]) for key in ("distance_m", "time_s"))
            rows.append((*_place(s, t), f"stopped: {result.stop_reason}", *who))
    heads = ("place", "time", "what happened", *(("result",) if len(names) > 1 else ()))
    return Table("", tuple(map(Column, heads)), rows) if rows else None


def _place(distance: float, time: float) -> tuple[str, str]:
    return quantity(float(distance), "m", ".1f"), quantity(float(time), "s", ".3f")
