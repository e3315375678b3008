"""Fatigue below the surface by one passage of a contact: the criteria of Dang Van and of Crossland.

The contact moves along x over a point, so the history of its stress is the field along x, and no stress before and
behind. Residual stresses are left out. Both criteria take the smallest hypersphere around the path of the deviator.
"""

from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

import numpy as np

from wrsim.contact.subsurface.loads import SurfaceLoads
from wrsim.contact.subsurface.stress import PAIRS, Stress
from wrsim.errors import InputError
from wrsim.jit import Array

PASSAGE = 41  # stations of the contact along its way over a point
EXCHANGES, SMALLEST = 400, 1e-12  # of weights in `smallest_spheres`; gain of one over the square radius


@dataclass(frozen=True)
class FatigueLimits:
    """Fatigue limits of the steel in fully reversed bending and torsion [Pa]."""

    bending: float
    torsion: float

    def __post_init__(self) -> None:
        if not self.bending / sqrt(3.0) <= self.torsion <= self.bending:
            low, high = (1e-6 * self.bending * part for part in (1.0 / sqrt(3.0), 1.0))
            raise InputError(
                f"torsion_limit_MPa = {1e-6 * self.torsion:g}: must lie from {low:.4g} (limit in bending over the root "
                f"of 3) to {high:.4g} (limit in bending)"
            )

    @property
    def dang_van(self) -> float:
        """Weight of the hydrostatic stress in Dang Van's criterion."""
        return 3.0 * (self.torsion / self.bending - 0.5)

    @property
    def crossland(self) -> float:
        """The same in Crossland's."""
        return 3.0 * self.torsion / self.bending - sqrt(3.0)


class Fatigue(NamedTuple):
    """Equivalent shear stresses of one passage over the limit in torsion [1]; 1: limit of endurance."""

    dang_van: Array
    crossland: Array


def smallest_spheres(paths: Array) -> tuple[Array, Array]:
    """Centres (n, d) and radii (n,) of the smallest spheres around points (n, points, d).

    The centre is a mean of the points; its weights maximise the sphere's dual. In turn, weight goes from the nearest
    point with weight to the farthest one, as much as gains most.
    """
    n, count, _ = paths.shape
    each, weights = np.arange(n), np.full((n, count), 1.0 / count)
    for _ in range(EXCHANGES):
        centre = np.einsum("np,npd->nd", weights, paths)
        square = ((paths - centre[:, None]) ** 2).sum(axis=-1)
        far, near = square.argmax(axis=1), np.where(weights > 0.0, square, np.inf).argmin(axis=1)
        gain = square[each, far] - square[each, near]
        apart = ((paths[each, far] - paths[each, near]) ** 2).sum(axis=-1)
        if (gain <= SMALLEST * square.max(axis=1)).all():
            break
        moved = np.minimum(0.5 * gain / np.maximum(apart, 1e-300), weights[each, near])
        weights[each, far] += moved
        weights[each, near] -= moved
    return centre, np.sqrt(square.max(axis=1))


def fatigue(history: Array, limits: FatigueLimits) -> Fatigue:
    """Both criteria (sub-dang-van, sub-crossland) of histories of stress (..., times, 6) [Pa]."""
    shape, stress = history.shape[:-2], Stress(history)
    flat = stress.tensor.reshape(-1, *history.shape[-2:-1], 3, 3)
    mean = np.trace(flat, axis1=-2, axis2=-1) / 3.0
    deviator = flat - mean[..., None, None] * np.eye(3)
    # six components whose squares sum up to those of the tensor
    path = np.stack([deviator[..., i, j] * (1.0 if i == j else sqrt(2.0)) for i, j in PAIRS], axis=-1)
    centre, radius = smallest_spheres(path)
    middle = np.empty((len(flat), 1, 3, 3))
    for k, (i, j) in enumerate(PAIRS):
        middle[..., i, j] = middle[..., j, i] = centre[:, None, k] / (1.0 if i == j else sqrt(2.0))
    amplitude = np.ptp(np.linalg.eigvalsh(deviator - middle)[..., [0, 2]], axis=-1) / 2.0
    by_dang_van = (amplitude + limits.dang_van * mean).max(axis=-1)
    by_crossland = radius / sqrt(2.0) + limits.crossland * mean.max(axis=-1)
    return Fatigue(*((values / limits.torsion).reshape(shape) for values in (by_dang_van, by_crossland)))


def passage(loads: SurfaceLoads, s: Array, depth: Array, limits: FatigueLimits) -> Fatigue:
    """Fatigue at points of a section across, s and depth broadcast [m], by one passage of the contact."""
    (x0, x1), size = loads.patch[0], loads.size
    x = np.linspace(x0 - 2.0 * size, x1 + 2.0 * size, PASSAGE)
    s, depth = np.broadcast_arrays(s, depth)
    history = loads.stress(x, s[..., None], depth[..., None]).components
    return fatigue(np.concatenate([history, np.zeros_like(history[..., :1, :])], axis=-2), limits)
