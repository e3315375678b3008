"""Threads that compute the contacts of a vehicle's wheels side by side."""

from __future__ import annotations

import importlib
from typing import Any

import numba

from wrsim.errors import InputError

CONFIG: Any = numba.config

LAYER = "omp"
"""OpenMP waits awake: handing work over and back costs 1.4 us, where numba's own queue of work takes some 140."""


def use_threads(count: int) -> None:
    """From now on parallel kernels of this process run on so many threads. Raises InputError where they cannot."""
    most = int(CONFIG.NUMBA_NUM_THREADS)
    if not 1 <= count <= most:
        raise InputError(f"threads: must be a whole number from 1 to {most}, the cores of this machine, not {count}")
    if count == 1 or CONFIG.DISABLE_JIT:
        return
    try:
        importlib.import_module("numba.np.ufunc.omppool")
    except ImportError:
        raise InputError(f"threads: {count} need OpenMP (Debian's libgomp1), which is not here; 1 needs none") from None
    CONFIG.THREADING_LAYER = LAYER
    numba.set_num_threads(count)
