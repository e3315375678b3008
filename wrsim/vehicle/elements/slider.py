"""Friction in one direction or in a plane: of friction elements, of leaf springs and of rubber."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

from wrsim.vehicle.elements.tables import Tables

Friction = Literal["coulomb", "fancher", "berg"]


@dataclass(frozen=True)
class Normal:
    """The normal force of a slider: that of an element ``of`` (its full name; "": its own spring), times a factor.

    axis: the component that counts where the element has three, 0, 1, 2; other elements have but one. sense: the sign
    of the force that presses, of surfaces that may be apart; None: that at rest, which they are not.
    """

    of: str
    factor: float = 1.0
    axis: Literal[0, 1, 2] = 2
    sense: float | None = None


@dataclass(frozen=True)
class Slider:
    """A spring behind a surface that slips, see ``core.body.friction``.

    stiffness [N/m], damping [N s/m] where it sticks; instead of the stiffness the distance [m] over which the largest
    force at rest builds up. bound: constant part of the largest force [N]; friction: times the normal force is the rest
    of it.
    """

    law: Friction
    stiffness: float = 0.0
    bound: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    normal: Normal | None = None
    distance: float | None = None

    def pressed_by(self, name: str) -> Slider:
        """The same with the normal force of the element of this full name."""
        return replace(self, normal=None if self.normal is None else replace(self.normal, of=name))

    def write(self, row: Any, tables: Tables, directions: int = 1, at_rest: float = 0.0) -> None:
        """Write its law to a record ELEMENT; how many directions it slips in; at_rest: its element's own force [N]."""
        from wrsim.core.body import friction as kernel

        row.slider = {"coulomb": kernel.COULOMB, "fancher": kernel.FANCHER, "berg": kernel.BERG}[self.law]
        row.stick, row.stick_damping, row.bound = self.stiffness, self.damping, self.bound
        if self.distance is not None:
            row.stick = (self.bound + self.friction * at_rest) / self.distance
        row.slip = tables.slip(3 if self.law == "berg" else directions)
