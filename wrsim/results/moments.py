"""The moments of which a result holds contact patches, snapshots of a run or poses; one patch as arrays."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.errors import InputError, suggest
from wrsim.results.channels import CHANNELS, PATCHES
from wrsim.results.table import Cell, Column, Table, finite, join_names, quantity

Array = NDArray[np.float64]

NEAR = 1.0  # distance from a requested place within which snapshots count as being there [m]


def has_patches(dataset: xr.Dataset) -> bool:
    """True when the dataset holds strips of at least one moment."""
    return "strip_p" in dataset and bool(np.isfinite(dataset["strip_p"].values).any())


def with_patches(dataset: xr.Dataset) -> NDArray[np.bool_]:
    """Whether a moment holds strips, for every moment."""
    strips = np.isfinite(dataset["strip_p"].values)
    return strips.reshape(strips.shape[0], -1).any(axis=1)


class Strips(NamedTuple):
    """Strips of one patch: values (strip,) of channels by their names, as those of a dataset."""

    variables: dict[str, Array]


def order_of_strips(s: Array, p: Array) -> NDArray[np.intp]:
    """Places of strips that have a pressure, by increasing s."""
    used = np.flatnonzero(np.isfinite(p))
    return used[np.argsort(s[used], kind="stable")]


def is_history(dataset: xr.Dataset) -> bool:
    """True for a run of several instants, unless these are the places where contacts were solved again."""
    return dataset.sizes.get("time", 0) > 1 and "resolved_with" not in dataset.attrs


def moment_dim(dataset: xr.Dataset) -> str:
    """``"snapshot"`` in runs, ``"pose"`` in static analyses."""
    return "snapshot" if "time" in dataset.dims else "pose"


def sample_of(dataset: xr.Dataset, moment: int) -> int:
    """Index along ``time`` or ``pose`` of the values that belong to the moment."""
    if moment_dim(dataset) == "pose":
        return moment
    return int(np.argmin(np.abs(dataset["time"].values - dataset["snapshot_time"].values[moment])))


def moments_at(dataset: xr.Dataset, places: Sequence[str | float], key: str) -> list[int]:
    """Indices of the moments at these distances of the vehicle [m], or of the poses of these names. key: what the
    places were given as, for messages. Raises InputError."""
    if not has_patches(dataset):
        raise InputError(f"{key}: this result holds no contact patches; choose places with [output] patches_at_m")
    moments = []
    if "pose" in dataset.dims:
        names = [str(name) for name in dataset["pose"].values]
        for name in map(str, places):
            if name not in names:
                raise InputError(
                    f"{key} {name}: there is no such pose{suggest(name, names)}; there are {join_names(names, 12)}"
                )
            moments.append(names.index(name))
        return moments
    distances = dataset["snapshot_distance"].values.tolist()
    for place in places:
        try:
            offsets = [abs(d - float(place)) for d in distances]
        except (TypeError, ValueError):
            raise InputError(f"{key} {place}: must be a distance in m") from None
        if not min(offsets) <= NEAR:
            stored = join_names([f"{d:.1f}" for d in distances], 12)
            within = f"within {NEAR:g} m of that distance of the vehicle"
            raise InputError(f"{key} {place}: no patches are stored {within}; there are {stored}")
        moments.append(offsets.index(min(offsets)))
    return moments


TRACTIONS = {"element_qx": "qx", "element_qs": "qs"}
"""Channels of the exact solver's elements, and their names in a patch."""


def patch_of(dataset: xr.Dataset, position: str | float, wheel: str | None, number: int, columns: int) -> xr.Dataset:
    """One patch of one wheelset; parameters and errors as in `wrsim.results.Result.patch`."""
    wheels = [str(w) for w in dataset["wheel"].values]
    if wheel is None and len(wheels) == 1:
        wheel = wheels[0]
    if wheel not in wheels:
        fault = "choose a wheel" if wheel is None else f"wheel = {wheel!r:.40}: there is none of that name"
        raise InputError(f"{fault}{suggest(str(wheel), wheels)}: {', '.join(wheels)}")
    if columns < 2:
        raise InputError(f"columns = {columns}: must be at least 2")
    (moment,) = moments_at(dataset, [position], "at")
    dim = moment_dim(dataset)
    of_wheel = dataset.isel({dim: moment}).sel(wheel=wheel)
    count = int(np.isfinite(of_wheel["strip_p"].values).any(axis=-1).sum())
    if not 0 <= number < count:
        has = "no contact" if not count else "one patch" if count == 1 else f"{count} patches"
        raise InputError(f"number = {number}: the {wheel} wheel has {has} at {position}; the first is number 0")
    patch = of_wheel.isel(patch=number)
    if dim == "snapshot":
        patch = patch.isel(time=sample_of(dataset, moment))
    used = order_of_strips(patch["strip_s"].values, patch["strip_p"].values)
    strips = {str(n): v.values[used] for n, v in patch.variables.items() if v.dims == ("strip",)}
    fields = _elements(patch, used) or _strips(strips, columns)
    about = {name: CHANNELS[channel].attributes for channel, name in TRACTIONS.items()}
    about["p"] = {"units": "Pa", "long_name": "pressure"}
    x = xr.Variable("x", fields.pop("x"), {"units": "m", "long_name": "along the track"})
    variables = {name: (("s", "x"), values, about[name]) for name, values in fields.items()}
    along = {n: ("s", v, CHANNELS[n].attributes) for n, v in strips.items()}
    s = along.pop("strip_s")
    numbers = {str(n): v for n, v in patch.data_vars.items() if v.dims == () and "patch" in CHANNELS[str(n)].dims}
    place = {"pose": position} if dim == "pose" else {"distance_m": float(patch["snapshot_distance"])}
    return xr.Dataset(
        variables | along | {name: ((), value.values, dict(value.attrs)) for name, value in numbers.items()},
        coords={"s": s, "x": x},
        attrs={"title": dataset.attrs["title"], "wheel": wheel, "number": number, **place},
    )


def _strips(strips: dict[str, Array], columns: int) -> dict[str, Array]:
    """Semi-ellipses of pressure on common columns (x,): p (s, x), zero outside of contact."""
    middle, a, top = (np.nan_to_num(strips[f"strip_{name}"])[:, None] for name in ("x", "a", "p"))
    x = np.linspace((middle - a).min(), (middle + a).max(), columns)
    inside = 1.0 - np.divide(x - middle, a, out=np.full((a.size, columns), np.inf), where=a > 0.0) ** 2
    return {"x": x, "p": top * np.sqrt(np.maximum(inside, 0.0))}


def _elements(patch: xr.Dataset, used: NDArray[np.intp]) -> dict[str, Array] | None:
    if "element_p" not in patch or not np.isfinite(patch["element_x"].values).any():
        return None
    columns = np.flatnonzero(np.isfinite(patch["element_x"].values))
    channels = {"element_p": "p"} | TRACTIONS
    cut = {name: np.nan_to_num(patch[channel].values[np.ix_(used, columns)]) for channel, name in channels.items()}
    return {"x": patch["element_x"].values[columns]} | cut


RESOLVED = ("N", "p0", "area", "approach", "Fx", "Fy", "contact_angle")
"""Channels that are compared where contacts were solved again."""


def resolved_table(old: xr.Dataset, new: xr.Dataset, notes: tuple[str, ...] = ()) -> Table:
    """Every patch of one wheelset at the moments of ``new``: as in ``old``, and with contacts solved again."""
    sample = "time" if "time" in new.dims else "pose"
    names = [name for name in RESOLVED if name in old and name in new]
    rows: list[list[Cell]] = []
    for i, place in enumerate(new[sample].values):
        j = int(np.flatnonzero(old[sample].values == place)[0])
        label = quantity(float(new["snapshot_distance"].values[i]), "m", ".1f") if sample == "time" else str(place)
        for w, wheel in enumerate(new["wheel"].values):
            for k in range(new.sizes["patch"]):
                if _shown(old, "N", j, w, k) is _shown(new, "N", i, w, k) is None:
                    continue
                head = (label if w == k == 0 else "", str(wheel) if k == 0 else "", PATCHES[k])
                rows.append([*head, "was", *(_shown(old, name, j, w, k) for name in names)])
                rows.append(["", "", "", "now", *(_shown(new, name, i, w, k) for name in names)])
    heads = (Column("at"), Column("wheel"), Column("patch"), Column(""))
    return Table("", (*heads, *(Column.of(CHANNELS[name], name) for name in names)), rows, notes)


SUBSURFACE = ("von_mises_max", "von_mises_depth", "tresca_max", "tresca_depth")
FATIGUE = ("dang_van_max", "dang_van_depth", "crossland_max", "crossland_depth")
"""Channels of patches in the table of stresses below the surface."""


def has_subsurface(dataset: xr.Dataset) -> bool:
    """True where stresses below a surface were computed."""
    return "von_mises_max" in dataset and bool(np.isfinite(dataset["von_mises_max"].values).any())


def subsurface_tables(dataset: xr.Dataset) -> list[Table]:
    """Stresses and fatigue below every patch of one wheelset; no table where there are none."""
    if not has_subsurface(dataset):
        return []
    names = [name for name in (*SUBSURFACE, *FATIGUE) if name in dataset]
    rows: list[list[Cell]] = []
    for i in range(dataset["von_mises_max"].shape[0]):
        runs = "time" in dataset.dims
        place = quantity(float(dataset["snapshot_distance"].values[i]), "m", ".1f") if runs else ""
        for w, wheel in enumerate(dataset["wheel"].values):
            for k in range(dataset.sizes["patch"]):
                if _shown(dataset, "von_mises_max", i, w, k) is not None:
                    head = (place or str(dataset["pose"].values[i]), str(wheel), PATCHES[k])
                    rows.append([*head, *(_shown(dataset, name, i, w, k) for name in names)])
    heads = (Column("at"), Column("wheel"), Column("patch"))
    title = f"Below the surface of the {dataset.attrs.get('subsurface_body', 'rail')}"
    return [Table(title, (*heads, *(Column.of(CHANNELS[name], name) for name in names)), rows)]


def _shown(dataset: xr.Dataset, name: str, moment: int, wheel: int, patch: int) -> float | None:
    values = dataset[name].values
    return finite(values[moment, wheel, patch], CHANNELS[name].shown.factor) if patch < values.shape[2] else None
