"""Packs arrays into one buffer for kernels that take an arena (core.jit.arena)."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ALIGNMENT = 8  # doubles: every array starts on a cache line of its own


@dataclass(frozen=True)
class Arena:
    """One buffer, its index (K, 4), and the arrays as views on it: what kernels write is seen in the views."""

    buffer: Array
    index: NDArray[np.int64]
    views: tuple[NDArray[Any], ...]

    def part(self, first: int, count: int) -> Arena:
        """``count`` of the arrays as an arena of their own, in the same buffer."""
        return Arena(self.buffer, self.index[first : first + count], self.views[first : first + count])

    def stretches_but(self, left_out: Container[int]) -> list[Array]:
        """Views on the stretches of the buffer that hold all arrays but those with these numbers."""
        found: list[list[int]] = []
        for i, view in enumerate(self.views):
            if i in left_out:
                continue
            begin = int(self.index[i, 0])
            end = begin + room(view)
            if found and found[-1][1] == begin:
                found[-1][1] = end
            else:
                found.append([begin, end])
        return [self.buffer[begin:end] for begin, end in found]


def room(array: NDArray[Any]) -> int:
    """How many numbers of a buffer an array takes."""
    return -(-array.nbytes // 8 // ALIGNMENT) * ALIGNMENT


def pack(arrays: Sequence[NDArray[Any]]) -> Arena:
    """Copy arrays of one to three dimensions, or of one or two with records, into a new arena.

    An array that stands in the row more than once (the same object: a table that wheels share) is copied once.
    """
    index = np.zeros((len(arrays), 4), dtype=np.int64)
    end = 0
    places: dict[int, int] = {}
    for row, array in zip(index, arrays, strict=True):
        shape = array.shape if array.dtype.names is None else (*array.shape, array.dtype.itemsize // 8)
        row[1 : 1 + len(shape)] = shape
        if id(array) in places:
            row[0] = places[id(array)]
            continue
        row[0] = places[id(array)] = end
        end += room(array)
    buffer = np.zeros(end)
    views = []
    for row, array in zip(index, arrays, strict=True):
        view = buffer[row[0] : row[0] + array.nbytes // 8].view(array.dtype).reshape(array.shape)
        view[...] = array
        views.append(view)
    return Arena(buffer, index, tuple(views))
