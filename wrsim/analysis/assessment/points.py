"""Accelerations at points of a vehicle: ride characteristics of car bodies, instability of bogie frames.

Sections go by the distance of the vehicle's reference body, not of the point.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.analysis.assessment import limits
from wrsim.analysis.assessment.filters import band_pass, hunting_frequency, hunting_rms, low_pass, sampling_rate
from wrsim.analysis.assessment.sections import STRAIGHT, TRANSITION
from wrsim.results.assessment import Limit, Section, Value
from wrsim.results.channels import BOGIE_FRAME, CAR_BODY
from wrsim.scenario.sections.assessment import AssessmentSettings

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Point:
    """Filtered accelerations (n,) [m/s2] of one point, and rms of hunting over windows (k,).

    level: ``CAR_BODY`` or ``BOGIE_FRAME``; bogie_mass [kg].
    """

    name: str
    level: str
    bogie_mass: float
    distance: Array
    lateral: Array
    vertical: Array
    slow: Array
    frequency: float
    middles: Array
    rms: Array

    @property
    def is_frame(self) -> bool:
        """True on a bogie frame."""
        return self.level == BOGIE_FRAME

    def values(self, section: Section, settings: AssessmentSettings) -> Iterator[Value]:
        """What can be said of one section."""
        if self.is_frame:
            middle = (self.middles >= section.start) & (self.middles <= section.end)
            if middle.any():
                limit = limits.frame_instability(self.bogie_mass)
                yield self._value("frame_instability", section, self.rms[middle].max(), limit)
            return
        inside = (self.distance >= section.start) & (self.distance <= section.end)
        if inside.sum() < 2:
            return
        for key, signal, name in (("body_ay", self.lateral, "lateral"), ("body_az", self.vertical, "vertical")):
            extremes = np.abs(np.percentile(signal[inside], [limits.LOW, limits.HIGH])).max()
            yield self._value(key, section, extremes, limits.body(settings.kind, name))
            mean = np.sqrt((signal[inside] ** 2).mean())
            yield self._value(f"{key}_rms", section, mean, limits.body(settings.kind, f"{name}_rms"))
        if section.zone not in (STRAIGHT, TRANSITION):
            slow = abs(np.median(self.slow[inside]))
            yield self._value("body_ay_qst", section, slow, limits.body(settings.kind, "lateral_quasi_static"))

    def _value(self, key: str, section: Section, value: float, limit: Limit) -> Value:
        return Value(limits.QUANTITIES[key], section, "", "", float(value), limit, self.name)


def points_of(dataset: xr.Dataset, settings: AssessmentSettings) -> list[Point]:
    """Points on car bodies and bogie frames with their filtered accelerations; none where the result has none."""
    if "point_ay" not in dataset or "point_az" not in dataset:
        return []
    names = [str(n) for n in dataset["point"].values]
    levels = [str(v) for v in dataset["point_level"].values] if "point_level" in dataset else [CAR_BODY] * len(names)
    masses = dataset["point_bogie_mass"].values if "point_bogie_mass" in dataset else np.full(len(names), np.nan)
    distance = dataset["distance"].values
    rate = sampling_rate(dataset["time"].values)
    lateral, vertical = (dataset[c].transpose("time", "point").values for c in ("point_ay", "point_az"))
    found = []
    for i, (name, level) in enumerate(zip(names, levels, strict=True)):
        if level not in (CAR_BODY, BOGIE_FRAME):
            continue
        frequency = settings.instability_frequency or hunting_frequency(lateral[:, i], rate)
        middles, rms = hunting_rms(distance, lateral[:, i], rate, frequency)
        found.append(
            Point(
                name=name,
                level=level,
                bogie_mass=float(masses[i]),
                distance=distance,
                lateral=band_pass(lateral[:, i], rate, *limits.RIDE_BAND),
                vertical=band_pass(vertical[:, i], rate, *limits.RIDE_BAND),
                slow=low_pass(lateral[:, i], rate, limits.CUT_OFF),
                frequency=frequency,
                middles=middles,
                rms=rms,
            )
        )
    return found
