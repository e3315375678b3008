"""Tractions to displacements of a half-space on a grid, by convolution in Fourier space.

Displacements are those of the wheel relative to the rail, tractions act on the wheel: p along the row's normal n (from
rail to wheel), q_x along the rail, q_s along the row's tangent t.

The integrals under a uniformly loaded rectangle, the constants of both bodies, and the kernel that is turned by the
angle between the normals are those of docs/theory/half_space.md. All integrals have the dimension of a length and scale
with the element: they are computed once for each shape of element, their transforms once for each size of grid. Written
in the axes (o, b) of the section the turned kernel is a sum of plain convolutions.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, wraps
from math import pi
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from wrsim.contact.settings import Material
from wrsim.jit import Array

Spectrum = NDArray[np.complexfloating]

NN, XX, SS, XS, XN, SN = range(6)
"""Kernels: A_nn, A_xx, A_ss, A_xs, A_xn, A_sn."""
ODD_IN_S, ODD_IN_X = (XS, SN), (XS, XN)
MARGIN = 6  # elements by which the period of the inverse is larger than the grid


@dataclass(frozen=True)
class Compliance:
    """Constants of two bodies, c_n, c_t, c_k [1/Pa]; c_k is rail minus wheel. layer: shear of a layer between them over
    the traction [m/Pa]."""

    normal: float
    tangential: float
    coupling: float
    layer: float = 0.0

    @classmethod
    def of(cls, wheel: Material, rail: Material, layer: float = 0.0) -> "Compliance":
        materials = (wheel, rail)
        k_wheel, k_rail = ((1.0 - 2.0 * m.poisson_ratio) / m.shear_modulus for m in materials)
        return cls(
            sum((1.0 - m.poisson_ratio) / m.shear_modulus for m in materials) / (2.0 * pi),
            sum(m.poisson_ratio / m.shear_modulus for m in materials) / (2.0 * pi),
            (k_rail - k_wheel) / (4.0 * pi),
            layer,
        )

    @property
    def modulus(self) -> float:
        """E* [Pa]."""
        return 1.0 / (pi * self.normal)


def integrals(x: Array, s: Array) -> Array:
    """Integrals over an element, (6, n, m), seen from points so far from its centre that its corners are at x (n + 1,)
    and s (m + 1,) from them; no corner has a coordinate 0."""
    x, s = np.broadcast_arrays(x[:, None], s)
    along_x, along_s = s * np.arcsinh(x / np.abs(s)), x * np.arcsinh(s / np.abs(x))
    r = np.hypot(x, s)
    ln = np.log(r)
    # atan(s / x) as an odd function of both: no jump where x changes sign within an element
    angle, complement = np.arctan2(s, np.abs(x)), np.arctan2(x, np.abs(s))
    primitive = along_x + along_s, along_x, along_s, -r, np.abs(x) * angle + s * ln, np.abs(s) * complement + x * ln
    return np.diff(np.diff(primitive, axis=1), axis=2)


@lru_cache(maxsize=16)
def _integrals(ratio: float, size: int) -> Array:
    """Integrals (6, x, s) at ``size`` non-negative offsets either way, for elements 1 x ratio."""
    corners: Array = np.arange(size + 1, dtype=np.float64) - 0.5
    return integrals(corners, ratio * corners)


@lru_cache(maxsize=64)
def _spectrum(kind: int, ratio: float, rows: int, columns: int, period: tuple[int, int]) -> Array:
    """Transform of one integral for a grid, elements 1 x ratio: real, or the imaginary part of an imaginary one."""
    size = 64
    while size <= max(rows, columns):
        size *= 2
    # one column more than the grid has: the slip looks one element ahead
    quarter = _integrals(ratio, size)[kind, : columns + 1, :rows].T
    odd_s, odd_x = kind in ODD_IN_S, kind in ODD_IN_X
    full = np.zeros(period)
    full[:rows, : columns + 1] = quarter
    full[1 - rows :, : columns + 1] = quarter[:0:-1] * (-1.0 if odd_s else 1.0)
    full[:, -columns:] = full[:, columns:0:-1] * (-1.0 if odd_x else 1.0)
    transform = scipy.fft.rfft2(full)
    return np.ascontiguousarray(transform.imag if odd_s != odd_x else transform.real)


class _Fourier:
    """Transforms of fields on (rows, columns) elements, padded to the next period that is quick to transform."""

    def __init__(self, rows: int, columns: int, period_s: int, period_x: int) -> None:
        self.rows, self.columns = rows, columns
        self.period = scipy.fft.next_fast_len(period_s, True), scipy.fft.next_fast_len(period_x, True)

    def to(self, field: Array) -> Spectrum:
        along = scipy.fft.rfft(field, self.period[1], axis=-1)
        return scipy.fft.fft(along, self.period[0], axis=-2, overwrite_x=True)

    def back(self, spectrum: Spectrum) -> Array:
        cut = scipy.fft.ifft(spectrum, axis=-2, overwrite_x=True)[..., : self.rows, :]
        return scipy.fft.irfft(cut, self.period[1], axis=-1)[..., : self.columns]


def _over_groups(act: Callable[..., Array]) -> Callable[..., Array]:
    """What all groups of rows do to all rows, from what a field does."""

    @wraps(act)
    def summed(self: Any, q: Array, *arguments: float) -> Array:
        if not self.shares:
            return act(self, q, *arguments)
        total = self.shares[0][1] * act(self, self.shares[0][0] * q, *arguments)
        for share, influence in self.shares[1:]:
            total += influence * act(self, share * q, *arguments)
        return total

    return summed


@dataclass(frozen=True, eq=False)
class Operator:
    """Influence of tractions on (rows, columns) elements ds x dx upon each other. angles: of the rows' normals [rad]
    for the angle-corrected kernel, or None for the plain one. shares: for groups of rows whose mutual influence is
    weakened, the rows of each group and its influence on all rows, both (rows, 1)."""

    rows: int
    columns: int
    ds: float
    dx: float
    compliance: Compliance
    angles: Array | None = None
    shares: Sequence[tuple[Array, Array]] = ()

    @property
    def coupled(self) -> bool:
        """Whether pressures make tangential, and tractions normal displacements."""
        return self._turned or self._unequal

    @_over_groups
    def normal(self, p: Array) -> Array:
        """Normal displacements under the pressures p [Pa], (rows, columns) [m]."""
        if self._turned:
            return self._along_normal(self._section_under_pressures(p))
        f = self._fourier.to(p)
        f *= self._spectra[NN]
        return self._fourier.back(f)

    @_over_groups
    def slip(self, q: Array, forward: float) -> Array:
        """Slip over the rolling speed, (2, rows, columns), that the tractions q bring about."""
        if self._turned:
            return self._slip_of(self._under_tractions(q), forward)
        a, (x, s) = self._spectra, self._fourier.to(q)
        return self._difference(np.stack([a[XX] * x + a[XS] * s, a[XS] * x + a[SS] * s]), forward)

    @_over_groups
    def normal_of_tractions(self, q: Array) -> Array:
        """Normal displacements under tangential tractions (rows, columns) [m]; zero unless ``coupled``."""
        if not self.coupled:
            return np.zeros(q.shape[1:])
        if self._turned:
            return self._along_normal(self._under_tractions(q)[1:])
        x, s = self._fourier.to(q)
        return self._fourier.back(-1j * (self._spectra[XN] * x + self._spectra[SN] * s))

    @_over_groups
    def slip_of_pressure(self, p: Array, forward: float) -> Array:
        """Slip over the rolling speed that the pressures bring about; zero unless ``coupled``."""
        if not self.coupled:
            return np.zeros((2, *p.shape))
        f = 1j * self._fourier.to(p)
        along = self._spectra[XN] * f if self._unequal else np.zeros_like(f)
        if self._turned:
            return self._slip_of(np.concatenate([along[None], self._section_under_pressures(p)]), forward)
        return self._difference(np.stack([along, self._spectra[SN] * f]), forward)

    def self_slip(self) -> float:
        """Largest slip that an element's own traction brings about, over that traction [1/Pa]."""
        integrals = _integrals(self._ratio, 64)[:, :2, 0]
        fall, c = integrals[:, 0] - integrals[:, 1], self.compliance
        return float(c.normal * fall[NN] + c.tangential * max(fall[XX], fall[SS])) + c.layer / self.dx

    @cached_property
    def inverse(self) -> "Inverse":
        return Inverse(self)

    @cached_property
    def _ratio(self) -> float:
        return round(self.ds / self.dx, 9)

    @property
    def _turned(self) -> bool:
        return self.angles is not None

    @property
    def _unequal(self) -> bool:
        return self.compliance.coupling != 0.0

    @cached_property
    def _fourier(self) -> _Fourier:
        return _Fourier(self.rows, self.columns, 2 * self.rows - 1, 2 * self.columns + 1)

    @cached_property
    def _frames(self) -> tuple[Array, Array]:
        """Tangents and normals of the rows in (o, b), (2, rows, 1)."""
        angles = np.zeros((1, 1)) if self.angles is None else np.asarray(self.angles, dtype=np.float64)[:, None]
        cos, sin = np.cos(angles), np.sin(angles)
        return np.stack([cos, sin]), np.stack([-sin, cos])

    @cached_property
    def _spectra(self) -> dict[int, Array]:
        """Spectra of A_nn, A_xx, A_ss, A_xs, and, of unequal materials, the imaginary parts of those of A_xn, A_sn."""
        c = self.compliance
        factors = {NN: c.normal, XX: c.tangential, SS: c.tangential, XS: c.tangential}
        if self._unequal:
            factors |= {XN: c.coupling, SN: c.coupling}
        spectra = {
            kind: self.dx * factor * _spectrum(kind, self._ratio, self.rows, self.columns, self._fourier.period)
            for kind, factor in factors.items()
        }
        for kind in (XX, SS):
            spectra[kind] += spectra[NN]
            if c.layer > 0.0:
                spectra[kind] += c.layer
        return spectra

    @cached_property
    def _differences(self) -> tuple[Spectrum, Spectrum]:
        """Take u(x) to (u(x) - u(x + forward dx)) / dx, for forward = 1 and -1."""
        ahead = (1.0 - np.exp(2j * pi * scipy.fft.rfftfreq(self._fourier.period[1]))) / self.dx
        return ahead, ahead.conj()

    def _section_under_pressures(self, p: Array) -> Spectrum:
        """Transform of the displacements (o, b) under turned pressures."""
        t, n = self._frames
        section: Spectrum = self._spectra[NN] * self._fourier.to(n * p)
        if self._unequal:
            section += 1j * self._spectra[SN] * self._fourier.to(t * p)
        return section

    def _under_tractions(self, q: Array) -> Spectrum:
        """Transform of the displacements (x, o, b) under turned tractions."""
        t, n = self._frames
        a, f = self._spectra, self._fourier.to(np.concatenate([q, t * q[0], t * q[1]]))
        u: Spectrum = np.concatenate([[a[XX] * f[0] + a[XS] * f[1]], a[XS] * f[2:4] + a[SS] * f[4:6]])
        if self._unequal:
            g = self._fourier.to(np.concatenate([n * q[0], n * q[1]]))
            u[1:] -= 1j * (a[XN] * g[0:2] + a[SN] * g[2:4])
        return u

    def _along_normal(self, section: Spectrum) -> Array:
        return np.asarray((self._frames[1] * self._fourier.back(section)).sum(axis=0))

    def _slip_of(self, u: Spectrum, forward: float) -> Array:
        x, *section = self._difference(u, forward)
        return np.stack([x, (self._frames[0] * section).sum(axis=0)])

    def _difference(self, u: Spectrum, forward: float) -> Array:
        """Slip from the transforms of displacements."""
        u *= self._differences[0 if forward > 0.0 else 1]
        return self._fourier.back(u)


class Inverse:
    """Inverse symbols of the half-space on a periodic grid hardly larger than the patch: preconditioners. Over the wave
    number k a half-space gives way by (1 - nu)/(G |k|) normal to its surface and along k, by 1/(G |k|) across; a layer
    adds its flexibility to both of the latter."""

    def __init__(self, operator: Operator) -> None:
        o, c = operator, operator.compliance
        self._fourier = _Fourier(o.rows, o.columns, o.rows + MARGIN, o.columns + MARGIN)
        period_s, period_x = self._fourier.period
        kx = 2.0 * pi * scipy.fft.rfftfreq(period_x, o.dx)
        ks = 2.0 * pi * scipy.fft.fftfreq(period_s, o.ds)[:, None]
        k = np.hypot(kx, ks)
        k[0, 0] = 4.0 / max(period_s * o.ds, period_x * o.dx)
        along = k / (2.0 * pi * c.normal)
        across = k / (2.0 * pi * (c.normal + c.tangential))
        self._normal = along
        along, across = along / (1.0 + c.layer * along), across / (1.0 + c.layer * across)
        self._xx = (along * kx**2 + across * ks**2) / k**2
        self._ss = (along * ks**2 + across * kx**2) / k**2
        self._xs = (along - across) * kx * ks / k**2
        self._xx[0, 0] = self._ss[0, 0] = across[0, 0]

    def pressure(self, u: Array) -> Array:
        """Roughly the pressures that make the normal displacements u, (rows, columns)."""
        f = self._fourier.to(u)
        f *= self._normal
        return self._fourier.back(f)

    def traction(self, u: Array) -> Array:
        """Roughly the tractions that make the tangential displacements u, (2, rows, columns)."""
        x, s = self._fourier.to(u)
        return self._fourier.back(np.stack([self._xx * x + self._xs * s, self._xs * x + self._ss * s]))
