"""How kernels are compiled: one place for numba's options.

``kernel`` for functions with work to do, ``inlined`` for the small ones that are called per strip or per sample: numba
does not inline across functions by itself, and a call with a dozen scalars in and eight out costs more than the
arithmetic inside (*measured*: a point of the contact locus 45 ns called, 19 ns inlined). LLVM does the inlining: each
function is typed once, wherever it is used (a quarter less time to compile than ``inline="always"``).

No fastmath: it would let the compiler drop tests for not-a-number. ``error_model="numpy"``: a division by zero gives
infinity, as in C, instead of a test at every division.
"""

from numba import njit

from wrsim.core import CACHE

KEPT = CACHE is not None

kernel = njit(cache=KEPT, error_model="numpy")
inlined = njit(cache=KEPT, error_model="numpy", forceinline=True)
