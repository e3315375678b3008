"""The contact angle: from where it is measured, and its sign."""

from math import atan2

import numpy as np
from numpy.typing import NDArray

from wrsim.jit import inlined


@inlined
def contact_angle(no: float, nb: float) -> float:
    """Angle of a strip's plane against the track plane [rad], from its normal (no, nb) that points from rail to wheel.

    o points outward and b up on both sides of the track. The angle is positive where the normal leans to the middle of
    the track (no < 0): on flange and flange root of both wheels.
    """
    return atan2(-no, nb)


def contact_angles(no: NDArray[np.float64], nb: NDArray[np.float64]) -> NDArray[np.float64]:
    """``contact_angle`` of arrays."""
    return np.asarray(np.arctan2(-no, nb))


def mean_contact_angle(angle: NDArray[np.float64], force: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angle [rad] of the sum of normal forces that act at these angles, along the last axis."""
    across, up = ((force * share).sum(axis=-1, initial=0.0) for share in (np.sin(angle), np.cos(angle)))
    return np.asarray(np.arctan2(across, up))
