"""Results that look like real ones, made without a simulation, to develop and test tables and pictures.

The patches come from a small Kik-Piotrowski in numpy on S1002 and 60E1 (1:40), frictionless and without yaw in the
normal problem; the motion through the curve is invented. Do not read physics from these numbers.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import xarray as xr
from scipy.special import ellipe, ellipk

from wrsim.results import assemble

PATCHES, STRIPS = 3, 31
RADIUS = 0.46
HALF_SPACING = 0.75
PLANE_MODULUS = 206e9 / (1 - 0.3**2)
SCENARIO = 'title = "synthetic"\nanalysis = "curving"  # not a scenario that anyone ran\n'

# S1002 (EN 13715), z down in mm: first y, last y, polynomial or (centre z, radius, centre y, sign)
_S1002 = (
    (60.0, 32.15796, (1.364323640, -0.066666667)),
    (32.15796, -26.0, (0.0, -3.358537058e-2, 1.565681624e-3, -2.810427944e-5, 5.844240864e-8, -1.562379023e-8,
                       5.309217349e-15, -5.957839843e-12, 2.646656573e-13)),
    (-26.0, -35.0, (-4.320221063e3, -1.038384026e3, -1.065501873e2, -6.051367875, -2.054332446e-1, -4.169739389e-3,
                    -4.687195829e-5, -2.252755540e-7)),
    (-35.0, -38.426669071, (16.446, 13.0, -26.210665, -1)),
    (-38.426669071, -39.764473993, (-93.576667419, -2.747477419)),
    (-39.764473993, -49.662510381, (8.834924130, 20.0, -58.558326413, 1)),
    (-49.662510381, -62.764705882, (16.0, 12.0, -55.0, 1)),
    (-62.764705882, -70.0, (9.519259302, 20.5, -49.5, 1)),
)  # fmt: skip


def _by_arclength(u: np.ndarray, w: np.ndarray, step: float = 5e-5) -> np.ndarray:
    """(n, 2) points of the curve at uniform arclength."""
    arc = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(u), np.diff(w)))))
    at = np.arange(0.0, arc[-1], step)
    return np.column_stack((np.interp(at, arc, u), np.interp(at, arc, w)))


@lru_cache(maxsize=1)
def wheel_outline() -> np.ndarray:
    """S1002 as (n, 2) points (u, w) in m, by uniform arclength from the flange back outward."""
    points = []
    for first, last, numbers in _S1002:
        y = np.linspace(first, last, 4000)
        if len(numbers) == 4 and numbers[1] > 1.0:
            centre_z, radius, centre_y, sign = numbers
            z = centre_z + sign * np.sqrt(np.maximum(radius**2 - (y - centre_y) ** 2, 0.0))
        else:
            z = np.polynomial.polynomial.polyval(y, numbers)
        points.append(np.column_stack((y, -z)))
    curve = np.concatenate(points)[::-1] * 1e-3
    return _by_arclength(curve[:, 0], curve[:, 1])


@lru_cache(maxsize=1)
def rail_outline() -> np.ndarray:
    """60E1 at 1:40 as (n, 2) points (u, w) in m, by uniform arclength from the gauge side outward."""
    angle = np.radians([0.0, 1.95378, 13.38979, 87.13759])
    centres = ((0.0, 300.0, 300.0), (7.500533, 80.127896, 80.0), (23.016030, 14.949147, 13.0))
    half = [
        np.column_stack((cy + r * np.sin(a), -(cz - r * np.cos(a))))
        for (cy, cz, r), a in zip(centres, (np.linspace(angle[i], angle[i + 1], 4000) for i in range(3)), strict=True)
    ]
    right = np.concatenate(half)
    right = np.vstack((right, [36.0 + (40.0 - 14.3) / 20.0, -40.0]))
    curve = np.concatenate((np.column_stack((-right[::-1, 0], right[::-1, 1])), right)) * 1e-3
    turn = np.arctan(1 / 40)
    u = curve[:, 0] * np.cos(turn) - curve[:, 1] * np.sin(turn)
    w = curve[:, 0] * np.sin(turn) + curve[:, 1] * np.cos(turn)
    return _by_arclength(u, w)


def _tangent(points: np.ndarray) -> np.ndarray:
    t = np.gradient(points, axis=0)
    return t / np.hypot(t[:, :1], t[:, 1:])


@lru_cache(maxsize=1)
def _rail_offset() -> float:
    """Outward distance of the rail's origin from the centre line at gauge 1435 mm."""
    rail = rail_outline()
    gauge_side = rail[: rail.shape[0] // 2]
    gauge_u = np.interp(rail[:, 1].max() - 0.014, gauge_side[:, 1], gauge_side[:, 0])
    return 1.435 / 2 - gauge_u


def contact(shift: float, force: float, yaw: float = 0.0) -> tuple[list[dict], np.ndarray]:
    """Patches of one wheel shifted outward by ``shift`` under the normal force, and the wheel's outline (n, 2)."""
    wheel, rail = wheel_outline(), rail_outline()
    placed = wheel + np.array([HALF_SPACING + shift - _rail_offset(), 0.0])
    top = np.searchsorted(rail[:, 0], [-0.0352, 0.030])
    crown = rail[top[0] : top[1]]
    inside = (placed[:, 0] > crown[0, 0]) & (placed[:, 0] < crown[-1, 0])
    gap = np.full(len(placed), np.inf)
    gap[inside] = placed[inside, 1] - np.interp(placed[inside, 0], crown[:, 0], crown[:, 1])
    placed = placed - [0.0, gap.min()]
    gap = gap - gap.min()
    low = np.flatnonzero((gap[1:-1] <= gap[:-2]) & (gap[1:-1] <= gap[2:]) & (gap[1:-1] < 2.5e-4)) + 1
    mains = [int(np.argmin(gap))]
    mains += [int(i) for i in low if np.ptp(gap[min(i, mains[0]) : max(i, mains[0]) + 1]) > 1e-4][:1]
    shares = np.array([1.0] + [1.0 - gap[i] / 2.5e-4 for i in mains[1:]])
    shares = shares / shares.sum()
    patches = [_patch(placed, rail, i, force * share, yaw) for i, share in zip(mains, shares, strict=True)]
    return sorted(patches, key=lambda p: -p["N"]), placed - [0.0, patches[0]["approach"]]


def _patch(wheel: np.ndarray, rail: np.ndarray, main: int, force: float, yaw: float) -> dict:
    """Kik-Piotrowski on the curved axis around wheel node ``main``, loaded with ``force``."""
    base = int(np.argmin(np.hypot(*(rail - wheel[main]).T)))
    reach = 280
    i = np.arange(-min(reach, base, main), min(reach, len(rail) - base - 1, len(wheel) - main - 1) + 1)
    wt, rt = _tangent(wheel)[main + i], _tangent(rail)[base + i]
    normal = np.column_stack((-(wt + rt)[:, 1], (wt + rt)[:, 0]))
    normal /= np.hypot(normal[:, :1], normal[:, 1:])
    apart = wheel[main + i] - wheel[main] - rail[base + i] + rail[base]
    gap = (apart * normal).sum(1)
    mid, s = 0.5 * (wheel[main + i] + rail[base + i]), i * 5e-5
    radius = RADIUS * np.hypot(1.0, wt[i == 0, 1] / wt[i == 0, 0])[0]
    low, high = 4e-6, 4e-4
    for _ in range(18):
        delta = np.sqrt(low * high)
        found = _pressure(s, gap, delta, radius)
        low, high = (delta, high) if found["N"] < force else (low, delta)
    theta = np.arctan2((wt + rt)[:, 1], (wt + rt)[:, 0])
    keep = found["strip_s"]
    for name, values in (("strip_y", mid[:, 0]), ("strip_z", mid[:, 1]), ("strip_angle", theta)):
        found[name] = np.interp(keep, s, values)
    found["strip_x"] = RADIUS * yaw * np.tan(found["strip_angle"])
    found["contact_angle"] = float(np.interp(0.0, s, theta))
    found["contact_angle_mean"] = float(np.average(found["strip_angle"], weights=found["strip_N"]))
    found["contact_angle_min"] = found["strip_angle"].min()
    found["contact_angle_max"] = found["strip_angle"].max()
    found["u_wheel"], found["u_rail"] = wheel_outline()[main, 0], rail[base, 0]
    return found


def _pressure(s: np.ndarray, gap: np.ndarray, delta: float, radius: float) -> dict:
    depth = 0.55 * delta - gap
    middle = int(np.argmin(np.abs(s)))
    out = depth <= 0.0
    first = middle - int(np.argmax(np.append(out[middle::-1], True))) + 1
    inside = np.arange(first, middle + int(np.argmax(np.append(out[middle:], True))))
    edges = []
    for a, b in ((inside[0], max(inside[0] - 1, 0)), (inside[-1], min(inside[-1] + 1, len(s) - 1))):
        edges.append(s[a] + (s[b] - s[a]) * depth[a] / max(depth[a] - depth[b], 1e-12))
    ds = (edges[1] - edges[0]) / STRIPS
    at = edges[0] + (np.arange(STRIPS) + 0.5) * ds
    a = np.sqrt(2.0 * radius * np.maximum(np.interp(at, s, depth), 1e-12))
    a0 = np.sqrt(2.0 * radius * 0.55 * delta)
    m = a**2 / (a**2 + at**2 + (0.3 * ds) ** 2)
    integral = (2.0 * np.sqrt(a**2 + at**2) * (ellipk(m) - ellipe(m))).sum() * ds
    p0 = 0.5 * np.pi * PLANE_MODULUS * delta * a0 / integral
    pressure = p0 * a / a0
    forces = 0.5 * np.pi * a * pressure * ds
    return {
        "N": forces.sum(), "p0": p0, "approach": delta, "area": (2 * a * ds).sum(), "n_strips": STRIPS,
        "length": 2 * a.max(), "width": edges[1] - edges[0], "strip_s": at, "strip_ds": np.full(STRIPS, ds),
        "strip_a": a, "strip_p": pressure, "strip_N": forces,
    }  # fmt: skip


def _empty(samples: int, wheels: int) -> dict[str, np.ndarray]:
    names = (
        "N", "Fx", "Fy", "spin_moment", "contact_angle", "contact_angle_min", "contact_angle_max", "contact_angle_mean",
        "p0", "area", "approach", "length", "width", "xi", "eta", "phi", "u_wheel", "u_rail", "n_strips",
    )  # fmt: skip
    arrays = {name: np.full((samples, wheels, PATCHES), np.nan) for name in names}
    arrays |= {name: np.full((samples, wheels), np.nan) for name in ("Y", "Q", "X", "T_gamma")}
    arrays["n_patches"] = np.zeros((samples, wheels))
    return arrays


_STRIP_NAMES = ("s", "ds", "x", "a", "p", "angle", "y", "z", "N", "Fx", "Fy", "xi", "eta", "phi")


def _store(arrays: dict, i: int, j: int, patches: list[dict], yaw: float, shift: float, friction: float) -> None:
    """Put the patches of one wheel in their places and add creep forces of a plausible size."""
    arrays["n_patches"][i, j] = len(patches)
    lateral = vertical = wear = along = 0.0
    for k, patch in enumerate(patches):
        angle, normal = patch["contact_angle"], patch["N"]
        rolling = RADIUS * (1.0 - np.tan(angle) * 0.05) / RADIUS
        creep = {
            "xi": 2e-3 * shift / 5e-3 * rolling,
            "eta": -yaw / np.cos(angle),
            "phi": -np.sin(angle) / RADIUS,
        }
        size = np.hypot(creep["xi"], creep["eta"]) + 1e-12
        force = friction * normal * np.tanh(300.0 * size)
        patch |= creep | {"Fx": -force * creep["xi"] / size, "Fy": -force * creep["eta"] / size}
        patch["spin_moment"] = -0.1 * friction * normal * patch["length"] * np.sign(creep["phi"])
        share = patch["strip_N"] / normal
        for name in ("Fx", "Fy"):
            patch[f"strip_{name}"] = patch[name] * share
        for name in ("xi", "eta", "phi"):
            patch[f"strip_{name}"] = np.full(STRIPS, patch[name])
        for name in arrays:
            if name in patch and arrays[name].ndim == 3:
                arrays[name][i, j, k] = patch[name]
        lateral += normal * np.sin(angle) - patch["Fy"] * np.cos(angle)
        vertical += normal * np.cos(angle) + patch["Fy"] * np.sin(angle)
        along -= patch["Fx"]
        wear += force * size
    arrays["Y"][i, j], arrays["Q"][i, j], arrays["X"][i, j] = lateral, vertical, along
    arrays["T_gamma"][i, j] = wear


def _moments(keep: list[list[tuple[list[dict], np.ndarray]]]) -> dict[str, np.ndarray]:
    """Strip channels and outlines of (moment, wheel) pairs of patches and outline."""
    moments, wheels = len(keep), len(keep[0])
    arrays = {f"strip_{n}": np.full((moments, wheels, PATCHES, STRIPS), np.nan) for n in _STRIP_NAMES}
    points = wheel_outline()[::10].shape[0]
    arrays |= {f"wheel_profile_{n}": np.full((moments, wheels, points), np.nan) for n in "yz"}
    rail = rail_outline()[::10]
    arrays |= {f"rail_profile_{n}": np.tile(rail[:, i], (moments, wheels, 1)) for i, n in enumerate("yz")}
    for i, row in enumerate(keep):
        for j, (patches, outline) in enumerate(row):
            arrays["wheel_profile_y"][i, j], arrays["wheel_profile_z"][i, j] = outline[::10].T
            for k, patch in enumerate(patches):
                for name in _STRIP_NAMES:
                    arrays[f"strip_{name}"][i, j, k] = patch[f"strip_{name}"]
    return arrays


@lru_cache(maxsize=4)
def curve_run(samples: int = 200, stopped: bool = False, radius: float = 300.0) -> xr.Dataset:
    """A wheelset through a left curve (a right curve for a negative radius); ``stopped`` derails it half way."""
    distance = np.linspace(0.0, 260.0, samples)
    speed = 15.0
    shape = np.interp(distance, [30.0, 70.0, 190.0, 230.0], [0.0, 1.0, 1.0, 0.0])
    late = np.interp(distance - 4.0, [30.0, 70.0, 190.0, 230.0], [0.0, 1.0, 1.0, 0.0])
    swing = np.sin(2 * np.pi * distance / 16.0) * np.exp(-np.abs(distance - 62.0) / 25.0)
    hand = np.sign(radius)
    shift = -hand * (6.1e-3 * late**0.6 + 0.5e-3 * swing)
    yaw = -hand * (5.5e-3 * late + 0.8e-3 * np.cos(2 * np.pi * distance / 16.0) * np.exp(-distance / 60.0))
    if stopped:
        samples = int(0.55 * samples)
        shift[samples - 8 : samples] -= hand * np.linspace(0.0, 2.5e-3, 8)
    arrays = _empty(samples, 2)
    keep, chosen = [], [int(f * samples) for f in (0.05, 0.22, 0.28, 0.5)] + [samples - 1]
    for i in range(samples):
        row = []
        for j, side in enumerate((1, -1)):
            load = 80e3 * (1.0 - 0.18 * side * hand * shape[i])
            if stopped and side * hand > 0 and i > samples - 8:
                row.append(([], wheel_outline() + np.array([side * shift[i] - 0.01, 0.012])))
                arrays["Q"][i, j] = arrays["Y"][i, j] = 0.0
                continue
            patches, outline = contact(side * shift[i], load / 0.9 if side * hand < 0 else load, yaw[i])
            _store(arrays, i, j, patches, side * yaw[i], side * shift[i], 0.3)
            row.append((patches, outline))
        if i in chosen:
            keep.append(row)
    first = slice(0, samples)
    channels = arrays | _moments(keep) | {
        "distance": distance[first],
        "speed": speed,
        "curvature": shape[first] / radius,
        "cant": hand * shape[first] * 0.06,
        "lateral_shift": shift[first],
        "vertical_shift": -2e-5,
        "yaw": yaw[first],
        "roll": shift[first] * 0.05,
        "spin_rate": speed / RADIUS,
        "snapshot_time": distance[chosen] / speed,
        "snapshot_distance": distance[chosen],
        "snapshot_label": ["straight", "transition", "largest Y/Q", "full curve", "end"],
    }  # fmt: skip
    attributes = {
        "title": "Synthetic: a wheelset through a 300 m curve",
        "analysis": "curving",
        "status": "stopped" if stopped else "completed",
        "scenario_text": SCENARIO,
    }
    if stopped:
        attributes |= {
            "stop_reason": "derailment: the left wheel had no contact over 2 m of track",
            "stop_time_s": float(distance[samples - 1] / speed),
            "stop_distance_m": float(distance[samples - 1]),
        }
    return assemble({"time": distance[first] / speed}, channels, attributes)


@lru_cache(maxsize=4)
def static_poses(
    shifts_mm: tuple[float, ...] = tuple(np.arange(-10.0, 10.5, 1.0).tolist()),
    yaws_mrad: tuple[float, ...] = (0.0, 12.0),
    wheels: tuple[str, ...] = ("left", "right"),
    load: float = 160e3,
) -> xr.Dataset:
    """A grid of static poses; the last shift of the last yaw has no solution when there are many."""
    grid = [(y, psi) for psi in yaws_mrad for y in shifts_mm]
    arrays = _empty(len(grid), len(wheels))
    message = [""] * len(grid)
    keep = []
    for i, (shift, yaw) in enumerate(grid):
        row = []
        for j, wheel in enumerate(wheels):
            side = 1 if wheel == "left" else -1
            patches, outline = contact(side * shift * (1e-3 + 4e-6 * yaw), load / len(wheels), yaw * 1e-3)
            if len(grid) > 20 and i == len(grid) - 1:
                message[i] = "the flange is over the rail"
                patches = []
            else:
                _store(arrays, i, j, patches, side * yaw * 1e-3, side * shift * 1e-3, 0.0)
            row.append((patches, outline))
        keep.append(row)
    channels = arrays | _moments(keep) | {
        "lateral_shift": np.array([y for y, _ in grid]) * 1e-3,
        "yaw": np.array([psi for _, psi in grid]) * 1e-3,
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
    names = [f"y{y:+g}_yaw{psi:g}" for y, psi in grid]
    return assemble({"pose": names, "wheel": wheels}, channels, attributes)
