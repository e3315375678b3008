"""What rings between two samples is told, and is what finer samples show."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from wrsim.analysis import run
from wrsim.analysis.motion.monitor import IntersamplePeaks
from wrsim.scenario.loading import load

SCENARIO = Path(__file__).parents[2] / "scenarios/lrv_curve.toml"


def test_a_force_between_samples_is_that_of_finer_samples() -> None:
    """A flange meets its rail and rings at some 100 Hz: samples every 10 ms miss the peak, not the integration."""
    part = {"run.start_distance_m": 5.5, "run.distance_m": 2.6, "run.step_us": 500, "output.patches_at_m": []}
    fine, coarse = (run(load(SCENARIO).with_values(part | {"run.output_interval_ms": ms})) for ms in (0.5, 10.0))
    every = round(10.0 / 0.5)
    force = fine.dataset["Q"].values[:, 0]
    kept = coarse.dataset["Q"].values[:-1, 0]
    # contacts of a sample are solved from those of the one before: strips end within some 1e-8 of the load
    assert force[::every][: len(kept)] == pytest.approx(kept, rel=1e-7), "the same motion"
    beyond = np.zeros(2)
    for i in range(every, len(force) - every, every):
        ends, inside = force[[i, i + every]], force[i + 1 : i + every]
        above, below = inside.max(axis=0) - ends.max(axis=0), ends.min(axis=0) - inside.min(axis=0)
        beyond = np.maximum(beyond, np.maximum(above, below))
    (event,) = coarse.summary()["events"]
    assert f"{beyond.max() / 1e3:.3g} kN beyond both: a smaller run.output_interval_ms" in event["event"]
    assert beyond.max() > 1e3
    assert "events" not in fine.summary(), "a sample at every step misses nothing"


def test_what_was_seen_between_samples_survives_an_interrupted_run() -> None:
    totals = [{"Fb": np.zeros(1)} for _ in range(2)]
    models = [SimpleNamespace(arrays=SimpleNamespace(rows=SimpleNamespace(total=total))) for total in totals]
    whole, first, second = (IntersamplePeaks(models) for _ in range(3))  # type: ignore[arg-type]
    signal = 1e3 * np.random.default_rng(3).standard_normal((40, 2))

    def go(between: IntersamplePeaks, steps: range) -> None:
        for k in steps:
            for total, value in zip(totals, signal[k], strict=True):
                total["Fb"][:] = value
            between.step(1e-3 * k, 2e-2 * k, k % 7 == 0)

    go(whole, range(40))
    go(first, range(17))
    second.set_state(first.get_state())
    go(second, range(17, 40))
    assert whole.largest(0.05) == second.largest(0.05)
    assert np.array_equal(whole.get_state(), second.get_state())
    assert whole.largest(5e4) is None, "a small part of the load is no news"
