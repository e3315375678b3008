"""Power spectral densities and third-octave levels of accelerations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from wrsim.errors import InputError

Array = NDArray[np.float64]

RESOLUTION = 0.1
"""Frequency resolution asked for [Hz]; a run is cut into segments of 1/RESOLUTION seconds that overlap by half."""

LEAST_SEGMENTS = 3  # segments below which a spectrum is too uncertain; the resolution gives way instead


@dataclass(frozen=True, eq=False)
class Spectrum:
    """One-sided power spectral density: frequency (m,) [Hz], density (m, ...) [unit^2/Hz]; segments averaged."""

    frequency: Array
    density: Array
    segments: int

    def rms(self, low: float = 0.0, high: float = np.inf) -> Array:
        """Root of the power between two frequencies [Hz]; bands may end between the lines of the spectrum."""
        return np.sqrt(np.maximum(self._power(high) - self._power(low), 0.0))

    def _power(self, frequency: float) -> Array:
        """Power below a frequency. Every line covers the band of half a resolution on both sides of it."""
        step = self.frequency[1]
        edges = np.clip(self.frequency[:, None] + step * np.array([-0.5, 0.5]), 0.0, self.frequency[-1])
        share = np.clip(frequency - edges[:, 0], 0.0, edges[:, 1] - edges[:, 0])
        return np.asarray(np.tensordot(share, self.density, axes=1))


def spectrum(signal: Array, rate: float, resolution: float = RESOLUTION) -> Spectrum:
    """Spectrum of a signal (n, ...) by Welch's method: Hann windows, overlap of half, mean of every segment removed.

    rate: samples a second. Segments are shortened until there are three. Raises InputError for too short a signal.
    """
    n = signal.shape[0]
    longest = 2 * n // (LEAST_SEGMENTS + 1)
    length = min(round(rate / resolution), longest)
    if length < 16:
        raise InputError(f"the run has {n} samples: too few for a spectrum")
    frequency, density = welch(signal, rate, "hann", length, length // 2, detrend="constant", axis=0)
    return Spectrum(frequency, density, 1 + (n - length) // (length - length // 2))


@dataclass(frozen=True, eq=False)
class Bands:
    """Third-octave bands: nominal middle frequencies [Hz], edges [Hz], rms (bands, ...) [unit]."""

    nominal: tuple[float, ...]
    low: Array
    high: Array
    rms: Array


_NOMINAL = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)


def third_octaves(spectrum: Spectrum, lowest: float = 0.4) -> Bands:
    """rms in third-octave bands (IEC 61260: middles 10^(k/10) Hz) from a frequency [Hz] to half the sampling rate.

    A band narrower than the resolution of the spectrum is left out.
    """
    k = np.arange(-30, 51)
    middle = 10.0 ** (k / 10.0)
    low, high = middle * 10.0**-0.05, middle * 10.0**0.05
    kept = (middle >= lowest * 0.99) & (high <= spectrum.frequency[-1] * 1.0001) & (high - low >= spectrum.frequency[1])
    rms = [spectrum.rms(a, b) for a, b in zip(low[kept], high[kept], strict=True)]
    nominal = tuple(float(f"{_NOMINAL[i % 10] * 10.0 ** (i // 10):.6g}") for i in k[kept])
    return Bands(nominal, low[kept], high[kept], np.array(rms))
