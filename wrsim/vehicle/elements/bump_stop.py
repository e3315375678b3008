"""A stop of a given travel: ``kind = "bump-stop"``."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf
from typing import ClassVar

from wrsim.inputs.section import Fault
from wrsim.inputs.values import Switch
from wrsim.vehicle.elements.keys import AXIS, Along, Axes, ElementTable, ForceOfTravel, Glyph, Joint, Place
from wrsim.vehicle.elements.strut import Strut, along_axis, both_ways


class BumpStopTable(ElementTable, kind="bump-stop"):
    """A stop of a given travel; force against travel, the same in both directions or in one."""

    aliases: ClassVar[dict[str, str]] = {**ElementTable.aliases, "travel_mm_force_kN": "gap_mm_force_N"}
    glyph: ClassVar[Glyph | None] = Glyph("X", "#B00020")

    at_mm: Place
    """Point at which it acts."""
    direction: Along
    """Axis of the body along which it acts."""
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
        axis, at = AXIS[self.direction], axes.point(self.at_mm)
        rows = self.travel_mm_force_kN
        free = ((rows[0][0] - 1.0, 0.0), *rows)  # nothing before the stop is met
        table = along_axis(both_ways(rows) if self.both_ways else free, axes.signs[axis])
        low, high = table[0][0], table[-1][0]
        if not self.both_ways:  # the other way it is free as far as anything goes
            low, high = (low, inf) if axes.signs[axis] < 0.0 else (-inf, high)
        return Strut(*joint, (at, at), axis, spring_table=table, limits=(low, high))
