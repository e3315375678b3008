"""A table of contacts over shift, yaw, roll and load, for other codes."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from wrsim.analysis.poses.solver import CLEARANCE, PoseSolver
from wrsim.analysis.poses.static import STANDARD_SPACING, on_rail
from wrsim.contact.channels import contact_channels
from wrsim.contact.models import contact_model
from wrsim.contact.settings import DRY, AnyFriction, ContactSettings
from wrsim.contact.status import UNMET
from wrsim.errors import InputError
from wrsim.geometry.profile.profile import Profile
from wrsim.geometry.track.track import STANDARD_GAUGE
from wrsim.results import CHANNELS

AXES = {"shift": "m", "yaw": "rad", "roll": "rad", "load": "N"}
MOST_POSES = 1_000_000


def contact_map(
    wheel: Profile,
    rail: Profile,
    radius: float,
    shifts: ArrayLike,
    yaws: ArrayLike = 0.0,
    rolls: ArrayLike = 0.0,
    loads: ArrayLike = 60e3,
    *,
    settings: ContactSettings | None = None,
    friction: AnyFriction = DRY,
    side: Literal["left", "right"] = "left",
    gauge: float = STANDARD_GAUGE,
    profile_spacing: float = STANDARD_SPACING,
    rolling: bool = True,
    threads: int | None = None,
    file: str | Path | None = None,
) -> xr.Dataset:
    """Contacts of one wheel over every combination of shift, yaw, roll and vertical load.

    Parameters
    ----------
    wheel, rail : Profile
        The rail with its inclination, ``rail.inclined(1 / 40)``.
    radius : float
        Of the wheel at the tape circle [m].
    shifts, yaws, rolls, loads : array_like
        One number or a list of each: lateral shift of the wheelset, positive to the left [m]; yaw, positive to the
        left, and roll, positive lifts the left wheel [rad]; vertical force [N].
    settings, friction
        As in `contact_model`.
    side, gauge, profile_spacing, rolling
        As in `solve_poses`.
    threads : int, optional
        That compute poses side by side; default all cores of the machine.
    file : str or Path, optional
        Where the table is saved, as NetCDF.

    Returns
    -------
    xarray.Dataset
        Over ``shift``, ``yaw``, ``roll``, ``load`` and, where it belongs to a patch, ``patch``, the largest normal
        force first: ``vertical_shift`` of the wheelset's centre, ``X``, ``Y``, ``Q``, ``T_gamma``, ``n_patches``,
        ``status``; of the patches ``N``, ``p0``, ``area``, ``approach``, ``contact_angle``, ``xi``, ``eta``,
        ``phi`` ..., each with its ``units``. Names and signs are those of results.
        Not-a-number where a load is not met; ``status`` has the reason.

    Raises
    ------
    InputError
        For empty lists, numbers that are not finite, loads not above 0, more threads than cores, a side that there is
        not, the exact half-space solver.

    Examples
    --------
    >>> from wrsim import contact_map, load_profile
    >>> rail = load_profile("rails/60E1.toml").inclined(1 / 40)
    >>> table = contact_map(load_profile("wheels/S1002.toml"), rail, 0.46, [0.0, 3e-3], loads=[50e3, 60e3])
    """
    model = contact_model(wheel, rail, radius, settings, friction)
    axes = {}
    for name, values in zip(AXES, (shifts, yaws, rolls, loads), strict=True):
        axes[name] = np.atleast_1d(np.asarray(values, dtype=float))
        if axes[name].ndim != 1 or not axes[name].size or not np.isfinite(axes[name]).all():
            raise InputError(f"{name}s: must be a number or a list of numbers, all finite")
    shape = tuple(values.size for values in axes.values())
    if np.prod(shape) > MOST_POSES:
        raise InputError(f"{np.prod(shape)} combinations of shifts, yaws, rolls and loads; allowed: {MOST_POSES}")
    placed = on_rail(model, side, gauge, profile_spacing, rolling)
    solver = PoseSolver([placed], rolling, radius)
    start = radius + CLEARANCE + np.abs(np.sin(axes["roll"])).max() * placed.half_spacing
    rows = np.empty((*shape, len(placed.model.arrays.pose)))
    for i, shift in enumerate(axes["shift"]):
        for j, yaw in enumerate(axes["yaw"]):
            for m, roll in enumerate(axes["roll"]):
                solver.place(float(shift), float(start), float(yaw), float(roll))
                rows[i, j, m] = placed.model.arrays.pose
    rows = rows.reshape(-1, rows.shape[-1])
    wanted = np.broadcast_to(axes["load"], shape).ravel()
    found = placed.model.solve_many(rows, wanted, threads=threads)
    unmet = (found.status & UNMET) != 0
    channels = {name: values[:, 0] for name, values in contact_channels(found.raw, [placed]).items()}
    channels["vertical_shift"] = found.poses[:, 2] - rows[:, 2] + start - radius
    table = xr.Dataset(
        coords={name: (name, values, {"units": AXES[name]}) for name, values in axes.items()},
        attrs={
            "title": f"contacts of {wheel.name} on {rail.name}", "radius_m": radius, "gauge_m": gauge, "side": side,
            "profile_spacing_m": profile_spacing, "rolling": int(rolling),
            "normal": model.settings.normal, "creep_forces": placed.model.settings.creep_forces,
        },
    )  # fmt: skip
    for name, values in channels.items():
        values = np.where(unmet.reshape(-1, *(1,) * (values.ndim - 1)), np.nan, values)
        dims = (*AXES, "patch")[: 3 + values.ndim]
        table[name] = dims, values.reshape(*shape, *values.shape[1:]), {"units": CHANNELS[name].unit}
    table["status"] = tuple(AXES), found.status.reshape(shape), {"units": "1"}
    if file is not None:
        table.to_netcdf(file)
    return table
