"""Stages are called by numbers from a table that has room for all of them; one stage is compiled by another process."""

import subprocess

import numba
import numpy as np
import pytest

from wrsim.jit import Array, Ints, compiling, kernel, parallel, prange, stages
from wrsim.jit.arena import take

with pytest.MonkeyPatch.context() as patch:
    patch.setattr(compiling, "CACHE", None)

    @kernel
    def add_one(buffer: Array, index: Ints) -> int:
        """Writes and returns a status of its own."""
        buffer[0] += 1.0
        return 11

    @kernel
    def add_ten(buffer: Array, index: Ints) -> int:
        """Another stage."""
        buffer[0] += 10.0
        return 12

    @kernel
    def run_some(buffer: Array, index: Ints) -> int:
        """All the stages that the index names; the sum of their statuses."""
        total = 0
        for i in range(index.shape[0]):
            total += stages.run(index[i, 0], buffer, index)
        return total

    @parallel
    def take_all(marks: Array, takers: Ints) -> None:
        """Every taker tries every mark."""
        for taker in prange(takers.size):
            for place in range(marks.size):
                takers[taker] += take(marks, place)


def test_a_mark_is_taken_once():
    compiling.use_threads(min(2, compiling.cores()))
    marks, takers = np.zeros(20_000), np.zeros(8, int)
    take_all(marks, takers)
    assert takers.sum() == marks.size and np.all(marks == 1.0)


def test_a_table_of_stages_grows_and_keeps_those_that_were_there():
    buffer, few, many = np.zeros(1), np.array([[30, 0, 0, 0]]), np.array([[n, 0, 0, 0] for n in range(30, 60)])
    stages.make_ready(30, add_one)
    assert run_some(buffer, few) == 11 and buffer[0] == 1.0
    for number in range(31, 60):
        stages.make_ready(number, add_ten if number % 2 else add_one)
    assert run_some(buffer, many) == 15 * (11 + 12) and buffer[0] == 1.0 + 15 * (1.0 + 10.0)
    stages.make_ready(30, add_ten)
    assert run_some(buffer, few) == 12, "a number may be given to another stage"


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="there is nothing to compile")
def test_a_stage_is_compiled_by_another_process_unless_it_is_there(monkeypatch):
    started = []
    monkeypatch.setattr(stages, "CACHE", "a folder")
    monkeypatch.setattr(stages, "cores", lambda: 2)
    monkeypatch.setattr(subprocess, "Popen", lambda args, **_: started.append(args) or Ended())
    with stages.compile_in_background(add_one) as in_background:
        assert in_background
    (command,) = started
    assert f"from {__name__} import add_one as stage" in command[-1]
    monkeypatch.setattr(stages, "is_cached", lambda _: True)
    with stages.compile_in_background(add_one) as in_background:
        assert not in_background and len(started) == 1


class Ended:
    """A process that has ended."""

    def wait(self) -> int:
        return 0

    def poll(self) -> int:
        return 0
