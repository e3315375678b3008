"""What the exact solver finds: pressures and tractions on a grid, their connected regions, forces.

Arrays over elements are (rows, columns): rows along the curved axis s, columns along the rail x.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.ndimage
from numpy.typing import NDArray

from wrsim.contact.half_space.solvers import Pressure, Traction
from wrsim.contact.half_space.surface import Grid
from wrsim.core.contact.half_space.normal import summarise

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Region:
    """One connected region of contact.

    normal_force: sum of p dA [N]; area [m2]; p0 [Pa]; s, x: extents (from, to) [m]; angle: contact angle at the
    outer edges in s (from, to) [rad]; centre: (x, o, b) of the pressure's resultant [m]; rows, columns: of the grid;
    p: the region's own pressures there (rows, columns) [Pa].
    """

    normal_force: float
    area: float
    p0: float
    s: tuple[float, float]
    x: tuple[float, float]
    angle: tuple[float, float]
    centre: tuple[float, float, float]
    rows: slice
    columns: slice
    p: Array


@dataclass(frozen=True)
class HalfSpacePatch:
    """All contact on one grid.

    p: pressures (rows, columns) over (s, x) [Pa]; q: tractions on the wheel along x and along the rows' tangents,
    outward (2, rows, columns) [Pa]; slip, rigid_slip: of the wheel over the rolling speed, alike, with and without
    the elastic part; state: 0 outside, 1 adhesion, 2 slip; approach: largest undeformed interpenetration along the
    normals [m]; force, moment: on the wheel (t, o, b), the moment about the wheel's profile origin [N, N m]; wear:
    work of the creep forces on the rigid slip over the rolling speed, T-gamma [N].
    """

    grid: Grid
    p: Array
    q: Array
    slip: Array
    rigid_slip: Array
    state: Array
    approach: float
    force: Array
    moment: Array
    wear: float
    regions: tuple[Region, ...]
    normal: Pressure
    rolling: Traction | None

    @property
    def normal_force(self) -> float:
        """Sum of p dA [N]."""
        return sum(r.normal_force for r in self.regions)

    @property
    def p0(self) -> float:
        """Largest pressure [Pa]."""
        return max((r.p0 for r in self.regions), default=0.0)

    @property
    def area(self) -> float:
        """Contact area [m2]."""
        return sum(r.area for r in self.regions)

    @property
    def counted_area(self) -> float:
        """Number of elements in contact times their size, as CONTACT states it: too large by about half an element
        around the edge [m2]."""
        return float(np.count_nonzero(self.p)) * self.grid.dx * self.grid.ds

    @property
    def creep_force(self) -> tuple[float, float]:
        """Sums of q dA along x and along the rows' tangents, on the wheel [N]."""
        cell = self.grid.dx * self.grid.ds
        return float(self.q[0].sum()) * cell, float(self.q[1].sum()) * cell


@dataclass(frozen=True)
class HalfSpaceContact:
    """Contact of one wheel on one rail: patches by falling normal force; totals on the wheel as in ContactModel."""

    patches: tuple[HalfSpacePatch, ...]
    force: Array
    moment: Array
    closest: float
    status: int

    @property
    def normal_force(self) -> float:
        """Sum over all patches [N]."""
        return sum(p.normal_force for p in self.patches)


def patch_of(
    pose: Array, grid: Grid, p: Array, pressure: Pressure, traction: Traction | None, rigid: Array
) -> HalfSpacePatch:
    """All contact on a grid. pose: see core.contact.layout; p: pressures with damping; rigid: slip of the wheel."""
    if traction is None:
        q, slip, state = np.zeros((2, *p.shape)), rigid, np.where(p > 0.0, 2.0, 0.0)
    else:
        q, slip, state = traction.q, traction.slip, traction.state
    cell = grid.dx * grid.ds
    no, nb = grid.normal.T[:, :, None]
    lines = np.stack([q[0], p * no + q[1] * nb, p * nb - q[1] * no]) * cell
    arms = np.stack(
        np.broadcast_arrays(
            grid.x[None, :] - pose[0], grid.centre[:, 0, None] - pose[1], grid.centre[:, 1, None] - pose[2]
        )
    )
    moment = np.cross(arms, lines, axis=0).sum(axis=(1, 2))
    wear = -float((q * rigid).sum()) * cell
    return HalfSpacePatch(
        grid, p, q, slip, rigid, state, float(grid.pen.max()), lines.sum(axis=(1, 2)), moment, wear, _regions(grid, p),
        pressure, traction,
    )  # fmt: skip


def _islands(p: Array) -> Iterator[tuple[slice, slice, Array]]:
    """Connected regions of a pressure field: their rows, their columns, and their own pressures in that box."""
    labels, _ = scipy.ndimage.label(p > 0.0)
    for number, (rows, columns) in enumerate(scipy.ndimage.find_objects(labels), start=1):
        yield rows, columns, np.where(labels[rows, columns] == number, p[rows, columns], 0.0)


def _regions(grid: Grid, p: Array) -> tuple[Region, ...]:
    """Connected regions by falling normal force."""
    regions = []
    for rows, columns, own in _islands(p):
        starts, ends, total = np.zeros(len(own)), np.zeros(len(own)), np.zeros(5)
        summarise(own, grid.dx, grid.ds, starts, ends, total)
        across = own.max(axis=1)[None, :]
        lo, hi, ignored = np.zeros(1), np.zeros(1), np.zeros(5)
        summarise(across, grid.ds, grid.dx, lo, hi, ignored)
        s = grid.s[rows.start] + grid.ds * (np.array([lo[0], hi[0]]) - 0.5)
        x = grid.x[columns.start] + grid.dx * (np.array([starts.min(), ends.max()]) - 0.5)
        weight = own / own.sum()
        centre = weight.sum(axis=1) @ grid.centre[rows]
        angle = np.interp(s, grid.s, grid.angle)
        regions.append(
            Region(
                float(total[2]), float(total[0]), float(total[1]), (float(s[0]), float(s[1])),
                (float(x[0]), float(x[1])), (float(angle[0]), float(angle[1])),
                (float(weight.sum(axis=0) @ grid.x[columns]), float(centre[0]), float(centre[1])),
                rows, columns, own,
            )
        )  # fmt: skip
    return tuple(sorted(regions, key=lambda r: -r.normal_force))
