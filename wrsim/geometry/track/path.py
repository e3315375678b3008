"""A path: the typed shell of `wrsim.core.track.path`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wrsim.core.frames import VECTOR, CurveNodes
from wrsim.core.track import path as core
from wrsim.errors import InputError

COLUMNS = ("x", "y", "z", "tx", "ty", "tz", "roll", "droll_ds", "kx", "ky", "kz")


@dataclass(frozen=True, eq=False)
class Path:
    """A space curve with a frame, by its own arclength.

    table: float64 (n, 11), rows at uniform arclength, columns ``COLUMNS`` (position, tangent, roll and its slope,
    curvature vector: `wrsim.core.track.path`). step: distance of the rows [m].
    """

    table: NDArray[np.float64]
    step: float

    def __post_init__(self) -> None:
        if self.table.ndim != 2 or self.table.shape[0] < 2 or self.table.shape[1] != len(COLUMNS):
            raise InputError(f"path table of shape {self.table.shape}; allowed: (n, {len(COLUMNS)}) with n >= 2")
        if not self.step > 0.0:
            raise InputError(f"path step = {self.step} m; allowed: above zero")
        if not np.all(np.isfinite(self.table)):
            row, column = np.argwhere(~np.isfinite(self.table))[0]
            raise InputError(f"path table: {COLUMNS[column]} of row {row} is not a finite number")

    @cached_property
    def curve(self) -> CurveNodes:
        """The path as kernels take it."""
        return CurveNodes(np.ascontiguousarray(self.table).view(core.NODE).reshape(-1), self.step)

    @property
    def length(self) -> float:
        """Arclength from the first to the last row [m]."""
        return (self.table.shape[0] - 1) * self.step

    def frame(self, s: ArrayLike) -> NDArray[np.float64]:
        """Position and frame at arclength s [m]: shape (..., 4, 3) with the rows r, t, n, b."""
        s = np.asarray(s, dtype=np.float64)
        out = np.empty((s.size, 12))
        core.frame_many(self.curve, np.ascontiguousarray(s.ravel()), out)
        return out.reshape((*s.shape, 4, 3))

    def position(self, s: ArrayLike) -> NDArray[np.float64]:
        """Position at arclength s [m]: shape (..., 3)."""
        return self.frame(s)[..., 0, :]

    def turning(self, s: float) -> tuple[float, float, float]:
        """How the cross-section turns about the tangent, positive where its left side rises [rad/m], and how the path
        bends to the left and up [1/m]."""
        twist, to_left, up = core.bends(self.curve, s, core.frame_at(self.curve, s))
        return float(twist), float(to_left), float(up)

    def curvature(self, s: ArrayLike) -> NDArray[np.float64]:
        """Horizontal curvature at arclength s [1/m], positive to the left; shape of s."""
        s = np.asarray(s, dtype=np.float64)
        out = np.empty(s.size)
        core.curvature_many(self.curve, np.ascontiguousarray(s.ravel()), out)
        return out.reshape(s.shape)

    def locate(self, points: ArrayLike, guess: ArrayLike) -> NDArray[np.float64]:
        """Arclength of the cross-sections through points (..., 3), each the root nearest to its guess [m].

        Not-a-number where the search does not converge.
        """
        points = np.asarray(points, dtype=np.float64)
        shape = points.shape[:-1]
        flat = np.ascontiguousarray(points).reshape(-1, 3).view(VECTOR).reshape(-1)
        out, status = np.empty(flat.size), np.empty(flat.size, dtype=np.int64)
        core.locate_many(self.curve, flat, np.broadcast_to(guess, shape).astype(np.float64).ravel(), out, status)
        out[status != core.LOCATE_OK] = np.nan
        return out.reshape(shape)
