"""What a suspension element is: plain data in SI units, and how the rest of the program asks it.

Each joins a ``first`` body to a ``second`` one, by their names, at points given in the vehicle's axes in its design
position: x forward, y left, z up above the rails. The axes of an element are those of its first body; forces are those
on the second one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wrsim.vehicle.elements.slider import Slider
from wrsim.vehicle.elements.tables import Tables

Array = NDArray[np.float64]
Triple = tuple[float, float, float]

if TYPE_CHECKING:
    from typing import Any

TRACK = "track"
"""Name of the frame that follows the centre line at constant speed, as a body."""

GUIDE = "guide frame"
"""Name of the bogie that a single wheelset leads, as a body: the track frame turned by -ahead kappa about b."""

ZERO: Triple = (0.0, 0.0, 0.0)


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
