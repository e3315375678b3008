"""Flange climbing: Nadal's limit, and for how long it is exceeded."""

from __future__ import annotations

from math import tan

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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
    longest = begin = 0.0
    inside = False
    for i in range(above.size):
        if above[i] > 0.0 and not inside:
            inside = True
            begin = distance[i]
            if i and above[i - 1] <= 0.0:
                begin -= (distance[i] - distance[i - 1]) * above[i] / (above[i] - above[i - 1])
        if inside and above[i] > 0.0:
            longest = max(longest, distance[i] - begin)
        if inside and above[i] <= 0.0:
            inside = False
            end = distance[i - 1] + (distance[i] - distance[i - 1]) * above[i - 1] / (above[i - 1] - above[i])
            longest = max(longest, end - begin)
    return float(longest)
