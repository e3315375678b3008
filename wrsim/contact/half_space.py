"""Exact elastic contact of a wheel and a rail at one pose: half-space elements on the curved patch.

Slow and trusted: the fast models are measured against it. The undeformed gap is exact (surface of revolution against
swept rail, measured along the normals of the curved reference), the elastic bodies are half-spaces bent along the
curved axis (``influence = "half-space"``) or with their influence turned by the angle between the normals
(``"angle-corrected"``). Damping is no part of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, log2
from typing import Literal

import numpy as np
import scipy.ndimage
from numpy.typing import NDArray

from wrsim.contact.half_space_grid import Grid, Seed, count_elements, find_seeds, lay_grid
from wrsim.contact.half_space_operator import Compliance, HalfSpaceOperator
from wrsim.contact.half_space_solvers import Pressure, Traction, solve_normal, solve_rolling
from wrsim.contact.model import ContactModel, KernelArrays
from wrsim.core import halfspace_surface as surface
from wrsim.core import layout as k
from wrsim.core.halfspace_normal import summarise
from wrsim.core.halfspace_rolling import rigid_slip
from wrsim.core.wheel_rail import DEEPEST

Array = NDArray[np.float64]
Influence = Literal["half-space", "angle-corrected"]
Pairing = Literal["opposite", "level"]

AHEAD = 1.0 / 6.0  # of an element: where the rigid slip is taken, which cancels most of the error of first order
WIDENING = (0.0, 0.15, 0.5)  # of the grid, tried in turn when contact reaches its edge
MOST_ELEMENTS = 200_000
SHARP, HIGH = 0.05, 0.75  # peaks that ask for finer rows: their bend, their height, over the highest
MOST_HALVINGS = 3
TURNS = 30  # between pressures and tractions that move each other
FINE_S = 2e-4  # largest default element across [m]: jumps of a profile's curvature make narrow peaks

STATUS_TOO_MANY = 8  # elements
STATUS_GRID_EDGE = 16  # contact reaches the edge of the grid
STATUS_NOT_CONVERGED = 32


@dataclass(frozen=True)
class Region:
    """One connected region of contact.

    normal_force: sum of p dA [N]; area [m2]; p0 [Pa]; s, x: extents (from, to) [m]; angle: contact angle at the
    outer edges in s (from, to) [rad]; centre: (x, o, b) of the pressure's resultant [m].
    """

    normal_force: float
    area: float
    p0: float
    s: tuple[float, float]
    x: tuple[float, float]
    angle: tuple[float, float]
    centre: tuple[float, float, float]


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


@dataclass(frozen=True)
class HalfSpace:
    """The exact solver and its settings.

    element: size of the elements (along x, along s) [m]; None: so that the smallest patch that matters gets about
    ``resolution`` elements over its length and its width, across not larger than about 0.2 mm, and halved across until
    no peak of pressure is sharper than the rows can tell. influence: see above.
    tolerance: of the gap over the approach; tractions are solved to ten times that over the largest bound.
    together, apart: distances of two zones of overlap up to which they press each other down fully, and from which on
    not at all [m] (see contact.half_space_grid). pairing: which points of the profiles belong together,
    ``"opposite"`` ones or, as in CONTACT, those of equal arclength from two points of the same lateral place
    (``"level"``; see core.halfspace_surface).
    """

    element: tuple[float, float] | None = None
    resolution: int = 36
    influence: Influence = "half-space"
    tolerance: float = 1e-5
    together: float = 4e-3
    apart: float = 8e-3
    pairing: Pairing = "opposite"

    def solve_pose(self, model: ContactModel, before: HalfSpaceContact | None = None) -> HalfSpaceContact:
        """Contact at the pose set in the model's arrays (`ContactModel.evaluate` and `StaticBench` set it).

        The approach comes from the pose. before: solution of a pose near by on the same elements, to start from.
        """
        seeds, closest, status = self.seeds(model)
        patches = []
        for number, seed in enumerate(seeds):
            start = before.patches[number] if before is not None and number < len(before.patches) else None
            patch, state = self._solve_seed(model, seed, start)
            status |= state
            if patch is not None and patch.regions:
                patches.append(patch)
        patches.sort(key=lambda p: -p.normal_force)
        zero = np.zeros(3)
        return HalfSpaceContact(
            tuple(patches),
            sum((p.force for p in patches), zero),
            sum((p.moment for p in patches), zero),
            closest,
            status,
        )

    def seeds(self, model: ContactModel) -> tuple[list[Seed], float, int]:
        """Patches at the pose set in the model's arrays, deepest first; closest distance [m]; search status."""
        return find_seeds(model.arrays, self.together, self.apart, self.pairing == "level")

    def elements_at(self, model: ContactModel) -> tuple[float, float] | None:
        """Elements (dx, ds) of the deepest patch at the pose set in the model's arrays [m]; None without contact."""
        seeds, _, _ = self.seeds(model)
        pressed = self._press(model, seeds[0], None) if seeds else None
        return None if pressed is None else (pressed.grid.dx, pressed.grid.ds)

    def elements_for(self, seed: Seed) -> tuple[float, float]:
        """Element size (dx, ds) to begin with [m]. The shape of elements comes in steps, so that kernels are reused."""
        if self.element is not None:
            return self.element
        length, width = (max(extent, 1e-7) for extent in seed.narrowest)
        dx = length / self.resolution
        shape = 2.0 ** (floor(2.0 * log2(min(width / self.resolution, FINE_S) / dx) + 0.5) / 2.0)
        return dx, min(max(shape, 0.125), 4.0) * dx

    def _press(self, model: ContactModel, seed: Seed, start: HalfSpacePatch | None) -> _Pressed | None:
        """The normal problem on a grid that holds the contact and tells its peaks; None with too many elements."""
        dx, ds = self.elements_for(seed)
        pressed = None
        for _ in range(1 if self.element is not None else 1 + MOST_HALVINGS):
            finer = self._press_on(model, seed, dx, ds, start)
            if finer is None:
                break
            pressed = finer
            if not _has_sharp_peak(pressed.pressure.p):
                break
            ds *= 0.5
        return pressed

    def _press_on(
        self, model: ContactModel, seed: Seed, dx: float, ds: float, start: HalfSpacePatch | None
    ) -> _Pressed | None:
        compliance = Compliance.of(model.settings.wheel, model.settings.rail)
        pressed = None
        for widening in WIDENING:
            if count_elements(seed, dx, ds, widening) > MOST_ELEMENTS:
                break
            grid = lay_grid(model.arrays, seed, dx, ds, widening)
            angles = grid.angle if self.influence == "angle-corrected" else None
            rows, columns = grid.pen.shape
            operator = HalfSpaceOperator(rows, columns, ds, dx, compliance, angles, grid.shares)
            pressure = solve_normal(operator, grid.pen, self.tolerance, start.p if start is not None else None)
            p = pressure.p
            pressed = _Pressed(
                grid, operator, pressure, bool(p[0].any() or p[-1].any() or p[:, 0].any() or p[:, -1].any())
            )
            if not pressed.reaches_edge:
                break
        return pressed

    def _solve_seed(
        self, model: ContactModel, seed: Seed, start: HalfSpacePatch | None
    ) -> tuple[HalfSpacePatch | None, int]:
        pressed = self._press(model, seed, start)
        if pressed is None:
            return None, STATUS_TOO_MANY
        grid, pressure = pressed.grid, pressed.pressure
        rigid, forward = _rigid_slip(model, grid)
        traction, settled = None, True
        if model.settings.tangential != "none" and model.friction > 0.0:
            first = start.q if start is not None else None
            pressure, traction, settled = self._roll(model, pressed, rigid, forward, first)
        status = STATUS_GRID_EDGE if pressed.reaches_edge else 0
        status |= k.STATUS_TOO_DEEP if seed.depth > DEEPEST else 0
        status |= k.STATUS_PROFILE_END if _leaves_profiles(model.arrays, grid, pressure.p) else 0
        if not (settled and pressure.converged and (traction is None or traction.converged)):
            status |= STATUS_NOT_CONVERGED
        return _patch(model.arrays.pose, grid, pressure, traction, rigid), status

    def _roll(
        self, model: ContactModel, pressed: _Pressed, rigid: Array, forward: float, first: Array | None
    ) -> tuple[Pressure, Traction, bool]:
        """Tractions; in turns with the pressures where they move each other (Panagiotopoulos); whether that settled."""
        operator, pressure = pressed.operator, pressed.pressure

        def roll(p: Array, q: Array | None) -> Traction:
            w = rigid + operator.slip_of_pressure(p, forward) if operator.coupled else rigid
            return solve_rolling(operator, model.friction * p, w, forward, 10.0 * self.tolerance, q)

        traction = roll(pressure.p, first)
        for _ in range(TURNS):
            if not operator.coupled:
                return pressure, traction, True
            last = pressure.p
            pen = pressed.grid.pen - operator.normal_of_tractions(traction.q)
            pressure = solve_normal(operator, pen, self.tolerance, last)
            traction = roll(pressure.p, traction.q)
            if np.abs(pressure.p - last).max() <= 100.0 * self.tolerance * pressure.p.max():
                return pressure, traction, True
        return pressure, traction, False


@dataclass(frozen=True)
class _Pressed:
    """A grid with its operator and pressures; whether contact reaches the grid's edge."""

    grid: Grid
    operator: HalfSpaceOperator
    pressure: Pressure
    reaches_edge: bool


def _has_sharp_peak(p: Array) -> bool:
    """Whether a high peak over the rows bends by more than SHARP of itself from one row to the next."""
    crest = np.zeros(len(p) + 2)
    crest[1:-1] = p.max(axis=1)
    middle = crest[1:-1]
    high = (middle > HIGH * middle.max()) & (middle >= crest[:-2]) & (middle >= crest[2:])
    return bool((2.0 * middle - crest[:-2] - crest[2:])[high].max(initial=0.0) > SHARP * middle.max())


def _rigid_slip(model: ContactModel, grid: Grid) -> tuple[Array, float]:
    """Rigid slip of all elements (2, rows, columns), and the direction of rolling."""
    a = model.arrays
    w = np.empty((2, *grid.pen.shape))
    forward = rigid_slip(
        a.pose, a.settings[k.LEAST_SPEED], grid.axis, len(grid.axis), float(grid.x[0]), grid.dx, AHEAD, grid.place,
        w[0], w[1],
    )  # fmt: skip
    return w, forward


def _leaves_profiles(a: KernelArrays, grid: Grid, p: Array) -> bool:
    """Whether contact reaches rows beyond the end of a profile, which is continued straight there."""
    rows = p.any(axis=1)
    ends = (
        (surface.AT_WHEEL, (len(a.wheel) - 1) * a.settings[k.WHEEL_STEP]),
        (surface.AT_RAIL, (len(a.rail) - 1) * a.settings[k.RAIL_STEP]),
    )
    return any(bool(((grid.axis[rows, c] < 0.0) | (grid.axis[rows, c] > end)).any()) for c, end in ends)


def _patch(pose: Array, grid: Grid, pressure: Pressure, traction: Traction | None, rigid: Array) -> HalfSpacePatch:
    p = pressure.p
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


def _regions(grid: Grid, p: Array) -> tuple[Region, ...]:
    """Connected regions by falling normal force."""
    labels, _ = scipy.ndimage.label(p > 0.0)
    regions = []
    for number, box in enumerate(scipy.ndimage.find_objects(labels), start=1):
        own = np.where(labels[box] == number, p[box], 0.0)
        rows, columns = box
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
            )
        )  # fmt: skip
    return tuple(sorted(regions, key=lambda r: -r.normal_force))
