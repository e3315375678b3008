"""The GZ18 metro car on the wheel, rail and irregularities of its source, which are not part of this repository.

The tables lie in ``shared/reference/gz18`` beside the clone, or in the folder that WRSIM_SHARED names in the place of
``shared``. Their axes are y right, z down; here they become ours.
"""

from __future__ import annotations

import gzip
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from wrsim.scenario.loading import Scenario, load

ROOT = Path(__file__).parents[1]
TABLES = Path(os.environ.get("WRSIM_SHARED", ROOT.parent / "shared")) / "reference" / "gz18"
CANT_MM = {"r300": 120.0, "r600": 100.0, "r800": 110.0}
"""The lines of the source by their names, which say the radius [m]."""

PROFILE = """\
name = "{name}"
body = "{body}"
kind = "points"
date = 2026-11-22
source = "ORVD 4706df9"
file = "{file}"
format = "columns"
measured = false
unit = "mm"
heights = "down"
field_side = "positive"
"""
PROFILES = {"wheel": "wheel_profile_gz18_right.csv", "rail": "rail_profile_uic60_right.csv"}


def has_tables() -> bool:
    """True if the tables of the source are at hand."""
    return TABLES.is_dir()


def _profiles(folder: Path) -> dict[str, str]:
    """Profile files of wheel and rail, written to ``folder``."""
    found = {}
    for body, file in PROFILES.items():
        place = folder / f"{body}.toml"
        place.write_text(PROFILE.format(name=f"{body} of the source", body=body, file=TABLES / file))
        found[body] = str(place)
    return found


def scenario(folder: Path, line: str = "r300", values: Mapping[str, Any] | None = None) -> Scenario:
    """The shipped scenario with the profiles of the source, on one of its lines; files go to ``folder``."""
    keys: dict[str, Any] = {
        "track.segments": [
            {"kind": "straight", "length_m": 50.0},
            {"kind": "transition", "length_m": 50.0, "form": "bloss"},
            {"kind": "arc", "radius_m": -float(line[1:]), "length_m": 500.0, "cant_mm": CANT_MM[line]},
            {"kind": "transition", "length_m": 50.0, "form": "bloss"},
            {"kind": "straight", "length_m": 450.0},
        ]
    }
    files = _profiles(folder)
    keys |= {"vehicle.wheel": files["wheel"], "track.rail": files["rail"]}
    return load(ROOT / "scenarios" / "gz18_r300.toml").with_values(keys | dict(values or {}))


STEADY = """\
title = "GZ18 in a steady curve"
analysis = "steady"
[vehicle]
model = "vehicles/gz18.toml"
wheel = "{wheel}"
[track]
gauge_mm = 1435
gauge_depth_mm = 16
rail = "{rail}"
inclination = "1:40"
[contact]
strips = 25
cells = 12
friction = {{ static = 0.3, falling_ratio = 0.4, falling_decay_s_per_m = 0.55 }}
[steady]
radius_m = -{radius}
cant_mm = {cant}
speed_kmh = 59.9
"""


def steady(folder: Path, line: str = "r300", values: Mapping[str, Any] | None = None) -> Scenario:
    """The car in the full curve of a line, at the speed that is left there in the source; files go to ``folder``."""
    place = folder / f"{line}.toml"
    place.write_text(STEADY.format(**_profiles(folder), radius=line[1:], cant=CANT_MM[line]))
    return load(place).with_values(dict(values or {}))


def irregularity(folder: Path, name: str) -> dict[str, Any]:
    """An entry of [[track.irregularities]] of a table of the source (aar5, aar6): its rows in our axes and columns."""
    with gzip.open(TABLES / f"irregularity_{name}.csv.gz", "rt") as file:
        distance, right, down = np.loadtxt(file, delimiter=",", skiprows=1).T
    place = folder / f"{name}.csv"
    rows = np.column_stack([distance, -right, -down])
    np.savetxt(place, rows, delimiter=",", header="distance_m,alignment_mm,level_mm", comments="", fmt="%.9g")
    return {"kind": "table", "file": str(place), "fade_m": 0.1}
