"""Which time step is stable and accurate.

RK44 needs the smaller a step the slower a run is (docs/theory/integration.md). Beyond its limit it neither diverges nor
oscillates: results look plausible, so the step is computed from the eigenvalues. On the knife-edge law the limit is
1.04 of 2.785/``creep_rate``; ``stable_step`` is within 1 % of it. In curves it is higher than on straight track: creep
forces are near saturation there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from wrsim.errors import InputError
from wrsim.simulation import Integrator
from wrsim.vehicle.vehicle import Vehicle

if TYPE_CHECKING:
    from wrsim.simulation.bodies import Solid
    from wrsim.simulation.force_law import ForceLaw
    from wrsim.simulation.system import Array, BodySystem

LARGEST_STEP, LARGEST_STEP_UNEVEN = 1e-3, 5e-4
"""Largest step on even and on uneven track [s].

A wheelset on its contact springs vibrates at some 1450 rad/s; on even track nothing keeps that up.
*Measured* on Manchester vehicle 1 at 120 km/h from straight track into a curve of 900 m, against 0.125 ms: largest
difference 0.16 % of the largest Q, 0.07 % of Y, 0.13 % of the accelerations. On ERRI low irregularities at 160 km/h,
against 0.25 ms: 1.9 % of Q, 1.0 % of Y at 1 ms; 0.17 and 0.07 % at 0.5 ms.
"""

LONGEST = 5e-3
"""Longest step of either method [s]."""

STEPS_OF_A_PERIOD = 10
"""Least number of steps in a period of an oscillation that grows: generalised alpha makes it slower by
(2 pi / 10)^2 / 12, 3 %."""

IMPLICIT_STEP, IMPLICIT_WAY, IMPLICIT_GRID = 2e-3, 0.033, 5e-4
"""Largest default step of generalised alpha [s]; longer, up to ``LONGEST`` in whole multiples of the last number [s],
where the distance run in it is at most the second [m]."""

VIBRATING_STEP, STEPS_OF_A_BAY = 1.25e-3, 20
"""Largest default step of generalised alpha on sleepers and with elastic modes [s]: ten steps a period at 80 Hz, to
where comfort is assessed and below which wheels and rails on sleepers vibrate together. Least number of steps from
sleeper to sleeper."""

USUAL_EVALUATIONS = 1.3
"""Evaluations of the forces in a step of generalised alpha: 1.1 on even track, 1.4 to 2 on uneven track."""

SAFETY = 0.8
"""Part of the stability limit that a step may take."""

RK44_LIMIT = 2.785
"""RK44 is stable on y' = -r y for h r below this number."""

CREEP_COEFFICIENT, CREEP_LOAD = 1.3e7, 50e3
"""Creep coefficient of one wheel [N] at a wheel load [N]; it grows with the power 2/3 of the load (Hertz).
"""

MANCHESTER_WHEELSET = (1813.0, 112.0, 0.46, 50e3)
"""Mass [kg], spin inertia [kg m2], radius [m], wheel load [N] where no wheelset is given."""


class StepTooLong(InputError):
    """The given step is not stable. ``rule``: what is allowed, without file and key."""

    def __init__(self, step: float, limit: float, speed: float) -> None:
        self.rule = (
            f"must be at most {1e6 * limit:.0f}, where rk44 becomes unstable at {3.6 * speed:g} km/h; without "
            "step_us a good one is chosen"
        )
        super().__init__(f"run.step_us = {1e6 * step:g}: {self.rule}")


def creep_rate(speed: float, mass: float, spin_inertia: float, radius: float, creep_coefficient: float) -> float:
    """Decay rate of the longitudinal slip of a free wheelset [1/s], the fastest mode of the creep forces.

    Two wheels with the force -C (v - r omega)/V each: rate = 2 C (1/m + r0^2/I_spin)/V. For m = 1813 kg,
    I = 112 kg m2, r0 = 0.46 m and C = 1e7 N: 48800/V.
    """
    return 2.0 * creep_coefficient * (1.0 / mass + radius * radius / spin_inertia) / speed


def step_for_speed(speed: float, vehicle: Vehicle | None = None) -> float:
    """Step of RK44 for a speed [m/s], estimated from the wheel load alone (``stable_step`` takes the force law).

    For the Manchester wheelset at 50 kN a wheel: 2.6e-5 s at 1 m/s, 1.3e-4 at 5, 2.5e-4 at 10.
    """
    mass, inertia, radius, load = MANCHESTER_WHEELSET
    if vehicle is not None:
        wheelset = vehicle.wheelsets[0].wheelset
        mass, inertia, radius = wheelset.mass, wheelset.inertia[1], wheelset.mean_radius
        vertical = vehicle.weight - sum(load.largest[2] for load in vehicle.loads)
        load = 0.5 * vertical / len(vehicle.wheelsets)
    coefficient = CREEP_COEFFICIENT * (max(load, 1e3) / CREEP_LOAD) ** (2.0 / 3.0)
    return round_step(SAFETY * RK44_LIMIT / creep_rate(max(speed, 0.1), mass, inertia, radius, coefficient))


def implicit_step(speed: float, sample_interval: float, spacing: float | None = None, vibrates: bool = False) -> float:
    """Step of generalised alpha [s] at a speed [m/s]: a whole part of the time between two samples [s].

    spacing: of the sleepers [m] where rails lie on them; vibrates: whether there are elastic modes.
    """
    longest = min(max(IMPLICIT_GRID * np.floor(IMPLICIT_WAY / speed / IMPLICIT_GRID), IMPLICIT_STEP), LONGEST)
    if spacing is not None:
        longest = min(VIBRATING_STEP, spacing / (STEPS_OF_A_BAY * speed))
    elif vibrates:
        longest = min(VIBRATING_STEP, longest)
    return sample_interval / int(np.ceil(sample_interval / longest - 1e-9))


def evaluations_for(
    integrator: Integrator,
    duration: float,
    speed: float,
    sample_interval: float,
    step: float | None = None,
    vehicle: Vehicle | None = None,
) -> float:
    """Estimated number of evaluations of the forces in a run of this duration [s]; step [s]: None for the default."""
    if integrator == "rk44":
        return 4.0 * duration / (step or step_for_speed(speed, vehicle))
    return USUAL_EVALUATIONS * duration / (step or implicit_step(speed, sample_interval))


def round_step(step: float, largest: float = LARGEST_STEP) -> float:
    """The largest whole part of a millisecond that is neither above ``step`` nor above ``largest`` [s]."""
    return 1e-3 / int(np.ceil(1e-3 / min(step, largest) - 1e-9))


def eigenvalues(
    forces: ForceLaw, bodies: Sequence[Solid], q: Array, q_t: Array, t: float = 0.0, by_unit: bool = False
) -> Array:
    """Eigenvalues (complex, 12 per body, 2 per damper in series with a spring) [1/s] of the motion about a state.

    Without the gyroscopic terms of the spin (some rad/s): this is for the fast modes that limit the step. by_unit: of
    every vehicle of a train while its neighbours stand still, in a time that grows with their number, not its cube.
    """
    from wrsim.simulation.bodies import mass_matrix
    from wrsim.simulation.force_law import force_derivative

    derivatives = [force_derivative(forces, q, q_t, len(bodies), t, *by) for by in ((1.0, 0.0), (0.0, 1.0))]
    mass, values = mass_matrix(bodies, q), []
    units = forces.coordinates_of_units(alone=True) if by_unit and forces.units > 1 else [np.arange(len(q))]
    for unit in units:
        n, places = len(unit), np.ix_(unit, unit)
        matrix = np.zeros((2 * n, 2 * n))
        matrix[:n, n:] = np.eye(n)
        matrix[n:] = np.linalg.solve(mass[places], np.hstack([derivative[places] for derivative in derivatives]))
        values.append(np.linalg.eigvals(matrix))
    return np.concatenate(values)


def growing_modes(forces: ForceLaw, bodies: Sequence[Solid], q: Array, q_t: Array, t: float, within: float) -> Array:
    """Eigenvalues (n,) [1/s] of oscillations about a state that grow by e within a time [s], the fastest growth first,
    and that some step of this module is too long for: longer than a part of ``STEPS_OF_A_PERIOD`` of the period. Those
    of a train are fast beside the motion of bodies on couplings."""
    values = eigenvalues(forces, bodies, q, q_t, t, by_unit=True)
    fast = values.imag > 2.0 * np.pi / (STEPS_OF_A_PERIOD * LONGEST)
    growing = values[fast & (values.real * within > 1.0)]
    return np.asarray(growing[np.argsort(-growing.real)])


def stable_step(system: BodySystem, q: Array, q_t: Array, t: float = 0.0) -> float:
    """Largest step [s] at which RK44 is stable on the motion about a state; no margin, at most ``LONGEST``.

    Take ``round_step(SAFETY * stable_step(...))``. Modes that grow, and those slower than 10 rad/s, do not limit it.
    """
    values = eigenvalues(system.forces, system.bodies, q, q_t, t)
    values = values[np.abs(values) > 10.0]
    undamped = np.abs(values.real) < 1e-3 * np.abs(values)
    values = np.where(undamped, 1j * values.imag, values)
    values = values[values.real <= 0.0]
    if values.size == 0:
        return LONGEST
    steps = np.geomspace(1e-7, LONGEST, 4000)
    z = steps[:, None] * values
    amplification = np.abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))).max(axis=1)
    beyond = np.flatnonzero(amplification > 1.0 + 1e-9)
    return float(steps[max(beyond[0] - 1, 0)]) if beyond.size else LONGEST
