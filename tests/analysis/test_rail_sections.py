"""Rails that change along the track, in scenarios and runs."""

from __future__ import annotations

from typing import Any

import pytest
from support.runs import FAST, SCENARIOS

from wrsim.analysis import run
from wrsim.errors import InputError
from wrsim.results import Result
from wrsim.scenario.build import build
from wrsim.scenario.loading import load

NEW, WORN = "rails/60E1.toml", "rails/60E1_worn.toml"


def section(at: float, rail: str = NEW, **more: Any) -> dict[str, Any]:
    return {"at_m": at, "rail": rail, **more}


@pytest.fixture(scope="module")
def lowered() -> Result:
    """A wheelset that runs from new rails to worn ones 2 mm lower."""
    values = {"track.rail_sections": [section(3.0), section(4.5, down_mm=1.0), section(6.0, WORN, down_mm=2.0)]}
    more = {"run.distance_m": 7.0, "vehicle.speed_kmh": 30, "output.patches_at_m": [1, 7], "run.output_interval_ms": 5}
    return run(load(SCENARIOS / "rail_states.toml").with_values(values | more | FAST))


def test_a_wheelset_follows_its_rails(lowered: Result) -> None:
    dataset = lowered.wheelset()
    height = dataset["vertical_shift"].values
    assert height[-1] - height[0] == pytest.approx(
        -2e-3, abs=5e-5
    )  # the worn rail's running surface is as high as the new one's
    assert dataset["Q"].values[-1] == pytest.approx(dataset["Q"].values[0], rel=2e-3)


def test_sections_are_drawn_as_they_are_at_each_moment(lowered: Result) -> None:
    heights = lowered.wheelset()["rail_profile_z"].max("rail_point").values
    assert heights[0] == pytest.approx(heights[0].mean(), abs=1e-5)
    assert heights[-1] - heights[0] == pytest.approx(-2e-3, abs=1e-5)


FAULTS: list[tuple[dict[str, Any], str]] = [
    ({"track.rail_sections": [section(5.0)]}, "is the only one of its rail; at least 2 are needed"),
    ({"track.rail_sections": [section(5.0), section(4.0)]}, "must be more than 5, where its rail"),
    ({"track.rail_sections": [section(5.0), section(400.0)]}, "must be on the track, which is 40 m long"),
    ({"track.rail_sections": [section(5.0, "rails/none.toml"), section(6.0)]}, "none.toml"),
    ({"track.rail_sections": [section(5.0, "wheels/S1002.toml"), section(6.0)]}, "a rail profile is needed here"),
    ({"track.rail_sections": [section(5.0, features_mm=[20]), section(6.0)]}, "the first section has 1"),
    ({"track.rail_sections": [section(5.0, features_mm=[900]), section(6.0, features_mm=[20])]}, "features must rise"),
    (
        {"track.rail_sections": [section(5.0, features_mm=[0.5]), *(section(s, features_mm=[0]) for s in (6.0, 7.0))]},
        "is there in 1 sections; it must be there in two or more that follow each other",
    ),
    ({"contact.normal": "half-space"}, "knows no rail that changes along the track"),
    ({"analysis": "equilibrium"}, 'analysis = "equilibrium" knows one profile of each rail'),
]


@pytest.mark.parametrize(("values", "message"), FAULTS, ids=[message[:30] for _, message in FAULTS])
def test_one_fault_is_one_clear_error(values: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        build(load(SCENARIOS / "rail_states.toml").with_values(values))
    assert message in str(caught.value) and len(str(caught.value).splitlines()) == 1
