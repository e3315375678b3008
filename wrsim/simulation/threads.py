"""Threads that compute the contacts of a vehicle's wheels side by side."""

from __future__ import annotations

from wrsim.core.jit import compiling
from wrsim.errors import InputError


def use_threads(count: int) -> None:
    """From now on parallel kernels of this process run on so many threads. Raises InputError where they cannot."""
    if not 1 <= count <= compiling.cores():
        raise InputError(
            f"threads: must be a whole number from 1 to {compiling.cores()}, the cores of this machine, not {count}"
        )
    try:
        compiling.use_threads(count)
    except ImportError:
        raise InputError(f"threads: {count} need OpenMP (Debian's libgomp1), which is not here; 1 needs none") from None
