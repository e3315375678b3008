"""[vehicle.speed_kmh]: a speed that changes on the way."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, ClassVar

from pydantic import Field

from wrsim.inputs.rows import Row
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import Two, number
from wrsim.vehicle.speed import SpeedProfile

LOWEST, HIGHEST = 1.0, 500.0  # [km/h]
Speed = Annotated[float, number(LOWEST, HIGHEST, "km/h")]

STEEPEST = 10.0
"""No wheel on a rail brakes or accelerates a vehicle by more [m/s2]."""

_Rows = Annotated[
    tuple[Row, ...], Field(strict=False, min_length=2, description="a list of rows in rising order, each {each}")
]
OverTime = _Rows[Annotated[Two[float], Field(description="two numbers [time s, speed km/h]")]]
OverDistance = _Rows[Annotated[Two[float], Field(description="two numbers [distance m, speed km/h]")]]


class SpeedTable(Section):
    """The speed of the vehicle's origin over the time of the run or over its distance along the track.

    Between two rows the acceleration is constant; before the first and behind the last row the speed is.
    """

    header: ClassVar[str] = "[vehicle.speed_kmh]"
    one_of: ClassVar[tuple[str, ...]] = ("distance_m_speed_kmh time_s_speed_kmh",)

    time_s_speed_kmh: OverTime | None = None
    """Speed over the time of the run; between two rows it is linear."""
    distance_m_speed_kmh: OverDistance | None = None
    """Speed over the distance of the vehicle's origin; between two rows its square is linear."""

    def consistency(self) -> Iterator[Fault]:
        """Rows that rise, and accelerations that a wheel on a rail can give."""
        key = "distance_m_speed_kmh" if self.time_s_speed_kmh is None else "time_s_speed_kmh"
        rows = self.time_s_speed_kmh or self.distance_m_speed_kmh or ()
        unit = "m" if key == "distance_m_speed_kmh" else "s"
        if rows[0][0] < 0.0:
            yield Fault((key, 0), f"begins with {rows[0][0]:g}: must not lie before 0")
        for i, (_, v) in enumerate(rows):
            if not LOWEST <= v <= HIGHEST:
                yield Fault((key, i), f"has {v:g} km/h: must be from {LOWEST:g} to {HIGHEST:g} km/h")
        for i, ((x, v), (later, w)) in enumerate(pairwise(rows), 1):
            if later < x:
                yield Fault((key, i), "must lie behind the row before it: the first numbers rise")
                return
            jump = f"goes from {v:g} to {w:g} km/h within {later - x:.6g} {unit}"
            if later == x:
                words = "asks for an infinite acceleration: must lie behind the row before it"
                yield Fault((key, i), f"{jump}, which {words}")
                return
            change = 0.5 * (v + w) / 3.6 if unit == "m" else 1.0
            rate = (w - v) / 3.6 / (later - x) * change
            if abs(rate) > STEEPEST:
                yield Fault((key, i), f"{jump}, {rate:.3g} m/s2: must be at most {STEEPEST:g}, which no rail gives")

    def profile(self, start: float) -> SpeedProfile:
        """The same in SI units for a run from a start [m]."""
        if self.time_s_speed_kmh is not None:
            return SpeedProfile.over_time([(t, v / 3.6) for t, v in self.time_s_speed_kmh])
        return SpeedProfile.over_distance([(s, v / 3.6) for s, v in self.distance_m_speed_kmh or ()], start)
