"""The air against the side of a vehicle, and [vehicle.wind]: wind along the track of a run."""

from math import radians
from typing import Annotated, Any, Literal

from pydantic import Field

from wrsim.inputs.section import Section
from wrsim.inputs.values import RisingRows, number, positive
from wrsim.vehicle.wind import Air

Largest = Annotated[float, number(0, 80)]
_Four = Annotated[tuple[float, float, float, float], Field(strict=False)]
Table = RisingRows[Annotated[_Four, Field(description="four numbers [yaw deg, side, lift, roll]")]]


class AirSection(Section, header="wind"):
    """What the wind pushes at."""

    together = ("yaw_deg_side_lift_roll reference_length_m",)
    one_of = ("height_m yaw_deg_side_lift_roll",)

    side_area_m2: Annotated[float, number(0.1, 1000)]
    """Area that the coefficients belong to: of the vehicle's side, or that of reference."""
    height_m: Annotated[float, number(0.1, 6, "m above the rails")] | None = None
    """Height of the centre of the wind's pressure."""
    coefficient: Annotated[float, number(0, 5)] = 1.2
    """Side force over area and dynamic pressure of the wind and the headwind together, for wind across the vehicle; it
    falls with the yaw angle as the sine."""
    yaw_deg_side_lift_roll: Table | None = None
    """Coefficients of side force, lift and roll moment over the yaw angle, as from a wind tunnel; linear between rows,
    constant beyond them. The moment is about the middle of the track at the height of the rails."""
    reference_length_m: Annotated[float, positive(10, "m")] | None = None
    """Length that the coefficient of the roll moment belongs to."""
    density_kg_m3: Annotated[float, number(0.5, 2)] = 1.225
    """Density of the air."""
    gust: Literal["EN 14067-6"] | None = None
    """Shape of the gust along the track, in which the wind is the largest one; a steady wind unless given."""

    def air(self) -> Air:
        """In SI units."""
        table = tuple((radians(yaw), *coefficients) for yaw, *coefficients in self.yaw_deg_side_lift_roll or ())
        lengths: Any = self.height_m or 0.0, self.coefficient, self.density_kg_m3, table, self.reference_length_m or 0.0
        return Air(self.side_area_m2, *lengths)


class WindTable(AirSection, header="[vehicle.wind]"):
    """Wind across the track on the heaviest body of a vehicle, or of each of a train, in a run at constant speed."""

    above = {"peak_m": "begins_m"}

    speed_m_s: Largest
    """Speed of the wind; of a gust the largest."""
    towards: Literal["left", "right"] = "left"
    """Where it blows."""
    begins_m: Annotated[float, number(0, 1e6, "m along the track")]
    """Where the wind begins; it rises over the first half of the way to its peak."""
    peak_m: Annotated[float, number(0, 1e6, "m along the track")]
    """Where the gust has its peak; without a gust the wind is steady from the middle of both places on."""
