"""What acts on a vehicle as a whole: how hard it is pushed aside, and whether that would overturn it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wrsim.analysis.motion.outcomes import NoSteadyMotion, Overturned, Side

if TYPE_CHECKING:
    from wrsim.scenario.build import Setup
    from wrsim.scenario.sections.run import RunPlan
    from wrsim.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class Resultant:
    """Of all that acts on a vehicle as one rigid body: force to the left and up [N], in the axes of the track; where it
    meets the plane of the rails to the left of the middle [m]; infinite where it points away from the rails.
    """

    left: float
    up: float
    point: float


def resultant(vehicle: Vehicle, distance: float, curvature: float, tilt: float, speed: float) -> Resultant:
    """Of weight, centrifugal force, payloads, and the loads of time 0 with the vehicle's origin at a distance [m].

    curvature [1/m] and tilt of the track by its cant [rad], both positive to the left; speed [m/s].
    """
    mass = vehicle.mass + sum(carried.mass for carried in vehicle.carried)
    inward = speed**2 * curvature
    left = mass * float(vehicle.gravity * np.sin(tilt) - inward * np.cos(tilt))
    up = -mass * float(vehicle.gravity * np.cos(tilt) + inward * np.sin(tilt))
    _, y, z = vehicle.centre_of_load
    tipping = z * left - y * up  # to the left
    held = vehicle.loaded_as_at(distance).loads
    for load in (*held, *(payload.as_load() for payload in vehicle.payloads)):
        _, fy, fz = load.largest
        _, y, z = load.at
        left, up, tipping = left + fy, up + fz, tipping + z * fy - y * fz
    return Resultant(left, up, tipping / -up if up < 0.0 else float(np.copysign(np.inf, tipping)))


def pushed(setup: Setup[RunPlan], speed: float) -> Resultant:
    """The same on the track where the run starts. Raises NoSteadyMotion when it would overturn the vehicle."""
    track, start = setup.track, setup.plan.start
    curvature = float(track.curvature(start))
    tilt = float(np.arcsin(track.cant(start) / track.cant_base))
    found = resultant(setup.vehicle, start, curvature, tilt, speed)
    check_upright(found, track.cant_base, curvature)
    return found


def check_upright(found: Resultant, base: float, curvature: float) -> None:
    """Raise NoSteadyMotion when it points beside the rails. base: distance between them [m]."""
    beyond = abs(found.point) - 0.5 * base
    if beyond <= 0.0:
        return
    side: Side = "left" if found.point > 0.0 else "right"
    if curvature != 0.0:
        side = "inner" if found.point * curvature > 0.0 else "outer"
    raise NoSteadyMotion(Overturned(side, float(beyond)))
