"""Results that look like real ones, made without a simulation, to develop and test tables and pictures.

S1002 rolls on 60E1 (1:40) by Kik-Piotrowski; the motion through the curve is invented."""

from functools import lru_cache
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from support.contacts import RADIUS, pair_model
from wrsim import Pose, solve_poses
from wrsim.results import assemble

SCENARIO = 'title = "synthetic"\nanalysis = "curving"  # not a scenario that anyone ran\n'
SIDES = ("left", "right")
LOST = "the flange is over the rail"
OWN = {"Y_over_Q", "sum_Y", "load", "pose_message", "lateral_shift", "vertical_shift", "yaw", "roll"}
"""Channels that follow from others, or that the results here say themselves."""


def wheels_at(
    shifts: NDArray[np.float64], yaws: NDArray[np.float64], loads: NDArray[np.float64], sides: tuple[str, ...] = SIDES
) -> dict[str, NDArray[Any]]:
    """Channels of wheels at lateral shifts [m], yaws [rad] and loads (poses, wheels) [N], of a single wheelset."""
    wheels = []
    for j, side in enumerate(sides):
        model = pair_model("S1002/60E1 1:40", strips=31, cells=8, max_patches=3)
        poses = [Pose(f"{i}", *arguments) for i, arguments in enumerate(zip(shifts, yaws, loads[:, j], strict=True))]
        wheels.append(solve_poses(model, poses, side=side).wheelset())  # type: ignore[arg-type]
    joined = xr.concat(wheels, "wheel", data_vars="minimal", coords="minimal", compat="override", join="outer")
    joined = joined.transpose("pose", "wheel", ...)
    return {str(n): v.values for n, v in joined.data_vars.items() if n not in OWN and "wheel" in v.dims}


def lose(arrays: dict[str, NDArray[Any]], force: float, *place: Any) -> None:
    """Take wheels off their rails at these places in the arrays; force: what they are left with."""
    for name, values in arrays.items():
        if not name.startswith(("wheel_", "rail_")):
            values[place] = 0 if values.dtype.kind == "i" else force if values.ndim == 2 else np.nan


@lru_cache(maxsize=4)
def curve_run(samples: int = 200, stopped: bool = False, radius: float = 300.0) -> xr.Dataset:
    """A wheelset through a left curve (a right curve for a negative radius); ``stopped`` derails it half way."""
    distance, speed, hand = np.linspace(0.0, 260.0, samples), 15.0, np.sign(radius)
    shape, late = (np.interp(distance - x, [30.0, 70.0, 190.0, 230.0], [0.0, 1.0, 1.0, 0.0]) for x in (0.0, 4.0))
    swing = np.sin(2 * np.pi * distance / 16.0) * np.exp(-np.abs(distance - 62.0) / 25.0)
    shift = -hand * (6.1e-3 * late**0.6 + 0.5e-3 * swing)
    yaw = -hand * (5.5e-3 * late + 0.8e-3 * np.cos(2 * np.pi * distance / 16.0) * np.exp(-distance / 60.0))
    if stopped:
        samples = int(0.55 * samples)
        shift[samples - 8 : samples] -= hand * np.linspace(0.0, 2.5e-3, 8)
    chosen = [int(f * samples) for f in (0.05, 0.22, 0.28, 0.5)] + [samples - 1]
    distance, shape, shift, yaw = (values[:samples] for values in (distance, shape, shift, yaw))
    loads = 80e3 * (1.0 + 0.01 * swing[:samples, None] - 0.18 * hand * np.outer(shape, (1.0, -1.0)))
    arrays = wheels_at(shift, yaw, loads)
    if stopped:
        lose(arrays, 0.0, slice(-7, None), int(hand < 0.0))
    kept = {name: arrays.pop(name)[chosen] for name in list(arrays) if name.startswith(("strip_", "wheel_", "rail_"))}
    channels = arrays | kept | {
        "distance": distance,
        "speed": speed,
        "curvature": shape / radius,
        "cant": hand * shape * 0.06,
        "lateral_shift": shift,
        "vertical_shift": -2e-5,
        "yaw": yaw,
        "roll": shift * 0.05,
        "spin_rate": speed / RADIUS,
        "snapshot_time": distance[chosen] / speed,
        "snapshot_distance": distance[chosen],
        "snapshot_label": ["straight", "transition", "largest Y/Q", "full curve", "end"],
    }  # fmt: skip
    attributes: dict[str, Any] = {
        "title": "Synthetic: a wheelset through a 300 m curve",
        "analysis": "curving",
        "status": "stopped" if stopped else "completed",
        "scenario_text": SCENARIO,
    }
    if stopped:
        attributes |= {
            "stop_reason": "derailment: the left wheel had no contact over 2 m of track",
            "stop_time_s": float(distance[-1] / speed),
            "stop_distance_m": float(distance[-1]),
        }
    return assemble({"time": distance / speed}, channels, attributes)


@lru_cache(maxsize=4)
def static_poses(
    shifts_mm: tuple[float, ...] = tuple(np.arange(-10.0, 10.5, 1.0).tolist()),
    yaws_mrad: tuple[float, ...] = (0.0, 12.0),
    wheels: tuple[str, ...] = SIDES,
    load: float = 160e3,
) -> xr.Dataset:
    """A grid of static poses; the last shift of the last yaw has no solution when there are many."""
    grid = [(y, psi) for psi in yaws_mrad for y in shifts_mm]
    shift, yaw = 1e-3 * np.array(grid).T
    loads = np.outer(1.0 + 1e-5 * np.arange(len(grid)), np.full(len(wheels), load / len(wheels)))  # no two alike
    arrays = wheels_at(shift, yaw, loads, wheels)
    message = [""] * len(grid)
    if len(grid) > 20:
        message[-1] = LOST
        lose(arrays, np.nan, -1)
    channels = arrays | {
        "lateral_shift": shift,
        "yaw": yaw,
        "roll": 0.0,
        "vertical_shift": -5e-5,
        "load": load,
        "pose_message": message,
    }  # fmt: skip
    attributes = {
        "title": "Synthetic: S1002 on 60E1 1:40",
        "analysis": "static",
        "status": "completed",
        "scenario_text": SCENARIO,
    }
    return assemble({"pose": [f"y{y:+g}_yaw{psi:g}" for y, psi in grid], "wheel": wheels}, channels, attributes)
