"""Fit the influence beside the middle of a strip that `wrsim/core/contact/strips/influence.py` has as ``BESIDE``.

    python campaigns/fit_shifted_influence.py

The integral int sqrt((1 - t^2)/((x - t)^2 + s^2)) dt over -1..1 and its first two derivatives by x are met in the mean
square for x < REACH s, where strips that follow each other across a slanted contact lie; beyond they count little.
Prints the sixteen numbers, and how far they are off: the largest error over f(1, s), of the derivatives times
sqrt(1 + s^2) and 1 + s^2.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray
from scipy.interpolate import RectBivariateSpline

Array = NDArray[np.float64]

REACH = 2.5  # x over s up to which the fit counts whole
POINTS = 60  # of the quadrature on either side of x
WEIGHTS = 2.0, 1.0, 0.7  # of the integral and its derivatives
BEYOND = 0.1, 0.01, 0.003  # the same beyond REACH, over these
SHARE_BEYOND_ENDS = 0.3  # weight of places beyond the end of the strip


def integral(x: float, s: float) -> float:
    """int sqrt((1 - t^2)/((x - t)^2 + s^2)) dt, by quadrature graded towards t = x."""
    nodes, weights = leggauss(POINTS)
    z, w = 0.5 * (nodes + 1.0), 0.5 * weights
    nearest = np.arcsin(min(x, 1.0))
    total = 0.0
    for end in (-0.5 * np.pi, 0.5 * np.pi):
        angle = nearest + (end - nearest) * z**5
        steps = np.abs(end - nearest) * 5.0 * z**4 * w
        total += float((steps * np.cos(angle) ** 2 / np.sqrt((x - np.sin(angle)) ** 2 + s * s)).sum())
    return total


def exact(x: Array, s: Array) -> tuple[Array, Array, Array]:
    """The integral over that at x = 0, and its two derivatives by x over it, at all (x, s)."""
    places = np.concatenate([np.linspace(0.0, 2.0, 81), np.linspace(2.1, 8.0, 40)])
    logs = np.linspace(np.log(1e-3), np.log(30.0), 90)
    values = np.array([[integral(a, float(np.exp(b))) for b in logs] for a in places])
    far = np.sqrt(1.0 + places[:, None] ** 2 / (1.0 + np.exp(2.0 * logs)))
    smooth = RectBivariateSpline(places, logs, values / values[0] * far, kx=5, ky=3)
    h = [smooth(x, np.log(s), dx=k) for k in range(3)]
    m, y = 1.0 + s * s, x[:, None] ** 2 / (1.0 + s * s)
    g0 = 1.0 / np.sqrt(1.0 + y)
    g1, g2 = -x[:, None] / m * g0**3, -(1.0 - 2.0 * y) / m * g0**5
    return h[0] * g0, h[1] * g0 + h[0] * g1, h[2] * g0 + 2.0 * h[1] * g1 + h[0] * g2


def main() -> None:
    """Print the fit."""
    x = np.concatenate([np.linspace(0.01, 1.6, 80), np.linspace(1.7, 7.8, 30)])
    s = np.exp(np.linspace(np.log(0.01), np.log(20.0), 110))
    m = 1.0 + s * s
    truth = [value * m ** (0.5 * k) for k, value in enumerate(exact(x, s))]
    i, y = 1.0 / m, x[:, None] ** 2 / (m + x[:, None] ** 2)
    z, over = 1.0 - y, x[:, None] / np.sqrt(m)

    def with_derivatives(p: Array, p_y: Array, p_yy: Array) -> tuple[Array, Array, Array]:
        """sqrt(z) p and its derivatives by x, scaled like ``truth``."""
        g, g_y = 2.0 * z * p_y - p, 2.0 * z * p_yy - 3.0 * p_y
        return np.sqrt(z) * p, over * z**1.5 * g, z**1.5 * (g * (1.0 - 3.0 * y) + 2.0 * y * z * g_y)

    plain = with_derivatives(np.ones_like(y), np.zeros_like(y), np.zeros_like(y))
    terms = []
    for k in range(2, 6):
        for j in range(4):
            part = i * np.sqrt(1.0 - i) ** j
            terms.append(with_derivatives(-part * y**k, -part * k * y ** (k - 1), -part * k * (k - 1) * y ** (k - 2)))
    within = x[:, None] <= REACH * s + 0.02
    at_end = np.where(x < 1.3, 1.0, SHARE_BEYOND_ENDS)[:, None]
    rows, wanted = [1e-3 * np.eye(len(terms))], [np.zeros(len(terms))]
    for k in range(3):
        weight = WEIGHTS[k] * np.where(within, 1.0, BEYOND[k]) * at_end
        rows.append(np.stack([(weight * term[k]).ravel() for term in terms], axis=1))
        wanted.append((weight * (truth[k] - plain[k])).ravel())
    numbers = np.linalg.lstsq(np.vstack(rows), np.concatenate(wanted), rcond=None)[0]
    print("BESIDE =", tuple(np.round(numbers, 4).tolist()))
    for ratio in (1.0, REACH, 4.0):
        near = x[:, None] <= ratio * s + 0.02
        found = [plain[k] + sum(c * term[k] for c, term in zip(numbers, terms, strict=True)) for k in range(3)]
        for low, high in ((0.0, 0.3), (0.3, 0.7), (0.7, 1.2)):
            there = near & (x >= low)[:, None] & (x < high)[:, None]
            worst = [float(np.abs(found[k] - truth[k])[there].max()) for k in range(3)]
            print(f"x < {ratio:g} s, {low:g} to {high:g}: " + " ".join(f"{e:.4f}" for e in worst))


if __name__ == "__main__":
    main()
