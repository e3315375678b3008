"""What the strips of a run take off wheels and rails, gathered place by place on both profiles.

Of every strip of a sample: power of creep ``-(Fx xi + Fy eta + Mz phi)`` [J per metre], those of a lobe scaled to its
T-gamma where some of them would be negative; from it, with a law, mass per metre rolled, the same for wheel and rail.
USFD takes a strip's power over its area: a strip is what two discs have in the machine that the law was measured in.
BRR takes the T-gamma of the patch and gives every strip its share of the power. Archard's law needs sliding speed and
pressure from point to point along x: there the power of a strip is spread as strip theory has it (`laws.slip_along`),
whatever the model of the creep forces; the sum over the strip is conserved.
Times the way of the sample, that is mass [kg], spread evenly over the places (bins of arclength) that the
strip covers (docs/user/wear.md).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wrsim.contact.channels import WheelOnRail
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.records import LOBE, POSE, STRIP
from wrsim.contact.wear.laws import DENSITY, LawName, WearSettings, brr, damage, slip_along, usfd, wear_coefficient
from wrsim.jit import Array, Records

FLANGE_ANGLE = np.radians(30.0)
"""Slope of a profile from which on, towards the gauge side, it is flange or gauge corner; before it is tread or top."""
ZONES = ("tread", "flange")

COLUMNS = 20
"""Parts of a strip along x, for laws that need them."""
ROOM = 20_000_000
"""Bytes of strips that are worked through together."""


@dataclass(frozen=True)
class Rows:
    """Strips of any number of wheels and samples, one row each, and what is known of their lobes and wheels.

    strip: STRIP records; way: of the sample [m]; speed: of rolling [m/s]; wear, patch: T-gamma of the lobe
    and of its patch [N]; lobe: number of the lobe among all of these; arc_wheel, arc_rail: arclengths [m], that on the
    wheel a first guess; u, w: of the centre in the axes of the wheel's profile [m]; wheel: number of the wheel, left
    and right of the first wheelset, of the second, ...
    """

    strip: Records
    way: Array
    speed: Array
    wear: Array
    patch: Array
    lobe: NDArray[np.intp]
    arc_wheel: Array
    arc_rail: Array
    u: Array
    w: Array
    wheel: NDArray[np.intp]

    @property
    def power(self) -> Array:
        """What creep dissipates in every strip, per metre rolled [J/m]; over a lobe they add up to its T-gamma."""
        strip = self.strip
        dissipated = -(strip["Fx"] * strip["xi"] + strip["Fy"] * strip["eta"] + strip["Mz"] * strip["phi"])
        dissipated = np.maximum(dissipated, 0.0)
        total = np.bincount(self.lobe, dissipated)[self.lobe]
        return dissipated * np.maximum(self.wear, 0.0) / np.where(total > 0.0, total, np.inf)


def _rows(samples: Records, radii: Array) -> Rows:
    """All strips with a load, of what `Losses.store` has copied; radii: of the wheels [m]."""
    lobes, strips, wheel = samples["lobes"].view(LOBE), samples["strips"].view(STRIP), samples["wheel"]
    loaded = (np.arange(lobes.shape[1]) < samples["count"][:, None]) & (lobes["N"] > 0.0)
    used = loaded[..., None] & (np.arange(strips.shape[2]) < lobes["n_strips"][..., None])
    sample, lobe, _ = np.nonzero(used)
    strip = strips[used]
    wear = np.where(loaded, lobes["wear"], 0.0)
    # lobes of one patch have one number
    same = lobes["group"][:, :, None] == lobes["group"][:, None, :]
    patch = (same * wear[:, None, :]).sum(axis=2)
    pose = samples["pose"][sample]
    arm = np.stack([strip["x"], strip["o"], strip["b"]], axis=-1) - pose[:, :3]
    u = (arm * pose[:, 3:6]).sum(axis=1)
    radius = np.linalg.norm(arm - u[:, None] * pose[:, 3:6], axis=1)
    on_wheel, on_rail = (lobes[name][sample, lobe] + strip["s"] for name in ("arc_wheel", "arc_rail"))
    return Rows(
        strip, samples["way"][sample], np.abs(pose[:, 6]), wear[sample, lobe], patch[sample, lobe],
        sample * lobes.shape[1] + lobe, on_wheel, on_rail, u, radii[wheel[sample]] - radius, wheel[sample],
    )  # fmt: skip


@dataclass(frozen=True)
class Places:
    """Places on a profile: bins of equal arclength; u, w: of their middles [m], width: of each along the profile [m],
    flange: those that are flange."""

    u: Array
    w: Array
    width: float
    flange: NDArray[np.bool_]

    @classmethod
    def on(cls, profile: Profile, step: float) -> "Places":
        """Bins of at most this step [m]."""
        count = int(np.ceil(profile.length / step))
        middles = (np.arange(count) + 0.5) * profile.length / count
        u, w = profile.at(middles)
        # the gauge corner of a rail and the face of a flange both rise outwards
        return cls(u, w, profile.length / count, profile.slope_angle(middles) > FLANGE_ANGLE)


class Losses:
    """Gathers the losses of a run, sample by sample."""

    def __init__(self, settings: WearSettings, wheels: Sequence[Sequence[WheelOnRail]], ways: Sequence[Array]) -> None:
        """wheels: of every wheelset, left and right; ways: of every wheelset, of its samples [m]."""
        self.settings, self.wheels, self.ways = settings, wheels, ways
        self.of_wheels = [[Places.on(wheel.model.wheel, settings.step) for wheel in pair] for pair in wheels]
        self.of_rails = [Places.on(wheel.model.rail, settings.step) for wheel in wheels[0]]
        most = max(p.u.size for pair in self.of_wheels for p in pair)
        on_rail = max(p.u.size for p in self.of_rails)
        laws = len(settings.laws)
        # of each law the mass, then what creep dissipates [J]; of the rail also damage over the way [m]
        self.on_wheels = np.zeros((laws + 1, len(wheels), 2, most))
        self.on_rails = np.zeros((laws + 2, len(wheels), 2, on_rail))
        a = wheels[0][0].model.arrays  # those of all wheels have one shape
        # records as plain numbers: numpy copies them a hundred times as fast
        kind: Any = [("lobes", "f8", a.patches.view("f8").shape), ("strips", "f8", a.strips.view("f8").shape)]
        kind += [("pose", "f8", POSE), ("way", "f8"), ("count", "i8"), ("wheel", "i8")]
        self._samples, self._count = np.zeros(max(ROOM // a.strips.nbytes, 1), kind), 0

    def store(self, wheelset: int, sample: int, contacts: Sequence[tuple[Records, Records, Array, int]]) -> None:
        """Take in the contacts of both wheels of a wheelset at a sample of the run: LOBE records, STRIP records, POSE,
        and the number of lobes of each."""
        way = float(self.ways[wheelset][sample])
        if not way > 0.0:
            return
        for side, (lobes, strips, pose, count) in enumerate(contacts):
            if count:
                row = lobes.view("f8"), strips.view("f8"), pose, way, count, 2 * wheelset + side
                self._samples[self._count] = row
                self._count += 1
            if self._count == self._samples.size:
                self._work_through()

    def _work_through(self) -> None:
        """Add up what was stored since the last call."""
        if not self._count:
            return
        wheels = [wheel for pair in self.wheels for wheel in pair]
        rows = _rows(self._samples[: self._count], np.array([wheel.model.radius for wheel in wheels]))
        self._count = 0
        width, power = rows.strip["ds"], rows.power
        material = wheels[0].model.settings.wheel
        stiffness = material.shear_modulus / (1.0 - material.poisson_ratio)
        lost = [mass_lost(law, rows, power, self.settings, stiffness) for law in self.settings.laws]
        amounts = [amount * rows.way for amount in (*lost, power)]
        harm = damage(rows.patch) * width * rows.way
        for i, wheel in enumerate(wheels):
            mine = rows.wheel == i
            if not mine.any():
                continue
            w, side = divmod(i, 2)
            amount_here = [amount[mine] for amount in (*amounts, harm)]
            arc = _foot(wheel.model.wheel, rows.arc_wheel[mine], rows.u[mine], rows.w[mine])
            places = self.of_wheels[w][side]
            self.on_wheels[:, w, side, : places.u.size] += _spread(arc, width[mine], places, amount_here[:-1])
            places = self.of_rails[side]
            self.on_rails[:, w, side, : places.u.size] += _spread(rows.arc_rail[mine], width[mine], places, amount_here)

    def channels(self) -> dict[str, Array]:
        """Channels of a result, over laws, wheelsets, wheels, zones and places; see docs/reference/channels.md."""
        self._work_through()
        laws = len(self.settings.laws)
        total = np.array([travelled.sum() for travelled in self.ways])
        way = np.where(total > 0.0, total, np.nan)[:, None, None]
        mass = self.on_wheels[:laws] / way  # kg per metre rolled
        of_wheels, shape = [places for pair in self.of_wheels for places in pair], self.on_wheels.shape[1:]
        u, w, width, flange = (_table(of_wheels, n, shape[-1]).reshape(shape) for n in ("u", "w", "width", "flange"))
        radius = np.array([[wheel.model.radius for wheel in pair] for pair in self.wheels])[..., None] - w
        ring = 2.0 * np.pi * radius * width
        rail_width = np.array([[places.width] for places in self.of_rails])
        # one vehicle after the other runs over a rail: the wheelsets add up
        of_rail = (self.on_rails / way).sum(axis=1)
        by_zone = [np.where(flange == (zone == "flange"), mass, 0.0).sum(axis=-1) for zone in ZONES]
        return {
            "wear_wheel_u": u,
            "wear_wheel_depth": mass / (DENSITY * ring),
            "wear_wheel_mass": np.stack(by_zone, axis=-1),
            "wear_wheel_energy": self.on_wheels[laws] / way / width,
            "wear_rail_u": _table(self.of_rails, "u", self.on_rails.shape[-1]),
            "wear_rail_depth": of_rail[:laws] / (DENSITY * rail_width),
            "wear_rail_energy": of_rail[laws] / rail_width,
            "rail_damage": of_rail[laws + 1] / rail_width,
        }


def _table(rows: Sequence[Places], name: str, count: int) -> Array:
    """An attribute of several rows of places, (rows, count); not-a-number beyond the last of a row."""
    table = np.full((len(rows), count), np.nan)
    for row, places in zip(table, rows, strict=True):
        row[: places.u.size] = getattr(places, name)
    return table


def ways(distance: Array, stretch: tuple[float | None, float | None]) -> Array:
    """The way [m] of each sample of a wheelset: half of that to either neighbour, within a stretch [m].
    distance: of the samples, rising, (n,). They add up to the stretch as far as the run passes it."""
    low = distance[0] if stretch[0] is None else stretch[0]
    high = distance[-1] if stretch[1] is None else stretch[1]
    edges = np.concatenate([distance[:1], 0.5 * (distance[1:] + distance[:-1]), distance[-1:]])
    return np.maximum(np.diff(np.clip(edges, low, high)), 0.0)


def mass_lost(law: LawName, rows: Rows, power: Array, settings: WearSettings, stiffness: float) -> Array:
    """Mass that each strip loses per metre rolled [kg/m]; power: of each [J/m], stiffness: G / (1 - nu) [Pa]."""
    strip = rows.strip
    if law == "usfd":
        area = 2.0 * strip["a"] * strip["ds"]
        return usfd(power / np.where(area > 0.0, area, np.inf)) * area
    if law == "brr":
        return brr(rows.patch) * power / np.where(rows.patch > 0.0, rows.patch, np.inf)
    return _archard(rows, power, settings, stiffness)


def _archard(rows: Rows, power: Array, settings: WearSettings, stiffness: float) -> Array:
    """The same by Archard's law. Where a point slides its traction is mu p, so k p times slip is k power over mu."""
    works = power > 0.0
    lost = np.zeros(power.size)
    strip, power, speed = rows.strip[works], power[works], rows.speed[works]
    mu, top = strip["mu"], strip["p"]
    x = (np.arange(COLUMNS) + 0.5) * 2.0 / COLUMNS - 1.0
    height = np.sqrt(1.0 - x * x)
    # spin counts by its mean square under the pressure: x^2 is a^2 / 4 there
    rigid = np.sqrt(strip["xi"] ** 2 + strip["eta"] ** 2 + (0.5 * strip["phi"] * strip["a"]) ** 2)
    dissipated = height * slip_along(rigid * stiffness / (2.0 * mu * top), COLUMNS)
    dissipated *= (power / dissipated.sum(axis=1))[:, None]  # J/m of every part
    pressure = top[:, None] * height
    part = 2.0 * strip["a"] * strip["ds"] / COLUMNS
    slip = dissipated / ((mu * part)[:, None] * pressure)
    k = wear_coefficient(slip * speed[:, None], pressure, settings.hardness, settings.coefficients)
    lost[works] = DENSITY * (k * dissipated).sum(axis=1) / (mu * settings.hardness)
    return lost


def _spread(arc: Array, width: Array, places: Places, amounts: Sequence[Array]) -> Array:
    """Amounts (n,) of strips about arclengths [m] with their widths [m] by place, (amounts, places); what would lie
    beyond a profile's end stays in it."""
    step, count = places.width, places.u.size
    low, high = arc - 0.5 * width, arc + 0.5 * width
    parts = np.floor(low / step).astype(np.intp) + np.arange(int(np.ceil(width.max() / step)) + 1)[:, None]
    covered = np.maximum(np.minimum(high, (parts + 1) * step) - np.maximum(low, parts * step), 0.0)
    covered[0, covered.sum(axis=0) <= 0.0] = 1.0
    bins, shares = np.clip(parts, 0, count - 1).ravel(), covered / covered.sum(axis=0)
    return np.array([np.bincount(bins, (shares * amount).ravel(), count) for amount in amounts])


def _foot(profile: Profile, arc: Array, u: Array, w: Array) -> Array:
    """Arclengths of the points of a profile nearest to (u, w), from a first guess [m]."""
    for _ in range(2):
        arc = np.clip(arc, 0.0, profile.length)
        at_u, at_w = profile.at(arc)
        along_u, along_w = profile.tangent(arc)
        arc = arc + (u - at_u) * along_u + (w - at_w) * along_w
    return np.clip(arc, 0.0, profile.length)
