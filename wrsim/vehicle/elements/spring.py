"""Springs and dampers along and about three axes: ``kind = "spring"``, ``"anti-roll-bar"``, and a flexible column,
``"shear-spring"``."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np

from wrsim.inputs.section import Fault
from wrsim.inputs.values import Three, number, positive
from wrsim.vehicle.elements.element import ZERO, Array, Element, Tables, Triple
from wrsim.vehicle.elements.keys import Axes, Damping, ElementTable, Glyph, Joint, Place, Stiffness, scaled

BLUE = "#0072B2"


@dataclass(frozen=True)
class Spring(Element):
    """Springs and dampers along and about three axes, at one point in the design position.

    stiffness [N/m], damping [N s/m], turning (rotational) stiffness [N m/rad] and damping [N m s/rad]: along and about
    x, y, z. column: half of it turns with either body, as in a flexible column clamped at both ends; ``at`` is then its
    middle. preload: force on the second body in the design position [N]; None: to be solved for.
    """

    at: Triple
    stiffness: Triple = ZERO
    damping: Triple = ZERO
    turning_stiffness: Triple = ZERO
    turning_damping: Triple = ZERO
    column: bool = False
    preload: Triple | None = None

    @property
    def points(self) -> tuple[Triple, Triple]:
        return self.at, self.at

    @property
    def stiffness_at_rest(self) -> Array:
        return np.array(self.stiffness)

    def reading_at_rest(self, preload: Array) -> Array:
        return preload

    @property
    def resists_turning(self) -> bool:
        return any(self.turning_stiffness) or any(self.turning_damping)

    def write(self, row: Any, preload: Array, tables: Tables) -> None:
        from wrsim.core.body import suspension as kernel

        row.kind = kernel.SHEAR if self.column else kernel.FIELD
        row.stiffness, row.damping, row.preload = self.stiffness, self.damping, tuple(preload)
        row.turning, row.turning_damping = self.turning_stiffness, self.turning_damping


class SpringTable(ElementTable, kind="spring"):
    """Springs and dampers along and about three axes at one point."""

    glyph: ClassVar[Glyph | None] = Glyph("o", BLUE, hollow=True)

    at_mm: Place
    """Point at which it acts."""
    stiffness_kN_per_m: Stiffness = ZERO
    """Stiffness along the three axes."""
    damping_kNs_per_m: Damping = ZERO
    """Damping along the three axes."""
    rotational_stiffness_kNm_per_rad: Three[Annotated[float, number(0, 1e8, "kN m/rad")]] = ZERO
    """Stiffness about the three axes."""
    rotational_damping_kNms_per_rad: Three[Annotated[float, number(0, 1e6, "kN m s/rad")]] = ZERO
    """Damping about the three axes."""
    preload_kN: Three[Annotated[float, number(-1e4, 1e4, "kN")]] | None = None
    """Force on the body at rest; solved for unless given."""

    def element(self, joint: Joint, axes: Axes) -> Spring:
        return Spring(
            *joint, axes.point(self.at_mm),
            scaled(self.stiffness_kN_per_m), scaled(self.damping_kNs_per_m),
            scaled(self.rotational_stiffness_kNm_per_rad), scaled(self.rotational_damping_kNms_per_rad),
            preload=None if self.preload_kN is None else axes.vector(self.preload_kN),
        )  # fmt: skip


class AntiRollBarTable(ElementTable, kind="anti-roll-bar"):
    """A torsion spring between two bodies about the x axis."""

    stiffness_kNm_per_rad: Annotated[float, positive(1e6, "kN m/rad")]
    """Moment over the difference of the roll of both bodies."""

    def element(self, joint: Joint, axes: Axes) -> Spring:
        stiffness = (1e3 * self.stiffness_kNm_per_rad, 0.0, 0.0)
        return Spring(*joint, axes.point(ZERO), turning_stiffness=stiffness)


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
