"""The lateral signal of a running gear that may be unstable, about the frequency of its hunting (EN 14363, 7.5.3)."""

import numpy as np
import scipy

from wrsim.assessment.outcome import Array, AssessedSection
from wrsim.assessment.rules import ClauseSection
from wrsim.inputs.section import given
from wrsim.results.filters import band_pass, sliding_rms, windows

BAND = (1.5, 10.0)  # in which the frequency of an instability lies [Hz]
LOWEST = 0.4  # least lower edge of the band [Hz]


class Hunting:
    """A lateral signal about the frequency f0 of an instability.

    frequency: f0 [Hz], that of the highest peak of the power spectrum in ``BAND`` unless given; middles (k,) of the
    windows [m], rms (k,) over them of the signal in the band of the clause about f0.
    """

    def __init__(
        self, distance: Array, signal: Array, rate: float, frequency: float | None, clause: ClauseSection
    ) -> None:
        """rate: samples a second."""
        half, window, step = given(clause.half_band_Hz), given(clause.window_m), given(clause.step_m)
        self.frequency = frequency or _highest_peak(signal, rate)
        narrow = band_pass(signal, rate, max(self.frequency - half, LOWEST), self.frequency + half)
        self.middles = windows(distance, window, step)
        self.rms = sliding_rms(distance, narrow, self.middles, window)

    def largest(self, section: AssessedSection) -> float | None:
        """Largest rms in a section; None without a window there."""
        inside = section.holds(self.middles)
        return float(self.rms[inside].max()) if inside.any() else None


def _highest_peak(signal: Array, rate: float) -> float:
    """Its frequency in the power spectrum, in ``BAND`` [Hz]."""
    length = min(signal.size, max(256, int(4.0 * rate)))
    frequencies, power = scipy.signal.welch(signal, rate, nperseg=length, detrend="linear")
    inside = (frequencies >= BAND[0]) & (frequencies <= BAND[1])
    return float(frequencies[inside][np.argmax(power[inside])]) if inside.any() else 0.5 * sum(BAND)
