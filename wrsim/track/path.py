"""A path: the typed shell of `wrsim.track.path_kernel`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from wrsim.jit.frames import CurveNodes

COLUMNS = ("x", "y", "z", "tx", "ty", "tz", "roll", "droll_ds", "kx", "ky", "kz")


@dataclass(frozen=True, eq=False)
class Path:
    """A space curve with a frame, by its own arclength.

    table: float64 (n, 11), rows at uniform arclength, columns ``COLUMNS`` (position, tangent, roll and its slope,
    curvature vector: `wrsim.track.path_kernel`). step: distance of the rows [m].
    """

    table: NDArray[np.float64]
    step: float

    @cached_property
    def curve(self) -> CurveNodes:
        """The path as kernels take it."""
        from wrsim.jit.frames import CurveNodes
        from wrsim.track.path_kernel import NODE  # with numba, which a look at a scenario does not need

        return CurveNodes(np.ascontiguousarray(self.table).view(NODE).reshape(-1), self.step)

    @property
    def length(self) -> float:
        """Arclength from the first to the last row [m]."""
        return (self.table.shape[0] - 1) * self.step

    def frame(self, s: ArrayLike) -> NDArray[np.float64]:
        """Position and frame at arclength s [m]: shape (..., 4, 3) with the rows r, t, n, b."""
        from wrsim.track.path_kernel import frame_many

        s = np.asarray(s, dtype=np.float64)
        out = np.empty((s.size, 12))
        frame_many(self.curve, np.ascontiguousarray(s.ravel()), out)
        return out.reshape((*s.shape, 4, 3))

    def position(self, s: ArrayLike) -> NDArray[np.float64]:
        """Position at arclength s [m]: shape (..., 3)."""
        return self.frame(s)[..., 0, :]

    def turning(self, s: float) -> tuple[float, float, float]:
        """How the cross-section turns about the tangent, positive where its left side rises [rad/m], and how the path
        bends to the left and up [1/m]."""
        from wrsim.track.path_kernel import bends, frame_at

        twist, to_left, up = bends(self.curve, s, frame_at(self.curve, s))
        return float(twist), float(to_left), float(up)
