"""The test on a twisted track by EN 14363: twists of bogies and body there and back, unloading of every wheel.

Twists, lengths and the limit are from memory of the standard [mem].
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wrsim.analysis.assessment.sections import CANT_BASE
from wrsim.analysis.stationary.statics import SupportedVehicle
from wrsim.simulation.system import Array
from wrsim.vehicle.bogies import bogies_of
from wrsim.vehicle.vehicle import Vehicle

UNLOADING_LIMIT = 0.6  # largest Delta Q / Q0 [mem]
QUARTER = 25  # steps from level rails to the full twist


def body_twist(length: float) -> float:
    """Twist under the body over the distance 2a* of the bogies [m], beside that of the bogies: 2 + 15/2a* per mille, at
    most 7; in parts of one.
    """
    return min(2e-3 + 15e-3 / length, 7e-3)


def lone_twist(length: float) -> float:
    """Twist of a vehicle without bogies over the distance 2a of its axles [m]: 2 + 20/2a per mille, at most 7, to 20 m,
    3 to 30 m, 90/2a beyond; in parts of one.
    """
    if length <= 20.0:
        return min(2e-3 + 20e-3 / length, 7e-3)
    return min(3e-3, 90e-3 / length)


def bogie_twist(length: float) -> float:
    """Twist under a bogie over its wheelbase 2a+ [m], in parts of one: 7 - 5/2a+, not below nothing."""
    return max(7e-3 - 5e-3 / length, 0.0)


@dataclass(frozen=True, eq=False)
class TwistTest:
    """body, bogie: twists in parts of one; part (n,): of both, there and back; wheel_loads (n, wheelsets, 2) [N].

    The loop starts at level rails, goes to the full twist, to the opposite one and back to the first.
    """

    body: float
    bogie: float
    part: Array
    wheel_loads: Array

    @property
    def closed(self) -> slice:
        """The samples of the closed loop, behind the way from the first rest."""
        return slice(QUARTER, None)

    @property
    def static(self) -> Array:
        """Q0 (wheelsets, 2): mean of the two ways through level rails [N]."""
        return np.asarray(self._level.mean(axis=0))

    @property
    def unloading(self) -> Array:
        """Largest Delta Q / Q0 of every wheel (wheelsets, 2)."""
        return np.asarray(1.0 - self.wheel_loads[self.closed].min(axis=0) / self.static)

    @property
    def friction(self) -> Array:
        """Half of what the loop is high at level rails over Q0: the part of friction (wheelsets, 2)."""
        return np.asarray(0.5 * np.ptp(self._level, axis=0) / self.static)

    @property
    def _level(self) -> Array:
        """Wheel loads on the two ways of the closed loop through level rails."""
        return self.wheel_loads[[2 * QUARTER, 4 * QUARTER]]


def twist_test(vehicle: Vehicle, body: float | None = None, bogie: float | None = None) -> TwistTest:
    """The vehicle without its loads on rails that are twisted there and back.

    body: twist over the distance of the bogies (of the axles of a vehicle without), bogie: over the wheelbase of every
    bogie, both to the same side, in parts of one; those of the standard unless given. Raises SimulationError where
    the vehicle finds no rest.
    """
    supported = SupportedVehicle(replace(vehicle, loads=()))
    ahead = supported.ahead
    bogies = bogies_of(vehicle)
    middle = 0.5 * (ahead.max() + ahead.min())
    if len(bogies) > 1:
        length = bogies[0].centre - bogies[-1].centre
        middle = 0.5 * (bogies[0].centre + bogies[-1].centre)
        wheelbase = max(b.wheelbase for b in bogies)
        body = body_twist(length) if body is None else body
        bogie = (bogie_twist(wheelbase) if wheelbase > 0.0 else 0.0) if bogie is None else bogie
    else:
        length = float(np.ptp(ahead))
        body = (lone_twist(length) if length > 0.0 else 0.0) if body is None else body
        bogie = 0.0
    tilt = body * (ahead - middle)
    for b in bogies if len(bogies) > 1 else ():
        own = list(b.wheelsets)
        tilt[own] = body * (b.centre - middle) + bogie * (ahead[own] - b.centre)
    up = np.arange(QUARTER + 1) / QUARTER
    down = 1.0 - up[1:]
    part = np.concatenate([up, down, -up[1:], -down, up[1:]])
    loads = [supported.rest(tilt * p / CANT_BASE).wheel_loads for p in part]
    return TwistTest(body, bogie, part, np.array(loads))
