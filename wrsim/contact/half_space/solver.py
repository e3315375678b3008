"""Exact elastic contact of a wheel and a rail at one pose: half-space elements on the curved patch.

Slow and trusted: the fast models are measured against it. The undeformed gap is exact (surface of revolution against
swept rail, measured along the normals of the curved reference), the elastic bodies are half-spaces bent along the
curved axis (``influence = "half-space"``) or with their influence turned by the angle between the normals
(``"angle-corrected"``). Damping multiplies the pressures of a row by max(0, 1 + c d(approach)/dt).
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from wrsim.contact import status as status_of
from wrsim.contact.half_space.elements import Pressed, press
from wrsim.contact.half_space.influence import Compliance
from wrsim.contact.half_space.normal import Pressure, solve_normal
from wrsim.contact.half_space.patch import HalfSpaceContact, Patch
from wrsim.contact.half_space.rolling import Traction, solve_rolling
from wrsim.contact.half_space.surface import Grid
from wrsim.contact.half_space.zones import Footprint, find_footprints
from wrsim.contact.model import LEAST_SPEED, ContactModel
from wrsim.contact.settings import HalfSpaceSettings
from wrsim.core.contact.records import STATUS_PROFILE_END, STATUS_TOO_DEEP
from wrsim.core.contact.wheel_rail import DEEPEST

Array = NDArray[np.float64]

AHEAD = 1.0 / 6.0  # of an element: where the rigid slip is taken, which cancels most of the error of first order
TURNS = 30  # between pressures and tractions that move each other


@dataclass(frozen=True)
class HalfSpace(HalfSpaceSettings):
    """The exact solver and its settings, see `wrsim.contact.settings.HalfSpaceSettings`."""

    @classmethod
    def of(cls, settings: HalfSpaceSettings) -> HalfSpace:
        """The solver with these settings."""
        return cls(**{f.name: getattr(settings, f.name) for f in fields(HalfSpaceSettings)})

    def solve_pose(self, model: ContactModel, before: HalfSpaceContact | None = None) -> HalfSpaceContact:
        """Contact at the pose set in the model's arrays (`ContactModel.evaluate` and pose solvers set it).

        The approach comes from the pose. before: solution of a pose near by on the same elements, to start from.
        Tractions are solved for when the model's settings say ``creep_forces == "half-space"``.
        """
        footprints, closest, status = find_footprints(model, self)
        patches = []
        for number, footprint in enumerate(footprints):
            start = before.patches[number] if before is not None and number < len(before.patches) else None
            patch, said = self._solve(model, footprint, start)
            status |= said
            if patch is not None and patch.regions:
                patches.append(patch)
        patches.sort(key=lambda p: -p.normal_force)
        return HalfSpaceContact(tuple(patches), closest, status)

    def elements_at(self, model: ContactModel) -> tuple[float, float] | None:
        """Elements (dx, ds) of the deepest patch at the pose set in the model's arrays [m]; None without contact."""
        footprints, _, _ = find_footprints(model, self)
        pressed = press(footprints[0], self, _compliance(model), None) if footprints else None
        return None if pressed is None else (pressed.grid.dx, pressed.grid.ds)

    def _solve(self, model: ContactModel, footprint: Footprint, start: Patch | None) -> tuple[Patch | None, int]:
        """The patch over one footprint, and what there is to say about it."""
        pressed = press(footprint, self, _compliance(model), start.pressure.p if start is not None else None)
        if pressed is None:
            return None, status_of.TOO_MANY
        grid, pressure = pressed.grid, pressed.pressure
        forward = 1.0 if grid.bodies.pose.velocity.x >= 0.0 else -1.0
        rigid = grid.rigid_slip(LEAST_SPEED, forward * AHEAD * grid.dx)
        damping = _damping(grid, model.settings.damping)
        traction, settled = None, True
        contact = footprint.depth <= DEEPEST
        law = model.friction_here
        rough = max(law.static, law.at_corner) > 0.0
        if contact and rough and model.settings.creep_forces == "half-space":
            speed = np.hypot(grid.bodies.pose.velocity.x, LEAST_SPEED)
            friction = damping * law.coefficient(grid.normal[:, None, :], speed * np.hypot(*rigid))
            first = start.q if start is not None else None
            pressure, traction, settled = self._roll(pressed, friction, rigid, forward, first)
        said = {
            status_of.GRID_EDGE: pressed.reaches_edge,
            STATUS_TOO_DEEP: not contact,
            STATUS_PROFILE_END: _leaves_profiles(grid, pressure.p),
            status_of.NOT_CONVERGED: not (settled and pressure.converged and (traction is None or traction.converged)),
        }
        patch = Patch.of(grid, damping * pressure.p, pressure, traction, rigid)
        return patch, sum(bit for bit, true in said.items() if true)

    def _roll(
        self, pressed: Pressed, friction: Array, rigid: Array, forward: float, first: Array | None
    ) -> tuple[Pressure, Traction, bool]:
        """Tractions; in turns with the pressures where they move each other (Panagiotopoulos); whether that settled.

        friction: bound of the tractions over the pressure (rows, columns); first: tractions to begin with.
        """
        operator, pressure = pressed.operator, pressed.pressure

        def roll(p: Array, q: Array | None) -> Traction:
            slip = rigid + operator.slip_of_pressure(p, forward) if operator.coupled else rigid
            return solve_rolling(operator, friction * p, slip, forward, 10.0 * self.tolerance, q)

        traction = roll(pressure.p, first)
        if not operator.coupled:
            return pressure, traction, True
        for _ in range(TURNS):
            last = pressure.p
            lifted = pressed.grid.pen - operator.normal_of_tractions(traction.q)
            pressure = solve_normal(operator, lifted, self.tolerance, last)
            traction = roll(pressure.p, traction.q)
            if np.abs(pressure.p - last).max() <= 100.0 * self.tolerance * pressure.p.max():
                return pressure, traction, True
        return pressure, traction, False


def _compliance(model: ContactModel) -> Compliance:
    return Compliance.of(model.settings.wheel, model.settings.rail)


def _damping(grid: Grid, damping: float) -> Array:
    """Factor of the pressures of every row (rows, 1): 1 + c times the rate of approach there, never negative.

    The spin moves a surface of revolution in itself, so it brings nothing nearer.
    """
    origin, axle, velocity, omega = (np.array(vector) for vector in grid.bodies.pose)
    turning = omega - (omega @ axle) * axle
    arm = np.column_stack([grid.axis["x"], grid.centre]) - origin
    closing = -((velocity + np.cross(turning, arm)) * grid.axes[2]).sum(axis=1)
    return np.maximum(1.0 + damping * closing, 0.0)[:, None]


def _leaves_profiles(grid: Grid, p: Array) -> bool:
    """Whether contact reaches rows beyond the end of a profile, which is continued straight there."""
    return not grid.bodies.holds(grid.axis[p.any(axis=1)]).all()
