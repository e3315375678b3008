"""The bogies of a vehicle: which body holds which wheelsets; the level of suspension of a body."""

from collections.abc import Container, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from wrsim.errors import InputError
from wrsim.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class Bogie:
    """A frame and the numbers of its wheelsets from the front; centre: the middle of its outermost axles along the
    vehicle, wheelbase: their distance [m]."""

    frame: str
    wheelsets: tuple[int, ...]
    centre: float
    wheelbase: float


def holders_of(vehicle: Vehicle) -> list[str | None]:
    """The body that holds each wheelset: of those that elements join to it or to its axle boxes the one with most
    wheelsets (not a motor or a gear on its axle), the first of several; None where only a frame of the track does."""
    bodies = {body.name for body in vehicle.bodies}
    axles = [mounted.name for mounted in vehicle.wheelsets]
    joined: dict[str, set[str]] = {}
    for body, axle in _joints(vehicle):
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
    bogies = []
    for frame, numbers in groups.items():
        x = [vehicle.wheelsets[i].x for i in numbers]
        bogies.append(Bogie(frame, tuple(numbers), 0.5 * (max(x) + min(x)), float(np.ptp(x))))
    return tuple(sorted(bogies, key=lambda bogie: -bogie.centre))


def wheelsets_beneath(vehicle: Vehicle) -> dict[str, tuple[int, ...]]:
    """Numbers of the wheelsets that carry each body: those that it holds, or those of the bodies that elements join it
    to; empty where it hangs on no body that wheelsets carry."""
    beneath: dict[str, set[int]] = {}
    for i, holder in enumerate(holders_of(vehicle)):
        if holder is not None:
            beneath.setdefault(holder, set()).add(i)
    numbers = {mounted.name: i for i, mounted in enumerate(vehicle.wheelsets)}
    of_holder = {i: held for held in beneath.values() for i in held}
    joined: dict[str, set[str]] = {body.name: set() for body in vehicle.bodies}
    for end, joint in _joints(vehicle):
        if end in joined:
            joined[end].add(joint)
    while True:
        further = {}
        for body in joined.keys() - beneath.keys():
            carried = [beneath[joint] for joint in joined[body] if joint in beneath]
            carried += [of_holder[numbers[joint]] for joint in joined[body] if numbers.get(joint) in of_holder]
            if carried:
                further[body] = set().union(*carried)
        if not further:
            return {body: tuple(sorted(beneath.get(body, ()))) for body in joined}
        beneath |= further


Level = Literal["wheelset", "bogie frame", "car body"]


def level_of(vehicle: Vehicle, body: str) -> Level:
    """A frame is joined to wheelsets and to another body as well; all other bodies are car bodies."""
    axles = {mounted.name for mounted in vehicle.wheelsets}
    if body in axles:
        return "wheelset"
    joined = _joined(vehicle, body)
    bodies = {b.name for b in vehicle.bodies}
    return "bogie frame" if joined & axles and joined & bodies else "car body"


def bogie_mass(vehicle: Vehicle, body: str) -> float:
    """Mass of a bogie frame and the wheelsets joined to it [kg]; not-a-number for any other body."""
    if level_of(vehicle, body) != "bogie frame":
        return float("nan")
    joined = _joined(vehicle, body)
    frame = next(b.mass for b in vehicle.bodies if b.name == body)
    return frame + sum(mounted.mass for mounted in vehicle.wheelsets if mounted.name in joined)


def _joints(vehicle: Vehicle, without: Container[str] = ()) -> Iterator[tuple[str, str]]:
    """Pairs of bodies that suspension elements join, in both orders, wheelsets for their axle boxes; without: names of
    elements that do not count."""
    for element in vehicle.elements:
        if element.name not in without:
            ends = vehicle.carrier(element.first), vehicle.carrier(element.second)
            yield from (ends, ends[::-1])


def _joined(vehicle: Vehicle, body: str) -> set[str]:
    """Names of the bodies that suspension elements, but no couplings, join to a body."""
    couplings = {name for coupling in vehicle.couplings for name in coupling.elements}
    return {joint for end, joint in _joints(vehicle, couplings) if end == body} - {body}
