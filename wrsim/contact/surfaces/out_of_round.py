"""Wheels out of round: polygons, flats, measured radii; and the table of depth that kernels read.

The deviation of the radius is given over the angle of the wheel: the angle by which it has to roll, from where it
stands at the start, until a place is lowest; and over the place u across its profile. What is given sums up. The table
is cubic over both, periodic over the angle.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
import scipy

from wrsim.contact.profiles.curves import Array
from wrsim.contact.profiles.profile import Profile
from wrsim.errors import InputError

TURN = 2.0 * np.pi
ROWS_OF_A_WAVE = 40  # of the table around the wheel: a spline through them is right to 2e-5 of the curvature
ROWS_OF_AN_EDGE = 4
FEWEST_ROWS, MOST_ROWS = 720, 16_384
COLUMNS_OF_A_WIDTH = 80
COLUMN_DISTANCE = 3e-3  # of the columns on which the place of contact is looked for [m]
MOST_NODES = 2_000_000
LARGEST_RANGE = 0.045
"""Largest difference of depths over the radius: the contact then lies at most 0.3 rad ahead, up to where the search's
series of the cosine is right to 1e-9 of the radius."""


@dataclass(frozen=True)
class Harmonic:
    """A wave of whole number ``order`` around the wheel: deviation amplitude cos(order angle - phase) [m, rad]."""

    order: int
    amplitude: float
    phase: float = 0.0

    def depth(self, angle: Array, across: Array, radius: float) -> Array:
        """Below the nominal radius at angles (n,) and places (m,), (n, m) or (n, 1) [m]."""
        return -self.amplitude * np.cos(self.order * angle - self.phase)[:, None]

    def spacing(self, radius: float) -> tuple[float, float]:
        """Distance of rows that follow it [rad], and of columns, infinite where it is the same across [m]."""
        return TURN / (ROWS_OF_A_WAVE * self.order), np.inf


@dataclass(frozen=True)
class Flat:
    """A flat whose middle is at an angle [rad].

    A fresh one is a chord, depth = R - (R - depth) / cos, whose edges are rounded over the length ``edge`` each; a
    rounded one (edge = 0) is depth/2 (1 + cos(2 pi x / length)) over the arc x. ``width``: of a flat that is cut by a
    crown, less deep by depth (2 (u - centre) / width)^2 across, but nowhere below 0; 0: alike all across [m].
    """

    deepest: float
    length: float
    angle: float = 0.0
    edge: float = 0.0
    width: float = 0.0
    centre: float = 0.0

    @classmethod
    def fresh(cls, radius: float, length: float | None, depth: float | None, edge: float, **place: float) -> Flat:
        """From its length or its depth, which go together: depth = R - sqrt(R^2 - length^2/4), length^2 / (8 R)."""
        if length is None:
            assert depth is not None
            length = 2.0 * np.sqrt(depth * (2.0 * radius - depth))
        depth = radius - np.sqrt(radius**2 - 0.25 * length**2)
        return cls(float(depth), float(length), edge=edge, **place)

    @classmethod
    def rounded(cls, radius: float, length: float | None, depth: float | None, **place: float) -> Flat:
        """From length and depth, or one of them: then as short as one that is nowhere hollow along the rail,
        depth = length^2 / (2 pi^2 R)."""
        if length is None:
            assert depth is not None
            length = np.pi * np.sqrt(2.0 * radius * depth)
        if depth is None:
            depth = length**2 / (2.0 * np.pi**2 * radius)
        return cls(float(depth), float(length), **place)

    def depth(self, angle: Array, across: Array, radius: float) -> Array:
        """See `Harmonic.depth`."""
        x = np.abs((angle - self.angle + np.pi) % TURN - np.pi)
        if self.edge > 0.0:
            half = 0.5 * self.edge / radius
            deviation = (self._area(x + half, radius) - self._area(x - half, radius)) / (2.0 * half)
        else:
            way = np.minimum(x * radius / self.length, 0.5)
            deviation = 0.5 * self.deepest * (1.0 + np.cos(TURN * way))
        if not self.width:
            return np.asarray(deviation[:, None])
        return np.maximum(deviation[:, None] - self.deepest * (2.0 * (across - self.centre) / self.width) ** 2, 0.0)

    def _area(self, x: Array, radius: float) -> Array:
        """Integral of a chord's depth from its middle to an angle."""
        low = radius - self.deepest
        x = np.clip(x, -np.arccos(low / radius), np.arccos(low / radius))
        return radius * x - low * np.arcsinh(np.tan(x))

    def spacing(self, radius: float) -> tuple[float, float]:
        """See `Harmonic.spacing`."""
        along = self.edge / ROWS_OF_AN_EDGE if self.edge else self.length / ROWS_OF_A_WAVE
        return along / radius, self.width / COLUMNS_OF_A_WIDTH if self.width else np.inf


@dataclass(frozen=True, eq=False)
class RadiusTable:
    """Measured deviations of the radius: angles (n,) in rising order within a turn [rad], places across (m,) [m], or
    none where it is the same across, deviations (n, m) or (n, 1) [m]. Waves shorter than ``shortest`` [m] along the
    circumference are taken out, half of the amplitude at it. Where angles lie ten times as far apart as usual the
    deviation is linear.

    Raises InputError for angles that do not rise or pass a turn, and for a table that does not close: over the joint it
    may change by twice its largest change elsewhere.
    """

    angle: Array
    across: Array
    deviation: Array
    shortest: float = 0.0

    def __post_init__(self) -> None:
        angle, values = self.angle, self.deviation
        if angle.size < 3 or values.shape != (angle.size, max(self.across.size, 1)):
            raise InputError(f"{angle.size} angles and {values.shape} deviations; a table has at least 3 angles")
        for name, rising in (("angle", angle), ("across", self.across)):
            back = np.flatnonzero(np.diff(rising) <= 0.0)
            if back.size:
                one, other = rising[back[0] : back[0] + 2] * (180.0 / np.pi if name == "angle" else 1e3)
                unit = "degrees" if name == "angle" else "mm"
                raise InputError(f"{name} {other:.6g} {unit} after {one:.6g}: must rise")
        if angle[-1] - angle[0] > TURN + 1e-9:
            span = np.degrees(angle[-1] - angle[0])
            raise InputError(f"the angles span {span:.6g} degrees; allowed: a turn of 360 degrees")
        steps = np.abs(np.diff(values, axis=0)).max()
        joint = np.abs(values[0] - values[-1]).max()
        whole = angle[-1] - angle[0] > TURN - 1e-9
        allowed = 1e-6 if whole else 2.0 * steps + 1e-6
        if joint > allowed:
            message = f"the radius does not close: {1e3 * joint:.4g} mm between its last angle and its first one"
            reason = "" if whole else ", twice its largest step"
            raise InputError(f"{message}; allowed: {1e3 * allowed:.4g} mm{reason}")

    def _stretches(self) -> tuple[Array, Array, list[slice]]:
        """Angles and deviations of a turn and its joint, begun behind the widest gap, and stretches of usual steps."""
        n = self.angle.size - (self.angle[-1] - self.angle[0] > TURN - 1e-9)
        angle, values = self.angle[:n], self.deviation[:n]
        widest = int(np.argmax(np.diff(angle, append=angle[0] + TURN)))
        order = np.roll(np.arange(n), -widest - 1)
        angle = np.unwrap(angle[order])
        angle, values = np.append(angle, angle[0] + TURN), np.append(values[order], values[order[:1]], axis=0)
        gaps = np.flatnonzero(np.diff(angle) > 10.0 * np.median(np.diff(angle)))
        bounds = [0, *(gaps + 1), angle.size]
        return angle, values, [slice(i, j) for i, j in pairwise(bounds)]

    def depth(self, angle: Array, across: Array, radius: float) -> Array:
        """See `Harmonic.depth`."""
        known, values, stretches = self._stretches()
        if self.across.size:
            inside = np.clip(across, self.across[0], self.across[-1])
            values = scipy.interpolate.Akima1DInterpolator(self.across, values, axis=1)(inside)
        measured = known[0] + (angle - known[0]) % TURN
        deviation = np.column_stack([np.interp(measured, known, column) for column in values.T])
        for stretch in stretches:
            knots = known[stretch]
            if knots.size < 3:
                continue
            inside = (measured >= knots[0]) & (measured <= knots[-1])
            closed = len(stretches) == 1
            spline = scipy.interpolate.CubicSpline(knots, values[stretch], bc_type="periodic" if closed else "clamped")
            deviation[inside] = spline(measured[inside])
        if self.shortest > 0.0:
            wave = np.arange(angle.size // 2 + 1) * self.shortest / (TURN * radius)
            deviation = np.fft.irfft(np.fft.rfft(deviation, axis=0) * 0.5 ** (wave**2)[:, None], angle.size, axis=0)
        return -deviation

    def spacing(self, radius: float) -> tuple[float, float]:
        """See `Harmonic.spacing`."""
        usual = float(np.median(np.diff(self.angle)))
        return 0.5 * usual, float(np.diff(self.across).min()) if self.across.size else np.inf


Part = Harmonic | Flat | RadiusTable


@dataclass(frozen=True, eq=False)
class ShapeTables:
    """What kernels take of a wheel out of round, see `contact.surfaces.wheel_shape`."""

    depth: Array
    branches: Array
    rows: int
    first: float
    step: float
    least: float
    hollow: float


@lru_cache(maxsize=64)
def shape_tables(parts: tuple[Part, ...], profile: Profile, radius: float) -> ShapeTables:
    """The table of a wheel that is round where ``parts`` has no depth anywhere. Raises InputError where it is deeper
    than the search follows."""
    spacing, column = (min(one) for one in zip(*(part.spacing(radius) for part in parts), strict=True))
    n = int(min(max(np.ceil(TURN / spacing), FEWEST_ROWS), MOST_ROWS))
    arc = np.linspace(0.0, profile.length, 2001)
    u = profile.at(arc)[0]
    low, high = float(u.min()), float(u.max())
    uniform = not np.isfinite(column)
    m = 1 if uniform else max(int(np.ceil((high - low) / column)), 4) + 1
    if n * m > MOST_NODES:
        raise InputError(f"{n} rows around the wheel and {m} across it: {n * m} nodes; allowed: {MOST_NODES}")
    angle, across = np.arange(n, dtype=np.float64) * (TURN / n), np.linspace(low, high, m, dtype=np.float64)
    depth = np.zeros((n, m))
    for part in parts:
        depth += part.depth(angle, across, radius)
    span = float(np.ptp(depth))
    if span > LARGEST_RANGE * radius:
        allowed = f"allowed: {1e3 * LARGEST_RANGE * radius:.4g} mm ({LARGEST_RANGE:g} of the radius)"
        raise InputError(f"the radius differs by {1e3 * span:.4g} mm around the wheel; {allowed}")
    ring = np.append(angle, TURN)
    spline = scipy.interpolate.CubicSpline(ring, np.append(depth, depth[:1], axis=0), bc_type="periodic")
    around = spline(angle, 1) * (TURN / n)
    step = 1.0 if uniform else (high - low) / (m - 1)
    sideways, twist, hollow = np.zeros_like(depth), np.zeros_like(depth), 0.0
    if not uniform:
        of_columns = scipy.interpolate.Akima1DInterpolator(across, depth, axis=1)
        sideways = of_columns(across, 1) * step
        twist = scipy.interpolate.Akima1DInterpolator(across, around, axis=1)(across, 1) * step
        hollow = float(np.abs(np.diff(sideways, axis=1)).max()) / step**2
    table = np.stack([depth, around, sideways, twist], axis=-1).transpose(1, 0, 2).reshape(n * m, 4)
    columns = np.linspace(low, high, max(int((high - low) / COLUMN_DISTANCE), 2) + 1)
    places = np.interp(columns, np.maximum.accumulate(u), arc)
    tu, tw = profile.tangent(places)
    branches = np.column_stack([columns, profile.at(places)[1], tw / np.maximum(tu, 1e-3), np.zeros(columns.size)])
    least = float(depth.min())
    return ShapeTables(np.ascontiguousarray(table), branches, n, low, step, least, hollow)
