"""The transfer functions of a recording car's systems over the wavelength, and their inverse.

A system is linear: a wave of wave number k [rad/m] in the shape y(s) has in the record the amplitude H(k), a complex
number (docs/user/recording.md has that of a chord). A difference over a base l (twist) has H = 1 - exp(-i k l). A
record is inverted by 1 / H, where 1.1 / |H| is not above the largest amplification allowed; where |H| is less, down to
a third, the inverse fades to nothing. So no wave of the record, and none of its noise, is enlarged by more. The slower
a filter fades over the wavelengths, the less far reaches the record's unknown continuation.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from wrsim.recording.dropouts import runs
from wrsim.track.irregularities import smooth_step
from wrsim.track.piecewise import Array

Complex = NDArray[np.complex128]
Response = Callable[[Array], Complex]

SKIRTS = (1.25, 1.6)  # ratios of wavelengths over which a band fades to nothing, at its short and at its long end
FADE = 3.0  # ratio of |H| over which an inverse fades to nothing
SPARE = 1.1  # keeps the fading inverse below the largest amplification, too
BANDS = {"D1": (3.0, 25.0), "D2": (25.0, 70.0), "D3": (70.0, 150.0)}
"""Wavelengths of EN 13848-1 [m]; D3 for lateral shapes to 200 m."""
PADDING = 4.0  # how far a record is continued at its ends for filtering, in longest wavelengths
COUNTED = 4000  # wavelengths at which an inverse is looked at for what it does


@dataclass(frozen=True)
class Chord:
    """A chord that reaches a behind the measuring point and b ahead of it [m]."""

    behind: float
    ahead: float

    @property
    def reach(self) -> float:
        """How far the track reaches into its record [m]."""
        return self.behind + self.ahead

    def response(self, k: Array) -> Complex:
        """H(k) at wave numbers [rad/m]."""
        a, b = self.behind, self.ahead
        return np.asarray(1.0 - (b * np.exp(-1j * k * a) + a * np.exp(1j * k * b)) / (a + b))

    def of_curvature(self, k: Array) -> Complex:
        """Response to a curvature y'' [1/m]: -H(k) / k^2 [m2], at k = 0 its limit."""
        a, b = self.behind, self.ahead
        series = -0.5 * a * b + 1j * k * a * b * (a - b) / 6.0  # of long waves, where the difference loses its digits
        short = k * (a + b) > 1e-3
        return np.where(short, -self.response(k) / np.where(short, k, 1.0) ** 2, series)


@dataclass(frozen=True)
class BaseDifference:
    """The value at a point less that a base behind it [m]."""

    base: float

    def response(self, k: Array) -> Complex:
        return np.asarray(1.0 - np.exp(-1j * k * self.base))


@dataclass(frozen=True)
class Inertial:
    """The shape within a band of wavelengths [m].

    By two Butterworth filters of fourth order, run forward and back for zero phase: half of it at the borders. Other
    cars' filters differ beyond the borders, where most of the curves' share lies.
    """

    short: float
    long: float

    @property
    def reach(self) -> float:
        return self.long

    def response(self, k: Array) -> Complex:
        shorter, longer = k * self.short / (2.0 * np.pi), k * self.long / (2.0 * np.pi)
        return (longer**8 / (1.0 + longer**8) / (1.0 + shorter**8)).astype(complex)

    def of_curvature(self, k: Array) -> Complex:
        return np.where(k > 0.0, -self.response(k) / np.where(k > 0.0, k, 1.0) ** 2, 0.0)


@dataclass(frozen=True)
class Plain:
    """The shape itself, such as gauge and cant."""

    def response(self, k: Array) -> Complex:
        return np.ones(k.shape, dtype=complex)


ShapeSystem = Chord | Inertial  # measures the shape of a rail
MeasuringSystem = ShapeSystem | BaseDifference | Plain


@dataclass(frozen=True)
class InverseFilter:
    """From the record of a system to the shape of the rail.

    band: wavelengths wanted [m], the longer may be infinite; amplification: largest factor of a wave of the record.
    """

    system: MeasuringSystem
    band: tuple[float, float]
    amplification: float

    def response(self, k: Array) -> Complex:
        """Factor of a wave of the record at wave numbers [rad/m]."""
        wanted = band_window(k, self.band)
        if isinstance(self.system, Inertial | Plain):
            return wanted.astype(complex)
        h = self.system.response(k)
        size = np.abs(h)
        known = smooth_step((FADE * size * self.amplification / SPARE - 1.0) / (FADE - 1.0))
        return np.where(size > 0.0, wanted * known / np.where(size > 0.0, h, 1.0), 0.0)

    def kept(self) -> Array:
        """Ranges of wavelengths that come back unchanged, (n, 2) [m], the shortest first."""
        lengths = self._wavelengths()
        if isinstance(self.system, Inertial):
            whole = (lengths >= self.system.short) & (lengths <= self.system.long)
        else:
            k = 2.0 * np.pi / lengths
            whole = np.abs(self.response(k) * self.system.response(k)) > 1.0 - 1e-9
        return np.array([(lengths[i], lengths[j - 1]) for i, j in runs(whole)]).reshape(-1, 2)

    def largest(self) -> float:
        """Largest factor of a wave of the record, or of its noise."""
        return float(np.abs(self.response(2.0 * np.pi / self._wavelengths())).max())

    def noise(self, step: float) -> float:
        """Standard deviation of the result over that of white noise in a record with rows every so many m."""
        k = np.linspace(0.0, np.pi / step, COUNTED)
        return float(np.sqrt(np.mean(np.abs(self.response(k)) ** 2)))

    def _wavelengths(self) -> Array:
        short, long = self.band
        return np.geomspace(short, min(long, 1e4), COUNTED)


def band_window(k: Array, band: tuple[float, float]) -> Array:
    """1 for wave numbers [rad/m] within a band of wavelengths [m], falling smoothly to 0 over `SKIRTS` outside."""
    turns = np.abs(k) / (2.0 * np.pi)
    short, long = (np.log(skirt) for skirt in SKIRTS)
    with np.errstate(divide="ignore"):
        log = np.log(turns)
    below = smooth_step(1.0 - (log + np.log(band[0])) / short)
    return below if np.isinf(band[1]) else below * smooth_step(1.0 + (log + np.log(band[1])) / long)


def filtered(values: Array, step: float, response: Response, longest: float, *, held: bool = False) -> Array:
    """A record (n,) with rows every ``step`` [m] behind a response; longest: wavelength [m] that it knows.

    At its ends the record is continued by its mirror image or, ``held``, by the end's value.
    """
    n = values.size
    extra = int(PADDING * longest / step) + 1
    whole = next_fast_len(n + 2 * extra, real=True)
    pad = (extra, whole - n - extra)
    wide = np.pad(values, pad, mode="edge") if held else np.pad(values, pad, mode="reflect")
    k = 2.0 * np.pi * rfftfreq(whole, step)
    return np.asarray(irfft(rfft(wide) * response(k), whole)[extra : extra + n])
