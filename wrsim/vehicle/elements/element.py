"""Suspension elements and their laws, plain data in SI units: along and about three axes, in one direction, in a plane.

Each joins a ``first`` body to a ``second`` one, by their names, at points given in the vehicle's axes in its design
position: x forward, y left, z up above the rails. The axes of an element are those of its first body; forces are those
on the second one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Triple = tuple[float, float, float]
Table = tuple[tuple[float, float], ...]
Friction = Literal["coulomb", "fancher", "berg"]

TRACK = "track"
"""Name of the frame that follows the centre line at constant speed, as a body."""
GUIDE = "guide frame"
"""Name of the bogie that a single wheelset leads, as a body: the track frame turned by -ahead kappa about b."""
ZERO: Triple = (0.0, 0.0, 0.0)
FAR = 1.0
"""How far its table goes beyond its bends [m]; it goes on evenly there."""


@dataclass
class Tables:
    """The tables of all elements in one, as the kernel takes them, and the number of unknowns that elements bring."""

    rows: list[tuple[float, float]] = field(default_factory=list)
    unknowns: int = 0
    slips: list[int] = field(default_factory=list)
    """Numbers of the unknowns that belong to sliders."""

    def store(self, table: Table) -> tuple[int, int]:
        """Add a table; returns its first row and the number of rows."""
        start = len(self.rows)
        self.rows.extend(table)
        return start, len(table)

    def unknown(self) -> int:
        """Number of one more unknown."""
        self.unknowns += 1
        return self.unknowns - 1

    def slip(self, count: int) -> int:
        """Number of the first of so many unknowns of a slider."""
        numbers = [self.unknown() for _ in range(count)]
        self.slips += numbers
        return numbers[0]


@dataclass(frozen=True)
class Normal:
    """The normal force of a slider: that of an element ``of`` (its full name; "": its own spring), times a factor.

    axis: the component that counts where the element has three, 0, 1, 2; other elements have but one. sense: the sign
    of the force that presses, of surfaces that may be apart; None: that at rest, which they are not.
    """

    of: str
    factor: float = 1.0
    axis: Literal[0, 1, 2] = 2
    sense: float | None = None


@dataclass(frozen=True)
class Slider:
    """A spring behind a surface that slips, see ``core.body.friction``.

    stiffness [N/m], damping [N s/m] where it sticks; instead of the stiffness the distance [m] over which the largest
    force at rest builds up. bound: constant part of the largest force [N]; friction: times the normal force is the rest
    of it.
    """

    law: Friction
    stiffness: float = 0.0
    bound: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    normal: Normal | None = None
    distance: float | None = None

    def pressed_by(self, name: str) -> Slider:
        """The same with the normal force of the element of this full name."""
        return replace(self, normal=None if self.normal is None else replace(self.normal, of=name))

    def write(self, row: Any, tables: Tables, directions: int = 1, at_rest: float = 0.0) -> None:
        """Write its law to a record ELEMENT; how many directions it slips in; at_rest: its element's own force [N]."""
        from wrsim.core.body import friction as kernel

        row.slider = {"coulomb": kernel.COULOMB, "fancher": kernel.FANCHER, "berg": kernel.BERG}[self.law]
        row.stick, row.stick_damping, row.bound = self.stiffness, self.damping, self.bound
        if self.distance is not None:
            row.stick = (self.bound + self.friction * at_rest) / self.distance
        row.slip = tables.slip(3 if self.law == "berg" else directions)


@dataclass(frozen=True)
class Element(ABC):
    """A suspension element; kind: as the file names it.

    preload [N]: along its directions, if it is not to be solved for. limits: travel that its table
    covers [m]; None without such limits. slider: its friction.
    """

    name: str
    kind: str
    first: str
    second: str
    _: KW_ONLY
    preload: Sequence[float] | None = None
    limits: tuple[float, float] | None = None
    slider: Slider | None = None

    @property
    @abstractmethod
    def points(self) -> tuple[Triple, Triple]:
        """Its points on the first and on the second body [m]."""

    @property
    def directions(self) -> Array:
        """Unit vectors along which it pushes in the design position, (m, 3)."""
        return np.eye(3)

    @property
    @abstractmethod
    def stiffness_at_rest(self) -> Array:
        """Stiffness along its directions, (m,) [N/m]."""

    @abstractmethod
    def write(self, row: Any, preload: Array, tables: Tables) -> None:
        """Write its law to a record ELEMENT of ``core.body.suspension``, bodies and points left out.

        preload: force on the second body along its directions in the design position, (m,) [N].
        """

    @property
    def turning_stiffness(self) -> Triple:
        """Stiffness about x, y, z at rest [N m/rad]."""
        return ZERO

    @property
    def resists_turning(self) -> bool:
        """True if moments hold its bodies against each other."""
        return False

    @property
    def turns_with_first(self) -> bool:
        """True if its axes are those of its first body."""
        return True

    @abstractmethod
    def reading_at_rest(self, preload: Array) -> Array:
        """Its reading's force (3,) in the design position [N]; preload: as ``write`` takes it."""

    def force_on_second(self, readings: Array) -> Array:
        """Force on the second body along the axes of the first one, (n, 3), from its readings (n, 6)."""
        return readings[:, :3]

    @property
    def travel_place(self) -> int:
        """Place of its travel among the six numbers of a reading (``core.body.suspension``)."""
        return 3


@dataclass(frozen=True)
class Spring(Element):
    """Springs and dampers along and about three axes, at one point in the design position.

    stiffness [N/m], damping [N s/m], turning (rotational) stiffness [N m/rad] and damping [N m s/rad]: along and about
    x, y, z. column: half of it turns with either body, as in a flexible column clamped at both ends; ``at`` is then its
    middle.
    """

    at: Triple
    stiffness: Triple = ZERO
    damping: Triple = ZERO
    turning_stiffness: Triple = ZERO
    turning_damping: Triple = ZERO
    column: bool = False

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
    extension of the damping part is an unknown of its own. limits: travel that the spring's table
    covers [m]. slider: friction beside them. Travel counts from the design position, positive when the second body
    moves along the axis, or when the line grows.
    """

    ends: tuple[Triple, Triple]
    axis: Literal[0, 1, 2] | None = None
    stiffness: float = 0.0
    damping: float = 0.0
    series: float | None = None
    spring_table: Table = ()
    damper_table: Table = ()

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
    [N/m] more beyond it. It never pulls. Where it is on this line at rest follows from the load that it carries there.
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
