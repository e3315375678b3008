"""Strips over a Hertzian ellipse with given creepages, for tests of the tangential models alone."""

import numpy as np
from numpy.typing import NDArray

from wrsim.contact import records as k
from wrsim.contact.arrays import ARRAYS, Arrays
from wrsim.contact.creep.creep_forces import creep_forces
from wrsim.contact.creep.laws import CREEP_LAWS
from wrsim.contact.tables import bound_over_cells, creep_coefficients

Array = NDArray[np.float64]

SHEAR_MODULUS, POISSON = 82e9, 0.28
COEFFICIENTS = creep_coefficients(POISSON)
MEAN_RADIUS = 5e-3  # sqrt(a b) [m]
PEAK = 1e9  # [Pa]
FORCE = 2.0 / 3.0 * np.pi * MEAN_RADIUS**2 * PEAK  # [N]


def ellipse(aspect: float, strips: int = 40, radius: float = MEAN_RADIUS, peak: float = PEAK) -> Array:
    """Rows of strips over the ellipse of half axes a along x and b = a / aspect; radius: sqrt(a b)."""
    a, b = radius * np.sqrt(aspect), radius / np.sqrt(aspect)
    rows = np.zeros(strips, k.STRIP)
    rows["ds"] = 2.0 * b / strips
    rows["s"] = -b + (np.arange(strips) + 0.5) * 2.0 * b / strips
    shape = np.sqrt(1.0 - (rows["s"] / b) ** 2)
    rows["a"], rows["p"], rows["nb"] = a * shape, peak * shape, 1.0
    rows["N"] = 0.5 * np.pi * rows["a"] * rows["p"] * rows["ds"]
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
    **numbers: float,
) -> Array:
    """A tangential model on the ellipse; xi, eta at its centre, spin phi [1/m]. Returns the strips.

    model: a choice of ContactSettings.tangential, or "fastsim, parabolic", or "fastsim, blended"; direction: speed
    along x [m/s]; numbers: of MODEL and CALL."""
    rows = ellipse(aspect, strips, radius, peak)
    rows["xi"], rows["eta"], rows["phi"] = xi - phi * rows["s"], eta, phi
    force = rows["N"].sum()
    lobes, constants, call = np.zeros(1, k.LOBE), np.zeros(1, k.MODEL), np.zeros(1, k.CALL)
    lobes["N"], lobes["n_strips"], lobes["amplitude"], lobes["partner"] = force, strips, 1.0, -1
    lobes["area"] = np.pi * radius**2
    lobes["length"], lobes["width"] = 2.0 * radius * np.sqrt(aspect), 2.0 * radius / np.sqrt(aspect)
    name, _, option = model.partition(", ")
    constants["tangential"] = CREEP_LAWS[name].kernel
    constants["parabolic"] = option == "parabolic"
    constants["blended"] = option == "blended"
    call["mu"] = call["mu_gauge"] = friction
    constants["G"] = SHEAR_MODULUS
    call["fall_ratio"] = 1.0
    for factor in ("kA", "kS", "slope_k0", "slope_alpha_inf"):
        constants[factor] = 1.0
    for name, value in numbers.items():
        (call if name in call.dtype.names else constants)[name] = value
    shape = bound_over_cells(cells, option == "parabolic")
    work = np.zeros((12, max(strips, 8, cells)))
    nothing = Arrays(*[None] * ARRAYS)
    a = nothing._replace(
        creep=COEFFICIENTS, shape=shape, model=constants, call=call, patches=lobes, strips=rows[None], work=work
    )
    creep_forces(a, direction, 1, 0)
    return rows


def total(rows: Array) -> Array:
    """Fx, Fy on the wheel and their moment about the ellipse's centre."""
    moment = rows["Mz"] - rows["s"] * rows["Fx"]
    return np.array([rows["Fx"].sum(), rows["Fy"].sum(), moment.sum()])
