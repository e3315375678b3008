"""One wheelset of a run: its filtered signals, and their values section by section."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.analysis.assessment import limits
from wrsim.analysis.assessment.filters import (
    hunting_frequency,
    hunting_rms,
    low_pass,
    sampling_rate,
    sliding_mean,
    windows,
)
from wrsim.analysis.assessment.nadal import longest_stretch
from wrsim.errors import InputError
from wrsim.results.assessment import Limit, Section, Value
from wrsim.scenario.sections.assessment import AssessmentSettings

Array = NDArray[np.float64]

SIDES = (("left", 0), ("right", 1))


def _quotient(y: Array, load: Array) -> Array:
    """Y/Q; beyond any limit where the wheel is pushed outward without load, 0 where it is without either."""
    free = load <= 0.0
    return np.where(free, np.where(y > 1e3, np.inf, 0.0), y / np.where(free, 1.0, load))


@dataclass(frozen=True, eq=False)
class Axle:
    """Filtered signals of one wheelset: over its samples (n,), and over the middles of windows (m,), (k,)."""

    name: str
    label: str
    load: float
    frequency: float
    distance: Array
    y: Array
    q: Array
    quotient: Array
    middles: Array
    sum_y_mean: Array
    quotient_mean: Array
    stability_middles: Array
    rms: Array
    wear: Array | None
    wear_mean: Array | None
    attack: Array | None
    shift: Array | None

    @classmethod
    def of(cls, name: str, label: str, dataset: xr.Dataset, settings: AssessmentSettings) -> Axle:
        """Filter the channels of one wheelset."""
        distance = dataset["distance"].values
        rate = sampling_rate(dataset["time"].values)

        def of_wheels(channel: str) -> Array:
            return np.asarray(dataset[channel].transpose("time", "wheel").sel(wheel=["left", "right"]).values)

        raw_y, raw_q = of_wheels("Y"), of_wheels("Q")
        if not (np.isfinite(raw_y).all() and np.isfinite(raw_q).all()):
            raise InputError("the result cannot be assessed: some of its wheel forces are not numbers")
        y, load = (low_pass(values, rate, limits.CUT_OFF) for values in (raw_y, raw_q))
        quotient = _quotient(y, load)
        middles = windows(distance, limits.WINDOW, limits.STEP)
        raw_sum = raw_y[:, 0] - raw_y[:, 1]
        frequency = settings.instability_frequency or hunting_frequency(raw_sum, rate)
        stability, rms = hunting_rms(distance, raw_sum, rate, frequency)
        wear = of_wheels("T_gamma") if "T_gamma" in dataset else None
        return cls(
            name=name,
            label=label,
            load=settings.axle_load if settings.axle_load is not None else float(raw_q.sum(axis=1).mean()),
            frequency=frequency,
            distance=distance,
            y=y,
            q=load,
            quotient=quotient,
            middles=middles,
            sum_y_mean=sliding_mean(distance, y[:, 0] - y[:, 1], middles, limits.WINDOW),
            quotient_mean=_mean_of_quotient(distance, quotient, middles),
            stability_middles=stability,
            rms=rms,
            wear=wear,
            wear_mean=None if wear is None else sliding_mean(distance, wear, middles, limits.WINDOW),
            attack=dataset["yaw"].values if "yaw" in dataset else None,
            shift=dataset["lateral_shift"].values if "lateral_shift" in dataset else None,
        )

    def values(self, section: Section, settings: AssessmentSettings, nadal: Limit | None) -> Iterator[Value]:
        """Everything that can be said of one section."""
        inside = self.inside(section)
        if inside.sum() < 2:
            return
        yield from self._safety(section, inside, settings, nadal)
        yield from self._loading(section, inside)
        yield from self._information(section, inside)

    def inside(self, section: Section) -> NDArray[np.bool_]:
        """Samples that lie in a section."""
        return np.asarray((self.distance >= section.start) & (self.distance <= section.end))

    def _within(self, section: Section) -> NDArray[np.bool_]:
        """Windows of 2 m that lie in a section."""
        half = 0.5 * limits.WINDOW - 1e-6
        return (self.middles - half >= section.start) & (self.middles + half <= section.end)

    def _safety(
        self, section: Section, inside: NDArray[np.bool_], settings: AssessmentSettings, nadal: Limit | None
    ) -> Iterator[Value]:
        within = self._within(section)
        if within.any():
            sum_y = np.abs(np.percentile(self.sum_y_mean[within], [limits.LOW, limits.HIGH])).max()
            yield self.value("sum_Y", section, sum_y, limits.track_shift(self.load, settings.kind))
            for wheel, side in SIDES:
                quotient = _high(self.quotient_mean[within, side])
                yield self.value("Y_over_Q", section, quotient, limits.derailment(section.radius), wheel)
                if nadal is not None:
                    yield self.value("Y_over_Q_nadal", section, quotient, nadal, wheel)
        if nadal is not None:
            for wheel, side in SIDES:
                beyond = longest_stretch(self.distance[inside], self.quotient[inside, side] - nadal.value)
                yield self.value("climb_distance", section, beyond, limits.CLIMB_DISTANCE, wheel)
        middle = (self.stability_middles >= section.start) & (self.stability_middles <= section.end)
        if middle.any():
            limit = limits.instability(self.load, settings.kind)
            yield self.value("instability", section, self.rms[middle].max(), limit)

    def _loading(self, section: Section, inside: NDArray[np.bool_]) -> Iterator[Value]:
        for wheel, side in SIDES:
            limit = limits.vertical_force(0.5 * self.load, section.speed)
            yield self.value("Q", section, np.percentile(self.q[inside, side], limits.HIGH), limit, wheel)
            lowest = np.percentile(self.q[inside, side], limits.LOW)
            yield self.value("unloading", section, 1.0 - lowest / (0.5 * self.load), None, wheel)

    def _information(self, section: Section, inside: NDArray[np.bool_]) -> Iterator[Value]:
        if self.wear is not None and self.wear_mean is not None:
            within = self._within(section)
            for wheel, side in SIDES:
                yield self.value("T_gamma", section, self.wear[inside, side].mean(), None, wheel)
                if within.any():
                    largest = np.percentile(self.wear_mean[within, side], limits.HIGH)
                    yield self.value("T_gamma_max", section, largest, None, wheel)
        if self.attack is not None:
            yield self.value("angle_of_attack", section, abs(np.median(self.attack[inside])), None)
        if self.shift is not None:
            shift = np.abs(np.percentile(self.shift[inside], [limits.LOW, limits.HIGH])).max()
            yield self.value("lateral_shift", section, shift, None)

    def value(self, key: str, section: Section, value: float, limit: Limit | None, wheel: str = "") -> Value:
        return Value(limits.QUANTITIES[key], section, self.name, wheel, float(value), limit, label=self.label)


def quasi_static(runs: Sequence[tuple[Axle, Sequence[Section]]], radii: Mapping[str, float]) -> Iterator[Value]:
    """What the outer wheel bears in the full curves of each class.

    runs: a wheelset in every run, with the sections of that; radii: the mean one of each class [m].
    """
    for zone, radius in radii.items():
        own = [
            (axle, section, inside, 1 if section.radius > 0.0 else 0)
            for axle, sections in runs
            for section in sections
            if section.zone == zone and (inside := axle.inside(section)).sum() >= 2
        ]
        lean = [float(np.median(axle.quotient[inside, 1 - outer])) for axle, _, inside, outer in own]
        limit = limits.quasi_static_guiding(radius)
        reduced = limit is not None and len(own) > 0 and float(np.mean(lean)) > limits.LEAN
        for (axle, section, inside, outer), inner in zip(own, lean, strict=True):
            wheel = SIDES[outer][0]
            y, load = np.median(axle.y[inside, outer]), np.median(axle.q[inside, outer])
            yield axle.value("Y_qst", section, y, None if reduced else limit, wheel)
            if reduced:
                yield axle.value("Y_qst_reduced", section, y - limits.LEAN_FORCE * (inner - limits.LEAN), limit, wheel)
            yield axle.value("Q_qst", section, load, limits.quasi_static_vertical(), wheel)
            yield axle.value("B_qst", section, abs(y) + limits.Q_SHARE * load, limits.combined(radius), wheel)


def _high(values: Array) -> float:
    """Percentile 99.85 %; infinite as soon as one value is."""
    return float(np.percentile(values, limits.HIGH)) if np.isfinite(values).all() else np.inf


def _mean_of_quotient(distance: Array, quotient: Array, middles: Array) -> Array:
    """Sliding mean; infinite in windows in which the quotient is."""
    lifted = ~np.isfinite(quotient)
    mean = sliding_mean(distance, np.where(lifted, 0.0, quotient), middles, limits.WINDOW)
    touched = sliding_mean(distance, lifted.astype(float), middles, limits.WINDOW)
    return np.where(touched > 1e-12, np.inf, mean)
