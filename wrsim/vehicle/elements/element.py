"""What a suspension element is: plain data in SI units, and how the rest of the program asks it.

Each joins a ``first`` body to a ``second`` one, by their names, at points given in the vehicle's axes in its design
position: x forward, y left, z up above the rails. The axes of an element are those of its first body; forces are those
on the second one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
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
    """A suspension element; kind: as the file names it."""

    name: str
    kind: str
    first: str
    second: str

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
    def preload(self) -> Triple | None:
        """Its preload [N] if it is not to be solved for."""
        return None

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

    @property
    def limits(self) -> tuple[float, float] | None:
        """Travel between which its table says something [m]; None without such limits."""
        return None

    @property
    def slider(self) -> Slider | None:
        """Its friction; None without."""
        return None

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
