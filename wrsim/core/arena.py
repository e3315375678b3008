"""Many arrays in one: a numba call costs about 0.1 us for every array that it is handed, so all arrays of a
wheelset lie in one buffer and an index says where.

index: (K, 4) int64 rows: offset, then up to three sizes (0 where there is no such dimension).
"""

from wrsim.core.compiling import inlined


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
