"""What the exact solver finds: pressures and tractions on a grid, their connected regions, forces.

Arrays over elements are (rows, columns): rows along the curved axis s, columns along the rail x.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.ndimage
from numpy.typing import NDArray

from wrsim.contact.half_space.normal import Pressure
from wrsim.contact.half_space.rolling import Traction
from wrsim.contact.half_space.rolling_kernel import OUTSIDE, SLIP
from wrsim.contact.half_space.surface import Grid
from wrsim.contact.wheel_rail import turned
from wrsim.jit import Array
from wrsim.jit.linalg import Vec


@dataclass(frozen=True, eq=False)
class Region:
    """One connected region of contact.

    rows, columns: of the grid; p: the region's own pressures there (rows, columns) [Pa]; area [m2]; p0: largest
    pressure [Pa]; normal_force: sum of p dA [N]; length: of the longest row [m]; starts, ends: of every row along x
    (rows,), zero without contact; s: extent (from, to); angle: contact angle at the outer edges in s (from, to) [rad].
    """

    rows: slice
    columns: slice
    p: Array
    area: float
    p0: float
    normal_force: float
    length: float
    starts: Array
    ends: Array
    s: tuple[float, float]
    angle: tuple[float, float]


@dataclass(frozen=True)
class Patch:
    """All contact on one grid.

    p: pressures (rows, columns) over (s, x) [Pa]; q: tractions on the wheel along x and along the rows' tangents,
    outward (2, rows, columns) [Pa]; slip, rigid_slip: of the wheel over the rolling speed, alike, with and without
    the elastic part; state: 0 outside, 1 adhesion, 2 slip, 3 a layer that yields; force, moment: on the wheel
    (t, o, b), the moment about the wheel's profile origin [N, N m]; pressure, traction: as solved for, p without
    damping; temperature: of the surfaces [degC], where it is computed.
    """

    grid: Grid
    p: Array
    q: Array
    slip: Array
    rigid_slip: Array
    state: Array
    force: Array
    moment: Array
    pressure: Pressure
    traction: Traction | None
    temperature: Array | None

    @classmethod
    def of(
        cls, grid: Grid, p: Array, pressure: Pressure, traction: Traction | None, rigid: Array,
        temperature: Array | None = None,
    ) -> "Patch":  # fmt: skip
        """All contact on a grid. p: pressures with damping; rigid: slip of the wheel."""
        if traction is None:
            q, slip, state = np.zeros((2, *p.shape)), rigid, np.where(p > 0.0, SLIP, OUTSIDE)
        else:
            q, slip, state = traction.q, traction.slip, traction.state
        along, across, normal = grid.axes.transpose(0, 2, 1)[..., None]
        forces = (q[0] * along + q[1] * across + p * normal) * grid.cell
        # on the wheel's undeformed surface, where the slip is taken
        arms = grid.arms(grid.x, 0.5 * grid.axis["gap"][:, None])
        moment = np.cross(arms, forces, axis=0).sum(axis=(1, 2))
        force, moment = (np.array(turned(Vec(*v), -grid.bodies.sine)) for v in (forces.sum(axis=(1, 2)), moment))
        return cls(grid, p, q, slip, rigid, state, force, moment, pressure, traction, temperature)

    @cached_property
    def regions(self) -> tuple[Region, ...]:
        """Connected regions by falling normal force."""
        return tuple(sorted(_regions(self.grid, self.p), key=lambda r: -r.normal_force))

    @property
    def approach(self) -> float:
        """Largest undeformed interpenetration along the normals [m]."""
        return float(self.grid.pen.max())

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
    def wear(self) -> float:
        """Work of the creep forces on the rigid slip over the rolling speed, T-gamma [N]."""
        return -float((self.q * self.rigid_slip).sum()) * self.grid.cell


@dataclass(frozen=True)
class HalfSpaceContact:
    """Contact of one wheel on one rail: patches by falling normal force; totals on the wheel as in ContactModel."""

    patches: tuple[Patch, ...]
    closest: float
    status: int

    @property
    def force(self) -> Array:
        """On the wheel, (3,) in rail axes [N]."""
        return sum((p.force for p in self.patches), np.zeros(3))

    @property
    def moment(self) -> Array:
        """On the wheel about its profile origin, (3,) in rail axes [N m]."""
        return sum((p.moment for p in self.patches), np.zeros(3))

    @property
    def normal_force(self) -> float:
        """Sum over all patches [N]."""
        return sum(p.normal_force for p in self.patches)

    @property
    def wear(self) -> float:
        """T-gamma over all patches [N]."""
        return sum(p.wear for p in self.patches)

    def largest(self, most: int) -> list[tuple[Patch, Region]]:
        """The largest regions of all patches, each with its patch, by falling normal force."""
        pairs = [(patch, region) for patch in self.patches for region in patch.regions]
        pairs.sort(key=lambda pair: -pair[1].normal_force)
        return pairs[:most]


def stretches(p: Array) -> tuple[NDArray[np.intp], Array, Array]:
    """Row, start and end of every stretch of contact along a row, in elements from the first column's outer side. Near
    its edge a pressure rises with the root of the distance, so p^2 extrapolated linearly from the two outermost
    elements vanishes at the edge, within the two elements' width."""
    inside = np.pad(p > 0.0, ((0, 0), (1, 1)))
    row, first = np.nonzero(inside[:, 1:] & ~inside[:, :-1])
    last = np.nonzero(inside[:, :-1] & ~inside[:, 1:])[1] - 1

    def to_edge(outer: Array, inner: Array) -> Array:
        rise = inner**2 - outer**2
        return np.where(rise > 0.0, np.minimum(outer**2 / np.where(rise > 0.0, rise, 1.0), 1.0), 0.5)

    start = first + 0.5 - to_edge(p[row, first], p[row, np.minimum(first + 1, last)])
    return row, start, last + 0.5 + to_edge(p[row, last], p[row, np.maximum(last - 1, first)])


def _regions(grid: Grid, p: Array) -> Iterator[Region]:
    labels, _ = scipy.ndimage.label(p > 0.0)
    for number, (rows, columns) in enumerate(scipy.ndimage.find_objects(labels), start=1):
        pressures = np.where(labels[rows, columns] == number, p[rows, columns], 0.0)
        row, start, end = stretches(pressures)
        longest = np.argsort(end - start)  # of a row's stretches the longest is written last
        starts, ends = np.zeros((2, len(pressures)))
        starts[row[longest]], ends[row[longest]] = start[longest], end[longest]
        _, first, last = stretches(pressures.max(axis=1)[None, :])
        s_from, s_to = (float(grid.s[rows.start] + grid.ds * (edge[0] - 0.5)) for edge in (first, last))
        length = float((ends - starts).max()) * grid.length
        outer = float(grid.x[columns.start]) - 0.5 * grid.dx
        starts, ends = outer + grid.dx * starts, outer + grid.dx * ends
        angle_from, angle_to = np.interp([s_from, s_to], grid.s, grid.angle)
        yield Region(
            rows, columns, pressures, float((end - start).sum()) * grid.cell, float(pressures.max()),
            float(pressures.sum()) * grid.cell,
            length, starts, ends, (s_from, s_to), (float(angle_from), float(angle_to)),
        )  # fmt: skip
