"""Curvature of paths and places on them, for many places at once."""

import numpy as np
from numpy.typing import ArrayLike

from wrsim.jit import Ints, Records, kernel
from wrsim.jit.frames import VECTOR, CurveNodes
from wrsim.track import path_kernel as core
from wrsim.track.path import Path
from wrsim.track.piecewise import Array


@kernel
def curvature_many(curve: CurveNodes, s: Array, out: Array) -> None:
    """Rate of the heading over the horizontal way at s (m,), from `frame_rates`; goes to ``out`` (m,)."""
    for j in range(s.shape[0]):
        (turning, roll_rate), t = core.frame_rates(curve, s[j]), core.frame_at(curve, s[j]).t
        out[j] = (turning.z - roll_rate * t.z) / (t.x * t.x + t.y * t.y) ** 0.5


@kernel
def locate_many(curve: CurveNodes, points: Records, guess: Array, out: Array, status: Ints) -> None:
    """`locate` for points, (m,) records VECTOR, and guesses (m,); results go to ``out`` and ``status`` (m,)."""
    for j in range(points.shape[0]):
        out[j], status[j] = core.locate(curve, points[j], guess[j])


def curvature(path: Path, s: ArrayLike) -> Array:
    """Horizontal curvature at arclength s [1/m], positive to the left; shape of s."""
    out = np.empty(np.size(s))
    curvature_many(path.curve, np.array(s, dtype=np.float64).ravel(), out)
    return out.reshape(np.shape(s))


def locate(path: Path, points: ArrayLike, guess: ArrayLike) -> Array:
    """Arclength of the cross-sections through points (..., 3), each the root nearest to its guess [m], or NaN."""
    points = np.ascontiguousarray(points, dtype=np.float64)
    shape = points.shape[:-1]
    flat = points.reshape(-1, 3).view(VECTOR).reshape(-1)
    out, status = np.empty(flat.size), np.empty(flat.size, dtype=np.int64)
    locate_many(path.curve, flat, np.broadcast_to(guess, shape).astype(np.float64).ravel(), out, status)
    out[status != core.LOCATE_OK] = np.nan
    return out.reshape(shape)
