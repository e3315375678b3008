"""An example of another code: Hertz' ellipse, Kalker's coefficients by table, FASTSIM. Plain numpy."""

import csv

import numpy as np
from scipy.optimize import brentq
from scipy.special import elliprd, elliprf

from campaigns.benchmark.adapter import Code

CELLS = 50


class HertzFastsim(Code):
    """J. J. Kalker, Vehicle System Dynamics 11 (1982) 1, with three flexibilities and an elliptic bound."""

    name = "hertz-fastsim"

    def hertz(self, *, along_per_m, across_per_m, load_N, G_GPa, nu, model):
        if model:
            raise NotImplementedError
        modulus = 1e9 * G_GPa / (1.0 - nu)

        def excess(log):
            k2 = np.exp(2.0 * log)  # of (b/a)^2
            return np.log(elliprd(0.0, k2, 1.0) / elliprd(0.0, 1.0, k2) * across_per_m / along_per_m)

        k = np.exp(brentq(excess, -6.0, 6.0, xtol=1e-13))
        a = np.cbrt(load_N * elliprd(0.0, k**2, 1.0) / (np.pi * modulus * along_per_m))
        p0 = 1.5 * load_N / (np.pi * a * a * k)
        approach = p0 * a * k * elliprf(0.0, 1.0, k**2) / modulus
        return {"p0_MPa": 1e-6 * p0, "approach_mm": 1e3 * approach, "area_mm2": 1e6 * np.pi * a * a * k}

    def kalker(self, *, a_over_b, nu):
        with (self.reference / "kalker.csv").open() as file:
            rows = np.array([[float(x) for x in row] for row in list(csv.reader(file))[1:]])
        inverse = []
        for tabulated_nu in (0.0, 0.25, 0.5):
            rows_of_nu = rows[np.isclose(rows[:, 1], tabulated_nu)]
            rows_of_nu = rows_of_nu[np.argsort(rows_of_nu[:, 0])]
            small = min(a_over_b, 1.0 / a_over_b)  # linear in the smaller ratio
            side = rows_of_nu[rows_of_nu[:, 0] <= 1.0] if a_over_b <= 1.0 else rows_of_nu[rows_of_nu[:, 0] >= 1.0][::-1]
            ratio = np.minimum(side[:, 0], 1.0 / side[:, 0])
            inverse.append([1.0 / np.interp(small, ratio, side[:, c]) for c in (2, 3, 4)])
        weights = (nu - 0.25) * (nu - 0.5) / 0.125, -nu * (nu - 0.5) / 0.0625, nu * (nu - 0.25) / 0.125
        return dict(zip(("C11", "C22", "C23"), 1.0 / (np.array(weights) @ inverse), strict=True))

    def creep_forces(self, *, a_mm, b_mm, N_N, xi, eta, phi_per_mm, friction, G_GPa, nu, model):
        if model not in ("", "fastsim"):
            raise NotImplementedError
        a, b, shear, phi = 1e-3 * a_mm, 1e-3 * b_mm, 1e9 * G_GPa, 1e3 * phi_per_mm
        c11, c22, c23 = self.kalker(a_over_b=a / b, nu=nu).values()
        l1, l2 = 8.0 * a / (3.0 * c11 * shear), 8.0 * a / (3.0 * c22 * shear)
        l3 = np.pi * a * np.sqrt(a / b) / (4.0 * c23 * shear)
        y = b * (2.0 * (np.arange(CELLS) + 0.5) / CELLS - 1.0)
        edge = a * np.sqrt(1.0 - (y / b) ** 2)
        step, tx, ty, sums = 2.0 * edge / CELLS, 0.0, 0.0, np.zeros(3)
        for i in range(CELLS):
            x = edge - (i + 0.5) * step
            tx, ty = tx - step * (xi / l1 - phi * y / l3), ty - step * (eta / l2 + phi * x / l3)
            bound = friction * 1.5 * N_N / (np.pi * a * b) * np.sqrt(1.0 - (x / a) ** 2 - (y / b) ** 2)
            share = np.minimum(1.0, bound / np.maximum(np.hypot(tx, ty), 1e-300))
            tx, ty = share * tx, share * ty
            sums += [(part * step).sum() * 2.0 * b / CELLS for part in (tx, ty, x * ty - y * tx)]
        fx, fy, mz = sums / (friction * N_N)
        return {"fx": fx, "fy": fy, "mz": mz / np.sqrt(a * b)}
