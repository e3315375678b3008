"""A torsion spring between two bodies about the x axis: ``kind = "anti-roll-bar"``."""

from __future__ import annotations

from typing import Annotated

from wrsim.inputs.values import positive
from wrsim.vehicle.elements.element import ZERO
from wrsim.vehicle.elements.keys import Axes, ElementTable, Joint
from wrsim.vehicle.elements.spring import Spring


class AntiRollBarTable(ElementTable, kind="anti-roll-bar"):
    """A torsion spring between two bodies about the x axis."""

    stiffness_kNm_per_rad: Annotated[float, positive(1e6, "kN m/rad")]
    """Moment over the difference of the roll of both bodies."""

    def element(self, joint: Joint, axes: Axes) -> Spring:
        stiffness = (1e3 * self.stiffness_kNm_per_rad, 0.0, 0.0)
        return Spring(*joint, axes.point(ZERO), turning_stiffness=stiffness)
