"""Moments: snapshots of a run and poses of a static analysis; their titles, patches and strips; lines of poses."""

from dataclasses import dataclass
from string import ascii_lowercase
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.plots.marks import minus
from wrsim.plots.theme import shown
from wrsim.results import CHANNELS
from wrsim.results.moments import Strips, moment_dim, order_of_strips, sample_of, with_patches
from wrsim.results.table import quantity


@dataclass(frozen=True)
class PatchAt:
    """Address of one patch in the dataset: moment (index), wheel (name), patch (index)."""

    moment: int
    wheel: str
    patch: int


def choose_moments(dataset: xr.Dataset, most: int) -> list[int]:
    """At most ``most`` moments that have strips, evenly spread, first and last among them. Poses come in the order of
    their groups (yaw, load), each group with its share."""
    has_strips = with_patches(dataset)
    runs = moment_dim(dataset) == "snapshot"
    groups = [np.arange(has_strips.size)] if runs else [member for _, member in pose_groups(dataset)]
    groups = [used for used in (group[has_strips[group]] for group in groups) if used.size]
    chosen: list[int] = []
    for i, group in enumerate(groups[:most]):
        share = (most - len(chosen)) // (min(len(groups), most) - i)
        spread = np.unique(np.round(np.linspace(0, group.size - 1, min(share, group.size))).astype(int))
        chosen += [int(j) for j in group[spread]]
    return chosen


def patches_at(dataset: xr.Dataset, moment: int, wheel: str) -> list[PatchAt]:
    """Patches of one wheel at a moment."""
    index = _indices(dataset, PatchAt(moment, wheel, 0)) | {"patch": slice(None)}
    finite = np.isfinite(dataset.variables["strip_p"].isel(index).values)
    return [PatchAt(moment, wheel, int(k)) for k in np.flatnonzero(finite.any(axis=-1))]


def snapshot_letter(index: int) -> str:
    """a, b, ..., z, aa, ab, ..."""
    return (ascii_lowercase[index // 26 - 1] if index >= 26 else "") + ascii_lowercase[index % 26]


def select(dataset: xr.Dataset, where: PatchAt) -> Strips:
    """The strips of one patch by increasing s: the channels that are drawn."""
    index = _indices(dataset, where)
    values = {}
    for name in (f"strip_{n}" for n in ("s", "ds", "x", "a", "p", "angle", "y", "z", "N")):
        if (variable := dataset.variables.get(name)) is not None:
            values[name] = variable.values[tuple(index.get(str(dim), slice(None)) for dim in variable.dims)]
    used = order_of_strips(values["strip_s"], values["strip_p"])
    return Strips({name: array[used] for name, array in values.items()})


def _indices(dataset: xr.Dataset, where: PatchAt) -> dict[str, Any]:
    wheel = list(dataset.variables["wheel"].values).index(where.wheel)
    return {moment_dim(dataset): where.moment, "patch": where.patch, "wheel": wheel}


def select_elements(dataset: xr.Dataset, where: PatchAt) -> tuple[NDArray, NDArray, NDArray] | None:
    """Elements of one patch of the exact solver in mm and MPa: s of the rows, x of the columns, pressures over (s, x),
    zero outside of contact. None when there are none."""
    if "element_p" not in dataset:
        return None
    patch = dataset[["strip_s", "element_x", "element_p"]].isel(_indices(dataset, where))
    s, x, p = (shown(patch, str(name)) for name in patch)
    rows, columns = np.isfinite(s), np.isfinite(x)
    return (s[rows], x[columns], np.nan_to_num(p[np.ix_(rows, columns)])) if columns.any() else None


def touching_runs(strips: Strips) -> list[Strips]:
    """The strips under pressure, split where a gap lies between neighbours: the islands of one patch."""
    a, p = (strips.variables[f"strip_{name}"] for name in "ap")
    pressed = np.flatnonzero((a > 0.0) & (p > 0.0))
    s, ds = (strips.variables[f"strip_{name}"][pressed] for name in ("s", "ds"))
    gaps = np.flatnonzero(np.diff(s) > 0.75 * (ds[1:] + ds[:-1])) + 1
    islands = [part for part in np.split(pressed, gaps) if part.size]
    return [Strips({name: array[part] for name, array in strips.variables.items()}) for part in islands]


def moment_title(dataset: xr.Dataset, moment: int, order: int) -> str:
    """Title of a panel, one or two lines: letter, then distance of the vehicle (and that of the wheelset where these
    differ) and reason, or the pose. The letter is the snapshot's own, as in the histories; poses are lettered in the
    ``order`` of the picture."""
    if moment_dim(dataset) == "snapshot":
        place = dataset["snapshot_distance"].values[moment]
        wheelset = dataset["distance"].values[sample_of(dataset, moment)]
        label = str(dataset["snapshot_label"].values[moment]) if "snapshot_label" in dataset else ""
        places = {"vehicle ": place, "wheelset ": wheelset} if abs(wheelset - place) >= SEPARATE_LABELS else {"": place}
        stations = ", ".join(f"{who}{quantity(float(where), 'm', '.1f')}" for who, where in places.items())
        lines = [f"({snapshot_letter(moment)}) {stations}", "" if label.startswith("at ") else label]  # it is the place
    else:
        forms = {"lateral_shift": (r"$\Delta y$ = ", ".3g"), "yaw": (r"$\psi$ = ", ".3g"), "load": ("", ".4g")}
        varied = [n for n in forms if n in dataset and (n == "lateral_shift" or np.ptp(dataset[n].values) > 0.0)]
        values = ((*forms[n], float(shown(dataset, n)[moment]), CHANNELS[n].shown.symbol) for n in varied)
        parts = [minus(symbol + quantity(value, unit, form)) for symbol, form, value, unit in values]
        lines = [f"({snapshot_letter(order)}) {', '.join(parts[:1])}", ", ".join(parts[1:])]
    return "\n".join(filter(None, lines))


SEPARATE_LABELS = 0.05
"""Difference of two distances that one decimal shows [m]."""
ABSCISSAE = ("lateral_shift", "yaw", "load")
"""Channels of a pose that may be on the horizontal axis, in order of preference."""


def pose_abscissa(dataset: xr.Dataset) -> str:
    """The channel on the horizontal axis: lateral shift, unless only yaw or load vary."""
    varied = [n for n in ABSCISSAE if n in dataset and np.ptp(dataset[n].values) > 0.0]
    return varied[0] if varied else "lateral_shift"


def pose_groups(dataset: xr.Dataset) -> list[tuple[str, NDArray[np.intp]]]:
    """Poses that make one line: label and indices in the order of the horizontal axis."""
    across = pose_abscissa(dataset)
    parameters = [n for n in ABSCISSAE if n in dataset and n != across and np.ptp(dataset[n].values) > 0.0]
    x = dataset[across].values
    if not parameters:
        return [("", np.argsort(x, kind="stable"))]
    keys = np.column_stack([np.round(shown(dataset, n), 9) for n in parameters])
    groups = []
    for key in np.unique(keys, axis=0):
        member = np.flatnonzero((keys == key).all(axis=1))
        pairs = [(CHANNELS[n], value) for n, value in zip(parameters, key.tolist(), strict=True)]
        values = (f"${c.symbol}$ = " * bool(c.symbol) + quantity(value, c.shown.symbol) for c, value in pairs)
        groups.append((minus(", ".join(values)), member[np.argsort(x[member], kind="stable")]))
    return groups


LARGEST_FORCE = 200.0
"""Poses that press a wheel on its rail with more [kN] are left out of axes: more than any limit of Q in EN 14363."""


def beyond_railways(forces: NDArray[np.float64]) -> tuple[NDArray[np.bool_], str]:
    """Poses that no railway has, of normal forces (pose, ...) of wheels [kN], and words for them; none where that
    leaves nothing to draw."""
    most = np.nan_to_num(forces).reshape(len(forces), -1).max(axis=1, initial=0.0)
    heavy = most > LARGEST_FORCE
    if heavy.all() or not heavy.any():
        return np.zeros_like(heavy), ""
    largest = quantity(float(most.max()), "kN", ".0f")
    return heavy, f"{int(heavy.sum())} of {heavy.size} poses, with up to {largest} on a wheel, are left out of the axes"


def ends_of(values: NDArray[np.float64]) -> tuple[float, float]:
    """Ends of an axis that holds the values with a margin."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    margin = 0.06 * max(high - low, 1e-9)
    return low - margin, high + margin
