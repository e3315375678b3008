"""Where every unknown of a vehicle stands in its state, and to which vehicle of a train it belongs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wrsim.core.body import friction, suspension, vehicle_forces

if TYPE_CHECKING:
    from wrsim.simulation.suspension_table import SuspensionTable
    from wrsim.vehicle.vehicle import Vehicle

RAIL_COORDINATES = vehicle_forces.RAIL_COORDINATES
"""Displacements of the rails under one wheelset."""


@dataclass(frozen=True)
class Layout:
    """Six coordinates a body, wheelsets first, then ``dampers`` unknowns, ``size`` in all.

    The last ``positions`` of them are positions: the pitch of the axle boxes, then the twist of axles whose wheels turn
    against each other (``twists``, their places by wheelset), then ``rails`` displacements of the rails under the
    wheels. ``sliders``: places of the unknowns that belong to friction. ``gears``: by wheelset the place of the twist
    of its geared motor's hollow axle; its rate stands behind it.
    """

    vehicle: Vehicle
    bodies: int
    size: int
    dampers: int
    positions: int
    rails: int
    sliders: NDArray[np.intp]
    gears: dict[int, int]
    twists: dict[int, int]

    @classmethod
    def of(cls, vehicle: Vehicle, bodies: int, table: SuspensionTable, elastic: bool) -> Layout:
        """bodies: how many; elastic: whether the rails under the wheels move."""
        rails = RAIL_COORDINATES * len(vehicle.wheelsets) if elastic else 0
        twisting = [i for i, mounted in enumerate(vehicle.wheelsets) if mounted.wheelset.torsion is not None]
        positions = len(vehicle.boxes) + len(twisting) + rails
        dampers = table.states + 2 * len(vehicle.drives) + positions
        size = 6 * bodies + dampers
        first = size - positions - 2 * len(vehicle.drives)
        return cls(
            vehicle, bodies, size, dampers, positions, rails,
            sliders=6 * bodies + np.array(table.slips, dtype=np.intp),
            gears={vehicle.index(d.wheelset): first + 2 * j for j, d in enumerate(vehicle.drives)},
            twists={wheelset: size - rails - len(twisting) + j for j, wheelset in enumerate(twisting)},
        )  # fmt: skip

    def of_units(self, elements: NDArray[np.record], alone: bool = False) -> list[NDArray[np.intp]]:
        """Places of what belongs to every vehicle of a train, what lies between two to that ahead, rails under the
        wheels left out; alone: in the order of a law of that vehicle alone, with these rails, without the unknowns of
        couplings. elements: records ELEMENT.
        """
        boxes = [wheelset for wheelset, _ in self.vehicle.boxes.values()]
        unit_of = np.zeros(self.bodies + vehicle_forces.FRAMES + len(boxes), dtype=int)
        for k, unit in enumerate(self.vehicle.units):
            unit_of[list(unit.parts)] = k
        unit_of[self.bodies + vehicle_forces.FRAMES :] = unit_of[boxes]
        owner = np.full(self.size, -1)
        owner[: 6 * self.bodies] = np.repeat(unit_of[: self.bodies], 6)
        for row in elements:
            if alone and unit_of[row.first] != unit_of[row.second]:
                continue
            places = [row.state] if row.state >= 0 else []
            if row.slider != friction.NO_SLIDER:
                count = 3 if row.slider == friction.BERG else 2 if row.kind == suspension.PLANE else 1
                places += range(row.slip, row.slip + count)
            owner[6 * self.bodies + np.array(places, dtype=int)] = unit_of[row.first]
        first = self.size - self.positions
        owner[first : first + len(boxes)] = unit_of[boxes]
        for wheelset, place in self.twists.items():
            owner[place] = unit_of[wheelset]
        for wheelset, place in self.gears.items():
            owner[place : place + 2] = unit_of[wheelset]
        if alone and self.rails:
            owner[self.size - self.rails :] = np.repeat(unit_of[: len(self.vehicle.wheelsets)], RAIL_COORDINATES)
        return [np.flatnonzero(owner == k) for k in range(len(self.vehicle.units))]
