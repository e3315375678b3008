"""A leaf spring, its leaves rubbing on each other: ``kind = "leaf-spring"``."""

from __future__ import annotations

from typing import Annotated, ClassVar

from wrsim.inputs.values import number, positive
from wrsim.vehicle.elements.element import Element, Normal, Slider
from wrsim.vehicle.elements.keys import Axes, AxialTable, Glyph, Joint
from wrsim.vehicle.elements.spring import BLUE
from wrsim.vehicle.elements.strut import Strut


class LeafSpringTable(AxialTable, kind="leaf-spring"):
    """An elastic spring and the friction of its leaves, which builds up over a distance (Fancher)."""

    one_of: ClassVar[tuple[str, ...]] = ("friction_force_kN friction_share",)
    glyph: ClassVar[Glyph | None] = Glyph("v", BLUE, hollow=True)

    stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Stiffness of the middle line of its loop."""
    friction_force_kN: Annotated[float, positive(1e4, "kN")] | None = None
    """Half of the height of its loop; or give the share."""
    friction_share: Annotated[float, positive(1, "")] | None = None
    """The same over the force of its middle line: friction that follows the load."""
    friction_travel_mm: Annotated[float, positive(1000, "mm")]
    """Distance over which friction comes within 1/e of its limit after a return."""
    damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0
    """Damping along the same axis."""

    def element(self, joint: Joint, axes: Axes) -> Element:
        distance, force = 1e-3 * self.friction_travel_mm, 1e3 * (self.friction_force_kN or 0.0)
        normal = None if self.friction_share is None else Normal("")
        slider = Slider("fancher", distance=distance, bound=force, friction=self.friction_share or 0.0, normal=normal)
        stiffness, damping = 1e3 * self.stiffness_kN_per_m, 1e3 * self.damping_kNs_per_m
        return Strut(*self.placed(joint, axes), stiffness, damping, slider=slider)
