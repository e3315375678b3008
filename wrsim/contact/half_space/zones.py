"""Where wheel and rail may touch at a pose: zones of overlap along the curved axis of each main point.

Contact lies within the zones in which the undeformed bodies overlap, because pressure pushes the surfaces apart
everywhere. Zones nearer than ``together`` press each other down as one half-space does, zones farther apart than
``apart`` do not act on each other, and in between the influence fades like CONTACT's (docs/theory/half_space.md).
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.half_space.surface import Axis, Bodies, Grid
from wrsim.contact.model import ContactModel
from wrsim.contact.settings import HalfSpaceSettings
from wrsim.contact.surfaces.rolled_rail import REACH
from wrsim.jit import Array

LEVEL = 0.15  # of a lobe's depth: contact beyond it is rare, and found out
KERNEL_LEVEL = 0.45  # of a lobe's depth: about where contact ends
FINEST, COARSEST = 1e-6, 1e-4  # steps of the first look along the axis [m]
LOOK = 400  # steps of the first look to either side, beyond what may act on the main point's zone
TURN = 0.17  # cosine of the largest angle between the normals of one grid (80 degrees)
DEEPEST_GAP = 5e-3  # at which an axis is given up [m]
MOST_LINES, COLUMN = 24, 2.5e-4  # of the look along the rail: lines of a zone, distance of places on them [m]
FADING = 0.8  # exponent


Box = tuple[float, float, float, float]
"""From and to along s, from and to along x [m]."""


@dataclass(frozen=True)
class Footprint:
    """A main point and the zones of overlap that share its axis, by increasing s.

    axis: through the main point; depth: of the overlap there [m]; boxes: from and to along s, from and to along x of
    what is looked at of every zone (zones, 4) [m]; sizes: length along x and width along s of its likely contact
    (zones, 2) [m]; influence: of every zone on every other (zones, zones).
    """

    axis: Axis
    depth: float
    boxes: Array
    sizes: Array
    influence: Array
    bounds: tuple[float, float]

    def extent(self, widening: float) -> list[float]:
        """From and to along s, from and to along x of all zones [m], wider on every side by a share of that."""
        low, high = self.boxes[:, ::2].min(axis=0), self.boxes[:, 1::2].max(axis=0)
        more = widening * (high - low)
        (start, x_start), (end, x_end) = (low - more).tolist(), (high + more).tolist()
        return [max(start, self.bounds[0]), min(end, self.bounds[1]), x_start, x_end]

    @property
    def narrowest(self) -> tuple[float, float]:
        """Length and width of the likely contact of the smallest zone that matters (x, s) [m]."""
        area = self.sizes.prod(axis=1)
        length, width = self.sizes[area > 0.1 * area.max()].min(axis=0)
        return float(length), float(width)

    def shares(self, s: Array) -> tuple[tuple[Array, Array], ...]:
        """For the rows at s: those of each zone that fades apart, and its influence on all rows, both (rows, 1). A row
        belongs to the zone it is nearest to; empty when all zones act as one."""
        if (self.influence == 1.0).all():
            return ()
        zone = np.searchsorted(0.5 * (self.boxes[:-1, 1] + self.boxes[1:, 0]), s)
        return tuple(
            ((zone == n).astype(np.float64)[:, None], self.influence[zone, n][:, None].copy())
            for n in range(len(self.boxes))
        )


def find_footprints(model: ContactModel, settings: HalfSpaceSettings) -> tuple[list[Footprint], float, int]:
    """Main points at the pose that is set, deepest first, with their zones; closest distance [m]; search status."""
    a = model.arrays
    count, status = a.search()
    bodies = Bodies.of(model)
    footprints: list[Footprint] = []
    taken: list[tuple[float, float]] = []  # stretches of the wheel's profile

    def free(start: float, end: float) -> bool:
        return all(end < lo or start > hi for lo, hi in taken)

    for i in np.argsort(-a.contacts["depth"][:count]):
        contact: Any = a.contacts[i]
        if free(contact.arc_wheel, contact.arc_wheel):
            axis = Axis(bodies, float(contact.arc_wheel), float(contact.arc_rail), settings.pairing == "level")
            footprint, reached = _footprint(axis, float(contact.depth), float(contact.curvature), settings, free)
            footprints.append(footprint)
            taken += reached
    return footprints, float(a.total.closest), status


def _footprint(
    axis: Axis, depth: float, curvature: float, settings: HalfSpaceSettings, free: Callable[[float, float], bool]
) -> tuple[Footprint, list[tuple[float, float]]]:
    """Zones around one main point, and the stretches of the wheel's profile that they take. free: whether a stretch
    still belongs to no other main point."""
    step = min(max(sqrt(2.0 * depth / max(curvature, 0.5)) / 12.0, FINEST), COARSEST)
    rows, main, overlaps = _rows_about(axis, depth, step, settings.apart / step)
    pen, arc, real = -rows["gap"], rows["arc_wheel"], axis.bodies.holds(rows)
    spans = [
        (lo, hi)
        for lo, hi in overlaps
        if lo <= main <= hi or (real[lo : hi + 1].any() and free(min(arc[lo], arc[hi]), max(arc[lo], arc[hi])))
    ]
    boxes = np.array([_box(rows, pen, lo, hi, step) for lo, hi in spans])
    apart = np.hypot(_apart(boxes[:, 0], boxes[:, 1]), _apart(boxes[:, 2], boxes[:, 3]))
    # the zone of the main point and, to either side, neighbours that act on each other
    group = np.concatenate([[0], np.cumsum(np.diag(apart, 1) >= settings.apart)])
    joined = np.flatnonzero(group == group[[lo <= main <= hi for lo, hi in spans].index(True)])
    fading = np.clip((settings.apart - apart[np.ix_(joined, joined)]) / (settings.apart - settings.together), 0.0, 1.0)
    inner, sizes = zip(*(_likely(rows, pen, *spans[n], step) for n in joined), strict=True)
    if len(axis.bodies.wheel.shape.depth) or axis.bodies.surface is not None:
        inner = tuple(_with_all_along(axis, rows, *spans[n], box) for n, box in zip(joined, inner, strict=True))
    ends = [sorted((float(arc[spans[n][0]]), float(arc[spans[n][1]]))) for n in joined]
    start, end = spans[joined[0]][0], spans[joined[-1]][1]
    less = max((hi for _lo, hi in overlaps if hi < start), default=-inf)
    more = min((lo for lo, _hi in overlaps if lo > end), default=inf)
    bounds = (0.5 * (less + start) - main) * step, (0.5 * (end + more) - main) * step
    footprint = Footprint(axis, depth, np.array(inner), np.array(sizes), fading**FADING, bounds)
    return footprint, [(lo - 2.0 * step, hi + 2.0 * step) for lo, hi in ends]


def _rows_about(
    axis: Axis, depth: float, step: float, near: float
) -> tuple[NDArray[np.void], int, list[tuple[int, int]]]:
    """Rows about a main point, its row, and the overlaps: as far as one beyond might act on one of these, which is
    nearer than so many rows."""
    main = LOOK + int(near)
    while True:
        rows = axis.lay(step, -main, main)
        rows["gap"][main] = min(rows["gap"][main], -depth)
        overlaps, first, last = _overlaps(rows, -rows["gap"], main)
        real = axis.bodies.holds(rows)
        before, after = first == 0 and real[0], last == 2 * main and real[-1]
        if not (before and overlaps[0][0] < near) and not (after and overlaps[-1][1] > last - near):
            return rows, main, overlaps
        main *= 2


def _with_all_along(axis: Axis, rows: NDArray[np.void], lo: int, hi: int, box: Box) -> Box:
    """The box of a zone, as long as the overlap is: wheels out of round and rails that change along the track may
    overlap at several places. From the lowest point of a round wheel they are as far away as a drop of x^2 / 2R makes
    good for penetration and range of the depth, or of the rail's heights as far as its effective profile looks."""
    bodies = axis.bodies
    wheel, lines = bodies.wheel, rows[lo : hi + 1 : (hi - lo) // MOST_LINES + 1].copy()
    first, last, drop = float(lines["x"].min()), float(lines["x"].max()), -float(lines["gap"].min())
    if len(wheel.shape.depth):
        drop += float(wheel.shape.depth[:, 0].max()) - wheel.shape.least
    if bodies.surface is not None:
        near = np.arange(first - REACH, last + REACH, COLUMN * MOST_LINES)
        drop += float(np.ptp(bodies.sections(near, float(lines["o"].mean()))[0][..., 1].max(axis=1)))
    reach = min(2.0 * sqrt(2.0 * wheel.radius * drop), REACH)  # both places are within half of it
    x = np.arange(first - reach, last + reach, COLUMN)
    along = x[(Grid(bodies, lines, x, COLUMN, 0.0, len(lines) // 2).pen > 0.0).any(axis=0)]
    if not along.size:
        return box
    return *box[:2], min(box[2], float(along[0]) - COLUMN), max(box[3], float(along[-1]) + COLUMN)


def _overlaps(rows: NDArray[np.void], pen: Array, main: int) -> tuple[list[tuple[int, int]], int, int]:
    """Stretches (from, to) of overlapping rows, and the rows as far as which the axis is of use on either side of the
    main point's."""
    facing = rows["no"] * rows["no"][main] + rows["nb"] * rows["nb"][main]
    lost = (facing < TURN) | (pen < -DEEPEST_GAP)
    before, after = np.flatnonzero(lost[: main + 1]), np.flatnonzero(lost[main:])
    first = int(before[-1]) + 1 if before.size else 0
    last = main + int(after[0]) - 1 if after.size else 2 * main
    inside = np.zeros(len(pen) + 2, dtype=bool)
    inside[first + 1 : last + 2] = pen[first : last + 1] > 0.0
    edges = np.flatnonzero(inside[1:] != inside[:-1])
    return [(int(lo), int(hi) - 1) for lo, hi in zip(edges[::2], edges[1::2], strict=True)], first, last


def _apart(start: Array, end: Array) -> Array:
    """Gaps between stretches (n,), each from every other (n, n) [m]."""
    return np.maximum(np.maximum(start[:, None] - end, start - end[:, None]), 0.0)


def _box(rows: NDArray[np.void], pen: Array, lo: int, hi: int, step: float) -> Box:
    """Extent along s and along x of the whole overlap of rows lo .. hi [m]."""
    half = np.sqrt(2.0 * rows["r_t"][lo : hi + 1] * pen[lo : hi + 1])
    x = rows["x"][lo : hi + 1]

    def crossing(row: int, side: int) -> float:
        """Where overlap ends beyond its last row."""
        neighbour = row + side
        if not 0 <= neighbour < len(pen):
            return row * step
        return (row + side * float(pen[row] / (pen[row] - pen[neighbour]))) * step

    return crossing(lo, -1), crossing(hi, 1), float((x - half).min()), float((x + half).max())


def _likely(rows: NDArray[np.void], pen: Array, lo: int, hi: int, step: float) -> tuple[Box, tuple[float, float]]:
    """What is looked at of rows lo .. hi, and the size of their likely contact, see `Footprint`. Every lobe counts from
    its own level on."""
    rows, h = rows[lo : hi + 1], pen[lo : hi + 1]
    # lobes part at the local minima
    low = np.flatnonzero((h[1:-1] <= h[:-2]) & (h[1:-1] < h[2:])) + 1
    crest = np.concatenate([np.full(len(part), part.max()) for part in np.split(h, low)])
    half, likely = (np.sqrt(2.0 * rows["r_t"] * np.maximum(h - level * crest, 0.0)) for level in (LEVEL, KERNEL_LEVEL))
    within = np.flatnonzero(half > 0.0)
    s, x = rows["s"][within], rows["x"]
    box = float(s[0]) - step, float(s[-1]) + step, float((x - half)[within].min()), float((x + half)[within].max())
    return box, (2.0 * float(likely.max()), float(np.count_nonzero(likely)) * step)
