"""Rubber and air springs after Berg, elastic, friction and viscous parts side by side: ``kind = "rubber-spring"`` and
``kind = "air-spring"``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

import numpy as np

from wrsim.inputs.section import Fault
from wrsim.inputs.values import number, positive
from wrsim.vehicle.elements.element import Element
from wrsim.vehicle.elements.keys import AXIS, Along, Axes, ElementTable, Glyph, Joint, Place
from wrsim.vehicle.elements.slider import Slider
from wrsim.vehicle.elements.spring import BLUE
from wrsim.vehicle.elements.strut import Strut, both_ways
from wrsim.vehicle.elements.tables import Table

SLOWEST, FASTEST, PER_DECADE = 1e-4, 3.0, 20
"""Velocities between which an orifice's force is tabulated [m/s], and how densely: within 0.2 % of the power law."""


class RubberSpringTable(ElementTable, kind="rubber-spring"):
    """Rubber in one direction: stiffer at small strokes (friction) and at high frequencies (viscous part)."""

    glyph: ClassVar[Glyph | None] = Glyph("H", BLUE)

    at_mm: Place
    """Point at which it acts."""
    direction: Along
    """Axis of the body along which it acts."""
    stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Elastic part: stiffness of slow, large strokes."""
    friction_force_kN: Annotated[float, positive(1e4, "kN")] | None = None
    """Largest force of the friction part; goes with friction_travel_mm."""
    friction_travel_mm: Annotated[float, positive(1000, "mm")] | None = None
    """Travel from rest over which friction comes to half of its largest force (Berg's x2)."""
    series_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")] | None = None
    """Viscous part: what it adds to the stiffness at high frequencies, in series with its damping."""
    damping_kNs_per_m: Annotated[float, positive(1e5, "kN s/m")] | None = None
    """Viscous part: its damping; goes with series_stiffness_kN_per_m."""

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Both numbers of a part or none."""
        yield from together(raw, "friction_force_kN", "friction_travel_mm")
        yield from together(raw, "series_stiffness_kN_per_m", "damping_kNs_per_m")

    def element(self, joint: Joint, axes: Axes) -> Element:
        at, series = axes.point(self.at_mm), self.series_stiffness_kN_per_m
        return Strut(
            *joint, (at, at), AXIS[self.direction], 1e3 * self.stiffness_kN_per_m,
            1e3 * (self.damping_kNs_per_m or 0.0),
            series=None if series is None else 1e3 * series,
            slider=friction_part(self.friction_force_kN, self.friction_travel_mm),
        )  # fmt: skip


class AirSpringTable(ElementTable, kind="air-spring"):
    """An air spring with its reservoir in one direction; the mass of the air in the pipe is left out."""

    glyph: ClassVar[Glyph | None] = Glyph("8", BLUE)

    at_mm: Place
    """Point at which it acts."""
    direction: Along
    """Axis of the body along which it acts."""
    stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Stiffness of slow strokes: bellows and reservoir together."""
    series_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")] | None = None
    """What fast strokes add to it, the pipe as good as closed; goes with orifice_damping."""
    orifice_damping: Annotated[float, positive(1e6, "kN (s/m)^n")] | None = None
    """Force of pipe or orifice at 1 m/s [kN]; goes with series_stiffness_kN_per_m."""
    orifice_exponent: Annotated[float, number(1, 2)] = 1.8
    """Exponent n of the velocity in that force."""
    friction_force_kN: Annotated[float, positive(1e4, "kN")] | None = None
    """Largest friction of the bellows; goes with friction_travel_mm."""
    friction_travel_mm: Annotated[float, positive(1000, "mm")] | None = None
    """Travel from rest over which friction comes to half of its largest force (Berg's x2)."""

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Both numbers of a part or none."""
        yield from together(raw, "series_stiffness_kN_per_m", "orifice_damping")
        yield from together(raw, "friction_force_kN", "friction_travel_mm")

    def element(self, joint: Joint, axes: Axes) -> Element:
        at, series = axes.point(self.at_mm), self.series_stiffness_kN_per_m
        table: Table = ()
        if self.orifice_damping is not None:
            table = orifice(1e3 * self.orifice_damping, self.orifice_exponent)
        return Strut(
            *joint, (at, at), AXIS[self.direction], 1e3 * self.stiffness_kN_per_m,
            series=None if series is None else 1e3 * series, damper_table=table,
            slider=friction_part(self.friction_force_kN, self.friction_travel_mm),
        )  # fmt: skip


def together(raw: dict[str, Any], one: str, other: str) -> Iterator[Fault]:
    """Two keys that go together."""
    for key, friend in ((one, other), (other, one)):
        if key in raw and friend not in raw:
            yield Fault(friend, f"must be given next to {key}", missing=True)


def friction_part(force_kN: float | None, travel_mm: float | None) -> Slider | None:
    """Berg's friction."""
    if force_kN is None or travel_mm is None:
        return None
    return Slider("berg", bound=1e3 * force_kN, distance=1e-3 * travel_mm)


def orifice(force: float, exponent: float) -> Table:
    """Rows (velocity [m/s], force [N]) of force |v|^exponent, both ways."""
    count = int(np.ceil(PER_DECADE * np.log10(FASTEST / SLOWEST)))
    velocities = np.geomspace(SLOWEST, FASTEST, count + 1)
    return both_ways(tuple((float(v), float(force * v**exponent)) for v in velocities))
