"""A spring and a damper in one direction: what rods, dampers, stops and tabulated springs are made of."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from wrsim.vehicle.elements.element import Array, Element, Slider, Table, Tables, Triple


@dataclass(frozen=True)
class Strut(Element):
    """A spring and a damper in one direction: along an axis of the first body, or along the line between two points.

    ends: on the first and on the second body, one point where ``axis`` is given; axis: 0, 1, 2 or None for the line.
    stiffness [N/m] or spring_table: rows (travel [m], force [N]) that pushes back; damping [N s/m] or damper_table:
    rows (velocity [m/s], force [N]). series: stiffness behind the damper [N/m], None for a stiff one; with it the
    extension of the damping part is an unknown of its own. limits: travel between which the spring's table says
    something [m]. slider: friction beside them. Travel counts from the design position, positive when the second body
    moves along the axis, or when the line grows.
    """

    ends: tuple[Triple, Triple]
    axis: Literal[0, 1, 2] | None = None
    stiffness: float = 0.0
    damping: float = 0.0
    series: float | None = None
    spring_table: Table = ()
    damper_table: Table = ()
    limits: tuple[float, float] | None = None
    slider: Slider | None = None

    @property
    def points(self) -> tuple[Triple, Triple]:
        return self.ends

    @property
    def directions(self) -> Array:
        if self.axis is not None:
            return np.eye(3)[self.axis][None]
        return np.asarray(self._line / np.linalg.norm(self._line))[None]

    @property
    def stiffness_at_rest(self) -> Array:
        table = self.spring_table
        if not table:
            return np.array([self.stiffness])
        i = next((k for k in range(len(table) - 2) if table[k + 1][0] >= 0.0), len(table) - 2)
        return np.array([(table[i + 1][1] - table[i][1]) / (table[i + 1][0] - table[i][0])])

    @property
    def turns_with_first(self) -> bool:
        return self.axis is not None

    def force_on_second(self, readings: Array) -> Array:
        return readings[:, :3] if self.axis is not None else -readings[:, :1] * self.directions

    def reading_at_rest(self, preload: Array) -> Array:
        return preload[0] * self.directions[0] if self.axis is not None else np.array([-preload[0], 0.0, 0.0])

    @property
    def travel_place(self) -> int:
        return 3 + (self.axis or 0)

    @property
    def _line(self) -> Array:
        return np.array(self.ends[1]) - np.array(self.ends[0])

    def write(self, row: Any, preload: Array, tables: Tables) -> None:
        from wrsim.core.body import suspension as kernel

        row.kind = kernel.LINE if self.axis is None else kernel.AXIS
        row.direction = self.axis or 0
        row.length = np.linalg.norm(self._line)
        row.k, row.c = self.stiffness, self.damping
        row.force_0 = preload[0]
        if self.spring_table:
            row.force_0 += np.interp(0.0, *np.transpose(self.spring_table))
        row.spring_start, row.spring_rows = tables.store(self.spring_table)
        if self.series is None:
            row.damper_start, row.damper_rows = tables.store(self.damper_table)
        else:
            row.series, row.state = self.series, tables.unknown()
            velocity_of_force = tuple((force, velocity) for velocity, force in self.damper_table)
            row.damper_start, row.damper_rows = tables.store(velocity_of_force)
        if self.slider is not None:
            self.slider.write(row, tables, at_rest=abs(float(preload[0])))


def both_ways(rows: Table) -> Table:
    """The odd continuation of a table that begins at or above 0."""
    positive = tuple(row for row in rows if row[0] > 0.0)
    middle: Table = ((0.0, 0.0),)
    if rows[0][0] > 0.0 and rows[0][1] == 0.0:
        middle = ()  # free travel between the two stops
    return (*((-t, -f) for t, f in reversed(positive)), *middle, *positive)


def along_axis(rows: Table, sign: float) -> Table:
    """A table of force against travel, rows in mm and kN, along an axis that may be turned round; in SI units."""
    if sign < 0.0:
        return tuple((-t / 1e3, -1e3 * f) for t, f in reversed(rows))
    return tuple((t / 1e3, 1e3 * f) for t, f in rows)
