"""Flange climbing: Nadal's limit, from the friction and the flange's angle of a run, and how far it is exceeded."""

from __future__ import annotations

from math import tan
from typing import Any

import numpy as np
import xarray as xr

from wrsim.contact.settings import ContactSettings
from wrsim.results.assessment import Array
from wrsim.results.dataset import table_of_scenario
from wrsim.scenario.sections.assessment import AssessmentSettings


def nadal_limit(flange_angle: float, friction: float) -> float:
    """Y/Q above which a wheel in full slip sideways climbs its flange: (tan g - mu)/(1 + mu tan g) (Nadal 1896).

    flange_angle [rad]: largest contact angle of the flange; friction: coefficient.
    """
    slope = tan(flange_angle)
    return (slope - friction) / (1.0 + friction * slope)


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

    friction, flange_angle [rad]: of the run or of the settings, None where neither has them.
    """

    def __init__(self, dataset: xr.Dataset, settings: AssessmentSettings) -> None:
        self.friction = _friction_of(dataset) if settings.friction is None else settings.friction
        self.flange_angle = _flange_angle_of(dataset) if settings.flange_angle is None else settings.flange_angle

    def nadal(self, friction: float | None) -> tuple[float, str] | None:
        """Nadal's limit with its words; None where something is unknown. friction: that of a clause, if it has one."""
        friction = self.friction if friction is None else friction
        if friction is None or self.flange_angle is None:
            return None
        words = f"flange {np.degrees(self.flange_angle):.1f}°, friction {friction:g}"
        return nadal_limit(self.flange_angle, friction), words

    def missing(self) -> str:
        """What is unknown, for a note."""
        return "angle of the flange" if self.flange_angle is None else "coefficient of friction"


def _friction_of(dataset: xr.Dataset) -> float | None:
    """Largest coefficient of friction of both rails, along the track or in the scenario; None where neither has one."""
    if "rail_friction" in dataset:
        return float(max(dataset[name].max() for name in ("rail_friction", "rail_friction_corner")))
    if (contact := table_of_scenario(dataset, "contact")) is None:
        return None
    both = contact.get("friction", _largest(ContactSettings().friction))
    found = [_largest(contact.get(f"friction_{side}", both)) for side in ("left", "right")]
    return max((value for value in found if value is not None), default=None)


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
