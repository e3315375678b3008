"""Where wheel and rail may touch at a pose: grids over the curved patch for the half-space solver.

The undeformed bodies overlap in zones along the curved axis; contact lies within them, because pressure pushes the
surfaces apart everywhere. Zones nearer than ``together`` press each other down as one half-space does, zones farther
apart than ``apart`` do not know of each other, and in between the mutual influence fades like CONTACT's,
((apart - d)/(apart - together))^0.8, so that nothing jumps as the distance d of two zones changes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, floor, sqrt

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.model import KernelArrays
from wrsim.core.contact import layout as k
from wrsim.core.contact.half_space import surface
from wrsim.core.contact.search.points import DEPTH, RAIL_ARC, RELATIVE_CURVATURE, WHEEL_ARC, find_contacts

Array = NDArray[np.float64]

LEVEL = 0.15  # of a lobe's depth: contact beyond it is rare, and found out
KERNEL_LEVEL = 0.45  # of a lobe's depth: about where contact ends
FINEST, COARSEST = 1e-6, 1e-4  # steps of the first look along the axis [m]
LOOK = 400  # steps of the first look to either side
TURN = 0.17  # cosine of the largest angle between the normals of one grid (80 degrees)
DEEPEST_GAP = 5e-3  # at which an axis is given up [m]
FADING = 0.8  # exponent


@dataclass(frozen=True)
class Place:
    """A zone along the axis: edges at LEVEL and extents of the likely contact [m]."""

    start: float
    end: float
    x_start: float
    x_end: float
    width: float
    length: float


@dataclass(frozen=True)
class Seed:
    """A main point and the zones that share its axis, by increasing s; influence: of every zone on every other."""

    wheel_arc: float
    rail_arc: float
    depth: float
    level: bool
    places: tuple[Place, ...]
    influence: Array

    @property
    def narrowest(self) -> tuple[float, float]:
        """Length and width of the likely contact of the smallest zone that matters (x, s) [m]."""
        areas = [p.length * p.width for p in self.places]
        matter = [p for p, area in zip(self.places, areas, strict=True) if area > 0.1 * max(areas)]
        return min(p.length for p in matter), min(p.width for p in matter)


@dataclass(frozen=True)
class Grid:
    """Elements dx x ds over a patch.

    axis: (rows, AXIS_COLUMNS) of core.contact.half_space.surface; x: (columns,) centres along the rail [m]; pen: (rows,
    columns) undeformed interpenetration along the rows' normals; place: from the reference to the wheel [m];
    shares: for every group of zones that fades apart, its rows (rows, 1) and its influence on all rows (rows, 1);
    empty when all act as one.
    """

    axis: Array
    x: Array
    dx: float
    ds: float
    pen: Array
    place: Array
    shares: tuple[tuple[Array, Array], ...]

    @property
    def s(self) -> Array:
        """Curved axis at the rows' centres [m]."""
        return self.axis[:, surface.AT_S]

    @property
    def normal(self) -> Array:
        """Normals of the rows from rail to wheel (o, b), (rows, 2)."""
        return self.axis[:, [surface.AT_NO, surface.AT_NB]]

    @property
    def centre(self) -> Array:
        """Places of the rows in the rail's section (o, b), (rows, 2) [m]."""
        return self.axis[:, [surface.AT_O, surface.AT_B]]

    @property
    def angle(self) -> Array:
        """Contact angle of the rows [rad], positive where the plane climbs towards the flange."""
        return np.arctan2(-self.axis[:, surface.AT_NO], self.axis[:, surface.AT_NB])


def find_seeds(a: KernelArrays, together: float, apart: float, level: bool = False) -> tuple[list[Seed], float, int]:
    """Main points at the pose that is set, deepest first, with their zones; closest distance [m]; search status.

    together, apart: see above [m]; level: pair the profiles' points as CONTACT does (core.contact.half_space.surface).
    """
    s, p = a.settings, a.pose
    count, closest, status = find_contacts(
        a.wheel, s[k.WHEEL_STEP], s[k.RADIUS], a.rail, s[k.RAIL_STEP], a.field, s[k.FIELD_O], s[k.FIELD_B],
        s[k.FIELD_SPACING], p[0], p[1], p[2], p[3], p[4], p[5], int(s[k.STRIDE]), s[k.HOLLOW], a.found,
    )  # fmt: skip
    seeds: list[Seed] = []
    taken: list[tuple[float, float]] = []  # stretches of the wheel's profile

    def free(start: float, end: float) -> bool:
        return all(end < lo or start > hi for lo, hi in taken)

    for i in np.argsort(-a.found[:count, DEPTH]):
        found = a.found[i].copy()
        if free(found[WHEEL_ARC], found[WHEEL_ARC]):
            seed, reached = _look(a, found, together, apart, level, free)
            seeds.append(seed)
            taken += reached
    return seeds, float(closest), int(status)


def _axis(a: KernelArrays, wheel_arc: float, rail_arc: float, level: bool, step: float, first: int, last: int) -> Array:
    """Rows first .. last of an axis at multiples of ``step`` from a main point (row 0)."""
    s = a.settings
    axis = np.zeros((last - first + 1, surface.AXIS_COLUMNS))
    geometry = (a.wheel, s[k.WHEEL_STEP], s[k.RADIUS], a.rail, s[k.RAIL_STEP], a.pose, wheel_arc, rail_arc, level)
    inner = min(max(first, 0), last)
    if inner <= last and last >= 0:
        surface.lay_axis(*geometry, inner * step, step, last - inner + 1, axis[inner - first :])
    if first < 0:
        outer = min(last, -1)
        back = np.zeros((outer - first + 1, surface.AXIS_COLUMNS))
        surface.lay_axis(*geometry, outer * step, -step, outer - first + 1, back)
        axis[: outer - first + 1] = back[::-1]
    return axis


def _look(
    a: KernelArrays, found: Array, together: float, apart: float, level: bool, free: Callable[[float, float], bool]
) -> tuple[Seed, list[tuple[float, float]]]:
    """Zones around one main point, and the stretches of the wheel's profile that they take.

    free: whether a stretch still belongs to no other main point.
    """
    depth = float(found[DEPTH])
    half = sqrt(2.0 * depth / max(float(found[RELATIVE_CURVATURE]), 0.5))
    step = min(max(half / 12.0, FINEST), COARSEST)
    axis = _axis(a, found[WHEEL_ARC], found[RAIL_ARC], level, step, -LOOK, LOOK)
    pen = -axis[:, surface.AT_GAP]
    pen[LOOK] = max(pen[LOOK], depth)
    facing = axis[:, surface.AT_NO] * axis[LOOK, surface.AT_NO] + axis[:, surface.AT_NB] * axis[LOOK, surface.AT_NB]
    lost = (facing < TURN) | (pen < -DEEPEST_GAP)
    after, before = np.flatnonzero(lost[LOOK:]), np.flatnonzero(lost[: LOOK + 1])
    first = int(before[-1]) + 1 if before.size else 0
    last = LOOK + int(after[0]) - 1 if after.size else 2 * LOOK
    radius = axis[:, surface.AT_RADIUS]
    arc = axis[:, surface.AT_WHEEL]
    zones, boxes = [], []
    for lo, hi in _runs(pen, first, last):
        ends = min(arc[lo], arc[hi]), max(arc[lo], arc[hi])
        if not (lo <= LOOK <= hi or free(*ends)):
            continue
        half_x = np.sqrt(2.0 * radius[lo : hi + 1] * pen[lo : hi + 1])
        x = axis[lo : hi + 1, surface.AT_X]
        zones.append((lo, hi))
        boxes.append(
            (
                _crossing(pen, lo, -1) * step,
                _crossing(pen, hi, 1) * step,
                float((x - half_x).min()),
                float((x + half_x).max()),
            )
        )
    own = next(n for n, (lo, hi) in enumerate(zones) if lo <= LOOK <= hi)
    joined = [own]
    for order in (range(own + 1, len(zones)), range(own - 1, -1, -1)):
        near = own
        for n in order:
            if _distance(boxes[near], boxes[n]) >= apart:
                break
            joined.append(n)
            near = n
    joined.sort()
    influence = np.array([[_fading(_distance(boxes[i], boxes[j]), together, apart) for i in joined] for j in joined])
    places = tuple(_place(axis, pen, *zones[n], step) for n in joined)
    margin = 2.0 * step
    stretches = [(float(arc[zones[n][0]]), float(arc[zones[n][1]])) for n in joined]
    return (
        Seed(float(found[WHEEL_ARC]), float(found[RAIL_ARC]), depth, level, places, influence),
        [(min(ends) - margin, max(ends) + margin) for ends in stretches],
    )


def _crossing(pen: Array, row: int, side: int) -> float:
    """Where overlap ends beyond its last row, in rows."""
    other = row + side
    if not 0 <= other < len(pen):
        return float(row)
    return row + side * float(pen[row] / (pen[row] - pen[other]))


def _fading(distance: float, together: float, apart: float) -> float:
    """Share of the mutual influence of two zones that counts."""
    if distance <= together:
        return 1.0
    return max((apart - distance) / (apart - together), 0.0) ** FADING


def _runs(pen: Array, first: int, last: int) -> list[tuple[int, int]]:
    """Stretches (from, to) of overlapping rows."""
    inside = np.zeros(last - first + 3, dtype=bool)
    inside[1:-1] = pen[first : last + 1] > 0.0
    edges = np.flatnonzero(inside[1:] != inside[:-1])
    return [(int(lo) + first, int(hi) + first - 1) for lo, hi in zip(edges[::2], edges[1::2], strict=True)]


def _distance(one: tuple[float, float, float, float], other: tuple[float, float, float, float]) -> float:
    """Between two boxes (s from, s to, x from, x to) [m]."""
    along_s = max(other[0] - one[1], one[0] - other[1], 0.0)
    along_x = max(other[2] - one[3], one[2] - other[3], 0.0)
    return sqrt(along_s**2 + along_x**2)


def _place(axis: Array, pen: Array, lo: int, hi: int, step: float) -> Place:
    """Extent of one zone: every lobe counts from its own level on."""
    h = pen[lo : hi + 1]
    # lobes part at the local minima
    low = np.flatnonzero((h[1:-1] <= h[:-2]) & (h[1:-1] < h[2:])) + 1
    crest = np.concatenate([np.full(len(part), part.max()) for part in np.split(h, low)])
    rows = slice(lo, hi + 1)
    s, x = axis[rows, surface.AT_S], axis[rows, surface.AT_X]
    radius = axis[rows, surface.AT_RADIUS]
    half = np.sqrt(2.0 * radius * np.maximum(h - LEVEL * crest, 0.0))
    within = np.flatnonzero(half > 0.0)
    likely = np.sqrt(2.0 * radius * np.maximum(h - KERNEL_LEVEL * crest, 0.0))
    return Place(
        float(s[within[0]]) - step,
        float(s[within[-1]]) + step,
        float((x - half)[within].min()),
        float((x + half)[within].max()),
        float(np.count_nonzero(likely)) * step,
        2.0 * float(likely.max()),
    )


def _extent(seed: Seed) -> tuple[float, float, float, float]:
    """Of all zones: s from, s to, x from, x to [m]."""
    return (
        min(p.start for p in seed.places),
        max(p.end for p in seed.places),
        min(p.x_start for p in seed.places),
        max(p.x_end for p in seed.places),
    )


def count_elements(seed: Seed, dx: float, ds: float, margin: float = 0.0) -> tuple[float, float]:
    """About how many rows and columns `lay_grid` lays."""
    start, end, x_start, x_end = _extent(seed)
    return (1.0 + 2.0 * margin) * (end - start) / ds, (1.0 + 2.0 * margin) * (x_end - x_start) / dx


def lay_grid(a: KernelArrays, seed: Seed, dx: float, ds: float, margin: float = 0.0) -> Grid:
    """Elements over all zones of a seed; margin: share by which the grid is widened on every side."""
    start, end, x_start, x_end = _extent(seed)
    more_s, more_x = margin * (end - start), margin * (x_end - x_start)
    first, last = floor((start - more_s) / ds), ceil((end + more_s) / ds)
    axis = _axis(a, seed.wheel_arc, seed.rail_arc, seed.level, ds, first, last)
    x_main = float(axis[min(max(-first, 0), len(axis) - 1), surface.AT_X])
    left = floor((x_start - more_x - x_main) / dx)
    right = ceil((x_end + more_x - x_main) / dx)
    x: Array = x_main + dx * np.arange(left, right + 1, dtype=np.float64)
    pen, place = np.empty((len(axis), len(x))), np.empty((len(axis), len(x)))
    s = a.settings
    surface.fill_gap(
        a.wheel, s[k.WHEEL_STEP], s[k.RADIUS], a.rail, s[k.RAIL_STEP], a.pose, axis, len(axis), float(x[0]), dx, pen,
        place,
    )  # fmt: skip
    return Grid(axis, x, dx, ds, pen, place, _shares(seed, axis[:, surface.AT_S]))


def _shares(seed: Seed, s: Array) -> tuple[tuple[Array, Array], ...]:
    """Rows and influence of each group of zones; a row belongs to the zone it is nearest to."""
    if (seed.influence == 1.0).all():
        return ()
    borders = [0.5 * (p.end + q.start) for p, q in zip(seed.places[:-1], seed.places[1:], strict=True)]
    zone = np.searchsorted(borders, s)
    shares = []
    for n in range(len(seed.places)):
        shares.append(((zone == n).astype(np.float64)[:, None], seed.influence[zone, n][:, None].copy()))
    return tuple(shares)
