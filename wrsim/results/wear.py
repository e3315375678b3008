"""The few numbers of wear and rolling contact fatigue of a run."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from wrsim.results.channels import CHANNELS
from wrsim.results.table import finite
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
        most = finite(np.fmax.reduce(one["fatigue_index"].values, axis=None))
        fatigue[wheel] = _deepest(one, "rail_damage", "wear_rail_u") | {"fatigue_index_max": most}
    return {"laws": laws, "fatigue": fatigue}


def worst_worn(dataset: xr.Dataset) -> str:
    """The wheelset of which a wheel loses the most by the first law."""
    mass = np.nan_to_num(dataset["wear_wheel_mass"].isel(wear_law=0).sum("wear_zone").max("wheel").values)
    return wheelsets(dataset)[int(np.argmax(mass))]


def _of_wheel(one: xr.Dataset) -> dict[str, Any]:
    unit = CHANNELS["wear_wheel_mass"].shown
    zones = zip(one["wear_zone"].values, one["wear_wheel_mass"].values, strict=True)
    mass = {f"{zone}_{unit.suffix}": finite(value, unit.factor) for zone, value in zones}
    return mass | _deepest(one, "wear_wheel_depth", "wear_wheel_u")


def _deepest(one: xr.Dataset, name: str, place: str) -> dict[str, Any]:
    own, values = CHANNELS[name].shown, one[name].values
    at = int(np.argmax(np.where(np.isfinite(values), values, -np.inf)))
    most, where = finite(values[at], own.factor), finite(one[place].values[at], 1e3)
    return {f"{name}_max_{own.suffix}".removesuffix("_"): most, f"{place}_mm": None if most is None else where}
