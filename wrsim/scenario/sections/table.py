"""A table of a scenario that belongs to some analyses only, by the register."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wrsim.errors import InputError
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.section import Fault, Section
from wrsim.register import Analysis
from wrsim.scenario.sections.vehicle import LOWEST, SpeedTable
from wrsim.track.track import Track
from wrsim.vehicle.loads import Drive
from wrsim.vehicle.speed import SpeedProfile
from wrsim.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class PlanContext:
    """What the plan of an analysis is made from, besides its own table.

    drive: what holds the speed; speed_kmh: of [vehicle], a number or a table; table: the scenario's table of a class;
    find: the file that a key names; fault: the error for a key.
    """

    analysis: Analysis
    vehicle: Vehicle
    track: Track
    drive: Drive
    speed_kmh: float | SpeedTable | None
    table: Callable[[type[Any]], Any]
    find: Callable[[KeyPath, str], Path]
    fault: Callable[[KeyPath, str], InputError]

    @property
    def one_speed(self) -> float | None:
        """The speed of [vehicle] for an analysis that knows no other [m/s]. Raises InputError where it varies."""
        if isinstance(self.speed_kmh, SpeedTable):
            message = f'must be one number: analysis = "{self.analysis.name}" looks for motion that lasts'
            raise self.fault(("vehicle", "speed_kmh"), message)
        return None if self.speed_kmh is None else self.speed_kmh / 3.6

    def speed_from(self, start: float, end: float) -> SpeedProfile:
        """The speed from the start of a run to its end [m].

        Where motors and brakes alone decide, that of a mass without losses under their forces."""
        vehicle = self.vehicle
        if isinstance(self.speed_kmh, SpeedTable):
            return self.speed_kmh.profile(start)
        speed = (self.speed_kmh or 0.0) / 3.6
        if self.drive == "free" and (vehicle.efforts or vehicle.brakes) and not vehicle.runs_with_frame:
            return SpeedProfile.under(vehicle.acceleration, speed, start, end, LOWEST / 3.6)
        return SpeedProfile.constant(speed)


class AnalysisTable(Section):
    """Base of these tables."""

    @classmethod
    def beside(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Yield faults in how the table goes together with the others of the scenario; raw: all of them."""
        yield from ()


class PlanTable(AnalysisTable):
    """Base of the first table of an analysis, which makes its plan."""

    def plan(self, context: PlanContext) -> Any:
        """What the analysis has to do, in SI units. Raises InputError at the key that does not fit."""
        raise NotImplementedError
