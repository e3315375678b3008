"""From the plain data of a vehicle to the tables that ``core.body.suspension`` takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wrsim.core.body import suspension as kernel
from wrsim.simulation.system import Array
from wrsim.vehicle.elements import Spring, Strut
from wrsim.vehicle.preload import preloads

if TYPE_CHECKING:
    from wrsim.vehicle.elements import Table
    from wrsim.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class SuspensionTable:
    """elements (m, COLUMNS), tables (., 2), and how many dampers have an unknown of their own."""

    elements: Array
    tables: Array
    states: int


def suspension_table(vehicle: Vehicle) -> SuspensionTable:
    """Tables of all elements, with the preloads that hold the vehicle in its design position."""
    rows = np.zeros((len(vehicle.elements), kernel.COLUMNS))
    tables: list[tuple[float, float]] = []
    centres = [np.array(part.centre) for part in vehicle.parts] + [np.zeros(3), np.zeros(3)]  # of the frames
    states = 0

    def stored(table: Table) -> tuple[int, int]:
        start = len(tables)
        tables.extend(table)
        return start, len(table)

    for row, element, preload in zip(rows, vehicle.elements, preloads(vehicle), strict=True):
        first, second = vehicle.index(element.first), vehicle.index(element.second)
        row[kernel.FIRST], row[kernel.SECOND] = first, second
        ends = (element.at, element.at) if isinstance(element, Spring) else element.ends
        row[kernel.POINT_1 : kernel.POINT_1 + 3] = np.array(ends[0]) - centres[first]
        row[kernel.POINT_2 : kernel.POINT_2 + 3] = np.array(ends[1]) - centres[second]
        if isinstance(element, Spring):
            row[kernel.KIND] = kernel.SHEAR if element.column else kernel.FIELD
            row[kernel.STIFFNESS : kernel.STIFFNESS + 3] = element.stiffness
            row[kernel.DAMPING : kernel.DAMPING + 3] = element.damping
            row[kernel.PRELOAD : kernel.PRELOAD + 3] = preload
            row[kernel.TURNING : kernel.TURNING + 3] = element.turning_stiffness
            row[kernel.TURNING_DAMPING : kernel.TURNING_DAMPING + 3] = element.turning_damping
            continue
        row[kernel.KIND] = kernel.LINE if element.axis is None else kernel.AXIS
        row[kernel.DIRECTION] = element.axis or 0
        row[kernel.LENGTH] = np.linalg.norm(np.array(ends[1]) - np.array(ends[0]))
        row[kernel.K], row[kernel.C] = element.stiffness, element.damping
        row[kernel.SPRING_TABLE], row[kernel.SPRING_ROWS] = stored(element.spring_table)
        row[kernel.FORCE_0] = preload[0] + _at_rest(element)
        row[kernel.STATE] = -1
        if element.series is None:
            row[kernel.DAMPER_TABLE], row[kernel.DAMPER_ROWS] = stored(element.damper_table)
        else:
            row[kernel.SERIES] = element.series
            row[kernel.STATE] = states
            states += 1
            inverse = tuple((force, velocity) for velocity, force in element.damper_table)
            row[kernel.DAMPER_TABLE], row[kernel.DAMPER_ROWS] = stored(inverse)
    return SuspensionTable(rows, np.array(tables or [(0.0, 0.0)]), states)


def _at_rest(strut: Strut) -> float:
    """Force of a tabulated spring without travel [N]."""
    if not strut.spring_table:
        return 0.0
    travel, force = np.array(strut.spring_table).T
    return float(np.interp(0.0, travel, force))
