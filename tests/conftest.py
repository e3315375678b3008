"""Settings of the whole test suite."""

import importlib
import sys

import pytest
from hypothesis import settings

sys.exudynFast = False  # the module that checks ranges and lengths

# the first example of a test compiles kernels: no deadline; the same examples in every run
settings.register_profile("wrsim", deadline=None, derandomize=True)
settings.load_profile("wrsim")


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are put together but not painted, for tests of what becomes of their files."""
    drawing = importlib.import_module("wrsim.plots.drawing")
    monkeypatch.setattr(drawing, "rendered", lambda figure: b"a picture")
