"""From the plain data of a vehicle to the tables that ``core.body.suspension`` takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wrsim.core.body.suspension import ELEMENT
from wrsim.vehicle.elements import Tables
from wrsim.vehicle.preload import preloads

if TYPE_CHECKING:
    from wrsim.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class SuspensionTable:
    """elements, (m,) records ELEMENT, tables (., 2), and how many dampers have an unknown of their own."""

    elements: NDArray[np.record]
    tables: NDArray[np.float64]
    states: int


def suspension_table(vehicle: Vehicle) -> SuspensionTable:
    """Tables of all elements, with the preloads that hold the vehicle in its design position."""
    rows = np.zeros(len(vehicle.elements), ELEMENT)
    rows["state"] = -1
    tables = Tables()
    for row, element, preload in zip(rows, vehicle.elements, preloads(vehicle), strict=True):
        row.first, row.second = vehicle.index(element.first), vehicle.index(element.second)
        start, end = element.points
        row.point_1 = tuple(np.array(start) - vehicle.place(element.first))
        row.point_2 = tuple(np.array(end) - vehicle.place(element.second))
        row.turning_preload = tuple(preload.moment)
        element.write(row, preload.force, tables)
    return SuspensionTable(rows, np.array(tables.rows or [(0.0, 0.0)]), tables.unknowns)
