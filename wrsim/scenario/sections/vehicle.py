"""[vehicle]: which vehicle runs, how fast, and what differs from its file."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Field

from wrsim.inputs.section import Fault, Section, both_or_sides
from wrsim.inputs.values import List, OrTable, RisingRows, Row, Two, number, text, within
from wrsim.scenario.sections.wind import WindTable
from wrsim.vehicle.loads import Effort, Over
from wrsim.vehicle.out_of_round import AnyOutOfRoundTable
from wrsim.vehicle.speed import SpeedProfile
from wrsim.vehicle.vehicle_sections import LoadTable, PayloadTable, Radius, WheelName

LOWEST, HIGHEST = 1.0, 500.0  # [km/h]
Speed = Annotated[float, number(LOWEST, HIGHEST, "km/h")]

STEEPEST = 10.0
"""No wheel on a rail brakes or accelerates a vehicle by more [m/s2]."""

_Rows = Annotated[
    RisingRows[Row],
    within(LOWEST, HIGHEST, "km/h"),
    Field(min_length=2, description="two or more rows in rising order, each {each}"),
]
SpeedOverTime = _Rows[Annotated[Two[float], Field(description="two numbers [time s, speed km/h]")]]
SpeedOverDistance = _Rows[Annotated[Two[float], Field(description="two numbers [distance m, speed km/h]")]]


class SpeedTable(Section, header="[vehicle.speed_kmh]"):
    """The speed of the vehicle's origin over the time of the run or over its distance along the track.

    Between two rows the acceleration is constant; before the first and behind the last row the speed is.
    """

    one_of = ("distance_m_speed_kmh time_s_speed_kmh",)

    time_s_speed_kmh: SpeedOverTime | None = None
    """Speed over the time of the run; between two rows it is linear."""
    distance_m_speed_kmh: SpeedOverDistance | None = None
    """Speed over the distance of the vehicle's origin; between two rows its square is linear."""

    def consistency(self) -> Iterator[Fault]:
        key = "distance_m_speed_kmh" if self.time_s_speed_kmh is None else "time_s_speed_kmh"
        rows = self.time_s_speed_kmh or self.distance_m_speed_kmh or ()
        unit = "m" if key == "distance_m_speed_kmh" else "s"
        for i, ((x, v), (later, w)) in enumerate(pairwise(rows), 1):
            change = 0.5 * (v + w) / 3.6 if unit == "m" else 1.0
            rate = (w - v) / 3.6 / (later - x) * change
            if abs(rate) > STEEPEST:
                jump = f"goes from {v:g} to {w:g} km/h within {later - x:.6g} {unit}, {rate:.3g} m/s2"
                yield Fault((key, i), f"{jump}: must be at most {STEEPEST:g} m/s2, more than any rail can give")

    def profile(self, start: float) -> SpeedProfile:
        """The same in SI units for a run from a start [m]."""
        if self.time_s_speed_kmh is not None:
            return SpeedProfile.over_time([(t, v / 3.6) for t, v in self.time_s_speed_kmh])
        return SpeedProfile.over_distance([(s, v / 3.6) for s, v in self.distance_m_speed_kmh or ()], start)


LARGEST = 200.0
"""Largest moment on an axle [kN m]; strong locomotives have some 70."""

_Moments = Annotated[RisingRows[Row], within(-LARGEST, LARGEST, "kNm")]
OverTime = _Moments[Annotated[Two[float], Field(description="two numbers [time s, moment kNm]")]]
OverDistance = _Moments[Annotated[Two[float], Field(description="two numbers [distance m, moment kNm]")]]


class EffortTable(Section, header="[[vehicle.efforts]]"):
    """A moment on each of some wheelsets over the time or the distance of the vehicle's origin, positive forward."""

    one_of = ("moment_kNm time_s_moment_kNm distance_m_moment_kNm",)

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
        over: Over = "time" if self.distance_m_moment_kNm is None else "distance"
        rows = self.time_s_moment_kNm or self.distance_m_moment_kNm or ((0.0, self.moment_kNm or 0.0),)
        return Effort(wheelset, tuple((x, 1e3 * moment) for x, moment in rows), over, self.wheel)


class SlipControlTable(Section, header="[vehicle.slip_control]"):
    """Protection against sliding and spinning wheels: no axle slips by more than slip_kmh + creepage V.

    A moment is given in full up to half of that, from there on linearly less, nothing at the limit.
    """

    slip_kmh: Annotated[float, number(0, 50, "km/h of slip speed")] = 0.0
    """Part of the limit that does not change with the speed."""
    creepage: Annotated[float, number(0, 1, "slip speed over the vehicle's speed")] = 0.0
    """Part of the limit that grows with the speed."""

    def consistency(self) -> Iterator[Fault]:
        if self.slip_kmh == 0.0 == self.creepage:
            yield Fault("creepage", "or slip_kmh must be above 0: at a limit of 0 no moment would be given")


_Shares = Annotated[RisingRows[Row], within(0, 1, "of the largest force")]


class BrakesTable(Section, header="[vehicle.brakes]"):
    """A command to the brakes of a train, which follow it along its brake pipe, in runs."""

    time_s_share: _Shares[Annotated[Two[float], Field(description="two numbers [time s, share of the largest force]")]]
    """Share of the largest force of each vehicle that is commanded from a time on; none before the first row."""


class VehicleSection(Section, header="[vehicle]"):
    """Which vehicle runs, how fast, and what differs from its file.

    drive: a pull along the track ("train", the default), moments on the axles ("wheels"), nothing but springs to a
    frame of constant speed, if there are any ("free", the default of a single wheelset).
    """

    goes_with = {"wheel_changes": "wheel wheel_left wheel_right"}

    model: Annotated[str, text('a vehicle file such as "vehicles/wheelset_s1002.toml"')]
    """File of the vehicle, or of a single wheelset."""
    speed_kmh: OrTable[Speed, SpeedTable] | None = None
    """Speed along the track, or a table of it; needed by analyses that run."""
    wheel: WheelName | None = None
    """Profile of all wheels in place of that in the vehicle file."""
    wheel_changes: Annotated[
        dict[str, Any], Field(description='a table such as {flange_angle_deg = 70, "removals[0].depth_mm" = 0.2}')
    ] = Field(default_factory=dict)
    """Values of the file of `wheel` that are changed: keys of a profile file."""
    wheel_left: WheelName | None = None
    """Profile of the left wheels in place of that in the vehicle file."""
    wheel_right: WheelName | None = None
    """Profile of the right wheels in place of that in the vehicle file."""
    changes: Annotated[
        dict[str, Any], Field(description='a table such as {"bogie.primary.stiffness_kN_per_m.2" = 1500}')
    ] = Field(default_factory=dict)
    """Values of the vehicle's file that are changed, by the names of its parts and elements."""
    radius_mm: Radius | None = None
    """Rolling radius of all wheels at the tape circle, in place of that in the vehicle file."""
    radius_left_mm: Radius | None = None
    """Rolling radius of the left wheels at the tape circle."""
    radius_right_mm: Radius | None = None
    """Rolling radius of the right wheels at the tape circle."""
    drive: Literal["train", "wheels", "free"] | None = None
    """What holds the speed: a pull along the track, moments on the axles, or nothing."""
    sprung_mass_kg: Annotated[float, number(0, 50_000, "mass carried by this wheelset")] | None = None
    """Mass that presses on the axle of a single wheelset, in place of that in its file."""
    loads: List[LoadTable] = ()
    """Further forces on bodies, such as wind; bodies go by their full names."""
    wind: WindTable | None = None
    """Wind along the track, in runs."""
    payloads: List[PayloadTable] = ()
    """Further masses or forces that the vehicle is trimmed with; bodies go by their full names."""
    out_of_round: List[AnyOutOfRoundTable] = ()
    """How wheels are out of round, beside what the vehicle's file says."""
    efforts: List[EffortTable] = ()
    """Moments of motors and brakes on single axles, in runs."""
    brakes: BrakesTable | None = None
    """Command to the brakes of a train with a brake pipe."""
    slip_control: SlipControlTable | None = None
    """Protection of all axles against sliding and spinning."""

    @classmethod
    def raw_faults(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        yield from both_or_sides(raw, "wheel")
        yield from both_or_sides(raw, "radius_mm")
