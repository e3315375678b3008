"""The numbers of a long run stand on disk: the same numbers, the same files, and memory that does not go with them."""

from pathlib import Path

import numpy as np
import pytest
from support.runs import FAST, LEADING, setup_of, straight

from wrsim.analysis.contacts import force_law
from wrsim.analysis.motion.monitor import Monitor
from wrsim.analysis.motion.run import recorded_run
from wrsim.results import Result, netcdf, write_run
from wrsim.scenario.build import Setup
from wrsim.simulation import recorder
from wrsim.simulation.integrate import Integration
from wrsim.simulation.placement import design_state
from wrsim.simulation.recorder import Recorder
from wrsim.simulation.system import BodySystem


def at_most(monkeypatch: pytest.MonkeyPatch, size: int) -> None:
    """So many bytes may stand in memory."""
    monkeypatch.setattr(netcdf, "LARGE", size)
    monkeypatch.setattr(recorder, "LARGE", size)


@pytest.fixture(scope="module")
def setup() -> Setup:
    return setup_of([straight(6.0)], 20.0, LEADING, values=FAST)


@pytest.fixture
def record(setup: Setup, tmp_path: Path) -> Path:
    """The file of a short run."""
    law = force_law(setup)
    q, q_t = design_state(law, lateral=1e-3)
    path = tmp_path / "result.nc.part"
    file = Recorder.create(path, {"step_s": 1e-3, "start_s": 0.0, "integrator": "generalised-alpha"}, law.size)
    system = BodySystem(law.bodies, law)
    monitor = Monitor(law, 20.0, system.work)
    Integration(system, duration=0.1, step=1e-3, recorder=file, monitor=monitor).run(q, q_t)
    file.close()
    return path


def test_a_result_on_disk_is_the_one_in_memory(
    setup: Setup, record: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    at_most(monkeypatch, 10**9)
    in_memory = recorded_run(setup, record)
    tables = {f.name: f.read_bytes() for f in write_run(in_memory, tmp_path / "memory") if f.suffix != ".nc"}
    at_most(monkeypatch, 1000)
    on_disk = recorded_run(setup, record)
    assert on_disk.dataset.identical(in_memory.dataset)
    assert tables == {f.name: f.read_bytes() for f in write_run(on_disk, tmp_path / "disk") if f.suffix != ".nc"}
    read = Result.load(tmp_path / "disk")
    assert read.dataset.identical(in_memory.dataset)
    for dataset in (on_disk.dataset, read.dataset):  # reading has left nothing in memory
        assert not any(
            isinstance(dataset[name].variable._data, np.ndarray) for name in ("Y", "p0", "sum_Y", "n_patches")
        )
    twice = Result.load(on_disk.save(tmp_path / "again.nc"))
    assert twice.dataset.identical(read.dataset)
    assert not [p for p in tmp_path.rglob("*") if p.name.startswith(".")]
