"""The table of the influence of a strip that the package has, from its integral. As a program it writes the file."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

from wrsim.contact.strips.influence import HIGHEST, INNER, LOWEST, OUTER, RISE, SHARP, STEPS, STEPS_BESIDE

FILE = Path(__file__).parents[2] / "wrsim/contact/data/influence.npy"


def made_table() -> NDArray[np.float64]:
    """Coefficients of the cubic spline of PHI/t, see `contact.strips.influence`: (places of xi + 3, of t + 2), in
    the last row for xi = 0.

    PHI is the integral of sqrt(1 - x^2) asinh(t/|x - xi|) over x; its pieces begin and end where that is singular.
    """
    beside = _at_octave(INNER + np.arange((OUTER - INNER) * STEPS_BESIDE + 1) / STEPS_BESIDE)
    xi = np.sqrt(np.maximum(1.0 + 0.5 * (beside - 1.0 / beside) / SHARP, 0.0))
    t = _at_octave(LOWEST + np.arange((HIGHEST - LOWEST) * STEPS + 1) / STEPS)
    z, w = np.polynomial.legendre.leggauss(40)
    z, w = 0.5 * (1.0 + z), 0.5 * w
    # flat at both ends of a piece: takes the singularities off
    share, w = z**3 * (10.0 - 15.0 * z + 6.0 * z * z), w * 30.0 * z**2 * (1.0 - z) ** 2
    value = np.zeros((xi.size, t.size))
    for i, middle in enumerate(xi):
        for lo, hi in ((-1.0, min(middle, 1.0)), (min(middle, 1.0), 1.0)):
            x = lo + (hi - lo) * share
            weights = (hi - lo) * w * np.sqrt(1.0 - x * x)
            value[i] += weights @ np.arcsinh(t / np.maximum(np.abs(x - middle), 1e-300)[:, None])
    table = _spline(_spline(value / t).T).T
    return np.vstack([table, (table[0] + 4.0 * table[1] + table[2]) / 6.0])


def _at_octave(octave: NDArray[np.float64]) -> NDArray[np.float64]:
    """The numbers with these octaves, see `contact.strips.influence.octave`, by Newton's method."""
    whole = np.floor(octave)
    z = part = octave - whole
    rise = np.polynomial.Polynomial((0.0, *RISE))
    for _ in range(6):
        z = z - (rise(z) - part) / rise.deriv()(z)
    return np.asarray(2.0**whole * (1.0 + z))


def _spline(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Coefficients of cubic B-splines through values at whole numbers, along the first axis; third differences of the
    coefficients vanish at both ends."""
    n = len(values)
    bands = np.repeat([[0.0], [1.0], [4.0], [1.0], [0.0]], n, axis=1)
    bands[0, 2] = bands[4, -3] = 1.0
    bands[1, 1] = bands[3, -2] = -2.0
    bands[2, [0, -1]] = 7.0
    c = solve_banded((2, 2), bands, 6.0 * values)
    return np.concatenate([[3.0 * (c[0] - c[1]) + c[2]], c, [3.0 * (c[-1] - c[-2]) + c[-3]]])


if __name__ == "__main__":
    np.save(FILE, made_table())
