"""What all kernels promise: the same numbers without the compiler, and no allocation.

The kernels are found by walking wrsim.jit, so a new one that no case in `support.kernels` sets to work fails here."""

import pickle

import numpy as np
import pytest
from numba import njit
from support import kernels
from support.allocations import allocations
from support.workers import EARLY, uncompiled

from wrsim.contact.wheel_rail import STAGES, compile_stages


@pytest.fixture(scope="module", params=["few", pytest.param("full", marks=pytest.mark.campaign)])
def plain(request):
    """Results without the compiler, and kernels that worked; how many cases."""
    early = request.config.stash.get(EARLY, None) if request.param == "few" else None
    with early or uncompiled(request.param) as process:
        return *pickle.load(process.stdout), request.param


@pytest.fixture(scope="module")
def compiled(plain):
    """The same results by kernels, and the first call of each from Python."""
    return kernels.cases_and_first_calls(plain[-1] == "full")


def test_every_kernel_works_in_some_case(plain):
    _, worked, form = plain
    idle = [name for _, name in set(kernels.kernels()) - worked]
    assert sorted(idle) == sorted(kernels.FULL_ALONE if form == "few" else ())


def test_kernels_give_the_same_numbers_without_the_compiler(plain, compiled):
    interpreted, *_ = plain
    for name, ours in compiled[0].items():
        # compilers may fuse products and sums: round-off of coordinates over an approach of 1e-4 m
        scale = np.maximum(np.abs(ours), 1e-9)
        np.testing.assert_allclose(np.array(interpreted[name]) / scale, np.array(ours) / scale, atol=1e-8, err_msg=name)


@njit
def allocate(n):
    """For comparison: one small array each time."""
    total = 0.0
    for i in range(n):
        total += np.full(3, float(i))[1]
    return total


def arrays(thing):
    """Number of arrays in an argument."""
    if isinstance(thing, tuple):
        return sum(arrays(part) for part in thing)
    return int(isinstance(thing, np.ndarray))


def test_no_kernel_that_python_calls_allocates_by_a_count_that_counts(compiled):
    # nor any that works within one of these
    _, calls = compiled
    every = kernels.kernels()
    assert len(calls.keys() & every.keys()) > 20
    compile_stages(*STAGES)
    for key in calls.keys() & every.keys():
        # a note for each array at the door where the kernel hands arrays back
        assert allocations(every[key], *calls[key]) in (0, sum(arrays(a) for a in calls[key])), key
    assert allocations(allocate, 1000) == 1000
