"""A viscous damper, perhaps behind a spring: ``kind = "damper"``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, ClassVar

from wrsim.inputs.section import Fault
from wrsim.inputs.values import positive
from wrsim.vehicle.elements.keys import AXIS, Along, Axes, ElementTable, ForceOfVelocity, Glyph, Joint, Place
from wrsim.vehicle.elements.strut import Strut, both_ways


class DamperTable(ElementTable, kind="damper"):
    """Viscous, along an axis (at_mm, direction) or along its line (body_mm, to_mm)."""

    one_of: ClassVar[tuple[str, ...]] = ("damping_kNs_per_m velocity_m_per_s_force_kN",)
    glyph: ClassVar[Glyph | None] = Glyph("s", "#D55E00")

    at_mm: Place | None = None
    """Point at which it acts along an axis."""
    direction: Along | None = None
    """Axis of the body along which it acts."""
    body_mm: Place | None = None
    """Its end on the body, where it acts along its own line."""
    to_mm: Place | None = None
    """Its end on the body that it leads to."""
    damping_kNs_per_m: Annotated[float, positive(1e5, "kN s/m")] | None = None
    """Force over velocity; or give a table."""
    velocity_m_per_s_force_kN: ForceOfVelocity | None = None
    """Force over velocity, row by row."""
    series_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")] | None = None
    """Stiffness of its mounting, in series with it; rigid unless given."""

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Where it is in one of two ways."""
        line = [key for key in ("body_mm", "to_mm") if key in raw]
        axis = [key for key in ("at_mm", "direction") if key in raw]
        if line and axis:
            yield Fault(line[0], f"cannot stand next to {' and '.join(axis)}: along a line or along an axis")
        elif len(line) == 1 or len(axis) == 1 or not (line or axis):
            needed = "goes with direction (along an axis); or give body_mm and to_mm (a line)"
            yield Fault("at_mm", needed, missing=True)

    def consistency(self) -> Iterator[Fault]:
        """A line has a length; a table of a damper behind a spring is read backwards."""
        if self.body_mm is not None and self.to_mm is not None and math.dist(self.body_mm, self.to_mm) < 1e-3:
            yield Fault("to_mm", "is the same point as body_mm: a damper along a line needs a length")
        table = self.velocity_m_per_s_force_kN or ()
        flat = any(b[1] <= a[1] for a, b in pairwise(table))
        if self.series_stiffness_kN_per_m is not None and flat:
            yield Fault("velocity_m_per_s_force_kN", "must rise everywhere next to series_stiffness_kN_per_m")

    def element(self, joint: Joint, axes: Axes) -> Strut:
        points = [axes.point(point) for point in self.points()]  # one on an axis, two on a line
        series = self.series_stiffness_kN_per_m
        rows = tuple((v, 1e3 * f) for v, f in self.velocity_m_per_s_force_kN or ())
        return Strut(
            *joint, (points[0], points[-1]), None if self.direction is None else AXIS[self.direction],
            damping=1e3 * (self.damping_kNs_per_m or 0.0),
            series=None if series is None else 1e3 * series,
            damper_table=both_ways(rows) if rows and rows[0][0] >= 0.0 else rows,
        )  # fmt: skip
