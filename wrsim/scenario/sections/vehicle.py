"""[vehicle]: which vehicle runs, how fast, and what differs from its file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from wrsim.inputs.section import Fault, Section, both_or_sides
from wrsim.inputs.values import List, number, text
from wrsim.vehicle.files import Radius, WheelName
from wrsim.vehicle.load_tables import LoadTable, PayloadTable


class VehicleSection(Section):
    """model: vehicle file; speed_kmh: needed to run along a track; the rest overrides values of the file.

    drive: what holds the speed: a pull along the track ("train", the default), moments on the axles ("wheels"), nothing
    but springs to a frame of constant speed, if there are any ("free", the default of a single wheelset). loads,
    payloads: more of them, on bodies by their full names.
    """

    header: ClassVar[str] = "[vehicle]"
    aliases: ClassVar[dict[str, str]] = {
        "speed_kmh": "v velocity velocity_kmh v0",
        "model": "file name",
        "wheel": "profile wheel_profile",
        "wheel_left": "profile_left",
        "wheel_right": "profile_right",
        "sprung_mass_kg": "mass mass_kg",
    }

    model: Annotated[str, text('a vehicle file such as "vehicles/wheelset_s1002.toml"')]
    speed_kmh: Annotated[float, number(1, 500, "km/h")] | None = None
    wheel: WheelName | None = None
    wheel_left: WheelName | None = None
    wheel_right: WheelName | None = None
    radius_mm: Radius | None = None
    radius_left_mm: Radius | None = None
    radius_right_mm: Radius | None = None
    drive: Literal["train", "wheels", "free"] | None = None
    sprung_mass_kg: Annotated[float, number(0, 50_000, "mass carried by this wheelset")] | None = None
    loads: List[LoadTable] = ()
    payloads: List[PayloadTable] = ()

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """One key for both sides, or keys for single sides."""
        yield from both_or_sides(raw, "wheel")
        yield from both_or_sides(raw, "radius_mm")
