"""[vehicle]: which wheelset runs, how fast, and what differs from its file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import Quantity, Text

Radius = Quantity(100, 1500, example="radius at the tape circle in mm, such as 460")
ProfileName = Text('a wheel profile file such as "wheels/S1002.toml"')


class VehicleSection(Section):
    """model: vehicle file; speed_kmh: needed to run along a track; the rest overrides values of the file."""

    header: ClassVar[str] = "[vehicle]"
    aliases: ClassVar[dict[str, str]] = {
        "v": "speed_kmh",
        "velocity": "speed_kmh",
        "velocity_kmh": "speed_kmh",
        "v0": "speed_kmh",
        "file": "model",
        "name": "model",
        "profile": "wheel",
        "wheel_profile": "wheel",
        "profile_left": "wheel_left",
        "profile_right": "wheel_right",
        "mass": "sprung_mass_kg",
        "mass_kg": "sprung_mass_kg",
    }

    model: Annotated[str, Text('a vehicle file such as "vehicles/wheelset_s1002.toml"')]
    speed_kmh: Annotated[float, Quantity(1, 500, example="km/h")] | None = None
    wheel: Annotated[str, ProfileName] | None = None
    wheel_left: Annotated[str, ProfileName] | None = None
    wheel_right: Annotated[str, ProfileName] | None = None
    radius_mm: Annotated[float, Radius] | None = None
    radius_left_mm: Annotated[float, Radius] | None = None
    radius_right_mm: Annotated[float, Radius] | None = None
    sprung_mass_kg: Annotated[float, Quantity(0, 50_000, example="mass carried by this wheelset")] | None = (
        None
    )

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """One key for both sides, or keys for single sides."""
        yield from both_or_sides(raw, "wheel", "wheel_left", "wheel_right")
        yield from both_or_sides(raw, "radius_mm", "radius_left_mm", "radius_right_mm")


def both_or_sides(
    raw: dict[str, Any], both: str, left: str, right: str, complete: bool = False
) -> Iterator[Fault]:
    """Refuse a value for both sides next to one for a single side; ``complete``: both sides need a value."""
    sides = [key for key in (left, right) if key in raw]
    if both in raw and sides:
        yield Fault(both, f"is for both sides and cannot stand next to {' and '.join(sides)}")
    elif complete and len(sides) == 1:
        missing = left if right in raw else right
        yield Fault(missing, f"give {left} and {right}, or {both} for both sides", missing=True)
