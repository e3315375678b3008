"""Signed distances around a rail, on a grid: where the search for contact begins.

The field is a guide, not a measure: the search corrects every point that matters to round-off. Negative inside the
steel. Each grid point also knows the arclength of the rail point nearest to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from wrsim.geometry.profile.profile import Array, Profile

SPACING = 0.5e-3
MARGIN_SIDE = 6e-3
MARGIN_TOP = 8e-3
MARGIN_BELOW = 6e-3  # below the lowest point: a flat rail is penetrated there
SAMPLE = 0.05e-3


@dataclass(frozen=True)
class DistanceField:
    """values: (n_o, n_b, 2) signed distance and nearest arclength [m]; origin of the grid and its spacing [m]."""

    values: Array
    origin: tuple[float, float]
    spacing: float


def distance_field(rail: Profile, spacing: float = SPACING) -> DistanceField:
    """Field of a rail profile (already inclined) over its bounding box with a margin all around."""
    n = int(np.ceil(rail.length / SAMPLE)) + 1
    arc = np.linspace(0.0, rail.length, n)
    u, w = rail.at(arc)
    tu, tw = rail.tangent(arc)
    o0, b0 = float(u.min() - MARGIN_SIDE), float(w.min() - MARGIN_BELOW)
    count_o = int(np.ceil((u.max() + MARGIN_SIDE - o0) / spacing)) + 1
    count_b = int(np.ceil((w.max() + MARGIN_TOP - b0) / spacing)) + 1
    grid = np.stack(
        np.meshgrid(o0 + spacing * np.arange(count_o), b0 + spacing * np.arange(count_b), indexing="ij"), axis=-1
    )
    _, nearest = cKDTree(np.column_stack([u, w])).query(grid.reshape(-1, 2))
    du = grid[..., 0].ravel() - u[nearest]
    dw = grid[..., 1].ravel() - w[nearest]
    along = du * tu[nearest] + dw * tw[nearest]
    outward = -du * tw[nearest] + dw * tu[nearest]
    foot = np.clip(arc[nearest] + np.clip(along, -SAMPLE, SAMPLE), 0.0, rail.length)
    # from the foot on the curve, not from the nearest sample: that is up to half a SAMPLE beside it
    distance = np.copysign(np.hypot(outward, along - (foot - arc[nearest])), outward)
    # beyond an end of the curve there is no steel to touch
    beyond = ((nearest == 0) & (along < 0.0)) | ((nearest == n - 1) & (along > 0.0))
    distance[beyond] = np.abs(distance[beyond])
    values = np.stack([distance, foot], axis=-1).reshape(count_o, count_b, 2)
    return DistanceField(np.ascontiguousarray(values), (o0, b0), spacing)
