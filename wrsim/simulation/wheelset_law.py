"""The force law of a wheelset on its track: both contacts, suspension, sprung mass and gravity in one numba call."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from wrsim.contact.arena import pack
from wrsim.contact.channels import ElementField, WheelOnRail
from wrsim.contact.model import ContactModel, KernelArrays
from wrsim.core.body import wheelset_forces as kernel
from wrsim.errors import SimulationError
from wrsim.simulation.carrier import carrier_parameters
from wrsim.simulation.system import Array

if TYPE_CHECKING:
    from wrsim.geometry.track.track import Track
    from wrsim.vehicle.wheelset import Wheelset


Contacts = tuple[ContactModel, ContactModel]
"""Contact models of the left and the right wheel."""


def wheelset_arrays(wheelset: Wheelset, track: Track, contacts: Contacts, *, speed: float, start: float) -> list[Array]:
    """The arrays of one wheelset in the order of ``core.body.wheelset_forces``."""
    scalars = np.zeros(kernel.SCALAR_COUNT)
    paths = (track.centre, track.left, track.right)
    scalars[kernel.STEP_CENTRE : kernel.STEP_RIGHT + 1] = [p.step for p in paths]
    scalars[kernel.HALF_SPACING] = 0.5 * wheelset.profile_spacing
    return [
        scalars,
        carrier_parameters(wheelset, speed=speed, start=start),
        *(p.table for p in paths),
        np.zeros(3),
        np.zeros(3),
        *contacts[0].arrays.arguments(),
        *contacts[1].arrays.arguments(),
    ]


def wheels_on_track(
    views: Sequence[Array], wheelset: Wheelset, track: Track, contacts: Contacts
) -> tuple[WheelOnRail, ...]:
    """The two wheels of a wheelset, whose models compute in the arena's views of its arrays."""
    count = kernel.RIGHT - kernel.LEFT
    return tuple(
        WheelOnRail(
            replace(contact, arrays=KernelArrays(*views[first : first + count])),
            side,
            0.5 * wheelset.profile_spacing,
            origin,
        )
        for contact, side, first, origin in zip(
            contacts, (1, -1), (kernel.LEFT, kernel.RIGHT), track.rail_origins, strict=True
        )
    )


class WheelsetOnTrack:
    """Forces on a wheelset at any state; a ``ForceLaw``.

    ``left`` and ``right`` hold the contacts of the state asked for last; ``distance`` is its place on the centre line.
    """

    def __init__(
        self,
        wheelset: Wheelset,
        track: Track,
        contacts: Contacts,
        *,
        speed: float,
        start: float = 0.0,
    ) -> None:
        """contacts: left and right; speed [m/s] of the track-following frame, which is at ``start`` [m] at t = 0."""
        self.arena = pack(wheelset_arrays(wheelset, track, contacts, speed=speed, start=start))
        self.wheels = wheels_on_track(self.arena.views, wheelset, track, contacts)
        self._scalars = self.arena.views[kernel.SCALARS]
        self._track = track
        self.look_near(self.places(np.array([start]))[0])

    def __call__(self, t: float, q: Array, q_t: Array, out: Array) -> int:
        """See ``ForceLaw``. Returns the status of the contacts; raises SimulationError off the track."""
        status = int(kernel.wheelset_forces(t, q, q_t, out, self.arena.buffer, self.arena.index))
        if status & kernel.OFF_TRACK:
            raise SimulationError(f"the wheelset has left the track's neighbourhood at t = {t:.6g} s")
        return status

    def elements(self) -> list[list[ElementField]]:
        """Elements of every wheel's patches at the state asked for last, where the contact model has any."""
        return []

    @property
    def distance(self) -> float:
        """Distance of the wheelset along the centre line at the state asked for last [m]."""
        return float(self._scalars[kernel.S_CENTRE])

    def places(self, distances: Array) -> Array:
        """Rows (n, 3) for ``look_near``: distances along the centre line (n,) and along both rails there [m]."""
        sides: tuple[Literal["left", "right"], ...] = ("left", "right")
        return np.column_stack([distances, *(self._track.rail_distance(side, distances) for side in sides)])

    def look_near(self, place: Array) -> None:
        """Tell where to look for the wheelset first, a row of ``places``: before a state far from the last one."""
        self._scalars[[kernel.S_CENTRE, kernel.S_LEFT, kernel.S_RIGHT]] = place

    def follow(self, on: bool, sharp: bool = False) -> None:
        """From now on contacts start from those of the last state (in a run), or afresh. See ``Follows``."""
        for wheel in self.wheels:
            wheel.model.arrays.follow(on, sharp)

    def memory(self) -> Array:
        """What the next call starts from: it decides the last bits of the answer. See ``tape.Remembers``."""
        places = self._scalars[[kernel.S_CENTRE, kernel.S_LEFT, kernel.S_RIGHT]]
        return np.concatenate([places, *(wheel.model.arrays.memory() for wheel in self.wheels)])

    def recall(self, memory: Array) -> None:
        """Put back what ``memory`` gave."""
        self.look_near(memory[:3])
        place = 3
        for wheel in self.wheels:
            place += wheel.model.arrays.recall(memory[place:])
