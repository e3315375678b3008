"""Whether a wheelset rests on its rails: wheel treads over rail heads, flanges inside of the gauge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wrsim.geometry.profile.flange import LEVEL
from wrsim.geometry.profile.profile import Profile

Array = NDArray[np.float64]

STEP = 0.1e-3
"""Distance of the samples along both profiles [m]."""
FLANGE_SLOPE = 0.6
"""A wheel profile steeper than this (31 degrees), inside of the tape circle, belongs to the flange."""


@dataclass(frozen=True)
class Stand:
    """How one wheel of a centred wheelset rests on its rail.

    u_wheel: where it rests, on the wheel profile [m], not-a-number when wheel and rail miss each other; on_flange: it
    rests on the flange; clearance: from the flange, 10 mm below the tape circle, to the gauge point of the rail [m],
    infinite without flange; reach: u of the outer end of the wheel [m]; rail_top: u of the rail's highest point [m].
    """

    u_wheel: float
    on_flange: bool
    clearance: float
    reach: float
    rail_top: float


def stand(wheel: Profile, rail: Profile, spacing: float, gauge: float) -> Stand:
    """Lower the wheel of a centred wheelset vertically on its rail.

    wheel, rail: profiles, the rail inclined; spacing: distance H of the wheel profile origins [m]; gauge [m],
    at the gauge point of the inclined rail.
    """
    offset = 0.5 * (gauge - spacing) - rail.gauge_point()[0]  # rail origin on the wheel profile
    tread = wheel.table(STEP)[0]
    head = rail.table(STEP)[0]
    low = _envelope(tread[:, 0], -tread[:, 1])
    high = _envelope(head[:, 0] + offset, head[:, 1])
    left, right = max(low[0][0], high[0][0]), min(low[0][-1], high[0][-1])
    rail_top = rail.top[0] + offset
    root = flange_root(tread)
    clearance = 0.5 * (gauge - spacing) - flange_face(tread) if np.isfinite(root) else np.inf
    reach = float(tread[:, 0].max())
    if right - left < STEP:
        return Stand(float("nan"), False, clearance, reach, rail_top)
    u = np.arange(left, right, STEP)
    gap = -np.interp(u, *low) - np.interp(u, *high)
    u_wheel = float(u[np.argmin(gap)])
    return Stand(u_wheel, bool(u_wheel < root), clearance, reach, rail_top)


def flange_root(tread: Array) -> float:
    """Return u where the flange begins [m]: inside of the tape circle and steep; -inf without flange."""
    inside = (tread[:, 0] < 0.0) & (tread[:, 3] > FLANGE_SLOPE * np.abs(tread[:, 2]))
    return float(tread[inside, 0].max()) if inside.any() else -np.inf


def flange_face(tread: Array) -> float:
    """Return the outermost u of the flange 10 mm below the tape circle [m], or its root."""
    deep = (tread[:, 0] < 0.0) & (tread[:, 1] <= -LEVEL)
    return float(tread[deep, 0].max()) if deep.any() else flange_root(tread)


def _envelope(u: Array, height: Array) -> tuple[Array, Array]:
    """Greatest height over each u of a curve that may pass a u more than once, on samples STEP apart."""
    index = np.round((u - u.min()) / STEP).astype(int)
    top = np.full(index.max() + 1, -np.inf)
    np.maximum.at(top, index, height)
    filled = np.isfinite(top)
    return u.min() + STEP * np.flatnonzero(filled), top[filled]
