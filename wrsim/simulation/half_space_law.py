"""The force law of a vehicle on its track with the contact forces of the exact half-space solver. Slow."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wrsim.contact.channels import ElementField
from wrsim.contact.half_space.patch import HalfSpaceContact
from wrsim.contact.half_space.strips import FORCE, MOMENT, element_fields, solve_into
from wrsim.core.body import vehicle_forces
from wrsim.core.body.kinematics import generalised_forces, kinematics
from wrsim.core.body.wheel_pose import add_forces
from wrsim.core.body.wheelset_forces import S_LEFT, S_RIGHT, SCALARS
from wrsim.core.track.path import frame
from wrsim.simulation.law import RAIL_COORDINATES, VehicleOnTrack
from wrsim.simulation.system import Array

if TYPE_CHECKING:
    from wrsim.geometry.track.path import Path


class HalfSpaceOnTrack(VehicleOnTrack):
    """Exact contact at every call; everything else as in its base. A ``ForceLaw``.

    ``contacts``: what the solver found last, a list of the two wheels for every wheelset. Every call starts anew, so
    that the forces depend on the state alone.
    """

    def __init__(self, *arguments: Any, **options: Any) -> None:
        """See `VehicleOnTrack`."""
        super().__init__(*arguments, **options)
        self.contacts: list[list[HalfSpaceContact]] = []
        self._force, self._moment, self._exchange = np.zeros(3), np.zeros(3), np.zeros(6)

    def __call__(self, t: float, q: Array, q_t: Array, out: Array) -> int:
        """See ``ForceLaw``. Returns the status of the contacts; raises SimulationError off the track."""
        status = super().__call__(t, q, q_t, out)
        self.contacts = []
        for w in range(len(self.wheels)):
            status |= self._exchange_forces(w, q, q_t, out)
        return status

    def _exchange_forces(self, w: int, q: Array, q_t: Array, out: Array) -> int:
        """Take the fast model's forces on one wheelset out and put the exact ones in."""
        own = slice(6 * w, 6 * w + 6)
        body = kinematics(q[own], q_t[own])
        self._force[:] = 0.0
        self._moment[:] = 0.0
        found: list[HalfSpaceContact] = []
        rails: tuple[tuple[Path, int], ...] = ((self.track.left, S_LEFT), (self.track.right, S_RIGHT))
        for i, (wheel, (rail, place)) in enumerate(zip(self.wheels[w], rails, strict=True)):
            total = wheel.model.arrays.total
            at = frame(rail.table, rail.step, self.wheelset_views[w][SCALARS][place])
            fast = total.copy()
            found.append(solve_into(wheel.model))
            more = total.copy()
            for name in (*FORCE, *MOMENT):
                more[name] -= fast[name]
            add_forces(body, at, wheel.side, wheel.half_spacing, more, self._force, self._moment)
            if self.elastic is not None:  # the wheel's force on its piece of rail, over the rail's mass
                own_rail = self.size - self.rails + RAIL_COORDINATES * w + 2 * i
                out[own_rail] -= wheel.side * more.Fo / self.scalars[vehicle_forces.RAIL_MASS]
                out[own_rail + 1] -= more.Fb / self.scalars[vehicle_forces.RAIL_MASS + 1]
        generalised_forces(body, self._force, self._moment, self._exchange)
        out[own] += self._exchange
        self.contacts.append(found)
        return found[0].status | found[1].status

    def elements_of_contacts(self) -> list[list[list[ElementField]]]:
        """See `VehicleOnTrack`."""
        return [
            [element_fields(contact, pair[0].model.settings.max_patches) for contact in contacts]
            for contacts, pair in zip(self.contacts, self.wheels, strict=True)
        ]
