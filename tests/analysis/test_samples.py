"""Samples that a thread works through while a run goes on."""

import numpy as np
import pytest
import xarray as xr
from support.runs import SCENARIOS

from wrsim import load, run
from wrsim.analysis.motion.samples import HANDED, WAITING, worked_through


class Slow:
    """Takes what comes, or fails at a time [s]."""

    def __init__(self, fails: float = np.inf) -> None:
        self.fails, self.times = fails, []

    def take(self, times, q, q_t):
        if times[-1] >= self.fails:
            raise ValueError(f"cannot take {times[-1]}")
        self.times += [*times]
        assert (q[:, 0] == times).all() and (q_t[:, 0] == -times).all()


def give(samples, count: int) -> None:
    with worked_through(samples) as take:
        state = np.zeros(2)
        for i in range(count):
            state[:] = i  # the run goes on to write to its state
            take(float(i), state, -state)


def test_samples_come_in_order_and_are_those_of_their_time() -> None:
    samples = Slow()
    give(samples, 3 * WAITING * HANDED)
    assert len(samples.times) > 0
    assert samples.times == list(range(len(samples.times)))


def test_what_fails_in_the_thread_fails_in_the_run() -> None:
    with pytest.raises(ValueError, match="cannot take 149"):
        give(Slow(fails=2.5 * HANDED), 3 * WAITING * HANDED)


def test_samples_beside_a_run_and_after_it_are_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """On one core, which a worker of a study has, they come after it: nothing is gained by a second thread."""
    scenario = load(SCENARIOS / "curve_r300.toml").with_values({"run": {"time_s": 0.6}, "output.patches_at_m": []})
    beside: list[int] = []

    def outcome(cores: int) -> xr.Dataset:
        monkeypatch.setattr("wrsim.analysis.motion.run.cores", lambda: cores)
        monkeypatch.setattr(
            "wrsim.analysis.motion.run.worked_through", lambda samples: beside.append(cores) or worked_through(samples)
        )
        return run(scenario, threads=1).dataset

    xr.testing.assert_identical(outcome(1), outcome(2))
    assert beside == [2]
