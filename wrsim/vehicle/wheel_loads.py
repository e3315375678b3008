"""Static wheel loads of a vehicle in its design position, from the forces in its springs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wrsim.vehicle.preload import preloads

if TYPE_CHECKING:
    from wrsim.vehicle.vehicle import Vehicle


def static_wheel_loads(vehicle: Vehicle) -> NDArray[np.float64]:
    """Vertical force of every wheel on level rails (wheelsets, 2: left and right) [N].

    Springs bear on the axles with their preload; each wheel takes its share by the lever of the profile spacing. Where
    on the profiles the contacts lie is left out: an asymmetric vehicle's loads differ from that by some per mille.
    """
    lifts = [(load.body, load.force[2], load.at[1]) for load in vehicle.loads]  # body, force up, its y
    lifts += [(carried.body, -carried.mass * vehicle.gravity, 0.0) for carried in vehicle.carried]
    for element, force in zip(vehicle.elements, preloads(vehicle), strict=True):
        up = float(force @ element.directions[:, 2])
        first, second = element.points
        lifts += [(element.first, -up, first[1]), (element.second, up, second[1])]
    loads = np.zeros((len(vehicle.wheelsets), 2))
    for w, mounted in enumerate(vehicle.wheelsets):
        own = [(up, y) for body, up, y in lifts if vehicle.carrier(body) == mounted.name]
        down = mounted.mass * vehicle.gravity - sum(up for up, _ in own)
        moment = -sum(up * y for up, y in own)  # about the forward axis, of forces down
        half = 0.5 * mounted.wheelset.profile_spacing
        loads[w] = 0.5 * down + 0.5 * moment / half, 0.5 * down - 0.5 * moment / half
    return loads
