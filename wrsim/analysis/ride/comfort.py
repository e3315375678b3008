"""Comfort: weighted accelerations over blocks of 5 s and their mean, as EN 12299 forms them [mem].

The frequency weighting (ISO 8041-1, as ISO 2631-1, ISO 2631-4 and EN 12299 use it) is the transfer function

    H(s) = K H_high(s) H_low(s) H_transition(s) H_step(s)
    H_high = 1/(1 + w1/(Q1 s) + (w1/s)^2),   H_low = 1/(1 + s/(Q2 w2) + (s/w2)^2),   Q1 = Q2 = 1/sqrt 2
    H_transition = (1 + s/w3)/(1 + s/(Q4 w4) + (s/w4)^2)
    H_step = (1 + s/(Q5 w5) + (s/w5)^2)/(1 + s/(Q6 w6) + (s/w6)^2) (w5/w6)^2

with the parameters of ISO 8041 [pub: table in the manual of a vibration meter that quotes it]. Rail vehicles: Wb
vertically and Wd horizontally (EN 12299); ISO 2631-1 has Wk vertically instead of Wb, Wc at the backrest.

Signals are weighted in the frequency domain, with the analogue H itself: no warping near half the sampling rate.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

Array = NDArray[np.float64]
Name = Literal["Wb", "Wc", "Wd", "We", "Wj", "Wk"]

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
AXES: dict[str, Name] = {"x": "Wd", "y": "Wd", "z": "Wb"}
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
    signals = np.column_stack([weighted(acceleration[:, i], rate, name) for i, name in enumerate(AXES.values())])
    length = round(BLOCK * rate)
    count = signals.shape[0] // length
    blocks = signals[: count * length].reshape(count, length, 3)
    continuous = np.sqrt((blocks**2).mean(axis=1))
    percentiles = np.percentile(continuous, PERCENTILE, axis=0) if count else np.full(3, np.nan)
    mean = 6.0 * float(np.sqrt((percentiles**2).sum()))
    return Comfort(np.sqrt((signals**2).mean(axis=0)), continuous, percentiles, mean)
