"""One contact patch of a result as arrays: pressures over the curved axis s and the rolling direction x."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.errors import InputError, suggest
from wrsim.results.channels import CHANNELS
from wrsim.results.moments import moment_dim, moments_at, order_of_strips, sample_of

Array = NDArray[np.float64]

TRACTIONS = {"element_qx": "qx", "element_qs": "qs"}
"""Channels of the exact solver's elements, and their names in a patch."""


def patch_of(one: xr.Dataset, at: str | float, wheel: str | None, number: int, columns: int) -> xr.Dataset:
    """One patch of one wheelset; parameters and errors as in `wrsim.results.Result.patch`."""
    wheels = [str(w) for w in one["wheel"].values]
    if wheel is None and len(wheels) == 1:
        wheel = wheels[0]
    if wheel not in wheels:
        asked = "choose a wheel" if wheel is None else f"wheel = {wheel!r:.40}: there is none of that name"
        raise InputError(f"{asked}{suggest(str(wheel), wheels)}: {', '.join(wheels)}")
    if columns < 2:
        raise InputError(f"columns = {columns}: must be at least 2")
    (moment,) = moments_at(one, [at], "at")
    dim = moment_dim(one)
    of_wheel = one.isel({dim: moment}).sel(wheel=wheel)
    there = int(np.isfinite(of_wheel["strip_p"].values).any(axis=-1).sum())
    if not 0 <= number < there:
        has = "no contact" if not there else "one patch" if there == 1 else f"{there} patches"
        raise InputError(f"number = {number}: the {wheel} wheel has {has} at {at}; the first is number 0")
    patch = of_wheel.isel(patch=number)
    if dim == "snapshot":
        patch = patch.isel(time=sample_of(one, moment))
    used = order_of_strips(patch["strip_s"].values, patch["strip_p"].values)
    strips = {str(n): v.values[used] for n, v in patch.variables.items() if v.dims == ("strip",)}
    fields = _elements(patch, used) or _strips(strips, columns)
    about = {name: CHANNELS[channel].attributes for channel, name in TRACTIONS.items()}
    about["p"] = {"units": "Pa", "long_name": "pressure"}
    x = xr.Variable("x", fields.pop("x"), {"units": "m", "long_name": "along the track"})
    found = {name: (("s", "x"), values, about[name]) for name, values in fields.items()}
    along = {n: ("s", v, CHANNELS[n].attributes) for n, v in strips.items()}
    s = along.pop("strip_s")
    numbers = {str(n): v for n, v in patch.data_vars.items() if v.dims == () and "patch" in CHANNELS[str(n)].dims}
    place = {"pose": at} if dim == "pose" else {"distance_m": float(patch["snapshot_distance"])}
    return xr.Dataset(
        found | along | {name: ((), value.values, dict(value.attrs)) for name, value in numbers.items()},
        coords={"s": s, "x": x},
        attrs={"title": one.attrs["title"], "wheel": wheel, "number": number, **place},
    )


def _strips(strips: dict[str, Array], columns: int) -> dict[str, Array]:
    """The semi-ellipses of pressure on common columns (x,): p (s, x), zero outside of contact."""
    middle, a, top = (np.nan_to_num(strips[f"strip_{name}"])[:, None] for name in ("x", "a", "p"))
    x = np.linspace((middle - a).min(), (middle + a).max(), columns)
    inside = 1.0 - np.divide(x - middle, a, out=np.full((a.size, columns), np.inf), where=a > 0.0) ** 2
    return {"x": x, "p": top * np.sqrt(np.maximum(inside, 0.0))}


def _elements(patch: xr.Dataset, used: NDArray[np.intp]) -> dict[str, Array] | None:
    """The elements of the exact solver, where they were kept."""
    if "element_p" not in patch or not np.isfinite(patch["element_x"].values).any():
        return None
    columns = np.flatnonzero(np.isfinite(patch["element_x"].values))
    own = {"element_p": "p"} | TRACTIONS
    cut = {name: np.nan_to_num(patch[channel].values[np.ix_(used, columns)]) for channel, name in own.items()}
    return {"x": patch["element_x"].values[columns]} | cut
