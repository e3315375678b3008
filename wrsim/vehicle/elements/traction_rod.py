"""A spring and damper along the line between two points: ``kind = "traction-rod"``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, ClassVar

from wrsim.inputs.section import Fault
from wrsim.inputs.values import number, positive
from wrsim.vehicle.elements.keys import Axes, ElementTable, Glyph, Joint, Place
from wrsim.vehicle.elements.strut import Strut, both_ways


class TractionRodTable(ElementTable, kind="traction-rod"):
    """A spring and damper along the line between two points."""

    glyph: ClassVar[Glyph | None] = Glyph("_", "#222222")

    body_mm: Place
    """Its end on the body."""
    to_mm: Place
    """Its end on the body that it leads to."""
    stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Stiffness along its line."""
    damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0
    """Damping along its line."""
    clearance_mm: Annotated[float, number(0, 1000, "mm")] = 0.0
    """Play of its ends: how far its line shortens or grows without a force of its stiffness."""

    def consistency(self) -> Iterator[Fault]:
        """A rod has a length."""
        if math.dist(self.body_mm, self.to_mm) < 1e-3:
            yield Fault("to_mm", "is the same point as body_mm: a rod needs a length")

    def element(self, joint: Joint, axes: Axes) -> Strut:
        ends = axes.point(self.body_mm), axes.point(self.to_mm)
        stiffness, play = 1e3 * self.stiffness_kN_per_m, 1e-3 * self.clearance_mm
        table = both_ways(((play, 0.0), (play + 1.0, stiffness))) if play else ()
        return Strut(*joint, ends, None, 0.0 if play else stiffness, 1e3 * self.damping_kNs_per_m, spring_table=table)
