"""Wear of a rail head against the unworn rail: vertical W1, lateral W2, W3 at 45 degrees.

Both profiles are upright and in the same axes: a scan is laid on the unworn rail at parts that do not wear (field side,
web, foot), as instruments do; it is not moved here.
"""

from dataclasses import dataclass

import numpy as np

from wrsim.contact.profiles.profile import Profile


@dataclass(frozen=True)
class HeadWear:
    """vertical W1: at the top of the unworn rail, on its centre line; lateral W2: across, `Profile.gauge_depth` (14 mm)
    below that top, on the gauge side; corner W3: along the normal of the unworn gauge corner where that leans by 45
    degrees; field: across, as deep on the field side as both heads reach, where a rail does not wear. All positive
    where material is missing [m]."""

    vertical: float
    lateral: float
    corner: float
    field: float


def head_wear(rail: Profile, unworn: Profile) -> HeadWear:
    """Wear of a rail. Raises InputError where one of the heads does not reach the gauge point of the unworn rail."""
    depth = unworn.gauge_depth
    side, unworn_side = rail.gauge_arclength(rail.top[1] - (unworn.top[1] - depth)), unworn.gauge_arclength(depth)
    lateral = float(rail.at(side)[0] - unworn.at(unworn_side)[0])
    heads = rail.clipped(float(side), rail.length), unworn.clipped(float(unworn_side), unworn.length)
    vertical, corner = (_at_top(*(head.rotated(turn) for head in heads)) for turn in (0.0, -0.25 * np.pi))
    worn_head, unworn_head = rail.mirrored(), unworn.mirrored()
    low = max(
        float(side.w[side.arclength < side.top_arclength].min(initial=side.top[1])) for side in (worn_head, unworn_head)
    )
    level = low + 0.1 * (min(worn_head.top[1], unworn_head.top[1]) - low)
    field = [float(side.at(side.gauge_arclength(side.top[1] - level))[0]) for side in (worn_head, unworn_head)]
    return HeadWear(vertical, lateral, corner, field[0] - field[1])


def _at_top(worn: Profile, unworn: Profile) -> float:
    """How much lower a profile is at the top of another [m]."""
    u, top = unworn.top
    return top - float(worn.at(worn.arclength_of(u))[1])
