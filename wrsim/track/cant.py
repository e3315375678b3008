"""Cant: its base, and the angle of the track plane."""

from typing import Any, Literal, get_args

import numpy as np

STANDARD_GAUGE = 1.435  # standard gauge [m]
RAIL_HEAD_WIDTH = 0.065  # difference of cant base and gauge where no cant base is given [m]
CANT_BASE = STANDARD_GAUGE + RAIL_HEAD_WIDTH
"""Distance that standards measure cant, cant deficiency and twist over, whatever the gauge: 1.5 m."""

Pivot = Literal["centre line", "low rail", "high rail", "left rail", "right rail"]
PIVOTS: tuple[Pivot, ...] = get_args(Pivot)
"""What cant turns the cross-section about: this stays at the height of the grade line."""


def cant_angle(cant: Any, base: float) -> Any:
    """Angle between the track plane and the horizontal [rad], with the sign of the cant: positive with the right rail
    higher, which is a negative roll about the tangent of the track. cant, base [m]; cant may be an array."""
    return np.arcsin(cant / base)


def cant_base(gauge_mm: float, given_mm: float | None) -> float:
    """Distance between the rail tops that cant is measured over [m]."""
    return (gauge_mm + 1e3 * RAIL_HEAD_WIDTH if given_mm is None else given_mm) / 1e3
