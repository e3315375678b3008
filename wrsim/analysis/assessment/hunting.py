"""The instability criterion: rms in a narrow band about the frequency of hunting, over a long window."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from wrsim.analysis.assessment import quantities as q
from wrsim.analysis.assessment.filters import band_pass, sliding_rms, windows

Array = NDArray[np.float64]

BAND = (1.5, 10.0)
"""Where the frequency of an instability is looked for [Hz]."""

LOWEST = 0.4
"""Least lower edge of the band [Hz]."""


def hunting_frequency(signal: Array, rate: float) -> float:
    """Frequency of the highest peak of the power spectrum in ``BAND`` [Hz]; rate: samples a second."""
    length = min(signal.size, max(256, int(4.0 * rate)))
    frequencies, power = welch(signal, rate, nperseg=length, detrend="linear")
    inside = (frequencies >= BAND[0]) & (frequencies <= BAND[1])
    if not inside.any():
        return 0.5 * sum(BAND)
    return float(frequencies[inside][np.argmax(power[inside])])


def hunting_rms(distance: Array, signal: Array, rate: float, frequency: float) -> tuple[Array, Array]:
    """Middles of the windows [m] and the rms of the signal in f0 - 2 Hz to f0 + 2 Hz over them."""
    low = max(frequency - q.STABILITY_HALF_BAND, LOWEST)
    narrow = band_pass(signal, rate, low, frequency + q.STABILITY_HALF_BAND)
    middles = windows(distance, q.STABILITY_WINDOW, q.STABILITY_STEP)
    return middles, sliding_rms(distance, narrow, middles, q.STABILITY_WINDOW)
