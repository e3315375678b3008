"""[contact.conical]: conical wheels with a prescribed creep law in the place of profiles and contact models."""

from __future__ import annotations

from typing import Annotated, ClassVar

from wrsim.contact.conical import ConicalWheels
from wrsim.inputs.section import Section
from wrsim.inputs.values import number, positive

CreepCoefficient = Annotated[float, positive(1e6, "kN per creepage of one wheel, such as 10000")]


class ConicalSection(Section):
    """Conical wheels with a prescribed creep law; profiles and the other keys of [contact] then count for nothing."""

    header: ClassVar[str] = "[contact.conical]"
    together: ClassVar[tuple[str, ...]] = ("flange_clearance_mm flange_stiffness_kN_per_m",)
    aliases: ClassVar[dict[str, str]] = {
        "conicity": "lambda", "friction": "mu", "creep_longitudinal_kN": "creep_x_kN f11_kN",
        "creep_lateral_kN": "creep_y_kN f22_kN", "half_spacing_mm": "half_contact_spacing_mm",
    }  # fmt: skip

    conicity: Annotated[float, number(0, 1, "such as 0.05")]
    """Slope of the tread."""
    half_spacing_mm: Annotated[float, number(200, 1500, "mm from the middle of the axle to the contact")]
    """Half the distance between the contacts of both wheels."""
    creep_longitudinal_kN: CreepCoefficient
    """Kalker's longitudinal coefficient: force of one wheel for a creepage of 1."""
    creep_lateral_kN: CreepCoefficient
    """Kalker's lateral coefficient: force of one wheel for a creepage of 1."""
    friction: Annotated[float, positive(2, "creep forces saturate; without it they do not")] | None = None
    """Coefficient at which creep forces saturate."""
    flange_clearance_mm: Annotated[float, number(0, 100, "mm of lateral shift")] | None = None
    """Lateral shift at which the flange touches."""
    flange_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")] | None = None
    """Lateral stiffness of the flange against the rail."""

    def wheels(self) -> ConicalWheels:
        """The same in SI units."""
        clearance = self.flange_clearance_mm
        return ConicalWheels(
            conicity=self.conicity,
            half_spacing=self.half_spacing_mm / 1e3,
            creep_x=1e3 * self.creep_longitudinal_kN,
            creep_y=1e3 * self.creep_lateral_kN,
            friction=self.friction,
            flange_clearance=None if clearance is None else clearance / 1e3,
            flange_stiffness=1e3 * (self.flange_stiffness_kN_per_m or 0.0),
        )
