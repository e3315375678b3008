"""Filters and sliding values of measured or simulated signals, as EN 14363 and UIC 518 name them.

All filters are zero-phase: a Butterworth filter runs forward and backward, so that nothing is shifted along the track
and values of one place stay together. The gain at the named cut-off is -3 dB for both passes together (the single pass
has a higher cut-off). Low-passes are of second order in each pass, 24 dB an octave in all. Band-passes are a low-pass
and a high-pass of fourth order in each pass, 48 dB an octave in all: with less, the narrow band about f0 of the
instability criterion would take 10 % off f0 itself.

Sliding values are integrals over distance, exact for a signal that is linear between its samples.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from math import atan, pi, tan

import numpy as np
import xarray as xr

from wrsim.errors import InputError
from wrsim.jit.butterworth import butterworth, zero_phase, zero_phase_parts
from wrsim.results.moments import Array

ROWS = 1 << 15  # samples of a long signal that are filtered at once
LEAST_SAMPLES = 30  # samples that a signal needs before filtering means anything


def sampling_rate(time: Array) -> float:
    """Samples a second of uniform times. Raises InputError when they are too few or not uniform."""
    if time.size < LEAST_SAMPLES:
        raise InputError(f"the result has {time.size} samples; filters need at least {LEAST_SAMPLES}")
    steps = np.diff(time)
    step = float(np.median(steps))
    if np.abs(steps - step).max() > 1e-3 * step:
        raise InputError("the samples of the result are not evenly spaced in time; filters need them to be")
    return 1.0 / step


def on_raster(dataset: xr.Dataset) -> xr.Dataset:
    """A run without its last sample where that is off the raster, as it does where a run was stopped."""
    time = dataset["time"].values
    if time.size > 2 and abs((time[-1] - time[-2]) - (time[1] - time[0])) > 1e-6 * (time[1] - time[0]):
        return dataset.isel(time=slice(0, -1))
    return dataset


def low_pass(signal: Array, rate: float, cut_off: float) -> Array:
    """Zero-phase low-pass along the first axis; -3 dB at ``cut_off`` [Hz], 24 dB an octave.

    rate: samples a second. Raises InputError when the signal is sampled too slowly for the filter.
    """
    return _filtered(signal, rate, False, cut_off, 2)


def band_pass(signal: Array, rate: float, low: float, high: float) -> Array:
    """Zero-phase band-pass; -3 dB at ``low`` and ``high`` [Hz], 48 dB an octave beyond. See ``low_pass``."""
    return _filtered(_filtered(signal, rate, False, high, 4), rate, True, low, 4)


def low_passed(read: Callable[[int, int], Array], count: int, rate: float, cut_off: float) -> Iterator[Array]:
    """`low_pass` of a long signal, to the bit, ``ROWS`` samples at a time.

    read: gives the samples (n, channels) from one to another, of so many.
    """
    sections, pad = _filter(count, rate, False, cut_off, 2)
    return zero_phase_parts(sections, read, count, pad, ROWS)


def _filtered(signal: Array, rate: float, highpass: bool, cut_off: float, order: int) -> Array:
    sections, pad = _filter(signal.shape[0], rate, highpass, cut_off, order)
    return zero_phase(sections, signal, pad)


def _filter(count: int, rate: float, highpass: bool, cut_off: float, order: int) -> tuple[Array, int]:
    """Sections of either pass of a Butterworth filter of that order each, and how many samples continue a signal:
    gain of both 1/(1 + (sqrt 2 - 1) w^(2 order)), w = f/cut_off."""
    if not 0.0 < cut_off < 0.45 * rate:
        raise InputError(
            f"a filter at {cut_off:g} Hz needs more than {cut_off / 0.45:.3g} samples a second; the result has "
            f"{rate:.4g}: run it with output_interval_ms = {0.4e3 / cut_off:.2g} or less"
        )
    # the bilinear transform maps frequencies to tan(pi f / rate); the corner of one pass is moved there
    factor = (2.0**0.5 - 1.0) ** (-0.5 / order)
    factor = 1.0 / factor if highpass else factor
    corner = rate / pi * atan(factor * tan(pi * cut_off / rate))
    pad = min(int(3.0 * rate / cut_off), count - 2)
    return butterworth(order, corner, highpass, rate), pad


def windows(distance: Array, length: float, step: float) -> Array:
    """Middles of windows of ``length`` every ``step`` [m] that lie within the distances."""
    room = distance[-1] - distance[0] - length
    if room < -1e-9:
        return np.zeros(0)
    return np.asarray(distance[0] + 0.5 * length + step * np.arange(int(room / step + 1e-6) + 1))


def sliding_mean(distance: Array, signal: Array, middles: Array, length: float) -> Array:
    """Mean of a signal (n, ...) over windows of ``length`` [m] about ``middles``: (windows, ...)."""
    return _mean(distance, signal, _integral(distance, signal, np.zeros_like(signal[:1])), middles, length)


def _integral(distance: Array, signal: Array, start: Array) -> Array:
    """Integral of a signal (n, ...) over distance up to each sample; start: up to the first one (1, ...)."""
    step = np.diff(distance).reshape(-1, *(1,) * (signal.ndim - 1))
    rises = 0.5 * (np.diff(signal, axis=0) / step)
    terms = np.stack([signal[:-1] * step, rises * (step * step)], axis=1).reshape(-1, *signal.shape[1:])
    return np.asarray(np.cumsum(np.concatenate([start, terms]), axis=0)[::2])


def _mean(distance: Array, signal: Array, integral: Array, middles: Array, length: float) -> Array:
    def up_to(places: Array) -> Array:
        i = np.clip(np.searchsorted(distance, places, "right") - 1, 0, distance.size - 2)
        shape = -1, *(1,) * (signal.ndim - 1)
        step, rest = (distance[i + 1] - distance[i]).reshape(shape), (places - distance[i]).reshape(shape)
        return np.asarray(integral[i] + signal[i] * rest + 0.5 * ((signal[i + 1] - signal[i]) / step) * (rest * rest))

    return (up_to(middles + 0.5 * length) - up_to(middles - 0.5 * length)) / length


def means_about(distance: Array, parts: Iterable[Array], length: float) -> Iterator[tuple[int, Array]]:
    """The `sliding_mean` about each sample of a signal that comes in parts, to the bit, as soon as its window is there;
    with the first of these samples. Not-a-number less than half a window from the ends."""
    half, first, done = 0.5 * length, 0, 0
    signal, start = np.zeros((0, 0)), np.zeros((0, 0))
    for part in parts:
        signal = np.concatenate([signal, part]) if signal.size else part
        start = start if start.size else np.zeros_like(part[:1])
        places = distance[first : first + len(signal)]
        integral = _integral(places, signal, start)
        last = first + len(signal) == len(distance)
        ready = len(distance) if last else first + int((places + half <= places[-1]).sum())
        middles = distance[done:ready]
        inside = (middles >= distance[0] + half) & (middles <= distance[-1] - half)
        means = np.full((len(middles), *signal.shape[1:]), np.nan)
        means[inside] = _mean(places, signal, integral, middles[inside], length)
        yield done, means
        done = max(ready, done)
        drop = max(int(np.searchsorted(places, distance[min(done, len(distance) - 1)] - half, "right")) - 1, 0)
        first, signal, start = first + drop, signal[drop:], integral[drop : drop + 1]


def sliding_rms(distance: Array, signal: Array, middles: Array, length: float) -> Array:
    """Root of the mean square of a signal over windows; see ``sliding_mean``."""
    return np.sqrt(np.maximum(sliding_mean(distance, signal * signal, middles, length), 0.0))


def sliding_held(distance: Array, signal: Array, middles: Array, length: float, lowest: bool) -> Array:
    """The value of a signal (n, ...) that is reached all over a window: its least value there, of a signal whose
    small values count (lowest) its largest; see ``sliding_mean``."""
    sign = -1.0 if lowest else 1.0
    ends = np.stack([middles - 0.5 * length, middles + 0.5 * length])
    pairs = np.stack([np.searchsorted(distance, ends[0], "right"), np.searchsorted(distance, ends[1], "left")], axis=1)
    result = np.empty((middles.size, *signal.shape[1:]))
    for column in np.ndindex(signal.shape[1:]):
        column_values = sign * signal[:, *column]
        inside = np.minimum.reduceat(np.append(column_values, np.inf), pairs.ravel())[::2]
        at_ends = np.interp(ends, distance, column_values).min(axis=0)
        result[:, *column] = np.where(pairs[:, 0] < pairs[:, 1], np.minimum(at_ends, inside), at_ends)
    return sign * result


def moving_deviation(signal: Array, samples: int) -> Array:
    """Rms about its mean of a signal (n,) over so many samples about each; not-a-number where these are not there."""
    result = np.full(signal.size, np.nan)
    if signal.size >= samples:
        first, second = (
            np.convolve(part, np.full(samples, 1.0 / samples), "valid") for part in (signal, signal * signal)
        )
        start = samples // 2
        result[start : start + first.size] = np.sqrt(np.maximum(second - first * first, 0.0))
    return result


def percentiles(values: Array, percents: Sequence[float]) -> Array:
    """Percentile of values (n, ...) along the first axis, of two the larger magnitude; infinite where a value is."""
    result = np.full(values.shape[1:], np.inf)
    finite = np.isfinite(values).all(axis=0)
    ends = np.percentile(values[:, finite] if values.ndim > 1 else values, list(percents), axis=0)
    if finite.any():
        result[finite] = ends[0] if len(percents) == 1 else np.abs(ends).max(axis=0)
    return result
