"""Filtered signals of a run and their values section by section: forces of a wheelset, accelerations at a point.

Ride characteristics are of points on car bodies, instability also of bogie frames; sections of points go by the
distance of the vehicle's reference body.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import xarray as xr

from wrsim.analysis.assessment import filters, limits
from wrsim.analysis.assessment.nadal import longest_stretch
from wrsim.analysis.assessment.sections import STRAIGHT, TRANSITION
from wrsim.errors import InputError
from wrsim.results.assessment import Array, AssessedSection, Limit, Value
from wrsim.results.channels import BOGIE_FRAME, CAR_BODY
from wrsim.scenario.sections.assessment import AssessmentSettings

SIDES = (("left", 0), ("right", 1))


class Axle:
    """Filtered signals of one wheelset: over its samples (n,), wheels (n, 2), and over the middles of windows (m,).

    label: name with its number from the front, for tables; load: static, of both wheels [N].
    """

    def __init__(self, name: str, label: str, dataset: xr.Dataset, settings: AssessmentSettings) -> None:
        rate = filters.sampling_rate(dataset["time"].values)

        def of_wheels(channel: str) -> Array:
            return np.asarray(dataset[channel].transpose("time", "wheel").sel(wheel=["left", "right"]).values)

        raw_y, raw_q = of_wheels("Y"), of_wheels("Q")
        if not (np.isfinite(raw_y).all() and np.isfinite(raw_q).all()):
            raise InputError("the result cannot be assessed: some of its wheel forces are not numbers")
        self.name, self.label = name, label
        self.load = settings.axle_load if settings.axle_load is not None else float(raw_q.sum(axis=1).mean())
        self.distance: Array = dataset["distance"].values
        self.y, self.q = (filters.low_pass(values, rate, limits.CUT_OFF) for values in (raw_y, raw_q))
        # beyond any limit where a wheel is pushed outward without load, 0 where it is without either
        free = self.q <= 0.0
        self.quotient = np.where(free, np.where(self.y > 1e3, np.inf, 0.0), self.y / np.where(free, 1.0, self.q))
        self.middles = filters.windows(self.distance, limits.WINDOW, limits.STEP)
        self.sum_y_mean = self._mean(self.y[:, 0] - self.y[:, 1])
        lifted = ~np.isfinite(self.quotient)
        mean, touched = self._mean(np.where(lifted, 0.0, self.quotient)), self._mean(lifted.astype(float))
        self.quotient_mean = np.where(touched > 1e-12, np.inf, mean)
        self.hunting = filters.Hunting(self.distance, raw_y[:, 0] - raw_y[:, 1], rate, settings.instability_frequency)
        self.wear = of_wheels("T_gamma") if "T_gamma" in dataset else None
        self.wear_mean = None if self.wear is None else self._mean(self.wear)
        self.attack, self.shift = (dataset[n].values if n in dataset else None for n in ("yaw", "lateral_shift"))

    def _mean(self, signal: Array) -> Array:
        return filters.sliding_mean(self.distance, signal, self.middles, limits.WINDOW)

    def values(self, section: AssessedSection, settings: AssessmentSettings, nadal: Limit | None) -> Iterator[Value]:
        """Everything in one section but the quasi-static values."""
        inside = section.holds(self.distance)
        if inside.sum() < 2:
            return
        half = 0.5 * limits.WINDOW - 1e-6
        within = (self.middles - half >= section.start) & (self.middles + half <= section.end)
        if within.any():
            limit = limits.track_shift(self.load, settings.kind)
            yield self.value("sum_Y", section, filters.extreme(self.sum_y_mean[within]), limit)
        if (hunting := self.hunting.largest(section)) is not None:
            yield self.value("instability", section, hunting, limits.instability(self.load, settings.kind))
        for wheel, side in SIDES:
            q, wheel_load = self.q[inside, side], 0.5 * self.load
            if within.any():
                means = self.quotient_mean[within, side]
                quotient = np.percentile(means, limits.HIGH) if np.isfinite(means).all() else np.inf
                yield self.value("Y_over_Q", section, quotient, limits.derailment(section.radius), wheel)
                if nadal is not None:
                    yield self.value("Y_over_Q_nadal", section, quotient, nadal, wheel)
            if nadal is not None:
                beyond = longest_stretch(self.distance[inside], self.quotient[inside, side] - nadal.value)
                yield self.value("climb_distance", section, beyond, limits.CLIMB_DISTANCE, wheel)
            limit = limits.vertical_force(wheel_load, section.speed)
            yield self.value("Q", section, np.percentile(q, limits.HIGH), limit, wheel)
            yield self.value("unloading", section, 1.0 - np.percentile(q, limits.LOW) / wheel_load, None, wheel)
            if self.wear is not None and self.wear_mean is not None:
                yield self.value("T_gamma", section, self.wear[inside, side].mean(), None, wheel)
                if within.any():
                    largest = np.percentile(self.wear_mean[within, side], limits.HIGH)
                    yield self.value("T_gamma_max", section, largest, None, wheel)
        if self.attack is not None:
            yield self.value("angle_of_attack", section, abs(np.median(self.attack[inside])), None)
        if self.shift is not None:
            yield self.value("lateral_shift", section, filters.extreme(self.shift[inside]), None)

    def value(
        self, key: str, section: AssessedSection, value: np.floating | float, limit: Limit | None, wheel: str = ""
    ) -> Value:
        """One value of this wheelset, or of a wheel of it."""
        return Value(limits.QUANTITIES[key], section, self.name, wheel, float(value), limit, label=self.label)


def quasi_static(runs: Sequence[tuple[Axle, Sequence[AssessedSection]]], radii: Mapping[str, float]) -> Iterator[Value]:
    """What the outer wheel bears in the full curves of each class.

    runs: a wheelset in every run, with the sections of that; radii: the mean one of each class [m].
    """
    for zone, radius in radii.items():
        own = [
            (axle, section, inside, 1 if section.radius > 0.0 else 0)
            for axle, sections in runs
            for section in sections
            if section.zone == zone and (inside := section.holds(axle.distance)).sum() >= 2
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
            yield axle.value("Q_qst", section, load, limits.QUASI_STATIC_VERTICAL, wheel)
            yield axle.value("B_qst", section, abs(y) + limits.Q_SHARE * load, limit and limits.COMBINED, wheel)


class AssessedPoint:
    """Filtered accelerations [m/s2] of one point on a car body or a bogie frame."""

    def __init__(self, one: xr.Dataset, level: str, settings: AssessmentSettings) -> None:
        """one: what a result has of the point; level: ``CAR_BODY`` or ``BOGIE_FRAME``."""
        self.name, self.is_frame = str(one["point"].item()), level == BOGIE_FRAME
        self.bogie_mass = float(one["point_bogie_mass"]) if "point_bogie_mass" in one else np.nan
        self.distance = one["distance"].values
        rate = filters.sampling_rate(one["time"].values)
        lateral, vertical = one["point_ay"].values, one["point_az"].values
        self.hunting = filters.Hunting(self.distance, lateral, rate, settings.instability_frequency)
        self.ride = {
            key: filters.band_pass(signal, rate, *limits.RIDE_BAND)
            for key, signal in (("ay", lateral), ("az", vertical))
        }
        self.slow = filters.low_pass(lateral, rate, limits.CUT_OFF)

    def values(self, section: AssessedSection, settings: AssessmentSettings) -> Iterator[Value]:
        """Everything in one section."""
        if self.is_frame:
            if (largest := self.hunting.largest(section)) is not None:
                yield self._value("frame_instability", section, largest, limits.frame_instability(self.bogie_mass))
            return
        inside = section.holds(self.distance)
        if inside.sum() < 2:
            return
        found: dict[str, float] = {}
        for key, signal in self.ride.items():
            found |= {key: filters.extreme(signal[inside]), f"{key}_rms": np.sqrt((signal[inside] ** 2).mean())}
        if section.zone not in (STRAIGHT, TRANSITION):
            found["ay_qst"] = abs(np.median(self.slow[inside]))
        for key, value in found.items():
            yield self._value(f"body_{key}", section, float(value), limits.body(settings.kind, key))

    def _value(self, key: str, section: AssessedSection, value: float, limit: Limit) -> Value:
        return Value(limits.QUANTITIES[key], section, "", "", value, limit, self.name)


def assessed_points(dataset: xr.Dataset, settings: AssessmentSettings) -> Iterator[AssessedPoint]:
    """Points on car bodies and bogie frames with their filtered accelerations; none where the result has none."""
    if "point_ay" not in dataset or "point_az" not in dataset:
        return
    for i in range(dataset.sizes["point"]):
        one = dataset.isel(point=i)
        level = str(one["point_level"].item()) if "point_level" in one else CAR_BODY
        if level in (CAR_BODY, BOGIE_FRAME):
            yield AssessedPoint(one, level, settings)
