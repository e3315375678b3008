"""Room for the numbers of long runs.

Few numbers stand in memory. Many go to a file without a name, which its system removes with its process: they are
written block by block, and every reading takes what it asks for and nothing more. So the memory that a run needs does
not grow with its length.
"""

from __future__ import annotations

import mmap
import os
import tempfile
from collections.abc import Iterable, Mapping
from itertools import chain
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray
from xarray.backends.common import BackendArray
from xarray.core import indexing

LARGE = 16_000_000
"""Bytes that stand in memory at most."""


class OnDisk(BackendArray):
    """An array that is mapped from a file: xarray reads from it what is asked for."""

    def __init__(self, mapped: NDArray[Any]) -> None:
        self.mapped, self.shape, self.dtype = mapped, mapped.shape, mapped.dtype

    def __setitem__(self, block: slice, values: NDArray[Any]) -> None:
        """Write some samples, the first dimension."""
        self.mapped[block] = values
        let_go(self.mapped)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._read)

    def _read(self, key: tuple[Any, ...]) -> NDArray[Any]:
        found = np.array(self.mapped[key])
        let_go(self.mapped)
        return found


class Channels:
    """Channels of n samples, filled block by block; where they are many, on disk in ``folder`` (None: in memory)."""

    def __init__(self, n: int, folder: Path | None) -> None:
        self.n, self.folder = n, folder
        self.arrays: dict[str, Any] = {}

    def put(self, block: slice, values: Mapping[str, NDArray[Any]]) -> None:
        """Channels of the samples of a block; the first one says which channels there are."""
        if not self.arrays:
            self._make(values)
        for name, own in values.items():
            self.arrays[name][block] = own

    def _make(self, values: Mapping[str, NDArray[Any]]) -> None:
        shapes = {name: (self.n, *own.shape[1:]) for name, own in values.items()}
        sizes = {name: own.dtype.itemsize * int(np.prod(shapes[name])) for name, own in values.items()}
        whole = self._mapped(sum(sizes.values()))
        place = 0
        for name, own in values.items():
            if whole is None:
                self.arrays[name] = np.zeros(shapes[name], own.dtype)
            else:
                self.arrays[name] = OnDisk(whole[place : place + sizes[name]].view(own.dtype).reshape(shapes[name]))
            place += sizes[name]

    def _mapped(self, size: int) -> NDArray[np.uint8] | None:
        """So many bytes of a file; None where they are few, or where there is no such room."""
        if self.folder is None or size <= LARGE:
            return None
        with _nameless(self.folder) as file:
            try:
                os.posix_fallocate(file.fileno(), 0, size)
            except (OSError, AttributeError):  # a full disk; a system that has no such function
                return None
            return np.memmap(file, np.uint8, "r+", shape=(size,))


def below_each_other(blocks: Iterable[NDArray[np.float64]], width: int, folder: Path) -> NDArray[np.float64]:
    """The rows (n, width) of all blocks; many are mapped from a file. Raises OSError where there is no room for it."""
    rest = iter(blocks)
    kept, size = [np.zeros((0, width))], 0
    for block in rest:
        kept.append(block)
        size += block.nbytes
        if size > LARGE:
            break
    else:
        return np.concatenate(kept)
    with _nameless(folder) as file:
        for block in chain(kept, rest):
            file.write(np.ascontiguousarray(block).data)
        file.flush()
        # "c": kernels take arrays that may be written to
        return np.memmap(file, np.float64, "c", shape=(file.tell() // (8 * width), width))


def _nameless(folder: Path) -> IO[bytes]:
    """A file without a name in a folder, or where temporary files stand if that is gone or may not be written to."""
    try:
        return tempfile.TemporaryFile(dir=folder)
    except OSError:
        return tempfile.TemporaryFile()


def let_go(array: NDArray[Any]) -> None:
    """Of rows that are mapped from a file: keep none in memory that have been read."""
    mapped = getattr(array, "_mmap", None)
    if mapped is not None and hasattr(mmap, "MADV_DONTNEED"):
        mapped.madvise(mmap.MADV_DONTNEED)
