"""Coulomb friction along an axis or in a plane: ``kind = "friction"``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from wrsim.inputs.values import number, positive, text
from wrsim.vehicle.elements.element import Array, Element, Normal, Slider, Tables, Triple
from wrsim.vehicle.elements.keys import AXIS, Along, Axes, ElementTable, Glyph, Joint, Place
from wrsim.vehicle.elements.strut import Strut

ACROSS: dict[str, Literal[0, 1, 2]] = {"yz": 0, "xz": 1, "xy": 2}


@dataclass(frozen=True)
class PlaneFriction(Element):
    """Friction in the plane across an axis (0, 1, 2) of the first body, at one point in the design position."""

    at: Triple
    across: Literal[0, 1, 2]
    slider: Slider | None = None

    @property
    def points(self) -> tuple[Triple, Triple]:
        return self.at, self.at

    @property
    def directions(self) -> Array:
        return np.delete(np.eye(3), self.across, axis=0)

    @property
    def stiffness_at_rest(self) -> Array:
        return np.zeros(2)

    def reading_at_rest(self, preload: Array) -> Array:
        return np.zeros(3)

    def write(self, row: Any, preload: Array, tables: Tables) -> None:
        from wrsim.core.body import suspension as kernel

        row.kind, row.direction = kernel.PLANE, self.across
        if self.slider is not None:
            self.slider.write(row, tables, 2)


class FrictionTable(ElementTable, kind="friction"):
    """Coulomb friction along an axis (direction) or in a plane (plane), behind a stiffness where it sticks."""

    aliases: ClassVar[dict[str, str]] = {**ElementTable.aliases, "friction": "mu", "normal_force_kN": "force_kN"}
    one_of: ClassVar[tuple[str, ...]] = ("direction plane", "normal_force_kN normal_spring")
    goes_with: ClassVar[dict[str, str]] = {"normal_spring_axis": "normal_spring", "normal_factor": "normal_spring"}
    glyph: ClassVar[Glyph | None] = Glyph("D", "#CC79A7", hollow=True)

    at_mm: Place
    """Point at which it acts."""
    direction: Along | None = None
    """Axis of the body along which it slides; or give the plane."""
    plane: Literal["xy", "xz", "yz"] | None = None
    """Plane of the body's axes in which it slides; the force is bounded by a circle."""
    friction: Annotated[float, positive(2, "")]
    """Coefficient of friction, sliding and sticking."""
    normal_force_kN: Annotated[float, positive(1e4, "kN")] | None = None
    """Constant normal force; or name a spring that gives it."""
    normal_spring: Annotated[str, text("the name of an element")] | None = None
    """Element whose force presses the surfaces together, by its name in the file."""
    normal_spring_axis: Along = "z"
    """Component of that force where the element is a spring with three."""
    normal_factor: Annotated[float, number(1e-3, 100)] = 1.0
    """Normal force over that force: of a Lenoir link the tangent of its angle to the vertical."""
    stick_stiffness_kN_per_m: Annotated[float, positive(1e7, "kN/m")]
    """Stiffness where it sticks."""
    stick_damping_kNs_per_m: Annotated[float, number(0, 1e5, "kN s/m")] = 0.0
    """Damping where it sticks."""

    def element(self, joint: Joint, axes: Axes) -> Element:
        at = axes.point(self.at_mm)
        normal = None
        if self.normal_spring is not None:
            normal = Normal(self.normal_spring, self.normal_factor, AXIS[self.normal_spring_axis])
        slider = Slider(
            "coulomb", 1e3 * self.stick_stiffness_kN_per_m, 1e3 * self.friction * (self.normal_force_kN or 0.0),
            1e3 * self.stick_damping_kNs_per_m, self.friction, normal,
        )  # fmt: skip
        if self.plane is not None:
            return PlaneFriction(*joint, at, ACROSS[self.plane], slider)
        return Strut(*joint, (at, at), AXIS[self.direction or "x"], slider=slider)
