"""Flange climbing: Nadal's limit, from the friction and the flange's angle of a run, and how far it is exceeded."""

from math import degrees, radians, tan
from typing import Any

import numpy as np
import xarray as xr

from wrsim.assessment.outcome import Array
from wrsim.assessment.settings import AssessmentSettings
from wrsim.contact.settings import ContactSettings
from wrsim.results.dataset import table_of_scenario


def nadal_limit(flange_angle: float, friction: float) -> float:
    """Y/Q above which a wheel in full slip sideways climbs its flange: (tan g - mu)/(1 + mu tan g) (Nadal 1896).

    flange_angle [rad]: largest contact angle of the flange; friction: coefficient.
    """
    slope = tan(flange_angle)
    return (slope - friction) / (1.0 + friction * slope)


TCRP_ANGLES = 60.0, 76.0
"""Angles of flanges [degrees] for which `distance_to_climb` has one; its terms have poles at 55.1, 76.6 and 77.0."""


def has_distance(flange_angle: float) -> bool:
    """Whether `distance_to_climb` knows a flange of this angle [rad]."""
    return radians(TCRP_ANGLES[0]) <= flange_angle <= radians(TCRP_ANGLES[1])


def distance_to_climb(attack: Array, flange_angle: float, flange_length: float) -> Array:
    """The way that a wheel goes until it has climbed, its Y/Q above Nadal's limit [m]; not a number for other flanges.

    attack (n,): angle of attack [rad], that of the flange against its rail positive; flange_angle [rad], from 60 to 76
    degrees; flange_length: of the flange's steepest part [m]. Source: TCRP Report 71, volume 5, TRB 2005, a fit to
    simulations with friction 0.5, confirmed on a track loading vehicle; where the flange does not attack, 0 mrad count.
    """
    if not has_distance(flange_angle):
        return np.full(np.shape(attack), np.nan)
    angle, length = degrees(flange_angle), flange_length / 0.0254
    a = (100.0 / (-1.9128 * angle + 146.56) + 3.1) * length
    a += 1.23 - 1.0 / (-0.0092 * angle**2 + 1.2152 * angle - 39.031)
    b = (10.0 / (-21.157 * length + 2.1052) + 0.05) * angle + 10.0 / (0.2688 * length - 0.0266) - 5.0
    return np.asarray(0.3048 * a * b * length / (np.maximum(1e3 * attack, 0.0) + b * length))


def longest_stretch(distance: Array, above: Array) -> float:
    """Length of the longest connected stretch on which ``above`` (n,) is positive [m].

    The signal is linear between its samples, so that the ends of a stretch lie between them; not-a-number is above.
    """
    above = np.where(np.isfinite(above), above, 1.0)
    inside = above > 0.0
    turns = np.flatnonzero(np.diff(inside))
    before, after, step = above[turns], above[turns + 1], np.diff(distance)[turns]
    rising = distance[turns + 1] - step * after / (after - before)
    falling = distance[turns] + step * before / (before - after)
    crossings = np.where(inside[turns], falling, rising)
    first, last = distance[:1][inside[:1]], distance[-1:][inside[-1:]]
    ends = np.concatenate([first, crossings, last])
    return float((ends[1::2] - ends[::2]).max(initial=0.0))


class Climbing:
    """What the flanges of a run have against climbing.

    friction, flange_angle [rad]: of the run or of the settings, None where neither has them; flange_length [m]: of the
    settings.
    """

    def __init__(self, dataset: xr.Dataset, settings: AssessmentSettings) -> None:
        self.friction = _friction_of(dataset) if settings.friction is None else settings.friction
        self.flange_angle = _flange_angle_of(dataset) if settings.flange_angle is None else settings.flange_angle
        self.flange_length = settings.flange_length

    def nadal(self, friction: float | None) -> tuple[float, str] | None:
        """Nadal's limit and its derivation; None where something is unknown. friction: of a clause, if it has one."""
        friction = self.friction if friction is None else friction
        if friction is None or self.flange_angle is None:
            return None
        derivation = f"flange {np.degrees(self.flange_angle):.1f}°, friction {friction:g}"
        return nadal_limit(self.flange_angle, friction), derivation

    def distance(self, attack: Array) -> Array | None:
        """`distance_to_climb` for angles of attack (n,) [rad]; None where it is unknown."""
        if self.flange_length is None or self.flange_angle is None or self.out_of_range():
            return None
        return distance_to_climb(attack, self.flange_angle, self.flange_length)

    def out_of_range(self) -> str:
        """Why a flange of known angle and length has no distance to climb; empty where it has one."""
        if self.flange_length is None or self.flange_angle is None or has_distance(self.flange_angle):
            return ""
        low, high = TCRP_ANGLES
        return f"distance to climb: TCRP 71 has it for {low:g} to {high:g}°, not for {degrees(self.flange_angle):.1f}°"

    def missing(self) -> str:
        """What is unknown, for a note."""
        return "angle of the flange" if self.flange_angle is None else "coefficient of friction"


def _friction_of(dataset: xr.Dataset) -> float | None:
    """Largest coefficient of friction of both rails, along the track or in the scenario, with what the temperature may
    add to it; None where neither has one."""
    contact = table_of_scenario(dataset, "contact")
    rise = max((contact or {}).get("temperature", {}).get("friction_change", 0.0), 0.0)
    if "rail_friction" in dataset:
        return rise + float(max(dataset[name].max() for name in ("rail_friction", "rail_friction_corner")))
    if contact is None:
        return None
    friction = contact.get("friction", _largest(ContactSettings().friction))
    largest = [_largest(contact.get(f"friction_{side}", friction)) for side in ("left", "right")]
    return max((rise + value for value in largest if value is not None), default=None)


def _largest(friction: Any) -> float | None:
    """The largest coefficient in a number, a pair or a table of a law."""
    if isinstance(friction, int | float):
        return float(friction) if 0.0 <= friction <= 2.0 else None
    parts = [getattr(friction, "static", None), getattr(friction, "gauge_corner", None)]
    if isinstance(friction, tuple | list):
        parts = [_largest(part) for part in friction]
    elif isinstance(friction, dict):
        parts = [_largest(friction.get(name)) for name in ("static", "gauge_corner", "coefficient")]
    return max((float(part) for part in parts if part is not None), default=None)


def _flange_angle_of(dataset: xr.Dataset) -> float | None:
    """Largest angle of the flange's face against the axle [rad], from the wheels' outlines in the result.

    None without outlines, or for wheels without a flange.
    """
    if "wheel_profile_y" not in dataset:
        return None
    outlines = [dataset[f"wheel_profile_{c}"].values.reshape(-1, dataset.sizes["wheel_point"]) for c in "yz"]
    steepest = []
    for y, z in zip(*outlines, strict=True):
        if np.isfinite(y).all() and np.isfinite(z).all():
            tip = int(np.argmin(z))
            dy, dz = np.diff(y[tip:]), np.diff(z[tip:])
            rising = (y[tip + 1 :] > y[tip]) & (dy > 0.0) & (dz > 0.0)
            steepest.append(float(np.arctan2(dz[rising], dy[rising]).max(initial=0.0)))
    flanged = [angle for angle in steepest if angle > np.radians(45.0)]
    return float(np.median(flanged)) if flanged else None
