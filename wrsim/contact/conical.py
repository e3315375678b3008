"""Conical wheels with a prescribed creep law in the place of profiles: plain data, SI units."""

from __future__ import annotations

from dataclasses import dataclass

SUPPORT = 1e9
"""Stiffness that stands for rigid rails under each wheel [N/m]."""

SUPPORT_DAMPING = 1e5
"""Damping of the same [N s/m]."""


@dataclass(frozen=True)
class ConicalWheels:
    """The textbook contact of ``core.body.conical``, alike for all wheels of a vehicle.

    conicity [1]; half_spacing: of the contacts from the middle of the axle [m]; creep_x, creep_y: creep coefficients of
    one wheel along and across [N]; friction: coefficient at which creep forces saturate, None for linear ones.
    flange_clearance [m]: shift at which a flange touches, None without flanges; flange_stiffness [N/m].
    """

    conicity: float
    half_spacing: float
    creep_x: float
    creep_y: float
    friction: float | None = None
    flange_clearance: float | None = None
    flange_stiffness: float = 0.0
