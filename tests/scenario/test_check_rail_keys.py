"""Check rails of a scenario: the shorthand and sections along the track."""

from pathlib import Path

import pytest

from wrsim import InputError, load
from wrsim.scenario.build import build

SCENARIO = Path(__file__).parents[2] / "scenarios/check_rail.toml"


def test_the_shorthand_is_the_rail_that_is_drawn_and_its_sections_part_in_the_floor():
    plain = {"track.rail_sections": []}
    scenario = load(SCENARIO).with_values(plain | {"track.check_rail_left": {"flangeway_mm": 41}})
    left, right = build(scenario).rails
    assert left.name == "60E1, check rail at 41 mm" and right.name == "60E1" and left.u.min() < -0.11
    sections = [
        {"at_m": place, "side": "left", "rail": "rails/60E1.toml", "check_rail": {"flangeway_mm": flangeway}}
        for place, flangeway in ((8, 60), (10, 41), (14, 41), (16, 60))
    ]
    surface = build(scenario.with_values({"track.rail_sections": sections})).surfaces[0]
    assert [section.distance for section in surface.sections] == pytest.approx([8, 10, 14, 16], abs=0.1)
    assert len(surface.pieces) == 2
    with pytest.raises(InputError, match="check_rail"):
        scenario.with_values({"track.check_rail": {"flangeway_mm": 41}})
