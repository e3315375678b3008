"""How often compiled code asks for memory."""

from numba.core.runtime import _nrt_python, rtsys


def allocations(function, n, *arguments):
    """Number of allocations that numba's run time counts during one call."""
    function(n, *arguments)
    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats().alloc
    function(n, *arguments)
    after = rtsys.get_allocation_stats().alloc
    _nrt_python.memsys_disable_stats()
    return after - before
