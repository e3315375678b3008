"""Elements fine enough for a patch, on a grid wide enough for it, with the pressures that show that they are."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, floor, log2

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.half_space.influence import Compliance, Operator
from wrsim.contact.half_space.normal import Pressure, solve_normal
from wrsim.contact.half_space.surface import Grid
from wrsim.contact.half_space.zones import Box, Footprint
from wrsim.contact.settings import HalfSpaceSettings
from wrsim.contact.status import MOST_ELEMENTS, MOST_ROWS
from wrsim.core.contact.wheel_rail import DEEPEST

Array = NDArray[np.float64]

WIDENING = (0.0, 0.15, 0.5)  # of the grid, tried in turn when contact reaches its edge
SHARP, HIGH = 0.05, 0.75  # peaks that ask for finer rows: their bend, their height, over the highest
MOST_HALVINGS = 3
FINE_S = 2e-4  # largest default element across [m]: jumps of a profile's curvature make narrow peaks


@dataclass(frozen=True)
class Pressed:
    """A grid with its operator and pressures."""

    grid: Grid
    operator: Operator
    pressure: Pressure

    @property
    def reaches_edge(self) -> bool:
        """Whether contact reaches the grid's edge."""
        p = self.pressure.p
        return bool(p[0].any() or p[-1].any() or p[:, 0].any() or p[:, -1].any())

    @property
    def has_sharp_peak(self) -> bool:
        """Whether a high peak over the rows bends by more than SHARP of itself from one row to the next."""
        crest = np.pad(self.pressure.p.max(axis=1), 1)
        before, middle, after = crest[:-2], crest[1:-1], crest[2:]
        high = (middle > HIGH * middle.max()) & (middle >= before) & (middle >= after)
        return bool((2.0 * middle - before - after)[high].max(initial=0.0) > SHARP * middle.max())


def press(
    footprint: Footprint, settings: HalfSpaceSettings, compliance: Compliance, start: Array | None
) -> Pressed | None:
    """The normal problem on a grid that holds the contact and resolves its peaks; None with too many elements.

    start: pressures to begin with, of use on the same elements.
    """
    dx, ds = settings.element or _first_elements(footprint, settings.resolution)
    # an overlap too deep to be a contact gets a first answer only
    once = settings.element is not None or footprint.depth > DEEPEST
    pressed = None
    for _ in range(1 if once else 1 + MOST_HALVINGS):
        finer = _press_on(footprint, dx, ds, settings, compliance, start)
        if finer is None:
            break
        pressed = finer
        if not pressed.has_sharp_peak:
            break
        ds *= 0.5
    return pressed


def _first_elements(footprint: Footprint, resolution: int) -> tuple[float, float]:
    """Element size (dx, ds) to begin with [m]. The shape of elements comes in steps, so that kernels are reused."""
    length, width = (max(extent, 1e-7) for extent in footprint.narrowest)
    dx = length / resolution
    shape = 2.0 ** (floor(2.0 * log2(min(width / resolution, FINE_S) / dx) + 0.5) / 2.0)
    return dx, min(max(shape, 0.125), 4.0) * dx


def _press_on(
    footprint: Footprint, dx: float, ds: float, settings: HalfSpaceSettings, compliance: Compliance, start: Array | None
) -> Pressed | None:
    pressed = None
    for widening in WIDENING:
        box = footprint.box.widened(widening)
        rows, columns = (box.end - box.start) / ds, (box.x_end - box.x_start) / dx
        if rows > MOST_ROWS or rows * columns > MOST_ELEMENTS:
            break
        grid = _lay_grid(footprint, box, dx, ds)
        angles = grid.angle if settings.influence == "angle-corrected" else None
        operator = Operator(len(grid.s), len(grid.x), ds, grid.length, compliance, angles, footprint.shares(grid.s))
        pressed = Pressed(grid, operator, solve_normal(operator, grid.pen, settings.tolerance, start))
        if not pressed.reaches_edge:
            break
    return pressed


def _lay_grid(footprint: Footprint, box: Box, dx: float, ds: float) -> Grid:
    """Elements over a box; a row and a column go through the main point."""
    first, last = floor(box.start / ds), ceil(box.end / ds)
    axis = footprint.axis.lay(ds, first, last)
    main = min(max(-first, 0), len(axis) - 1)
    x_main = float(axis["x"][main])
    left, right = floor((box.x_start - x_main) / dx), ceil((box.x_end - x_main) / dx)
    return Grid(footprint.axis.bodies, axis, x_main + dx * np.arange(left, right + 1, dtype=np.float64), dx, ds, main)
