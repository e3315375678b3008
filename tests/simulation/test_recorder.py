"""Samples of a run are safe whatever happens to the file that keeps them."""

import shutil
from pathlib import Path

import numpy as np

from wrsim.simulation.recorder import BLOCK, Checkpoint, Ending, Recorder


def test_samples_survive_the_deletion_of_their_folder(tmp_path: Path) -> None:
    """The descriptor still has what the folder has lost."""
    recorder = Recorder.create(tmp_path / "out/result.nc.part", {"step_s": 1.0, "start_s": 0.0}, 2)
    samples = 3 * BLOCK
    for k in range(samples):
        if k == BLOCK + 7:
            shutil.rmtree(tmp_path / "out")
        recorder.sample(float(k), np.array([k, -k], dtype=float), np.zeros(2))
        if recorder.due():
            recorder.flush(Checkpoint(k, np.zeros(2), np.zeros(2), np.zeros(0)))
    recorder.end(Ending("", ""))
    rows = recorder.rows()
    assert np.array_equal(rows[:, 0], np.arange(samples))
    assert np.array_equal(rows[:, 2], -np.arange(samples))
    recorder.close()
