"""Masses that are part of a body: what a vehicle carries and is trimmed with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wrsim.errors import InputError
from wrsim.vehicle.elements import Triple
from wrsim.vehicle.vehicle import Body, Vehicle

SKEWEST = 0.1
"""Largest product of inertia of a body with what it carries, over the root of the product of the moments of inertia
about both axes. The motion is computed without it; what that changes is of the order of its square."""


@dataclass(frozen=True)
class Ballast:
    """A mass [kg] that moves with a body, its centre [m], its inertia about x, y, z through that [kg m2]."""

    body: str
    mass: float
    centre: Triple
    inertia: Triple


def with_ballast(vehicle: Vehicle, masses: Sequence[Ballast]) -> Vehicle:
    """The vehicle with these masses as part of its bodies. Raises InputError for a body that they make too skew."""
    bodies = []
    for body in vehicle.bodies:
        own = [mass for mass in masses if mass.body == body.name]
        bodies.append(_together(body, own) if own else body)
    return replace(vehicle, bodies=tuple(bodies))


def _together(body: Body, masses: Sequence[Ballast]) -> Body:
    """The body and the masses as one, its axes as they were."""
    parts = [Ballast(body.name, body.mass, body.centre, body.inertia), *masses]
    weights = [part.mass for part in parts]
    centre = np.average([part.centre for part in parts], axis=0, weights=weights)
    inertia = np.zeros((3, 3))
    for part in parts:
        arm = np.array(part.centre) - centre
        inertia += np.diag(part.inertia) + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    about = np.diag(inertia)
    skew = np.abs(inertia - np.diag(about)) / np.sqrt(np.outer(about, about))
    if skew.max() > SKEWEST:
        i, j = np.unravel_index(int(np.argmax(skew)), skew.shape)
        raise InputError(
            f"the payload turns the principal axes of body '{body.name}' about {'xyz'[3 - int(i) - int(j)]} "
            f"(product of inertia {-inertia[i, j]:.4g} kg m2): it must lie nearer to the body's centre, or be a body "
            "of its own on stiff springs"
        )
    x, y, z = (float(c) for c in centre)
    a, b, c = (float(own) for own in about)
    return Body(body.name, float(sum(weights)), (a, b, c), (x, y, z))
