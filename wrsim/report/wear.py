"""Wear and rolling contact fatigue of a run, as tables of its page."""

from __future__ import annotations

from typing import Any

import xarray as xr

from wrsim.plots.wear import LAW_WORDS
from wrsim.report.facts import Table
from wrsim.results.wear import summary
from wrsim.results.wheelsets import numbered, wheelsets

OF_WHEELS = {
    "tread_g_per_km": "tread [g/km]",
    "flange_g_per_km": "flange [g/km]",
    "wear_wheel_depth_max_um_per_km": "deepest [µm/km]",
    "wear_wheel_u_mm": "at u [mm]",
}
OF_RAILS = {"wear_rail_depth_max_nm": "deepest, one passage [nm]", "wear_rail_u_mm": "at u [mm]"}
OF_FATIGUE = {
    "rail_damage_max": "largest damage, one passage [1]",
    "wear_rail_u_mm": "at u [mm]",
    "fatigue_index_max": "largest fatigue index [1]",
}
"""Columns of the tables: keys of a summary, and words."""


def wear_tables(dataset: xr.Dataset) -> list[Table]:
    """What wheels lose by every law, what rails lose, fatigue of the rails."""
    found, called = summary(dataset), numbered(wheelsets(dataset))
    tables = []
    for law, of in found["laws"].items():
        wheels = [
            (f"{called[name]}, {wheel}", *_cells(own, OF_WHEELS))
            for name, pair in of["wheelsets"].items()
            for wheel, own in pair.items()
        ]
        tables.append(Table(f"Wheels, {LAW_WORDS[law]}", ("wheel", *OF_WHEELS.values()), tuple(wheels)))
        rails = [(name, *_cells(own, OF_RAILS)) for name, own in of["rails"].items()]
        tables.append(Table(f"Rails, {LAW_WORDS[law]}", ("rail", *OF_RAILS.values()), tuple(rails)))
    fatigue = [(name, *_cells(own, OF_FATIGUE)) for name, own in found["fatigue"].items()]
    return [*tables, Table("Fatigue of the rails", ("rail", *OF_FATIGUE.values()), tuple(fatigue))]


def _cells(own: dict[str, Any], columns: dict[str, str]) -> list[str]:
    return ["" if own[key] is None else f"{own[key]:z.4g}" for key in columns]
