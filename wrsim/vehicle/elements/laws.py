"""Laws of suspension elements: along and about three axes, in one direction, in a plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from wrsim.vehicle.elements.element import ZERO, Array, Element, Slider, Table, Tables, Triple

FAR = 1.0
"""How far its table goes beyond its bends [m]; it goes on evenly there."""


@dataclass(frozen=True)
class Spring(Element):
    """Springs and dampers along and about three axes, at one point in the design position.

    stiffness [N/m], damping [N s/m], turning (rotational) stiffness [N m/rad] and damping [N m s/rad]: along and about
    x, y, z. column: half of it turns with either body, as in a flexible column clamped at both ends; ``at`` is then its
    middle. preload: force on the second body in the design position [N]; None: to be solved for.
    """

    at: Triple
    stiffness: Triple = ZERO
    damping: Triple = ZERO
    turning_stiffness: Triple = ZERO
    turning_damping: Triple = ZERO
    column: bool = False
    preload: Triple | None = None

    @property
    def points(self) -> tuple[Triple, Triple]:
        return self.at, self.at

    @property
    def stiffness_at_rest(self) -> Array:
        return np.array(self.stiffness)

    def reading_at_rest(self, preload: Array) -> Array:
        return preload

    @property
    def resists_turning(self) -> bool:
        return any(self.turning_stiffness) or any(self.turning_damping)

    def write(self, row: Any, preload: Array, tables: Tables) -> None:
        from wrsim.core.body import suspension as kernel

        row.kind = kernel.SHEAR if self.column else kernel.FIELD
        row.stiffness, row.damping, row.preload = self.stiffness, self.damping, tuple(preload)
        row.turning, row.turning_damping = self.turning_stiffness, self.turning_damping


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


@dataclass(frozen=True)
class PlaneFriction(Element):
    """Friction in the plane across an axis (0, 1, 2) of the first body, at one point in the design position."""

    at: Triple
    across: Literal[0, 1, 2]
    slider: Slider | None = None

    @property
    def points(self) -> tuple[Triple, Triple]:
        return self.at, self.at

    @property
    def directions(self) -> Array:
        return np.delete(np.eye(3), self.across, axis=0)

    @property
    def stiffness_at_rest(self) -> Array:
        return np.zeros(2)

    def reading_at_rest(self, preload: Array) -> Array:
        return np.zeros(3)

    def write(self, row: Any, preload: Array, tables: Tables) -> None:
        from wrsim.core.body import suspension as kernel

        row.kind, row.direction = kernel.PLANE, self.across
        if self.slider is not None:
            self.slider.write(row, tables, 2)
