"""What knows numba: compiling, the cache of compiled kernels, arrays in one buffer, kernels called by number.

Nothing else imports numba or llvmlite (import contract in pyproject.toml).
"""

from wrsim.jit.arena import Array, Bools, Ints, Record, Records, block, matrix, record, record_rows, records, vector
from wrsim.jit.compiling import inlined, kernel, noalias_kernel, parallel, prange, reassociating_kernel, released

__all__ = [
    "Array", "Bools", "Ints", "Record", "Records", "block", "noalias_kernel", "inlined", "kernel", "matrix", "parallel",
    "prange", "record", "record_rows", "records", "reassociating_kernel", "released",
    "vector",
]  # fmt: skip
