"""The few numbers that people ask for first: peaks, where they occur, and quasi-static values in full curves.

Units stand in the keys. Nothing here is filtered: these are raw peaks, not the quantities of EN 14363.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.register import ANALYSES, resolved
from wrsim.results import wear
from wrsim.results.channels import CHANNELS, Channel
from wrsim.results.wheelsets import of_wheelset, wheelsets

CURVE_CHANNELS = (
    "lateral_shift", "yaw", "guide_force_y", "sum_Y", "Y", "Q", "Y_over_Q", "contact_angle", "p0", "T_gamma",
)  # fmt: skip
"""Channels whose median in each full curve is reported."""

PEAKS = {
    "Y_max_kN": ("Y, largest", "kN"),
    "Y_min_kN": ("Y, least", "kN"),
    "Y_abs_max_kN": ("Y, largest either way", "kN"),
    "Q_max_kN": ("Q, largest", "kN"),
    "Q_min_kN": ("Q, least", "kN"),
    "Y_over_Q_max": ("Y/Q, largest", ""),
    "T_gamma_max_N": ("wear number Tγ, largest", "N"),
    "N_max_kN": ("normal force of a patch, largest", "kN"),
    "p0_max_MPa": ("pressure p₀, largest", "MPa"),
    "contact_angle_max_deg": ("contact angle, largest", "°"),
    "contact_angle_variation_max_deg": ("turn of the normal in a patch, largest", "°"),
}
"""Words and units of the peaks of a wheel."""

OF_WHEELSET = {
    "lateral_shift_max_mm": ("lateral shift", "mm"),
    "angle_of_attack_max_mrad": ("angle of attack", "mrad"),
    "sum_Y_max_kN": ("track shifting force ΣY", "kN"),
    "guide_force_y_max_kN": ("lateral force of the guide frame", "kN"),
}
"""Words and units of the peaks of a wheelset: those largest either way, with their sign."""

_STEADY = 1e-4  # change of curvature over its largest value, per metre, below which a curve counts as full
_SHORTEST = 5  # samples of a full curve that make a median worth reporting


COUNTS = ("steps", "evaluations", "jacobians", "cut_steps", "explicit_steps")
"""What the integration of a run took, among the attributes of its result."""


def summarise(dataset: xr.Dataset) -> dict[str, Any]:
    """Plain numbers for ``summary.json``: status, what the integration took, versions, for each wheelset peaks with
    their place and full curves.

    Every peak is ``{"value": .., "distance_m": .., "time_s": ..}``, or with ``"pose"`` in a static analysis;
    ``None`` where there is no finite value. Peaks of patch channels run over all patches of the wheel.
    """
    attributes = dataset.attrs
    own = resolved(ANALYSES[str(attributes["analysis"])].summary)(dataset)
    head = {name: attributes[name] for name in ("title", "analysis", "status")} | {"stop": _stop(dataset)}
    names = [name for name in attributes if name.endswith("_version") and name != "format_version"]
    if "integrator" in attributes:
        counts = {name: int(attributes.get(name, 0)) for name in COUNTS}
        step = 1e3 * float(attributes["step_s"])
        head["integration"] = {"integrator": attributes["integrator"], "step_ms": step, **counts}
    return (
        head
        | own
        | _remarks(dataset)
        | {"versions": {name.removesuffix("_version"): attributes[name] for name in names}}
    )


def _remarks(dataset: xr.Dataset) -> dict[str, Any]:
    """What contacts of solved samples and limit cycles have to say, by the sample."""
    found: dict[str, str] = {}
    if "contact_remark" in dataset:
        (sample,) = dataset["contact_remark"].dims
        found |= {
            f"{sample} {at}": str(w)
            for at, w in zip(dataset[sample].values, dataset["contact_remark"].values, strict=True)
        }
    if "cycle_remark" in dataset:
        held = zip(
            dataset["cycle_speed"].values, dataset["cycle_branch"].values, dataset["cycle_remark"].values, strict=True
        )
        found |= {f"{3.6 * speed:.5g} km/h {branch}": str(words) for speed, branch, words in held}
    found = {place: words for place, words in found.items() if words}
    return {"remarks": found} if found else {}


def of_contacts(dataset: xr.Dataset) -> dict[str, Any]:
    """The summary of a run or of poses: how much was computed, peaks of every wheelset and point, events."""
    summary: dict[str, Any] = {
        "extent": extent(dataset),
        "wheelsets": {name: _of_wheelset(of_wheelset(dataset, name)) for name in wheelsets(dataset)},
    }
    if "point" in dataset.dims:
        summary["points"] = {str(point): _of_point(dataset.sel(point=point)) for point in dataset["point"].values}
    if "kinetic_energy" in dataset:
        summary["energy"] = energy(dataset)
    if wear.has_wear(dataset):
        summary["wear"] = wear.summary(dataset)
    if "event" in dataset.dims:
        values = (dataset[f"event_{name}"].values for name in ("time", "distance", "label"))
        summary["events"] = [
            {"time_s": float(t), "distance_m": float(s), "event": str(words)}
            for t, s, words in zip(*values, strict=True)
        ]
    return summary


ENERGY = {
    "work_of_pull_kJ": "work of the pull that holds the speed",
    "work_of_drive_kJ": "work of motors and brakes",
    "lost_in_creep_kJ": "lost in creep",
    "lost_in_dampers_kJ": "lost in dampers and friction of the suspension",
    "gained_in_motion_kJ": "gained in motion",
    "gained_in_height_kJ": "gained in height",
    "left_over_kJ": "left over: springs, rails, contacts, loads",
}
"""Parts of the balance of energy in words."""


def energy(dataset: xr.Dataset) -> dict[str, float]:
    """What became of the work of drive and pull over a run, in kJ.

    left_over_kJ: work less everything that is told; what springs, rails and contacts hold or lose and what loads do.
    """
    time = dataset["time"].values

    def over_time(power: str) -> float:
        return 1e-3 * float(np.trapezoid(dataset[power].values, time))

    found = {
        "work_of_pull_kJ": over_time("pull_power"),
        "work_of_drive_kJ": 1e-3 * float(dataset["drive_work"][-1].sum()) if "drive_work" in dataset else 0.0,
        "lost_in_creep_kJ": over_time("creep_power"),
        "lost_in_dampers_kJ": over_time("damper_power"),
    }
    for key, name in (("gained_in_motion_kJ", "kinetic_energy"), ("gained_in_height_kJ", "potential_energy")):
        found[key] = 1e-3 * float(dataset[name][-1] - dataset[name][0])
    work = found["work_of_pull_kJ"] + found["work_of_drive_kJ"]
    return found | {"left_over_kJ": work - sum(value for key, value in found.items() if not key.startswith("work"))}


def _of_wheelset(one: xr.Dataset) -> dict[str, Any]:
    """Peaks of one wheelset and its wheels, values in full curves."""
    found: dict[str, Any] = {
        "lateral_shift_max_mm": peak(one, "lateral_shift", largest_magnitude=True),
        "angle_of_attack_max_mrad": peak(one, "yaw", largest_magnitude=True),
        "wheels": {str(wheel): _wheel(one, str(wheel)) for wheel in one["wheel"].values},
    }
    if "sum_Y" in one:
        found["sum_Y_max_kN"] = peak(one, "sum_Y", largest_magnitude=True)
    if "guide_force_y" in one:
        found["guide_force_y_max_kN"] = peak(one, "guide_force_y", largest_magnitude=True)
    if "time" in one.dims:
        found["full_curves"] = full_curves(one)
    return found


def _of_point(one: xr.Dataset) -> dict[str, Any]:
    """Largest accelerations at one point."""
    return {f"{name}_max_m_s2": peak(one, name, largest_magnitude=True) for name in ("point_ay", "point_az")}


def peak(
    dataset: xr.Dataset,
    name: str,
    wheel: str | None = None,
    *,
    smallest: bool = False,
    largest_magnitude: bool = False,
) -> dict[str, Any] | None:
    """Largest value of a channel (smallest, largest in magnitude) in units for readers, and where it is.

    ``None`` when the channel is absent or has no finite value.
    """
    if name not in dataset:
        return None
    data = dataset.variables[name]  # its labels, carried along, take most of the time
    if wheel is not None:
        data = data.isel(wheel=int(np.flatnonzero(dataset.variables["wheel"].values == wheel)[0]))
    values = data.values.reshape(data.shape[0], int(np.prod(data.shape[1:])))
    finite = np.isfinite(values)
    if not finite.any():
        return None
    rank = np.abs(values) if largest_magnitude else (-values if smallest else values)
    index = np.unravel_index(np.argmax(np.where(finite, rank, -np.inf)), values.shape)
    found = {"value": shown(CHANNELS[name], float(values[index]))}
    return found | _place(dataset, int(index[0]))


def full_curves(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Quasi-static values: medians over the second half of every stretch of constant, non-zero curvature.

    Of a wheel's patches p0 is the largest pressure, the contact angle that of the patch with the largest force.
    """
    if "curvature" not in dataset or dataset.sizes["time"] < _SHORTEST:
        return []
    curves = []
    for first, last in _constant_stretches(dataset["distance"].values, dataset["curvature"].values):
        part = dataset.isel(time=slice((first + last) // 2, last + 1))
        curve: dict[str, Any] = {
            "from_m": float(dataset["distance"].values[first]),
            "to_m": float(dataset["distance"].values[last]),
            "radius_m": 1.0 / float(np.median(part["curvature"])),
        }
        if "cant" in part:
            curve["cant_mm"] = float(np.median(part["cant"])) * 1e3
        for name in CURVE_CHANNELS:
            if name in part and "wheel" not in part[name].dims:
                curve[CHANNELS[name].column] = _median(part[name], CHANNELS[name])
        for wheel in dataset["wheel"].values:
            curve[str(wheel)] = {
                CHANNELS[name].column: _median(_of_wheel(part[name].sel(wheel=wheel)), CHANNELS[name])
                for name in CURVE_CHANNELS
                if name in part and "wheel" in part[name].dims
            }
        curves.append(curve)
    return curves


def shown(channel: Channel, value: float) -> float | None:
    """The value in the unit for readers; ``None`` for not-a-number."""
    return float(value) * channel.shown.factor if np.isfinite(value) else None


def _constant_stretches(distance: NDArray[Any], curvature: NDArray[Any]) -> list[tuple[int, int]]:
    """First and last sample of every stretch of constant, non-zero curvature."""
    scale = np.nanmax(np.abs(curvature), initial=0.0)
    if not scale > 0.0:
        return []
    change = np.abs(np.diff(curvature)) <= _STEADY * scale * np.maximum(np.abs(np.diff(distance)), 1e-3)
    steady = change & (np.abs(curvature[1:]) > 1e-3 * scale)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], steady.astype(int), [0]))))
    pairs = zip(edges[::2], edges[1::2], strict=True)
    return [(int(first), int(last)) for first, last in pairs if last - first + 1 >= _SHORTEST]


def _of_wheel(data: xr.DataArray) -> xr.DataArray:
    """One value of a wheel's patches: the largest pressure of all, else that of the patch with the largest force."""
    if "patch" not in data.dims:
        return data
    return data.max("patch") if data.name == "p0" else data.isel(patch=0)


def _median(data: xr.DataArray, channel: Channel) -> float | None:
    values = data.values[np.isfinite(data.values)]
    return shown(channel, float(np.median(values))) if values.size else None


def _place(dataset: xr.Dataset, index: int) -> dict[str, Any]:
    if "pose" in dataset.dims:
        return {"pose": str(dataset["pose"].values[index])}
    place = {"distance_m": float(dataset.variables["distance"][index])} if "distance" in dataset.coords else {}
    return place | {"time_s": float(dataset.variables["time"][index])}


def _wheel(dataset: xr.Dataset, wheel: str) -> dict[str, Any]:
    """Peaks of one wheel."""
    return {
        "Y_max_kN": peak(dataset, "Y", wheel),
        "Y_min_kN": peak(dataset, "Y", wheel, smallest=True),
        "Y_abs_max_kN": peak(dataset, "Y", wheel, largest_magnitude=True),
        "Q_max_kN": peak(dataset, "Q", wheel),
        "Q_min_kN": peak(dataset, "Q", wheel, smallest=True),
        "Y_over_Q_max": peak(dataset, "Y_over_Q", wheel),
        "T_gamma_max_N": peak(dataset, "T_gamma", wheel),
        "N_max_kN": peak(dataset, "N", wheel),
        "p0_max_MPa": peak(dataset, "p0", wheel),
        "contact_angle_max_deg": peak(dataset, "contact_angle_max", wheel),
        "contact_angle_variation_max_deg": peak(dataset, "contact_angle_variation", wheel),
    }


def _stop(dataset: xr.Dataset) -> dict[str, Any] | None:
    """Why, when and where the analysis stopped early; ``None`` when it did not."""
    attributes = dataset.attrs
    if attributes["status"] != "stopped":
        return None
    stop: dict[str, Any] = {"reason": attributes["stop_reason"]}
    if "stop_cause" in attributes:
        stop["cause"] = attributes["stop_cause"]
    for key in ("stop_time_s", "stop_distance_m"):
        if key in attributes:
            value = float(attributes[key])
            stop[key.removeprefix("stop_")] = value if np.isfinite(value) else None
    return stop


def extent(dataset: xr.Dataset) -> dict[str, Any]:
    """How much was computed."""
    if "pose" in dataset.dims:
        solved = np.ones(dataset.sizes["pose"], dtype=bool)
        if "pose_message" in dataset:
            solved = dataset["pose_message"].values == ""
        return {"poses": int(solved.size), "solved": int(solved.sum())}
    extent: dict[str, Any] = {"samples": dataset.sizes["time"]}
    if dataset.sizes["time"]:
        extent["time_s"] = float(dataset["time"].values[-1])
        if "distance" in dataset.coords:
            extent["distance_m"] = float(dataset["distance"].values[-1])
    return extent
