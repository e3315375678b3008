"""Tractions to displacements of a half-space on a grid, by convolution in Fourier space.

Kernel coefficients (core.halfspace_influence) are computed once for each shape of element and scaled; their transforms
are kept for each size of grid. ``"angle-corrected"`` turns them by the angle alpha = a(source) - a(receiver) between
the rows' normals (Blanco-Lorenzo et al., Tribology International 103, 2016; Vollebregt, CONTACT user guide, 2023):

    B_nn = A_nn cos alpha - A_ns sin alpha        B_ss = A_ss cos alpha + A_sn sin alpha
    B_sn = A_sn cos alpha - A_ss sin alpha        B_xs = A_xs cos alpha + A_xn sin alpha
    B_xx = A_xx, B_sx = A_sx                      B_xn = A_xn cos alpha - A_xs sin alpha

Because cos and sin of a difference are sums of products of functions of source and receiver alone, each of them is
two plain convolutions: the corrected kernel costs twice the plain one, nothing more.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import pi

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from wrsim.contact.settings import Material
from wrsim.core.halfspace_influence import INTEGRALS, NN, SN, SS, XN, XS, XX, fill_integrals

Array = NDArray[np.float64]
Spectrum = NDArray[np.complexfloating]

# odd in (s, x)
_ODD = {
    NN: (False, False),
    XX: (False, False),
    SS: (False, False),
    XS: (True, True),
    XN: (False, True),
    SN: (True, False),
}


@dataclass(frozen=True)
class Compliance:
    """Constants of two bodies: c_n, c_t, c_k of core.halfspace_influence [1/Pa]; c_k is wheel minus rail."""

    normal: float
    tangential: float
    coupling: float

    @classmethod
    def of(cls, wheel: Material, rail: Material) -> Compliance:
        """Of a wheel's and a rail's material."""
        both = (wheel, rail)
        k_wheel, k_rail = ((1.0 - 2.0 * m.poisson_ratio) / m.shear_modulus for m in both)
        return cls(
            sum((1.0 - m.poisson_ratio) / m.shear_modulus for m in both) / (2.0 * pi),
            sum(m.poisson_ratio / m.shear_modulus for m in both) / (2.0 * pi),
            (k_wheel - k_rail) / (4.0 * pi),
        )

    @property
    def modulus(self) -> float:
        """E* [Pa]."""
        return 1.0 / (pi * self.normal)


@lru_cache(maxsize=16)
def _integrals(ratio: float, columns: int, rows: int) -> Array:
    """Integrals (INTEGRALS, columns, rows) at non-negative offsets, for elements 1 x ratio."""
    out = np.zeros((INTEGRALS, columns + 1, rows + 1))
    fill_integrals(0.0, 1.0, 0.0, ratio, out)
    return out[:, :columns, :rows]


@lru_cache(maxsize=64)
def _spectrum(kind: int, ratio: float, rows: int, columns: int, period: tuple[int, int]) -> Array:
    """Transform of one integral for a grid, elements 1 x ratio: real, or the imaginary part of an imaginary one."""
    size = 64
    while size < max(rows, columns):
        size *= 2
    quarter = _integrals(ratio, size, size)[kind, :columns, :rows].T
    odd_s, odd_x = _ODD[kind]
    full = np.zeros(period)
    full[:rows, :columns] = quarter
    full[1 - rows :, :columns] = quarter[:0:-1] * (-1.0 if odd_s else 1.0)
    full[:, 1 - columns :] = full[:, columns - 1 : 0 : -1] * (-1.0 if odd_x else 1.0)
    transform = scipy.fft.rfft2(full)
    return np.ascontiguousarray(transform.imag if odd_s != odd_x else transform.real)


class HalfSpaceOperator:
    """Influence of tractions on (rows, columns) elements ds x dx upon each other.

    angles: of the rows' normals [rad] for the angle-corrected kernel, or None for the plain one.
    """

    def __init__(
        self, rows: int, columns: int, ds: float, dx: float, compliance: Compliance, angles: Array | None = None
    ) -> None:
        self.rows, self.columns, self.ds, self.dx = rows, columns, ds, dx
        self.compliance = compliance
        # one element more than the linear convolution needs: the slip looks one element ahead
        self._period = (scipy.fft.next_fast_len(2 * rows, True), scipy.fft.next_fast_len(2 * columns, True))
        self._turn = None if angles is None else (np.cos(angles)[:, None], np.sin(angles)[:, None])
        self._tangential: tuple[Array, Array, Array] | None = None
        self._normal = compliance.normal * dx * self._of(NN)
        self._near = Inverse(rows, columns, ds, dx, compliance)

    def _of(self, kind: int) -> Array:
        return _spectrum(kind, round(self.ds / self.dx, 9), self.rows, self.columns, self._period)

    def _transform(self, q: Array) -> Spectrum:
        return scipy.fft.fft(scipy.fft.rfft(q, self._period[1], axis=-1), self._period[0], axis=-2, overwrite_x=True)

    def _back(self, f: Spectrum) -> Array:
        cut = scipy.fft.ifft(f, axis=-2, overwrite_x=True)[..., : self.rows, :]
        return scipy.fft.irfft(cut, self._period[1], axis=-1)[..., : self.columns]

    def normal(self, p: Array) -> Array:
        """Normal displacement difference under the pressures p [Pa], (rows, columns) [m]."""
        if self._turn is None:
            f = self._transform(p)
            f *= self._normal
            return self._back(f)
        cos, sin = self._turn
        f = self._transform(np.stack([cos * p, sin * p]))
        f *= self._normal
        u = self._back(f)
        turned: Array = cos * u[0] + sin * u[1]
        return turned

    def near_pressure(self, e: Array) -> Array:
        """Roughly the pressure that makes the normal displacement e: the preconditioner of the normal problem."""
        return self._near.pressure(e)

    def near_traction(self, u: Array) -> Array:
        """Roughly the tractions that make the tangential displacements u, (2, rows, columns)."""
        return self._near.traction(u)

    def _shear(self) -> tuple[Array, Array, Array]:
        """Spectra of A_xx, A_ss, A_xs."""
        if self._tangential is None:
            c, dx = self.compliance, self.dx
            self._tangential = (
                dx * (c.normal * self._of(NN) + c.tangential * self._of(XX)),
                dx * (c.normal * self._of(NN) + c.tangential * self._of(SS)),
                dx * c.tangential * self._of(XS),
            )
        return self._tangential

    def _ahead(self, forward: float) -> Spectrum:
        """Takes u(x) to (u(x) - u(x + forward dx)) / dx."""
        k = 2.0 * pi * scipy.fft.rfftfreq(self._period[1])
        return (1.0 - np.exp(1j * forward * k)) / self.dx

    def slip(self, q: Array, forward: float) -> Array:
        """Slip over the rolling speed, (2, rows, columns), that the tractions q on the wheel bring about."""
        xx, ss, xs = self._shear()
        ahead = self._ahead(forward)
        if self._turn is None:
            f = self._transform(q)
            f *= ahead
            return self._back(np.stack([xx * f[0] + xs * f[1], xs * f[0] + ss * f[1]]))
        cos, sin = self._turn
        f = self._transform(np.stack([q[0], cos * q[1], sin * q[1]]))
        f *= ahead
        parts = [xx * f[0], xs * f[0], xs * f[1], xs * f[2], ss * f[1], ss * f[2]]
        if self.compliance.coupling != 0.0:
            xn, sn = self._coupling()
            # sin(a_source - a_receiver) = sin cos - cos sin
            parts += [xn * f[1], xn * f[2], sn * f[1], sn * f[2]]
        u = self._back(np.stack(parts))
        x = u[0] + cos * u[2] + sin * u[3]
        s = u[1] + cos * u[4] + sin * u[5]
        if self.compliance.coupling != 0.0:
            x += cos * u[7] - sin * u[6]
            s += cos * u[9] - sin * u[8]
        return np.stack([x, s])

    def slip_of_pressure(self, p: Array, forward: float) -> Array | None:
        """Slip over the rolling speed that the pressures bring about; None where there is none.

        On a plane with equal materials there is none; different materials and turned normals make some.
        """
        c = self.compliance
        if c.coupling == 0.0 and self._turn is None:
            return None
        ahead = self._ahead(forward)
        if self._turn is None:
            f = self._transform(p) * ahead
            xn, sn = self._coupling()
            return self._back(np.stack([xn * f, sn * f]))
        cos, sin = self._turn
        f = self._transform(np.stack([cos * p, sin * p])) * ahead
        _, ss, xs = self._shear()
        u = self._back(np.stack([xs * f[0], xs * f[1], ss * f[0], ss * f[1]]))
        x = -(cos * u[1] - sin * u[0])
        s = -(cos * u[3] - sin * u[2])
        if c.coupling != 0.0:
            xn, sn = self._coupling()
            u = self._back(np.stack([xn * f[0], xn * f[1], sn * f[0], sn * f[1]]))
            x += cos * u[0] + sin * u[1]
            s += cos * u[2] + sin * u[3]
        return np.stack([x, s])

    def _coupling(self) -> tuple[Spectrum, Spectrum]:
        """Spectra of A_xn and A_sn."""
        scale = self.compliance.coupling * self.dx
        xn: Spectrum = 1j * scale * self._of(XN)
        sn: Spectrum = 1j * scale * self._of(SN)
        return xn, sn

    def self_slip(self) -> float:
        """Largest slip that an element's own traction brings about, over that traction [1/Pa]."""
        own = _integrals(round(self.ds / self.dx, 9), 64, 64)[:, :2, 0]
        c = self.compliance
        along = (XX, SS)
        return max(c.normal * (own[NN, 0] - own[NN, 1]) + c.tangential * (own[k, 0] - own[k, 1]) for k in along)


class Inverse:
    """Inverse symbols of the half-space on a periodic grid hardly larger than the patch: preconditioners.

    Over the wave number k a half-space yields (1 - nu)/(G |k|) normal to its surface and along k, 1/(G |k|) across.
    """

    MARGIN = 6

    def __init__(self, rows: int, columns: int, ds: float, dx: float, compliance: Compliance) -> None:
        self.rows, self.columns = rows, columns
        self._period = tuple(scipy.fft.next_fast_len(n + self.MARGIN, True) for n in (rows, columns))
        kx = 2.0 * pi * scipy.fft.rfftfreq(self._period[1], dx)
        ks = 2.0 * pi * scipy.fft.fftfreq(self._period[0], ds)[:, None]
        k = np.hypot(kx, ks)
        k[0, 0] = 4.0 / max(self._period[0] * ds, self._period[1] * dx)
        along = k / (2.0 * pi * compliance.normal)
        across = k / (2.0 * pi * (compliance.normal + compliance.tangential))
        self._normal = along
        self._xx = (along * kx**2 + across * ks**2) / k**2
        self._ss = (along * ks**2 + across * kx**2) / k**2
        self._xs = (along - across) * kx * ks / k**2
        self._xx[0, 0] = self._ss[0, 0] = across[0, 0]

    def _transform(self, u: Array) -> Spectrum:
        return scipy.fft.fft(scipy.fft.rfft(u, self._period[1], axis=-1), self._period[0], axis=-2, overwrite_x=True)

    def _back(self, f: Spectrum) -> Array:
        cut = scipy.fft.ifft(f, axis=-2, overwrite_x=True)[..., : self.rows, :]
        return scipy.fft.irfft(cut, self._period[1], axis=-1)[..., : self.columns]

    def pressure(self, u: Array) -> Array:
        """Pressures for normal displacements, (rows, columns)."""
        f = self._transform(u)
        f *= self._normal
        return self._back(f)

    def traction(self, u: Array) -> Array:
        """Tractions for tangential displacements, (2, rows, columns)."""
        f = self._transform(u)
        return self._back(np.stack([self._xx * f[0] + self._xs * f[1], self._xs * f[0] + self._ss * f[1]]))
