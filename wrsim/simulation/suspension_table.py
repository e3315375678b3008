"""From the plain data of a vehicle to the tables that ``core.body.suspension`` takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wrsim.core.body.suspension import ELEMENT
from wrsim.vehicle.elements import Tables
from wrsim.vehicle.preload import normal_loads, preloads

if TYPE_CHECKING:
    from wrsim.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class SuspensionTable:
    """elements, (m,) records ELEMENT, tables (., 2), how many unknowns dampers and sliders have, and the numbers of
    those of sliders."""

    elements: NDArray[np.record]
    tables: NDArray[np.float64]
    states: int
    slips: tuple[int, ...]


def suspension_table(vehicle: Vehicle) -> SuspensionTable:
    """Tables of all elements, with the preloads that hold the vehicle in its design position."""
    rows = np.zeros(len(vehicle.elements), ELEMENT)
    rows["state"] = rows["normal"] = -1
    tables, held = Tables(), preloads(vehicle)
    normals = normal_loads(vehicle, held)
    for row, element, preload, normal in zip(rows, vehicle.elements, held, normals, strict=True):
        row.first, row.second = vehicle.index(element.first), vehicle.index(element.second)
        start, end = element.points
        row.point_1 = tuple(np.array(start) - vehicle.place(element.first))
        row.point_2 = tuple(np.array(end) - vehicle.place(element.second))
        row.turning_preload = tuple(preload.moment)
        element.write(row, preload.force, tables)
        if normal is not None:
            row.normal, row.load = normal
    return SuspensionTable(rows, np.array(tables.rows or [(0.0, 0.0)]), tables.unknowns, tuple(tables.slips))
