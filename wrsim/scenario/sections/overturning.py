"""[overturning]: a curve, and the wind, in which the speed is looked for at which a vehicle overturns."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from wrsim.inputs.section import Fault
from wrsim.inputs.values import Series, number
from wrsim.scenario.sections.steady import SHARPEST, Radius, Speed
from wrsim.scenario.sections.table import PlanContext, PlanTable
from wrsim.scenario.sections.track import Cant
from wrsim.scenario.sections.wind import AirSection, Largest
from wrsim.vehicle.wind import Air


@dataclass(frozen=True)
class OverturningPlan:
    """radius [m], positive to the left; cant [m]; speeds [m/s]: the lowest, the highest, the closeness of the limits;
    air: None for no wind; winds: their speeds [m/s]; gust: whether runs meet a gust; run: whether the vehicle also runs
    into the curve, over a transition [m]."""

    radius: float
    cant: float
    lowest: float
    highest: float
    tolerance: float
    air: Air | None
    winds: tuple[float, ...]
    gust: bool
    run: bool
    transition: float

    def facts(self) -> dict[str, Any]:
        return {"radius_m": self.radius, "cant_mm": 1e3 * self.cant, "runs": "yes" if self.run else "no"}


class WindSection(AirSection, header="[overturning.wind]"):
    """Wind across the track, from the inside of the curve."""

    speed_m_s: Series[Largest]
    """Speeds of the wind, each on its own; of a gust the largest."""


class OverturningSection(PlanTable, header="[overturning]"):
    """A curve, and the wind, in which the speed is looked for at which a vehicle overturns."""

    above = {"highest_kmh": "lowest_kmh"}

    radius_m: Radius
    """Radius of the curve."""
    cant_mm: Cant = 0.0
    """Cant of the curve."""
    lowest_kmh: Speed = 20.0
    """Speed at which the search begins."""
    highest_kmh: Speed = 400.0
    """Speed at which it ends where the vehicle still stands."""
    tolerance_kmh: Annotated[float, number(0.05, 20, "km/h")] = 0.5
    """How closely the limits are found."""
    run: bool = False
    """Whether the vehicle also runs from straight track into the curve, at speeds that enclose its limit."""
    transition_m: Annotated[float, number(1, 1000, "m")] = 100.0
    """Length of the clothoid ahead of the curve in these runs."""
    wind: WindSection | None = None
    """Wind across the track."""

    def consistency(self) -> Iterator[Fault]:
        if abs(self.radius_m) < SHARPEST:
            message = f"must be {SHARPEST:g} m or more, or negative and as far from 0"
            yield Fault("radius_m", message)
        if self.wind is not None and self.run and len(self.wind.speed_m_s) > 1:
            yield Fault(("wind", "speed_m_s"), "one speed with run = true")
        if self.wind is not None and self.wind.gust is not None and not self.run:
            yield Fault("run", "must be true with a gust: it is for runs")

    def plan(self, context: PlanContext) -> OverturningPlan:
        if not context.vehicle.bodies:
            raise context.fault(("vehicle", "model"), 'is a single wheelset; analysis = "overturning" knows vehicles')
        wind = self.wind
        air, winds = (None, (0.0,)) if wind is None else (wind.air(), wind.speed_m_s)
        gust = wind is not None and wind.gust is not None
        speeds = (self.lowest_kmh / 3.6, self.highest_kmh / 3.6, self.tolerance_kmh / 3.6)
        return OverturningPlan(
            self.radius_m, self.cant_mm / 1e3, *speeds, air, winds, gust, self.run, self.transition_m
        )
