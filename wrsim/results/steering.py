"""Radial steering index: whether rolling alone, without a flange, leads a wheelset radially through a curve.

In a curve of radius R a wheelset with wheels 2e apart rolls without slip where its rolling radii differ by
Delta r_E = 2e r0 / R. The index q_E = Delta r_E / Delta r_max compares that with the largest difference that the outer
wheel reaches before its flange does (EN 14363:2016 [mem]; where the flange begins is our choice): up to 1 the wheelset
can stand radially, beyond that it cannot.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, radians
from typing import Any

import numpy as np
import xarray as xr

CONTACT_DISTANCE = 1.5
"""2 e, between the contact points of both wheels by EN 15302 [m]."""

FLANGE_FROM = radians(40.0)
"""Contact angle from which the outer wheel is on its flange unless said otherwise [rad]."""


@dataclass(frozen=True)
class RadialSteering:
    """radius R, needed and available difference of the rolling radii, shift of the wheelset at which the needed one is
    there, not-a-number where it is not [m]; the less able side of the two counts.
    """

    radius: float
    needed: float
    available: float
    shift: float

    @property
    def index(self) -> float:
        """q_E, infinite where there is no difference at all."""
        return self.needed / self.available if self.available > 0.0 else np.inf


def radial_steering(dataset: xr.Dataset, radius: float) -> RadialSteering:
    """Of a wheelset whose contact was found over its shift (channels of a conicity analysis), in curves of a radius
    [m] to either hand.
    """
    attributes = dataset.attrs
    mean = 0.5 * (float(attributes["radius_left_m"]) + float(attributes["radius_right_m"]))
    needed = CONTACT_DISTANCE * mean / radius
    hands = [_towards(dataset, sign, needed) for sign in (1.0, -1.0)]
    available, shift = min(hands, key=lambda hand: hand[0])
    return RadialSteering(radius, needed, available, shift)


def _towards(dataset: xr.Dataset, sign: float, needed: float) -> tuple[float, float]:
    """Largest difference towards the left (+1) or the right (-1) wheel as the outer one, and the shift at which it
    is as large as needed."""
    place = sign * (dataset["lateral_shift"].values - float(dataset.attrs["equilibrium_shift_m"]))
    order = np.argsort(place)
    place = place[order]
    larger = sign * dataset["rolling_radius_difference"].values[order]
    angle = dataset["contact_angle"].sel(wheel="left" if sign > 0.0 else "right").values[order, 0]
    begin = int(np.searchsorted(place, 0.0))
    on_tread = np.isfinite(larger) & (angle < float(dataset.attrs["flange_from_rad"]))
    end = begin + int(np.argmin(np.append(on_tread[begin:], False)))
    if end == begin:
        return 0.0, np.nan
    most = np.maximum.accumulate(larger[begin:end])
    reached = np.interp(needed, most, place[begin:end]) if most[0] < needed <= most[-1] else np.nan
    return float(most[-1]), float(place[begin]) if needed <= most[0] else float(reached)


def steering_summary(dataset: xr.Dataset) -> dict[str, Any]:
    """What a summary tells of the curves that were asked for; nothing where none were."""
    radii = [float(radius) for radius in str(dataset.attrs.get("curve_radii_m", "")).split()]
    if not radii:
        return {}
    found = [radial_steering(dataset, radius) for radius in radii]
    return {
        "flange_from_deg": degrees(float(dataset.attrs["flange_from_rad"])),
        "smallest_radial_curve_m": _number(found[0].needed * found[0].radius / found[0].available)
        if found[0].available > 0.0
        else None,
        "radial_steering": [
            {
                "curve_radius_m": steering.radius,
                "needed_mm": 1e3 * steering.needed,
                "available_mm": 1e3 * steering.available,
                "q_E": _number(steering.index),
                "shift_mm": _number(1e3 * steering.shift),
            }
            for steering in found
        ],
    }


def _number(value: float) -> float | None:
    """A number that JSON knows."""
    return float(value) if np.isfinite(value) else None
