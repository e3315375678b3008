"""Small valid scenarios, and what is said about them after an edit."""

from pathlib import Path

from wrsim.errors import InputError
from wrsim.scenario.build import build
from wrsim.scenario.loading import load

CURVE = """\
title = "a curve"
analysis = "curving"
[vehicle]
model = "vehicles/wheelset_s1002.toml"
speed_kmh = 54
[track]
gauge_mm = 1435
rail = "rails/60E1.toml"
inclination = "1:40"
[[track.segments]]
kind = "straight"
length_m = 30
[[track.segments]]
kind = "transition"
length_m = 40
[[track.segments]]
kind = "arc"
radius_m = 300
length_m = 120
cant_mm = 60
[contact]
friction = 0.35
[run]
output_interval_ms = 5
"""

STATIC = """\
analysis = "static"
[vehicle]
model = "vehicles/wheelset_s1002.toml"
[track]
gauge_mm = 1435
rail = "rails/60E1.toml"
inclination = "1:40"
[static]
target = "wheel"
lateral_mm = 0
load_kN = 60
"""


def faults(text: str, folder: Path, name: str = "case.toml") -> list[str]:
    """Messages for a scenario text, one a line; empty if it is valid."""
    (folder / name).write_text(text, encoding="utf-8")
    try:
        build(load(folder / name))
    except InputError as error:
        return [line.removeprefix(f"{folder}/") for line in str(error).split("\n")]
    return []


def edited(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1, old
    return text.replace(old, new)
