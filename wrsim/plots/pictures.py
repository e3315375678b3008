"""The pictures that every analysis gets."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from wrsim.errors import InputError
from wrsim.inputs.file_kinds import resolved
from wrsim.plots.bent import bent_figures
from wrsim.plots.cross_section import has_outlines, section_gallery
from wrsim.plots.drawing import save_all
from wrsim.plots.histories import ANGLES, VEHICLE_PICTURES, channels_figure, enveloped, overview_figure, vehicle_figures
from wrsim.plots.patches import patch_gallery
from wrsim.plots.static import PANELS, static_figure
from wrsim.plots.subsurface import subsurface_figure
from wrsim.plots.wear import fatigue_figure, wear_figure
from wrsim.register import ANALYSES
from wrsim.results import CHANNELS, Result
from wrsim.results.channels import NAMES
from wrsim.results.moments import has_patches, has_subsurface, is_history
from wrsim.results.summary import has_wear
from wrsim.results.wheelsets import fast_of, of_wheelset, wheelset_folder, wheelsets, worst_wheelset

HISTORIES = {
    "forces": ("Q", "Y", "sum_Y", "guide_force_y"),
    "contact": ("p0", "area", "T_gamma", "temperature", "rail_friction", "rail_friction_corner"),
}
"""Pictures of a run beside its overview, and the channels in them; none is in two: every panel costs time."""


def standard_figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Makers of the pictures that the register names for the dataset's analysis, by file name without ending."""
    figures: dict[str, Callable[[], Figure]] = resolved(ANALYSES[str(dataset.attrs["analysis"])].pictures)(dataset)
    return figures


def of_contacts(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Pictures of the vehicle (``vehicle_figures``) and of the wheelset with the largest Y/Q (``wheelset_figures``),
    in a folder of its own where there are several."""
    worst = worst_wheelset(dataset)
    folder = wheelset_folder(wheelsets(dataset), worst)
    vehicle_names = (name for _, names in VEHICLE_PICTURES.values() for name in names.split())
    drawn = enveloped(dataset, {*ANGLES, *vehicle_names, *(name for names in HISTORIES.values() for name in names)})
    of_worst = wheelset_figures(of_wheelset(dataset, worst), of_wheelset(drawn, worst))
    of_wear = {"wear": wear_figure, "fatigue": fatigue_figure} if has_wear(dataset) else {}
    of_vehicle = vehicle_figures(drawn) | {name: partial(make, dataset) for name, make in of_wear.items()}
    of_vehicle |= bent_figures(dataset)
    return of_vehicle | {f"{folder}{name}": make for name, make in of_worst.items()}


def wheelset_figures(data: xr.Dataset, drawn: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Makers of the pictures of one wheelset of which there are data, by file name without ending: histories of runs,
    contacts over poses, patches and sections of both. drawn: what histories are drawn of."""
    figures: dict[str, Callable[[], Figure]] = {}
    if is_history(data):
        if set(ANGLES) <= set(drawn):
            figures["overview"] = partial(overview_figure, drawn)
        for name, channels in HISTORIES.items():
            present = tuple(c for c in channels if c in drawn and (c != "guide_force_y" or drawn[c].values.any()))
            if present:
                figures[name] = partial(channels_figure, drawn, present)
        fast = [str(n) for n, variable in drawn.data_vars.items() if variable.dims[:1] == ("fast_time",)]
        if fast:
            figures["fast"] = partial(channels_figure, fast_of(drawn), [name.removeprefix("fast_") for name in fast])
    elif data.sizes.get("pose", 0) > 1 and any(np.isfinite(data[name]).any() for name in PANELS if name in data):
        figures["contact"] = partial(static_figure, data)
    if has_patches(data):
        figures["patches"] = partial(patch_gallery, data)
        if has_outlines(data):
            figures["sections"] = partial(section_gallery, data)
    if has_subsurface(data):
        figures["subsurface"] = partial(subsurface_figure, data)
    return figures


def standard_pictures(dataset: xr.Dataset, directory: str | Path) -> list[Path]:
    """Write the standard pictures as PNG into ``directory``; returns their paths. Raises ``WrsimError``."""
    return save_all(standard_figures(dataset), directory)


def picture(result: Result, names: Sequence[str], wheelset: str | None) -> Figure:
    """A standard picture by its name (without names the first), or channels; see `wrsim.results.Result.plot`."""
    chosen = result.dataset if wheelset is None else result.wheelset(wheelset)
    figures = standard_figures(chosen)
    if not names and figures:
        names = (next(iter(figures)),)
    if len(names) == 1 and names[0] in figures:
        return figures[names[0]]()
    if names and all(name.startswith("fast_") for name in names) and "fast_time" in chosen.dims:
        result, names = Result(fast_of(chosen)), [name.removeprefix("fast_") for name in names]
        chosen = result.dataset
    dims = {str(n): tuple(d for d in v.dims if d != "wheelset") for n, v in chosen.variables.items()}
    numbers = (name for name in dims if name not in chosen.dims and CHANNELS[name].kind == "number")
    channels = [name for name in numbers if dims[name] in DRAWN]
    known, means = NAMES.among((*channels, *figures)), [NAMES.among(channels).understood(str(name)) for name in names]
    for word, name in zip(names, means, strict=True):
        if name is None:
            raise InputError(
                f"plot: '{word}' is neither a picture nor a channel of this result: {known.unknown(str(word))}"
            )
    names = [name for name in means if name]
    if not names:
        raise InputError("plot: this result has no pictures")
    several = len(wheelsets(chosen)) > 1 and any("wheelset" in chosen[name].dims for name in names)
    data = result.wheelset() if several else of_wheelset(chosen, wheelsets(chosen)[0])
    return static_figure(data, names) if "pose" in data.dims else channels_figure(enveloped(data, names), names)


DRAWN = (("time",), *((sample, *rest) for sample in ("time", "pose") for rest in (("wheel",), ("wheel", "patch"))))
"""Dimensions, besides that of wheelsets, of channels that `picture` draws: a line, or one a wheel and patch."""
