"""Signed distances around a rail, on a grid: where the search for contact begins.

The field is a guide, not a measure: the search corrects every point that matters to round-off. It is negative inside
the steel, and holds the arclength of the nearest rail point as well.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.profiles.profile import Array, Profile

SPACING = 0.5e-3
MARGIN_SIDE = 6e-3
MARGIN_TOP = 8e-3
MARGIN_BELOW = 6e-3  # below the lowest point: a flat rail is penetrated there
SAMPLE = 0.05e-3
WALK, WALKS = 0.5e-3, 4  # along the curve to the foot of a point: each time at most [m], times


@dataclass(frozen=True)
class DistanceField:
    """values: (n_o, n_b, 2) signed distance and nearest arclength [m]; origin of the grid and its spacing [m]."""

    values: Array
    origin: tuple[float, float]
    spacing: float


def distance_field(rail: Profile) -> DistanceField:
    """Field of a rail profile (already inclined) over its bounding box with a margin all around."""
    n = int(np.ceil(rail.length / SAMPLE)) + 1
    arc = np.linspace(0.0, rail.length, n)
    low, counts = grid_about(np.column_stack(rail.at(arc)), SPACING)
    values = field_of_points(arc, np.column_stack((*rail.at(arc), *rail.tangent(arc))), low, counts, SPACING)
    return DistanceField(values, low, SPACING)


def grid_about(points: Array, spacing: float) -> tuple[tuple[float, float], tuple[int, int]]:
    """Origin and numbers of rows and columns of a grid about points (n, 2), with a margin all around."""
    least, most = points.min(axis=0), points.max(axis=0)
    o0, b0 = float(least[0] - MARGIN_SIDE), float(least[1] - MARGIN_BELOW)
    count_o = int(np.ceil((most[0] + MARGIN_SIDE - o0) / spacing)) + 1
    count_b = int(np.ceil((most[1] + MARGIN_TOP - b0) / spacing)) + 1
    return (o0, b0), (count_o, count_b)


def field_of_points(
    arc: Array, rows: Array, low: tuple[float, float], counts: tuple[int, int], spacing: float
) -> Array:
    """Signed distance and nearest arclength (n_o, n_b, 2) on a grid of a densely sampled curve.

    arc: (n,) equal steps; rows: (n, 4) of u, w and the unit tangent.
    """
    u, w, tu, tw = rows.T
    last, step = float(arc[-1]), float(arc[1] - arc[0])
    axes = (origin + spacing * np.arange(count) for origin, count in zip(low, counts, strict=True))
    o, b = (axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    nearest = _nearest_cells(rows[:, :2], low, counts, spacing)
    for _ in range(WALKS):
        along = (o - u[nearest]) * tu[nearest] + (b - w[nearest]) * tw[nearest]
        reach = np.rint(np.clip(along, -WALK, WALK) / step).astype(int)
        nearest = np.clip(nearest + reach, 0, u.size - 1)
    du, dw = o - u[nearest], b - w[nearest]
    along = du * tu[nearest] + dw * tw[nearest]
    outward = -du * tw[nearest] + dw * tu[nearest]
    foot = np.clip(arc[nearest] + np.clip(along, -step, step), 0.0, last)
    # from the foot on the curve, not from the nearest sample: that is up to half a step beside it
    distance = np.copysign(np.hypot(outward, along - (foot - arc[nearest])), outward)
    # beyond an end of the curve there is no steel to touch
    beyond = ((nearest == 0) & (along < 0.0)) | ((nearest == len(arc) - 1) & (along > 0.0))
    distance[beyond] = np.abs(distance[beyond])
    return np.ascontiguousarray(np.stack([distance, foot], axis=-1).reshape(*counts, 2))


def _nearest_cells(
    points: Array, low: tuple[float, float], counts: tuple[int, int], spacing: float
) -> NDArray[np.intp]:
    """Number of a point (n, 2) of the curve in the cell of the grid that is nearest to each place of it, (n_o n_b,).

    Beside the true nearest one by two halves of a cell's diagonal at most, and elsewhere only where two parts of the
    curve are as near as that.
    """
    cells = np.rint((points - low) / spacing).astype(int)
    inside = ((cells >= 0) & (cells < counts)).all(axis=1)
    first = np.full(counts, -1)
    first[tuple(cells[inside].T)] = np.flatnonzero(inside)
    # as scipy.ndimage, which takes a quarter of a second to import: the nearest cell of a column, then of all of them
    row, far = np.arange(counts[0])[:, None], sum(counts)
    before = np.maximum.accumulate(np.where(first < 0, -far, row))
    behind = np.minimum.accumulate(np.where(first < 0, 2 * far, row)[::-1])[::-1]
    nearest = np.where(row - before <= behind - row, before, behind)
    square = ((nearest - row) ** 2).astype(np.int32)
    across = (np.subtract.outer(*2 * (np.arange(counts[1]),)) ** 2).astype(np.int32)
    column = np.array([(across + each).argmin(axis=1) for each in square])
    return first[np.take_along_axis(nearest, column, axis=1), column].ravel()
