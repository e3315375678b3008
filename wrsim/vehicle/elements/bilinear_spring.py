"""A nest of two springs, the second one touched under load: ``kind = "bilinear-spring"``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from wrsim.inputs.values import number, positive
from wrsim.vehicle.elements.element import Array, Element, Tables
from wrsim.vehicle.elements.keys import Along, Axes, AxialTable, Glyph, Joint
from wrsim.vehicle.elements.spring import BLUE
from wrsim.vehicle.elements.strut import Strut

FAR = 1.0
"""How far its table goes beyond its bends [m]; it goes on evenly there."""


@dataclass(frozen=True)
class BilinearSpring(Strut):
    """A strut along an axis that pushes with ``stiffness`` up to the force ``inner_from`` [N], and with ``inner``
    [N/m] more beyond it. It never pulls. Where it stands on this line at rest, the load says that it carries there.
    """

    inner: float = 0.0
    inner_from: float = 0.0

    def write(self, row: Any, preload: Array, tables: Tables) -> None:
        super().write(row, preload, tables)
        table = self.table(float(preload[0]))
        row.k, row.force_0 = 0.0, preload[0]
        row.spring_start, row.spring_rows = tables.store(table)

    def table(self, at_rest: float) -> tuple[tuple[float, float], ...]:
        """Rows (travel, what it takes from the force at rest) about the design position; at_rest [N]: its force there
        on the second body.
        """
        k, both, sign = self.stiffness, self.stiffness + self.inner, np.sign(at_rest)
        load = abs(at_rest)
        bend = (self.inner_from - load) / (k if load < self.inner_from else both)
        free = bend - self.inner_from / k
        compressed = (
            (free - FAR, 0.0),
            (free, 0.0),
            (bend, self.inner_from),
            (bend + FAR, self.inner_from + both * FAR),
        )
        rows = [(float(-sign * c), float(at_rest - sign * force)) for c, force in compressed]
        return tuple(sorted(rows))


class BilinearSpringTable(AxialTable, kind="bilinear-spring"):
    """A nest of springs that only pushes, the inner one touched from a certain load on: of freight wagons."""

    glyph: ClassVar[Glyph | None] = Glyph("p", BLUE, hollow=True)

    direction: Along = "z"
    """Axis of the body along which it acts."""
    stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Stiffness of the outer spring."""
    second_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Stiffness of the inner spring."""
    second_from_kN: Annotated[float, positive(1e4, "kN")]
    """Load from which on the inner spring carries as well."""
    damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0
    """Damping along the same axis."""

    def element(self, joint: Joint, axes: Axes) -> Element:
        return BilinearSpring(
            *self.placed(joint, axes), 1e3 * self.stiffness_kN_per_m, 1e3 * self.damping_kNs_per_m,
            inner=1e3 * self.second_stiffness_kN_per_m, inner_from=1e3 * self.second_from_kN,
        )  # fmt: skip
