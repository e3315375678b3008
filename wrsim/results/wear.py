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


def summarise_wear(dataset: xr.Dataset) -> dict[str, Any]:
    """By law what wheels lose and how deep, what rails lose by one passage; fatigue of the rails."""
    wheels = [str(wheel) for wheel in dataset["wheel"].values]
    laws: dict[str, Any] = {}
    for law in map(str, dataset["wear_law"].values):
        own = dataset.sel(wear_law=law)
        laws[law] = {
            "wheelsets": {
                name: {wheel: _of_wheel(own.sel(wheelset=name, wheel=wheel)) for wheel in wheels}
                for name in wheelsets(dataset)
            },
            "rails": {wheel: _deepest(own.sel(wheel=wheel), "wear_rail_depth", "wear_rail_u") for wheel in wheels},
        }
    fatigue = {}
    for wheel in wheels:
        one = dataset.sel(wheel=wheel)
        index = one["fatigue_index"].values
        most = float(np.nanmax(index)) if np.isfinite(index).any() else None
        fatigue[wheel] = _deepest(one, "rail_damage", "wear_rail_u") | {"fatigue_index_max": most}
    return {"laws": laws, "fatigue": fatigue}


def worst_worn(dataset: xr.Dataset) -> str:
    """The wheelset of which a wheel loses the most by the first law."""
    mass = np.nan_to_num(dataset["wear_wheel_mass"].isel(wear_law=0).sum("wear_zone").max("wheel").values)
    return wheelsets(dataset)[int(np.argmax(mass))]


def _of_wheel(one: xr.Dataset) -> dict[str, Any]:
    """Mass by zone, and the deepest place."""
    unit = CHANNELS["wear_wheel_mass"].shown
    zones = zip(one["wear_zone"].values, (one["wear_wheel_mass"].values * unit.factor).tolist(), strict=True)
    mass = {f"{zone}_{unit.suffix}": value if np.isfinite(value) else None for zone, value in zones}
    return mass | _deepest(one, "wear_wheel_depth", "wear_wheel_u")


def _deepest(one: xr.Dataset, name: str, place: str) -> dict[str, Any]:
    """The largest value over a profile, and where it is."""
    channel, values = CHANNELS[name], one[name].values
    known = np.isfinite(values)
    key = f"{name}_max_{channel.shown.suffix}".removesuffix("_")
    if not known.any():
        return {key: None, f"{place}_mm": None}
    at = int(np.argmax(np.where(known, values, -np.inf)))
    return {key: float(values[at]) * channel.shown.factor, f"{place}_mm": 1e3 * float(one[place].values[at])}
