"""Rigid bodies of a system: mass and inertia, and the mass matrix in their coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wrsim.vehicle.dynamics import rigid_body as kernel
from wrsim.vehicle.elements import Array
from wrsim.vehicle.vehicle import MountedWheelset, Vehicle
from wrsim.vehicle.wheelset import Wheelset


@dataclass(frozen=True)
class Solid:
    """A rigid body: mass [kg], principal inertia about x, y (of a wheelset: its axle), z [kg m2]."""

    mass: float
    inertia: tuple[float, float, float]

    @classmethod
    def of_wheelset(cls, wheelset: Wheelset | MountedWheelset) -> Solid:
        """The body of a wheelset, whose inertia about x is that about z."""
        _, spin, yaw = wheelset.inertia
        return cls(wheelset.mass, (yaw, spin, yaw))


def bodies_of(vehicle: Vehicle) -> tuple[Solid, ...]:
    """The bodies of a vehicle, wheelsets first; cases of geared motors with the inertia that these add to them."""
    geared = dict.fromkeys((body.name for body in vehicle.bodies), 0.0)
    for drive in vehicle.drives:
        geared[drive.case] += drive.case_inertia
    bodies = [Solid.of_wheelset(mounted) for mounted in vehicle.wheelsets]
    for body in vehicle.bodies:
        x, y, z = body.inertia
        bodies.append(Solid(body.mass, (x, y + geared[body.name], z)))
    return tuple(bodies)


def mass_matrix(bodies: Sequence[Solid], q: Array) -> Array:
    """Mass matrix in the coordinates q (6 per body; one more for every damper in series with a spring, of mass 1)."""
    whole = np.eye(len(q))
    for i, body in enumerate(bodies):
        block = slice(6 * i, 6 * i + 6)
        kernel.mass_block(q[block], body.mass, *body.inertia, whole[block, block])
    return whole


def inertia_table(bodies: Sequence[Solid]) -> NDArray[np.record]:
    return np.array([(body.mass, *body.inertia) for body in bodies], kernel.INERTIA)


def accelerations(bodies: Sequence[Solid], q: Array, q_t: Array, forces: Array) -> Array:
    """Accelerations of the coordinates of all bodies (n, bodies, 6) at states (n, size) under generalised forces, body
    by body."""
    blocks, quadratic = np.zeros((len(q), len(bodies), 6, 6)), np.zeros((len(q), len(bodies), 6))
    kernel.equations_of_motion(q, q_t, inertia_table(bodies), blocks, quadratic)
    left = forces[:, : 6 * len(bodies)].reshape(quadratic.shape) - quadratic
    return np.asarray(np.linalg.solve(blocks, left[..., None])[..., 0], dtype=np.float64)


def velocity_forces(bodies: Sequence[Solid], q: Array, q_t: Array) -> Array:
    """Quadratic velocity forces h of M(q) q_tt + h(q, q_t) = F, as a new array of the length of q."""
    whole = np.zeros(len(q))
    for i, body in enumerate(bodies):
        block = slice(6 * i, 6 * i + 6)
        kernel.quadratic_forces(q[block], q_t[block], *body.inertia, whole[block])
    return whole
