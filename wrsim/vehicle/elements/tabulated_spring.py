"""Force against travel in one direction: ``kind = "tabulated-spring"``, and ``kind = "bump-stop"``."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import Annotated, ClassVar

from wrsim.inputs.section import Fault
from wrsim.inputs.values import Switch, number
from wrsim.vehicle.elements.keys import AXIS, Axes, AxialTable, ForceOfTravel, Glyph, Joint
from wrsim.vehicle.elements.spring import BLUE
from wrsim.vehicle.elements.strut import Strut, along_axis, both_ways


class TabulatedSpringTable(AxialTable, kind="tabulated-spring"):
    """Force against travel in one direction."""

    glyph: ClassVar[Glyph | None] = Glyph("h", BLUE, hollow=True)

    travel_mm_force_kN: ForceOfTravel
    """Force over travel, row by row."""
    damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0
    """Damping along the same axis."""

    def element(self, joint: Joint, axes: Axes) -> Strut:
        table = along_axis(self.travel_mm_force_kN, axes.signs[AXIS[self.direction]])
        return Strut(*self.placed(joint, axes), damping=1e3 * self.damping_kNs_per_m, spring_table=table)


class BumpStopTable(AxialTable, kind="bump-stop"):
    """A stop of a given travel; force against travel, the same in both directions or in one."""

    aliases: ClassVar[dict[str, str]] = {**AxialTable.aliases, "travel_mm_force_kN": "gap_mm_force_N"}
    glyph: ClassVar[Glyph | None] = Glyph("X", "#B00020")

    travel_mm_force_kN: ForceOfTravel
    """Force over travel, row by row; the free travel has no force."""
    both_ways: Switch = True
    """Whether it stops both directions alike, or the positive one alone."""

    def consistency(self) -> Iterator[Fault]:
        """The table begins where the stop is met."""
        travel, force = self.travel_mm_force_kN[0]
        if travel < 0.0 or force != 0.0:
            yield Fault("travel_mm_force_kN", "must begin at a travel not below 0, with a force of 0")

    def element(self, joint: Joint, axes: Axes) -> Strut:
        sign, rows = axes.signs[AXIS[self.direction]], self.travel_mm_force_kN
        free = ((rows[0][0] - 1.0, 0.0), *rows)  # nothing before the stop is met
        table = along_axis(both_ways(rows) if self.both_ways else free, sign)
        low, high = table[0][0], table[-1][0]
        if not self.both_ways:  # the other way it is free as far as anything goes
            low, high = (low, inf) if sign < 0.0 else (-inf, high)
        return Strut(*self.placed(joint, axes), spring_table=table, limits=(low, high))
