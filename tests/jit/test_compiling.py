"""Kernels are compiled once: for their types, not for values, and with all that they call."""

import logging
import subprocess
import sys
from functools import partial
from pathlib import Path

import numba
import numpy as np
import pytest
from numba.core.errors import NumbaError

from wrsim.jit import compiling
from wrsim.jit.compiling import COUNT, kernel

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="there is nothing to compile")


with pytest.MonkeyPatch.context() as patch:
    patch.setattr(compiling, "CACHE", None)  # what an earlier run of these tests has kept would not be compiled

    @kernel
    def power(x, n, inverse):
        """x^n, or its inverse."""
        total = 1.0
        for _ in range(n):
            total *= x
        return 1.0 / total if inverse else total

    @kernel
    def outer(x):
        """Calls one kernel with several literal arguments."""
        return power(x, 2, False) + power(x, 3, True)

    @kernel
    def grasp(x):
        """Asks for memory."""
        return np.full(3, x).sum()


def test_literal_arguments_make_no_kernels_of_their_own_and_how_far_it_is_is_reported(caplog):
    with caplog.at_level(logging.INFO, "wrsim.kernels"):
        assert outer(2.0) == 4.125
    assert len(power._parts) == 1 and not power.overloads
    functions = {outer.py_func, power.py_func}
    assert functions <= COUNT.due & COUNT.done
    done, due = zip(*(record.args for record in caplog.records if record.args), strict=True)
    assert not caplog.messages[-1]
    assert done[-1] == due[-1] and set(due) == {due[0]} and list(done) == sorted(done)


def test_a_kernel_is_compiled_once_for_literals_and_callers_and_none_that_allocates():
    with pytest.raises(NumbaError, match="built-in function empty"):
        grasp(2.0)
    outer(2.0)
    assert power(2.0, 3, True) == 0.125


def test_types_in_words_are_kept_in_the_cache_as_those_of_a_call(monkeypatch):
    asked = []
    monkeypatch.setattr(outer._cache, "load_overload", lambda types, target: asked.append(types))
    outer.compile("(float32,)")
    outer(np.float32(2.0))
    assert asked == [(numba.float32,)]


COUNTED = """
import gc, logging, sys
from numba.core import event
from wrsim import load, run, warm
from wrsim.jit.compiling import COUNT, Kernel, LOGGER
from wrsim.scenario.build import build
import wrsim.analysis.motion.run
LOGGER.setLevel(logging.INFO)
if sys.argv[2:]:
    warm()
    sys.exit()
short = {"run": {"distance_m": 0.3}, "contact": {"strips": 12, "cells": 4}, "output": {"patches_at_m": [0.2]}}
scenario = load(sys.argv[1]).with_values(short)
setup = build(scenario)
heavy = {"scipy.signal", "scipy.stats", "scipy.ndimage", "matplotlib", "dask"} & set(sys.modules)
with event.install_recorder("numba:compile") as compiled:
    run(scenario, setup=setup)
called = {one.py_func for one in gc.get_objects() if isinstance(one, Kernel) and one.overloads}
assert len(called) > 15
names = [one.data["dispatcher"].__name__ for _, one in compiled.buffer]
print(*heavy, *names, *(function.__name__ for function in called - COUNT.due))
"""


def test_a_run_finds_all_kernels_after_warming_up_has_them_counted_ahead_and_is_built_with_light_imports():
    command = [sys.executable, "-c", COUNTED, "scenarios/curve_r300.toml"]
    counted = partial(subprocess.run, check=True, capture_output=True, text=True, cwd=ROOT)
    if counted(command).stdout.split():  # they may not have been compiled yet
        counted([*command, "warm"])
        assert counted(command).stdout.split() == []
