"""A vehicle that another program moves on step by step: test benches, control in the loop, co-simulation."""

import ctypes
import gc
import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from wrsim.errors import InputError, SimulationError, suggest
from wrsim.inputs.section import SIDES
from wrsim.simulation import law as laws
from wrsim.simulation.bodies import accelerations, mass_matrix
from wrsim.simulation.force_law import force_derivative
from wrsim.simulation.implicit_step import METHOD
from wrsim.simulation.integrate import CONTACT_TOLERANCE
from wrsim.simulation.law import VehicleOnTrack
from wrsim.simulation.system import Array
from wrsim.vehicle.dynamics import outputs, vehicle_forces
from wrsim.vehicle.dynamics import stepper as kernel
from wrsim.vehicle.dynamics.wheel_forces import OFF_TRACK
from wrsim.vehicle.elements import Strut
from wrsim.vehicle.loads import Effort, Turned
from wrsim.vehicle.vehicle import Vehicle

UNITS = {
    "distance": "m", "speed": "m_s", "lateral": "m", "height": "m", "yaw": "rad", "roll": "rad", "yaw_rate": "rad_s",
    "rotation": "rad_s", "acceleration_x": "m_s2", "acceleration_y": "m_s2", "acceleration_z": "m_s2",
}  # fmt: skip
"""Units of what is read of a body, as names of outputs end."""
MEMORY_NOW, MEMORY_LATER = 1, 2  # flags of mlockall, alike on all systems that have it


class Coarse(NamedTuple):
    """Contacts of strips that the budget was too small for: half as many strips, or a larger residual."""

    steps: int  # in which there was any
    contacts: int  # of all evaluations of all wheels
    unsolved: int  # of these: forces of Kik and Piotrowski's model
    most: float  # that the strips took in a step, in residuals of one grid


class Stepper:
    """Generalised alpha with a fixed step, a fixed number of iterations and one Jacobian, see ``dynamics.stepper``.

    A step is one compiled call that allocates no memory and writes no file. It takes no smaller steps where the motion
    would need them: ``residual`` is what is left of the balance.

    Attributes
    ----------
    law : VehicleOnTrack
        Forces of contacts, elements and axles at the last evaluation, ahead of the last correction of the state.
    q, q_t : ndarray
        State after the last step, (6 per body, then inner unknowns), views [m, rad, m/s, rad/s].
    inputs : dict
        By name, views (1,) to write to between steps: ``"front.outer.torque_Nm"`` of every wheelset, of one with
        independent wheels ``torque_left_Nm`` and ``torque_right_Nm``; ``control_N`` of every strut (dampers, rods,
        stops), tension of one along a line, else on its second body along its axis; ``force_x_N``, ``force_y_N``,
        ``force_z_N`` of the loads of the scenario that do not vary. A blank in a name is written as ``_``.
    outputs : dict
        By name, views (1,) that every call of `step` fills: motions of every body (``"carbody.lateral_m"``), forces of
        every wheelset (``"front.outer.Y_left_N"``), of every strut; docs/user/cosimulation.md lists them.
    """

    def __init__(
        self, law: VehicleOnTrack, q: Array, q_t: Array, step: float, iterations: int, budget: float = np.inf
    ) -> None:
        """From the state (q, q_t) at the time 0, which the Jacobian belongs to; step [s]; budget: see `stepper`."""
        self.law, self.memory = law, law.whole
        views = law.whole.views
        self._record, rows = views[kernel.STEP_RECORD][0], views[kernel.STATE]
        record = self._record
        record.h, record.iterations = step, iterations
        record.budget = budget * iterations * len(self.law.wheels) * len(SIDES)
        record.alpha_m, record.alpha_f, record.beta, record.gamma = METHOD
        record.q_of_q_tt, record.q_t_of_q_tt = by = METHOD.increments(step)
        self.q, self.q_t = rows[kernel.Q], rows[kernel.Q_T]
        self.q[:], self.q_t[:], rows[kernel.INVERTED_AT] = q, q_t, q
        law.follow(True, CONTACT_TOLERANCE)
        law(0.0, q, q_t, rows[kernel.FORCES])
        count = len(law.bodies)
        q_tt = rows[kernel.FORCES].copy()
        q_tt[: 6 * count] = accelerations(law.bodies, q[None], q_t[None], rows[kernel.FORCES][None]).ravel()
        rows[[kernel.Q_TT, kernel.A]] = q_tt
        matrix = mass_matrix(law.bodies, q) - force_derivative(law, q, q_t, count, 0.0, *by)
        views[kernel.INVERSE][:] = np.linalg.inv(matrix)
        views[kernel.SEEN]["distance"] = [law.start + part.centre[0] for part in law.vehicle.parts]
        self.inputs, self.outputs = _inputs(law), _outputs(law)
        self.tried: Coarse | None = None
        """What was coarse when the step was tried over a run."""
        self._observe()

    def step(self, count: int = 1) -> None:
        """Move on by so many steps. Raises SimulationError off the track, and where a number is not finite."""
        for _ in range(count):
            status = kernel.advance(self.memory.buffer, self.memory.index)
            if status == kernel.NOT_FINITE:
                raise SimulationError(f"a force is not a number at t = {self.time:.6g} s")
            if status & OFF_TRACK:
                raise SimulationError(laws.OFF_TRACK.format(self.time))
        self._observe()

    @contextmanager
    def deadline(self) -> Iterator[str]:
        """Keep the process in memory and Python's garbage collector off while steps have a deadline: no page fault, no
        collection. Gives "" or, where memory cannot be locked, why; Linux limits it (``ulimit -l``), Windows has no
        such call."""
        collects = gc.isenabled()
        gc.collect()
        gc.disable()
        library = ctypes.CDLL(None, use_errno=True) if sys.platform != "win32" else None
        problem = "this system has no mlockall"
        if library is not None and hasattr(library, "mlockall"):
            problem = "" if library.mlockall(MEMORY_NOW | MEMORY_LATER) == 0 else os.strerror(ctypes.get_errno())
        try:
            yield problem
        finally:
            if library is not None and not problem:
                library.munlockall()
            if collects:
                gc.enable()

    def _observe(self) -> None:
        if outputs.observe(self.memory.buffer, self.memory.index):
            raise SimulationError(laws.OFF_TRACK.format(self.time))

    @property
    def budget_line(self) -> str:
        """The budget of a step, and what it was too small for in a trial, in one line; "" without strips or budget."""
        memos = [wheel.model.arrays.rows.memo for pair in self.law.wheels for wheel in pair]
        if self._record.budget == np.inf or not any(len(memo) and memo[0].grids for memo in memos):
            return ""
        line = f"strips take at most {self._record.budget:g} residuals a step"
        if self.tried is None:
            return line
        return (
            f"{line}; over the run {self.tried.steps} steps had coarse contacts, {self.tried.contacts} in all, and "
            f"{self.tried.unsolved} by Kik and Piotrowski's model"
        )

    @property
    def coarse(self) -> Coarse:
        """What the budget was too small for, in all steps."""
        r = self._record
        return Coarse(int(r.coarse_steps), int(r.all_coarse), int(r.all_unsolved), float(r.most_work))

    def __repr__(self) -> str:
        named = f"{len(self.inputs)} inputs, {len(self.outputs)} outputs"
        step = f"step {1e3 * self.step_size:g} ms"
        return f"Stepper({self.law.vehicle.name!r}, t = {self.time:.6g} s, {step}, {named})"

    @property
    def step_size(self) -> float:
        """Step of the integration [s]."""
        return float(self._record.h)

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self.step_size * int(self._record.steps)

    @property
    def residual(self) -> tuple[float, float]:
        """Norm of the forces without balance ahead of the last correction over the weight, in the last step and the
        most of all steps."""
        weight = self.law.vehicle.weight
        return float(self._record.residual) / weight, float(self._record.most) / weight


def with_torques(vehicle: Vehicle) -> Vehicle:
    """The vehicle with an effort that does not vary on every wheelset, or on both of its wheels where these are
    independent; 0 where it has none."""
    known = {effort.wheelset for effort in vehicle.efforts if len(effort.table) == 1}
    single: tuple[Turned, ...] = ("left", "right")
    pair: tuple[Turned, ...] = ("both",)
    more = [
        Effort(mounted.name, ((0.0, 0.0),), wheel=wheel)
        for mounted in vehicle.wheelsets
        if mounted.name not in known
        for wheel in (single if mounted.wheelset.independent and vehicle.slip_control is None else pair)
    ]
    return replace(vehicle, efforts=(*vehicle.efforts, *more))


class Named(dict[str, Array]):
    """Views by name; the error for a name that there is not has the nearest one."""

    def __missing__(self, name: str) -> Array:
        raise InputError(f"{name!r:.60}: is no input or output of that name{suggest(str(name), list(self))}")


def _named(views: Iterable[tuple[str, Array]]) -> Named:
    """By name. Raises InputError for two of one name."""
    named = Named()
    for name, view in views:
        if (word := name.replace(" ", "_")) in named:
            raise InputError(
                f"two parts, elements, loads or efforts of the vehicle are called {word.rpartition('.')[0]}"
            )
        named[word] = view
    return named


def _inputs(law: VehicleOnTrack) -> dict[str, Array]:
    """Views of loads and efforts of one row each, and of the forces of controls."""
    views, vehicle = law.workspace.views, law.vehicle

    def views_by_name() -> Iterator[tuple[str, Array]]:
        for row, effort in zip(views[vehicle_forces.EFFORTS], vehicle.efforts, strict=True):
            if row["rows"] == 1:
                side = "" if effort.wheel == "both" else f"_{effort.wheel}"
                yield f"{effort.wheelset}.torque{side}_Nm", views[vehicle_forces.EFFORT_TABLES][row["start"], 1:]
        for i, element in enumerate(vehicle.elements):
            if isinstance(element, Strut):
                yield f"{element.name}.control_N", law.elements["added"][i : i + 1]
        for row, load in zip(views[vehicle_forces.LOADS], vehicle.loads, strict=False):  # payloads follow
            for axis in range(1, 4) if row["rows"] == 1 else ():
                force = views[vehicle_forces.LOAD_TABLES][row["start"], axis : axis + 1]
                yield f"{load.name}.force_{'_xyz'[axis]}_N", force

    return _named(views_by_name())


def _outputs(law: VehicleOnTrack) -> dict[str, Array]:
    """Views of what is read of bodies, wheels and struts."""
    views, vehicle = law.whole.views, law.vehicle

    def views_by_name() -> Iterator[tuple[str, Array]]:
        yield from ((f"contacts.{name}", views[kernel.STEP_RECORD][name]) for name in ("coarse", "unsolved"))
        for i, part in enumerate(vehicle.parts):
            for name in outputs.BODY_SEEN.names:
                yield f"{part.name}.{name}_{UNITS[name]}", views[kernel.SEEN][name][i : i + 1]
        for i, mounted in enumerate(vehicle.wheelsets):
            yield f"{mounted.name}.slip_m_s", law.axles["slip"][i : i + 1]
            for k, side in enumerate(SIDES if len(views[kernel.WHEELS]) else ()):
                for name in outputs.WHEEL_SEEN.names:
                    yield f"{mounted.name}.{name}_{side}_N", views[kernel.WHEELS][name][2 * i + k : 2 * i + k + 1]
        for i, element in enumerate(vehicle.elements):
            if isinstance(element, Strut):
                axis = element.axis or 0
                yield f"{element.name}.force_N", law.records[i, axis : axis + 1]
                yield f"{element.name}.travel_m", law.records[i, 3 + axis : 4 + axis]

    return _named(views_by_name())
