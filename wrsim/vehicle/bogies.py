"""Which body holds which wheelsets: the bogies of a vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from wrsim.errors import InputError

if TYPE_CHECKING:
    from wrsim.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class Bogie:
    """A frame that holds wheelsets, by their numbers from the front; centre: the middle between its outermost axles
    along the vehicle, wheelbase: the way from the one to the other [m]."""

    frame: str
    wheelsets: tuple[int, ...]
    centre: float
    wheelbase: float


def holders_of(vehicle: Vehicle) -> list[str | None]:
    """The body, no wheelset, that holds each wheelset: of those that elements join to it or to its axle boxes the one
    that is joined to most wheelsets (a motor or a gear that sits on its axle is not), the first of several; None where
    only a frame of the track holds it.
    """
    bodies = {body.name for body in vehicle.bodies}
    axles = [mounted.name for mounted in vehicle.wheelsets]
    joined: dict[str, set[str]] = {}
    for e in vehicle.elements:
        ends = vehicle.carrier(e.first), vehicle.carrier(e.second)
        for body, axle in (ends, ends[::-1]):
            if body in bodies and axle in axles:
                joined.setdefault(body, set()).add(axle)
    of_axles = ([body for body, held in joined.items() if axle in held] for axle in axles)
    return [max(holders, key=lambda body: len(joined[body]), default=None) for holders in of_axles]


def bogies_of(vehicle: Vehicle) -> tuple[Bogie, ...]:
    """The bogies from front to rear; none where the heaviest body holds the wheelsets itself, or nothing does.

    Raises InputError for a train, whose vehicles are tested one by one.
    """
    if vehicle.members:
        raise InputError(f"{vehicle.name} is a train: its vehicles are tested one by one")
    reference = vehicle.parts[vehicle.reference].name
    groups: dict[str, list[int]] = {}
    for i, frame in enumerate(holders_of(vehicle)):
        if frame is None or frame == reference:
            return ()
        groups.setdefault(frame, []).append(i)
    found = []
    for frame, numbers in groups.items():
        x = [vehicle.wheelsets[i].x for i in numbers]
        found.append(Bogie(frame, tuple(numbers), 0.5 * (max(x) + min(x)), float(np.ptp(x))))
    return tuple(sorted(found, key=lambda bogie: -bogie.centre))


def wheelsets_beneath(vehicle: Vehicle) -> dict[str, tuple[int, ...]]:
    """Numbers of the wheelsets that carry each body, no wheelset: those that it holds; of another body, those of the
    bodies that elements join it to. None where it hangs on no body that wheelsets carry."""
    found: dict[str, set[int]] = {}
    for i, holder in enumerate(holders_of(vehicle)):
        if holder is not None:
            found.setdefault(holder, set()).add(i)
    numbers = {mounted.name: i for i, mounted in enumerate(vehicle.wheelsets)}
    own = {i: held for held in found.values() for i in held}
    joined: dict[str, set[str]] = {body.name: set() for body in vehicle.bodies}
    for e in vehicle.elements:
        ends = vehicle.carrier(e.first), vehicle.carrier(e.second)
        for one, other in (ends, ends[::-1]):
            if one in joined:
                joined[one].add(other)
    while True:
        further = {}
        for body in joined.keys() - found.keys():
            carried = [found[other] for other in joined[body] if other in found]
            carried += [own[numbers[other]] for other in joined[body] if numbers.get(other) in own]
            if carried:
                further[body] = set().union(*carried)
        if not further:
            return {body: tuple(sorted(found.get(body, ()))) for body in joined}
        found |= further
