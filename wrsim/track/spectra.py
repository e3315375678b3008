"""Spectra of track irregularities, and tracks drawn from them.

Densities are one-sided over the wave number W = 2 pi / wavelength, in m2/(rad/m), of the four channels of
`wrsim.track.irregularities`: those of docs/theory/track.md. Marks: [pub] published figure, [mem] recalled from
the literature.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy

from wrsim.track.irregularities import CHANNELS, Channel, Disturbance, Sampled
from wrsim.track.piecewise import Array

Density = Callable[[Array], Array]

SAMPLES_A_WAVE = 8.0  # samples of the spline within the shortest wave: it follows the wave within 0.1 %
LINES = 16.0
"""The wave repeats after so many of the longest waves at least, however short the track: so fine are the lines."""
ERRI_CORNERS = (0.00028855, 0.6803895)  # Wr^2 Wc^2 and Wr^2 + Wc^2 [pub]
ERRI_CROSS = 0.4380
ERRI = {"low": (1.440846e-7, 2.741619e-7), "high": (4.164787e-7, 7.343623e-7)}  # b0 lateral and vertical [pub]
FRA_CUT = 0.8245
FRA_VERTICAL = (1.2107e-4, 1.0181e-4, 0.6816e-4, 0.5376e-4, 0.2095e-4, 0.0339e-4)  # A of classes 1 to 6, m2 rad/m
FRA_LATERAL = (3.3634e-4, 1.2107e-4, 0.4128e-4, 0.3027e-4, 0.0762e-4, 0.0339e-4)
FRA_CROSS = (0.6046, 0.9308, 0.8520, 1.1312, 0.8209, 0.4380)  # Ws of classes 1 to 6, rad/m


def _erri(b0: float, w: Array) -> Array:
    product, total = ERRI_CORNERS
    return np.asarray(b0 / (product + total * w**2 + w**4))


def _erri_cross(b0: float, w: Array) -> Array:
    return np.asarray(4.0 * _erri(b0, w) * w**2 / (w**2 + ERRI_CROSS**2))


def _fra(a: float, w: Array) -> Array:
    return np.asarray(0.25 * a * FRA_CUT**2 / (w**2 * (w**2 + FRA_CUT**2)))


def _fra_cross(a: float, ws: float, w: Array) -> Array:
    return np.asarray(a * FRA_CUT**2 / ((w**2 + FRA_CUT**2) * (w**2 + ws**2)))


SPECTRA: dict[str, dict[Channel, Density]] = {
    f"ERRI-{grade}": {
        "alignment": partial(_erri, lateral),
        "level": partial(_erri, vertical),
        "cross-level": partial(_erri_cross, vertical),
    }
    for grade, (lateral, vertical) in ERRI.items()
} | {
    f"FRA-{i + 1}": {
        "alignment": partial(_fra, FRA_LATERAL[i]),
        "level": partial(_fra, FRA_VERTICAL[i]),
        "cross-level": partial(_fra_cross, FRA_VERTICAL[i], FRA_CROSS[i]),
        "gauge": partial(_fra_cross, FRA_VERTICAL[i], FRA_CROSS[i]),
    }
    for i in range(6)
}
"""Density functions by the name that files use and the channel; the gauge of ERRI tracks has none."""


@dataclass(frozen=True)
class Realisation:
    """One track out of a spectrum.

    name: key of `SPECTRA`; seed: of the random phases; shortest, longest: wavelengths [m]; start, end: distances [m];
    scale: factor on all amplitudes; fade: length over which it begins and ends [m].
    """

    name: str
    seed: int
    shortest: float
    longest: float
    start: float
    end: float
    scale: float = 1.0
    fade: float = 20.0
    channels: tuple[Channel, ...] = CHANNELS

    def disturbances(self) -> tuple[Disturbance, ...]:
        """The drawn channels as disturbances of the rails."""
        generator = np.random.Generator(np.random.PCG64(self.seed))
        step = self.shortest / SAMPLES_A_WAVE
        count = int(np.ceil((self.end - self.start) / step)) + 1
        period = scipy.fft.next_fast_len(max(count, int(np.ceil(LINES * self.longest / step))), real=True)
        distance = np.linspace(self.start, self.end, count)
        step = (self.end - self.start) / (count - 1)
        disturbances = []
        for channel in CHANNELS:
            phases = generator.random(period // 2 + 1)  # drawn for every channel, so that none depends on the others
            density = SPECTRA[self.name].get(channel)
            if channel not in self.channels or density is None:
                continue
            amplitudes = self.scale * self._amplitudes(density, period, step)
            values = scipy.fft.irfft(0.5 * period * amplitudes * np.exp(2j * np.pi * phases), period)[:count]
            shape = Sampled.through(distance, values, min(self.fade, 0.5 * (self.end - self.start)), self.shortest)
            disturbances.append(Disturbance.of(shape, channel))
        return tuple(disturbances)

    def _amplitudes(self, density: Density, period: int, step: float) -> Array:
        """Amplitudes [m] of the lines 0 .. period/2 of a wave of ``period`` samples with the density's variance.

        Each line carries the variance of the interval of wave numbers around it, cut at the ends of the band.
        """
        line = 2.0 * np.pi / (period * step)
        middle = line * np.arange(period // 2 + 1)
        band = 2.0 * np.pi / self.longest, 2.0 * np.pi / self.shortest
        low, high = np.clip(middle - 0.5 * line, *band), np.clip(middle + 0.5 * line, *band)
        variance = np.zeros(middle.shape)
        for point, weight in zip(*np.polynomial.legendre.leggauss(4), strict=True):
            variance += 0.5 * weight * density(np.maximum(0.5 * (high + low) + 0.5 * point * (high - low), 1e-12))
        return np.asarray(np.sqrt(2.0 * variance * (high - low)))
