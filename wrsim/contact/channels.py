"""From the kernel's records to named channels."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from wrsim.contact import records as k
from wrsim.contact.contact_angle import contact_angles
from wrsim.contact.model import ContactModel
from wrsim.contact.patches import RawContacts, patches_of, patches_with_main, where_present
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.search.locus import outline
from wrsim.jit import Array, Records

_OF_STRIPS = ("s", "ds", "x", "a", "p", "o", "b", "N", "Fx", "Fy", "xi", "eta", "phi", "mu", "temperature")
_RENAMED = {"o": "y", "b": "z", "mu": "friction"}
_STRIP_CHANNELS = {f"strip_{_RENAMED.get(name, name)}": name for name in _OF_STRIPS}
POSE_CHANNELS = {"wheel_origin": 0, "wheel_axle": 3, "wheel_velocity": 6, "wheel_rotation": 9}
"""Channels that hold a wheel's pose and motion, and their first place in the kernel's pose."""

OUTLINE_POINTS = 500
MOST_FIELDS = 100


@dataclass(frozen=True)
class WheelOnRail:
    """One wheel of a wheelset: its contact model, its side (+1 left, -1 right) and its wheel's place. half_spacing: H/2
    [m]; rail_origin: (o, b) of the rail profile's origin in the track cross-section at nominal gauge [m]."""

    model: ContactModel
    side: int
    half_spacing: float
    rail_origin: tuple[float, float]

    @property
    def name(self) -> str:
        return "left" if self.side > 0 else "right"


def remarks_channel(remarks: Sequence[str]) -> dict[str, NDArray[np.str_]]:
    """The channel ``contact_remark``, where solved contacts have remarks."""
    return {"contact_remark": np.array(remarks)} if any(remarks) else {}


def contact_channels(
    raw: RawContacts, wheels: Sequence[WheelOnRail], widening: Array | float = 0.0, uneven: Array | float = 0.0
) -> dict[str, Array]:
    """Channels of the wheels (sample, wheel), and of their patches (sample, wheel, patch).

    widening: designed gauge beyond the nominal one, (S,) or one [m]; uneven: irregularities under the wheels, to the
    left and up, (S, W, 2) or none [m].
    """
    p, main, channels = patches_with_main(raw)
    if wheels[0].model.settings.temperature is None:
        del channels["temperature"]
    # main points on the profiles and in the track frame
    left, up = np.moveaxis(np.broadcast_to(uneven, (*raw.patches.shape[:2], 2)), -1, 0)
    half_widening = 0.5 * np.broadcast_to(widening, raw.patches.shape[:1])
    for name, body in (("u_wheel", "wheel"), ("u_rail", "rail")):
        channels[name] = main[f"arc_{body}"].copy()
        for i, wheel in enumerate(wheels):
            profile: Profile = getattr(wheel.model, body)
            channels[name][:, i] = profile.at(np.clip(channels[name][:, i], 0.0, profile.length))[0]
    channels |= {"y_contact": main["o"].copy(), "z_contact": main["b"].copy()}
    for i, wheel in enumerate(wheels):
        o, b = wheel.rail_origin
        channels["y_contact"][:, i] = wheel.side * (o + half_widening[:, None] + channels["y_contact"][:, i])
        channels["y_contact"][:, i] += left[:, i, None]
        channels["z_contact"][:, i] += b + up[:, i, None]
    t = raw.totals
    from_totals = {
        "Y": -t["Fo"],
        "Q": t["Fb"],
        "X": -t["Ft"],
        "T_gamma": t["wear"],
        "n_patches": t["patches"].astype(float),
    }
    count = raw.patches.shape[2]
    return from_totals | {name: where_present(p, values, count) for name, values in channels.items()}


@dataclass(frozen=True)
class ElementField:
    """Elements of one patch of the exact solver: x of the columns relative to the wheel's section [m]; pressures
    (rows, columns), tractions on the wheel along x and the rows' tangents (2, rows, columns) [Pa]; rows are strips."""

    x: Array
    p: Array
    q: Array


@dataclass(frozen=True)
class _Moment:
    """One moment: strips and elements by the numbers of wheel and patch, outlines and poses of the wheels."""

    strips: dict[tuple[int, int], Records]
    outlines: Array
    poses: Array
    elements: dict[tuple[int, int], ElementField]


@dataclass
class StripRecorder:
    """Collects strips, poses and wheel outlines at chosen moments, the same wheels each time."""

    wheels: Sequence[WheelOnRail]
    moments: list[_Moment] = field(default_factory=list)

    def store(
        self, elements: Sequence[Sequence[ElementField]] = (), holders: Sequence[WheelOnRail] | None = None
    ) -> None:
        """Take in what belongs to the pose that the models computed last. elements: of every wheel's patches, if any;
        only those of the first MOST_FIELDS moments are stored; holders: the wheels with other models that hold it."""
        wheels = self.wheels if holders is None else holders
        patches = wheels[0].model.arrays.patches.shape[0]
        raw = RawContacts.empty(1, len(wheels), patches)
        for i, wheel in enumerate(wheels):
            raw.store(0, i, wheel.model.arrays)
        members, strips = patches_of(raw), {}
        for i, j in zip(*np.nonzero(members.present[0]), strict=True):
            a, main = wheels[i].model.arrays, members.main[0, i, j]
            parts = []
            for lobe in np.flatnonzero(members.member[0, i, j]):
                strip_rows = a.strips[lobe, : a.patches[lobe].n_strips].copy()
                strip_rows["s"] += a.patches["arc_rail"][lobe] - a.patches["arc_rail"][main]
                parts.append(strip_rows)
            strips[int(i), int(j)] = np.concatenate(parts)
        fields = {(i, j): patch for i, strip_rows in enumerate(elements) for j, patch in enumerate(strip_rows)}
        outlines = np.stack([np.concatenate((wheel_outline(w), rail_outline(w))) for w in wheels])
        poses = np.stack([w.model.arrays.pose for w in wheels])
        self.moments.append(_Moment(strips, outlines, poses, fields if len(self.moments) < MOST_FIELDS else {}))

    def clear_last(self) -> None:
        """Nothing was found at the moment stored last."""
        last = self.moments[-1]
        self.moments[-1] = _Moment({}, np.full_like(last.outlines, np.nan), np.full_like(last.poses, np.nan), {})

    def channels(self) -> dict[str, Array]:
        """Strip channels (moment, wheel, patch, strip) and outlines for drawing."""
        if not self.moments:
            return {}
        patches = self.wheels[0].model.arrays.patches.shape[0]
        most = max((len(row) for m in self.moments for row in m.strips.values()), default=1)
        table = np.zeros((len(self.moments), len(self.wheels), patches, max(most, 1)), k.STRIP)
        table.view(np.float64)[...] = np.nan
        for m, moment in enumerate(self.moments):
            for (i, j), row in moment.strips.items():
                table[m, i, j, : len(row)] = row
        result = {name: table[column] for name, column in _STRIP_CHANNELS.items()}
        if self.wheels[0].model.settings.temperature is None:
            del result["strip_temperature"]
        result["strip_angle"] = contact_angles(table["no"], table["nb"])
        for i, name in enumerate(("wheel_profile_y", "wheel_profile_z", "rail_profile_y", "rail_profile_z")):
            result[name] = np.stack([m.outlines[:, i] for m in self.moments])
        poses = np.stack([m.poses for m in self.moments])
        result |= {name: poses[..., start : start + 3] for name, start in POSE_CHANNELS.items()}
        return result | self._elements(table.shape)

    def _elements(self, shape: tuple[int, ...]) -> dict[str, Array]:
        """Channels of the elements, if any were stored; shape: moments, wheels, patches, strips."""
        fields = {
            (m, *place): patch for m, moment in enumerate(self.moments) for place, patch in moment.elements.items()
        }
        if not fields:
            return {}
        columns = max(patch.x.size for patch in fields.values())
        x, values = np.full((*shape[:3], columns), np.nan), np.full((3, *shape, columns), np.nan)
        for place, patch in fields.items():
            rows, width = patch.p.shape
            x[place][:width] = patch.x
            values[(slice(None), *place)][:, :rows, :width] = patch.p, *patch.q
        return {"element_x": x} | dict(zip(("element_p", "element_qx", "element_qs"), values, strict=True))


def wheel_outline(wheel: WheelOnRail) -> Array:
    """Outline (o, b) of the wheel seen along its rail at the pose computed last, (2, OUTLINE_POINTS) [m]. What a yawed
    wheel's flange back hides behind itself is left out: those points are where the outline begins."""
    a = wheel.model.arrays
    arc = np.linspace(0.0, wheel.model.wheel.length, OUTLINE_POINTS)
    out = np.empty((2, OUTLINE_POINTS))
    n = a.model
    numbers = np.array([n.depth_rows, n.depth_first, n.depth_step, n.depth_least, a.inputs.wheel_angle])
    outline(a.wheel, n.wheel_step, n.radius, a.pose, a.rows.depth, a.rows.branches, numbers, arc, out)
    begin = int(np.argmax(out[1, : int(np.argmin(out[1])) + 1]))
    out[:, :begin] = out[:, begin, None]
    return out


def rail_outline(wheel: WheelOnRail) -> Array:
    """The rail's section (o, b) at the pose computed last, the effective one, (2, OUTLINE_POINTS) [m]."""
    model = wheel.model
    if model.rolled is not None:
        return model.rolled.outline(float(model.arrays.inputs.place), OUTLINE_POINTS).T
    return np.stack(model.rail.at(np.linspace(0.0, model.rail.length, OUTLINE_POINTS)))
