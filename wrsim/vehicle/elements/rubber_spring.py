"""Rubber and air springs after Berg, elastic, friction and viscous parts side by side: ``kind = "rubber-spring"`` and
``kind = "air-spring"``."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np

from wrsim.inputs.values import number, positive
from wrsim.vehicle.elements.element import Element, Slider, Table
from wrsim.vehicle.elements.keys import Axes, AxialTable, Glyph, Joint
from wrsim.vehicle.elements.spring import BLUE
from wrsim.vehicle.elements.strut import Strut, both_ways

SLOWEST, FASTEST, PER_DECADE = 1e-4, 3.0, 20
"""Velocities between which an orifice's force is tabulated [m/s], and how densely: within 0.2 % of the power law."""
FRICTION_PART = "friction_force_kN friction_travel_mm"
"""Keys that go together."""


class RubberSpringTable(AxialTable, kind="rubber-spring"):
    """Rubber in one direction: stiffer at small strokes (friction) and at high frequencies (viscous part)."""

    together: ClassVar[tuple[str, ...]] = (FRICTION_PART, "series_stiffness_kN_per_m damping_kNs_per_m")
    glyph: ClassVar[Glyph | None] = Glyph("H", BLUE)

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

    def element(self, joint: Joint, axes: Axes) -> Element:
        series = self.series_stiffness_kN_per_m
        return Strut(
            *self.placed(joint, axes), 1e3 * self.stiffness_kN_per_m,
            1e3 * (self.damping_kNs_per_m or 0.0),
            series=None if series is None else 1e3 * series,
            slider=friction_part(self.friction_force_kN, self.friction_travel_mm),
        )  # fmt: skip


class AirSpringTable(AxialTable, kind="air-spring"):
    """An air spring with its reservoir in one direction; the mass of the air in the pipe is left out."""

    together: ClassVar[tuple[str, ...]] = (FRICTION_PART, "series_stiffness_kN_per_m orifice_damping")
    glyph: ClassVar[Glyph | None] = Glyph("8", BLUE)

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

    def element(self, joint: Joint, axes: Axes) -> Element:
        series = self.series_stiffness_kN_per_m
        table: Table = ()
        if self.orifice_damping is not None:
            table = orifice(1e3 * self.orifice_damping, self.orifice_exponent)
        return Strut(
            *self.placed(joint, axes), 1e3 * self.stiffness_kN_per_m,
            series=None if series is None else 1e3 * series, damper_table=table,
            slider=friction_part(self.friction_force_kN, self.friction_travel_mm),
        )  # fmt: skip


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
