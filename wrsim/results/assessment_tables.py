"""Tables of an assessment for files: ``assessment.json`` and ``assessment.csv``, in units for readers."""

from __future__ import annotations

import math
from typing import Any

from wrsim.results.assessment import Assessment, Quantity, Section, TrackQuality, Value, ZoneValue
from wrsim.results.files import as_csv, as_json
from wrsim.results.regression import SHOWN, Regression


def assessment_rows(found: Assessment) -> dict[str, Any]:
    """What ``assessment.json`` holds."""
    return {
        "title": found.title,
        "passed": found.passed,
        "runs": [name for name in found.signals if name],
        "settings": dict(found.settings),
        "notes": list(found.notes),
        "quantities": [_quantity(q) for q in dict.fromkeys(v.quantity for v in found.values)],
        "sections": [_section(s) for s in found.sections],
        "track_quality": [_track_row(t) for t in found.track],
        "zones": [_zone_row(z) for z in found.zones()],
        "values": [_value(v) for v in found.values],
    }


def assessment_json(found: Assessment) -> bytes:
    """Content of ``assessment.json``."""
    return as_json(assessment_rows(found), indent=1)


def assessment_csv(found: Assessment) -> bytes:
    """Content of ``assessment.csv``: one row per value."""
    return as_csv([_COLUMNS, *(_flat(v) for v in found.values)])


def _number(value: float | None, factor: float = 1.0) -> float | None:
    """A plain number that JSON knows; None for what is none."""
    return None if value is None or not math.isfinite(value) else float(value) * factor


def _quantity(q: Quantity) -> dict[str, Any]:
    named = {"key": q.key, "symbol": q.symbol, "name": q.words, "group": q.group, "unit": q.shown.symbol}
    return named | {"evaluation": q.evaluation, "source": q.source}


def _section(s: Section) -> dict[str, Any]:
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
        "limit_source": "" if v.limit is None else f"{v.limit.source} [{v.limit.mark}]",
        "margin": _number(v.margin),
        "passed": v.passed,
    }


def _zone_row(z: ZoneValue) -> dict[str, Any]:
    factor = z.worst.quantity.shown.factor
    return {
        "zone": z.worst.section.zone,
        "sections": z.sections,
        "counted": z.counted,
        "mean": _number(z.mean, factor),
        "deviation": _number(z.deviation, factor),
        "estimated_maximum": _number(z.estimate, factor),
        "regression": None if z.regression is None else _regression_row(z.regression, factor),
        "passed": z.passed,
        "worst": _value(z.worst),
    }


def _regression_row(r: Regression, factor: float) -> dict[str, Any]:
    return {
        "fit": r.fit * factor,
        "deviation": r.deviation * factor,
        "over": [
            {"influence": name, "unit": SHOWN[name][0], "at": at * SHOWN[name][1], "slope": b * factor / SHOWN[name][1]}
            for name, at, b in zip(r.over, r.at, r.slope, strict=True)
        ],
    }


def _track_row(t: TrackQuality) -> dict[str, Any]:
    return {
        "section": t.section.number,
        "direction": t.direction,
        "deviation_mm": 1e3 * t.deviation,
        "largest_mm": 1e3 * t.largest,
        "step_by_deviation": t.by_deviation,
        "step_by_largest": t.by_largest,
        "TL90": t.tl90,
    }


_COLUMNS = (
    "quantity", "unit", "run", "section", "zone", "start_m", "end_m", "radius_m", "wheelset", "wheel", "point", "value",
    "limit", "margin", "passed", "limit_source",
)  # fmt: skip


def _flat(v: Value) -> list[str]:
    row = _section(v.section) | _value(v) | {"unit": v.quantity.shown.symbol}
    return [_cell(row[key]) for key in _COLUMNS]


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
