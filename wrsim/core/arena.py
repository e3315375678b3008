"""Many arrays in one: a numba call costs about 0.1 us for every array that it is handed, so all arrays of a
wheelset lie in one buffer and an index says where.

index: (K, 4) int64 rows: offset, then up to three sizes (0 where there is no such dimension). Records (``record``) lie
in the same buffer of doubles; the size of a record is their last dimension.
"""

import numpy as np

from wrsim.core.compiling import inlined


def record(floats="", integers="", **parts):
    """Type of a record of 8-byte numbers with these names, and of other records; ``row.name`` reads and writes,
    compiled or not.
    """
    fields = [(name, "f8") for name in floats.split()] + [(name, "i8") for name in integers.split()]
    fields += list(parts.items())
    return np.dtype((np.record, np.dtype(fields, align=True)))


@inlined
def vector(buffer, index, k):
    """Array number k as (n,)."""
    o = index[k, 0]
    return buffer[o : o + index[k, 1]]


@inlined
def matrix(buffer, index, k):
    """Array number k as (n, m)."""
    o, n, m = index[k, 0], index[k, 1], index[k, 2]
    return buffer[o : o + n * m].reshape((n, m))


@inlined
def block(buffer, index, k):
    """Array number k as (n, m, l)."""
    o, n, m, p = index[k, 0], index[k, 1], index[k, 2], index[k, 3]
    return buffer[o : o + n * m * p].reshape((n, m, p))


@inlined
def records(buffer, index, k, kind):
    """Array number k as (n,) records of this kind."""
    o, n, size = index[k, 0], index[k, 1], index[k, 2]
    return buffer[o : o + n * size].view(kind)


@inlined
def record_rows(buffer, index, k, kind):
    """Array number k as (n, m) records of this kind."""
    o, n, m, size = index[k, 0], index[k, 1], index[k, 2], index[k, 3]
    return buffer[o : o + n * m * size].view(kind).reshape((n, m))
