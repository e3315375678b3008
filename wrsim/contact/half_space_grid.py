"""Where wheel and rail may touch at a pose: grids over the curved patch for the half-space solver.

The undeformed bodies overlap in zones along the curved axis; contact lies within them, because pressure pushes the
surfaces apart everywhere. Zones not farther apart than ``reach`` share one axis and one grid, so that they press each
other down; zones farther apart get grids of their own and do not know of each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor, sqrt

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.model import KernelArrays
from wrsim.core import halfspace_surface as surface
from wrsim.core import layout as k
from wrsim.core.search import DEPTH, RAIL_ARC, RELATIVE_CURVATURE, WHEEL_ARC, find_contacts

Array = NDArray[np.float64]

LEVEL = 0.15  # of a lobe's depth: contact beyond it is rare, and found out
KERNEL_LEVEL = 0.45  # of a lobe's depth: about where contact ends
FINEST, COARSEST = 1e-6, 1e-4  # steps of the first look along the axis [m]
LOOK = 400  # steps of the first look to either side
TURN = 0.17  # cosine of the largest angle between the normals of one grid (80 degrees)
DEEPEST_GAP = 5e-3  # at which an axis is given up [m]


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
    """A main point and the zones that share its axis."""

    wheel_arc: float
    rail_arc: float
    depth: float
    level: bool
    places: tuple[Place, ...]

    @property
    def narrowest(self) -> tuple[float, float]:
        """Length and width of the likely contact of the smallest zone that matters (x, s) [m]."""
        areas = [p.length * p.width for p in self.places]
        matter = [p for p, area in zip(self.places, areas, strict=True) if area > 0.1 * max(areas)]
        return min(p.length for p in matter), min(p.width for p in matter)


@dataclass(frozen=True)
class Grid:
    """Elements dx x ds over a patch.

    axis: (rows, AXIS_COLUMNS) of core.halfspace_surface; x: (columns,) centres along the rail [m]; pen: (rows,
    columns) undeformed interpenetration along the rows' normals; place: from the reference to the wheel [m].
    """

    axis: Array
    x: Array
    dx: float
    ds: float
    pen: Array
    place: Array

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


def find_seeds(a: KernelArrays, reach: float, level: bool = False) -> tuple[list[Seed], float, int]:
    """Main points at the pose that is set, deepest first, with their zones; closest distance [m]; search status.

    reach: farthest zones on one grid [m]; level: pair the profiles' points as CONTACT does (core.halfspace_surface).
    """
    s, p = a.settings, a.pose
    count, closest, status = find_contacts(
        a.wheel, s[k.WHEEL_STEP], s[k.RADIUS], a.rail, s[k.RAIL_STEP], a.field, s[k.FIELD_O], s[k.FIELD_B],
        s[k.FIELD_SPACING], p[0], p[1], p[2], p[3], p[4], p[5], int(s[k.STRIDE]), s[k.HOLLOW], a.found,
    )  # fmt: skip
    seeds: list[Seed] = []
    taken = np.zeros(count, dtype=bool)
    for i in np.argsort(-a.found[:count, DEPTH]):
        if taken[i]:
            continue
        seed, reached = _look(a, a.found[i].copy(), reach, level)
        arcs = a.found[:count, WHEEL_ARC]
        for start, end in reached:
            taken |= (arcs >= start) & (arcs <= end)
        taken[i] = True
        seeds.append(seed)
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


def _look(a: KernelArrays, found: Array, reach: float, level: bool) -> tuple[Seed, list[tuple[float, float]]]:
    """Zones around one main point, and the stretches of the wheel's profile that they take."""
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
    zones = _runs(pen, first, last)
    radius = axis[:, surface.AT_RADIUS]
    boxes = []
    for lo, hi in zones:
        reach_x = np.sqrt(2.0 * radius[lo : hi + 1] * pen[lo : hi + 1])
        x = axis[lo : hi + 1, surface.AT_X]
        boxes.append((lo, hi, float((x - reach_x).min()), float((x + reach_x).max())))
    own = next(n for n, (lo, hi) in enumerate(zones) if lo <= LOOK <= hi)
    joined = [own]
    for order in (range(own + 1, len(zones)), range(own - 1, -1, -1)):
        near = own
        for n in order:
            if _distance(boxes[near], boxes[n], step) > reach:
                break
            joined.append(n)
            near = n
    places = tuple(_place(axis, pen, *zones[n], step) for n in sorted(joined))
    arcs = [(float(axis[zones[n][0], surface.AT_WHEEL]), float(axis[zones[n][1], surface.AT_WHEEL])) for n in joined]
    margin = 2.0 * step
    return (
        Seed(float(found[WHEEL_ARC]), float(found[RAIL_ARC]), depth, level, places),
        [(min(arc) - margin, max(arc) + margin) for arc in arcs],
    )


def _runs(pen: Array, first: int, last: int) -> list[tuple[int, int]]:
    """Stretches (from, to) of overlapping rows."""
    inside = np.zeros(last - first + 3, dtype=bool)
    inside[1:-1] = pen[first : last + 1] > 0.0
    edges = np.flatnonzero(inside[1:] != inside[:-1])
    return [(int(lo) + first, int(hi) + first - 1) for lo, hi in zip(edges[::2], edges[1::2], strict=True)]


def _distance(one: tuple[int, int, float, float], other: tuple[int, int, float, float], step: float) -> float:
    """Between the boxes of two zones [m]."""
    along_s = max(other[0] - one[1], one[0] - other[1], 0) * step
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


def lay_grid(a: KernelArrays, seed: Seed, dx: float, ds: float, margin: float = 0.0) -> Grid:
    """Elements over all zones of a seed; margin: share by which the grid is widened on every side."""
    start, end = min(p.start for p in seed.places), max(p.end for p in seed.places)
    x_start, x_end = min(p.x_start for p in seed.places), max(p.x_end for p in seed.places)
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
    return Grid(axis, x, dx, ds, pen, place)
