"""The few numbers of wear and rolling contact fatigue of a run."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.channels import CHANNELS
from wrsim.results.wheelsets import wheelsets


def has_wear(dataset: xr.Dataset) -> bool:
    """True when wear was computed."""
    return "wear_wheel_depth" in dataset and "wear_law" in dataset.dims


def summary(dataset: xr.Dataset) -> dict[str, Any]:
    """By law what wheels lose and how deep, what rails lose by one passage; fatigue of the rails."""
    found: dict[str, Any] = {}
    for law in (str(name) for name in dataset["wear_law"].values):
        of_law = dataset.sel(wear_law=law)
        wheels = {
            name: {str(wheel): _of_wheel(of_law.sel(wheelset=name, wheel=wheel)) for wheel in dataset["wheel"].values}
            for name in wheelsets(dataset)
        }
        rails = {
            str(wheel): _deepest(of_law.sel(wheel=wheel), "wear_rail_depth", "wear_rail_u")
            for wheel in dataset["wheel"].values
        }
        found[law] = {"wheelsets": wheels, "rails": rails}
    fatigue = {}
    for wheel in (str(name) for name in dataset["wheel"].values):
        one = dataset.sel(wheel=wheel)
        fatigue[wheel] = _deepest(one, "rail_damage", "wear_rail_u") | {
            "fatigue_index_max": _most(one, "fatigue_index")
        }
    return {"laws": found, "fatigue": fatigue}


def worst_worn(dataset: xr.Dataset) -> str:
    """The wheelset of which a wheel loses the most by the first law."""
    mass = np.nan_to_num(dataset["wear_wheel_mass"].isel(wear_law=0).sum("wear_zone").max("wheel").values)
    return wheelsets(dataset)[int(np.argmax(mass))]


def _of_wheel(one: xr.Dataset) -> dict[str, Any]:
    """Mass by zone, and the deepest place."""
    channel = CHANNELS["wear_wheel_mass"]
    mass = {
        f"{zone}_{channel.shown.suffix}": float(one["wear_wheel_mass"].sel(wear_zone=zone)) * channel.shown.factor
        for zone in (str(name) for name in one["wear_zone"].values)
    }
    return {k: v if np.isfinite(v) else None for k, v in mass.items()} | _deepest(
        one, "wear_wheel_depth", "wear_wheel_u"
    )


def _deepest(one: xr.Dataset, name: str, place: str) -> dict[str, Any]:
    """The largest value over a profile, and where it is."""
    channel, values = CHANNELS[name], one[name].values
    known = np.isfinite(values)
    key = f"{name}_max_{channel.shown.suffix}".removesuffix("_")
    if not known.any():
        return {key: None, f"{place}_mm": None}
    at = int(np.argmax(np.where(known, values, -np.inf)))
    return {key: float(values[at]) * channel.shown.factor, f"{place}_mm": 1e3 * float(one[place].values[at])}


def _most(one: xr.Dataset, name: str) -> float | None:
    """The largest value of a channel of patches."""
    values = one[name].values
    return float(np.nanmax(values)) if np.isfinite(values).any() else None
