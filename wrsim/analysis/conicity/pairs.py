"""The conicity of profiles that are named: two wheels on two rails, or a map over gauges and folders of profiles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from wrsim.analysis.conicity.conicity import conicity
from wrsim.analysis.conicity.maps import conicity_map, profiles_of
from wrsim.errors import InputError
from wrsim.geometry.profile.flange import BACK
from wrsim.geometry.profile.models import load_profile
from wrsim.inputs.checking import check_value
from wrsim.inputs.lookup import model_file
from wrsim.inputs.values import number
from wrsim.results.conicity import ConicityMap
from wrsim.scenario.sections.conicity import AMPLITUDES, ConicityPlan, CurveRadius, FlangeAngle, Roll
from wrsim.scenario.sections.track import Inclination
from wrsim.vehicle.wheelset import Wheel, Wheelset

if TYPE_CHECKING:
    from wrsim.geometry.profile.profile import Kind, Profile
    from wrsim.results import Result

Models = Sequence[str | Path]
Gauge = Annotated[float, number(400, 2000)]
Diameter = Annotated[float, number(200, 3000)]

MOST_GAUGES = 200


@dataclass(frozen=True)
class Pairing:
    """How wheels stand on rails. flange_back: distance of the flange backs [m]; inclination: of the rails, as in a
    scenario; roll: how the shift is counted, see `ConicityPlan`; models: folders in which profiles are looked up.

    Raises InputError.
    """

    flange_back: float
    inclination: str
    roll: str
    models: Models = ()

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
        profiles = [self._profile(name, "wheel") for name in wheels]
        left, right = (self._profile(name, "rail").inclined(self._slope) for name in rails)
        mounted = [Wheel(profile, 0.5 * d) for profile, d in zip(profiles, diameters, strict=True)]
        wheelset = Wheelset("wheelset", 0.0, (0.0, 0.0, 0.0), self._spacing, mounted[0], mounted[1])
        names = [_both(p.name, q.name) for p, q in (profiles, (left, right))]
        amplitudes = tuple(a / 1e3 for a in AMPLITUDES)
        plan = ConicityPlan(amplitudes, self._roll, tuple(curves), radians(flange_from_deg))
        return conicity(wheelset, (left, right), gauge, plan, self._title(*names))

    def map(self, wheel: str, rail: str, gauges_mm: tuple[float, float, float], radius: float) -> ConicityMap:
        """A map of profiles or folders of them over gauges (first, last, step) [mm]; radius at the tape circle [m]."""
        rails = {name: p.inclined(self._slope) for name, p in self._profiles(rail, "rail").items()}
        wheels, gauges = self._profiles(wheel, "wheel"), [g / 1e3 for g in _gauges(*gauges_mm)]
        return conicity_map(wheels, rails, gauges, self._spacing, radius, self._roll, self._title(wheel, rail))

    @property
    def _spacing(self) -> float:
        return self.flange_back + 2.0 * BACK

    @property
    def _roll(self) -> Roll:
        return check_value(Roll, self.roll, "--roll")  # type: ignore[no-any-return]

    @property
    def _slope(self) -> float:
        try:
            slope: Any = float(self.inclination)
        except ValueError:
            slope = self.inclination
        return check_value(Inclination, slope, "--inclination")  # type: ignore[no-any-return]

    def _title(self, wheels: str, rails: str) -> str:
        return f"{wheels} on {rails}" + (f", inclined {self.inclination}" if self._slope else "")

    def _profile(self, name: str, kind: Kind) -> Profile:
        return load_profile(model_file(name, self.models), kind)

    def _profiles(self, name: str, kind: Kind) -> dict[str, Profile]:
        """One profile by the name of its file, or those of a folder."""
        return profiles_of(Path(name), kind) if Path(name).is_dir() else {Path(name).stem: self._profile(name, kind)}


def _both(left: str, right: str) -> str:
    return left if left == right else f"{left} / {right}"


def _gauges(low: float, high: float, step: float) -> list[float]:
    """Gauges [mm] from one to the other."""
    for gauge in (low, high):
        check_value(Gauge, gauge, "--gauges-mm")
    count = (high - low) / step if step > 0.0 and high >= low else -1.0
    if not 0.0 <= count <= MOST_GAUGES:
        words = f"must be FROM, a TO not below it, and a STEP above 0 that makes at most {MOST_GAUGES} of them"
        raise InputError(f"--gauges-mm {low:g} {high:g} {step:g}: {words}")
    return [low + i * step for i in range(int(count + 1e-9) + 1)]
