"""Rolling contact fatigue of a patch of contact: damage by T-gamma, and the surface fatigue index."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

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
    """Friction that is used: creep force over normal force of a patch [1]; not-a-number without contact."""
    n = np.asarray(normal, dtype=float)
    return np.hypot(fx, fy) / np.where(n > 0.0, n, np.nan)


def fatigue_index(used: ArrayLike, normal: ArrayLike, area: ArrayLike, shear_yield: float) -> Array:
    """Surface fatigue index [1]: above 0 the surface shakes down no more; Ekberg, Kabo and Andersson 2002.

    ``used - 2 pi a b k / (3 N)``: how far, along the traction coefficient, a patch lies beyond the limit p0 / k = 1 /
    mu of the shakedown map. used: friction that is used; normal [N]; area: pi a b [m2]; shear_yield: k [Pa].
    """
    n = np.asarray(normal, dtype=float)
    return np.asarray(used) - 2.0 * np.asarray(area) * shear_yield / (3.0 * np.where(n > 0.0, n, np.nan))
