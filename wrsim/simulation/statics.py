"""A vehicle at rest on level, canted or twisted rails: how it stands under its loads, and the force of every wheel.

The wheelsets stand each on two hard supports half the profile spacing to either side of its middle that
push and do not pull, so a wheel may lift; the rails hold them sideways at their own height. All else finds its place in
its springs, bump stops and all. Where on the profiles the contacts lie is left out: with rails under
the wheels ``analysis = "equilibrium"`` says more.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np

from wrsim.errors import SimulationError
from wrsim.geometry.track.segments import Straight
from wrsim.geometry.track.track import Track
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.newton import newton
from wrsim.simulation.state import TOLERANCE, SteadyMotion, design_state
from wrsim.simulation.system import COORDINATES, Array
from wrsim.vehicle.vehicle import Load

if TYPE_CHECKING:
    from wrsim.vehicle.vehicle import Vehicle

SUPPORT = 1e10
"""Stiffness of a support [N/m]."""

LENGTH, PLACE = 200.0, 100.0
"""Level track, and where on it the vehicle stands [m]."""

Z, Y, ROLL, SPIN = (COORDINATES.index(name) for name in ("z", "y", "roll", "spin"))


@dataclass(frozen=True)
class Standing:
    """wheel_loads: (wheelsets, 2), left and right [N]; moved: of the bodies from the design position, (bodies, 3), to
    the left, up [m] and roll [rad]; readings: forces and travels of the elements, (elements, 6).
    """

    wheel_loads: Array
    moved: Array
    readings: Array


def leaning(vehicle: Vehicle, angle: float) -> Vehicle:
    """The vehicle on rails that are canted by this angle [rad], the right one higher, in the axes of the track.

    Loads at all masses, carried ones and payloads turn their weight to the left: the same as a curve to the right with
    so much cant deficiency, but for the weight, which is m g cos(angle).
    """
    weights = [(part.name, vehicle.gravity * part.mass, part.centre) for part in vehicle.parts]
    weights += [(p.body, -p.force[2], p.at) for p in vehicle.payloads]
    for c in vehicle.carried:
        x, y, z = vehicle.place(c.body)
        weights.append((c.body, vehicle.gravity * c.mass, (x, y, z + c.height)))
    turned = (
        Load.constant(f"leaning {i}", body, (0.0, weight * sin(angle), weight * (1.0 - cos(angle))), at)
        for i, (body, weight, at) in enumerate(weights)
    )
    return replace(vehicle, loads=(*vehicle.loads, *turned))


def standing(vehicle: Vehicle, twist: float = 0.0) -> Standing:
    """The vehicle at rest under its payloads and loads, those over time or distance at their largest.

    twist: by how much the rails turn about the track along it [rad/m]; they are level under the middle of the
    wheelsets and their left side rises ahead. Raises SimulationError when the vehicle finds no rest: it overturns.
    """
    loaded = vehicle.loaded_as(lambda load: load.largest)
    law = VehicleOnTrack(loaded, Track.build([Straight(LENGTH)], 1.5), (), speed=0.0, start=PLACE, drive="train")
    steady = SteadyMotion(law)
    n, w = len(law.bodies), len(vehicle.wheelsets)
    half = np.array([0.5 * mounted.wheelset.profile_spacing for mounted in vehicle.wheelsets])
    radius = np.array([mounted.wheelset.mean_radius for mounted in vehicle.wheelsets])
    ahead = np.array([mounted.x for mounted in vehicle.wheelsets])
    tilt = twist * (ahead - ahead.mean())
    x = steady.unknowns(*design_state(law))
    own = x[: 6 * n].reshape(n, 6)
    design = own[w:, [Y, Z, ROLL]].copy()
    own[:w, Z] = radius - 0.5 * vehicle.weight / w / SUPPORT
    own[:w, ROLL] = tilt
    held = [6 * i + k for i in range(w) for k in (Y, SPIN)]
    free = np.delete(np.arange(x.size), held)
    supports = np.zeros((w, 2))

    def residual(part: Array) -> Array:
        x[free] = part
        left = steady.residual(x)
        axles = left[: 6 * w].reshape(w, 6)
        for side, sign in enumerate((1.0, -1.0)):
            sunk = radius - own[:w, Z] + sign * half * (tilt - own[:w, ROLL])
            supports[:, side] = SUPPORT * np.maximum(sunk, 0.0)
        up, about = supports.sum(axis=1), half * (supports[:, 0] - supports[:, 1])
        axles[:, Z] += up / vehicle.weight
        axles[:, ROLL] += about / vehicle.weight - radius * axles[:, Y]  # the rails push back at their height
        return left[free]

    with law.settled():
        x[free], left, _ = newton(residual, x[free].copy(), steady.small[free], TOLERANCE, 100)
    largest = float(np.max(np.abs(left)))
    if not largest <= TOLERANCE:
        raise SimulationError(
            f"{vehicle.name} does not come to rest under its loads: it overturns ({largest:.2g} of its weight is left "
            "over)"
        )
    return Standing(supports, own[w:, [Y, Z, ROLL]] - design, law.records.copy())
