"""Resistance of a bogie against rotation under its body: the X factor of EN 14363.

A turntable under one bogie turns it slowly to one side, to the other and back, as far as a curve of small radius does;
the other wheelsets rest on their rails. Radius, rates and the limit are from memory [mem].
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import asin, radians

import numpy as np

from wrsim.analysis.stationary.statics import SupportedVehicle
from wrsim.errors import InputError
from wrsim.simulation.system import Array
from wrsim.vehicle.bogies import Bogie, bogies_of
from wrsim.vehicle.elements import Strut
from wrsim.vehicle.vehicle import Vehicle

RADIUS = 150.0  # of the curve whose rotation is tried [m] [mem]
RATES = (radians(0.2), radians(1.0))  # of the turntable: slow, and as in a transition at speed [rad/s] [mem]
LIMIT = 0.1  # largest X factor [mem]
QUARTER = 40  # steps from the middle to the largest angle


@dataclass(frozen=True, eq=False)
class RotationTest:
    """bogie; rate [rad/s]; angle (n,) of the turntable to the left [rad], moment (n,) with which it turns the bogie
    [N m], from the middle to the left, to the right and back to the left; axle_load: mean of the bogie's [N].
    """

    bogie: Bogie
    rate: float
    angle: Array
    moment: Array
    axle_load: float

    @property
    def largest(self) -> float:
        """Largest moment, to either side [N m]."""
        return float(np.abs(self.moment).max())

    @property
    def factor(self) -> float:
        """X: the largest moment over wheelbase times axle load."""
        return self.largest / (self.bogie.wheelbase * self.axle_load)


def rotation_test(vehicle: Vehicle, bogie: Bogie, rate: float, radius: float = RADIUS) -> RotationTest:
    """Turn a bogie of a vehicle without its loads as far as a curve of a radius [m] does.

    bogie: one of `bogies_of`; rate [rad/s]. Raises InputError without a bogie that could turn (see `turning_bogies`),
    SimulationError where the vehicle finds no rest.
    """
    bogies = turning_bogies(vehicle)
    half = 0.5 * (bogies[0].centre - bogies[-1].centre)
    if radius <= half:
        raise InputError(f"{vehicle.name}: a curve of {radius:g} m is no wider than half of its pivots' {2 * half:g} m")
    most = asin(half / radius)
    # in slow steady motion a stiffness in series with a damper is rigid
    elements = tuple(replace(e, series=None) if isinstance(e, Strut) else e for e in vehicle.elements)
    supported = SupportedVehicle(replace(vehicle, loads=(), elements=elements))
    level = np.zeros(len(vehicle.wheelsets))
    static = supported.rest(level).wheel_loads
    up = np.arange(1, QUARTER + 1) / QUARTER
    part = np.concatenate([[0.0], up, 1.0 - up, -up, up - 1.0, up])
    interval = most / QUARTER / rate
    moments = [supported.rest(level, (bogie, most * p), interval).moment for p in part]
    return RotationTest(
        bogie, rate, most * part, np.array(moments), float(static[list(bogie.wheelsets)].sum(axis=1).mean())
    )


def turning_bogies(vehicle: Vehicle) -> tuple[Bogie, ...]:
    """The bogies of a vehicle. Raises InputError without two of them that have two axles or more."""
    bogies = bogies_of(vehicle)
    if len(bogies) < 2 or min(b.wheelbase for b in bogies) <= 0.0:
        frames = ", ".join(bogie.frame for bogie in bogies) or "none"
        raise InputError(
            f"{vehicle.name} has no bogies to turn: two frames that hold two wheelsets or more are needed; frames that "
            f"hold wheelsets: {frames}"
        )
    return bogies
