"""Strips over a Hertzian ellipse with given creepages, for tests of the tangential models alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.creep_coefficients import creep_coefficients
from wrsim.contact.model import TANGENTIAL, bound_over_cells
from wrsim.core.contact import layout as k
from wrsim.core.contact.tangential.creep_forces import creep_forces

Array = NDArray[np.float64]

SHEAR_MODULUS, POISSON = 82e9, 0.28
COEFFICIENTS = creep_coefficients(POISSON)
MEAN_RADIUS = 5e-3  # sqrt(a b) [m]
PEAK = 1e9  # [Pa]
FORCE = 2.0 / 3.0 * np.pi * MEAN_RADIUS**2 * PEAK  # [N]


def ellipse(aspect: float, strips: int = 40, radius: float = MEAN_RADIUS, peak: float = PEAK) -> Array:
    """Rows of strips over the ellipse of half axes a along x and b = a / aspect; radius: sqrt(a b)."""
    a, b = radius * np.sqrt(aspect), radius / np.sqrt(aspect)
    rows = np.zeros((strips, k.STRIP_COLUMNS))
    rows[:, k.DS] = 2.0 * b / strips
    rows[:, k.S] = -b + (np.arange(strips) + 0.5) * 2.0 * b / strips
    shape = np.sqrt(1.0 - (rows[:, k.S] / b) ** 2)
    rows[:, k.A], rows[:, k.P], rows[:, k.NB] = a * shape, peak * shape, 1.0
    rows[:, k.FORCE] = 0.5 * np.pi * rows[:, k.A] * rows[:, k.P] * rows[:, k.DS]
    return rows


def roll(
    aspect: float,
    xi: float = 0.0,
    eta: float = 0.0,
    phi: float = 0.0,
    *,
    model: str = "fastsim",
    friction: float = 0.3,
    strips: int = 40,
    cells: int = 20,
    direction: float = 1.0,
    radius: float = MEAN_RADIUS,
    peak: float = PEAK,
) -> Array:
    """A tangential model on the ellipse; xi, eta at its centre, spin phi [1/m]. Returns the strips.

    model: a choice of ContactSettings.tangential, or "fastsim, parabolic", or "fastsim, blended".
    """
    rows = ellipse(aspect, strips, radius, peak)
    rows[:, k.XI], rows[:, k.ETA], rows[:, k.PHI] = xi - phi * rows[:, k.S], eta, phi
    force = rows[:, k.FORCE].sum()
    lobe = np.zeros((1, k.PATCH_COLUMNS))
    lobe[0, [k.N, k.N_STRIPS, k.AMPLITUDE, k.PARTNER]] = force, strips, 1.0, -1.0
    lobe[0, k.AREA] = np.pi * radius**2
    lobe[0, k.LENGTH], lobe[0, k.WIDTH] = 2.0 * radius * np.sqrt(aspect), 2.0 * radius / np.sqrt(aspect)
    name, _, option = model.partition(", ")
    numbers = np.zeros(k.SETTINGS)
    numbers[k.TANGENTIAL] = TANGENTIAL[name]
    numbers[k.PARABOLIC] = option == "parabolic"
    numbers[k.BLENDED] = option == "blended"
    numbers[[k.FRICTION, k.FRICTION_GAUGE]] = friction
    numbers[k.SHEAR_MODULUS] = SHEAR_MODULUS
    numbers[[k.FALL_RATIO, k.ADHESION_FACTOR, k.SLIP_FACTOR]] = 1.0
    pose = np.zeros(k.POSE)
    pose[6] = direction
    shape = bound_over_cells(cells, option == "parabolic")
    creep_forces(COEFFICIENTS, shape, numbers, pose, lobe, rows[None], 1, 0, np.zeros((12, max(strips, 8))))
    return rows


def total(rows: Array) -> Array:
    """Fx, Fy on the wheel and their moment about the ellipse's centre."""
    moment = rows[:, k.MZ] - rows[:, k.S] * rows[:, k.FX]
    return np.array([rows[:, k.FX].sum(), rows[:, k.FY].sum(), moment.sum()])
