"""What the couplings of a train do: channels from sampled states and the readings of their elements."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wrsim.core.body.kinematics import kinematics
from wrsim.core.body.rigid_body import pitched
from wrsim.vehicle.couplings import Gear

if TYPE_CHECKING:
    from wrsim.simulation.law import VehicleOnTrack
    from wrsim.simulation.system import Array


def coupling_channels(law: VehicleOnTrack, q: Array, records: Array) -> dict[str, Array]:
    """Forces of the couplings and how the ends of their vehicles lie to each other, each (samples, couplings).

    q: states (samples, .); records: readings of all elements (samples, elements, 6). Forward, left and up are those in
    the middle between both bodies, but for the lateral forces: each is along the left of the body that it acts on.
    """
    vehicle = law.vehicle
    names = ("force", "fy_ahead", "fy_behind", "fz", "extension", "offset", "yaw")
    found = {f"coupling_{name}": np.zeros((len(q), len(vehicle.couplings))) for name in names}
    numbers = {element.name: i for i, element in enumerate(vehicle.elements)}
    for c, coupling in enumerate(vehicle.couplings):
        ahead, behind = _Moved(law, q, coupling.ahead), _Moved(law, q, coupling.behind)
        force = np.zeros((len(q), 3))  # on the vehicle behind
        for i in (numbers[name] for name in coupling.elements):
            element = vehicle.elements[i]
            if isinstance(element, Gear):
                line = behind.point(element.ends[1]) - ahead.point(element.ends[0])
                force -= records[:, i, :1] * line / np.linalg.norm(line, axis=1, keepdims=True)
            else:
                force += np.einsum("nk,nkj->nj", records[:, i, :3], ahead.axes)
        forward, left, up = (_unit(ahead.axes[:, k] + behind.axes[:, k]) for k in range(3))
        apart = ahead.point(coupling.at) - behind.point(coupling.at)
        turned = np.cross(behind.axes[:, 0], ahead.axes[:, 0])
        values = (
            _along(force, forward), -_along(force, ahead.axes[:, 1]), _along(force, behind.axes[:, 1]),
            _along(force, up), _along(apart, forward), _along(apart, left), np.arcsin(_along(turned, up)),
        )  # fmt: skip
        for name, value in zip(names, values, strict=True):
            found[f"coupling_{name}"][:, c] = value
    return found


class _Moved:
    """A body in sampled states: its axes, (samples, 3, 3), forward, left and up in the rows, and where it is."""

    def __init__(self, law: VehicleOnTrack, q: Array, name: str) -> None:
        i = law.vehicle.index(name)
        own = q[:, 6 * i : 6 * i + 6]
        bodies = [pitched(kinematics(at, np.zeros(6)), at[5]) for at in own]
        self.centre = np.array(law.vehicle.parts[i].centre)
        self.position = np.array([body.position for body in bodies])
        self.axes = np.array([(body.forward, body.left, body.up) for body in bodies])

    def point(self, at: tuple[float, float, float]) -> Array:
        """Where a point of the design position has moved to, (samples, 3)."""
        return np.asarray(self.position + np.einsum("k,nkj->nj", np.array(at) - self.centre, self.axes))


def _along(vectors: Array, direction: Array) -> Array:
    return np.asarray(np.einsum("nj,nj->n", vectors, direction))


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))
