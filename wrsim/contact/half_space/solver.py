"""Exact elastic contact of a wheel and a rail at one pose: half-space elements on the curved patch.

Slow and trusted: the fast models are measured against it. The undeformed gap is exact (surface of revolution against
swept rail, measured along the normals of the curved reference), the elastic bodies are half-spaces bent along the
curved axis (``influence = "half-space"``) or with their influence turned by the angle between the normals
(``"angle-corrected"``). Damping multiplies the pressures of a row by max(0, 1 + c d(approach)/dt).
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import floor, log2

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.half_space.influence import Compliance, HalfSpaceOperator
from wrsim.contact.half_space.patch import HalfSpaceContact, HalfSpacePatch, patch_of
from wrsim.contact.half_space.solvers import Pressure, Traction, solve_normal, solve_rolling
from wrsim.contact.half_space.surface import Grid, Seed, count_elements, find_seeds, lay_grid
from wrsim.contact.model import MOST_STRIPS, ContactModel, KernelArrays
from wrsim.contact.settings import HalfSpaceSettings
from wrsim.core.contact import layout as k
from wrsim.core.contact.half_space import surface
from wrsim.core.contact.half_space.rolling import rigid_slip
from wrsim.core.contact.wheel_rail import DEEPEST

Array = NDArray[np.float64]

AHEAD = 1.0 / 6.0  # of an element: where the rigid slip is taken, which cancels most of the error of first order
WIDENING = (0.0, 0.15, 0.5)  # of the grid, tried in turn when contact reaches its edge
MOST_ELEMENTS = 200_000
MOST_ROWS = MOST_STRIPS
SHARP, HIGH = 0.05, 0.75  # peaks that ask for finer rows: their bend, their height, over the highest
MOST_HALVINGS = 3
TURNS = 30  # between pressures and tractions that move each other
FINE_S = 2e-4  # largest default element across [m]: jumps of a profile's curvature make narrow peaks

STATUS_TOO_MANY = 64  # elements
STATUS_GRID_EDGE = 128  # contact reaches the edge of the grid
STATUS_NOT_CONVERGED = 256
_WORDS = {
    STATUS_TOO_MANY: (
        f"contact needs more than {MOST_ELEMENTS} elements or {MOST_ROWS} rows of them: give larger ones "
        "(contact.half_space)"
    ),
    STATUS_GRID_EDGE: "contact reaches the edge of the grid of elements",
    STATUS_NOT_CONVERGED: "pressures or tractions have not converged",
    k.STATUS_TOO_DEEP: f"wheel and rail overlap by more than {1e3 * DEEPEST:g} mm",
    k.STATUS_PROFILE_END: "contact reaches the end of a profile, which is continued straight there",
}


def status_words(status: int) -> str:
    """What a status has to say, empty when all is well."""
    return "; ".join(words for bit, words in _WORDS.items() if status & bit)


@dataclass(frozen=True)
class HalfSpace(HalfSpaceSettings):
    """The exact solver and its settings.

    Settings: `wrsim.contact.settings.HalfSpaceSettings`.
    """

    @classmethod
    def of(cls, settings: HalfSpaceSettings) -> HalfSpace:
        """The solver with these settings."""
        return cls(**{f.name: getattr(settings, f.name) for f in fields(HalfSpaceSettings)})

    def solve_pose(self, model: ContactModel, before: HalfSpaceContact | None = None) -> HalfSpaceContact:
        """Contact at the pose set in the model's arrays (`ContactModel.evaluate` and `StaticBench` set it).

        The approach comes from the pose. before: solution of a pose near by on the same elements, to start from.
        Tractions are solved for when the model's settings say ``tangential = "half-space"``.
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
        # an overlap too deep to be a contact gets a first answer only
        once = self.element is not None or seed.depth > DEEPEST
        for _ in range(1 if once else 1 + MOST_HALVINGS):
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
            rows, columns = count_elements(seed, dx, ds, widening)
            if rows > MOST_ROWS or rows * columns > MOST_ELEMENTS:
                break
            grid = lay_grid(model.arrays, seed, dx, ds, widening)
            angles = grid.angle if self.influence == "angle-corrected" else None
            rows, columns = grid.pen.shape
            operator = HalfSpaceOperator(rows, columns, ds, dx, compliance, angles, grid.shares)
            pressure = solve_normal(operator, grid.pen, self.tolerance, start.normal.p if start is not None else None)
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
        damping = _damping(model, grid)
        traction, settled = None, True
        contact = seed.depth <= DEEPEST
        if (
            contact
            and model.settings.tangential == "half-space"
            and max(model.friction.static, model.friction.at_corner) > 0.0
        ):
            first = start.q if start is not None else None
            pressure, traction, settled = self._roll(model, pressed, rigid, forward, damping, first)
        status = STATUS_GRID_EDGE if pressed.reaches_edge else 0
        status |= k.STATUS_TOO_DEEP if seed.depth > DEEPEST else 0
        status |= k.STATUS_PROFILE_END if _leaves_profiles(model.arrays, grid, pressure.p) else 0
        if not (settled and pressure.converged and (traction is None or traction.converged)):
            status |= STATUS_NOT_CONVERGED
        return patch_of(model.arrays.pose, grid, damping * pressure.p, pressure, traction, rigid), status

    def _roll(
        self,
        model: ContactModel,
        pressed: _Pressed,
        rigid: Array,
        forward: float,
        damping: Array,
        first: Array | None,
    ) -> tuple[Pressure, Traction, bool]:
        """Tractions; in turns with the pressures where they move each other (Panagiotopoulos); whether that settled."""
        operator, pressure = pressed.operator, pressed.pressure
        speed = np.hypot(model.arrays.pose[6], model.arrays.settings[k.LEAST_SPEED])
        friction = model.friction.coefficient(pressed.grid.normal[:, None, :], speed * np.hypot(*rigid))

        def roll(p: Array, q: Array | None) -> Traction:
            w = rigid + operator.slip_of_pressure(p, forward) if operator.coupled else rigid
            return solve_rolling(operator, friction * damping * p, w, forward, 10.0 * self.tolerance, q)

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


def _damping(model: ContactModel, grid: Grid) -> Array:
    """Factor of the pressures of every row (rows, 1): 1 + c times the rate of approach there, never negative.

    The spin moves a surface of revolution in itself, so it brings nothing nearer.
    """
    pose = model.arrays.pose
    velocity, omega, axle = pose[6:9], pose[9:12], pose[3:6]
    turning = omega - (omega @ axle) * axle
    arm = np.column_stack([grid.axis[:, surface.AT_X], grid.centre]) - pose[:3]
    closing = -((velocity + np.cross(turning, arm))[:, 1:] * grid.normal).sum(axis=1)
    return np.maximum(1.0 + model.settings.damping * closing, 0.0)[:, None]


def _leaves_profiles(a: KernelArrays, grid: Grid, p: Array) -> bool:
    """Whether contact reaches rows beyond the end of a profile, which is continued straight there."""
    rows = p.any(axis=1)
    ends = (
        (surface.AT_WHEEL, (len(a.wheel) - 1) * a.settings[k.WHEEL_STEP]),
        (surface.AT_RAIL, (len(a.rail) - 1) * a.settings[k.RAIL_STEP]),
    )
    return any(bool(((grid.axis[rows, c] < 0.0) | (grid.axis[rows, c] > end)).any()) for c, end in ends)
