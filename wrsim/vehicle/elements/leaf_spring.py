"""A leaf spring, its leaves rubbing on each other: ``kind = "leaf-spring"``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar

from wrsim.inputs.section import Fault
from wrsim.inputs.values import number, positive
from wrsim.vehicle.elements.element import Element
from wrsim.vehicle.elements.keys import AXIS, Along, Axes, ElementTable, Glyph, Joint, Place, one_of
from wrsim.vehicle.elements.slider import Normal, Slider
from wrsim.vehicle.elements.spring import BLUE
from wrsim.vehicle.elements.strut import Strut


class LeafSpringTable(ElementTable, kind="leaf-spring"):
    """An elastic spring and the friction of its leaves, which builds up over a distance (Fancher)."""

    glyph: ClassVar[Glyph | None] = Glyph("v", BLUE, hollow=True)

    at_mm: Place
    """Point at which it acts."""
    direction: Along
    """Axis of the body along which it acts."""
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

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """One way to say how large the friction is."""
        yield from one_of(raw, "friction_force_kN", "friction_share")

    def element(self, joint: Joint, axes: Axes) -> Element:
        at, distance = axes.point(self.at_mm), 1e-3 * self.friction_travel_mm
        force = 1e3 * (self.friction_force_kN or 0.0)
        normal = None if self.friction_share is None else Normal("")
        slider = Slider("fancher", distance=distance, bound=force, friction=self.friction_share or 0.0, normal=normal)
        return Strut(
            *joint, (at, at), AXIS[self.direction], 1e3 * self.stiffness_kN_per_m, 1e3 * self.damping_kNs_per_m,
            slider=slider,
        )  # fmt: skip
