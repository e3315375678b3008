"""Wear and rolling contact fatigue of a run, as tables of its page."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from wrsim.plots.wear import LAW_WORDS
from wrsim.report.facts import Table
from wrsim.report.svg import Array
from wrsim.results import CHANNELS
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


LEAST_DEPTH = 0.01
"""Of the largest, from which on the viewer draws it."""


def depth_at(mine: xr.Dataset, body: str, share: Array) -> Array:
    """Depths by the first law over the largest, at shares of a profile's length; nothing where nothing wears."""
    depth = mine.isel(wear_law=0)[f"wear_{body}_depth"].values
    depth = depth[np.isfinite(depth)]  # profiles of other wheels may have more places
    if not depth.any():
        return np.zeros(share.size)
    return np.asarray(np.interp(share, (np.arange(depth.size) + 0.5) / depth.size, depth) / depth.max())


def worn_outlines(mine: xr.Dataset, on_wheel: Array, on_rail: Array) -> dict[str, Any]:
    """For the viewer: depths by the first law at points of the outlines of one wheel and its rail, and words for them.

    on_wheel, on_rail: the points, as shares of the profiles' lengths; depths as hundredths of the largest.
    """
    law, words = str(mine["wear_law"].values[0]), []
    found: dict[str, Any] = {}
    for body, points in (("wheel", on_wheel), ("rail", on_rail)):
        found[body] = np.rint(100.0 * depth_at(mine, body, points)).astype(int).tolist()
        channel = CHANNELS[f"wear_{body}_depth"]
        most = float(mine.isel(wear_law=0)[channel.name].max())
        words.append(f"{body} to {most * channel.shown.factor:.3g} {channel.shown.symbol}")
    return found | {"words": f"wear, {LAW_WORDS[law]}: {', '.join(words)} a passage"}
