"""One run of a coach and one browser for all tests of pages."""

from collections.abc import Iterator

import pytest
from support.browser import Browser, browser
from support.runs import FAST, SCENARIOS, arc, straight, transition

from wrsim.analysis import run
from wrsim.results import Result
from wrsim.scenario.loading import load

SEGMENTS = [straight(20.0), transition(20.0), arc(20.0, 300.0, 100.0), transition(20.0), straight(25.0)]


@pytest.fixture(scope="session")
def coach() -> Result:
    """A coach through a short curve."""
    scenario = load(SCENARIOS / "manchester_r300.toml")
    keys = {"track.segments": SEGMENTS, "run.distance_m": 70, "output.patches_at_m": [35]}
    return run(scenario.with_values(FAST | {"contact.strips": 20} | keys))


@pytest.fixture(scope="session")
def chromium() -> Iterator[Browser]:
    with browser() as opened:
        yield opened
