"""The pictures that every analysis gets."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from wrsim.plots.conicity import conicity_figure
from wrsim.plots.cross_section import has_outlines, section_gallery
from wrsim.plots.histories import (
    ANGLES,
    channels_figure,
    contact_angle_figure,
    overview_figure,
)
from wrsim.plots.moments import has_patches
from wrsim.plots.patches import patch_gallery
from wrsim.plots.stability import bifurcation_figure, modes_figure
from wrsim.plots.static import PANELS, static_figure
from wrsim.plots.steady import steady_figure
from wrsim.plots.style import save
from wrsim.plots.vehicle_run import vehicle_figures
from wrsim.results.wheelsets import is_vehicle, of_wheelset, worst_wheelset

HISTORIES: dict[str, tuple[str, ...]] = {
    "forces": ("Q", "Y"),
    "derailment": ("Y_over_Q", "T_gamma"),
    "motion": ("lateral_shift", "yaw"),
    "pressure": ("p0", "area"),
}
"""Pictures of a run and the channels in them."""


def standard_figures(dataset: xr.Dataset) -> dict[str, Callable[[], Figure]]:
    """Makers of the pictures that suit the dataset, by file name without ending.

    Runs of several instants: overview, contact_angle, forces, derailment, motion, pressure. Static analyses of
    several poses: contact. Whole vehicles: their own histories, and all of these for the wheelset with the largest
    Y/Q. Both: patches and sections of the snapshots or poses. Conicity analyses: conicity. Stability analyses: modes,
    bifurcation. Steady ones: steady. What the dataset has no data for is left out.
    """
    figures: dict[str, Callable[[], Figure]] = {}
    if "mode_growth" in dataset:
        figures["modes"] = lambda: modes_figure(dataset)
        if "cycle" in dataset.dims:
            figures["bifurcation"] = lambda: bifurcation_figure(dataset)
        return figures
    if "pose_radius" in dataset:
        return {"steady": lambda: steady_figure(dataset)}
    if is_vehicle(dataset):
        worst = worst_wheelset(dataset)
        if dataset.sizes.get("time", 0) > 1:
            figures |= vehicle_figures(dataset)
        return figures | {f"{worst}_{k}": make for k, make in standard_figures(of_wheelset(dataset, worst)).items()}
    if "equivalent_conicity" in dataset:
        return {"conicity": lambda: conicity_figure(dataset)}
    if dataset.sizes.get("time", 0) > 1 and "resolved_with" not in dataset.attrs:  # these are moments, no history
        if set(ANGLES) <= set(dataset):
            figures["overview"] = lambda: overview_figure(dataset)
            figures["contact_angle"] = lambda: contact_angle_figure(dataset)
        for name, channels in HISTORIES.items():
            present = tuple(c for c in channels if c in dataset)
            if present:
                figures[name] = _channels(dataset, present)
    elif dataset.sizes.get("pose", 0) > 1 and any(_has_values(dataset, name) for name in PANELS):
        figures["contact"] = lambda: static_figure(dataset)
    if has_patches(dataset):
        figures["patches"] = lambda: patch_gallery(dataset)
        if has_outlines(dataset):
            figures["sections"] = lambda: section_gallery(dataset)
    return figures


def standard_pictures(dataset: xr.Dataset, directory: str | Path) -> list[Path]:
    """Write the standard pictures as PNG into ``directory``; returns their paths. Raises ``WrsimError``."""
    directory = Path(directory)
    return [save(make(), directory / f"{name}.png") for name, make in standard_figures(dataset).items()]


def _channels(dataset: xr.Dataset, names: tuple[str, ...]) -> Callable[[], Figure]:
    return lambda: channels_figure(dataset, names)


def _has_values(dataset: xr.Dataset, name: str) -> bool:
    return name in dataset and bool(np.isfinite(dataset[name].values).any())
