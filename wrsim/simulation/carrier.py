"""From the plain data of a wheelset to the parameters of the kernel that carries it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wrsim.core.body import carrier as kernel
from wrsim.simulation.system import Array
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

if TYPE_CHECKING:
    from wrsim.vehicle.wheelset import Wheelset


def carrier_parameters(
    wheelset: Wheelset,
    *,
    speed: float,
    start: float = 0.0,
    height: float | None = None,
    gravity: float = STANDARD_GRAVITY,
) -> Array:
    """Parameters of ``core.body.carrier.carrier_forces`` (18,).

    speed [m/s] and start [m]: the frame is at s = start + speed t; height [m]: of the axle above the track
    plane where the springs carry nothing, default the mean wheel radius; gravity [m/s2].
    """
    suspension = wheelset.suspension
    p = np.zeros(kernel.PARAMETERS)
    p[kernel.MASS] = wheelset.mass
    p[kernel.GRAVITY] = gravity
    p[kernel.STIFFNESS : kernel.STIFFNESS + 3] = suspension.stiffness
    p[kernel.DAMPING : kernel.DAMPING + 3] = suspension.damping
    p[kernel.HALF_SPACING] = suspension.half_spacing
    p[kernel.AHEAD] = suspension.ahead_of_bogie_centre
    p[kernel.HEIGHT] = wheelset.mean_radius if height is None else height
    p[kernel.SPRUNG_MASS] = wheelset.sprung.mass
    p[kernel.SPRUNG_HEIGHT] = wheelset.sprung.height
    p[kernel.CONSTANT : kernel.CONSTANT + 3] = wheelset.constant_force
    p[kernel.START] = start
    p[kernel.SPEED] = speed
    return p
