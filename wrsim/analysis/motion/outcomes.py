"""What may happen to a vehicle on its track, as data; ``words`` says it to people."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from wrsim.errors import SimulationError

Side = Literal["left", "right", "outer", "inner"]
"""Of the track; of a curve."""


@dataclass(frozen=True)
class OffRail:
    """A wheel that has left its rail.

    how: its flange has climbed over the rail, lifting it by ``amount`` [m]; it has dropped beside the rail, or sunk
    beside one that changes along the track or into a gap of it; or it has had no contact for ``amount`` [m], 0 where
    nothing is known of the way.
    """

    wheelset: str
    side: str
    how: Literal["climbed", "dropped", "sunk", "no contact"]
    amount: float = 0.0


@dataclass(frozen=True)
class Overlap:
    """A wheel so deep in its rail, ``depth`` [m], that no contact law covers it: a lost solution."""

    wheelset: str
    side: str
    depth: float


@dataclass(frozen=True)
class Overturned:
    """All that acts on the vehicle together points so far beyond a rail [m]."""

    side: Side
    beyond: float


@dataclass(frozen=True)
class RunInStopped:
    """The run into the curve stopped, and why in words."""

    reason: str


@dataclass(frozen=True)
class Event:
    """A wheel without contact, a bump stop beyond the end of its table, a contact with something to say (bit of
    `wrsim.contact.status`), steps of the integration that had to be cut, a vertical force that the samples miss, an
    axle that is driven or braked beyond adhesion, or a friction element without a normal force.

    part: name of the wheelset or of the element; start, end: time [s] and distance of the vehicle [m]; missed: the
    force between samples, and by how much it is beyond those beside it [N].
    """

    kind: Literal["lift", "stop", "contact", "steps", "between", "spins", "slides", "loose"]
    part: str
    start: tuple[float, float]
    end: tuple[float, float]
    side: str = ""
    bit: int = 0
    missed: tuple[float, float] = (0.0, 0.0)


class NoSteadyMotion(SimulationError):
    """No steady motion was found; ``reason`` says what became of the search."""

    def __init__(self, reason: OffRail | Overlap | Overturned | RunInStopped | SimulationError) -> None:
        super().__init__(str(reason))
        self.reason = reason

    @classmethod
    def of(cls, fault: SimulationError) -> NoSteadyMotion:
        """What has stopped a search, as such an error; it may be one already."""
        return fault if isinstance(fault, cls) else cls(fault)
