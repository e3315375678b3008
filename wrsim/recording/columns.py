"""The columns of a recording, as in a TOML file beside the CSV."""

from collections.abc import Iterator
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field

from wrsim.inputs.section import Fault, Section
from wrsim.inputs.us_units import FOOT
from wrsim.inputs.values import List, Two, number, text
from wrsim.recording.systems import BANDS, BaseDifference, Chord, Inertial, MeasuringSystem, Plain
from wrsim.track.cant import Pivot
from wrsim.track.piecewise import Array

Quantity = Literal[
    "distance", "curvature", "gauge", "gauge_deviation", "cant", "twist",
    "alignment", "alignment_left", "alignment_right", "level", "level_left", "level_right",
]  # fmt: skip
Unit = Literal["m", "km", "mm", "cm", "um", "in", "ft", "yd", "mi", "ch", "1/km", "1/m", "deg", "mm/m", "permille"]
Positive = Literal["left", "right", "up", "down", "right rail higher", "left rail higher"]

LENGTHS = {"mm": 1e-3, "m": 1.0, "cm": 1e-2, "um": 1e-6, "in": 0.0254}
SLOPES = {"mm/m": 1e-3, "permille": 1e-3}
UNITS: dict[str, dict[str, float]] = {
    "distance": {"m": 1.0, "km": 1e3, "ft": FOOT, "yd": 3.0 * FOOT, "mi": 5280.0 * FOOT, "ch": 66.0 * FOOT},
    "curvature": {"1/km": 1e-3, "1/m": 1.0, "deg": 1.0},
    "twist": SLOPES | LENGTHS,
}
"""Units of a quantity, the usual one first; of all others: lengths. Degrees of curve: see `ChannelSection.si`."""
SIGNS: dict[str, tuple[Positive, Positive]] = {
    "curvature": ("left", "right"),
    "alignment": ("left", "right"),
    "level": ("up", "down"),
    "cant": ("right rail higher", "left rail higher"),
    "twist": ("right rail higher", "left rail higher"),
}
"""What may be positive; ours first."""
BASE = 3.0  # usual base of twist [m]


class ChannelSection(Section, header="[[channels]]"):
    """A column: quantity, unit, sign, and the measuring system of alignment and level."""

    column: Annotated[str, text('the name of a column in the CSV file such as "level_left"')]
    """Name of the column in the table's first line."""
    quantity: Quantity
    """What the column holds."""
    unit: Unit | None = None
    """Unit of its numbers; left out: mm, m of distance, 1/km of curvature, mm/m of twist."""
    positive: Positive | None = None
    """Which side is positive; left out: left, up, right rail higher."""
    chord_m: Annotated[
        Two[Annotated[float, number(0.2, 30, "m")]] | None,
        Field(description="two lengths in m, behind and ahead of the measuring point: [4, 6]"),
    ] = None
    """Chord that alignment or level was measured with."""
    band: Literal["D1", "D2", "D3"] | None = None
    """Band of wavelengths of EN 13848 that an inertial system gave."""
    band_m: Annotated[
        Two[Annotated[float, number(0.5, 500, "m")]] | None, Field(description="two rising wavelengths such as [3, 25]")
    ] = None
    """Another band of wavelengths of an inertial system."""
    base_m: Annotated[float, number(0.5, 30, "m")] | None = None
    """Base of twist, 3 m unless given, or length over which curvature was measured."""
    with_curvature: bool | None = None
    """Whether alignment holds the curve itself; left out: by the record."""

    def consistency(self) -> Iterator[Fault]:
        kind, signs = self.kind, SIGNS.get(self.kind, ())
        if self.unit is not None and self.unit not in self.units:
            yield Fault("unit", f"is none of {self.quantity}: must be {', '.join(self.units)}")
        if self.positive is not None and self.positive not in signs:
            allowed = " or ".join(f'"{s}"' for s in signs)
            yield Fault("positive", f"must be {allowed}" if signs else f"cannot be given: {self.quantity} has one sign")
        systems = [key for key in ("chord_m", "band", "band_m") if getattr(self, key) is not None]
        if kind not in ("alignment", "level"):
            for key in systems:
                yield Fault(key, "is for alignment and level only")
        elif len(systems) != 1:
            subject = f"has {' and '.join(systems)}" if systems else "has no measuring system"
            yield Fault((), f'{subject}: must be one of chord_m = [4, 6], band = "D1" or band_m = [3, 25]')
        if self.band_m is not None and not self.band_m[0] < self.band_m[1]:
            yield Fault("band_m", "must be two rising wavelengths")
        if self.base_m is not None and kind not in ("twist", "curvature"):
            yield Fault("base_m", "is for twist and curvature only")
        if self.with_curvature is not None and kind != "alignment":
            yield Fault("with_curvature", "is for alignment only")

    @property
    def kind(self) -> str:
        """The quantity without its rail."""
        return self.quantity.removesuffix("_left").removesuffix("_right")

    @property
    def units(self) -> dict[str, float]:
        """Units that the column may have and their size, the usual one first."""
        return UNITS.get(self.kind, LENGTHS)

    def si(self, values: Array) -> Array:
        """The column's numbers in SI units and our signs; degrees are those of 100 ft, R = 50 ft / sin(D / 2)."""
        unit: str = self.unit or next(iter(self.units))
        factor = self.units[unit] * (self.base if self.kind == "twist" and unit in SLOPES else 1.0)
        sign = -1.0 if self.kind in SIGNS and self.positive == SIGNS[self.kind][1] else 1.0
        return sign * (np.sin(np.radians(0.5 * values)) / (50.0 * FOOT) if unit == "deg" else factor * values)

    def turned(self) -> Self:
        """The same of a car that runs the other way: rails, signs and the ends of the chord exchanged."""
        side = self.quantity.removeprefix(self.kind)
        change: dict[str, object] = {"quantity": self.kind + {"_left": "_right", "_right": "_left"}.get(side, "")}
        if self.kind in ("curvature", "alignment", "cant"):
            usual, opposite = SIGNS[self.kind]
            change["positive"] = usual if self.positive == opposite else opposite
        if self.chord_m is not None:
            change["chord_m"] = self.chord_m[::-1]
        return self.model_copy(update=change)

    @property
    def base(self) -> float:
        """Base of twist, chord of curvature [m]."""
        return (BASE if self.quantity == "twist" else 0.0) if self.base_m is None else self.base_m

    @property
    def system(self) -> MeasuringSystem:
        """Measuring system of the column."""
        return self.shape_system or (BaseDifference(self.base) if self.quantity == "twist" else Plain())

    @property
    def shape_system(self) -> Chord | Inertial | None:
        """Measuring system of alignment or level; None for other quantities."""
        if self.chord_m is not None:
            return Chord(*self.chord_m)
        band = self.band_m if self.band is None else BANDS[self.band]
        return None if band is None else Inertial(*band)

    @property
    def description(self) -> str:
        """Quantity, unit, sign and measuring system, for tables."""
        parts = [self.quantity.replace("_", " "), f"in {self.unit or next(iter(self.units))}"]
        if self.kind in SIGNS:
            parts.append(f"positive: {self.positive or SIGNS[self.kind][0]}")
        if self.chord_m is not None:
            parts.append(f"chord {self.chord_m[0]:g} + {self.chord_m[1]:g} m")
        elif isinstance(self.system, Inertial):
            parts.append(f"inertial, {self.system.short:g} to {self.system.long:g} m")
        elif self.quantity == "twist":
            parts.append(f"base {self.base:g} m")
        return ", ".join(parts)


class ColumnsFile(Section, header="a column map"):
    """The columns of a recording, and the gauge of the line."""

    gauge_mm: Annotated[float, number(400, 2000, "nominal")] = 1435.0
    """Nominal gauge of the line."""
    cant_base_mm: Annotated[float, number(400, 2200, "mm between the rail tops, such as 1500")] | None = None
    """Distance that cant is measured over; left out: the gauge and 65 mm."""
    pivot: Pivot = "centre line"
    """What cant turns about, for the height of both rails in ramps of cant."""
    sides: Literal["car", "line"] = "car"
    """Left and right where distances fall: of the car that runs towards 0, or of the line with rising distance."""
    spikes: Literal["bridge", "keep"] = "bridge"
    """What becomes of single values that no rail can follow."""
    channels: Annotated[List[ChannelSection], Field(min_length=1)]
    """The columns that are used."""

    def consistency(self) -> Iterator[Fault]:
        seen: dict[tuple[object, ...], int] = {}
        for i, c in enumerate(self.channels):  # whole kilometres and the metres beyond them are two columns
            earlier = seen.setdefault((c.quantity, c.system, c.quantity == "distance" and c.unit), i)
            if earlier != i:
                same = f"channels[{earlier}] (column '{self.channels[earlier].column}')"
                yield Fault(("channels", i), f"is {c.quantity} like {same}: leave one of them out")
        names = [c.quantity for c in self.channels]
        if "distance" not in names:
            yield Fault("channels", 'needs one with quantity = "distance"')
        if set(names) <= {"distance"}:
            yield Fault("channels", "need something that was measured besides distance")
        if "gauge" in names and "gauge_deviation" in names:
            yield Fault("channels", "have gauge and gauge_deviation: leave one of them out")
        for kind in ("alignment", "level"):
            if kind in names and any(name in names for name in (f"{kind}_left", f"{kind}_right")):
                yield Fault("channels", f"have {kind} of the mean and of single rails: leave one of them out")
