"""The height of a wheel at which it carries a load: secants on force^(2/3), nearly linear in the height."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

LARGEST_MOVE = 0.3  # of the approach in one step
EVALUATIONS = 40


class LoadNotReached(Exception):
    """The load is not met within any sensible approach."""


class Carried(NamedTuple):
    """What a wheel carries at a height: vertical force [N], largest approach [m]."""

    force: float
    approach: float


def height_for_load(
    carried: Callable[[float], Carried], load: float, height: float, *, tolerance: float, farthest: float
) -> float:
    """Height [m] at which ``carried`` gives the load [N] to a relative tolerance; the last one asked for.

    height: to begin with. Raises LoadNotReached when the load is not met within ``farthest`` of it [m]; a load in a
    jump of the force ends at the jump.
    """
    target = load ** (2.0 / 3.0)
    high, low = np.inf, -np.inf  # heights with too little and too much force
    first = height
    at = carried(height)
    excess = _power(at) - target
    # force^(2/3) is about proportional to the approach
    rate = -max(_power(at), 0.1 * target) / max(at.approach, 1e-7)
    for _ in range(EVALUATIONS):
        if abs(at.force / load - 1.0) < tolerance:
            break
        if excess < 0.0:
            high = min(high, height)
        else:
            low = max(low, height)
        largest = LARGEST_MOVE * max(at.approach, 1e-6)
        new = height + float(np.clip(-excess / rate, -largest, largest))
        if not low < new < high:
            new = 0.5 * (low + high) if np.isfinite(low) and np.isfinite(high) else height - excess / rate
        if abs(new - first) > farthest:
            raise LoadNotReached(f"{load:g} N are not reached within {1e3 * farthest:g} mm of approach")
        if abs(new - height) < 1e-13:
            break
        last, last_height = excess, height
        height = new
        at = carried(height)
        excess = _power(at) - target
        if (excess - last) * (height - last_height) < 0.0:
            rate = (excess - last) / (height - last_height)
    return height


def _power(at: Carried) -> float:
    return float(np.cbrt(max(at.force, 0.0)) ** 2)
