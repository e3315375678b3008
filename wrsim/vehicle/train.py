"""A train: which bodies of it belong to which vehicle, and what couples these.

A train is a `Vehicle` with the bodies, wheelsets and elements of all its vehicles, from front to rear, and the elements
of the couplings between them. Its origin is that of its first vehicle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from wrsim.vehicle.elements import Triple


@dataclass(frozen=True)
class Member:
    """A vehicle of a train: its name, how many wheelsets and bodies it has, where its origin lies along the train [m],
    and whether its own drive holds its speed, or its couplings alone take it along.
    """

    name: str
    wheelsets: int
    bodies: int
    x: float
    driven: bool = True


@dataclass(frozen=True)
class Coupling:
    """What joins two neighbours: the bodies that it holds on to, ahead and behind, the middle of the plane in which
    the vehicles meet in the design position [m], and the names of its elements.
    """

    name: str
    ahead: str
    behind: str
    at: Triple
    elements: tuple[str, ...]


@dataclass(frozen=True)
class Unit:
    """A vehicle among the parts of a train, or on its own: numbers of its wheelsets and bodies in the order of the
    state, the part whose place stands for it, and what its drive moves: mass, with the inertia of what turns [kg].
    """

    wheelsets: range
    bodies: range
    reference: int
    driven: bool
    pulled_mass: float
    pulled_inertia: float

    @property
    def parts(self) -> tuple[int, ...]:
        """Numbers of all its parts."""
        return (*self.wheelsets, *self.bodies)


def units_of(members: Sequence[Member], masses: Sequence[float], turning: Sequence[float]) -> tuple[Unit, ...]:
    """The vehicles of a train; driven ones share the masses of those that are not.

    masses: of all parts, wheelsets first [kg]; turning: of every wheelset, its inertia about the axle over the square
    of its radius [kg].
    """
    first, body = 0, len(turning)
    found: list[Unit] = []
    for member in members:
        wheelsets, bodies = range(first, first + member.wheelsets), range(body, body + member.bodies)
        own = [masses[i] for i in bodies]
        mass = sum(masses[i] for i in (*wheelsets, *bodies))
        reference = bodies[own.index(max(own))] if own else first
        found.append(Unit(wheelsets, bodies, reference, member.driven, mass, mass + sum(turning[i] for i in wheelsets)))
        first, body = wheelsets.stop, bodies.stop
    driven = [unit for unit in found if unit.driven]
    if len(driven) == len(found) or not driven:
        return tuple(found)
    share = sum(unit.pulled_mass for unit in found) / sum(unit.pulled_mass for unit in driven)
    inertia = sum(unit.pulled_inertia for unit in found) / sum(unit.pulled_inertia for unit in driven)
    return tuple(
        replace(unit, pulled_mass=share * unit.pulled_mass, pulled_inertia=inertia * unit.pulled_inertia)
        for unit in found
    )
