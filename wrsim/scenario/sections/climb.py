"""[climb]: angles of attack and lateral forces under which a wheelset may climb its flange."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Annotated, Any

from wrsim.inputs.section import Fault
from wrsim.inputs.values import Series, number
from wrsim.scenario.sections.table import PlanContext, PlanTable

USUAL_SPEED = 18.0  # km/h
MOST_POINTS = 10_000


@dataclass(frozen=True)
class ClimbPoint:
    """An angle of attack [rad], positive towards the flange, and a lateral force over the vertical one of its wheel."""

    name: str
    attack: float
    quotient: float


@dataclass(frozen=True)
class ClimbPlan:
    """points: in their order; speed [m/s]; longest: way after which a wheel counts as held [m]."""

    points: tuple[ClimbPoint, ...]
    speed: float
    longest: float

    def facts(self) -> dict[str, Any]:
        return {"points": len(self.points), "speed_kmh": 3.6 * self.speed}


class ClimbSection(PlanTable, header="[climb]"):
    """Angles of attack and lateral forces under which the left wheel of a wheelset may climb its flange."""

    angle_of_attack_mrad: Series[Annotated[float, number(-50, 50, "mrad, positive: towards the flange")]]
    """Angles of attack at which the wheelset is held; each with every Y/Q."""
    Y_over_Q: Series[Annotated[float, number(0.05, 10)]] = (1.99,)
    """Lateral force on the wheel over its vertical force, reached at once and kept."""
    longest_m: Annotated[float, number(0.5, 2000)] = 200.0
    """Way after which a wheel that has not climbed counts as held by the rail."""

    def consistency(self) -> Iterator[Fault]:
        count = len(self.angle_of_attack_mrad) * len(self.Y_over_Q)
        if count > MOST_POINTS:
            yield Fault((), f"describes {count} points; must be at most {MOST_POINTS}")

    def plan(self, context: PlanContext) -> ClimbPlan:
        vehicle, fault = context.vehicle, context.fault
        if vehicle.bodies or len(vehicle.wheelsets) > 1:
            raise fault(("vehicle", "model"), 'is a vehicle; analysis = "climb" knows a single wheelset')
        if vehicle.loads:
            raise fault(("vehicle", "loads"), "are for other analyses: [climb] gives the forces on the wheelset")
        if vehicle.wheelsets[0].wheelset.torsion is not None:
            raise fault(("vehicle", "model"), 'has wheels that turn against each other; analysis = "climb" not')
        points: dict[str, ClimbPoint] = {}
        for attack, quotient in product(self.angle_of_attack_mrad, self.Y_over_Q):
            name = f"{attack:.10g}mrad_{quotient:.10g}"
            points[name] = ClimbPoint(name, attack / 1e3, quotient)
        return ClimbPlan(tuple(points.values()), context.one_speed or USUAL_SPEED / 3.6, self.longest_m)
