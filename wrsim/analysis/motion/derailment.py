"""Signs that a wheel has left its rail.

They lie in geometry rather than in forces: neither an impact nor a lost contact hides or fakes one.

- The flange is over the rail: its lowest point has passed the gauge face, outward.
- The wheel has dropped: its tread is deeper below the top of its rail than ``DROP``, so it has left the head.

And what acts on a vehicle as a whole: how hard it is pushed aside, and whether that would overturn it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from wrsim.analysis.motion.messages import Derailment, NoSteadyMotion, wheel_words
from wrsim.contact.channels import WheelOnRail
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.records import STATUS_TOO_DEEP
from wrsim.contact.status import status_words
from wrsim.contact.wheel_rail import DEEPEST
from wrsim.errors import InputError
from wrsim.scenario.build import Setup
from wrsim.scenario.sections.run import RunPlan
from wrsim.simulation.law import VehicleOnTrack
from wrsim.track.cant import cant_angle
from wrsim.vehicle.dynamics.watch import WATCH
from wrsim.vehicle.vehicle import Vehicle

DROP = 15e-3  # depth of the tape circle below the top of its rail at which a wheel has left the rail's head [m]


class WatchedWheel:
    """One wheel of a vehicle on its rail, looked at in the pose that its model computed last. words: which wheel."""

    def __init__(self, wheelset: str, wheel: WheelOnRail, label: str) -> None:
        self.wheelset, self.side, self.model, self.label = wheelset, wheel.name, wheel.model, label
        self.tip = flange_tip(wheel.model.wheel)
        self.face = gauge_face(wheel.model.rail)
        self.level = self.model.radius + self.model.rail.top[1]  # height of the axle on the rail's highest point
        rows = wheel.model.arrays.rows
        self._lobes, self._closest, self._N = rows.total["lobes"], rows.total["closest"], rows.patches["N"]

    def off_the_rail(self) -> Derailment | None:
        """How the wheel has left its rail, if it has."""
        pose = self.model.arrays.pose
        height = pose.item(2) - self.level
        if height < -DROP:
            where = "beside its rail" if self.model.rolled is None else "into a gap of its rail, or beside it"
            return Derailment("derailed", f"{self.label} has dropped {where}")
        if self.tip is not None:
            u, w = self.tip  # on the wheel profile; its outward coordinate in the rail's axes:
            if pose.item(1) + u * pose.item(4) + (self.model.radius - w) * pose.item(5) > self.face:
                lifted = f"(lifted by {1e3 * height:.0f} mm)"
                return Derailment("derailed", f"the flange of {self.label} has climbed over its rail {lifted}")
        return None

    @property
    def status(self) -> int:
        """Messages of its contact, see `wrsim.contact.status`."""
        return self.model.arrays.status

    @property
    def depth(self) -> float:
        """Largest overlap with the rail [m]."""
        return -self._closest.item()

    def nearest_end(self) -> int:
        """The end of a profile that is nearest to a patch: inner and outer one of the rail (0, 1), of the wheel (2, 3);
        -1 without a patch."""
        patches = self.model.arrays.patches[: int(self._lobes.item())]
        if not patches.size:
            return -1
        rooms: list[float] = []
        for arc, profile in (("arc_rail", self.model.rail), ("arc_wheel", self.model.wheel)):
            rooms += [(patches[arc] + patches["start"]).min(), profile.length - (patches[arc] + patches["end"]).max()]
        return int(np.argmin(rooms))

    def end_of_profile(self, end: int) -> tuple[str, str, float]:
        """Name, side and outward coordinate [m] of an end in that order."""
        profile, outer = (self.model.rail, self.model.wheel)[end // 2], end % 2
        return profile.name, ("inner", "outer")[outer], float(profile.at(profile.length * outer)[0])

    @property
    def in_contact(self) -> bool:
        """True if any patch carries a force."""
        return any(self._N.item(i) > 0.0 for i in range(self._lobes.item()))


def wheels_of(law: VehicleOnTrack) -> list[WatchedWheel]:
    """All wheels, front ones first, left before right."""
    pairs = zip(law.vehicle.wheelsets, law.wheels, strict=bool(law.wheels))
    return [
        WatchedWheel(mounted.name, wheel, wheel_words(wheel.name, mounted.name, law.vehicle))
        for mounted, pair in pairs
        for wheel in pair
    ]


def watched(wheels: Sequence[WatchedWheel]) -> NDArray[np.void]:
    """Records WATCH of wheels (``dynamics.watch``), with their geometry."""
    records = np.zeros(len(wheels), WATCH)
    for row, wheel in zip(records, wheels, strict=True):
        row.level, row.drop, row.face, row.substitutes = wheel.level, -DROP, wheel.face, wheel.model.arrays.substitutes
        row.flanged = wheel.tip is not None
        if wheel.tip is not None:
            row.u, row.reach = wheel.tip[0], wheel.model.radius - wheel.tip[1]
    records["most"], records["least"] = -np.inf, np.inf
    return records


def overlap(wheels: Sequence[WatchedWheel]) -> Derailment:
    """The wheel that is deepest in its rail."""
    deepest = max(wheels, key=lambda wheel: wheel.depth)
    depth = f"{1e3 * deepest.depth:.2g} mm (more than {1e3 * DEEPEST:g} mm)"
    return Derailment("overlap", f"{deepest.label} and its rail overlap by {depth}")


def derailed(law: VehicleOnTrack) -> Derailment | None:
    """A wheel in its rail, off it, or without load, at the state of the last evaluation of the law."""
    wheels = wheels_of(law)
    if any(wheel.status & STATUS_TOO_DEEP for wheel in wheels):
        return overlap(wheels)
    for wheel in wheels:
        off = wheel.off_the_rail()
        if off is not None:
            return off
        if not wheel.in_contact:
            return Derailment("derailed", f"{wheel.label} has no contact with its rail")
    return None


def contact_words(wheels: Sequence[WatchedWheel], statuses: Sequence[int] | None = None) -> str:
    """Messages of the contacts of wheels, of their last state unless statuses are given; empty when all is well."""
    statuses = [wheel.status for wheel in wheels] if statuses is None else statuses
    pairs = zip(wheels, map(status_words, statuses), strict=True)
    return "; ".join(f"{wheel.label}: {message}" for wheel, message in pairs if message)


@lru_cache(maxsize=32)
def flange_tip(wheel: Profile) -> tuple[float, float] | None:
    """(u, w) of the lowest point of the flange [m]; None for a wheel without a flange."""
    u, w = wheel.at(np.linspace(0.0, wheel.length, 2001))
    flange = u < -0.02
    if not flange.any() or w[flange].min() > -0.01:
        return None
    lowest = int(np.argmin(np.where(flange, w, np.inf)))
    return float(u[lowest]), float(w[lowest])


@lru_cache(maxsize=32)
def gauge_face(rail: Profile) -> float:
    """Outward coordinate of the gauge point of a rail profile [m], of its inner end if it has none."""
    try:
        return rail.gauge_point()[0]
    except InputError:
        return float(rail.at(0.0)[0])


@dataclass(frozen=True)
class QuasiStaticForce:
    """Resultant on a vehicle as one rigid body: force to the left and up [N], in the axes of the track; where it meets
    the plane of the rails to the left of the middle [m]; infinite where it points away from the rails.
    """

    left: float
    up: float
    point: float


def resultant(vehicle: Vehicle, distance: float, curvature: float, tilt: float, speed: float) -> QuasiStaticForce:
    """Resultant of weight, centrifugal force, payloads, and loads of time 0 with the vehicle's origin at a place [m].

    curvature [1/m] and tilt of the track by its cant [rad], both positive to the left; speed [m/s].
    """
    mass = vehicle.mass + sum(carried.mass for carried in vehicle.carried)
    inward = speed**2 * curvature
    left = mass * float(vehicle.gravity * np.sin(tilt) - inward * np.cos(tilt))
    up = -mass * float(vehicle.gravity * np.cos(tilt) + inward * np.sin(tilt))
    _, y, z = vehicle.centre_of_load
    tipping = z * left - y * up  # to the left
    held = vehicle.loaded_as_at(distance).loads
    for load in (*held, *(payload.as_load() for payload in vehicle.payloads)):
        _, fy, fz = load.largest
        _, y, z = load.at
        left, up, tipping = left + fy, up + fz, tipping + z * fy - y * fz
    return QuasiStaticForce(left, up, tipping / -up if up < 0.0 else float(np.copysign(np.inf, tipping)))


def resultant_at_start(setup: Setup[RunPlan], speed: float) -> QuasiStaticForce:
    """The same on the track where the run starts. Raises NoSteadyMotion when it would overturn the vehicle."""
    track, start = setup.track, setup.plan.start
    curvature = float(track.curvature(start))
    tilt = float(cant_angle(track.cant(start), track.cant_base))
    force = resultant(setup.vehicle, start, curvature, tilt, speed)
    check_upright(force, track.cant_base, curvature, setup.vehicle)
    return force


def check_upright(force: QuasiStaticForce, base: float, curvature: float, vehicle: Vehicle) -> None:
    """Raise NoSteadyMotion when it points beside the rails. base: distance between them [m]."""
    beyond = abs(force.point) - 0.5 * base
    if beyond <= 0.0:
        return
    side = "left" if force.point > 0.0 else "right"
    if curvature != 0.0:
        side = "inner" if force.point * curvature > 0.0 else "outer"
    causes = "weight, centrifugal force and loads" if vehicle.loads else "weight and centrifugal force"
    far = f"{1e3 * beyond:.0f} mm" if np.isfinite(beyond) else "far"
    message = f"the vehicle would overturn: its {causes} together point {far} beyond the {side} rail"
    raise NoSteadyMotion(Derailment("overturned", message))
