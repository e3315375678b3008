"""Packs arrays into one buffer for kernels that take an arena (core.arena)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ALIGNMENT = 8  # doubles: every array starts on a cache line of its own


@dataclass(frozen=True)
class Arena:
    """One buffer, its index (K, 4), and the arrays as views on it: what kernels write is seen in the views."""

    buffer: Array
    index: NDArray[np.int64]
    views: tuple[Array, ...]


def pack(arrays: Sequence[Array]) -> Arena:
    """Copy arrays of one to three dimensions into a new arena.

    An array that stands in the row more than once (the same object: a table that wheels share) is copied once.
    """
    index = np.zeros((len(arrays), 4), dtype=np.int64)
    end = 0
    places: dict[int, int] = {}
    for row, array in zip(index, arrays, strict=True):
        row[1 : 1 + array.ndim] = array.shape
        if id(array) in places:
            row[0] = places[id(array)]
            continue
        row[0] = places[id(array)] = end
        end += -(-array.size // ALIGNMENT) * ALIGNMENT
    buffer = np.zeros(end)
    views = []
    for row, array in zip(index, arrays, strict=True):
        view = buffer[row[0] : row[0] + array.size].reshape(array.shape)
        view[...] = array
        views.append(view)
    return Arena(buffer, index, tuple(views))
