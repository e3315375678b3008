"""Wind across the track on the body of a vehicle: forces by coefficients over the yaw angle, steady or in a gust.

A vehicle that runs at v in a wind u square to the track has the air against it at an angle beta, tan(beta) = u/v, with
the pressure q = rho/2 (u^2 + v^2). Side force q A c_y and lift q A c_z act across the track and up, the roll moment
q A l c_m about the middle of the track at the height of the rails, positive towards the lee (EN 14067-6). In place of
coefficients: a side force q A c sin(beta) at the height of its centre, which is 0 without wind.

The gust of EN 14067-6 ("Chinese hat"), all figures [mem]: on a mean wind U/1.6946, U the largest wind, stands a peak of
2.84 standard deviations that falls on both sides as exp(-16 f |x|/mean), f = 1/(2 T), T = 0.95 * 4.1825 times the
square root of (integral S dn over integral n^2 S dn), S von Karman's spectrum with a length of 96.04 m from 1/300 to
1 Hz. What a vehicle feels is the mean over its length.
"""

from dataclasses import dataclass, replace
from math import cos, sin

import numpy as np
from numpy.typing import ArrayLike

from wrsim.vehicle.elements import Array
from wrsim.vehicle.loads import Load
from wrsim.vehicle.vehicle import Vehicle

GUST_FACTOR = 1.6946  # largest over mean wind
STEP = 0.5  # between places along the track at which the force is given [m]
ARM = 1.0  # half the distance of the couple of vertical forces [m]


@dataclass(frozen=True)
class Air:
    """area of the side [m2]; height of the side force above the rails [m]; coefficient of the side force; density of
    the air [kg/m3]; table: rows of a yaw angle [rad] and the coefficients of side force, lift and roll moment, which
    take the place of height and coefficient; length: of the roll moment [m]."""

    area: float
    height: float
    coefficient: float
    density: float
    table: tuple[tuple[float, float, float, float], ...] = ()
    length: float = 0.0

    def forces(self, wind: ArrayLike, running: float) -> tuple[Array, Array, Array]:
        """Side force and lift [N], roll moment about the middle of the track [N m], of winds square to the track, at
        a speed of the vehicle [m/s]."""
        speed = np.asarray(wind, dtype=float)
        yaw = np.arctan2(speed, running)
        push = 0.5 * self.density * self.area * (speed**2 + running**2)
        if not self.table:
            side = push * self.coefficient * np.sin(yaw)
            return side, np.zeros_like(side), self.height * side
        angles, *coefficients = np.transpose(self.table)
        side, lift, roll = (push * np.interp(yaw, angles, coefficient) for coefficient in coefficients)
        return side, lift, self.length * roll

    def along_track(
        self, vehicle: Vehicle, largest: float, begins: float, peak: float, gusty: bool, running: float, **across: float
    ) -> Vehicle:
        """The vehicle, or each of a train, in a wind along its way (`felt`); across: as `loads` takes it."""
        loads = list(vehicle.loads)
        for unit in (unit for unit in vehicle.units if unit.parts):
            centres = [vehicle.parts[i].centre[0] for i in (*unit.wheelsets, *unit.bodies)]
            way = felt(largest, begins, peak, max(centres) - min(centres), gusty)
            loads += self.loads(vehicle, *way, running, on=unit.reference, **across)
        return replace(vehicle, loads=tuple(loads))

    def loads(
        self, vehicle: Vehicle, places: ArrayLike, wind: ArrayLike, running: float, left: float = 1.0,
        tilt: float = 0.0, on: int | None = None,
    ) -> tuple[Load, ...]:  # fmt: skip
        """Loads on a reference body (on: its number; of the first vehicle unless given), as `Vehicle.reference`: of a
        wind (n,) [m/s] over rising places of its centre along the track (n,) [m].

        The side force acts at its height, or with coefficients at the rails; a couple of vertical forces is the rest
        of the roll moment. left: 1 for a wind towards the left, -1 to the right; tilt: of the track, its lee side
        higher, in a level wind [rad].
        """
        side, lift, roll = self.forces(np.atleast_1d(wind), running)
        body, height = vehicle.parts[vehicle.reference if on is None else on], 0.0 if self.table else self.height
        whose = f"{body.name}: " if vehicle.members else ""
        across, up = left * (side * cos(tilt) + lift * sin(tilt)), lift * cos(tilt) - side * sin(tilt)
        couple, none = -0.5 / ARM * left * (roll - height * side), np.zeros_like(side)
        pushes = [("wind", 0.0, height, across, up)]
        if self.table:
            pushes += [("wind, left", ARM, 0.0, none, couple), ("wind, right", -ARM, 0.0, none, -couple)]
        rows = np.atleast_1d(places)
        tables = [tuple(map(tuple, np.column_stack([rows, none, y, z]).tolist())) for *_, y, z in pushes]
        return tuple(
            Load(whose + name, body.name, (body.centre[0], y, z), table, "distance")
            for (name, y, z, *_), table in zip(pushes, tables, strict=True)
        )


def gust_decay(mean: float) -> float:
    """Distance from the peak of a gust at which it has fallen to 1/e [m]; mean: wind [m/s]."""
    n = np.linspace(1.0 / 300.0, 1.0, 3000)
    spectrum = (1.0 + 70.8 * (96.04 * n / mean) ** 2) ** (-5.0 / 6.0)
    duration = 0.95 * 4.1825 * float(np.sqrt(spectrum.sum() / (n**2 * spectrum).sum()))
    return 2.0 * duration * mean / 16.0


def gust(largest: float, along: ArrayLike, decay: float | None = None) -> Array:
    """Wind [m/s] at distances along the track from the peak of a gust [m]; largest: at the peak; decay: `gust_decay`
    unless given, with inf a steady wind."""
    mean = largest / GUST_FACTOR
    fallen = np.exp(-np.abs(along) / (decay or gust_decay(mean)))
    return mean + (largest - mean) * fallen


def felt(largest: float, begins: float, peak: float, length: float, gusty: bool) -> tuple[Array, Array]:
    """Places along the track [m] and the wind there [m/s] that a vehicle of a length [m] feels.

    The mean wind, without a gust all of it, rises over the first half of the way from where it begins to the peak.
    """
    places = np.arange(begins, 2.0 * peak - begins + STEP, STEP)
    wind = gust(largest, places - peak) if gusty else np.full_like(places, largest)
    width = max(round(length / STEP), 1)
    wind = np.convolve(np.pad(wind, width, mode="edge"), np.full(width, 1.0 / width), mode="same")[width:-width]
    part = np.clip(2.0 * (places - begins) / (peak - begins), 0.0, 1.0)
    return places, wind * (0.5 - 0.5 * np.cos(np.pi * part))
