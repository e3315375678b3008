"""Where wheel and rail may touch at a pose: zones of overlap along the curved axis of each main point.

Contact lies within the zones in which the undeformed bodies overlap, because pressure pushes the surfaces apart
everywhere. Zones nearer than ``together`` press each other down as one half-space does, zones farther apart than
``apart`` do not know of each other, and in between the mutual influence fades like CONTACT's,
((apart - d)/(apart - together))^0.8, so that nothing jumps as the distance d of two zones changes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import hypot, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.half_space.surface import Axis, Bodies
from wrsim.contact.model import ContactModel
from wrsim.contact.settings import HalfSpaceSettings

Array = NDArray[np.float64]

LEVEL = 0.15  # of a lobe's depth: contact beyond it is rare, and found out
KERNEL_LEVEL = 0.45  # of a lobe's depth: about where contact ends
FINEST, COARSEST = 1e-6, 1e-4  # steps of the first look along the axis [m]
LOOK = 400  # steps of the first look to either side
TURN = 0.17  # cosine of the largest angle between the normals of one grid (80 degrees)
DEEPEST_GAP = 5e-3  # at which an axis is given up [m]
FADING = 0.8  # exponent


@dataclass(frozen=True)
class Box:
    """Extent along the axis and along the rail [m]."""

    start: float
    end: float
    x_start: float
    x_end: float

    def distance(self, other: Box) -> float:
        """Between two boxes [m]."""
        along_s = max(other.start - self.end, self.start - other.end, 0.0)
        along_x = max(other.x_start - self.x_end, self.x_start - other.x_end, 0.0)
        return hypot(along_s, along_x)

    def widened(self, share: float) -> Box:
        """Larger on every side by a share of its extent."""
        s, x = share * (self.end - self.start), share * (self.x_end - self.x_start)
        return Box(self.start - s, self.end + s, self.x_start - x, self.x_end + x)


@dataclass(frozen=True)
class Zone:
    """A zone of overlap: what is looked at of it, and width (along s) and length (along x) of its contact [m]."""

    box: Box
    width: float
    length: float


@dataclass(frozen=True)
class Footprint:
    """A main point and the zones that share its axis, by increasing s.

    axis: through the main point; depth: of the overlap there [m]; influence: of every zone on every other.
    """

    axis: Axis
    depth: float
    zones: tuple[Zone, ...]
    influence: Array

    @property
    def box(self) -> Box:
        """Of all zones."""
        boxes = [zone.box for zone in self.zones]
        return Box(
            min(b.start for b in boxes), max(b.end for b in boxes),
            min(b.x_start for b in boxes), max(b.x_end for b in boxes),
        )  # fmt: skip

    @property
    def narrowest(self) -> tuple[float, float]:
        """Length and width of the likely contact of the smallest zone that matters (x, s) [m]."""
        largest = max(z.length * z.width for z in self.zones)
        matter = [z for z in self.zones if z.length * z.width > 0.1 * largest]
        return min(z.length for z in matter), min(z.width for z in matter)

    def shares(self, s: Array) -> tuple[tuple[Array, Array], ...]:
        """For the rows at s: those of each zone that fades apart, and its influence on all rows, both (rows, 1).

        A row belongs to the zone it is nearest to; empty when all zones act as one.
        """
        if (self.influence == 1.0).all():
            return ()
        borders = [0.5 * (p.box.end + q.box.start) for p, q in zip(self.zones[:-1], self.zones[1:], strict=True)]
        zone = np.searchsorted(borders, s)
        return tuple(
            ((zone == n).astype(np.float64)[:, None], self.influence[zone, n][:, None].copy())
            for n in range(len(self.zones))
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

    for i in np.argsort(-a.found["depth"][:count]):
        found: Any = a.found[i]
        if free(found.arc_wheel, found.arc_wheel):
            axis = Axis(bodies, float(found.arc_wheel), float(found.arc_rail), settings.pairing == "level")
            footprint, reached = _look(axis, float(found.depth), float(found.curvature), settings, free)
            footprints.append(footprint)
            taken += reached
    return footprints, float(a.total.closest), status


def _look(
    axis: Axis, depth: float, curvature: float, settings: HalfSpaceSettings, free: Callable[[float, float], bool]
) -> tuple[Footprint, list[tuple[float, float]]]:
    """Zones around one main point, and the stretches of the wheel's profile that they take.

    free: whether a stretch still belongs to no other main point.
    """
    step = min(max(sqrt(2.0 * depth / max(curvature, 0.5)) / 12.0, FINEST), COARSEST)
    rows = axis.lay(step, -LOOK, LOOK)
    pen, arc = -rows["gap"], rows["arc_wheel"]
    pen[LOOK] = max(pen[LOOK], depth)
    real = axis.bodies.holds(rows)
    found = [
        (lo, hi)
        for lo, hi in _overlaps(rows, pen)
        if lo <= LOOK <= hi or (real[lo : hi + 1].any() and free(min(arc[lo], arc[hi]), max(arc[lo], arc[hi])))
    ]
    boxes = [_box(rows, pen, lo, hi, step) for lo, hi in found]
    joined = _joined(found, boxes, settings.apart)
    influence = np.array([[_fading(boxes[i].distance(boxes[j]), settings) for i in joined] for j in joined])
    zones = tuple(_zone(rows, pen, *found[n], step) for n in joined)
    ends = [sorted((float(arc[found[n][0]]), float(arc[found[n][1]]))) for n in joined]
    return Footprint(axis, depth, zones, influence), [(lo - 2.0 * step, hi + 2.0 * step) for lo, hi in ends]


def _overlaps(rows: NDArray[np.void], pen: Array) -> list[tuple[int, int]]:
    """Stretches (from, to) of overlapping rows, as far as the axis is of use on either side of the main point."""
    facing = rows["no"] * rows["no"][LOOK] + rows["nb"] * rows["nb"][LOOK]
    lost = (facing < TURN) | (pen < -DEEPEST_GAP)
    before, after = np.flatnonzero(lost[: LOOK + 1]), np.flatnonzero(lost[LOOK:])
    first = int(before[-1]) + 1 if before.size else 0
    last = LOOK + int(after[0]) - 1 if after.size else 2 * LOOK
    inside = np.zeros(len(pen) + 2, dtype=bool)
    inside[first + 1 : last + 2] = pen[first : last + 1] > 0.0
    edges = np.flatnonzero(inside[1:] != inside[:-1])
    return [(int(lo), int(hi) - 1) for lo, hi in zip(edges[::2], edges[1::2], strict=True)]


def _joined(found: list[tuple[int, int]], boxes: list[Box], apart: float) -> list[int]:
    """The zone of the main point and, to either side, its neighbours at less than ``apart`` from each other."""
    own = next(n for n, (lo, hi) in enumerate(found) if lo <= LOOK <= hi)
    first = last = own
    while last + 1 < len(boxes) and boxes[last].distance(boxes[last + 1]) < apart:
        last += 1
    while first > 0 and boxes[first].distance(boxes[first - 1]) < apart:
        first -= 1
    return list(range(first, last + 1))


def _box(rows: NDArray[np.void], pen: Array, lo: int, hi: int, step: float) -> Box:
    """Extent of the whole overlap of rows lo .. hi."""
    half = np.sqrt(2.0 * rows["r_t"][lo : hi + 1] * pen[lo : hi + 1])
    x = rows["x"][lo : hi + 1]
    return Box(
        _crossing(pen, lo, -1) * step, _crossing(pen, hi, 1) * step, float((x - half).min()), float((x + half).max())
    )


def _crossing(pen: Array, row: int, side: int) -> float:
    """Where overlap ends beyond its last row, in rows."""
    other = row + side
    if not 0 <= other < len(pen):
        return float(row)
    return row + side * float(pen[row] / (pen[row] - pen[other]))


def _fading(distance: float, settings: HalfSpaceSettings) -> float:
    """Share of the mutual influence of two zones that counts."""
    if distance <= settings.together:
        return 1.0
    return max((settings.apart - distance) / (settings.apart - settings.together), 0.0) ** FADING


def _zone(rows: NDArray[np.void], pen: Array, lo: int, hi: int, step: float) -> Zone:
    """Of rows lo .. hi: every lobe counts from its own level on."""
    rows, h = rows[lo : hi + 1], pen[lo : hi + 1]
    # lobes part at the local minima
    low = np.flatnonzero((h[1:-1] <= h[:-2]) & (h[1:-1] < h[2:])) + 1
    crest = np.concatenate([np.full(len(part), part.max()) for part in np.split(h, low)])

    def half_lengths(level: float) -> Array:
        half: Array = np.sqrt(2.0 * rows["r_t"] * np.maximum(h - level * crest, 0.0))
        return half

    half, likely = half_lengths(LEVEL), half_lengths(KERNEL_LEVEL)
    within = np.flatnonzero(half > 0.0)
    s, x = rows["s"], rows["x"]
    return Zone(
        Box(
            float(s[within[0]]) - step, float(s[within[-1]]) + step,
            float((x - half)[within].min()), float((x + half)[within].max()),
        ),
        float(np.count_nonzero(likely)) * step,
        2.0 * float(likely.max()),
    )  # fmt: skip
