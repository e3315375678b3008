"""[[vehicle.efforts]] and [vehicle.slip_control]: what motors and brakes ask of the axles."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field

from wrsim.inputs.rows import RisingRows
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import List, Two, number, refuse, text
from wrsim.vehicle.loads import Effort, Over, SlipControl

LARGEST = 200.0
"""Largest moment on an axle [kN m]; strong locomotives have some 70."""

Rows = tuple[tuple[float, float], ...]


def _allowed(rows: Rows) -> Rows:
    """Rows (x, moment) whose moments are possible."""
    for position, row in enumerate(rows):
        if abs(row[1]) > LARGEST:
            raise refuse(f"row [{position}] has {row[1]:g} kNm: must be from {-LARGEST:g} to {LARGEST:g}")
    return rows


OverTime = Annotated[
    RisingRows[Annotated[Two[float], Field(description="two numbers [time s, moment kNm]")]], AfterValidator(_allowed)
]
OverDistance = Annotated[
    RisingRows[Annotated[Two[float], Field(description="two numbers [distance m, moment kNm]")]],
    AfterValidator(_allowed),
]


class EffortTable(Section):
    """A moment on each of some wheelsets over the time or the distance of the vehicle's origin, positive forward."""

    header: ClassVar[str] = "[[vehicle.efforts]]"
    one_of: ClassVar[tuple[str, ...]] = ("moment_kNm time_s_moment_kNm distance_m_moment_kNm",)
    aliases: ClassVar[dict[str, str]] = {"on": "wheelsets wheelset axles axle", "moment_kNm": "torque_kNm"}

    on: List[Annotated[str, text("the name of a wheelset")]] = ()
    """Wheelsets that the moment acts on, each alike; all of them where it is not given."""
    wheel: Literal["left", "right", "both"] = "both"
    """Which of the wheels the moment acts on, where they turn on their own."""
    moment_kNm: Annotated[float, number(-LARGEST, LARGEST, "kNm on an axle, brakes negative")] | None = None
    """Moment that stays the same, positive forward."""
    time_s_moment_kNm: OverTime | None = None
    """Moment over the time of the run, linear between rows, constant beyond them."""
    distance_m_moment_kNm: OverDistance | None = None
    """Moment over the distance of the vehicle's origin, linear between rows, constant beyond them."""

    def effort(self, wheelset: str) -> Effort:
        """The effort on a wheelset in SI units."""
        over: Over = "time" if self.distance_m_moment_kNm is None else "distance"
        rows = self.time_s_moment_kNm or self.distance_m_moment_kNm or ((0.0, self.moment_kNm or 0.0),)
        return Effort(wheelset, tuple((x, 1e3 * moment) for x, moment in rows), over, self.wheel)


class SlipControlTable(Section):
    """Protection against sliding and spinning wheels: no axle slips by more than slip_kmh + creepage V.

    A moment is given in full up to half of that, from there on linearly less, nothing at the limit.
    """

    header: ClassVar[str] = "[vehicle.slip_control]"
    aliases: ClassVar[dict[str, str]] = {"slip_kmh": "slip_speed_kmh", "creepage": "slip_ratio"}

    slip_kmh: Annotated[float, number(0, 50, "km/h of slip speed")] = 0.0
    """Part of the limit that does not change with the speed."""
    creepage: Annotated[float, number(0, 1, "slip speed over the vehicle's speed")] = 0.0
    """Part of the limit that grows with the speed."""

    def consistency(self) -> Iterator[Fault]:
        """A limit above nothing."""
        if self.slip_kmh == 0.0 == self.creepage:
            yield Fault("creepage", "or slip_kmh must be above 0: at a limit of 0 no moment would be given")

    def control(self) -> SlipControl:
        """The same in SI units."""
        return SlipControl(self.slip_kmh / 3.6, self.creepage)
