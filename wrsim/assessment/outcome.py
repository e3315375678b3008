"""An assessment: values of sections of track, their limits, its tables. Made by ``wrsim.assessment``.

Values are in SI units; ``Quantity.shown`` is the unit in which people read them.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.assessment.limits import INFORMATION, QUANTITIES, Limit, Quantity
from wrsim.assessment.rules import RulesFile
from wrsim.results.channels import SHOWN, Shown
from wrsim.results.files import as_csv, as_json
from wrsim.results.moments import Array
from wrsim.results.table import Cell, Column, Table, as_rows, finite, formatted, quantity
from wrsim.results.units import converted

Influence = Literal["cant_deficiency", "curvature", "speed"]
"""What the sections of a class differ in, by which values are estimated."""

INFLUENCES: dict[Influence, Shown] = {
    "cant_deficiency": SHOWN["mm"], "curvature": SHOWN["1/km"], "speed": SHOWN["km/h"],
}  # fmt: skip
"""Units of influences for readers."""

TRANSITION = "transition"  # class of what lies between curves

NO_VERDICT = "no verdict: rules assess vehicles, and this is a run of a lone wheelset"
TO_CONFIRM = "*: from memory of the standard, to be confirmed against its text"


@dataclass(frozen=True)
class AssessedSection:
    """A piece of track that is assessed for itself.

    number: from 1; zone: its class; start, end [m]; radius [m]: of the mean curvature (of the sharpest one in a
    transition), positive to the left, infinite on straight track; speed [m/s] and cant deficiency [m] (over 1.5 m,
    positive where cant is missing): means; short: shorter than sections of that zone should be; run: its name, where
    several runs are assessed together; counts: in statistics of its zone, for its cant deficiency is one of a test.
    """

    number: int
    zone: str
    start: float
    end: float
    radius: float
    speed: float
    cant_deficiency: float
    short: bool
    run: str = ""
    counts: bool = True

    def holds(self, places: Array) -> NDArray[np.bool_]:
        """Which places along the track lie in it."""
        return (places >= self.start) & (places <= self.end)

    @property
    def label(self) -> str:
        """Words for tables: zone, radius and hand."""
        if math.isinf(self.radius) or self.zone == TRANSITION:
            return self.zone
        return f"{self.zone}, R {abs(self.radius):.0f} m {'left' if self.radius > 0.0 else 'right'}"


@dataclass(frozen=True)
class TrackQuality:
    """How uneven a section is, laterally (alignment) or vertically (longitudinal level), in waves of 3 to 25 m.

    deviation: standard deviation; largest value [m], both of the worse rail; by_deviation, by_largest: step QN of UIC
    518 that they keep; tl90: where the deviation lies beside the band TL90 of EN 14363: "below", "within" or "above".
    """

    section: AssessedSection
    direction: str
    deviation: float
    largest: float
    by_deviation: str
    by_largest: str
    tl90: str


@dataclass(frozen=True)
class Value:
    """One quantity in one section, on one wheelset and, where it belongs to a wheel, on that wheel; or at a point.
    label: the wheelset's name with its number from the front."""

    quantity: Quantity
    section: AssessedSection
    wheelset: str
    wheel: str
    value: float
    limit: Limit | None = None
    point: str = ""
    label: str = ""

    @property
    def passed(self) -> bool | None:
        """None where there is no limit."""
        return None if self.limit is None else bool(self.quantity.within(self.value, self.limit.value))

    @property
    def margin(self) -> float | None:
        """See `Quantity.margin`; None where there is no limit."""
        return None if self.limit is None else self.quantity.margin(self.value, self.limit.value)

    @property
    def where(self) -> str:
        """Section with the wheelset and wheel, or the point, where there are several."""
        place = " ".join(part for part in (self.label, self.wheel, self.point) if part)
        return f"section {self.section.number}" + (f": {place}" if place else "")


@dataclass(frozen=True, eq=False)
class Regression:
    """over: influences that the sections differ in; point: where the value is estimated; slope: of the value, for each
    of them; fit: value there; deviation: s; estimate: the upper bound. For pictures: places (n,) of the sections along
    the first influence, and their values (n,) moved to where the others are when estimated. SI units.
    """

    over: tuple[Influence, ...]
    point: tuple[float, ...]
    slope: tuple[float, ...]
    fit: float
    deviation: float
    estimate: float
    places: Array
    moved: Array


@dataclass(frozen=True)
class ZoneValue:
    """One quantity over all sections of a zone.

    worst: the section, wheelset and wheel nearest to or furthest beyond the limit; sections: how many; counted: those
    that count in statistics; mean and deviation of their largest values; estimate: estimated maximum, None with too few
    sections; regression: what it comes from where it goes by influences.
    """

    worst: Value
    sections: int
    counted: int
    mean: float
    deviation: float
    estimate: float | None
    regression: Regression | None = None

    @property
    def passed(self) -> bool | None:
        """The worst section and the estimated maximum within the limit; None where there is no limit."""
        limit = self.worst.limit
        if limit is None:
            return None
        estimated = self.worst if self.estimate is None else replace(self.worst, value=self.estimate)
        return bool(self.worst.passed and estimated.passed)

    @property
    def margin(self) -> float | None:
        """What is left to the limit, of the worst section or of the estimated maximum, as a part of it."""
        worst = self.worst.margin
        estimated = None if self.estimate is None else replace(self.worst, value=self.estimate).margin
        return worst if worst is None or estimated is None else min(worst, estimated)

    @property
    def zone(self) -> str:
        """Class of track with the number of sections; where some do not count, how many do."""
        number = str(self.sections) if self.counted == self.sections else f"{self.counted} of {self.sections}"
        return f"{self.worst.section.zone} ({number})"

    def cells(self) -> dict[str, str]:
        """Cells of tables, in the unit in use; empty texts where there is nothing."""
        worst, limit, factor = self.worst, self.worst.limit, converted(self.worst.quantity.shown).factor
        missing = "" if worst.quantity.group == INFORMATION else "none"
        return {
            "worst": formatted(worst.value * factor),
            "estimate": "" if self.estimate is None else formatted(self.estimate * factor),
            "limit": missing
            if limit is None
            else "at least " * worst.quantity.lowest + formatted(limit.value * factor),
            "margin": "" if worst.margin is None else quantity(100.0 * worst.margin, "%", ".0f"),
            "verdict": "" if self.passed is None else "ok" if self.passed else "EXCEEDED",
            "where": worst.where,
        }


@dataclass(frozen=True, eq=False)
class Assessment:
    """Everything that an assessment found.

    zones: every quantity over every zone, in the order of ``values``; notes: what could not be assessed, and why;
    settings: numbers it rests on, in units for readers; signals: evaluated signals of each run by its name (empty for a
    lone one) against distance (dimensions ``place``, ``wheelset``, ``wheel``); track: how uneven it is, nothing on
    smooth track; rules: by which it is assessed;
    estimate_over: influences by which values are estimated, none for the one-dimensional method; lone: of
    a single wheelset without a vehicle, of which the standard knows no verdict.
    """

    title: str
    sections: tuple[AssessedSection, ...]
    values: tuple[Value, ...]
    zones: tuple[ZoneValue, ...]
    notes: tuple[str, ...]
    settings: Mapping[str, float | str]
    signals: Mapping[str, xr.Dataset] = field(repr=False)
    rules: RulesFile = field(repr=False)
    track: tuple[TrackQuality, ...] = ()
    estimate_over: tuple[Influence, ...] = ()
    lone: bool = False

    @property
    def passed(self) -> bool:
        """True when no value and no estimated maximum is beyond its limit."""
        return all(row.passed is not False for row in self.zones)

    @property
    def unlimited(self) -> list[str]:
        """Symbols of what is judged, not given for information, but has no limit or no value in some class of track."""
        judged = [
            QUANTITIES[clause.quantity] for clause in self.rules.judging("axle", "bogie", "stop", "frame", "body")
        ]
        lacking = {row.worst.quantity.key for row in self.zones if row.worst.limit is None}
        lacking |= {q.key for q in judged} - {row.worst.quantity.key for row in self.zones}
        return [q.symbol for q in dict.fromkeys(judged) if q.key in lacking and q.group != INFORMATION]

    @property
    def verdict(self) -> str:
        """In words."""
        if self.lone:
            return NO_VERDICT
        without = f"; without a limit or a value here: {', '.join(self.unlimited)}" if self.unlimited else ""
        subject = "every quantity with a limit" if self.unlimited else "every quantity"
        return f"{subject} is within its limit{without}" if self.passed else f"A LIMIT IS EXCEEDED{without}"

    def tightest(self) -> ZoneValue | None:
        """Where least is left to a limit; None where there are no limits."""
        limited = [row for row in self.zones if row.margin is not None]
        return min(limited, key=lambda row: row.margin or 0.0, default=None)

    def of(self, key: str) -> list[Value]:
        """Values of one quantity."""
        return [value for value in self.values if value.quantity.key == key]


def assessment_dict(assessment: Assessment) -> dict[str, Any]:
    """Numbers of ``assessment.json``."""
    quantities = [
        {"key": q.key, "symbol": q.symbol, "name": q.meaning, "group": q.group, "unit": q.shown.symbol}
        | {"evaluation": q.evaluation, "source": q.source}
        for q in dict.fromkeys(v.quantity for v in assessment.values)
    ]
    track = [
        {"section": t.section.number, "direction": t.direction, "deviation_mm": 1e3 * t.deviation}
        | {"largest_mm": 1e3 * t.largest, "step_by_deviation": t.by_deviation, "step_by_largest": t.by_largest}
        | {"TL90": t.tl90}
        for t in assessment.track
    ]
    return {
        "title": assessment.title, "passed": None if assessment.lone else assessment.passed,
        "runs": [name for name in assessment.signals if name],
        "settings": dict(assessment.settings), "notes": list(assessment.notes), "quantities": quantities,
        "sections": list(map(_section, assessment.sections)), "track_quality": track,
        "zones": list(map(_zone, assessment.zones)), "values": list(map(_value, assessment.values)),
    }  # fmt: skip


def assessment_json(assessment: Assessment) -> bytes:
    """Content of ``assessment.json``."""
    return as_json(assessment_dict(assessment), indent=1)


def assessment_csv(assessment: Assessment) -> bytes:
    """Content of ``assessment.csv``: one row per value."""
    keys = (
        "quantity", "unit", "run", "section", "zone", "start_m", "end_m", "radius_m", "wheelset", "wheel", "point",
        "value", "limit", "margin", "passed", "limit_source",
    )  # fmt: skip
    rows = (_section(v.section) | _value(v) | {"unit": v.quantity.shown.symbol} for v in assessment.values)
    table = Table("", tuple(Column(key=key) for key in keys), [[row[key] for key in keys] for row in rows])
    return as_csv(as_rows(table))


def _section(s: AssessedSection) -> dict[str, Any]:
    return {
        "section": s.number, "run": s.run, "zone": s.zone, "start_m": s.start, "end_m": s.end,
        "radius_m": finite(s.radius), "speed_kmh": 3.6 * s.speed, "cant_deficiency_mm": 1e3 * s.cant_deficiency,
        "short": s.short, "counts": s.counts,
    }  # fmt: skip


def _value(v: Value) -> dict[str, Any]:
    factor = v.quantity.shown.factor
    return {
        "quantity": v.quantity.key, "section": v.section.number, "wheelset": v.wheelset, "wheel": v.wheel,
        "point": v.point, "value": finite(v.value, factor),
        "limit": None if v.limit is None else finite(v.limit.value, factor),
        "limit_source": "" if v.limit is None else v.limit.reference,
        "margin": finite(v.margin), "passed": v.passed,
    }  # fmt: skip


def _zone(z: ZoneValue) -> dict[str, Any]:
    factor, r = z.worst.quantity.shown.factor, z.regression
    over = [
        {"influence": name, "unit": scale.symbol, "at": point * scale.factor, "slope": b * factor / scale.factor}
        for name, point, b in (() if r is None else zip(r.over, r.point, r.slope, strict=True))
        for scale in (INFLUENCES[name],)
    ]
    return {
        "zone": z.worst.section.zone, "sections": z.sections, "counted": z.counted, "mean": finite(z.mean, factor),
        "deviation": finite(z.deviation, factor), "estimated_maximum": finite(z.estimate, factor),
        "regression": r and {"fit": r.fit * factor, "deviation": r.deviation * factor, "over": over},
        "passed": z.passed, "worst": _value(z.worst),
    }  # fmt: skip


def assessment_numbers(assessment: Assessment) -> list[Table]:
    """For people: sections, the worst value of every quantity and class of track, regressions, track, notes."""
    tables = [_sections_table(assessment)]
    letters: dict[str, str] = {}
    rows: list[list[Cell]] = []
    last = ""
    for row in assessment.zones:
        limit, judged, cells = row.worst.limit, row.worst.quantity, row.cells()
        letter = (
            "" if limit is None else letters.setdefault(limit.source + limit.star, chr(ord("a") + len(letters) % 26))
        )
        head = [judged.symbol, converted(judged.shown).unit] if judged.key != last else ["", ""]
        numbers = [cells[key] for key in ("worst", "estimate", "limit", "margin")] + [
            cells["verdict"] * (not assessment.lone)
        ]
        rows.append([*head, row.zone, *numbers, letter, cells["where"]])
        last = judged.key
    headings = ("quantity", "unit", "class (sections)", "worst", "estimate", "limit", "margin", "", "by", "where")
    tables.append(Table("", tuple(map(Column, headings)), rows))
    tables += [*_regressions_table(assessment), *_track_table(assessment)]
    notes = [*(f"{letter}  {source}" for source, letter in letters.items()), *(f"note: {n}" for n in assessment.notes)]
    confirm = (TO_CONFIRM,) if any(z.worst.limit is not None and z.worst.limit.star for z in assessment.zones) else ()
    return [*tables, Table("", notes=(*notes, assessment.verdict, *confirm))]


def _sections_table(assessment: Assessment) -> Table:
    several = bool(assessment.sections[0].run)
    rows: list[list[Cell]] = []
    for s in assessment.sections:
        remarks = ", ".join(word for word, so in (("short", s.short), ("does not count", not s.counts)) if so)
        head: list[Cell] = [s.run] if several else []
        head += [str(s.number), s.label + (f" ({remarks})" if remarks else "")]
        rows.append([*head, s.start, s.end, 3.6 * s.speed, 1e3 * s.cant_deficiency])
    heads = [*([Column("run")] if several else []), Column("section"), Column("class")]
    heads += [Column("from", "m", ".1f"), Column("to", "m", ".1f"), Column("speed", "km/h", ".0f")]
    return Table(assessment.title, (*heads, Column("cant deficiency", "mm", ".0f")), rows)


def _regressions_table(assessment: Assessment) -> list[Table]:
    """How quantities with a limit depend on what the sections differ in, and which of them have no regression."""
    rows: list[Sequence[Cell]] = []
    short = set()
    for row in assessment.zones:
        r, judged = row.regression, row.worst.quantity
        if r is None:
            short |= {row.worst.section.zone} if assessment.estimate_over else set()
        elif row.worst.limit is not None:
            factor, slopes = converted(judged.shown).factor, dict.fromkeys(assessment.estimate_over, "")
            for name, slope, point in zip(r.over, r.slope, r.point, strict=True):
                unit = converted(INFLUENCES[name])
                place = quantity(point * unit.factor, unit.symbol)
                slopes[name] = f"{formatted(slope * factor / unit.factor, '.3g')} at {place}"
            numbers = (value * factor for value in (r.fit, r.deviation, r.estimate))
            rows.append((judged.symbol, row.zone, *slopes.values(), *numbers))
    none = f"no regression, too few sections or influences that go together: {', '.join(sorted(short))}"
    notes = (none,) if short else ()
    over = (Column(f"per {INFLUENCES[name].symbol} of {name}") for name in assessment.estimate_over)
    heads = (Column("quantity"), Column("class (sections)"), *over, Column("fit"), Column("s"), Column("estimate"))
    title = "estimated values by regression [mem]"
    return [Table(title, heads, rows, notes)] if rows else [Table("", notes=notes)] if notes else []


def _track_table(assessment: Assessment) -> list[Table]:
    rows = [
        (str(t.section.number), t.direction, 1e3 * t.deviation, 1e3 * t.largest, t.by_deviation, t.by_largest, t.tl90)
        for t in assessment.track
    ]
    heads = (Column("section"), Column("direction"), Column("deviation", "mm", ".2f"), Column("largest", "mm", ".2f"))
    steps = map(Column, ("UIC 518 by deviation", "by largest", "TL90 of EN 14363"))
    return [Table("Track quality, D1 (3-25 m), worse rail [mem]", (*heads, *steps), rows)] if rows else []
