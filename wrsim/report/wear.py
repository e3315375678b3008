"""Wear and rolling contact fatigue of a run, as tables of its page."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from wrsim.plots.wear import LAW_WORDS
from wrsim.report.svg import Array
from wrsim.results import CHANNELS
from wrsim.results.table import Column, Table, quantity
from wrsim.results.wear import summary
from wrsim.results.wheelsets import numbered, wheelsets

OF_WHEELS = {
    "tread_g_per_km": Column("tread", "g/km"),
    "flange_g_per_km": Column("flange", "g/km"),
    "wear_wheel_depth_max_um_per_km": Column("deepest", "µm/km"),
    "wear_wheel_u_mm": Column("at u", "mm"),
}
OF_RAILS = {
    "wear_rail_depth_max_nm": Column("deepest, one passage", "nm"),
    "wear_rail_u_mm": Column("at u", "mm"),
}
OF_FATIGUE = {
    "rail_damage_max": Column("largest damage, one passage"),
    "wear_rail_u_mm": Column("at u", "mm"),
    "fatigue_index_max": Column("largest fatigue index"),
}
"""Columns of the tables by keys of a summary."""


def wear_tables(dataset: xr.Dataset) -> list[Table]:
    """What wheels lose by every law, what rails lose, fatigue of the rails."""
    found, called = summary(dataset), numbered(wheelsets(dataset))
    tables = []
    for law, of in found["laws"].items():
        wheels = {f"{called[name]}, {w}": own for name, pair in of["wheelsets"].items() for w, own in pair.items()}
        tables.append(_table(f"Wheels, {LAW_WORDS[law]}", "wheel", OF_WHEELS, wheels))
        tables.append(_table(f"Rails, {LAW_WORDS[law]}", "rail", OF_RAILS, of["rails"]))
    return [*tables, _table("Fatigue of the rails", "rail", OF_FATIGUE, found["fatigue"])]


def _table(title: str, what: str, columns: dict[str, Column], of: dict[str, Any]) -> Table:
    rows = [(name, *(own[key] for key in columns)) for name, own in of.items()]
    return Table(title, (Column(what), *columns.values()), rows)


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
        words.append(f"{body} to {quantity(most * channel.shown.factor, channel.shown.symbol, '.3g')}")
    return found | {"words": f"wear, {LAW_WORDS[law]}: {', '.join(words)} a passage"}
