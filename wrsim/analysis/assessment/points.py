"""Accelerations at points of a vehicle: ride characteristics of car bodies, instability of bogie frames.

Sections go by the distance of the vehicle's reference body, not of the point.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from wrsim.analysis.assessment import limits
from wrsim.analysis.assessment.filters import Hunting, band_pass, extreme, low_pass, sampling_rate
from wrsim.analysis.assessment.sections import STRAIGHT, TRANSITION
from wrsim.results.assessment import AssessedSection, Limit, Value
from wrsim.results.channels import BOGIE_FRAME, CAR_BODY
from wrsim.scenario.sections.assessment import AssessmentSettings


class AssessedPoint:
    """Filtered accelerations [m/s2] of one point on a car body or a bogie frame."""

    def __init__(self, one: xr.Dataset, level: str, settings: AssessmentSettings) -> None:
        """one: what a result has of the point; level: ``CAR_BODY`` or ``BOGIE_FRAME``."""
        self.name, self.is_frame = str(one["point"].item()), level == BOGIE_FRAME
        self.bogie_mass = float(one["point_bogie_mass"]) if "point_bogie_mass" in one else np.nan
        self.distance = one["distance"].values
        rate, lateral, vertical = sampling_rate(one["time"].values), one["point_ay"].values, one["point_az"].values
        self.hunting = Hunting(self.distance, lateral, rate, settings.instability_frequency)
        self.ride = {
            key: band_pass(signal, rate, *limits.RIDE_BAND) for key, signal in (("ay", lateral), ("az", vertical))
        }
        self.slow = low_pass(lateral, rate, limits.CUT_OFF)

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
            found |= {key: extreme(signal[inside]), f"{key}_rms": np.sqrt((signal[inside] ** 2).mean())}
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
