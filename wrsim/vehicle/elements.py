"""Suspension elements and their laws, plain data in SI units.

Each joins a ``first`` body to a ``second`` one, by their names, at points given in the vehicle's axes in its design
position: x forward, y left, z up above the rails. The axes of an element are those of its first body; forces are those
on the second one. The keys of vehicle files: ``element_tables``; the forces: ``dynamics.suspension``.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field
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
"""How far the table of a bilinear spring extends beyond its kinks [m]; beyond, it is extrapolated."""


@dataclass
class Tables:
    """Tables of all elements in one array, as the kernel takes them; number of inner unknowns (``unknowns``), and the
    numbers of those that belong to sliders (``slips``)."""

    rows: list[tuple[float, float]] = field(default_factory=list)
    unknowns: int = 0
    slips: list[int] = field(default_factory=list)

    def store(self, table: Table) -> tuple[int, int]:
        """Add a table; returns its first row and the number of rows."""
        self.rows.extend(table)
        return len(self.rows) - len(table), len(table)

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
    """Normal force of a slider: the force of an element (its full name; "": the slider's own), times a factor.

    axis: its component, 0, 1, 2, where that element has three. sense: sign of the force that presses, of surfaces that
    may separate; None: the sign at rest.
    """

    element: str
    factor: float = 1.0
    axis: Literal[0, 1, 2] = 2
    sense: float | None = None


@dataclass(frozen=True)
class Slider:
    """A spring in series with a sliding surface, see ``dynamics.friction``.

    stiffness [N/m], damping [N s/m] while it sticks; or, in place of the stiffness, the distance [m] over which the
    largest force at rest builds up. Largest force: bound [N] + friction times the normal force.
    """

    law: Friction
    stiffness: float = 0.0
    bound: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    normal: Normal | None = None
    distance: float | None = None

    def write(self, row: Any, tables: Tables, directions: int = 1, at_rest: float = 0.0) -> None:
        """Write its law to a record ELEMENT; directions: in which it slips; at_rest: its element's own force [N]."""
        from wrsim.vehicle.dynamics import friction as kernel

        row.slider = {"coulomb": kernel.COULOMB, "fancher": kernel.FANCHER, "berg": kernel.BERG}[self.law]
        row.stick, row.stick_damping, row.bound = self.stiffness, self.damping, self.bound
        if self.distance is not None:
            row.stick = (self.bound + self.friction * at_rest) / self.distance
        row.slip = tables.slip(3 if self.law == "berg" else directions)


@dataclass(frozen=True)
class Element(ABC):
    """A suspension element; kind: as in the vehicle file.

    preload [N]: along its directions, where it is prescribed. limits: travel that its table covers [m]; None without
    such limits. slider: its friction.
    """

    name: str
    kind: str
    first: str
    second: str
    _: KW_ONLY
    preload: Sequence[float] | None = None
    limits: tuple[float, float] | None = None
    slider: Slider | None = None

    turns_with_first = True
    """Whether its axes are those of its first body."""
    travel_place = 3
    """Place of its travel among the six numbers of a reading (``dynamics.suspension``)."""
    resists_turning = False
    """Whether moments hold its bodies against each other."""
    turning_stiffness = ZERO
    """Stiffness about x, y, z at rest [N m/rad]."""

    @property
    @abstractmethod
    def points(self) -> tuple[Triple, Triple]:
        """Its points on the first and on the second body [m]."""

    @property
    def is_linearised(self) -> bool:
        """Whether an equivalent linear element stands for it in modes (``vehicle.equivalent``)."""
        return self.slider is not None

    @property
    def directions(self) -> Array:
        """Unit vectors of its forces in the design position, (m, 3)."""
        return np.eye(3)

    @property
    def stiffness_at_rest(self) -> Array:
        """Stiffness along its directions, (m,) [N/m]."""
        return np.zeros(len(self.directions))

    @abstractmethod
    def write(self, row: Any, preload: Array, tables: Tables) -> None:
        """Write its law to a record ELEMENT of ``dynamics.suspension``, bodies and points left out.

        preload: force on the second body along its directions in the design position, (m,) [N].
        """

    def reading_at_rest(self, preload: Array) -> Array:
        """Force (3,) of its reading in the design position [N]; preload: as for ``write``."""
        return np.asarray(preload @ self.directions)

    def force_on_second(self, readings: Array) -> Array:
        """Force on the second body along the axes of the first one, (n, 3), from its readings (n, 6)."""
        return readings[:, :3]


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

    @property
    def resists_turning(self) -> bool:  # type: ignore[override]
        return any(self.turning_stiffness) or any(self.turning_damping)

    def write(self, row: Any, preload: Array, tables: Tables) -> None:
        from wrsim.vehicle.dynamics import suspension as kernel

        row.kind = kernel.SHEAR if self.column else kernel.FIELD
        row.stiffness, row.damping, row.preload = self.stiffness, self.damping, tuple(preload)
        row.turning, row.turning_damping = self.turning_stiffness, self.turning_damping


@dataclass(frozen=True)
class Strut(Element):
    """A spring and a damper in one direction: along an axis of the first body, or along the line between two points.

    ends: on the first and on the second body, one point where ``axis`` is given; axis: 0, 1, 2 or None for the line.
    stiffness [N/m] or spring_table: rows (travel [m], restoring force [N]); damping [N s/m] or damper_table: rows
    (velocity [m/s], force [N]). series_stiffness: in series with the damper [N/m], None for a rigid mounting; with it
    the extension of the damper is an unknown. Travel counts from the design position, positive when the second body
    moves along the axis, or when the line grows.
    """

    ends: tuple[Triple, Triple]
    axis: Literal[0, 1, 2] | None = None
    stiffness: float = 0.0
    damping: float = 0.0
    series_stiffness: float | None = None
    spring_table: Table = ()
    damper_table: Table = ()

    @property
    def points(self) -> tuple[Triple, Triple]:
        return self.ends

    @property
    def is_linearised(self) -> bool:
        return bool(self.damper_table) or super().is_linearised

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
    def turns_with_first(self) -> bool:  # type: ignore[override]
        return self.axis is not None

    @property
    def travel_place(self) -> int:  # type: ignore[override]
        return 3 + (self.axis or 0)

    def force_on_second(self, readings: Array) -> Array:
        return readings[:, :3] if self.axis is not None else -readings[:, :1] * self.directions

    def reading_at_rest(self, preload: Array) -> Array:
        return super().reading_at_rest(preload) if self.axis is not None else np.array([-preload[0], 0.0, 0.0])

    @property
    def _line(self) -> Array:
        return np.array(self.ends[1]) - np.array(self.ends[0])

    def write(self, row: Any, preload: Array, tables: Tables) -> None:
        from wrsim.vehicle.dynamics import suspension as kernel

        row.kind = kernel.LINE if self.axis is None else kernel.AXIS
        row.direction = self.axis or 0
        row.length = np.linalg.norm(self._line)
        row.k, row.c = self.stiffness, self.damping
        row.force_0 = preload[0]
        if self.spring_table:
            row.force_0 += np.interp(0.0, *np.transpose(self.spring_table))
        row.spring_start, row.spring_rows = tables.store(self.spring_table)
        damper = self.damper_table
        if self.series_stiffness is not None:
            row.series, row.state = self.series_stiffness, tables.unknown()
            damper = tuple((force, velocity) for velocity, force in damper)  # read backwards
        row.damper_start, row.damper_rows = tables.store(damper)
        if self.slider is not None:
            self.slider.write(row, tables, at_rest=abs(float(preload[0])))


@dataclass(frozen=True)
class BilinearSpring(Strut):
    """A strut along an axis that pushes with ``stiffness`` up to the force ``second_from`` [N], and with
    ``second_stiffness`` [N/m] more beyond it. It never pulls. Its travel at rest follows from its load there."""

    second_stiffness: float = 0.0
    second_from: float = 0.0

    def write(self, row: Any, preload: Array, tables: Tables) -> None:
        super().write(row, preload, tables)
        row.k, row.force_0 = 0.0, preload[0]
        row.spring_start, row.spring_rows = tables.store(self.table(float(preload[0])))

    def table(self, at_rest: float) -> Table:
        """Rows (travel [m], restoring force less that at rest [N]); at_rest: force on the second body there [N]."""
        k, total, kink = self.stiffness, self.stiffness + self.second_stiffness, self.second_from
        sign, load = np.sign(at_rest), abs(at_rest)
        bend = (kink - load) / (k if load < kink else total)
        free = bend - kink / k
        compressed = ((free - FAR, 0.0), (free, 0.0), (bend, kink), (bend + FAR, kink + total * FAR))
        return tuple(sorted((float(-sign * c), float(at_rest - sign * force)) for c, force in compressed))


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

    def write(self, row: Any, preload: Array, tables: Tables) -> None:
        from wrsim.vehicle.dynamics import suspension as kernel

        row.kind, row.direction = kernel.PLANE, self.across
        if self.slider is not None:
            self.slider.write(row, tables, 2)
