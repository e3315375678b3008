"""Laws of wear, each for one of two steel bodies that roll on each other, and of rolling contact fatigue of a patch.

Arrays in, arrays out, SI units. All laws of wear give what is lost for every metre rolled. They agree at mild wear:
5.3e-9 kg per metre and newton of T-gamma (USFD), 6.2e-9 (BRR), 4.0e-9 (Archard, friction 0.35); none is fitted to the
others. Sources and their limits: docs/user/wear.md.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
LawName = Literal["usfd", "archard", "brr"]

DENSITY = 7850.0
"""Density of steel [kg/m3]."""

USFD_LIMITS = 10.4e6, 77.2e6
"""T-gamma over the area of contact where mild wear ends and severe wear becomes catastrophic [Pa]."""
USFD_RATES = 5.3, 55.0, 61.9
"""Micrograms per metre and square millimetre: times T-gamma over area in N/mm2; in all; added per N/mm2 beyond."""

BRR_LIMITS = 100.0, 200.0
"""T-gamma where the loss becomes constant, and where it rises again [N]."""

SLIDING_LIMITS = 0.2, 0.7
"""Sliding speeds between which wear is severe in the map of KTH [m/s]."""
SEIZURE = 0.8
"""Pressure over hardness beyond which it is seizure, at any speed."""


@dataclass(frozen=True)
class WearSettings:
    """What is computed.

    laws: in the order of the results; stretch: of the run that counts, from and to [m along the centre line], None
    where the run begins or ends; hardness: of the softer body [Pa]; coefficients: k of Archard's law, slow, faster and
    fast sliding, seizure; shear_yield: yield stress in shear, of the fatigue index [Pa]; step: of the places on
    the profiles [m].
    """

    laws: tuple[LawName, ...]
    stretch: tuple[float | None, float | None] = (None, None)
    hardness: float = 2.8e9
    coefficients: tuple[float, float, float, float] = (5e-4, 35e-4, 5e-4, 350e-4)
    shear_yield: float = 300e6
    step: float = 0.25e-3


def usfd(power: ArrayLike) -> Array:
    """Mass lost per metre rolled and area of contact [kg/m/m2].

    power: T-gamma over the area of contact [N/m2]. Measured up to some 150e6.
    The third branch goes on from the second; codes that print 61.9 w - 4778.7 drop to 0 there.
    """
    w = np.asarray(power, dtype=float)
    mild, severe = USFD_LIMITS
    slope, level, steep = USFD_RATES
    # 1 microgram per metre and square millimetre is 1e-3 kg/m/m2
    return 1e-3 * np.select([w < mild, w <= severe], [slope * 1e-6 * w, level], level + steep * 1e-6 * (w - severe))


def wear_coefficient(
    sliding: ArrayLike, pressure: ArrayLike, hardness: float, coefficients: tuple[float, float, float, float]
) -> Array:
    """k of Archard's law [1] at sliding speeds [m/s] and pressures [Pa], constant in each field of the map."""
    slow, faster, fast, seized = coefficients
    v = np.asarray(sliding, dtype=float)
    by_speed = np.select([v < SLIDING_LIMITS[0], v <= SLIDING_LIMITS[1]], [slow, faster], fast)
    return np.where(np.asarray(pressure) > SEIZURE * hardness, seized, by_speed)


def brr(wear_number: ArrayLike) -> Array:
    """Mass lost per metre rolled [kg/m] at T-gamma of a patch [N].

    In the source the area that a wheel's section loses, in mm2 per km, times its diameter D in mm: 0.25 T-gamma below
    100 N, 25 up to 200 N, 1.19 T-gamma - 154 above. The jump at 200 N belongs to it. The volume of the ring, that
    area times pi D, does not depend on D.
    """
    t = np.asarray(wear_number, dtype=float)
    times_diameter = np.select([t < BRR_LIMITS[0], t <= BRR_LIMITS[1]], [0.25 * t, 25.0], 1.19 * t - 154.0)
    return pi * 1e-12 * DENSITY * times_diameter  # mm2/km times mm is 1e-12 m3/m


def slip_along(full: ArrayLike, columns: int) -> Array:
    """Where a strip slides: |slip| over its largest, at the middles of equal parts from -a to a, (n, columns).

    full: rigid slip of the strips over that at which all of a strip slides, (n,). Strip theory (Carter 1926; FaStrip
    rests on it): with d = a (1 - full) it sticks over 2 d from the leading edge x = a on and slides behind with
    sqrt((x - a + d)^2 - d^2); beyond full = 1 with full - x / a.
    """
    x = (np.arange(columns) + 0.5) * 2.0 / columns - 1.0
    share = np.asarray(full, dtype=float)[:, None]
    d = np.clip(1.0 - share, 0.0, 1.0)
    behind = 1.0 - d - x
    slips = np.where(behind > d, np.sqrt(np.maximum(behind**2 - d**2, 0.0)), 0.0)
    slips = np.where(share >= 1.0, share - x, slips)
    largest = slips.max(axis=1, keepdims=True)
    # next to no slip: all of it in the last part
    slips = np.where(largest > 0.0, slips, (np.arange(columns) == 0).astype(float))
    return np.asarray(slips / np.where(largest > 0.0, largest, 1.0))


# --- rolling contact fatigue ---------------------------------------------------------------------------------------

DAMAGE = (15.0, 0.0), (65.0, 1e-5), (175.0, 0.0)
"""T-gamma [N] and damage at the corners of the function; before the first it is 0, behind the last it falls on."""


def damage(wear_number: ArrayLike) -> Array:
    """Damage of one passage of a patch [1]; 1 is a crack that can be seen, below 0 wear takes cracks away.

    wear_number: T-gamma of the patch [N]. Burstow 2003 (RSSB T115), for rails of grade 220 [recalled, not read].
    """
    t = np.asarray(wear_number, dtype=float)
    (first, _), (peak, most), (last, _) = DAMAGE
    rising, falling = (t - first) * most / (peak - first), (last - t) * most / (last - peak)
    return np.where(t <= first, 0.0, np.minimum(rising, falling))


def fatigue_channels(patches: Mapping[str, Array], wear_number: Array, shear_yield: float) -> dict[str, Array]:
    """Channels of patches from others of them; wear_number: T-gamma [N], shear_yield: k of the rail [Pa]."""
    used = traction_coefficient(patches["Fx"], patches["Fy"], patches["N"])
    index = fatigue_index(used, patches["N"], patches["area"], shear_yield)
    return {"T_gamma_patch": wear_number, "traction_coefficient": used, "fatigue_index": index}


def traction_coefficient(fx: ArrayLike, fy: ArrayLike, normal: ArrayLike) -> Array:
    """Utilised friction: creep force over normal force of a patch [1]; not-a-number without contact."""
    n = np.asarray(normal, dtype=float)
    return np.hypot(fx, fy) / np.where(n > 0.0, n, np.nan)


def fatigue_index(used: ArrayLike, normal: ArrayLike, area: ArrayLike, shear_yield: float) -> Array:
    """Surface fatigue index [1]: above 0 the surface shakes down no more; Ekberg, Kabo and Andersson 2002.

    ``used - 2 pi a b k / (3 N)``: how far, along the traction coefficient, a patch lies beyond the limit p0 / k = 1 /
    mu of the shakedown map. used: utilised friction; normal [N]; area: pi a b [m2]; shear_yield: k [Pa].
    """
    n = np.asarray(normal, dtype=float)
    return np.asarray(used) - 2.0 * np.asarray(area) * shear_yield / (3.0 * np.where(n > 0.0, n, np.nan))
