"""Settings of the whole test suite."""

import importlib
import os
import sys

import pytest
from hypothesis import settings

sys.exudynFast = False  # the module that checks ranges and lengths
os.environ.setdefault("NUMBA_NUM_THREADS", "2")  # two threads can be tried on one core

# the first example of a test compiles kernels: no deadline; the same examples in every run
settings.register_profile("wrsim", deadline=None, derandomize=True)
settings.load_profile("wrsim")


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are put together but not painted, for tests of what becomes of their files."""
    drawing = importlib.import_module("wrsim.plots.drawing")
    monkeypatch.setattr(drawing, "rendered", lambda figure: b"a picture")
    monkeypatch.setattr(drawing, "_worth_a_process", lambda pictures: False)


FIRST = ("core/test_kernels.py", "contact/test_laws.py", "study/test_study.py", "analysis/test_shipped_scenarios.py")
"""Files that take longest: the first two compile nearly all kernels, one after 20 s without the compiler."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Long files first, so that no worker is left alone with one at the end."""

    def turn(item: pytest.Item) -> int:
        return next((i for i, name in enumerate(FIRST) if item.path.as_posix().endswith(name)), len(FIRST))

    items.sort(key=turn)
