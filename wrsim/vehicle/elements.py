"""Suspension elements: plain data, SI units.

Each joins a ``first`` body to a ``second`` one, by their names (``TRACK`` is the frame that follows the track), at
points given in the vehicle's axes in its design position: x forward, y left, z up above the rails. The axes of an
element are those of its first body; forces are those on the second one. What the kernel makes of it:
``core.body.suspension``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Triple = tuple[float, float, float]
Table = tuple[tuple[float, float], ...]

TRACK = "track"
"""Name of the frame that follows the centre line at constant speed, as a body."""

GUIDE = "guide frame"
"""Name of the bogie that a single wheelset leads, as a body: the track frame turned by -ahead kappa about b."""

ZERO: Triple = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Spring:
    """Springs and dampers along and about three axes, at one point in the design position.

    kind: as the file names it. stiffness [N/m], damping [N s/m], turning (rotational) stiffness [N m/rad] and
    damping [N m s/rad]: along and about x, y, z. column: half of it turns with either body, as in a flexible column
    clamped at both ends; ``at`` is then its middle. preload: force on the second body in the design position [N];
    None: to be solved for.
    """

    name: str
    kind: str
    first: str
    second: str
    at: Triple
    stiffness: Triple = ZERO
    damping: Triple = ZERO
    turning_stiffness: Triple = ZERO
    turning_damping: Triple = ZERO
    column: bool = False
    preload: Triple | None = None


@dataclass(frozen=True)
class Strut:
    """A spring and a damper in one direction: along an axis of the first body, or along the line between two points.

    kind: as the file names it. ends: on the first and on the second body, one point where ``axis`` is given; axis: 0,
    1, 2 or None for the line. stiffness [N/m] or spring_table: rows (travel [m], force [N]) that pushes back; damping
    [N s/m] or damper_table: rows (velocity [m/s], force [N]). series: stiffness behind the damper [N/m], None for a
    stiff one. Travel is counted from the design position, positive when the second body moves along the axis, or when
    the line grows.
    """

    name: str
    kind: str
    first: str
    second: str
    ends: tuple[Triple, Triple]
    axis: Literal[0, 1, 2] | None = None
    stiffness: float = 0.0
    damping: float = 0.0
    series: float | None = None
    spring_table: Table = ()
    damper_table: Table = ()

    @property
    def has_state(self) -> bool:
        """True if the extension of its damping part is an unknown of its own."""
        return self.series is not None

    @property
    def limits(self) -> tuple[float, float] | None:
        """Travel between which the table of a bump stop says something [m]; None for everything else."""
        if self.kind != "bump-stop" or not self.spring_table:
            return None
        return self.spring_table[0][0], self.spring_table[-1][0]


Element = Spring | Strut
