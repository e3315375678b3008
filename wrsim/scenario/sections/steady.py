"""[steady]: curves, cants and speeds at which the steady motion of a vehicle is looked for."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Annotated, Any, Literal

from wrsim.inputs.section import Fault
from wrsim.inputs.values import Series, number, requirement
from wrsim.scenario.sections.table import PlanContext, PlanTable
from wrsim.scenario.sections.track import Cant
from wrsim.scenario.sections.vehicle import VehicleSection

SHARPEST = 20.0
MOST_POINTS = 100_000

Radius = Annotated[float, number(-1e6, 1e6, "m, positive curves to the left, negative to the right")]
Speed = Annotated[float, number(1, 500, "km/h")]


@dataclass(frozen=True)
class SteadyPoint:
    """A curve at a speed: radius [m], positive to the left; cant [m], positive leans inside; speed [m/s]."""

    name: str
    radius: float
    cant: float
    speed: float


@dataclass(frozen=True)
class SteadyPlan:
    """The curves in their order."""

    points: tuple[SteadyPoint, ...]

    def facts(self) -> dict[str, Any]:
        return {"curves": len(self.points)}


class SteadySection(PlanTable, header="[steady]"):
    """Curves, cants and speeds at which the steady motion of a vehicle is looked for."""

    radius_m: Series[Radius]
    """Radii of the curves."""
    cant_mm: Series[Cant] = (0.0,)
    """Cants of the curves."""
    speed_kmh: Series[Speed] | None = None
    """Speeds in the curves; that of [vehicle] unless given."""
    combine: Literal["grid", "rows"] = "grid"
    """Every value with every other, or the first of each, then the second of each, and so on."""

    @classmethod
    def beside(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        steady, vehicle = raw.get("steady"), raw.get("vehicle")
        keys = cls.keys_meant(steady) | VehicleSection.keys_meant(vehicle)
        if isinstance(steady, dict) and "speed_kmh" not in keys:
            yield Fault(("steady", "speed_kmh"), f"must be {requirement(Series[Speed])}", missing=True)

    def consistency(self) -> Iterator[Fault]:
        for radius in self.radius_m:
            if abs(radius) < SHARPEST:
                message = f"has {radius:g}: must be {SHARPEST:g} m or more, or negative and as far from 0"
                yield Fault("radius_m", message)
                return
        sizes = [len(self.radius_m), len(self.cant_mm), len(self.speed_kmh or (0.0,))]
        if self.combine == "rows" and {*sizes} - {1, max(sizes)}:
            yield Fault((), f"the rows have {', '.join(map(str, sizes))} radii, cants and speeds: must be equally many")
        if self.combine == "grid" and prod(sizes) > MOST_POINTS:
            yield Fault((), f"describes {prod(sizes)} points; must be at most {MOST_POINTS}")

    def plan(self, context: PlanContext) -> SteadyPlan:
        speed = None if self.speed_kmh else context.one_speed
        speeds = self.speed_kmh or (() if speed is None else (3.6 * speed,))
        axes = (self.radius_m, self.cant_mm, speeds)
        if self.combine == "rows":
            longest = max(map(len, axes))
            rows = list(zip(*(axis * longest if len(axis) == 1 else axis for axis in axes), strict=True))
        else:
            rows = list(product(*axes))
        points: dict[str, SteadyPoint] = {}
        for radius, cant, v in rows:
            name = f"R{radius:.10g}m_cant{cant:.10g}mm_{v:.10g}kmh"
            points[name] = SteadyPoint(name, radius, cant / 1e3, v / 3.6)
        return SteadyPlan(tuple(points.values()))
