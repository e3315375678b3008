"""Spectra of a channel of a run: power spectral density, third-octaves, and how it changes along the track.

``evaluate_spectra(result, "Q") -> Dataset`` is a pure function of a result. Density and third-octaves are those of
``wrsim.analysis.ride``. Derivatives are taken in the frequency domain: the density of the k-th one is (2 pi f)^(2 k)
times that of the channel.
"""

from dataclasses import replace

import numpy as np
import xarray as xr
from scipy.signal import spectrogram

from wrsim.analysis.ride import Array, spectrum, stretch_of, third_octaves
from wrsim.errors import InputError
from wrsim.inputs.checking import check_section
from wrsim.results import CHANNELS, Result
from wrsim.results.channels import NAMES
from wrsim.results.filters import sampling_rate
from wrsim.results.spectra import ORDERS
from wrsim.results.wheelsets import fast_of
from wrsim.scenario.sections.run import StretchTable

LEAST_LINES = 16  # samples of a piece of the spectrogram at least


def evaluate_spectra(
    result: Result, channel: str, derivative: int = 0, stretch: tuple[float | None, float | None] = (None, None),
    resolution: float = 2.0, piece: float = 2.0,
) -> xr.Dataset:  # fmt: skip
    """Spectra of a channel over time, of the fast one where it is stored: see `wrsim.api.analyses.spectra`.

    stretch, piece [m]; resolution [Hz]. Raises InputError for a name that is no such channel of the result, for numbers
    that cannot be, and for too few or unevenly spaced samples.
    """
    if derivative not in range(len(ORDERS)) or not (resolution > 0.0 and piece > 0.0):
        settings = f"derivative = {derivative}, resolution_Hz = {resolution:g}, piece_m = {piece:g}"
        raise InputError(f"{settings}: derivative must be 0, 1 or 2, the others above 0")
    dataset = result.dataset
    fast = [str(n).removeprefix("fast_") for n in dataset.data_vars if str(n).startswith("fast_")]
    names = [str(n) for n, variable in dataset.data_vars.items() if variable.dims[:1] == ("time",)]
    known = [n for n in dict.fromkeys([*fast, *names]) if CHANNELS[n].kind == "number"]
    if (name := (channels := NAMES.among(known)).understood(channel.removeprefix("fast_"))) is None:
        raise InputError(f"channel '{channel}' {channels.unknown(channel)} (of those over time)")
    channel = name
    ends = {key: place for key, place in zip(("from_m", "to_m"), stretch, strict=True) if place is not None}
    section = check_section(StretchTable, ends, lambda path: "spectra")
    part = stretch_of(fast_of(dataset) if channel in fast else dataset, section)
    signal, time, distance = part[channel], part["time"].values, part["distance"].values
    if not np.isfinite(signal.values).all():
        raise InputError(f"{channel} is not a number somewhere on the stretch: it has no spectrum")
    rate, dims = sampling_rate(time), signal.dims[1:]
    spectra = spectrum(signal.values, rate, resolution)
    speed = (distance[-1] - distance[0]) / (time[-1] - time[0])
    length = len(time) // 4
    if speed > 0.0:
        length = max(min(round(rate * piece / speed), length), LEAST_LINES)
    lines, middles, pieces = spectrogram(signal.values, rate, "hann", length, length // 2, detrend="constant", axis=0)

    def power(frequency: Array) -> Array:
        return np.asarray((2.0 * np.pi * frequency) ** (2 * derivative)).reshape(-1, *(1,) * len(dims))

    spectra = replace(spectra, density=spectra.density * power(spectra.frequency))
    bands = third_octaves(spectra, spectra.frequency[1])
    unit = CHANNELS[channel].unit
    return xr.Dataset(
        {
            "density": (("frequency", *dims), spectra.density),
            "band_rms": (("band", *dims), bands.rms.reshape(-1, *signal.shape[1:])),
            "band_low": ("band", bands.low),
            "band_high": ("band", bands.high),
            "rms": (dims, spectra.rms() if derivative else signal.values.std(axis=0)),
            "spectrogram": (("place", "line", *dims), np.moveaxis(pieces, -1, 0) * power(lines)),
        },
        coords={
            "frequency": spectra.frequency,
            "band": np.array(bands.nominal),
            "line": lines,
            "place": np.interp(time[0] + middles, time, distance),
            **{dim: signal[dim].values for dim in (*dims, "wheelset") if dim in signal.coords},
        },
        attrs={
            "title": result.title, "channel": channel, "derivative": derivative, "segments": spectra.segments,
            "unit": unit if derivative == 0 else f"{unit}/s" + (f"{derivative}" if derivative > 1 else ""),
            "from_m": float(distance[0]), "to_m": float(distance[-1]), "rate_Hz": rate,
        },
    )  # fmt: skip
