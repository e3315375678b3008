"""A run over a rail whose friction changes on the way."""

from typing import Any

import numpy as np
import pytest
from support.runs import FAST, LEADING, arc, setup_of

from wrsim import Result
from wrsim.analysis.motion.run import run_in_time

WET = {"from_m": 12.0, "friction": 0.15, "side": "right", "transition_m": 2.0}


@pytest.fixture(scope="module")
def wetted() -> Result:
    """A leading axle in a full curve whose outer rail gets wet on the way, from 12 to 14 m."""
    return in_curve({"friction_sections": [WET]})


def in_curve(contact: dict[str, Any], start: float = 10.0, way: float = 8.0) -> Result:
    keys = {"contact": {"friction": 0.4} | contact} | FAST | {"run.distance_m": way}
    return run_in_time(setup_of([arc(40.0, 200.0, 60.0)], 10.0, LEADING, start=start, values=keys))


def test_a_run_says_which_friction_acts_and_runs_behind_a_change_as_with_that_alone(wetted: Result) -> None:
    dataset = wetted.wheelset()
    distance, mu = dataset["distance"].values, dataset["rail_friction"].values
    assert mu[:, 0] == pytest.approx(0.4)
    np.testing.assert_array_equal(mu, dataset["rail_friction_corner"].values)
    x = np.clip((distance - 12.0) / 2.0, 0.0, 1.0)
    # the outer rail is longer than the centre line by .4 %: a few um of a metre within the transition
    assert mu[:, 1] == pytest.approx(0.4 - 0.25 * x * x * (3.0 - 2.0 * x), abs=2e-5)
    wet = in_curve({"friction_sections": [WET | {"from_m": 1.0}]}, way=0.2)
    dry = in_curve({}, way=0.2)
    ours = wetted.wheelset()
    for name in ("Y", "T_gamma"):
        first, last = (r.wheelset()[name].values[0] for r in (dry, wet))
        np.testing.assert_array_equal(ours[name].values[0], first)  # the start knows the friction of its place
        assert np.abs(last / first - 1.0).max() > 0.05
        assert ours[name].values[-1] == pytest.approx(last, rel=5e-3)
