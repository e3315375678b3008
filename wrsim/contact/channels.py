"""From the kernel's columns to named channels.

Raw arrays are stacked over samples and wheels; absent patches become not-a-number. Patches are put in the order of
their normal force, largest first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.model import ContactModel
from wrsim.core import layout as k
from wrsim.core.locus import outline

Array = NDArray[np.float64]

_PATCH_CHANNELS = {
    "N": k.N,
    "Fx": k.FX_SUM,
    "Fy": k.FY_SUM,
    "spin_moment": k.SPIN_MOMENT,
    "contact_angle": k.ANGLE,
    "contact_angle_min": k.ANGLE_MIN,
    "contact_angle_max": k.ANGLE_MAX,
    "contact_angle_mean": k.ANGLE_MEAN,
    "p0": k.P0,
    "area": k.AREA,
    "approach": k.APPROACH,
    "n_strips": k.N_STRIPS,
    "length": k.LENGTH,
    "width": k.WIDTH,
    "xi": k.XI_MAIN,
    "eta": k.ETA_MAIN,
    "phi": k.PHI_MAIN,
    "x_contact": k.X_MAIN,
}
_STRIP_CHANNELS = {
    "strip_s": k.S,
    "strip_ds": k.DS,
    "strip_x": k.X,
    "strip_a": k.A,
    "strip_p": k.P,
    "strip_y": k.O,
    "strip_z": k.B,
    "strip_N": k.FORCE,
    "strip_Fx": k.FX,
    "strip_Fy": k.FY,
    "strip_xi": k.XI,
    "strip_eta": k.ETA,
    "strip_phi": k.PHI,
}
OUTLINE_POINTS = 500


@dataclass(frozen=True)
class WheelOnRail:
    """One wheel of a wheelset: its contact model, its side (+1 left, -1 right) and its wheel's place.

    half_spacing: H/2 [m]; rail_origin: (o, b) of the rail profile's origin in the track cross-section at nominal
    gauge [m].
    """

    model: ContactModel
    side: int
    half_spacing: float
    rail_origin: tuple[float, float]

    @property
    def name(self) -> str:
        """``"left"`` or ``"right"``."""
        return "left" if self.side > 0 else "right"


@dataclass(frozen=True)
class RawContacts:
    """Copies of the kernel's results over samples: patches (S, W, P, columns), totals (S, W, columns)."""

    patches: Array
    totals: Array

    @classmethod
    def empty(cls, samples: int, wheels: int, patches: int) -> RawContacts:
        """Zeros for that many samples."""
        return cls(
            np.zeros((samples, wheels, patches, k.PATCH_COLUMNS)), np.zeros((samples, wheels, k.TOTAL))
        )

    def store(self, sample: int, wheel: int, model: ContactModel) -> None:
        """Copy what the model computed last."""
        self.patches[sample, wheel] = model.arrays.patches
        self.totals[sample, wheel] = model.arrays.total


def _order(raw: RawContacts) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Order of the patches by normal force, and which are present (in that order); both (S, W, P)."""
    present = np.arange(raw.patches.shape[2]) < raw.totals[..., k.COUNT, None]
    force = np.where(present, raw.patches[..., k.N], -1.0)
    order = np.argsort(-force, axis=-1, kind="stable")
    return order, np.take_along_axis(present, order, axis=-1)


def wheel_channels(raw: RawContacts) -> dict[str, Array]:
    """Channels with dimensions (sample, wheel): forces of the wheel on the rail, wear number, patches."""
    t = raw.totals
    return {
        "Y": -t[..., k.FORCE_O],
        "Q": t[..., k.FORCE_B],
        "X": -t[..., k.FORCE_T],
        "T_gamma": t[..., k.WEAR],
        "n_patches": t[..., k.COUNT],
    }


def patch_channels(
    raw: RawContacts, wheels: Sequence[WheelOnRail], widening: Array | float = 0.0
) -> dict[str, Array]:
    """Channels with dimensions (sample, wheel, patch). widening: gauge beyond the nominal one, (S,) or one [m]."""
    order, present = _order(raw)
    sorted_patches = np.take_along_axis(raw.patches, order[..., None], axis=2)

    def masked(values: Array) -> Array:
        return np.where(present, values, np.nan)

    channels = {name: masked(sorted_patches[..., column]) for name, column in _PATCH_CHANNELS.items()}
    for name in ("u_wheel", "u_rail", "y_contact", "z_contact"):
        channels[name] = np.full(present.shape, np.nan)
    half_widening = 0.5 * np.broadcast_to(widening, raw.patches.shape[:1])
    for i, wheel in enumerate(wheels):
        p = sorted_patches[:, i]
        for name, profile, column in (
            ("u_wheel", wheel.model.wheel, k.ARC_WHEEL),
            ("u_rail", wheel.model.rail, k.ARC_RAIL),
        ):
            channels[name][:, i] = profile.at(np.clip(p[..., column], 0.0, profile.length))[0]
        o, b = wheel.rail_origin
        channels["y_contact"][:, i] = wheel.side * (o + half_widening[:, None] + p[..., k.O_MAIN])
        channels["z_contact"][:, i] = b + p[..., k.B_MAIN]
    for name in ("u_wheel", "u_rail", "y_contact", "z_contact"):
        channels[name] = masked(channels[name])
    return channels


@dataclass
class StripRecorder:
    """Collects strips and wheel outlines at chosen moments, the same wheels each time."""

    wheels: Sequence[WheelOnRail]
    moments: list[dict[str, Array]]

    @classmethod
    def start(cls, wheels: Sequence[WheelOnRail]) -> StripRecorder:
        """An empty record."""
        return cls(wheels, [])

    def store(self) -> None:
        """Keep the strips and the outline of the pose that the models computed last."""
        self.moments.append(
            {
                "patches": np.stack([w.model.arrays.patches.copy() for w in self.wheels]),
                "totals": np.stack([w.model.arrays.total.copy() for w in self.wheels]),
                "strips": _ragged([_used_strips(w) for w in self.wheels]),
                "outline": np.stack([wheel_outline(w) for w in self.wheels]),
            }
        )

    def channels(self) -> dict[str, Array]:
        """Strip channels (moment, wheel, patch, strip) and outlines for drawing."""
        result: dict[str, Array] = {}
        rails = [w.model.rail.at(np.linspace(0.0, w.model.rail.length, OUTLINE_POINTS)) for w in self.wheels]
        result["rail_profile_y"] = np.stack([r[0] for r in rails])
        result["rail_profile_z"] = np.stack([r[1] for r in rails])
        if not self.moments:
            return result
        most = max(m["strips"].shape[2] for m in self.moments)
        rows = np.full((len(self.moments), *self.moments[0]["strips"].shape[:2], most, k.STRIP_COLUMNS), np.nan)
        for row, m in zip(rows, self.moments, strict=True):
            row[:, :, : m["strips"].shape[2]] = m["strips"]
        raw = RawContacts(
            np.stack([m["patches"] for m in self.moments]), np.stack([m["totals"] for m in self.moments])
        )
        order, present = _order(raw)
        rows = np.take_along_axis(rows, order[..., None, None], axis=2)
        counts = np.take_along_axis(raw.patches[..., k.N_STRIPS], order, axis=-1)
        used = present[..., None] & (np.arange(most) < counts[..., None])
        for name, column in _STRIP_CHANNELS.items():
            result[name] = np.where(used, rows[..., column], np.nan)
        result["strip_angle"] = np.where(used, np.arctan2(-rows[..., k.NO], rows[..., k.NB]), np.nan)
        result["wheel_profile_y"] = np.stack([m["outline"][:, 0] for m in self.moments])
        result["wheel_profile_z"] = np.stack([m["outline"][:, 1] for m in self.moments])
        return result


def _used_strips(wheel: WheelOnRail) -> Array:
    """(patches, strips in use, columns) of what was computed last."""
    a = wheel.model.arrays
    most = max((int(a.patches[i, k.N_STRIPS]) for i in range(int(a.total[k.COUNT]))), default=1)
    return a.strips[:, :most].copy()


def _ragged(parts: list[Array]) -> Array:
    """Stack of arrays that differ in the number of strips, filled up with not-a-number."""
    most = max(p.shape[1] for p in parts)
    out = np.full((len(parts), max(p.shape[0] for p in parts), most, parts[0].shape[2]), np.nan)
    for row, p in zip(out, parts, strict=True):
        row[: p.shape[0], : p.shape[1]] = p
    return out


def wheel_outline(wheel: WheelOnRail) -> Array:
    """Outline (o, b) of the wheel seen along its rail at the pose computed last, (2, OUTLINE_POINTS) [m]."""
    a = wheel.model.arrays
    arc = np.linspace(0.0, wheel.model.wheel.length, OUTLINE_POINTS)
    out = np.empty((2, OUTLINE_POINTS))
    outline(a.wheel, a.settings[k.WHEEL_STEP], a.settings[k.RADIUS], a.pose, arc, out)
    return out
