"""Tractions to displacements of a half-space on a grid, by convolution in Fourier space.

Kernel coefficients (core.contact.half_space.influence) are computed once for each shape of element and scaled; their
transforms are kept for each size of grid. Displacements are those of the wheel relative to the rail, tractions act on
the wheel: p along the row's normal n (from rail to wheel), q_x along the rail, q_s along the row's tangent t.

``"angle-corrected"`` takes a traction in the frame of its own row J, with the influence of the half-space tangent
there, and the displacement in the frame of row I (Vollebregt, Vehicle System Dynamics 56, 2018; version 3 of
CONTACT's corrections). With alpha = a(J) - a(I) between the normals:

    B_nn = A_nn cos alpha + A_sn sin alpha        B_ns = A_ns cos alpha + A_ss sin alpha
    B_sn = A_sn cos alpha - A_nn sin alpha        B_ss = A_ss cos alpha - A_ns sin alpha

(A_sn = -A_ns is zero for equal materials.) Pressure thus makes slip and creep forces lift or press. Written in the
axes (o, b) of the section these are sums of A_nn * (p n), A_ss * (q_s t), ...: plain convolutions, so the corrected
kernel costs about twice the plain one, nothing more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import pi

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from wrsim.contact.settings import Material
from wrsim.core.contact.half_space.influence import INTEGRALS, NN, SN, SS, XN, XS, XX, fill_integrals

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
    """Constants of two bodies: c_n, c_t, c_k of core.contact.half_space.influence [1/Pa]; c_k is rail minus wheel."""

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
            (k_rail - k_wheel) / (4.0 * pi),
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
    while size <= max(rows, columns):
        size *= 2
    # one column more than the grid has: the slip looks one element ahead
    quarter = _integrals(ratio, size, size)[kind, : columns + 1, :rows].T
    odd_s, odd_x = _ODD[kind]
    full = np.zeros(period)
    full[:rows, : columns + 1] = quarter
    full[1 - rows :, : columns + 1] = quarter[:0:-1] * (-1.0 if odd_s else 1.0)
    full[:, -columns:] = full[:, columns:0:-1] * (-1.0 if odd_x else 1.0)
    transform = scipy.fft.rfft2(full)
    return np.ascontiguousarray(transform.imag if odd_s != odd_x else transform.real)


class HalfSpaceOperator:
    """Influence of tractions on (rows, columns) elements ds x dx upon each other.

    angles: of the rows' normals [rad] for the angle-corrected kernel, or None for the plain one. shares: for groups of
    rows whose mutual influence is weakened, the rows of each group and its influence on all rows, both (rows, 1).
    """

    def __init__(
        self,
        rows: int,
        columns: int,
        ds: float,
        dx: float,
        compliance: Compliance,
        angles: Array | None = None,
        shares: Sequence[tuple[Array, Array]] = (),
    ) -> None:
        self.rows, self.columns, self.ds, self.dx = rows, columns, ds, dx
        self.compliance = compliance
        self._period = (scipy.fft.next_fast_len(2 * rows - 1, True), scipy.fft.next_fast_len(2 * columns + 1, True))
        self._tangent, self._normal_of_row = _frames(angles)
        self._curved = angles is not None
        self._shares = tuple(shares)
        self._spectra: dict[int, Array] = {}
        self._near = Inverse(rows, columns, ds, dx, compliance)

    @property
    def coupled(self) -> bool:
        """Whether pressures make tangential, and tractions normal displacements."""
        return self._curved or self.compliance.coupling != 0.0

    def _of(self, kind: int) -> Array:
        """Spectrum of A_nn, A_xx, A_ss, A_xs, or the imaginary part of that of A_xn, A_sn."""
        if kind not in self._spectra:
            c, ratio = self.compliance, round(self.ds / self.dx, 9)

            def integral(k: int) -> Array:
                return _spectrum(k, ratio, self.rows, self.columns, self._period)

            if kind in (XX, SS):
                spectrum = c.normal * integral(NN) + c.tangential * integral(kind)
            else:
                spectrum = {NN: c.normal, XS: c.tangential, XN: c.coupling, SN: c.coupling}[kind] * integral(kind)
            self._spectra[kind] = self.dx * spectrum
        return self._spectra[kind]

    def _transform(self, q: Array) -> Spectrum:
        return scipy.fft.fft(scipy.fft.rfft(q, self._period[1], axis=-1), self._period[0], axis=-2, overwrite_x=True)

    def _back(self, f: Spectrum) -> Array:
        cut = scipy.fft.ifft(f, axis=-2, overwrite_x=True)[..., : self.rows, :]
        return scipy.fft.irfft(cut, self._period[1], axis=-1)[..., : self.columns]

    def near_pressure(self, e: Array) -> Array:
        """Roughly the pressure that makes the normal displacement e: the preconditioner of the normal problem."""
        return self._near.pressure(e)

    def near_traction(self, u: Array) -> Array:
        """Roughly the tractions that make the tangential displacements u, (2, rows, columns)."""
        return self._near.traction(u)

    def _ahead(self, forward: float) -> Spectrum:
        """Takes u(x) to (u(x) - u(x + forward dx)) / dx."""
        k = 2.0 * pi * scipy.fft.rfftfreq(self._period[1])
        ahead: Spectrum = (1.0 - np.exp(1j * forward * k)) / self.dx
        return ahead

    def _shared(self, act: Callable[[Array], Array], q: Array) -> Array:
        """What all groups of rows do to all rows."""
        if not self._shares:
            return act(q)
        total = self._shares[0][1] * act(self._shares[0][0] * q)
        for own, influence in self._shares[1:]:
            total += influence * act(own * q)
        return total

    def normal(self, p: Array) -> Array:
        """Normal displacements under the pressures p [Pa], (rows, columns) [m]."""
        return self._shared(self._normal, p)

    def slip(self, q: Array, forward: float) -> Array:
        """Slip over the rolling speed, (2, rows, columns), that the tractions q bring about."""
        return self._shared(lambda part: self._slip(part, forward), q)

    def normal_of_tractions(self, q: Array) -> Array:
        """Normal displacements under tangential tractions (rows, columns) [m]; zero unless ``coupled``."""
        if not self.coupled:
            return np.zeros(q.shape[1:])
        return self._shared(self._normal_of_tractions, q)

    def slip_of_pressure(self, p: Array, forward: float) -> Array:
        """Slip over the rolling speed that the pressures bring about; zero unless ``coupled``."""
        if not self.coupled:
            return np.zeros((2, *p.shape))
        return self._shared(lambda part: self._slip_of_pressure(part, forward), p)

    def _normal(self, p: Array) -> Array:
        if not self._curved:
            f = self._transform(p)
            f *= self._of(NN)
            return self._back(f)
        n = self._normal_of_row
        f = self._transform(n * p)
        f *= self._of(NN)
        if self.compliance.coupling != 0.0:
            f += 1j * self._of(SN) * self._transform(self._tangent * p)
        u: Array = (n * self._back(f)).sum(axis=0)
        return u

    def _slip(self, q: Array, forward: float) -> Array:
        if not self._curved:
            f = self._transform(q)
            f *= self._ahead(forward)
            xs = self._of(XS)
            return self._back(np.stack([self._of(XX) * f[0] + xs * f[1], xs * f[0] + self._of(SS) * f[1]]))
        x, section = self._under_tractions(q)
        u = self._back(np.concatenate([x[None], section]) * self._ahead(forward))
        return np.stack([u[0], (self._tangent * u[1:]).sum(axis=0)])

    def _normal_of_tractions(self, q: Array) -> Array:
        if not self._curved:
            f = self._transform(q)
            return self._back(-1j * (self._of(XN) * f[0] + self._of(SN) * f[1]))
        _, section = self._under_tractions(q)
        u: Array = (self._normal_of_row * self._back(section)).sum(axis=0)
        return u

    def _slip_of_pressure(self, p: Array, forward: float) -> Array:
        ahead = self._ahead(forward)
        along = 1j * self._of(XN) * self._transform(p)
        if not self._curved:
            return self._back(np.stack([along, 1j * self._of(SN) * self._transform(p)]) * ahead)
        section = self._of(NN) * self._transform(self._normal_of_row * p)
        if self.compliance.coupling != 0.0:
            section = section + 1j * self._of(SN) * self._transform(self._tangent * p)
        u = self._back(np.concatenate([along[None], section]) * ahead)
        return np.stack([u[0], (self._tangent * u[1:]).sum(axis=0)])

    def _under_tractions(self, q: Array) -> tuple[Spectrum, Spectrum]:
        """Transforms of the displacements along x, and in the section (o, b), under turned tractions."""
        t = self._tangent
        f = self._transform(np.concatenate([q, t * q[0], t * q[1]]))
        x: Spectrum = self._of(XX) * f[0] + self._of(XS) * f[1]
        section: Spectrum = self._of(XS) * f[2:4] + self._of(SS) * f[4:6]
        if self.compliance.coupling != 0.0:
            g = self._transform(np.concatenate([self._normal_of_row * q[0], self._normal_of_row * q[1]]))
            section = section - 1j * (self._of(XN) * g[0:2] + self._of(SN) * g[2:4])
        return x, section

    def self_slip(self) -> float:
        """Largest slip that an element's own traction brings about, over that traction [1/Pa]."""
        own = _integrals(round(self.ds / self.dx, 9), 64, 64)[:, :2, 0]
        c = self.compliance
        along = (XX, SS)
        return max(c.normal * (own[NN, 0] - own[NN, 1]) + c.tangential * (own[k, 0] - own[k, 1]) for k in along)


def _frames(angles: Array | None) -> tuple[Array, Array]:
    """Tangents and normals of the rows in (o, b), (2, rows, 1)."""
    a = np.zeros(1) if angles is None else np.asarray(angles, dtype=np.float64)
    cos, sin = np.cos(a)[:, None], np.sin(a)[:, None]
    return np.stack([cos, sin]), np.stack([-sin, cos])


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
