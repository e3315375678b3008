"""[vehicle]: which vehicle runs, how fast, and what differs from its file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from wrsim.inputs.section import Fault, Section, both_or_sides
from wrsim.inputs.values import List, OrTable, number, text
from wrsim.scenario.sections.effort import EffortTable, SlipControlTable
from wrsim.scenario.sections.speed import Speed, SpeedTable
from wrsim.vehicle.load_tables import LoadTable, PayloadTable
from wrsim.vehicle.vehicle_sections import Radius, WheelName


class VehicleSection(Section):
    """Which vehicle runs, how fast, and what differs from its file.

    drive: a pull along the track ("train", the default), moments on the axles ("wheels"), nothing but springs to a
    frame of constant speed, if there are any ("free", the default of a single wheelset).
    """

    header: ClassVar[str] = "[vehicle]"
    aliases: ClassVar[dict[str, str]] = {
        "speed_kmh": "v velocity velocity_kmh v0", "model": "file name", "wheel": "profile wheel_profile",
        "wheel_left": "profile_left", "wheel_right": "profile_right", "sprung_mass_kg": "mass mass_kg",
    }  # fmt: skip

    model: Annotated[str, text('a vehicle file such as "vehicles/wheelset_s1002.toml"')]
    """File of the vehicle, or of a single wheelset."""
    speed_kmh: OrTable[Speed, SpeedTable] | None = None
    """Speed along the track, or a table of it; needed by analyses that run."""
    wheel: WheelName | None = None
    """Profile of all wheels in place of that in the vehicle file."""
    wheel_left: WheelName | None = None
    """Profile of the left wheels in place of that in the vehicle file."""
    wheel_right: WheelName | None = None
    """Profile of the right wheels in place of that in the vehicle file."""
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
    payloads: List[PayloadTable] = ()
    """Further masses or forces that the vehicle is trimmed with; bodies go by their full names."""
    efforts: List[EffortTable] = ()
    """Moments of motors and brakes on single axles, in runs."""
    slip_control: SlipControlTable | None = None
    """Protection of all axles against sliding and spinning."""

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """One key for both sides, or keys for single sides."""
        yield from both_or_sides(raw, "wheel")
        yield from both_or_sides(raw, "radius_mm")
