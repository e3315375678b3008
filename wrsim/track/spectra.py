"""Spectra of track irregularities, and tracks drawn from them.

Densities are one-sided over the wave number W = 2 pi / wavelength, in m2/(rad/m), of the four channels of
`wrsim.track.irregularities`: those of docs/theory/track.md. Marks: [pub] published figure that was read, [mem] recalled
from the literature.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy

from wrsim.inputs.terms import Names
from wrsim.track.irregularities import CHANNELS, Channel, Disturbance, Sampled
from wrsim.track.piecewise import Array

Density = Callable[[Array], Array]

SAMPLES_A_WAVE = 8.0  # samples of the spline within the shortest wave: it follows the wave within 0.1 %
LINES = 16.0
"""The wave repeats after so many of the longest waves at least, however short the track: so fine are the lines."""
ERRI_CORNERS = (0.00028855, 0.6803895)  # Wr^2 Wc^2 and Wr^2 + Wc^2 [pub]
ERRI_CROSS = 0.4380  # Ws, rad/m [pub]
ERRI = {"low": (1.440846e-7, 2.741619e-7), "high": (4.164787e-7, 7.343623e-7)}  # b0 lateral and vertical [pub]
GERMAN_GAUGE = {"low": 5.32e-8 * 0.8246**2, "high": 1.032e-7 * 0.8246**2}  # A_g Wc^2 [pub]
FRA_CUT = 0.8245
FRA_VERTICAL = (1.2107e-4, 1.0181e-4, 0.6816e-4, 0.5376e-4, 0.2095e-4, 0.0339e-4)  # A of classes 1 to 6, m2 rad/m [pub]
FRA_LATERAL = (3.3634e-4, 1.2107e-4, 0.4128e-4, 0.3027e-4, 0.0762e-4, 0.0339e-4)  # classes 3 and 4 [mem], others [pub]
FRA_CROSS = (0.6046, 0.9308, 0.8520, 1.1312, 0.8209, 0.4380)  # Ws of classes 1 to 6, rad/m [mem]
SNCF = {"good": 0.509 * 308e-6, "poor": 1.790 * 308e-6}  # A, m2/(1/m) [pub]
SNCF_CUT = 0.0489  # n0, 1/m [pub]
CHINA_HIGH_SPEED: dict[Channel, tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]] = {
    "level": ((0.0187, 0.0474, 0.1533), (1.0544e-5, 3.5588e-3, 1.9784e-2, 3.9488e-4), (3.3891, 1.9271, 1.3643, 3.4516)),
    "alignment": ((0.0450, 0.1234), (3.9513e-3, 1.1047e-2, 7.5633e-4), (1.8670, 1.5354, 2.8171)),
    "cross-level": ((0.0258, 0.1163), (3.6148e-3, 4.3685e-2, 4.5867e-3), (1.7278, 1.0461, 2.0939)),
    "gauge": ((0.1090, 0.2938), (5.4978e-2, 5.0701e-3, 1.8778e-4), (0.8282, 1.9037, 4.5948)),
}
"""Frequencies [1/m] at which the power changes, A and exponent k of A / f^k [mm2/(1/m)] below, between, above [pub]."""
CHINA_MAIN_LINE: dict[Channel, tuple[tuple[float, ...], ...]] = {
    "level": (
        (1.1029, -1.4709, 0.5941, 0.8480, 3.8016, -0.2500, 0.0112),
        (0.8581, -1.4607, 0.5848, 0.0407, 2.8428, -0.1989, 0.0094),
    ),
    "alignment": (
        (0.2244, -1.5746, 0.6683, -2.1466, 1.7665, -0.1506, 0.0052),
        (0.3743, -1.5894, 0.7265, 0.4353, 0.9101, -0.0270, 0.0031),
    ),
    "cross-level": ((0.1214, -2.1603, 2.0214, 4.5089, 2.2227, -0.0396, 0.0073),),
}
"""A to G of A (f^2 + B f + C) / (f^4 + D f^3 + E f^2 + F f + G) [mm2/(1/m)]; of left and right rail where two [pub]."""


@dataclass(frozen=True)
class Spectrum:
    """Densities by channel.

    terms: other names; waves: wavelengths that they are fitted to, where a source has them [m]; recalled: channels with
    a figure from memory.
    """

    densities: Mapping[Channel, Density]
    terms: tuple[str, ...]
    waves: tuple[float, float] | None = None
    recalled: tuple[Channel, ...] = ()

    def rms(self, channel: Channel, band: tuple[float, float]) -> float:
        """Root of the integral of the density over wavelengths from one to another [m]."""
        w = np.geomspace(2.0 * np.pi / band[1], 2.0 * np.pi / band[0], 4001)  # 1e-6 of smooth ones, 1e-3 beside a jump
        return float(np.sqrt(np.trapezoid(self.densities[channel](w), w)))


def _erri(b0: float, w: Array) -> Array:
    product, total = ERRI_CORNERS
    return np.asarray(b0 / (product + total * w**2 + w**4))


def _erri_cross(b0: float, w: Array) -> Array:
    return np.asarray(_erri(b0, w) * w**2 / (w**2 + ERRI_CROSS**2))


def _fra(a: float, w: Array) -> Array:
    return np.asarray(0.25 * a * FRA_CUT**2 / (w**2 * (w**2 + FRA_CUT**2)))


def _fra_cross(a: float, ws: float, w: Array) -> Array:
    return np.asarray(a * FRA_CUT**2 / ((w**2 + FRA_CUT**2) * (w**2 + ws**2)))


def _per_radian(density: Density, unit: float, w: Array) -> Array:
    """Of a density over f = 1/wavelength, in the square of a unit [m]."""
    return np.asarray(unit**2 / (2.0 * np.pi) * density(w / (2.0 * np.pi)))


def _sncf(a: float, f: Array) -> Array:
    return np.asarray(a / (1.0 + f / SNCF_CUT) ** 3)


def _powers(edges: tuple[float, ...], a: tuple[float, ...], k: tuple[float, ...], f: Array) -> Array:
    piece = np.searchsorted(edges, f, side="right")
    return np.asarray(np.array(a)[piece] / f ** np.array(k)[piece])


def _ratios(rows: tuple[tuple[float, ...], ...], f: Array) -> Array:
    ratios = [a * (f**2 + b * f + c) / (f**4 + d * f**3 + e * f**2 + g * f + h) for a, b, c, d, e, g, h in rows]
    return np.asarray(np.mean(ratios, axis=0))


def _b176(grade: str) -> dict[Channel, Density]:
    lateral, vertical = ERRI[grade]
    return {
        "alignment": partial(_erri, lateral),
        "level": partial(_erri, vertical),
        "cross-level": partial(_erri_cross, 4.0 * vertical),
    }


def _class_of_fra(i: int) -> dict[Channel, Density]:
    across = partial(_fra_cross, FRA_VERTICAL[i], FRA_CROSS[i])
    level = partial(_fra, FRA_VERTICAL[i])
    return {"alignment": partial(_fra, FRA_LATERAL[i]), "level": level, "cross-level": across, "gauge": across}


def _of_millimetres(densities: dict[Channel, Density]) -> dict[Channel, Density]:
    return {channel: partial(_per_radian, density, 1e-3) for channel, density in densities.items()}


SPECTRA: dict[str, Spectrum] = {
    **{f"ERRI-{grade}": Spectrum(_b176(grade), (f"ERRI B176 {grade}",)) for grade in ERRI},
    **{
        f"German-{grade}": Spectrum(
            _b176(grade) | {"gauge": partial(_erri_cross, gauge)}, (f"German {grade} interference",)
        )
        for grade, gauge in GERMAN_GAUGE.items()
    },
    **{
        f"FRA-{i + 1}": Spectrum(
            _class_of_fra(i),
            (f"AAR-{i + 1}", f"American {i + 1}"),
            (1.524, 304.8),
            (("alignment", "cross-level", "gauge") if i in (2, 3) else ("cross-level", "gauge")),
        )
        for i in range(6)
    },
    **{
        f"SNCF-{grade}": Spectrum({"level": partial(_per_radian, partial(_sncf, a), 1.0)}, (), (2.0, 40.0))
        for grade, a in SNCF.items()
    },
    "China-HSR": Spectrum(
        _of_millimetres({channel: partial(_powers, *rows) for channel, rows in CHINA_HIGH_SPEED.items()}),
        ("TB/T 3352", "China ballastless"),
        (2.0, 200.0),
    ),
    "China-main-line": Spectrum(
        _of_millimetres({channel: partial(_ratios, rows) for channel, rows in CHINA_MAIN_LINE.items()}),
        ("China trunk lines",),
    ),
}
"""Spectra by the name that files use."""
NAMES = Names({name: spectrum.terms for name, spectrum in SPECTRA.items()})


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
            density = SPECTRA[self.name].densities.get(channel)
            if channel not in self.channels or density is None:
                continue
            amplitudes = self.scale * self._amplitudes(density, period, step)
            values = scipy.fft.irfft(0.5 * period * amplitudes * np.exp(2j * np.pi * phases), period)[:count]
            shape = Sampled.through(distance, values, min(self.fade, 0.5 * (self.end - self.start)), self.shortest)
            disturbances.append(Disturbance.of(shape, channel))
        return tuple(disturbances)

    def label(self) -> str:
        """What is drawn: convention, band, rms of the channels, and what there is not."""
        spectrum, band = SPECTRA[self.name], (self.shortest, self.longest)
        drawn = [
            f"{channel} {1e3 * self.scale * spectrum.rms(channel, band):.3g}{' [mem]' * (channel in spectrum.recalled)}"
            for channel in spectrum.densities
            if channel in self.channels
        ]
        none = [channel for channel in self.channels if channel not in spectrum.densities]
        beyond = spectrum.waves and (self.shortest < spectrum.waves[0] or self.longest > spectrum.waves[1])
        parts = (
            f"{self.name}, seed {self.seed}, one-sided in m2/(rad/m), waves of {self.shortest:g} to {self.longest:g} m",
            f"beyond the fit, {spectrum.waves[0]:g} to {spectrum.waves[1]:g} m" if spectrum.waves and beyond else "",
            f"rms in mm: {', '.join(drawn)}" if drawn else "",
            f"not in this spectrum: {', '.join(none)}" if none else "",
        )
        return "; ".join(filter(None, parts))

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
