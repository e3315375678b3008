"""Loads, payloads, and moments that drive and brake a vehicle. Plain data, SI units, in the vehicle's axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from wrsim.vehicle.elements import Triple

Drive = Literal["free", "train", "wheels"]
"""What holds the speed: nothing; a force along the track; moments on the axles. See ``dynamics.vehicle_forces``."""

LoadAxes = Literal["track", "body"]
"""Axes of a load's components."""

Over = Literal["time", "distance"]
"""Argument of the table of a load."""


Turned = Literal["left", "right", "both"]
"""Wheels of a wheelset that an effort acts on."""


@dataclass(frozen=True)
class Load:
    """A force at a point [m] of a body that acts at rest and in runs; the springs' preload does not balance it.

    table: rows (x, force [N] along three axes), x rising: the time of the run [s] or the distance of the point along
    the centre line [m]; linear between rows, constant beyond the ends, so that one row is a constant force. axes: those
    of the track (t, n, b) where the point is, or those of the body (of a wheelset: which do not spin).
    """

    name: str
    body: str
    at: Triple
    table: tuple[tuple[float, float, float, float], ...]
    over: Over = "time"
    axes: LoadAxes = "track"

    @classmethod
    def constant(cls, name: str, body: str, force: Triple, at: Triple, axes: LoadAxes = "track") -> Load:
        """A load that stays the same."""
        return cls(name, body, at, ((0.0, *force),), axes=axes)

    @property
    def varies(self) -> bool:
        return any(row[1:] != self.table[0][1:] for row in self.table)

    @property
    def largest(self) -> Triple:
        """The force in the row where it is largest [N]."""
        return max((row[1:] for row in self.table), key=lambda force: float(np.linalg.norm(force)))

    def force(self, time: float, distance: float) -> Triple:
        """The force [N] at a time [s], its point at a distance along the centre line [m]."""
        x, *forces = np.transpose(self.table)
        fx, fy, fz = (float(np.interp(time if self.over == "time" else distance, x, f)) for f in forces)
        return fx, fy, fz


@dataclass(frozen=True)
class Payload:
    """A constant force [N] along the track's axes t, n, b at a point [m] of a body, with which the vehicle is trimmed:
    the springs' preload carries it in the design position.
    """

    name: str
    body: str
    force: Triple
    at: Triple

    def as_load(self) -> Load:
        return Load.constant(self.name, self.body, self.force, self.at)


@dataclass(frozen=True)
class Effort:
    """A moment on a wheelset, or on one of its independent wheels, in runs; positive forward, with its reaction on the
    body that holds the wheelset.

    table: rows (x, moment [N m]), x rising: the time of the run [s] or the distance of the vehicle's origin along the
    centre line [m]; linear between rows, constant beyond the ends.
    """

    wheelset: str
    table: tuple[tuple[float, float], ...]
    over: Over = "time"
    wheel: Turned = "both"

    def moment(self, time: float, distance: float) -> float:
        """The moment [N m] at a time [s], the vehicle's origin at a distance [m]."""
        x, moments = np.transpose(self.table)
        return float(np.interp(time if self.over == "time" else distance, x, moments))


@dataclass(frozen=True)
class GearedMotor:
    """A motor that drives a wheelset through a gear and a hollow axle, see ``dynamics.loads``.

    motor, case: bodies that hold the motor's stator and the gear. ratio: turns of the rotor for one of the axle,
    negative where it turns the other way. rotor_inertia about the rotor, hollow_inertia of hollow axle and large wheel
    about the axle [kg m2]; stiffness [N m/rad] and damping [N m s/rad] of hollow axle and couplings in torsion.
    """

    wheelset: str
    motor: str
    case: str
    ratio: float
    rotor_inertia: float
    hollow_inertia: float
    stiffness: float
    damping: float = 0.0

    @property
    def inertia(self) -> float:
        """Inertia of all that turns, as the hollow axle sees it [kg m2]."""
        return self.hollow_inertia + self.ratio**2 * self.rotor_inertia

    @property
    def case_inertia(self) -> float:
        """Its share of the inertia of its case about the axle [kg m2]: the case cannot turn without it."""
        return self.hollow_inertia * self.rotor_inertia * (1.0 - self.ratio) ** 2 / self.inertia


@dataclass(frozen=True)
class SlipControl:
    """Keeps the slip speed of every axle below speed + creepage V [m/s], see ``dynamics.loads``."""

    speed: float
    creepage: float


@dataclass(frozen=True)
class CarriedMass:
    """A mass [kg] that follows the track frame ``height`` [m] above the centre of a body: its weight and its
    centrifugal force act on the body, the height gives the load transfer; it does not oscillate."""

    body: str
    mass: float
    height: float
