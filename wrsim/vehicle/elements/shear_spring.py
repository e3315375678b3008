"""A flexible column between two heights, such as a coil or an air spring: ``kind = "shear-spring"``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar

from wrsim.inputs.section import Fault
from wrsim.inputs.values import number
from wrsim.vehicle.elements.element import ZERO
from wrsim.vehicle.elements.keys import Axes, Damping, ElementTable, Glyph, Joint, Place, Stiffness, scaled
from wrsim.vehicle.elements.spring import BLUE, Spring


class ShearSpringTable(ElementTable, kind="shear-spring"):
    """A flexible column between two heights, with shear and bending stiffness."""

    glyph: ClassVar[Glyph | None] = Glyph("D", BLUE, hollow=True)

    body_mm: Place
    """Its end on the body."""
    to_mm: Place
    """Its end on the body that it leads to."""
    stiffness_kN_per_m: Stiffness
    """Stiffness along the three axes; across the column it is the shear stiffness."""
    bending_stiffness_kNm_per_rad: Annotated[float, number(0, 1e6, "kN m/rad, of either axis")] = 0.0
    """Stiffness against bending, about either axis across the column."""
    torsional_stiffness_kNm_per_rad: Annotated[float, number(0, 1e6, "kN m/rad")] = 0.0
    """Stiffness against twisting about the column."""
    damping_kNs_per_m: Damping = ZERO
    """Damping along the three axes."""

    def consistency(self) -> Iterator[Fault]:
        """Its axis is vertical."""
        if self.body_mm[:2] != self.to_mm[:2] or self.body_mm[2] == self.to_mm[2]:
            yield Fault("to_mm", "must lie straight above or below body_mm: the column stands upright")

    def element(self, joint: Joint, axes: Axes) -> Spring:
        x, y, z = (0.5 * (a + b) for a, b in zip(self.body_mm, self.to_mm, strict=True))
        bending, torsion = self.bending_stiffness_kNm_per_rad, self.torsional_stiffness_kNm_per_rad
        return Spring(
            *joint, axes.point((x, y, z)),
            scaled(self.stiffness_kN_per_m), scaled(self.damping_kNs_per_m), scaled((bending, bending, torsion)),
            column=True,
        )  # fmt: skip
