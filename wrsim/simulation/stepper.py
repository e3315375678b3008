"""A vehicle that another program moves on step by step: test benches, control in the loop, co-simulation."""

from __future__ import annotations

import numpy as np

from wrsim.core.body import stepper as kernel
from wrsim.core.body import vehicle_forces
from wrsim.core.body.wheel_forces import OFF_TRACK
from wrsim.errors import SimulationError
from wrsim.simulation import law as laws
from wrsim.simulation.bodies import accelerations, inertia_table, mass_matrix
from wrsim.simulation.force_law import force_derivative
from wrsim.simulation.implicit_step import ALPHA_F, ALPHA_M, BETA, GAMMA, changes_of_step
from wrsim.simulation.integrate import OF_CONTACTS
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.system import Array


class Stepper:
    """Generalised alpha with a fixed step, a fixed number of iterations and one Jacobian, see ``core.body.stepper``.

    A step is one compiled call that allocates no memory and writes no file. It takes no smaller steps where the motion
    would need them: ``residual`` is what is left of the balance.

    Attributes
    ----------
    law : VehicleOnTrack
        Forces of contacts, elements and axles at the last evaluation, ahead of the last correction of the state.
    q, q_t : ndarray
        State after the last step, (6 per body, then inner unknowns), views [m, rad, m/s, rad/s].
    inputs : dict
        By name, views to write to between steps. ``"force NAME"``, (3,) [N]: a load of the scenario that does not vary;
        ``"moment WHEELSET"``, (1,) [N m]: an effort that does not vary, with ``left`` or ``right`` behind it where it
        acts on one wheel.
    """

    def __init__(self, law: VehicleOnTrack, q: Array, q_t: Array, step: float, iterations: int) -> None:
        """From the state (q, q_t) at the time 0, which the Jacobian belongs to; step [s]."""
        self.law, self._rows, self._block = law, np.zeros((kernel.ROWS, law.size)), np.zeros((6, 6))
        rows, self._inertia = self._rows, inertia_table(law.bodies)
        self._own = np.zeros(1, kernel.STEP)
        own = self._own[0]
        own.h, own.iterations = step, iterations
        own.alpha_m, own.alpha_f, own.beta, own.gamma = ALPHA_M, ALPHA_F, BETA, GAMMA
        own.q_of_q_tt, own.q_t_of_q_tt = by = changes_of_step(step)
        self.q, self.q_t = rows[kernel.Q], rows[kernel.Q_T]
        self.q[:], self.q_t[:], rows[kernel.AT] = q, q_t, q
        law.follow(True, OF_CONTACTS)
        law(0.0, q, q_t, rows[kernel.FORCES])
        count = len(law.bodies)
        q_tt = rows[kernel.FORCES].copy()
        q_tt[: 6 * count] = accelerations(law.bodies, q, q_t, rows[kernel.FORCES]).ravel()
        rows[[kernel.Q_TT, kernel.A]] = q_tt
        matrix = mass_matrix(law.bodies, q) - force_derivative(law, q, q_t, count, 0.0, *by)
        self._inverse: Array = np.linalg.inv(matrix).astype(np.float64, copy=False)
        self.inputs = _inputs(law)

    def step(self, count: int = 1) -> None:
        """Move on by so many steps. Raises SimulationError off the track, and where a number is not finite."""
        workspace = self.law.workspace
        for _ in range(count):
            status = kernel.advance(
                self._own, self._rows, self._inverse, self._inertia, self._block, workspace.buffer, workspace.index
            )
            if status == kernel.NOT_FINITE:
                raise SimulationError(f"a force is not a number at t = {self.time:.6g} s")
            if status & OFF_TRACK:
                raise SimulationError(laws.OFF_TRACK.format(self.time))

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return float(self._own["h"][0] * self._own["steps"][0])

    @property
    def residual(self) -> tuple[float, float]:
        """Norm of the forces without balance ahead of the last correction over the weight, in the last step and the
        most of all steps."""
        weight = self.law.vehicle.weight
        return float(self._own["residual"][0]) / weight, float(self._own["most"][0]) / weight


def _inputs(law: VehicleOnTrack) -> dict[str, Array]:
    """Views of the tables of loads and efforts of one row each."""
    views, vehicle = law.workspace.views, law.vehicle
    found: dict[str, Array] = {}
    for row, load in zip(views[vehicle_forces.LOADS], vehicle.loads, strict=False):  # payloads follow
        if row["rows"] == 1:
            found[f"force {load.name}"] = views[vehicle_forces.LOAD_TABLES][row["start"], 1:]
    for row, effort in zip(views[vehicle_forces.EFFORTS], vehicle.efforts, strict=True):
        if row["rows"] == 1:
            side = "" if effort.wheel == "both" else f" {effort.wheel}"
            found[f"moment {effort.wheelset}{side}"] = views[vehicle_forces.EFFORT_TABLES][row["start"], 1:]
    return found
