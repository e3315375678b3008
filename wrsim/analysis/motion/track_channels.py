"""Channels of the track under a wheelset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from wrsim.geometry.track.track import Track

Array = NDArray[np.float64]
SIDES: tuple[Literal["left", "right"], ...] = ("left", "right")


def track_channels(track: Track, distance: Array) -> dict[str, Array]:
    """Curvature, cant, gauge and grade (n,) at distances along the centre line [m]; on uneven tracks the
    irregularities of the rails (n, 2) as well."""
    channels = {
        "curvature": track.curvature(distance),
        "cant": track.cant(distance),
        "gauge": track.gauge(distance),
        "grade": track.grade(distance),
    }
    if track.is_uneven:
        left, up = np.moveaxis(uneven(track, distance), -1, 0)
        channels |= {"rail_lateral": left, "rail_vertical": up}
    return channels


def uneven(track: Track, distance: Array) -> Array:
    """Irregularities under the left and the right wheel, to the left and up (n, 2, 2) [m]."""
    return np.stack([np.stack(track.irregularity(side, distance), axis=-1) for side in SIDES], axis=1)
