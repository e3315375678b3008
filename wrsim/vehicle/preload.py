"""Preload: the forces in the springs that hold a vehicle in its design position.

The springs of a vehicle at rest carry what an elastic structure on fixed wheelsets carries: let the bodies move under
their weight and the loads, K u = f, then each spring holds its share -k d(u). With these forces built in, the design
position is the position of rest, whichever way the springs share the load. Springs whose preload the file gives are
left out of K and add their force to f.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wrsim.errors import InputError
from wrsim.vehicle.wheelset import STANDARD_GRAVITY

if TYPE_CHECKING:
    from wrsim.vehicle.elements import Element
    from wrsim.vehicle.vehicle import Vehicle

Array = NDArray[np.float64]

WORDS = ("along x", "along y", "vertically", "in roll", "in pitch", "in yaw")

TOLERANCE = 1e-9
"""Part of the vehicle's weight that may be left over; moments are divided by 1 m."""

ROUND_OFF = 1e-12
"""Forces below this part of the weight are none: a symmetric vehicle is to be symmetric to the last digit."""


def preloads(vehicle: Vehicle) -> list[Array]:
    """Force on the second body of every element in the design position, along its directions, (m,) each [N].

    Raises InputError for a body that its springs do not hold: it names the body and the direction.
    """
    n = len(vehicle.bodies)
    base = len(vehicle.wheelsets)
    centres = np.array([part.centre for part in vehicle.parts]).reshape(-1, 3)
    load = np.zeros((n, 6))
    load[:, 2] = [-body.mass * STANDARD_GRAVITY for body in vehicle.bodies]
    for extra in vehicle.loads:
        i = vehicle.index(extra.body) - base
        if i >= 0:
            load[i] += _at(np.array(extra.at) - centres[i + base]).T @ np.array(extra.force)

    def motion(element: Element) -> tuple[Array, Array]:
        """Travel along the element's directions, (m, 6 n), and turning, (3, 6 n), per motion of the bodies."""
        rows, turns = np.zeros((2, 3, n, 6))
        for name, end, sign in zip((element.first, element.second), element.points, (-1.0, 1.0), strict=True):
            i = vehicle.index(name) - base
            if 0 <= i < n:
                rows[:, i] += sign * _at(np.array(end) - centres[i + base])
                turns[:, i, 3:] += sign * np.eye(3)
        return element.directions @ rows.reshape(3, 6 * n), turns.reshape(3, 6 * n)

    motions = [motion(element) for element in vehicle.elements]
    stiffness = np.zeros((6 * n, 6 * n))
    right = load.ravel().copy()
    for element, (travel, turning) in zip(vehicle.elements, motions, strict=True):
        if element.preload is not None:
            right += travel.T @ np.array(element.preload)
        else:
            stiffness += travel.T @ np.diag(element.stiffness_at_rest) @ travel
        stiffness += turning.T @ np.diag(element.turning_stiffness) @ turning
    u = np.linalg.lstsq(stiffness, right, rcond=1e-12)[0] if n else np.zeros(0)
    left = right - stiffness @ u
    if n and np.max(np.abs(left)) > TOLERANCE * vehicle.mass * STANDARD_GRAVITY:
        loose, direction = divmod(int(np.argmax(np.abs(left))), 6)
        raise InputError(
            f"the preload cannot be found: nothing holds body '{vehicle.bodies[loose].name}' {WORDS[direction]} "
            f"({left[6 * loose + direction]:.4g} {'N' if direction < 3 else 'N m'} are left over)"
        )
    found = []
    for element, (travel, _) in zip(vehicle.elements, motions, strict=True):
        if element.preload is not None:
            found.append(np.array(element.preload))
        else:
            force = -element.stiffness_at_rest * (travel @ u)
            found.append(np.where(np.abs(force) > ROUND_OFF * vehicle.mass * STANDARD_GRAVITY, force, 0.0))
    return found


def _at(arm: Array) -> Array:
    """Motion of a point (3,) of a body per translation and rotation of the body, (3, 6)."""
    x, y, z = arm
    turn = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.hstack([np.eye(3), turn])
