"""Error that a time step leaves in vibrations of the lateral forces, and the step that keeps it small.

A trapezoidal rule solves the equations of a mode as if a sixth of the second difference of the force over three steps
disturbed them. The bank holds the response of one mode per frequency to this: (int-phase). A vibration that lasts adds
up, noise and single impacts do not.
"""

import numpy as np
from numpy.typing import NDArray

from wrsim.simulation.step_size import IMPLICIT_GRID, IMPLICIT_STEP, LONGEST, STEPS_OF_A_PERIOD
from wrsim.vehicle.dynamics import watch

DAMPING = 0.02
"""Damping ratio of the modes: of wheelsets between tread and flange it is -0.01 to 0.05, on the tread 0.06 and more."""

FREQUENCIES = 2.0 * np.pi * np.geomspace(1.0 / LONGEST, 1.0 / IMPLICIT_STEP, 24) / STEPS_OF_A_PERIOD
"""Of the modes [rad/s]: 20 to 50 Hz, in steps of twice the damping ratio."""

REST = 0.2
"""Part of the tolerance to which refined steps reduce the error: a mode without damping goes on for longer."""


class PhaseError:
    """Error of the lateral forces of wheels in steps of one length; ``arrays`` are its state."""

    def __init__(self, wheels: int, step: float, tolerance: float) -> None:
        """step [s]: 0 where steps are given, and no others are wanted; tolerance [N]."""
        self.step, self.tolerance = step, tolerance
        self._rates = np.stack([-DAMPING * FREQUENCIES, FREQUENCIES], axis=1)
        clock = np.array([np.nan, np.nan, 0.0, 0.0])
        self.arrays = np.zeros((len(FREQUENCIES), wheels, 2)), np.zeros((2, wheels)), clock
        """Errors of the modes (modes, wheels, 2) [N]; forces [N] and their rates [N/s] at the last step; its time and
        length [s], 1 while steps are to be refined, and the largest error."""

    def add(self, t: float, forces: NDArray[np.float64]) -> None:
        """Take in the forces (wheels,) [N] at the end of a step, which may be a part of one of length ``step``."""
        watch.add_phase_error(t, self.step, self.tolerance, REST, self._rates, forces, *self.arrays)

    @property
    def longest_step(self) -> float:
        """The longest step for what follows [s]; infinite where ``step`` does."""
        _, _, refined, error = self.arrays[-1].tolist()
        return max(self.step * (REST * self.tolerance / error) ** 0.5, IMPLICIT_GRID) if refined else np.inf
