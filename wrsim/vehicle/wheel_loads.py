"""Static wheel loads of a vehicle in its design position, from the forces in its springs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wrsim.vehicle.preload import preloads
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

if TYPE_CHECKING:
    from wrsim.vehicle.vehicle import Vehicle


def static_wheel_loads(vehicle: Vehicle) -> NDArray[np.float64]:
    """Vertical force of every wheel on level rails (wheelsets, 2: left and right) [N].

    Springs bear on the axles with their preload; each wheel takes its share by the lever of the profile spacing. Where
    on the profiles the contacts lie is left out: an asymmetric vehicle's loads differ from that by some per mille.
    """
    loads = np.zeros((len(vehicle.wheelsets), 2))
    for w, mounted in enumerate(vehicle.wheelsets):
        down = mounted.mass * STANDARD_GRAVITY
        moment = 0.0  # about the forward axis, of forces down
        for element, force in zip(vehicle.elements, preloads(vehicle), strict=True):
            for end, sign in ((element.second, 1.0), (element.first, -1.0)):
                if end != mounted.name:
                    continue
                vertical = sign * float(force @ element.directions[:, 2])
                y = element.points[1 if sign > 0.0 else 0][1]
                down -= vertical
                moment -= vertical * y
        down += sum(load.mass for load in vehicle.carried if load.body == mounted.name) * STANDARD_GRAVITY
        for load in vehicle.loads:
            if load.body == mounted.name:
                down -= load.force[2]
                moment -= load.force[2] * load.at[1]
        half = 0.5 * mounted.wheelset.profile_spacing
        loads[w] = 0.5 * down + 0.5 * moment / half, 0.5 * down - 0.5 * moment / half
    return loads
