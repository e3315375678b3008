"""Ride: accelerations at points of a vehicle, their power spectra, third-octaves and comfort (EN 12299 [mem]).

``evaluate_ride(result) -> Ride`` is a pure function of a result.

The frequency weighting (ISO 8041-1, as ISO 2631-1, ISO 2631-4 and EN 12299 use it) is the transfer function

    H(s) = K H_high(s) H_low(s) H_transition(s) H_step(s)
    H_high = 1/(1 + w1/(Q1 s) + (w1/s)^2),   H_low = 1/(1 + s/(Q2 w2) + (s/w2)^2),   Q1 = Q2 = 1/sqrt 2
    H_transition = (1 + s/w3)/(1 + s/(Q4 w4) + (s/w4)^2)
    H_step = (1 + s/(Q5 w5) + (s/w5)^2)/(1 + s/(Q6 w6) + (s/w6)^2) (w5/w6)^2

with the parameters of ISO 8041 [pub: table in the manual of a vibration meter that quotes it]. Rail vehicles: Wb
vertically and Wd horizontally (EN 12299); ISO 2631-1 has Wk vertically instead of Wb, Wc at the backrest.

Signals are weighted in the frequency domain, with the analogue H itself: no warping near half the sampling rate.
"""

from dataclasses import dataclass
from math import inf, pi
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.signal import welch

from wrsim.errors import InputError
from wrsim.inputs.checking import check_section
from wrsim.results import Result
from wrsim.results.dataset import table_of_scenario
from wrsim.results.filters import on_raster, sampling_rate
from wrsim.results.ride import AXES, Ride
from wrsim.scenario.sections.run import RideSection, StretchTable

Array = NDArray[np.float64]
Name = Literal["Wb", "Wc", "Wd", "We", "Wj", "Wk"]


RESOLUTION = 0.1
"""Frequency resolution wanted [Hz]; a run is cut into segments of 1/RESOLUTION seconds that overlap by half."""

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
class RideBands:
    """Third-octave bands: nominal middle frequencies [Hz], edges [Hz], rms (bands, ...) [unit]."""

    nominal: tuple[float, ...]
    low: Array
    high: Array
    rms: Array


_NOMINAL = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)


def third_octaves(spectrum: Spectrum, lowest: float = 0.4) -> RideBands:
    """rms in third-octave bands (IEC 61260: middles 10^(k/10) Hz) from a frequency [Hz] to half the sampling rate.

    A band narrower than the resolution of the spectrum is left out.
    """
    k = np.arange(-30, 51)
    middle = 10.0 ** (k / 10.0)
    low, high = middle * 10.0**-0.05, middle * 10.0**0.05
    retained = (
        (middle >= lowest * 0.99) & (high <= spectrum.frequency[-1] * 1.0001) & (high - low >= spectrum.frequency[1])
    )
    rms = [spectrum.rms(a, b) for a, b in zip(low[retained], high[retained], strict=True)]
    nominal = tuple(float(f"{_NOMINAL[i % 10] * 10.0 ** (i // 10):.6g}") for i in k[retained])
    return RideBands(nominal, low[retained], high[retained], np.array(rms))


SETTLING = 10.0  # seconds of nothing behind a signal, in which the weighting's slowest part (0.4 Hz) dies away


@dataclass(frozen=True)
class Weighting:
    """Parameters of the transfer function: corner frequencies [Hz], quality factors, gain."""

    f3: float
    f4: float
    q4: float
    f5: float = inf
    q5: float = 1.0
    f6: float = inf
    q6: float = 1.0
    gain: float = 1.0
    f1: float = 0.4
    f2: float = 100.0

    def response(self, frequency: Array) -> NDArray[np.complex128]:
        """H at frequencies [Hz] above 0; 0 at 0."""
        s = 2j * pi * np.where(frequency > 0.0, frequency, 1.0)

        def quadratic(f: float, q: float) -> NDArray[np.complex128]:
            w = 2.0 * pi * f
            return np.asarray(1.0 + s / (q * w) + (s / w) ** 2)

        w1 = 2.0 * pi * self.f1
        value = self.gain / (1.0 + 2.0**0.5 * w1 / s + (w1 / s) ** 2) / quadratic(self.f2, 0.5**0.5)
        if self.f4 != inf:
            value = value * (1.0 + s / (2.0 * pi * self.f3)) / quadratic(self.f4, self.q4)
        if self.f6 != inf:
            value = value * quadratic(self.f5, self.q5) / quadratic(self.f6, self.q6) * (self.f5 / self.f6) ** 2
        return np.asarray(np.where(frequency > 0.0, value, 0.0))


WEIGHTINGS: dict[Name, Weighting] = {
    "Wb": Weighting(16.0, 16.0, 0.55, 2.5, 0.9, 4.0, 0.95, gain=1.024),
    "Wc": Weighting(8.0, 8.0, 0.63),
    "Wd": Weighting(2.0, 2.0, 0.63),
    "We": Weighting(1.0, 1.0, 0.63),
    "Wj": Weighting(inf, inf, 1.0, 3.75, 0.91, 5.32, 0.91),
    "Wk": Weighting(12.5, 12.5, 0.63, 2.37, 0.91, 3.35, 0.91),
}


def weighted(signal: Array, rate: float, name: Name) -> Array:
    """The signal (n, ...) with its frequencies weighted; rate: samples a second."""
    n = next_fast_len(signal.shape[0] + int(SETTLING * rate), real=True)
    h = WEIGHTINGS[name].response(rfftfreq(n, 1.0 / rate)).reshape(-1, *(1,) * (signal.ndim - 1))
    return np.asarray(irfft(rfft(signal, n, axis=0) * h, n, axis=0)[: signal.shape[0]])


BLOCK = 5.0  # length of a block [s]
AXIS_WEIGHTINGS: dict[str, Name] = {"x": "Wd", "y": "Wd", "z": "Wb"}
PERCENTILE = 95.0


@dataclass(frozen=True, eq=False)
class Comfort:
    """Weighted rms over the whole run by axis, and over every block of 5 s (blocks, 3), all of one point.

    weighted_rms [m/s2]: x, y, z. continuous (C_Cx, C_Cy, C_Cz) [m/s2] of every block; the standard asks for sixty
    blocks, five minutes. percentiles: 95 % of the blocks, by axis; not-a-number for a run shorter than a block. mean:
    N_MV = 6 sqrt(sum of the squares of the percentiles).
    """

    weighted_rms: Array
    continuous: Array
    percentiles: Array
    mean: float


def comfort(acceleration: Array, rate: float) -> Comfort:
    """Comfort at one point; acceleration (n, 3) along x, y, z [m/s2], rate: samples a second."""
    signals = np.column_stack(
        [weighted(acceleration[:, i], rate, name) for i, name in enumerate(AXIS_WEIGHTINGS.values())]
    )
    length = round(BLOCK * rate)
    count = signals.shape[0] // length
    blocks = signals[: count * length].reshape(count, length, 3)
    continuous = np.sqrt((blocks**2).mean(axis=1))
    percentiles = np.percentile(continuous, PERCENTILE, axis=0) if count else np.full(3, np.nan)
    mean = 6.0 * float(np.sqrt((percentiles**2).sum()))
    return Comfort(np.sqrt((signals**2).mean(axis=0)), continuous, percentiles, mean)


def evaluate_ride(result: Result, section: RideSection | None = None) -> Ride:
    """Spectra, third-octaves and comfort at all points of a vehicle.

    section: stretch and resolution, by default [ride] of the scenario that the result carries. Raises InputError for
    a result without points, with too few or unevenly spaced samples, or none on the stretch.
    """
    dataset, section = result.dataset, section or ride_section_of(result)
    if "point_ay" not in dataset:
        raise InputError("the result has no points: accelerations are stored at the [[points]] of a vehicle file")
    part = stretch_of(dataset, section)
    rate = sampling_rate(part["time"].values)
    acceleration = np.stack([part[f"point_a{a}"].transpose("time", "point").values for a in AXES], axis=-1)
    spectra = spectrum(acceleration, rate, section.resolution_Hz)
    bands = third_octaves(spectra)
    each = [comfort(acceleration[:, i], rate) for i in range(acceleration.shape[1])]
    dims = ("point", "axis")
    data = xr.Dataset(
        {
            "density": (("frequency", *dims), spectra.density),
            "band_rms": (("band", *dims), bands.rms.reshape(-1, *acceleration.shape[1:])),
            "band_low": ("band", bands.low),
            "band_high": ("band", bands.high),
            "rms": (dims, acceleration.std(axis=0)),
            "peak": (dims, np.abs(acceleration).max(axis=0)),
            "weighted_rms": (dims, np.stack([c.weighted_rms for c in each])),
            "comfort_95": (dims, np.stack([c.percentiles for c in each])),
            "N_MV": ("point", [c.mean for c in each]),
        },
        coords={
            "frequency": spectra.frequency,
            "band": np.array(bands.nominal),
            "point": [str(p) for p in part["point"].values],
            "axis": list(AXES),
        },
        attrs={"blocks": len(each[0].continuous), "weightings": " ".join(AXIS_WEIGHTINGS[a] for a in AXES)},
    )
    times, places = part["time"].values, part["distance"].values
    return Ride(result.title, float(places[0]), float(places[-1]), float(times[-1] - times[0]), spectra.segments, data)


def stretch_of(dataset: xr.Dataset, section: StretchTable) -> xr.Dataset:
    """The samples of a run on a stretch. Raises InputError where there are none."""
    dataset = on_raster(dataset)
    distance = dataset["distance"].values
    low = -inf if section.from_m is None else section.from_m
    high = inf if section.to_m is None else section.to_m
    inside = (distance >= low - 1e-6) & (distance <= high + 1e-6)
    if not inside.any():
        limits = ", ".join(f"{key} = {end:g}" for key, end in (("from_m", low), ("to_m", high)) if abs(end) < inf)
        raise InputError(
            f"{limits}: the run has no samples there; it goes from {distance[0]:z.2f} to {distance[-1]:z.2f} m"
        )
    return dataset.isel(time=np.flatnonzero(inside))


def ride_section_of(result: Result) -> RideSection:
    """[ride] of the scenario that the result carries; the defaults where it has none."""
    return check_section(RideSection, table_of_scenario(result.dataset, "ride") or {}, lambda path: "[ride]")
