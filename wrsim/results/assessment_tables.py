"""Tables of an assessment: for people, and for ``assessment.json`` and ``assessment.csv`` in units for readers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from wrsim.results.assessment import INFLUENCES, AssessedSection, Assessment, Influence, Regression, Value, ZoneValue
from wrsim.results.files import as_csv, as_json
from wrsim.results.render import as_rows
from wrsim.results.table import Cell, Column, Table, formatted, quantity


def assessment_dict(found: Assessment) -> dict[str, Any]:
    """What ``assessment.json`` holds."""
    quantities = [
        {"key": q.key, "symbol": q.symbol, "name": q.words, "group": q.group, "unit": q.shown.symbol}
        | {"evaluation": q.evaluation, "source": q.source}
        for q in dict.fromkeys(v.quantity for v in found.values)
    ]
    track = [
        {
            "section": t.section.number,
            "direction": t.direction,
            "deviation_mm": 1e3 * t.deviation,
            "largest_mm": 1e3 * t.largest,
            "step_by_deviation": t.by_deviation,
            "step_by_largest": t.by_largest,
            "TL90": t.tl90,
        }
        for t in found.track
    ]
    return {
        "title": found.title,
        "passed": found.passed,
        "runs": [name for name in found.signals if name],
        "settings": dict(found.settings),
        "notes": list(found.notes),
        "quantities": quantities,
        "sections": [_section(s) for s in found.sections],
        "track_quality": track,
        "zones": [_zone(z) for z in found.zones],
        "values": [_value(v) for v in found.values],
    }


def assessment_json(found: Assessment) -> bytes:
    """Content of ``assessment.json``."""
    return as_json(assessment_dict(found), indent=1)


def assessment_csv(found: Assessment) -> bytes:
    """Content of ``assessment.csv``: one row per value."""
    columns = (
        "quantity", "unit", "run", "section", "zone", "start_m", "end_m", "radius_m", "wheelset", "wheel", "point",
        "value", "limit", "margin", "passed", "limit_source",
    )  # fmt: skip
    rows = [_section(v.section) | _value(v) | {"unit": v.quantity.shown.symbol} for v in found.values]
    return as_csv(
        as_rows(Table("", tuple(Column(key=c) for c in columns), [[row[c] for c in columns] for row in rows]))
    )


def _number(value: float | None, factor: float = 1.0) -> float | None:
    """A plain number that JSON knows; None for what is none."""
    return None if value is None or not math.isfinite(value) else float(value) * factor


def _section(s: AssessedSection) -> dict[str, Any]:
    return {
        "section": s.number,
        "run": s.run,
        "zone": s.zone,
        "start_m": s.start,
        "end_m": s.end,
        "radius_m": _number(s.radius),
        "speed_kmh": 3.6 * s.speed,
        "cant_deficiency_mm": 1e3 * s.cant_deficiency,
        "short": s.short,
        "counts": s.counts,
    }


def _value(v: Value) -> dict[str, Any]:
    factor = v.quantity.shown.factor
    return {
        "quantity": v.quantity.key,
        "section": v.section.number,
        "wheelset": v.wheelset,
        "wheel": v.wheel,
        "point": v.point,
        "value": _number(v.value, factor),
        "limit": None if v.limit is None else _number(v.limit.value, factor),
        "limit_source": "" if v.limit is None else v.limit.words,
        "margin": _number(v.margin),
        "passed": v.passed,
    }


def _zone(z: ZoneValue) -> dict[str, Any]:
    factor, r = z.worst.quantity.shown.factor, z.regression
    over = [
        {"influence": name, "unit": own.symbol, "at": at * own.factor, "slope": b * factor / own.factor}
        for name, at, b in (() if r is None else zip(r.over, r.at, r.slope, strict=True))
        for own in (INFLUENCES[name],)
    ]
    return {
        "zone": z.worst.section.zone,
        "sections": z.sections,
        "counted": z.counted,
        "mean": _number(z.mean, factor),
        "deviation": _number(z.deviation, factor),
        "estimated_maximum": _number(z.estimate, factor),
        "regression": r and {"fit": r.fit * factor, "deviation": r.deviation * factor, "over": over},
        "passed": z.passed,
        "worst": _value(z.worst),
    }


def assessment_numbers(found: Assessment) -> list[Table]:
    """For people: sections, the worst value of every quantity and class of track, regressions, track, notes."""
    tables = [_sections_table(found)]
    letters: dict[str, str] = {}
    rows: list[list[Cell]] = []
    last = ""
    for row in found.zones:
        limit, own, cells = row.worst.limit, row.worst.quantity, row.cells()
        source = "" if limit is None else limit.words
        letter = letters.setdefault(source, chr(ord("a") + len(letters) % 26)) if source else ""
        head = [own.symbol, own.shown.unit] if own.key != last else ["", ""]
        numbers = [cells[key] for key in ("worst", "estimate", "limit", "margin", "verdict")]
        rows.append([*head, f"{row.worst.section.zone} ({row.number})", *numbers, letter, cells["worst in"]])
        last = own.key
    words = ("quantity", "unit", "class (sections)", "worst", "estimate", "limit", "margin", "", "by", "worst in")
    tables.append(Table("", tuple(map(Column, words)), rows))
    tables += [*_regressions_table(found), *_track_table(found)]
    verdict = "every quantity is within its limit" if found.passed else "A LIMIT IS EXCEEDED"
    notes = [*(f"{letter}  {source}" for source, letter in letters.items()), *(f"note: {n}" for n in found.notes)]
    last_words = f"{verdict}; [mem]: from memory of the standard, [pub]: from a published source"
    return [*tables, Table("", notes=(*notes, last_words))]


def _sections_table(found: Assessment) -> Table:
    several = bool(found.sections[0].run)
    rows: list[list[Cell]] = []
    for s in found.sections:
        remarks = ", ".join(word for word, so in (("short", s.short), ("does not count", not s.counts)) if so)
        head: list[Cell] = [
            *([s.run] if several else []),
            str(s.number),
            s.label + (f" ({remarks})" if remarks else ""),
        ]
        rows.append([*head, s.start, s.end, 3.6 * s.speed, 1e3 * s.cant_deficiency])
    heads = [*([Column("run")] if several else []), Column("section"), Column("class")]
    heads += [Column("from", "m", ".1f"), Column("to", "m", ".1f"), Column("speed", "km/h", ".0f")]
    return Table(found.title, (*heads, Column("cant deficiency", "mm", ".0f")), rows)


def _regressions_table(found: Assessment) -> list[Table]:
    """How quantities with a limit depend on what the sections differ in, and which of them have no regression."""
    rows: list[Sequence[Cell]] = []
    short = set()
    for row in found.zones:
        r, own = row.regression, row.worst.quantity
        if r is None:
            short |= {row.worst.section.zone} if found.estimate_over else set()
        elif row.worst.limit is not None:
            factor = own.shown.factor
            slopes = {name: _slope(r, name, factor) for name in r.over}
            numbers = (value * factor for value in (r.fit, r.deviation, r.estimate))
            zone = f"{row.worst.section.zone} ({row.number})"
            rows.append((own.symbol, zone, *(slopes.get(name, "") for name in found.estimate_over), *numbers))
    none = f"no regression, too few sections or influences that go together: {', '.join(sorted(short))}"
    notes = (none,) if short else ()
    over = (Column(f"per {INFLUENCES[name].symbol} of {name}") for name in found.estimate_over)
    heads = (Column("quantity"), Column("class (sections)"), *over, Column("fit"), Column("s"), Column("estimate"))
    title = "estimated values by regression [mem]"
    return [Table(title, heads, rows, notes)] if rows else [Table("", notes=notes)] if notes else []


def _slope(r: Regression, name: Influence, factor: float) -> str:
    """What a quantity changes by with an influence, and the value of that influence where it is estimated."""
    own, i = INFLUENCES[name], r.over.index(name)
    return f"{formatted(r.slope[i] * factor / own.factor, '.3g')} at {quantity(r.at[i] * own.factor, own.symbol)}"


def _track_table(found: Assessment) -> list[Table]:
    """How uneven the sections are."""
    rows = [
        (str(t.section.number), t.direction, 1e3 * t.deviation, 1e3 * t.largest, t.by_deviation, t.by_largest, t.tl90)
        for t in found.track
    ]
    heads = (Column("section"), Column("direction"), Column("deviation", "mm", ".2f"), Column("largest", "mm", ".2f"))
    steps = map(Column, ("UIC 518 by deviation", "by largest", "TL90 of EN 14363"))
    return [Table("Track, worse rail, waves of 3 to 25 m [mem]", (*heads, *steps), rows)] if rows else []
