"""One run of a coach and one browser for all tests of pages."""

import fcntl
import os
from collections.abc import Iterator

import pytest
from support.browser import Browser, browser
from support.runs import FAST, SCENARIOS, arc, straight, transition

from wrsim.analysis import run
from wrsim.results import Result
from wrsim.scenario.loading import load

SEGMENTS = [straight(20.0), transition(20.0), arc(20.0, 300.0, 100.0), transition(20.0), straight(25.0)]


@pytest.fixture(scope="session")
def coach(tmp_path_factory: pytest.TempPathFactory) -> Result:
    """A coach through a short curve, run by the first of the suite's workers that needs it."""
    own = tmp_path_factory.getbasetemp()
    file = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "coach.nc"
    with file.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not file.exists():
            scenario = load(SCENARIOS / "manchester_r300.toml")
            keys = {"track.segments": SEGMENTS, "run.distance_m": 70, "output.patches_at_m": [35]}
            run(scenario.with_values(FAST | {"contact.strips": 20} | keys)).save(file)
    return Result.load(file)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    with browser() as opened:
        yield opened
