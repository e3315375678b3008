"""Half-space problems with known solutions: ellipses of Hertz on grids of elements."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import elliprd, elliprf

from support.contacts import STEEL
from wrsim.contact.half_space.influence import Compliance, Operator

Array = NDArray[np.float64]

COMPLIANCE = Compliance.of(STEEL, STEEL)


@dataclass(frozen=True)
class Ellipse:
    """Hertz' contact of half axes a (along x), b (along s) [m] and peak pressure p0 [Pa]; modulus: E* [Pa].

    With Carlson's integrals (Johnson, Contact Mechanics, 1985, sections 3.2 and 3.3): the surfaces part by
    A x^2 + B s^2, A = p0 a b R_D(0, b^2, a^2)/(3 E*), the approach is p0 a b R_F(0, a^2, b^2)/E*."""

    a: float
    b: float
    p0: float = 1e9
    modulus: float = COMPLIANCE.modulus

    @property
    def curvatures(self) -> tuple[float, float]:
        scale = self.p0 * self.a * self.b / (3.0 * self.modulus)
        return scale * elliprd(0.0, self.b**2, self.a**2), scale * elliprd(0.0, self.a**2, self.b**2)

    @property
    def approach(self) -> float:
        return self.p0 * self.a * self.b * elliprf(0.0, self.a**2, self.b**2) / self.modulus

    @property
    def force(self) -> float:
        return 2.0 / 3.0 * np.pi * self.a * self.b * self.p0

    @property
    def area(self) -> float:
        return np.pi * self.a * self.b


def hertz(ratio: float, approach: float = 1.0) -> Ellipse:
    """The ellipse between paraboloids A = ratio, B = 1, for E* = 1."""

    def excess(log: float) -> float:
        return float(np.log(np.divide(*Ellipse(1.0, np.exp(log), 1.0, 1.0).curvatures) / ratio))

    shape = np.exp(brentq(excess, -6.0, 6.0, xtol=1e-14))  # b/a
    unit = Ellipse(1.0, shape, 1.0, 1.0)
    # at the scale where B is 1
    b = unit.curvatures[1]
    a = np.sqrt(approach * b / unit.approach)
    return Ellipse(a, a * shape, approach / (a * unit.approach), 1.0)


@dataclass(frozen=True)
class EllipseGrid:
    """``across`` elements over either axis of an ellipse, on a grid 1.1 times as large, off its centre by ``off``."""

    ellipse: Ellipse
    across: int
    off: tuple[float, float] = (0.0, 0.0)

    @property
    def count(self) -> int:
        return round(1.1 * self.across)

    @property
    def dx(self) -> float:
        return 2.0 * self.ellipse.a / self.across

    @property
    def ds(self) -> float:
        return 2.0 * self.ellipse.b / self.across

    @property
    def x(self) -> Array:
        return (np.arange(self.count) - 0.5 * (self.count - 1) + self.off[0]) * self.dx

    @property
    def s(self) -> Array:
        return ((np.arange(self.count) - 0.5 * (self.count - 1) + self.off[1]) * self.ds)[:, None]

    @property
    def cell(self) -> float:
        return self.dx * self.ds

    def operator(self, **choices) -> Operator:
        return Operator(self.count, self.count, self.ds, self.dx, COMPLIANCE, **choices)

    def penetration(self) -> Array:
        a, b = self.ellipse.curvatures
        return self.ellipse.approach - a * self.x**2 - b * self.s**2

    def pressure(self) -> Array:
        """Hertz' own, at the elements' centres."""
        e = self.ellipse
        return e.p0 * np.sqrt(np.maximum(1.0 - (self.x / e.a) ** 2 - (self.s / e.b) ** 2, 0.0))

    def rigid_slip(self, xi: float, eta: float, phi: float, ahead: float = 1.0 / 6.0) -> Array:
        """Of creepages and a spin [1/m], taken ``ahead`` of the elements' centres, in elements."""
        x, s = np.broadcast_arrays(self.x + ahead * self.dx, self.s)
        return np.stack([xi - phi * s, eta + phi * x])

    def resultants(self, q: Array) -> Array:
        """Fx, Fs and the moment about the centre."""
        moment = (self.x * q[1] - self.s * q[0]).sum()
        return np.array([q[0].sum(), q[1].sum(), moment]) * self.cell
