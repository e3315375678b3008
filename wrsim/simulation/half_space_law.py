"""The force law of a vehicle on its track with the contact forces of the exact half-space solver. Slow."""

from collections.abc import Sequence

import numpy as np

from wrsim.contact.channels import ElementField
from wrsim.contact.half_space.patch import HalfSpaceContact
from wrsim.contact.half_space.strips import FORCE, MOMENT, element_fields, solve_into
from wrsim.jit.linalg import Vec
from wrsim.simulation.law import RAIL_COORDINATES, VehicleOnTrack
from wrsim.simulation.system import Array
from wrsim.track.path_kernel import frame_at
from wrsim.vehicle.dynamics.kinematics import add_generalised_forces, kinematics
from wrsim.vehicle.dynamics.wheel_forces import wheel_wrench


class HalfSpaceOnTrack(VehicleOnTrack):
    """Exact contact at every call, from a cold start: the forces depend on the state alone. A ``ForceLaw``.

    ``contacts``: the last solutions, a list of the two wheels for every wheelset.
    """

    compiled = False
    contacts: Sequence[list[HalfSpaceContact]] = ()

    def forces(self, t: float, q: Array, q_t: Array, out: Array) -> None:
        super().forces(t, q, q_t, out)
        self.contacts = [self._exchange_forces(w, q, q_t, out) for w in range(len(self.wheels))]

    def _exchange_forces(self, w: int, q: Array, q_t: Array, out: Array) -> list[HalfSpaceContact]:
        """Replace the fast model's forces on one wheelset by the exact ones; returns both contacts."""
        coordinates = slice(6 * w, 6 * w + 6)
        body = kinematics(q[coordinates], q_t[coordinates])
        change = np.zeros((2, 3))  # of force and moment
        contacts: list[HalfSpaceContact] = []
        rails = self.track.left.curve, self.track.right.curve
        for i, (wheel, rail, place) in enumerate(zip(self.wheels[w], rails, self.wheel_records(w), strict=True)):
            total, frame = wheel.model.arrays.total, frame_at(rail, place.s)
            fast = total.copy()
            contacts.append(solve_into(wheel.model))
            more = total.copy()
            for name in (*FORCE, *MOMENT):
                more[name] -= fast[name]
            wrench = np.array(wheel_wrench(body, frame, place.side, wheel.half_spacing, more))
            change += wrench
            if w in self.twists:
                inertia = 0.25 * self.bodies[w].inertia[1]
                out[self.twists[w]] += 0.5 * wheel.side * float(wrench[1] @ np.array(body.left)) / inertia
            if self.elastic is not None:  # the wheel's force on its piece of rail, over the rail's mass
                rail_place = self.size - self.rails + RAIL_COORDINATES * w + 2 * i
                out[rail_place] -= wheel.side * more.Fo / self.elastic.mass[0]
                out[rail_place + 1] -= more.Fb / self.elastic.mass[1]
        add_generalised_forces(body, Vec(*change[0]), Vec(*change[1]), out[coordinates])
        return contacts

    def elements_of_contacts(self) -> list[list[list[ElementField]]]:
        return [
            [element_fields(contact, pair[0].model.settings.patch_count) for contact in contacts]
            for contacts, pair in zip(self.contacts, self.wheels, strict=True)
        ]
