"""[stability]: speeds of the linearised modes, and how limit cycles are looked for."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from wrsim.inputs.section import Fault
from wrsim.inputs.values import Series, number, positive
from wrsim.scenario.sections.table import PlanContext, PlanTable
from wrsim.vehicle.equivalent import SMALL_STROKE, Stroke

Speed = Annotated[float, number(1, 1000, "km/h")]
SPEEDS = tuple(float(v) for v in range(40, 401, 20))
MOST_SPEEDS = 1000


@dataclass(frozen=True)
class CyclePlan:
    """How limit cycles are looked for: keys of `StabilitySection` in SI units.

    start: None for 10 % above the linear critical speed or the largest speed of the modes.
    """

    start: float | None
    step: float
    tolerance: float
    lowest: float
    kick: float
    small_kick: float
    window: float
    longest: float
    rest: float


@dataclass(frozen=True)
class StabilityPlan:
    """Speeds [m/s] of the modes, rising; highest frequency of modes that are stored [Hz]; stroke for which elements are
    linearised; cycles: None without their search.
    """

    speeds: tuple[float, ...]
    highest: float
    stroke: Stroke
    cycles: CyclePlan | None

    def facts(self) -> dict[str, Any]:
        return {"speeds_kmh": [3.6 * v for v in self.speeds], "limit_cycles": "yes" if self.cycles else "no"}


class StabilitySection(PlanTable, header="[stability]"):
    """Speeds of the linearised modes, and how limit cycles are looked for."""

    above = {"cycle_start_kmh": "lowest_kmh", "small_kick_mm": "rest_mm"}
    not_above = {"tolerance_kmh": "cycle_step_kmh"}

    speed_kmh: Series[Speed] = SPEEDS
    """Speeds at which the modes are computed."""
    highest_Hz: Annotated[float, number(0.1, 1000, "Hz")] = 25.0
    """Highest frequency of modes that are stored."""
    amplitude_mm: Annotated[float, positive(1000, "mm")] = 1e3 * SMALL_STROKE.amplitude
    """Amplitude of the travel at which dampers and friction are linearised."""
    frequency_Hz: Annotated[float, number(0.01, 1000, "Hz")] = SMALL_STROKE.frequency
    """Frequency of that travel."""
    nonlinear: bool = True
    """Whether limit cycles and the nonlinear critical speed are looked for."""
    cycle_start_kmh: Speed | None = None
    """Speed at which the first limit cycle is looked for; above the linear critical speed unless given."""
    cycle_step_kmh: Annotated[float, number(0.1, 100, "km/h")] = 10.0
    """Step of the speed on the way down along the limit cycles."""
    tolerance_kmh: Annotated[float, number(0.01, 50, "km/h")] = 1.0
    """How closely the speed is found at which the cycle dies."""
    lowest_kmh: Speed = 20.0
    """Speed at which the search gives up."""
    kick_mm: Annotated[float, number(0.1, 20, "mm of lateral shift")] = 5.0
    """Lateral shift of the wheelsets that sets the first cycle off."""
    small_kick_mm: Annotated[float, number(0.01, 10, "mm of lateral shift")] = 0.3
    """Lateral shift of the runs that look for cycles from below."""
    window_s: Annotated[float, number(0.2, 20, "s, two periods of the hunting or more")] = 1.0
    """Time over which an amplitude is taken."""
    longest_s: Annotated[float, number(1, 600, "s at one speed")] = 15.0
    """Longest time that a cycle may take to settle at one speed."""
    rest_mm: Annotated[float, number(0.001, 2, "mm")] = 0.1
    """Amplitude below which the vehicle counts as running straight."""

    def consistency(self) -> Iterator[Fault]:
        if len(self.speed_kmh) > MOST_SPEEDS:
            yield Fault("speed_kmh", f"has {len(self.speed_kmh)} speeds; must be at most {MOST_SPEEDS}")
        if self.longest_s < 2.0 * self.window_s:
            yield Fault("longest_s", f"must be at least two windows ({2.0 * self.window_s:g} s)")

    def plan(self, context: PlanContext) -> StabilityPlan:
        start = None if self.cycle_start_kmh is None else self.cycle_start_kmh / 3.6
        cycles = self.to_si(CyclePlan, start=start, step=self.cycle_step_kmh / 3.6)
        speeds = tuple(sorted({v / 3.6 for v in self.speed_kmh}))
        stroke = Stroke(self.amplitude_mm / 1e3, self.frequency_Hz)
        return StabilityPlan(speeds, self.highest_Hz, stroke, cycles if self.nonlinear else None)
