"""The viewer of one result: wheels on their rails and the vehicle on its track, one page that needs nothing else."""

from __future__ import annotations

import base64
import math
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from wrsim import __version__
from wrsim.contact.contact_angle import contact_angles, mean_contact_angle
from wrsim.contact.profiles.profile import Profile
from wrsim.errors import InputError, SimulationError, in_one_line
from wrsim.plots.cross_section import has_outlines, pressed_curve
from wrsim.plots.moments import patches_at, select, touching_runs
from wrsim.plots.theme import pressure_map
from wrsim.plots.wear import LAW_LABELS
from wrsim.report.page import page_template
from wrsim.results import CHANNELS, Result
from wrsim.results.channels import PATCHES
from wrsim.results.moments import Array, has_patches, is_history, moment_dim, sample_of
from wrsim.results.summary import events, has_wear
from wrsim.results.table import quantity
from wrsim.results.wheelsets import numbered, of_wheelset, wheelsets
from wrsim.track.cant import cant_angle

if TYPE_CHECKING:
    from wrsim.scenario.build import Setup

MOST_SAMPLES = 20000  # samples that a page holds; of longer runs every second, third, ... one
SECTIONS = 240  # places, evenly spread, at which wheels are drawn on their rails
NODES = 17  # points of a patch along its curved axis
PATH_STEP = 1.0  # between two points of the track [m]
BEYOND = 60.0
"""Length of track drawn ahead of the first and behind the last place of the vehicle [m]."""

LEAST_DEPTH = 0.01  # of the largest depth worn off, from which on it is drawn

OF_WHEELSETS = ("lateral_shift", "vertical_shift", "yaw", "roll", "curvature", "cant", "Y", "Q", "Y_over_Q", "T_gamma")
PATCH_CHANNELS = ("N", "contact_angle", "p0")
OF_BODIES = ("body_lateral", "body_vertical", "body_yaw", "body_pitch", "body_roll")


def packed(values: NDArray[Any], kind: str) -> dict[str, Any]:
    """An array as text: its shape, its type ("u1", "f4", "f8", "i2" little-endian), its bytes compressed."""
    data = np.ascontiguousarray(values, dtype=f"<{kind}")
    content = base64.b64encode(zlib.compress(data.tobytes(), 6)).decode()
    return {"shape": list(data.shape), "kind": kind, "data": content}


def packed_steps(values: Array, unit: float) -> dict[str, Any]:
    """The same of numbers in whole units; along the first dimension differences are stored, which compress well."""
    whole = np.clip(np.rint(np.nan_to_num(values) / unit), -32767, 32767).astype(np.int32)
    steps = np.diff(whole, axis=0, prepend=np.zeros_like(whole[:1]))
    return packed(((steps + 32768) % 65536 - 32768).astype(np.int16), "i2") | {"unit": unit}


def view_page(result: Result, folder: Path, models: Sequence[Path] = ()) -> str:
    """The viewer as HTML. folder, models: where the model files of the scenario are looked up; where they are missing,
    the page shows what the result alone holds, with the reason. Raises InputError for a result with nothing to see."""
    data = view_data(result, *setup_of(result, folder, models))
    page = {"title": result.title, "version": __version__, "numbers": "run" in data, "data": data}
    return page_template("view.html").render(page)


def setup_of(result: Result, folder: Path, models: Sequence[Path] = ()) -> tuple[Setup[Any] | None, str]:
    """The set-up of a result's scenario, or None and the reason."""
    from wrsim.scenario.build import build
    from wrsim.scenario.kept import scenario_of

    try:
        return build(scenario_of(result.dataset.attrs, folder, models)), ""
    except InputError as problem:
        why = in_one_line(problem)
        return None, f"The scenario of the result cannot be set up here, so there is no vehicle to show: {why}"


def view_data(result: Result, setup: Setup[Any] | None, why: str = "") -> dict[str, Any]:
    """Everything that the viewer shows of a result. setup: of its scenario, for shapes and for contacts between the
    snapshots; why: what prevented it. Raises InputError for a result with nothing to see."""
    dataset = result.dataset
    data: dict[str, Any] = {"title": result.title, "analysis": result.analysis, "notes": [why] if why else []}
    if result.stop_reason:
        data["notes"].append(f"Stopped: {result.stop_reason}")
    data["colours"] = [to_hex(c) for c in pressure_map()(np.linspace(0.0, 1.0, 32))]
    names = [m.name for m in setup.vehicle.wheelsets] if setup is not None else wheelsets(dataset)
    data["called"] = numbered(names)
    if setup is not None:
        data["vehicle"] = vehicle_shapes(setup)
    if result.analysis == "stability" and setup is not None:
        data["modes"] = _modes(result, setup)
        return data
    dense = dataset
    if is_history(dataset):
        count = dataset.sizes["time"]
        keep = np.unique(np.append(np.arange(0, count, -(-count // MOST_SAMPLES)), count - 1))
        data["run"] = _run(dataset, setup, keep)
        if "bent_at_m" in dataset.attrs:
            data["run"]["bent"] = _bent(dataset, keep, data["run"]["events"])
        dense = _dense(dataset, setup, keep, data["notes"])
    if has_patches(dense) and has_outlines(dense):
        data["sections"] = _sections(dense)
    if "run" not in data and "sections" not in data:
        raise InputError(f'a result of analysis = "{result.analysis}" holds neither motion nor contacts to look at')
    return data


def _dense(dataset: xr.Dataset, setup: Setup[Any] | None, keep: NDArray[np.intp], notes: list[str]) -> xr.Dataset:
    """The run with contacts at many places, where they can be solved again; else with its own snapshots."""
    from wrsim.analysis.resolve import with_moments

    if setup is None:
        return dataset
    wanted = keep[np.unique(np.linspace(0, keep.size - 1, min(SECTIONS, keep.size)).astype(int))].tolist()
    if "snapshot_time" in dataset:
        wanted += [sample_of(dataset, m) for m in range(dataset.sizes["snapshot"])]
    try:
        dense = with_moments(dataset, setup, sorted(set(wanted)))
    except (InputError, SimulationError) as problem:
        notes.append(f"Contacts are shown at the snapshots only: {problem}")
        return dataset
    if remark := dense.attrs["contact_remark"]:
        notes.append(f"Contacts that are drawn: {remark}")
    return dense


def _run(dataset: xr.Dataset, setup: Setup[Any] | None, keep: NDArray[np.intp]) -> dict[str, Any]:
    """The motion: channels at the samples in units for readers (of forces) or SI (of poses), and the track."""
    names = wheelsets(dataset)
    count = len(names)
    moves = "distance" in dataset.coords
    distance = dataset["distance"].values if moves else np.zeros(dataset.sizes["time"])
    place = dataset["wheelset_distance"].values if "wheelset_distance" in dataset else np.tile(distance[:, None], count)
    spin = np.zeros((dataset.sizes["time"], count))
    if "spin_rate" in dataset:
        rate, dt = dataset["spin_rate"].values, np.diff(dataset["time"].values)
        spin[1:] = np.cumsum(0.5 * (rate[1:] + rate[:-1]) * dt[:, None], axis=0)
    columns = {"time": dataset["time"].values, "distance": distance, "place": place}
    run: dict[str, Any] = {"wheelsets": list(names)} | {n: packed(column[keep], "f8") for n, column in columns.items()}
    run["spin"] = packed(spin[keep] % (2.0 * np.pi), "f4")
    track = _track(dataset, place, setup.track.cant_base) if setup is not None else None
    run |= {"channels": {}, "track": track, "events": _events(dataset)}
    channels = {name: (dataset[name], CHANNELS[name], "") for name in OF_WHEELSETS if name in dataset}
    for k in range(dataset.sizes.get("patch", 0)):
        for name in PATCH_CHANNELS if np.isfinite(dataset["N"].values[..., k]).any() else ():
            of_patch = (dataset[name].isel(patch=k), CHANNELS[name], f", {PATCHES[k]} patch")
            channels[f"{name}_{k}" if k else name] = of_patch
    channels |= {name: (dataset[name], CHANNELS[name], "") for name in OF_BODIES if name in dataset}
    for name, (data, channel, suffix) in channels.items():
        column = channel.shown
        about = {"unit": column.unit, "factor": column.factor, "words": channel.long_name + suffix}
        dims = [d for d in data.dims if d != "time"]
        run["channels"][name] = packed(data.values[keep] * column.factor, "f4") | about | {"dims": dims}
    if "body" in dataset.dims:
        run["bodies"] = [str(b) for b in dataset["body"].values]
    if "suspension" in dataset.dims:
        forces = [dataset[f"suspension_f{axis}"].values[keep] for axis in "xyz"]
        size = np.linalg.norm(1e-3 * np.nan_to_num(np.stack(forces)), axis=0)
        least, most = size.min(axis=0), size.max(axis=0)
        share = (size - least) / np.maximum(most - least, 1e-9)  # for colours: from the least to the largest of each
        names_of = [str(n) for n in dataset["suspension"].values]
        run["suspension"] = {"names": names_of, "share": packed(np.rint(250.0 * share), "u1")}
    return run


def _bent(dataset: xr.Dataset, keep: NDArray[np.intp], events: list[dict[str, Any]]) -> dict[str, Any]:
    """Rails and axles as they are bent, and the sample for that, which becomes an event."""
    names, station = wheelsets(dataset), float(dataset.attrs["bent_at_m"])
    wheelset = names.index(str(dataset.attrs["bent_by"]).rpartition(" ")[0])
    sample = int(np.argmin(np.abs(dataset["wheelset_distance"].values[keep, wheelset] - station)))
    label = "the largest vertical force, with bent rails and axles"
    events.append({"s": float(dataset["distance"].values[keep[sample]]), "words": label})
    shapes: dict[str, Any] = {"sample": sample, "wheelsets": list(names)}
    if "bent_rail" in dataset:
        shapes |= {
            "place": packed(dataset["bent_place"].values, "f8"),
            "rail": packed(dataset["bent_rail"].values.T, "f4"),
        }
    if "bent_axle_y" in dataset:
        axles = np.stack([dataset[f"bent_axle_{axis}"].values for axis in "yxz"], axis=1)
        shapes["axles"] = packed(axles, "f4")
    return shapes


def _events(dataset: xr.Dataset) -> list[dict[str, Any]]:
    marks: list[dict[str, Any]] = [{"s": s, "words": label} for _, s, label in events(dataset)]
    if "snapshot_label" in dataset:
        places = zip(dataset["snapshot_distance"].values, dataset["snapshot_label"].values, strict=True)
        marks += [{"s": float(s), "words": f"snapshot: {label}"} for s, label in places]
    if "stop_distance_m" in dataset.attrs:
        marks.append({"s": float(dataset.attrs["stop_distance_m"]), "words": "the stop"})
    return sorted((e for e in marks if np.isfinite(e["s"])), key=lambda e: e["s"])


def _track(dataset: xr.Dataset, place: Array, cant_base: float) -> dict[str, Any] | None:
    """The centre line at even steps, from the curvature, cant and grade that the first and last wheelsets passed.
    cant_base [m]."""
    if "curvature" not in dataset:
        return None
    order = np.argsort(np.concatenate((place[:, -1], place[:, 0])), kind="stable")
    stations = np.concatenate((place[:, -1], place[:, 0]))[order]
    stations, first = np.unique(stations, return_index=True)
    s = np.arange(np.floor(stations[0] - BEYOND), stations[-1] + BEYOND, PATH_STEP)

    def along(name: str) -> Array:
        if name not in dataset:
            return np.zeros(s.size)
        values = dataset[name].values
        samples = np.concatenate((values[:, -1], values[:, 0]))[order][first]
        return np.interp(s, stations, samples)

    line = centre_line(along("curvature"), along("cant"), along("grade"), cant_base)
    return {"start": float(s[0]), "step": PATH_STEP, "line": packed(line, "f8")}


def centre_line(curvature: Array, cant: Array, grade: Array, cant_base: float) -> Array:
    """Rows (n, 5) of the centre line at places PATH_STEP apart: x, y, z [m], heading, roll [rad]; curvature [1/m], cant
    [m] and grade there. Good for a drawing: trapezoidal steps."""
    middle = 0.5 * (curvature[1:] + curvature[:-1])
    heading = np.concatenate(([0.0], np.cumsum(middle * PATH_STEP)))
    bend = 0.5 * (heading[1:] + heading[:-1])
    x, y = (np.concatenate(([0.0], np.cumsum(f(bend) * PATH_STEP))) for f in (np.cos, np.sin))
    z = np.concatenate(([0.0], np.cumsum(0.5 * (grade[1:] + grade[:-1]) * PATH_STEP)))
    return np.stack((x, y, z, heading, -cant_angle(cant, cant_base)), axis=1)


def vehicle_shapes(setup: Setup[Any]) -> dict[str, Any]:
    """Shapes: wheels turned from their profiles, boxes of the inertia of the bodies, elements between their ends."""
    vehicle = setup.vehicle
    wheels = []
    for mounted in vehicle.wheelsets:
        wheelset = mounted.wheelset
        shapes = ((wheel.radius, *outline_points(wheel.profile, 400, 0.3)) for wheel in (wheelset.left, wheelset.right))
        sides = [{"radius": radius, "u": _short(u), "r": _short(radius - w)} for radius, u, w in shapes]
        place = {"x": mounted.x, "height": mounted.height, "spacing": wheelset.profile_spacing}
        wheels.append({"name": mounted.name, **place, "sides": sides})
    elements = [
        {"name": e.name, "kind": e.kind, "first": e.first, "second": e.second, "ends": [list(p) for p in e.points]}
        for e in vehicle.elements
    ]
    rails = [{"u": _short(u), "w": _short(w)} for u, w in (outline_points(rail, 300, 0.5) for rail in setup.rails)]
    bodies = [{"name": b.name, "centre": list(b.centre), "size": list(b.box)} for b in vehicle.bodies]
    return {
        "name": vehicle.name, "wheelsets": wheels, "bodies": bodies, "elements": elements,
        "boxes": {name: vehicle.carrier(name) for name in vehicle.boxes},
        "reference": vehicle.parts[vehicle.reference].centre[0],
        "rails": rails, "rail_origins": [list(o) for o in setup.track.rail_origins],
    }  # fmt: skip


def outline_points(profile: Profile, count: int, off: float) -> tuple[Array, Array]:
    """The points u, w [m] of so many along a profile that cannot be spared; off: see ``needed`` [mm]."""
    u, w = (np.asarray(x) for x in profile.at(np.linspace(0.0, profile.length, count))[:2])
    i = needed(1e3 * u, 1e3 * w, off)
    return u[i], w[i]


def _short(values: Array) -> list[float]:
    return [round(v, 5) for v in values.tolist()]


def _modes(result: Result, setup: Setup[Any]) -> dict[str, Any]:
    """Shapes of the modes at some speeds, solved again: amplitudes of all bodies, complex."""
    from wrsim.analysis.stability.rolling import mode_shapes

    dataset = result.dataset
    speeds = dataset["pose_speed"].values
    critical = float(dataset.attrs.get("critical_speed_m_s", np.nan))
    chosen = np.unique(np.linspace(0, speeds.size - 1, min(4, speeds.size)).astype(int)).tolist()
    drawn = {float(speeds[i]) for i in chosen} | ({critical} if np.isfinite(critical) else set())
    speed_rows = []
    for modes, names in mode_shapes(setup, sorted(drawn)):
        rows = []
        for value, shape, name in zip(modes.values, modes.shapes, names, strict=True):
            numbers = {"frequency": float(value.imag / (2.0 * np.pi)), "damping": float(-value.real / abs(value))}
            parts = {
                key: [[round(v, 6) for v in body] for body in (part / np.abs(shape).max()).tolist()]
                for key, part in (("real", shape.real), ("imag", shape.imag))
            }
            rows.append({"name": name, **numbers, **parts})
        speed_rows.append({"speed": modes.speed * 3.6, "critical": bool(modes.speed == critical), "modes": rows})
    bodies = [*(m.name for m in setup.vehicle.wheelsets), *(b.name for b in setup.vehicle.bodies)]
    return {"speeds": speed_rows, "bodies": bodies}


def _sections(dense: xr.Dataset) -> dict[str, Any]:
    """Wheels on rails at the moments of a dataset: outlines and patches, per wheelset and wheel."""
    dim = moment_dim(dense)
    count = dense.sizes[dim]
    sides = [str(w) for w in dense["wheel"].values]
    names = wheelsets(dense)
    most = float(np.nanmax(dense["strip_p"].values, initial=0.0)) * 1e-6 or 1.0
    sections: dict[str, Any] = {"wheelsets": list(names), "wheels": sides, "most": most, "of": []}
    if dim == "snapshot":
        sections["at"] = [round(s, 4) for s in dense["snapshot_distance"].values.tolist()]
        sections["time"] = [round(t, 6) for t in dense["snapshot_time"].values.tolist()]
    else:
        sections["poses"] = [str(p) for p in dense["pose"].values]
    for name, wheelset in ((name, of_wheelset(dense, name)) for name in names):
        sections["of"] += [{"wheelset": name, "wheel": side, **_wheel(wheelset, side, count, most)} for side in sides]
    return sections


def _wheel(wheelset: xr.Dataset, side: str, count: int, most: float) -> dict[str, Any]:
    """One wheel at all moments. Lengths in mm; patches: moment of each, and its points from edge to edge."""
    dim = moment_dim(wheelset)
    wheel = wheelset.sel(wheel=side)
    worn = has_wear(wheelset)
    rail, _, on_rail = _outline(wheel, "rail", dim, 0.02, worn)
    if (rail == rail[:1]).all():  # the same all along the track
        rail = rail[:1]
    outline, finite, on_wheel = _outline(wheel, "wheel", dim, 0.01, worn)
    moments, shapes, numbers = [], [], []
    for m in range(count):
        for where in patches_at(wheelset, m, side):
            for strips in touching_runs(select(wheelset, where)):
                curve, normal, p = pressed_curve(strips)
                walked = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(curve, axis=0).T))))
                nodes = 0.5 * walked[-1] * (1.0 - np.cos(np.linspace(0.0, np.pi, NODES)))
                points_of = [np.interp(nodes, walked, v) for v in (*curve.T, contact_angles(*normal.T))]
                pressure = np.interp(nodes, walked, p)
                moments.append(m)
                shapes.append(np.stack((points_of[0], points_of[1], 10.0 * points_of[2], 50.0 * pressure / most), 1))
                force = strips.variables["strip_N"]
                mean = mean_contact_angle(strips.variables["strip_angle"], force)
                numbers.append((float(force.sum()) * 1e-3, float(np.degrees(mean)), float(p.max())))
    wear = {"wear": worn_outlines(wheel, on_wheel, on_rail)} if worn else {}
    return wear | {
        "rail": packed_steps(rail, 0.005),
        "outline": packed_steps(outline, 0.005),
        "missing": [int(m) for m in range(count) if m not in set(finite.tolist())],
        "patch_moment": moments,
        "patch": packed_steps(np.array(shapes).reshape(-1, NODES, 4), 0.002),
        "patch_numbers": packed(np.array(numbers).reshape(-1, 3), "f4"),
    }


def _outline(wheel: xr.Dataset, body: str, dim: str, error: float, worn: bool) -> tuple[Array, NDArray[np.intp], Array]:
    """An outline at all moments (moments, points, 2) [mm], others having that of the nearest; moments that have one;
    points needed for an error [mm], and worn ones where wanted, as shares of the profile's length."""
    lines = np.stack([wheel[f"{body}_profile_{n}"].transpose(dim, f"{body}_point").values * 1e3 for n in "yz"], axis=-1)
    mask = np.isfinite(lines[..., 0])
    finite = np.flatnonzero(mask.any(axis=1))
    if not finite.size:
        return np.zeros((len(lines), 1, 2)), finite, np.zeros(1)
    for m in finite:  # a nose that is not there yet: its points lie on the last one before
        lines[m] = lines[m][_nearest(np.flatnonzero(mask[m]), lines.shape[1])]
    new = finite[np.append(True, (np.diff(lines[finite, :, 1], axis=0) != 0.0).any(axis=1))]
    share = np.linspace(0.0, 1.0, lines.shape[1])
    retained = [needed(lines[m, :, 0], lines[m, :, 1], error) for m in (new if body == "rail" else new[:1])]
    if worn:
        retained.append(np.flatnonzero(drawn_depth(wheel, body, share) > LEAST_DEPTH))
    points = np.unique(np.concatenate(retained))
    return lines[_nearest(finite, len(lines))][:, points], finite, share[points]


def _nearest(known: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """For each of so many numbers the nearest of those that are known, which rise."""
    following = np.clip(np.searchsorted(known, np.arange(count)), 1, max(known.size - 1, 1))
    low, high = known[following - 1], known[np.minimum(following, known.size - 1)]
    index = np.arange(count)
    return np.where(index - low <= high - index, low, high)


def drawn_depth(mine: xr.Dataset, body: str, share: Array) -> Array:
    """Depths by the first law over the largest, at shares of a profile's length; nothing where nothing wears."""
    depth = mine.isel(wear_law=0)[f"wear_{body}_depth"].values
    depth = depth[np.isfinite(depth)]  # profiles of other wheels may have more places
    if not depth.any():
        return np.zeros(share.size)
    return np.asarray(np.interp(share, (np.arange(depth.size) + 0.5) / depth.size, depth) / depth.max())


def worn_outlines(mine: xr.Dataset, on_wheel: Array, on_rail: Array) -> dict[str, Any]:
    """For the viewer: depths by the first law at points of the outlines of one wheel and its rail, and their label.
    on_wheel, on_rail: the points, as shares of the profiles' lengths; depths as hundredths of the largest."""
    law, depth_texts = str(mine["wear_law"].values[0]), []
    depths: dict[str, Any] = {}
    for body, points in (("wheel", on_wheel), ("rail", on_rail)):
        depths[body] = np.rint(100.0 * drawn_depth(mine, body, points)).astype(int).tolist()
        channel = CHANNELS[f"wear_{body}_depth"]
        most = float(mine.isel(wear_law=0)[channel.name].max())
        depth_texts.append(f"{body} {quantity(most * channel.shown.factor, channel.shown.symbol, '.3g')}")
    return depths | {"words": f"wear, {LAW_LABELS[law]}: {', '.join(depth_texts)} per passage"}


def needed(x: Array, y: Array, off: float) -> NDArray[np.intp]:
    """Indices of points that a line cannot spare (Douglas and Peucker); off: how far others may lie beside it."""
    keep = np.zeros(x.size, dtype=bool)
    keep[[0, -1]] = True
    open_pieces = [(0, x.size - 1)]
    while open_pieces:
        i, j = open_pieces.pop()
        if j - i < 2:
            continue
        dx, dy = x[j] - x[i], y[j] - y[i]
        u, v = x[i + 1 : j] - x[i], y[i + 1 : j] - y[i]
        length = math.hypot(dx, dy)
        away = np.abs(u * dy - v * dx) / length if length > 0.0 else np.hypot(u, v)
        k = int(np.argmax(away))
        if away[k] > off:
            keep[i + 1 + k] = True
            open_pieces += [(i, i + 1 + k), (i + 1 + k, j)]
    return np.flatnonzero(keep)
