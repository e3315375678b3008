"""Curvature of paths and places on them, for many places at once."""

import numpy as np
from numpy.typing import ArrayLike

from wrsim.core.frames import VECTOR
from wrsim.core.track import path as core
from wrsim.geometry.piecewise import Array
from wrsim.geometry.track.path import Path


def curvature(path: Path, s: ArrayLike) -> Array:
    """Horizontal curvature at arclength s [1/m], positive to the left; shape of s."""
    out = np.empty(np.size(s))
    core.curvature_many(path.curve, np.array(s, dtype=np.float64).ravel(), out)
    return out.reshape(np.shape(s))


def locate(path: Path, points: ArrayLike, guess: ArrayLike) -> Array:
    """Arclength of the cross-sections through points (..., 3), each the root nearest to its guess [m], or NaN."""
    points = np.ascontiguousarray(points, dtype=np.float64)
    shape = points.shape[:-1]
    flat = points.reshape(-1, 3).view(VECTOR).reshape(-1)
    out, status = np.empty(flat.size), np.empty(flat.size, dtype=np.int64)
    core.locate_many(path.curve, flat, np.broadcast_to(guess, shape).astype(np.float64).ravel(), out, status)
    out[status != core.LOCATE_OK] = np.nan
    return out.reshape(shape)
