"""Comfort: weighted accelerations over blocks of 5 s and their mean, as EN 12299 forms them [mem]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wrsim.analysis.ride.weighting import Name, weighted

Array = NDArray[np.float64]

BLOCK = 5.0
"""Length of a block [s]."""
AXES: dict[str, Name] = {"x": "Wd", "y": "Wd", "z": "Wb"}
PERCENTILE = 95.0


@dataclass(frozen=True, eq=False)
class Comfort:
    """Weighted rms over the whole run by axis, over every block of 5 s (blocks, 3), and N_MV, all of one point.

    weighted_rms [m/s2]: x, y, z. continuous (C_Cx, C_Cy, C_Cz) [m/s2] of every block. mean: N_MV = 6 sqrt(sum of the
    squares of the blocks' 95 % percentiles), not-a-number for a run shorter than a block. The standard asks for sixty
    blocks, five minutes; ``blocks`` says how many there were.
    """

    weighted_rms: Array
    continuous: Array
    mean: float

    @property
    def blocks(self) -> int:
        """How many."""
        return int(self.continuous.shape[0])


def comfort(acceleration: Array, rate: float) -> Comfort:
    """Comfort at one point; acceleration (n, 3) along x, y, z [m/s2], rate: samples a second."""
    signals = np.column_stack([weighted(acceleration[:, i], rate, name) for i, name in enumerate(AXES.values())])
    length = round(BLOCK * rate)
    count = signals.shape[0] // length
    blocks = signals[: count * length].reshape(count, length, 3)
    continuous = np.sqrt((blocks**2).mean(axis=1))
    mean = float("nan")
    if count:
        mean = 6.0 * float(np.sqrt((np.percentile(continuous, PERCENTILE, axis=0) ** 2).sum()))
    return Comfort(np.sqrt((signals**2).mean(axis=0)), continuous, mean)
