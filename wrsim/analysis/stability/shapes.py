"""Shapes of the modes of a rolling vehicle at chosen speeds, for who wants to see them move."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from wrsim.analysis.stability.modes import Modes, modes_of
from wrsim.analysis.stability.rolling import RollingVehicle
from wrsim.simulation.modes import mode_name

if TYPE_CHECKING:
    from wrsim.scenario.build import Setup
    from wrsim.scenario.sections.stability import StabilityPlan


def mode_shapes(setup: Setup[StabilityPlan], speeds: Sequence[float]) -> Iterator[tuple[Modes, list[str]]]:
    """Modes of the set-up's vehicle at speeds [m/s], each with the names of its modes."""
    rolling = RollingVehicle(setup, speeds[0])
    for speed in speeds:
        found = modes_of(rolling.linearised(speed), speed, len(setup.vehicle.wheelsets), setup.plan.highest)
        yield found, [mode_name(setup.vehicle, shape) for shape in found.shapes]
