"""Force against travel in one direction: ``kind = "tabulated-spring"``."""

from __future__ import annotations

from typing import Annotated, ClassVar

from wrsim.inputs.values import number
from wrsim.vehicle.elements.keys import AXIS, Along, Axes, ElementTable, ForceOfTravel, Glyph, Joint, Place
from wrsim.vehicle.elements.spring import BLUE
from wrsim.vehicle.elements.strut import Strut, along_axis


class TabulatedSpringTable(ElementTable, kind="tabulated-spring"):
    """Force against travel in one direction."""

    glyph: ClassVar[Glyph | None] = Glyph("h", BLUE, hollow=True)

    at_mm: Place
    """Point at which it acts."""
    direction: Along
    """Axis of the body along which it acts."""
    travel_mm_force_kN: ForceOfTravel
    """Force over travel, row by row."""
    damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0
    """Damping along the same axis."""

    def element(self, joint: Joint, axes: Axes) -> Strut:
        axis, at = AXIS[self.direction], axes.point(self.at_mm)
        table = along_axis(self.travel_mm_force_kN, axes.signs[axis])
        damping = 1e3 * self.damping_kNs_per_m
        return Strut(*joint, (at, at), axis, damping=damping, spring_table=table)
