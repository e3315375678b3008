"""The conicity of profiles that are named: two wheels on two rails, or a map over gauges and folders of profiles."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from math import radians
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from wrsim.analysis.conicity.conicity import wheelset_conicity
from wrsim.contact.profiles.files import noted, notes_of, reading_options
from wrsim.contact.profiles.flange import BACK
from wrsim.contact.profiles.models import load_profile, readings_of
from wrsim.contact.profiles.profile import Kind, Profile
from wrsim.errors import InputError
from wrsim.inputs.checking import check_value
from wrsim.inputs.lookup import model_file
from wrsim.inputs.values import number
from wrsim.results import Result
from wrsim.results.conicity import ConicityMap, conicity_summary
from wrsim.scenario.sections.conicity import AMPLITUDES, ConicityPlan, CurveRadius, FlangeAngle, Roll
from wrsim.scenario.sections.track import Inclination
from wrsim.vehicle.wheelset import Wheel, Wheelset

Models = Sequence[str | Path]
Gauge = Annotated[float, number(400, 2000)]
Diameter = Annotated[float, number(200, 3000)]

MOST_GAUGES = 200

MAP_AMPLITUDES = (2e-3, 3e-3, 4e-3)  # at which the map and its nonlinearity parameter are taken [m]


class Pairing:
    """How wheels are placed on rails."""

    def __init__(
        self,
        flange_back: float,
        inclination: str,
        roll: str,
        models: Models = (),
        reading: Mapping[str, Any] | None = None,
    ) -> None:
        """flange_back: distance of the flange backs [m]; inclination: of the rails, as in a scenario; roll: how the
        shift is counted, see `ConicityPlan`; models: folders in which profiles are looked up; reading: how files of
        points are read, see `reading_options`. Raises InputError.
        """
        slope: float | str = inclination
        with suppress(ValueError):
            slope = float(inclination)
        self.slope: float = check_value(Inclination, slope, "--inclination")
        self.roll: Roll = check_value(Roll, roll, "--roll")
        self.flange_back, self.models, self.reading = flange_back, models, reading or {}
        self.inclined = f", inclined {inclination}" if self.slope else ""

    def spacing(self, left: Profile, right: Profile) -> float:
        """Distance of the origins of two wheel profiles [m]."""
        return self.flange_back + sum(BACK if wheel.back is None else wheel.back for wheel in (left, right))

    def conicity(
        self, wheels: tuple[str, str], rails: tuple[str, str], gauge: float, diameters: tuple[float, float],
        curves: Sequence[float], flange_from_deg: float,
    ) -> Result:  # fmt: skip
        """Conicity of one wheelset; profiles left and right by the names of their files.

        gauge, diameters at the tape circle, curves: radii for the radial steering index [m].
        """
        for diameter in diameters:
            check_value(Diameter, 1e3 * diameter, "--diameters-mm")
        for radius in curves:
            check_value(CurveRadius, radius, "--curve-m")
        check_value(FlangeAngle, flange_from_deg, "--flange-from-deg")
        with reading_options(**self.reading):
            profiles = [self._profile(name, "wheel") for name in wheels]
            left, right = (self._profile(name, "rail").inclined(self.slope) for name in rails)
        mounted = [Wheel(profile, 0.5 * d) for profile, d in zip(profiles, diameters, strict=True)]
        wheelset = Wheelset("wheelset", 0.0, (0.0, 0.0, 0.0), self.spacing(*profiles), mounted[0], mounted[1])
        on = " on ".join(" / ".join(dict.fromkeys((p.name, q.name))) for p, q in (profiles, (left, right)))
        amplitudes = tuple(a / 1e3 for a in AMPLITUDES)
        plan = ConicityPlan(amplitudes, self.roll, tuple(curves), radians(flange_from_deg))
        result = wheelset_conicity(wheelset, (left, right), gauge, plan, on + self.inclined)
        result.dataset.attrs |= noted([*profiles, left, right])
        return result

    def map(self, wheel: str, rail: str, gauges_mm: tuple[float, float, float], radius: float) -> ConicityMap:
        """A map of profiles or folders of them over gauges (first, last, step) [mm]; radius at the tape circle [m]."""
        with reading_options(**self.reading):
            rail_readings, bad = readings_of((rail,), "rail", self.models)
            wheel_readings, worse = readings_of((wheel,), "wheel", self.models)
        wheels = {name: reading.profile for name, reading in wheel_readings.items()}
        rails = {name: reading.profile.inclined(self.slope) for name, reading in rail_readings.items()}
        notes, gauges = notes_of([*wheels.values(), *rails.values()]), [g / 1e3 for g in _gauges(*gauges_mm)]
        chart = conicity_map(
            wheels, rails, gauges, self.spacing, radius, self.roll, f"{wheel} on {rail}{self.inclined}"
        )
        return replace(chart, reasons=(*worse, *bad, *chart.reasons), notes=notes)

    def _profile(self, name: str, kind: Kind) -> Profile:
        return load_profile(model_file(name, self.models), kind)


def _gauges(low: float, high: float, step: float) -> list[float]:
    """Gauges [mm] from one to the other."""
    for gauge in (low, high):
        check_value(Gauge, gauge, "--gauges-mm")
    count = (high - low) / step if step > 0.0 and high >= low else -1.0
    if not 0.0 <= count <= MOST_GAUGES:
        allowed = f"must be FROM, a TO not below it, and a STEP above 0 that makes at most {MOST_GAUGES} of them"
        raise InputError(f"--gauges-mm {low:g} {high:g} {step:g}: {allowed}")
    return [low + i * step for i in range(int(count + 1e-9) + 1)]


def conicity_map(
    wheels: Mapping[str, Profile], rails: Mapping[str, Profile], gauges: Sequence[float],
    spacing: Callable[[Profile, Profile], float], radius: float, roll: Roll = "none", title: str = "",
) -> ConicityMap:  # fmt: skip
    """The map of all pairs, both wheels and both rails alike.

    wheels, rails: profiles by the names they go by, rails inclined; gauges, rolling radius [m]; spacing: that of the
    origins of the profiles of two wheels [m]. A pair that has no conicity at a gauge (wheels off the rails, no place to
    swing about) leaves a gap.
    """
    plan = ConicityPlan(MAP_AMPLITUDES, roll)
    pairs = tuple((wheel, rail) for wheel in wheels for rail in rails)
    values = np.full((2, len(pairs), len(gauges)), np.nan)
    reasons: dict[str, None] = {}
    for i, (wheel, rail) in enumerate(pairs):
        side = Wheel(wheels[wheel], radius)
        apart = spacing(side.profile, side.profile)
        wheelset = Wheelset("wheelset", 0.0, (0.0, 0.0, 0.0), apart, side, side)
        for j, gauge in enumerate(gauges):
            pair = f"{wheel} on {rail}, gauge {1e3 * gauge:.6g} mm"
            try:
                rigid = wheelset_conicity(wheelset, (rails[rail],) * 2, gauge, plan, pair)
                summary = conicity_summary(rigid.wheelset())
            except InputError as error:
                text = str(error)
                reasons[text if text.startswith(pair) else f"{pair}: {text}"] = None
                continue
            # None becomes not-a-number
            values[:, i, j] = np.array([summary["equivalent_conicity"]["3_mm"], summary["nonlinearity_per_mm"]], float)
    return ConicityMap(pairs, tuple(gauges), values[0], values[1], tuple(reasons), title)
