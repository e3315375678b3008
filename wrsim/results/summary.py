"""The few numbers that people ask for first: peaks, where they occur, quasi-static values in full curves, wear.

Units are in the keys. Raw peaks are those of samples; beside them are those of forces below 20 Hz, of ΣY and Y/Q over
2 m, the evaluation of EN 14363 without its percentiles.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import tee
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from wrsim.errors import InputError
from wrsim.inputs.file_kinds import resolved
from wrsim.register import ANALYSES
from wrsim.results.channels import CHANNELS
from wrsim.results.dataset import ASSUMPTIONS, COUNTS
from wrsim.results.netcdf import parts_of
from wrsim.results.table import finite, quantity
from wrsim.results.wheelsets import of_wheelset, wheelsets

CURVE_CHANNELS = {
    "lateral_shift": "shift", "yaw": "attack", "guide_force_y": "guide force", "sum_Y": "ΣY",
    "Y": "Y", "Q": "Q", "Y_over_Q": "Y/Q", "T_gamma": "Tγ",
}  # fmt: skip
"""Channels of wheelsets and wheels whose median in each full curve is reported, and their headings."""

PATCH_CHANNELS = {"N": "N", "p0": "p₀", "contact_angle": "angle", "area": "area"}
"""The same of every patch."""

LABELS = {"largest": "max {}", "least": "min {}", "magnitude": "max |{}|"}


@dataclass(frozen=True)
class Peak:
    """One peak: the channel, which of its values ("largest", "least", "magnitude"), words; short: heading in the table
    of several wheelsets, which leaves out those without; filtered: of forces as `filtered` has them."""

    channel: str
    extreme: str
    title: str
    short: str = ""
    filtered: bool = False

    @property
    def unit(self) -> str:
        """For readers."""
        return CHANNELS[self.channel].shown.symbol

    @property
    def label(self) -> str:
        """Its words with which of the values it is: "max |Y|, raw"."""
        name, comma, signal = self.title.partition(", ")
        return LABELS[self.extreme].format(name) + comma + signal


PEAKS = {
    "Y_max_kN": Peak("Y", "largest", "Y, raw", "Y max raw"),
    "Y_max_20Hz_kN": Peak("Y", "largest", "Y, 20 Hz", "Y max 20 Hz", True),
    "Y_min_kN": Peak("Y", "least", "Y, raw", "Y min raw"),
    "Y_abs_max_kN": Peak("Y", "magnitude", "Y, raw"),
    "Q_max_kN": Peak("Q", "largest", "Q, raw", "Q max raw"),
    "Q_max_20Hz_kN": Peak("Q", "largest", "Q, 20 Hz", "Q max 20 Hz", True),
    "Q_min_kN": Peak("Q", "least", "Q, raw", "Q min raw"),
    "Q_min_20Hz_kN": Peak("Q", "least", "Q, 20 Hz", "Q min 20 Hz", True),
    "Y_over_Q_max": Peak("Y_over_Q", "largest", "Y/Q, raw", "Y/Q max raw"),
    "Y_over_Q_max_20Hz_2m": Peak("Y_over_Q", "largest", "Y/Q, 20 Hz, 2 m", "Y/Q max 20 Hz, 2 m", True),
    "T_gamma_max_N": Peak("T_gamma", "largest", "wear number Tγ", "Tγ max"),
    "N_max_kN": Peak("N", "largest", "normal force of a patch"),
    "p0_max_MPa": Peak("p0", "largest", "pressure p₀", "p₀ max"),
    "temperature_max_C": Peak("temperature", "largest", "surface temperature", "T max"),
    "contact_angle_max_deg": Peak("contact_angle_max", "largest", "contact angle"),
    "contact_angle_variation_max_deg": Peak("contact_angle_variation", "largest", "contact angle range in a patch"),
}
"""Peaks of a wheel, over all of its patches."""

OF_WHEELSET = {
    "lateral_shift_max_mm": Peak("lateral_shift", "magnitude", "lateral shift"),
    "angle_of_attack_max_mrad": Peak("yaw", "magnitude", "angle of attack"),
    "sum_Y_max_kN": Peak("sum_Y", "magnitude", "track shifting force ΣY, raw", "ΣY raw"),
    "sum_Y_max_20Hz_2m_kN": Peak("sum_Y", "magnitude", "track shifting force ΣY, 20 Hz, 2 m", "ΣY 20 Hz, 2 m", True),
    "guide_force_y_max_kN": Peak("guide_force_y", "magnitude", "lateral force of the guide frame"),
}
"""Peaks of a wheelset: those of the largest magnitude, with their sign."""

OF_POINT = {f"{name}_max_m_s2": Peak(name, "magnitude", CHANNELS[name].long_name) for name in ("point_ay", "point_az")}
"""Peaks of a point of a vehicle."""

OF_SPAN = {
    "deflection_max_mm": Peak("deck_deflection", "magnitude", "deflection, downward"),
    "moment_max_kNm": Peak("deck_moment", "magnitude", "bending moment"),
    "acceleration_max_m_s2": Peak("deck_acceleration", "magnitude", "acceleration"),
}
"""Peaks in the middle of a span of a bridge."""

LATER = {"events", "remarks", *(key for key, kind in (PEAKS | OF_WHEELSET).items() if kind.filtered)}
"""Keys that a summary has once there is something to tell, or enough samples."""

_STEADY = 1e-4  # change of curvature over its largest value, per metre, below which a curve counts as full
_SHORTEST = 5  # samples of a full curve that make a median worth reporting


def summarise(dataset: xr.Dataset) -> dict[str, Any]:
    """Plain numbers for ``summary.json``: status, what the integration took, versions, for each wheelset peaks with
    their place and full curves.

    Every peak is ``{"value": .., "distance_m": .., "time_s": ..}``, or with ``"pose"`` in a static analysis;
    ``None`` where there is no finite value. Peaks of patch channels run over all patches of the wheel.
    """
    attributes = dataset.attrs
    summary = {name: attributes[name] for name in ("title", "analysis", "status")} | {"stop": _stop(dataset)}
    if notes := str(attributes.get("profile_notes", "")):
        summary["profiles"] = notes.splitlines()
    if {"integrator", "step_s"} <= attributes.keys():
        counts = {name: int(attributes.get(name, 0)) for name in COUNTS}
        step = 1e3 * float(attributes["step_s"])
        summary["integration"] = {"integrator": attributes["integrator"], "step_ms": step, **counts}
    summary |= {name: attributes[name] for name in ASSUMPTIONS if name in attributes}
    summary |= resolved(ANALYSES[str(attributes["analysis"])].summary)(dataset)
    summary |= _remarks(dataset, summary.get("energy"))
    names = (name for name in attributes if name.endswith("_version") and name != "format_version")
    return summary | {"versions": {name.removesuffix("_version"): attributes[name] for name in names}}


def _remarks(dataset: xr.Dataset, balance: Mapping[str, float] | None) -> dict[str, Any]:
    """Remarks on contacts of solved samples and on limit cycles, by the sample, and on what became of the energy."""
    remarks_at: list[tuple[str, str]] = []
    if "contact_remark" in dataset:
        (sample,) = dataset["contact_remark"].dims
        places = [f"{sample} {position}" for position in dataset[sample].values]
        remarks_at += zip(places, dataset["contact_remark"].values.tolist(), strict=True)
    if "cycle_remark" in dataset:
        held = zip((3.6 * dataset["cycle_speed"].values).tolist(), dataset["cycle_branch"].values, strict=True)
        places = [f"{quantity(speed, 'km/h', '.5g')} {branch}" for speed, branch in held]
        remarks_at += zip(places, dataset["cycle_remark"].values.tolist(), strict=True)
    if balance and not dataset.sizes.get("external_load"):  # nobody counts what loads do
        rest, signs = balance["left_over_kJ"], {"work": 1.0, "gained": -1.0}
        put_in = sum(max(signs.get(key.split("_")[0], 0.0) * value, 0.0) for key, value in balance.items())
        if put_in > LEAST_ENERGY and abs(rest) > LEFT_OVER * put_in:
            message = f"{100.0 * rest / put_in:.3g} % of what was put in is not accounted for"
            remarks_at.append(("energy", f"{message}: steps do not resolve the motion, or rails and contacts take it"))
    remarks = {place: message for place, message in remarks_at if message}
    return {"remarks": remarks} if remarks else {}


def summarise_contacts(dataset: xr.Dataset) -> dict[str, Any]:
    """The summary of a run or of poses: how much was computed, peaks of every wheelset and point, events."""
    dataset = dataset.drop_dims("snapshot", errors="ignore")
    summary: dict[str, Any] = {"extent": extent(dataset)}
    summary["wheelsets"] = {name: _of_wheelset(of_wheelset(dataset, name)) for name in wheelsets(dataset)}
    for dim, kinds in (("point", OF_POINT), ("span", OF_SPAN)):
        if dim in dataset.dims:
            each = {str(name): dataset.sel({dim: name}) for name in dataset[dim].values}
            used = {key: kind for key, kind in kinds.items() if kind.channel in dataset}
            summary[f"{dim}s"] = {n: {key: peak(data, kind) for key, kind in used.items()} for n, data in each.items()}
    if "kinetic_energy" in dataset:
        summary["energy"] = energy(dataset)
    if has_wear(dataset):
        summary["wear"] = summarise_wear(dataset)
    if happened := events(dataset):
        summary["events"] = [{"time_s": t, "distance_m": s, "event": label} for t, s, label in happened]
    return summary


CUT_STEPS = "time steps that Newton's method did not solve"
"""Begin of the words of an event of the solver, which is none of the vehicle's."""


def events(dataset: xr.Dataset) -> list[tuple[float, float, str]]:
    """Time [s], distance [m] and words of what happened to the vehicle on its way; nothing of the solver's own."""
    if "event" not in dataset.dims:
        return []
    rows = zip(*(dataset[f"event_{name}"].values.tolist() for name in ("time", "distance", "label")), strict=True)
    return [(t, s, str(label)) for t, s, label in rows if not str(label).startswith(CUT_STEPS)]


ENERGY = {
    "work_of_pull_kJ": "traction work",
    "work_of_drive_kJ": "work of motors and brakes",
    "lost_in_creep_kJ": "lost in creep",
    "lost_in_dampers_kJ": "lost in dampers and friction of the suspension",
    "gained_in_motion_kJ": "change of kinetic energy",
    "gained_in_height_kJ": "change of potential energy",
    "left_over_kJ": "stored elastically, rest",
}
"""Terms of the energy balance."""


def energy(dataset: xr.Dataset) -> dict[str, float]:
    """What became of the work of drive and pull over a run, in kJ. left_over_kJ: work less everything above; what
    springs, rails and contacts hold or lose and what loads do."""
    time = dataset["time"].values

    def over_time(power: str) -> float:
        areas, before = np.zeros(time.size), np.nan  # their sum over all is that of numpy's trapezoid to the bit
        for begin, part in parts_of(dataset.variables[power]):
            end = begin + len(part)
            areas[begin:end] = np.diff(time[begin:end], prepend=time[max(begin - 1, 0)])
            areas[begin:end] *= part + np.concatenate([[before], part[:-1]])
            areas[begin:end] /= 2.0
            before = part[-1]
        return 1e-3 * float(areas[1:].sum())

    changes = {
        "work_of_pull_kJ": over_time("pull_power"),
        "work_of_drive_kJ": 1e-3 * float(dataset["drive_work"][-1].sum()) if "drive_work" in dataset else 0.0,
        "lost_in_creep_kJ": over_time("creep_power"),
        "lost_in_dampers_kJ": over_time("damper_power"),
    }
    for key, name in (("gained_in_motion_kJ", "kinetic_energy"), ("gained_in_height_kJ", "potential_energy")):
        changes[key] = 1e-3 * float(dataset[name][-1] - dataset[name][0])
    work = changes["work_of_pull_kJ"] + changes["work_of_drive_kJ"]
    return changes | {"left_over_kJ": work - sum(value for key, value in changes.items() if not key.startswith("work"))}


LEFT_OVER, LEAST_ENERGY = 0.05, 1.0
"""Part of the energy that was put in which may be left over without a remark; less than that [kJ], what springs hold
counts as much: 10 kN at 100 mm."""


def _of_wheelset(data: xr.Dataset) -> dict[str, Any]:
    always = ("lateral_shift", "yaw")
    wheels = _peaks(data, {key: kind for key, kind in OF_WHEELSET.items() if kind.channel in (*data, *always)})
    peaks: dict[str, Any] = {**wheels.pop(""), "wheels": wheels}
    if "time" in data.dims:
        peaks["full_curves"] = full_curves(data)
    return peaks


def wheel_peaks(data: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Peaks of the wheels of one wheelset, by wheel and name."""
    return {wheel: peaks for wheel, peaks in _peaks(data, {}).items() if wheel}


def _peaks(data: xr.Dataset, of_wheelset: Mapping[str, Peak]) -> dict[str, dict[str, Any]]:
    """Peaks of the wheels of one wheelset by wheel, and of itself by ""; filtered ones where forces can be filtered."""
    of_wheel = {key: kind for key, kind in PEAKS.items() if kind.channel != "temperature" or "temperature" in data}
    smooth, sides = filtered(data), {str(wheel): side for side, wheel in enumerate(data["wheel"].values)}
    kinds = {
        (name, key): kind
        for name in ("", *sides)
        for key, kind in (of_wheel if name else of_wheelset).items()
        if smooth is not None or not kind.filtered
    }
    raw, slow = (
        {place: (kind, sides.get(place[0])) for place, kind in kinds.items() if kind.filtered is wanted}
        for wanted in (False, True)
    )
    extremes = _extremes(_parts(data, raw.values()), raw) | _extremes(smooth or (), slow)
    peaks: dict[str, dict[str, Any]] = {name: {} for name in ("", *sides)}
    places = _places(data)
    for (name, key), kind in kinds.items():
        peaks[name][key] = _entry(places, kind, extremes.get((name, key)))
    return peaks


Part = tuple[str, int, NDArray[Any]]
"""Name of a channel, the sample that a part of it begins with, that part."""
Sided = tuple[Peak, int | None]
"""A peak, and of which wheel."""
Extreme = tuple[float, Any, tuple[int, ...]]
"""Rank and value of a peak, its first place: sample, patch if any."""
RANKS: dict[str, Callable[[Any], Any]] = {"magnitude": np.abs, "least": np.negative, "largest": np.positive}


def _parts(dataset: xr.Dataset, kinds: Iterable[Sided]) -> Iterator[Part]:
    for name in dict.fromkeys(kind.channel for kind, _ in kinds):
        if name in dataset.variables:
            yield from ((name, *part) for part in parts_of(dataset.variables[name]))


def _extremes(parts: Iterable[Part], kinds: Mapping[Any, Sided]) -> dict[Any, Extreme]:
    """Peaks with a finite value, by their keys."""
    extremes: dict[Any, Extreme] = {}
    for name, begin, part in parts:
        for key, (kind, side) in kinds.items():
            if kind.channel != name or not part.size:
                continue
            values = part if side is None else part[:, side]
            ranks = np.where(np.isfinite(values), RANKS[kind.extreme](values), -np.inf)
            place = np.unravel_index(np.argmax(ranks), ranks.shape)
            if ranks[place] > (extremes[key][0] if key in extremes else -np.inf):
                extremes[key] = ranks[place], values[place], (begin + int(place[0]), *map(int, place[1:]))
    return extremes


LOW_PASS, WINDOW = 20.0, 2.0
"""Filters of EN 14363: low-pass of forces [Hz], length of the sliding mean of ΣY and Y/Q [m]."""


def filtered(data: xr.Dataset) -> Iterator[Part] | None:
    """Y and Q of a wheelset below LOW_PASS, ΣY and Y/Q of these as means over WINDOW about each sample, in parts: not a
    number less than half a window from the ends, and of Y/Q where a wheel has no load. None of poses, and where samples
    are too few, too slow or uneven."""
    if "time" not in data.dims or not {"Y", "Q", "wheel", "distance"} <= {*data.variables} or data.sizes["wheel"] < 2:
        return None
    from wrsim.results import filters  # brings numba, for runs alone

    raster = filters.on_raster(data)
    forces = [raster.variables[name].transpose("time", "wheel") for name in ("Y", "Q")]
    place = raster["distance"].values
    if not (np.diff(place) > 0.0).all():
        return None

    def slid(part: NDArray[Any]) -> NDArray[Any]:
        y, q = part[:, :2], part[:, 2:]
        free = q <= 0.0
        return np.column_stack([y[:, 0] - y[:, 1], np.where(free, 0.0, y / np.where(free, 1.0, q)), free])

    try:
        smooth, copies = tee(
            filters.low_passed(
                lambda first, last: np.concatenate([force[first:last].values for force in forces], axis=1),
                place.size, filters.sampling_rate(raster["time"].values), LOW_PASS,
            )
        )  # fmt: skip
    except InputError:
        return None
    means = filters.means_about(place, map(slid, copies), WINDOW)

    def parts() -> Iterator[Part]:
        begin = 0
        for part, (first, mean) in zip(smooth, means, strict=True):
            yield from (("Y", begin, part[:, :2]), ("Q", begin, part[:, 2:]), ("sum_Y", first, mean[:, 0]))
            yield "Y_over_Q", first, np.where(mean[:, 3:] > 1e-12, np.nan, mean[:, 1:3])
            begin += len(part)

    return parts()


def peak(dataset: xr.Dataset, kind: Peak) -> dict[str, Any] | None:
    """A peak in units for readers, and where: its sample. ``None`` without a finite value."""
    sided = {"": (kind, None)}
    return _entry(_places(dataset), kind, _extremes(_parts(dataset, sided.values()), sided).get(""))


def _entry(places: Mapping[str, NDArray[Any]], kind: Peak, extreme: Extreme | None) -> dict[str, Any] | None:
    if extreme is None:
        return None
    _, value, (sample, *patch) = extreme
    entry = {key: values[sample].item() for key, values in places.items()}
    entry = {"value": finite(value, CHANNELS[kind.channel].shown.factor)} | entry
    return entry | ({"patch": patch[0]} if patch else {})


def full_curves(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Quasi-static values: medians over the second half of every stretch of constant, non-zero curvature. ``patches``
    of a wheel are those that are in contact for most of that half, the largest normal force first."""
    if "curvature" not in dataset or dataset.sizes["time"] < _SHORTEST:
        return []
    curves, distance = [], dataset["distance"].values
    for first, last in _constant_stretches(distance, dataset.variables["curvature"]):
        part = dataset.isel(time=slice((first + last) // 2, last + 1))
        curve: dict[str, Any] = {"from_m": float(distance[first]), "to_m": float(distance[last])}
        curve["radius_m"] = 1.0 / float(np.median(part["curvature"]))
        if "cant" in part:
            curve["cant_mm"] = float(np.median(part["cant"])) * 1e3
        of_wheels = [name for name in CURVE_CHANNELS if name in part and "wheel" in part[name].dims]
        curve |= _medians(part, [name for name in CURVE_CHANNELS if name not in of_wheels])
        for wheel in dataset["wheel"].values:
            of_side = part.sel(wheel=wheel)
            often = np.isfinite(of_side["N"].values).mean(axis=0) > 0.5 if "N" in of_side else np.zeros(0)
            patches = [_medians(of_side.isel(patch=int(k)), PATCH_CHANNELS) for k in np.flatnonzero(often)]
            curve[str(wheel)] = _medians(of_side, of_wheels) | {"patches": patches}
        curves.append(curve)
    return curves


def _constant_stretches(distance: NDArray[Any], curvature: xr.Variable) -> list[tuple[int, int]]:
    """First and last sample of every stretch of constant, non-zero curvature."""
    scale = max(float(np.nanmax(np.abs(part), initial=0.0)) for _, part in parts_of(curvature))
    if not scale > 0.0:
        return []
    steady, before = np.zeros(distance.size + 1, dtype=bool), np.nan  # no stretch goes over either end
    for begin, part in parts_of(curvature):
        end = begin + len(part)
        step = np.diff(distance[begin:end], prepend=distance[max(begin - 1, 0)])
        change = np.abs(np.diff(part, prepend=before)) <= _STEADY * scale * np.maximum(np.abs(step), 1e-3)
        steady[begin:end] = change & (np.abs(part) > 1e-3 * scale)
        before = part[-1]
    edges = np.flatnonzero(np.diff(steady))
    pairs = zip(edges[::2], edges[1::2], strict=True)
    return [(int(first), int(last)) for first, last in pairs if last - first + 1 >= _SHORTEST]


def _medians(part: xr.Dataset, names: Iterable[str]) -> dict[str, Any]:
    values = {name: part[name].values[np.isfinite(part[name].values)] for name in names if name in part}
    return {
        CHANNELS[name].column: finite(np.median(row), CHANNELS[name].shown.factor) if row.size else None
        for name, row in values.items()
    }


def _places(dataset: xr.Dataset) -> dict[str, NDArray[Any]]:
    """Where every sample is: its pose, or distance and time."""
    names = {"pose": "pose"} if "pose" in dataset.dims else {"distance_m": "distance", "time_s": "time"}
    return {key: dataset.variables[name].values for key, name in names.items() if name in dataset.coords}


def _stop(dataset: xr.Dataset) -> dict[str, Any] | None:
    attributes = dataset.attrs
    if attributes["status"] != "stopped":
        return None
    stop: dict[str, Any] = {"reason": attributes.get("stop_reason", "")}
    if "stop_cause" in attributes:
        stop["cause"] = attributes["stop_cause"]
    places = {key: attributes[f"stop_{key}"] for key in ("time_s", "distance_m") if f"stop_{key}" in attributes}
    return stop | {key: finite(value) for key, value in places.items()}


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


def has_wear(dataset: xr.Dataset) -> bool:
    """True when wear was computed."""
    return "wear_wheel_depth" in dataset and "wear_law" in dataset.dims


def summarise_wear(dataset: xr.Dataset) -> dict[str, Any]:
    """By law what wheels lose and how deep, what rails lose by one passage; fatigue of the rails."""
    wheels = [str(wheel) for wheel in dataset["wheel"].values]
    laws: dict[str, Any] = {}
    for law in map(str, dataset["wear_law"].values):
        of_law = dataset.sel(wear_law=law)
        laws[law] = {
            "wheelsets": {
                name: {wheel: _worn_wheel(of_law.sel(wheelset=name, wheel=wheel)) for wheel in wheels}
                for name in wheelsets(dataset)
            },
            "rails": {wheel: _deepest(of_law.sel(wheel=wheel), "wear_rail_depth", "wear_rail_u") for wheel in wheels},
        }
    fatigue = {}
    for wheel in wheels:
        losses = dataset.sel(wheel=wheel)
        most = finite(np.fmax.reduce(losses["fatigue_index"].values, axis=None))
        fatigue[wheel] = _deepest(losses, "rail_damage", "wear_rail_u") | {"fatigue_index_max": most}
    return {"laws": laws, "fatigue": fatigue}


def worst_worn(dataset: xr.Dataset) -> str:
    """The wheelset of which a wheel loses the most by the first law."""
    mass = np.nan_to_num(dataset["wear_wheel_mass"].isel(wear_law=0).sum("wear_zone").max("wheel").values)
    return wheelsets(dataset)[int(np.argmax(mass))]


def _worn_wheel(losses: xr.Dataset) -> dict[str, Any]:
    unit = CHANNELS["wear_wheel_mass"].shown
    zones = zip(losses["wear_zone"].values, losses["wear_wheel_mass"].values, strict=True)
    mass = {f"{zone}_{unit.suffix}": finite(value, unit.factor) for zone, value in zones}
    return mass | _deepest(losses, "wear_wheel_depth", "wear_wheel_u")


def _deepest(losses: xr.Dataset, name: str, place: str) -> dict[str, Any]:
    shown, values = CHANNELS[name].shown, losses[name].values
    index = int(np.argmax(np.where(np.isfinite(values), values, -np.inf)))
    most, where = finite(values[index], shown.factor), finite(losses[place].values[index], 1e3)
    return {f"{name}_max_{shown.suffix}".removesuffix("_"): most, f"{place}_mm": None if most is None else where}
