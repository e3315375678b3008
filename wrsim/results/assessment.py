"""An assessment: values of sections of track, their limits, and what follows. Made by ``wrsim.analysis.assessment``.

Values are in SI units; ``Quantity.shown`` is the unit in which people read them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.results.channels import SHOWN, Shown
from wrsim.results.table import formatted, quantity

Array = NDArray[np.float64]

Influence = Literal["cant_deficiency", "curvature", "speed"]
"""What the sections of a class differ in, by which values are estimated."""

INFLUENCES: dict[Influence, Shown] = {
    "cant_deficiency": SHOWN["mm"],
    "curvature": SHOWN["1/km"],
    "speed": SHOWN["km/h"],
}
"""In which unit people read them."""

TRANSITION = "transition"
"""Class of what lies between curves."""

SAFETY, LOADING, RIDE, INFORMATION = "running safety", "track loading", "ride characteristics", "information"

DERAILMENT_LIMIT, DERAILMENT_RADIUS = 0.8, 250.0
"""Limit of Y/Q by EN 14363, from memory of the standard, and the radius [m] below which it sets none."""


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
class Quantity:
    """What is assessed: its symbol, its meaning, its group, how it is evaluated, and from where that comes."""

    key: str
    symbol: str
    words: str
    group: str
    shown: Shown
    evaluation: str
    source: str
    quasi_static: bool = False


@dataclass(frozen=True)
class Limit:
    """The largest value allowed, and its source; ``mark``: "pub", "mem" as in the reference data, or "file"."""

    value: float
    source: str
    mark: str

    @property
    def words(self) -> str:
        """Source and mark."""
        return f"{self.source} [{self.mark}]"


@dataclass(frozen=True)
class Value:
    """One quantity in one section, on one wheelset and, where it belongs to a wheel, on that wheel; or at a point.

    label: the wheelset's name with its number from the front.
    """

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
        return None if self.limit is None else bool(self.value <= self.limit.value)

    @property
    def margin(self) -> float | None:
        """What is left to the limit, as a part of it; negative beyond it."""
        return None if self.limit is None else 1.0 - self.value / self.limit.value

    @property
    def place(self) -> str:
        """Wheelset and wheel, or the point, in words; empty where there is only one."""
        return " ".join(part for part in (self.label, self.wheel, self.point) if part)


@dataclass(frozen=True, eq=False)
class Regression:
    """over: influences that the sections differ in; at: where the value is estimated; slope: of the value, for each of
    them; fit: value there; deviation: s; estimate: the upper bound. For pictures: places (n,) of the sections along the
    first influence, and their values (n,) moved to where the others are when estimated. SI units.
    """

    over: tuple[Influence, ...]
    at: tuple[float, ...]
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
        return bool(self.worst.passed) and (self.estimate is None or self.estimate <= limit.value)

    @property
    def margin(self) -> float | None:
        """What is left to the limit, of the worst section or of the estimated maximum, as a part of it."""
        worst, limit = self.worst.margin, self.worst.limit
        if worst is None or limit is None or self.estimate is None:
            return worst
        return min(worst, 1.0 - self.estimate / limit.value)

    @property
    def number(self) -> str:
        """How many sections, in words: where some do not count, how many do."""
        return str(self.sections) if self.counted == self.sections else f"{self.counted} of {self.sections}"

    def cells(self) -> dict[str, str]:
        """Cells of tables, in the unit for readers; empty texts where there is nothing."""
        worst, limit = self.worst, self.worst.limit
        factor = worst.quantity.shown.factor
        return {
            "worst": formatted(worst.value * factor),
            "estimate": "" if self.estimate is None else formatted(self.estimate * factor),
            "limit": "" if limit is None else formatted(limit.value * factor),
            "margin": "" if worst.margin is None else quantity(100.0 * worst.margin, "%", ".0f"),
            "verdict": "" if self.passed is None else "ok" if self.passed else "EXCEEDED",
            "worst in": f"section {worst.section.number}" + (f": {worst.place}" if worst.place else ""),
        }


@dataclass(frozen=True, eq=False)
class Assessment:
    """Everything that an assessment found.

    zones: every quantity over every zone, in the order of ``values``; notes: what could not be assessed, and why;
    settings: numbers it rests on, in units for readers; signals: what was evaluated in each run, by its name, against
    distance, for pictures (dimensions ``place``, ``wheelset``, ``wheel``); the name of a lone run is empty; track: how
    uneven it is, nothing on smooth track; estimate_over: influences by which values are estimated, none for the
    one-dimensional method.
    """

    title: str
    sections: tuple[AssessedSection, ...]
    values: tuple[Value, ...]
    zones: tuple[ZoneValue, ...]
    notes: tuple[str, ...]
    settings: Mapping[str, float | str]
    signals: Mapping[str, xr.Dataset] = field(repr=False)
    track: tuple[TrackQuality, ...] = ()
    estimate_over: tuple[Influence, ...] = ()

    @property
    def passed(self) -> bool:
        """True when no value and no estimated maximum is beyond its limit."""
        return all(row.passed is not False for row in self.zones)

    def tightest(self) -> ZoneValue | None:
        """Where least is left to a limit; None where there are no limits."""
        limited = [row for row in self.zones if row.margin is not None]
        return min(limited, key=lambda row: row.margin or 0.0, default=None)

    def of(self, key: str) -> list[Value]:
        """Values of one quantity."""
        return [value for value in self.values if value.quantity.key == key]
