"""Rigid bodies of a system: mass and inertia, and the mass matrix in their coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wrsim.core.body import rigid_body as kernel
from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.vehicle.vehicle import MountedWheelset, Vehicle
    from wrsim.vehicle.wheelset import Wheelset

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Solid:
    """A rigid body: mass [kg], principal inertia about x, y (of a wheelset: its axle), z [kg m2]. geared: the share of
    gears and rotors in that about y (``core.body.loads``)."""

    mass: float
    inertia: tuple[float, float, float]
    geared: float = 0.0

    def __post_init__(self) -> None:
        for key, value in zip(("mass", "Ixx", "Iyy", "Izz"), (self.mass, *self.inertia), strict=True):
            if not (np.isfinite(value) and value > 0.0):
                raise InputError(f"body: {key} must be a positive number, not {value!r}")
        x, y, z = self.inertia
        own = (x, y - self.geared, z)
        if 2.0 * max(own) > sum(own) * (1.0 + 1e-9):
            raise InputError(f"body: one of the inertias {own} kg m2 is larger than the other two together")

    @classmethod
    def of_wheelset(cls, wheelset: Wheelset | MountedWheelset) -> Solid:
        """The body of a wheelset. Its roll and yaw inertia must agree, for it spins about its axle."""
        roll, spin, yaw = wheelset.inertia
        if abs(roll - yaw) > 1e-6 * abs(yaw):
            raise InputError(
                f"wheelset '{wheelset.name}': roll inertia {roll:g} and yaw inertia {yaw:g} kg m2 differ; "
                "a wheelset spins about its axle, so that the two must be equal (take their mean)"
            )
        return cls(wheelset.mass, (yaw, spin, yaw))


def bodies_of(vehicle: Vehicle) -> tuple[Solid, ...]:
    """The bodies of a vehicle, wheelsets first; cases of geared motors with the inertia that these add to them."""
    geared = dict.fromkeys((body.name for body in vehicle.bodies), 0.0)
    for drive in vehicle.drives:
        geared[drive.case] += drive.case_inertia
    found = [Solid.of_wheelset(mounted) for mounted in vehicle.wheelsets]
    for body in vehicle.bodies:
        (x, y, z), more = body.inertia, geared[body.name]
        found.append(Solid(body.mass, (x, y + more, z), more))
    return tuple(found)


def mass_matrix(bodies: Sequence[Solid], q: Array) -> Array:
    """Mass matrix in the coordinates q (6 per body; one more for every damper in series with a spring, of mass 1)."""
    whole = np.eye(len(q))
    for i, body in enumerate(bodies):
        own = slice(6 * i, 6 * i + 6)
        kernel.mass_block(q[own], body.mass, *body.inertia, whole[own, own])
    return whole


def inertia_table(bodies: Sequence[Solid]) -> NDArray[np.record]:
    """Records INERTIA of all bodies."""
    return np.array([(body.mass, *body.inertia) for body in bodies], kernel.INERTIA)


def accelerations(bodies: Sequence[Solid], q: Array, q_t: Array, forces: Array) -> Array:
    """Accelerations of the coordinates of all bodies (bodies, 6) under generalised forces, body by body."""
    blocks = np.zeros((len(bodies), 6, 6))
    for i, body in enumerate(bodies):
        kernel.mass_block(q[6 * i : 6 * i + 6], body.mass, *body.inertia, blocks[i])
    left = (forces - velocity_forces(bodies, q, q_t))[: 6 * len(bodies)].reshape(-1, 6, 1)
    return np.asarray(np.linalg.solve(blocks, left)[:, :, 0], dtype=np.float64)


def velocity_forces(bodies: Sequence[Solid], q: Array, q_t: Array) -> Array:
    """Quadratic velocity forces h of M(q) q_tt + h(q, q_t) = F, as a new array of the length of q."""
    whole = np.zeros(len(q))
    for i, body in enumerate(bodies):
        own = slice(6 * i, 6 * i + 6)
        kernel.quadratic_forces(q[own], q_t[own], *body.inertia, whole[own])
    return whole
