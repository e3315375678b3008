"""The force law of a wheelset on its track with the contact forces of the exact half-space solver. Slow."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wrsim.contact.channels import ElementField
from wrsim.contact.half_space.patch import HalfSpaceContact
from wrsim.contact.half_space.strips import element_fields, solve_into
from wrsim.core.body.kinematics import generalised_forces, kinematics
from wrsim.core.body.wheel_pose import add_forces
from wrsim.core.body.wheelset_forces import OFF_TRACK, S_LEFT, S_RIGHT
from wrsim.core.track.path import frame
from wrsim.simulation.system import Array
from wrsim.simulation.wheelset_law import WheelsetOnTrack

if TYPE_CHECKING:
    from wrsim.contact.model import ContactModel
    from wrsim.geometry.track.track import Track
    from wrsim.vehicle.wheelset import Wheelset


class HalfSpaceOnTrack(WheelsetOnTrack):
    """Exact contact at every call; everything else as in its base. A ``ForceLaw``.

    ``contacts``: what the solver found last, left and right. Every call starts anew, so that the forces depend on the
    state alone.
    """

    def __init__(
        self,
        wheelset: Wheelset,
        track: Track,
        contacts: tuple[ContactModel, ContactModel],
        *,
        speed: float,
        start: float = 0.0,
    ) -> None:
        """See `WheelsetOnTrack`."""
        super().__init__(wheelset, track, contacts, speed=speed, start=start)
        self.contacts: list[HalfSpaceContact] = []
        self._rails = ((track.left, S_LEFT), (track.right, S_RIGHT))
        self._force, self._moment, self._exact = np.zeros(3), np.zeros(3), np.zeros(6)

    def __call__(self, t: float, q: Array, q_t: Array, out: Array) -> int:
        """See ``ForceLaw``. Returns the status of the contacts; raises SimulationError off the track."""
        status = super().__call__(t, q, q_t, out)
        if status & OFF_TRACK:
            return status
        body = kinematics(q, q_t)
        self._force[:] = 0.0
        self._moment[:] = 0.0
        contacts = []
        for wheel, (rail, place) in zip(self.wheels, self._rails, strict=True):
            total = wheel.model.arrays.total
            at = frame(rail.table, rail.step, self._scalars[place])
            # the fast model's forces out, the exact ones in
            add_forces(body, at, wheel.side, wheel.half_spacing, -total, self._force, self._moment)
            contacts.append(solve_into(wheel.model))
            status |= contacts[-1].status
            add_forces(body, at, wheel.side, wheel.half_spacing, total, self._force, self._moment)
        self.contacts = contacts
        generalised_forces(body, self._force, self._moment, self._exact)
        out += self._exact
        return status

    def elements(self) -> list[list[ElementField]]:
        """See `WheelsetOnTrack.elements`."""
        return [element_fields(c, self.wheels[0].model.settings.max_patches) for c in self.contacts]
