"""What an assessment takes from a result: its own settings, the friction and the angle of the flange."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np
import xarray as xr

from wrsim.contact.settings import ContactSettings
from wrsim.errors import InputError
from wrsim.scenario.loading import load_text
from wrsim.scenario.sections.assessment import AssessmentSection, AssessmentSettings


def settings_of(dataset: xr.Dataset) -> AssessmentSettings:
    """[assessment] of the scenario that the result carries; the defaults where that says nothing."""
    try:
        section = load_text(str(dataset.attrs.get("scenario_text", ""))).table(AssessmentSection)
    except InputError:  # a result without a scenario, or of an older wrsim
        return AssessmentSettings()
    return section.settings()


def friction_of(dataset: xr.Dataset) -> float | None:
    """Larger coefficient of friction of both rails in the scenario that the result carries; None without one."""
    try:
        scenario = tomllib.loads(str(dataset.attrs.get("scenario_text", "")))
    except tomllib.TOMLDecodeError:
        return None
    contact: dict[str, Any] = scenario.get("contact", {})
    both = contact.get("friction", _largest(ContactSettings().friction))
    found = [_largest(contact.get(f"friction_{side}", both)) for side in ("left", "right")]
    return max((value for value in found if value is not None), default=None)


def _largest(friction: Any) -> float | None:
    """The largest coefficient in a number, a pair or a table of a law."""
    if isinstance(friction, int | float):
        return float(friction)
    parts = [getattr(friction, "static", None), getattr(friction, "gauge_corner", None)]
    if isinstance(friction, tuple | list):
        parts = [_largest(part) for part in friction]
    elif isinstance(friction, dict):
        parts = [friction.get(name) for name in ("static", "gauge_corner", "coefficient")]
    return max((float(part) for part in parts if part is not None), default=None)


def flange_angle_of(dataset: xr.Dataset) -> float | None:
    """Largest angle of the flange's face against the axle [rad], from the wheels' outlines in the result.

    None without outlines, or for wheels without a flange.
    """
    if "wheel_profile_y" not in dataset:
        return None
    y = dataset["wheel_profile_y"].values.reshape(-1, dataset.sizes["wheel_point"])
    z = dataset["wheel_profile_z"].values.reshape(y.shape)
    steepest = [_face(a, b) for a, b in zip(y, z, strict=True) if np.isfinite(a).all() and np.isfinite(b).all()]
    steepest = [angle for angle in steepest if angle > np.radians(45.0)]
    return float(np.median(steepest)) if steepest else None


def _face(y: np.ndarray, z: np.ndarray) -> float:
    """Steepest angle between the tip of the flange and the tread."""
    tip = int(np.argmin(z))
    outward = y[tip + 1 :] > y[tip]
    dy, dz = np.diff(y[tip:]), np.diff(z[tip:])
    rising = outward & (dy > 0.0) & (dz > 0.0)
    return float(np.arctan2(dz[rising], dy[rising]).max(initial=0.0))
