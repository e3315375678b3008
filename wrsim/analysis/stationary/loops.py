"""Tests of EN 14363 that go there and back: unloading on a twisted track, resistance of a bogie against rotation.

The rails, or a turntable under one bogie, go slowly to one side, to the other and back: the loop shows friction. The
turntable turns as far as a curve of small radius does, while the other wheelsets rest on their rails. Twists, lengths,
radius and rates are from memory of the standard [mem].
"""

from dataclasses import dataclass, replace
from math import asin, radians

import numpy as np

from wrsim.analysis.stationary.statics import SupportedVehicle
from wrsim.errors import InputError
from wrsim.simulation.system import Array
from wrsim.track.cant import CANT_BASE
from wrsim.vehicle.bogies import Bogie, bogies_of
from wrsim.vehicle.elements import Strut
from wrsim.vehicle.vehicle import Vehicle

RADIUS = 150.0  # of the curve whose rotation is tried [m] [mem]
RATES = (radians(0.2), radians(1.0))  # of the turntable: slow, and as in a transition at speed [rad/s] [mem]
TWIST_STEPS, ROTATION_STEPS = 25, 40  # from the middle to the end


def there_and_back(steps: int) -> Array:
    """Parts of the largest turn (5 steps + 1,): from the middle to 1, to -1 and back to 1."""
    up = np.arange(1, steps + 1) / steps
    return np.concatenate([[0.0], up, 1.0 - up, -up, up - 1.0, up])


def body_twist(length: float) -> float:
    """Twist of the body over the distance 2a* of bogies [m], beside theirs: 2 + 15/2a* per mille, 7 at most; [1]."""
    return min(2e-3 + 15e-3 / length, 7e-3)


def lone_twist(length: float) -> float:
    """Twist over the distance 2a of lone axles [m]: 2 + 20/2a per mille, 7 at most, to 20 m; 3 to 30 m; 90/2a; [1]."""
    if length <= 20.0:
        return min(2e-3 + 20e-3 / length, 7e-3)
    return min(3e-3, 90e-3 / length)


def bogie_twist(length: float) -> float:
    """Twist under a bogie over its wheelbase 2a+ [m]: 7 - 5/2a+ per mille, not below 0; [1]."""
    return max(7e-3 - 5e-3 / length, 0.0)


@dataclass(frozen=True, eq=False)
class TwistTest:
    """body, bogie: twists in parts of one; part (n,): of both, there and back; wheel_loads (n, wheelsets, 2) [N].

    The loop from the full twist to the opposite one and back, for every wheel (wheelsets, 2): static: Q0, mean of
    both ways through level rails [N]; unloading: largest Delta Q / Q0; friction: half its height there over Q0.
    """

    body: float
    bogie: float
    part: Array
    wheel_loads: Array
    static: Array
    unloading: Array
    friction: Array


def twist_test(vehicle: Vehicle, body: float | None = None, bogie: float | None = None) -> TwistTest:
    """The vehicle without its loads on rails that are twisted there and back.

    body: twist over the distance of the bogies (of lone axles), bogie: over every wheelbase, both to the same side, in
    parts of one; those of the standard unless given. Raises SimulationError where the vehicle finds no rest.
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
        numbers = list(b.wheelsets)
        tilt[numbers] = body * (b.centre - middle) + bogie * (ahead[numbers] - b.centre)
    part = there_and_back(TWIST_STEPS)
    loads = np.array([supported.rest(tilt * p / CANT_BASE).wheel_loads for p in part])
    level = loads[[2 * TWIST_STEPS, 4 * TWIST_STEPS]]
    static = level.mean(axis=0)
    unloading = 1.0 - loads[TWIST_STEPS:].min(axis=0) / static
    return TwistTest(body, bogie, part, loads, static, unloading, 0.5 * np.ptp(level, axis=0) / static)


@dataclass(frozen=True, eq=False)
class RotationTest:
    """bogie; rate [rad/s]; angle (n,) of the turntable to the left [rad], moment (n,) with which it turns the bogie
    [N m], from the middle to the left, to the right and back to the left; axle_load: mean of the bogie's [N]; largest
    moment to either side [N m]; factor: X, the largest moment over wheelbase times axle load.
    """

    bogie: Bogie
    rate: float
    angle: Array
    moment: Array
    axle_load: float
    largest: float
    factor: float


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
    elements = tuple(replace(e, series_stiffness=None) if isinstance(e, Strut) else e for e in vehicle.elements)
    supported = SupportedVehicle(replace(vehicle, loads=(), elements=elements))
    level = np.zeros(len(vehicle.wheelsets))
    axle_load = float(supported.rest(level).wheel_loads[list(bogie.wheelsets)].sum(axis=1).mean())
    part = there_and_back(ROTATION_STEPS)
    interval = most / ROTATION_STEPS / rate
    moment = np.array([supported.rest(level, (bogie, most * p), interval).moment for p in part])
    largest = float(np.abs(moment).max())
    return RotationTest(bogie, rate, most * part, moment, axle_load, largest, largest / (bogie.wheelbase * axle_load))


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
