"""[contact.friction] and [[contact.friction_sections]]: by contact angle, slip speed and place on the track."""

from __future__ import annotations

from collections.abc import Iterator
from math import radians
from typing import Annotated, Literal

from wrsim.contact.settings import Friction
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import OrTable, number

Coefficient = Annotated[float, number(0, 2, "dry steel 0.3 to 0.5")]
Angle = Annotated[float, number(-30, 80, "contact angle in degrees, flange side positive")]

PLAIN = Friction(0.0)
FROM_DEG, FULL_DEG = 15.0, 35.0


class FrictionSection(Section, header="[contact.friction]"):
    """Friction of both rails or of one, that depends on the place on the rail and on the slip speed."""

    aliases = {
        "static": "mu mu0 coefficient top_of_rail", "gauge_corner": "gauge flange", "falling_ratio": "A",
        "falling_decay_s_per_m": "B",
    }  # fmt: skip
    goes_with = {
        "gauge_corner_from_deg": "gauge_corner", "gauge_corner_full_deg": "gauge_corner",
        "falling_decay_s_per_m": "falling_ratio",
    }  # fmt: skip
    elsewhere = {
        "left": "[contact] as friction_left", "right": "[contact] as friction_right", "friction_left": "[contact]",
        "friction_right": "[contact]",
    }  # fmt: skip

    static: Coefficient
    """Coefficient of friction on the top of the rail, at no slip."""
    gauge_corner: Coefficient | None = None
    """The same on the gauge corner; as on the top unless given."""
    gauge_corner_from_deg: Angle = FROM_DEG
    """Contact angle up to which the rail counts as top."""
    gauge_corner_full_deg: Angle = FULL_DEG
    """Contact angle from which on the rail counts as gauge corner."""
    falling_ratio: Annotated[float, number(0, 1, "limit at fast slip over static, 1 does not fall")] = 1.0
    """Friction at fast slip over that at no slip: A of static ((1 - A) exp(-B w) + A)."""
    falling_decay_s_per_m: Annotated[float, number(0, 100, "dry 0.6, wet 0.2")] = PLAIN.falling_decay
    """How soon friction falls with the slip speed w: B of the same law."""

    def consistency(self) -> Iterator[Fault]:
        if self.gauge_corner_full_deg <= self.gauge_corner_from_deg:
            message = f"must be above gauge_corner_from_deg ({self.gauge_corner_from_deg:g})"
            yield Fault("gauge_corner_full_deg", message)

    def law(self) -> Friction:
        """Return the same in SI units."""
        return self.to_si(Friction, ramp=(radians(self.gauge_corner_from_deg), radians(self.gauge_corner_full_deg)))


FrictionValue = OrTable[Coefficient, FrictionSection]


def law_of(value: float | FrictionSection) -> Friction:
    """The law of a plain coefficient or of a table."""
    return value.law() if isinstance(value, FrictionSection) else Friction(value)


class FrictionPlaceSection(Section, header="[[contact.friction_sections]]"):
    """From a place on another friction holds, which is reached smoothly over transition_m behind that place."""

    aliases = {
        "from_m": "at_m distance_m s_m", "friction": "mu coefficient static", "side": "rail",
        "transition_m": "fade_m length_m",
    }  # fmt: skip

    from_m: Annotated[float, number(0, 1e6, "m along the track")]
    """Where it begins; it holds up to the next section of the same rail."""
    friction: FrictionValue
    """Coefficient of friction, or a table of how it depends on place on the rail and slip."""
    side: Literal["left", "right", "both"] = "both"
    """Which rail has it."""
    transition_m: Annotated[float, number(0.01, 1000, "m; 0.01, the length of a patch, is a step")] = 1.0
    """Length behind from_m over which the friction changes from that before."""
