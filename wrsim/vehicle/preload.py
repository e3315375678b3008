"""Preload: the forces in the springs that hold a vehicle in its design position.

The springs of a vehicle at rest carry what an elastic structure on fixed wheelsets carries: let the bodies move under
their weight and the payloads, K u = f, then each spring holds its share -k d(u). With these forces built in, the design
position is the position of rest, whichever way the springs share the force. Loads are no part of it: under them the
vehicle moves. Springs whose preload the file gives are
left out of K and add their force to f.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.vehicle.elements import Element
    from wrsim.vehicle.vehicle import Vehicle

Array = NDArray[np.float64]

WORDS = ("along x", "along y", "vertically", "in roll", "in pitch", "in yaw")
PITCH = WORDS.index("in pitch")

TOLERANCE = 1e-9
"""Part of the vehicle's weight that may be left over; moments are divided by 1 m."""

ROUND_OFF = 1e-12
"""Forces below this part of the weight are none: a symmetric vehicle is to be symmetric to the last digit."""


class Preload(NamedTuple):
    """What an element does to its second body in the design position: force along its directions (m,) [N], moment of
    its rotational springs about x, y, z (3,) [N m].
    """

    force: Array
    moment: Array


def preloads(vehicle: Vehicle) -> list[Preload]:
    """The preload of every element.

    Raises InputError for a body that its springs do not hold: it names the body and the direction.
    """
    n, boxes = len(vehicle.bodies), list(vehicle.boxes)
    size = 6 * n + len(boxes)
    base = len(vehicle.wheelsets)
    load = np.zeros((n, 6))
    load[:, 2] = [-body.mass * vehicle.gravity for body in vehicle.bodies]
    for extra in vehicle.payloads:
        i = vehicle.index(extra.body) - base
        if i >= 0:
            load[i] += _at(np.array(extra.at) - vehicle.place(extra.body)).T @ np.array(extra.force)

    def motion(element: Element) -> tuple[Array, Array]:
        """Travel along the element's directions, (m, size), and turning, (3, size), per motion of bodies and boxes."""
        rows, turns = np.zeros((2, 3, size))
        for name, end, sign in zip((element.first, element.second), element.points, (-1.0, 1.0), strict=True):
            i = vehicle.index(name) - base
            moves = sign * _at(np.array(end) - vehicle.place(name))
            if name in boxes:  # it pitches about the axle
                column = 6 * n + boxes.index(name)
                rows[:, column] += moves[:, PITCH]
                turns[1, column] += sign
            elif 0 <= i < n:
                rows[:, 6 * i : 6 * i + 6] += moves
                turns[:, 6 * i + 3 : 6 * i + 6] += sign * np.eye(3)
        return element.directions @ rows, turns

    motions = [motion(element) for element in vehicle.elements]
    stiffness = np.zeros((size, size))
    held = np.zeros(size)
    right = np.append(load.ravel(), np.zeros(len(boxes)))
    for element, (travel, turning) in zip(vehicle.elements, motions, strict=True):
        if element.preload is not None:
            right += travel.T @ np.array(element.preload)
        else:
            stiffness += travel.T @ np.diag(element.stiffness_at_rest) @ travel
        stiffness += turning.T @ np.diag(element.turning_stiffness) @ turning
        held += element.stiffness_at_rest @ travel**2 + np.array(element.turning_stiffness) @ turning**2
    for name, about in zip(boxes, held[6 * n :], strict=True):
        if not about > 0.0:
            raise InputError(
                f"no spring keeps axle box '{name}' from turning about the axle: it needs one beside the axle"
            )
    u = np.linalg.lstsq(stiffness, right, rcond=1e-12)[0] if n else np.zeros(size)
    left = right - stiffness @ u
    if n and np.max(np.abs(left)) > TOLERANCE * vehicle.mass * vehicle.gravity:
        worst = int(np.argmax(np.abs(left)))
        loose, direction = divmod(worst, 6)
        what = f"body '{vehicle.bodies[loose].name}'" if loose < n else f"axle box '{boxes[worst - 6 * n]}'"
        direction = direction if loose < n else PITCH
        raise InputError(
            f"the preload cannot be found: nothing holds {what} {WORDS[direction]} "
            f"({left[worst]:.4g} {'N' if direction < 3 else 'N m'} are left over)"
        )
    found = []
    for element, (travel, turning) in zip(vehicle.elements, motions, strict=True):
        force = -element.stiffness_at_rest * (travel @ u) if element.preload is None else np.array(element.preload)
        moment = -np.array(element.turning_stiffness) * (turning @ u)
        least = ROUND_OFF * vehicle.mass * vehicle.gravity
        found.append(Preload(*(np.where(np.abs(a) > least, a, 0.0) for a in (force, moment))))
    return found


def _at(arm: Array) -> Array:
    """Motion of a point (3,) of a body per translation and rotation of the body, (3, 6)."""
    x, y, z = arm
    turn = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.hstack([np.eye(3), turn])
