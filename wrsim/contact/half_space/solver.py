"""Exact elastic contact of a wheel and a rail at one pose: half-space elements on the curved patch.

Slow and trusted: the fast models are measured against it. The undeformed gap is exact: surface of revolution against
swept rail, measured along the normals of the curved reference. The model: docs/theory/half_space.md.
"""

from dataclasses import dataclass
from math import ceil, floor, log2

import numpy as np

from wrsim.contact import status as status_of
from wrsim.contact.half_space.influence import Compliance, Operator
from wrsim.contact.half_space.normal import Pressure, solve_normal
from wrsim.contact.half_space.patch import HalfSpaceContact, Patch
from wrsim.contact.half_space.rolling import Traction, solve_rolling
from wrsim.contact.half_space.rolling_kernel import heat_rows
from wrsim.contact.half_space.surface import Grid
from wrsim.contact.half_space.zones import Footprint, find_footprints
from wrsim.contact.model import LEAST_SPEED, ContactModel
from wrsim.contact.records import STATUS_PROFILE_END, STATUS_TOO_DEEP
from wrsim.contact.settings import HalfSpaceSettings, Layer
from wrsim.contact.wheel_rail import DEEPEST
from wrsim.jit import Array

AHEAD = 1.0 / 6.0  # of an element: where the rigid slip is taken, which cancels most of the error of first order
ALTERNATIONS = 30  # between pressures and tractions that move each other
WIDENING = (0.0, 0.15, 0.5)  # of the grid, tried in turn when contact reaches its edge
SHARP, HIGH = 0.05, 0.75  # peaks that ask for finer rows: their bend, their height, over the highest
MOST_HALVINGS = 3
FINE_S = 2e-4  # largest default element across [m]: jumps of a profile's curvature make narrow peaks


@dataclass(frozen=True)
class HalfSpace(HalfSpaceSettings):
    """The exact solver and its settings, see `wrsim.contact.settings.HalfSpaceSettings`."""

    @classmethod
    def of(cls, settings: HalfSpaceSettings) -> "HalfSpace":
        return cls(**vars(settings))

    def solve_pose(self, model: ContactModel, before: HalfSpaceContact | None = None) -> HalfSpaceContact:
        """Contact at the pose set in the model's arrays (`ContactModel.evaluate` and pose solvers set it). The approach
        comes from the pose. before: solution of a pose near by on the same elements, to start from. Tractions are
        solved for when the model's settings have ``creep_forces == "half-space"``."""
        footprints, closest, status = find_footprints(model, self)
        patches = []
        for number, footprint in enumerate(footprints):
            start = before.patches[number] if before is not None and number < len(before.patches) else None
            patch, patch_status = self._solve(model, footprint, start)
            status |= patch_status
            if patch is not None and patch.regions:
                patches.append(patch)
        patches.sort(key=lambda p: -p.normal_force)
        return HalfSpaceContact(tuple(patches), closest, status)

    def elements_at(self, model: ContactModel) -> tuple[float, float] | None:
        """Elements (dx, ds) of the deepest patch at the pose set in the model's arrays [m]; None without contact."""
        footprints, _, _ = find_footprints(model, self)
        normal = _press(footprints[0], self, _compliance(model), None) if footprints else None
        return None if normal is None else (normal.grid.dx, normal.grid.ds)

    def _solve(self, model: ContactModel, footprint: Footprint, start: Patch | None) -> tuple[Patch | None, int]:
        """The patch over one footprint, and its status."""
        normal = _press(footprint, self, _compliance(model), start.pressure.p if start is not None else None)
        if normal is None:
            return None, status_of.TOO_MANY
        grid, pressure = normal.grid, normal.pressure
        forward = 1.0 if grid.bodies.pose.velocity.x >= 0.0 else -1.0
        rigid = grid.rigid_slip(LEAST_SPEED, forward * AHEAD * grid.dx)
        damping = _damping(grid, model.settings.damping, pressure.p)
        traction, temperature, converged = None, None, True
        contact = footprint.depth <= DEEPEST
        law = model.friction_here
        rough = max(law.static, law.at_corner) > 0.0
        if contact and rough and model.settings.creep_forces == "half-space":
            speed = np.hypot(grid.bodies.pose.velocity.x, LEAST_SPEED)
            cold = law.coefficient(grid.normal[:, None, :], speed * np.hypot(*rigid))
            first = start.q if start is not None else None
            layer, friction, heat = model.settings.layer or Layer(), cold, np.empty(cold.shape[1])
            for _ in range(ALTERNATIONS):
                pressure, traction, converged = self._roll(normal, damping * friction, rigid, forward, first, layer)
                if model.settings.temperature is None:
                    break
                last, first = friction, traction.q
                friction, temperature = np.empty((2, *cold.shape))
                of = damping * pressure.p, traction.q, traction.slip, traction.state
                heat_rows(model.arrays.model, speed, grid.dx, forward, cold, *of, heat, friction, temperature)
                if np.abs(friction - last).max() <= 10.0 * self.tolerance * friction.max():
                    break
            else:
                converged = False
        bits = {
            status_of.GRID_EDGE: normal.reaches_edge,
            STATUS_TOO_DEEP: not contact,
            # rows beyond the end of a profile, which is continued straight there
            STATUS_PROFILE_END: not grid.bodies.holds(grid.axis[pressure.p.any(axis=1)]).all(),
            status_of.NOT_CONVERGED: not (converged and pressure.converged),
        }
        patch = Patch.of(grid, damping * pressure.p, pressure, traction, rigid, temperature)
        return patch, sum(bit for bit, is_set in bits.items() if is_set)

    def _roll(
        self, normal: "NormalSolution", friction: Array, rigid: Array, forward: float, first: Array | None, layer: Layer
    ) -> tuple[Pressure, Traction, bool]:
        """Pressures, tractions, whether they converged: alternating where they move each other (Panagiotopoulos).
        friction: bound of the tractions over the pressure (rows, columns); first: tractions to begin with."""
        operator, pressure = normal.operator, normal.pressure

        def roll(p: Array, q: Array | None) -> Traction:
            slip = rigid + operator.slip_of_pressure(p, forward) if operator.coupled else rigid
            yields = layer.yield_stress, layer.hardening
            return solve_rolling(operator, friction * p, slip, forward, 10.0 * self.tolerance, q, *yields)

        traction = roll(pressure.p, first)
        if not operator.coupled:
            return pressure, traction, traction.converged
        for _ in range(ALTERNATIONS):
            last = pressure.p
            lifted = normal.grid.pen - operator.normal_of_tractions(traction.q)
            pressure = solve_normal(operator, lifted, self.tolerance, last)
            traction = roll(pressure.p, traction.q)
            if np.abs(pressure.p - last).max() <= 100.0 * self.tolerance * pressure.p.max():
                return pressure, traction, traction.converged
        return pressure, traction, False


def _compliance(model: ContactModel) -> Compliance:
    layer = model.settings.layer
    return Compliance.of(model.settings.wheel, model.settings.rail, layer.flexibility if layer else 0.0)


def _damping(grid: Grid, damping: float, p: Array) -> Array:
    """Factor of the pressures p of every row (rows, 1): 1 + c times the rate of approach there, never negative. The
    spin moves a surface of revolution in itself, so it brings nothing nearer, unless the wheel is out of round: then
    it counts where the row's pressures have their centre, for both edges of a flat may carry."""
    origin, axle, velocity, omega = (np.array(vector) for vector in grid.bodies.pose)
    turning, x = omega, grid.axis["x"]
    if not len(grid.bodies.wheel.shape.depth):
        turning = omega - (omega @ axle) * axle
    else:
        weight = p.sum(axis=1)
        x = np.where(weight > 0.0, p @ grid.x / np.where(weight > 0.0, weight, 1.0), x)
    arm = np.column_stack([x, grid.centre]) - origin
    motion = velocity + np.cross(turning, arm)
    if grid.bodies.rail.roller > 0.0:
        motion -= grid.bodies.roller_velocity(arm.T).T
    closing = -(motion * grid.axes[2]).sum(axis=1)
    return np.maximum(1.0 + damping * closing, 0.0)[:, None]


@dataclass(frozen=True)
class NormalSolution:
    """A grid with its operator and pressures."""

    grid: Grid
    operator: Operator
    pressure: Pressure

    @property
    def reaches_edge(self) -> bool:
        p = self.pressure.p
        return bool(p[0].any() or p[-1].any() or p[:, 0].any() or p[:, -1].any())

    @property
    def has_sharp_peak(self) -> bool:
        """Whether a high peak over the rows bends by more than SHARP of itself from one row to the next."""
        crest = np.pad(self.pressure.p.max(axis=1), 1)
        before, middle, after = crest[:-2], crest[1:-1], crest[2:]
        high = (middle > HIGH * middle.max()) & (middle >= before) & (middle >= after)
        return bool((2.0 * middle - before - after)[high].max(initial=0.0) > SHARP * middle.max())


def _press(
    footprint: Footprint, settings: HalfSpaceSettings, compliance: Compliance, start: Array | None
) -> NormalSolution | None:
    """The normal problem on a grid that holds the contact and resolves its peaks; None with too many elements. start:
    pressures to begin with, of use on the same elements."""
    if settings.element is None:
        # the shape of elements comes in steps, so that kernels are used again
        length, width = (max(extent, 1e-7) / settings.resolution for extent in footprint.narrowest)
        shape = 2.0 ** (floor(2.0 * log2(min(width, FINE_S) / length) + 0.5) / 2.0)
        dx, ds = length, min(max(shape, 0.125), 4.0) * length
    else:
        dx, ds = settings.element
    # an overlap too deep to be a contact gets a first answer only
    once = settings.element is not None or footprint.depth > DEEPEST
    normal = None
    for _ in range(1 if once else 1 + MOST_HALVINGS):
        finer = _press_on(footprint, dx, ds, settings, compliance, start)
        if finer is None:
            break
        normal = finer
        if not normal.has_sharp_peak:
            break
        ds *= 0.5
    return normal


def _press_on(
    footprint: Footprint, dx: float, ds: float, settings: HalfSpaceSettings, compliance: Compliance, known: Array | None
) -> NormalSolution | None:
    normal = None
    for widening in WIDENING:
        start, end, x_start, x_end = footprint.extent(widening)
        rows, columns = (end - start) / ds, (x_end - x_start) / dx
        if rows > status_of.MOST_ROWS or rows * columns > status_of.MOST_ELEMENTS:
            break
        # a row and a column go through the main point
        first, last = floor(start / ds), ceil(end / ds)
        axis = footprint.axis.lay(ds, first, last)
        main = min(max(-first, 0), len(axis) - 1)
        x_main = float(axis["x"][main])
        x = x_main + dx * np.arange(floor((x_start - x_main) / dx), ceil((x_end - x_main) / dx) + 1, dtype=np.float64)
        grid = Grid(footprint.axis.bodies, axis, x, dx, ds, main)
        angles = grid.angle if settings.influence == "angle-corrected" else None
        operator = Operator(len(grid.s), len(grid.x), ds, grid.length, compliance, angles, footprint.shares(grid.s))
        normal = NormalSolution(grid, operator, solve_normal(operator, grid.pen, settings.tolerance, known))
        if not normal.reaches_edge:
            break
    return normal
