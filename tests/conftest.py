"""Settings of the whole test suite."""

import gc
import os
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

# two threads that share the small matrices of a vehicle wait awake for each other: fifty times the processor time
# where all cores are busy; read when numpy is imported
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# before numba is imported: it reads its settings anew where they have changed since, and forgets where the cache is
# also where it says 1: kernels of several threads are tried with two, which one core can do
os.environ["NUMBA_NUM_THREADS"] = str(max(2, int(os.environ.get("NUMBA_NUM_THREADS", 2))))

import pytest
from hypothesis import settings
from support import examples  # noqa: F401 (its profiles)
from support.files import report_foreign, watch_files
from support.pictures import leave_unpainted, sketch
from support.reference import add_option, crossing_tables, leave_out, reference  # noqa: F401 (fixtures)
from support.workers import add_workers, begin_early, pytest_runtestloop  # noqa: F401

gc.disable()  # until all modules are there
os.fsync = lambda handle: None  # what tests write needs to outlive no power cut
sys.exudynFast = False  # the module that checks ranges and lengths
# threads that wait awake take turns with the other workers of the suite: a test of two took minutes beside them
os.environ.setdefault("OMP_WAIT_POLICY", "passive")

# the first example of a test compiles kernels: no deadline; the same examples in every run
settings.load_profile("wrsim")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options of this suite."""
    add_workers(parser)
    add_option(parser)


def pytest_configure(config: pytest.Config) -> None:
    """What begins before tests are collected."""
    watch_files(config)
    begin_early(config)


@pytest.fixture(autouse=True)
def _no_foreign_files():
    """Each test reads what every machine has, and modules do when they are imported."""
    report_foreign()
    yield
    report_foreign()


@pytest.fixture(autouse=True, scope="session")
def _forgotten_times():
    """No run tells the time of the next one: what commands print is the same everywhere."""
    with pytest.MonkeyPatch.context() as patch:
        if find_spec("exudyn") is not None:  # the contact alone has no runs
            patch.setattr("wrsim.analysis.run_times._file", lambda: None)
        yield


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are neither put together nor painted."""
    leave_unpainted(monkeypatch)


@pytest.fixture
def sketched(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are put together and not painted."""
    sketch(monkeypatch)


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Write a text file; returns its path."""

    def writer(text: str, name: str = "points.csv") -> Path:
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return writer


FIRST = (
    "jit/test_kernels.py",
    # without kernels, while these are compiled
    "cli/test_users_files.py", "cli/test_cli.py", "tests/plots/", "tests/results/", "cli/test_words.py",
    "study/test_study.py", "study/test_evolution.py", "tests/report/", "analysis/test_train.py",
    "analysis/test_shipped_scenarios.py", "analysis/test_vehicle_run.py",
    "contact/test_strip_model.py", "analysis/test_resume.py", "contact/test_library.py", "contact/test_crossing.py",
    "jit/test_shipped.py", "simulation/test_energy.py", "vehicle/test_vehicle_loads.py",
)  # fmt: skip
"""What comes first: the test that compiles nearly all kernels, beside it tests that need none, then the longest."""


def pytest_collection_finish() -> None:
    """What all modules hold is no garbage and need not be looked through again."""
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)  # seldom: little of what tests make refers to itself
    gc.enable()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """No worker compiles what another one compiles at the time, none is left alone with a long file at the end."""

    def turn(item: pytest.Item) -> int:
        return next((i for i, name in enumerate(FIRST) if name in item.path.as_posix()), len(FIRST))

    items.sort(key=turn)
    leave_out(config, items)
