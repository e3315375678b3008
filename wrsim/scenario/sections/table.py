"""A table of a scenario that belongs to some analyses only; the register says to which."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeVar

from wrsim.errors import InputError
from wrsim.geometry.track.track import Track
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.section import Fault, Section
from wrsim.register import Analysis
from wrsim.vehicle.vehicle import Vehicle

T = TypeVar("T", bound="Table")


class FindTable(Protocol):
    """Gives the scenario's table of a class."""

    def __call__(self, kind: type[T]) -> T:
        """The table."""
        ...


@dataclass(frozen=True)
class Given:
    """What the plan of an analysis is made from, besides its own table.

    speed_kmh: of [vehicle]; table: other tables of the analysis; find: the file of a name that stands at a key; fault:
    the error for a key.
    """

    analysis: Analysis
    vehicle: Vehicle
    track: Track
    speed_kmh: float | None
    table: FindTable
    find: Callable[[KeyPath, str], Path]
    fault: Callable[[KeyPath, str], InputError]


class Table(Section):
    """Base of these tables."""

    @classmethod
    def beside(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Yield faults in how the table goes together with the others of the scenario; raw: all of them."""
        yield from ()


class PlanTable(Table):
    """Base of the first table of an analysis, which makes its plan."""

    def plan(self, given: Given) -> Any:
        """What the analysis has to do, in SI units. Raises InputError at the key that does not fit."""
        raise NotImplementedError
