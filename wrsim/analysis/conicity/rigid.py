"""Rigid contact of an unyawed wheelset with both rails: where undeformed profiles touch when it is shifted sideways.

The wheelset is lowered onto the rails until both wheels touch. It has one degree of freedom besides its height, the
roll, and that follows from touching on both sides; EN 15302 leaves it out, each wheel then touches at a height of its
own. On each side the wheel touches where the vertical gap

    g(L) = z(L) - h(o(L)),    o = y + Y cos(phi) - Z sin(phi),    z = Y sin(phi) + Z cos(phi)

between the wheel's profile at arclength L and the rail's height h is smallest; y and the roll phi are counted outward
(phi lifts this wheel), Y is the lateral distance from the wheelset's middle, Z the height over the point of the
wheelset at which the shift is measured.

That point lies one mean wheel radius below the axle, at the height of the rail tops. Kinematics of a rolling wheelset
are simplest there: a conical wheelset on rails with sharp edges has exactly the rolling radius difference 2 gamma y.
The wheelset's centre is shifted by less, R phi, when it rolls: see `RigidContact.centre_shift`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from wrsim.contact.profiles.profile import Profile
from wrsim.errors import InputError
from wrsim.results.conicity import Array

NODE_DISTANCE = 1e-4
"""Distance of the places on a wheel at which the gap is sampled [m]; between them a parabola gives its minimum."""
STEEPEST = np.radians(85.0)  # slope up to which the sides of a profile take part
LEVEL, LONGEST = 1e-12, 1e-3
"""Gaps that differ by less are the same [m]; where such a piece of a wheel is longer [m], it touches along a line."""
ROLL_STEPS = 12
ROLL_TOLERANCE = 1e-13  # of the gap between both sides [m]


@dataclass(frozen=True, eq=False)
class RigidContact:
    """Contact points over the lateral shift (n,), wheels (n, 2), left first; not-a-number where one leaves its rail."""

    shift: Array  # of the wheelset at the height of the rail tops, to the left [m]
    roll: Array  # left wheel up [rad]
    lift: Array  # of the wheelset over the height at which its tape circles are at the rail tops [m]
    u_wheel: Array  # contact points on the profiles, outward [m]
    u_rail: Array
    lateral: Array  # contact points to the left of the track's centre line [m]
    radius: Array  # rolling radii [m]
    angle: Array  # contact angles against the track plane [rad]
    centre_shift: Array  # of the wheelset's centre on the axle [m]

    @property
    def radius_difference(self) -> Array:
        """Left minus right rolling radius (n,), m."""
        return np.asarray(self.radius[:, 0] - self.radius[:, 1])


class _Side:
    """One wheel over its rail, in outward coordinates."""

    def __init__(self, wheel: Profile, radius: float, rail: Profile, spacing: float, gauge: float, mean: float) -> None:
        table, self.node_distance = wheel.table(NODE_DISTANCE)
        self.wheel, self.radius, self.half_spacing = wheel, radius, 0.5 * spacing
        self.drop, self.rail_name = mean - radius, rail.name
        self.out, self.up = self.half_spacing + table[:, 0], table[:, 1] + self.drop
        self.origin = 0.5 * gauge - rail.gauge_point()[0]
        # around the top, where the rail's height is a function of u
        steep, top = np.abs(rail.angle) > STEEPEST, rail.top_node
        first = int(np.flatnonzero(np.append(True, steep[:top]))[-1])
        part = slice(first, top + int(np.flatnonzero(np.append(steep[top:], True))[0]))
        u, w = rail.u[part] + self.origin, rail.w[part] - rail.top[1]
        self.rail = CubicHermiteSpline(u, w, np.tan(rail.angle[part]))
        self.slope = self.rail.derivative()
        self.fine = np.linspace(self.rail.x[0], self.rail.x[-1], 8 * u.size)
        self.height = self.rail(self.fine)

    def placed(self, out: Array, up: Array, shift: Array, roll: Array) -> tuple[Array, Array]:
        """Outward and upward coordinates of points of the wheelset."""
        c, s = np.cos(roll), np.sin(roll)
        return shift + out * c - up * s, out * s + up * c

    def gap(self, shift: Array, roll: Array) -> tuple[Array, Array]:
        """Outward coordinate of the wheel's nodes, and the gap below them (n, nodes)."""
        o, z = self.placed(self.out, self.up, shift[:, None], roll[:, None])
        return o, z - np.interp(o, self.fine, self.height, left=-np.inf, right=-np.inf)

    def closest(self, shift: Array, roll: Array) -> tuple[Array, Array, NDArray[np.intp]]:
        """Smallest gap (n,), its rate with the outward roll, and the wheel's node next to it."""
        o, gap = self.gap(shift, roll)
        before, middle, after = gap[:, :-2], gap[:, 1:-1], gap[:, 2:]
        with np.errstate(invalid="ignore"):
            bend = 8.0 * (before - 2.0 * middle + after)
            low = (middle <= before) & (middle <= after)
            dip = np.divide((after - before) ** 2, bend, out=np.zeros_like(bend), where=low & (bend > 0.0))
            lowest = np.where(low, middle - dip, np.inf)
        node = np.argmin(np.where(np.isnan(lowest), np.inf, lowest), axis=1) + 1
        row, c, s = np.arange(shift.size), np.cos(roll), np.sin(roll)
        best, out, up = lowest[row, node - 1], self.out[node], self.up[node]
        rate = out * c - up * s + self.slope(o[row, node]) * (out * s + up * c)
        return np.where(np.isfinite(best), best, np.nan), rate, node

    def check_point(self, shift: Array, roll: Array) -> None:
        """Raises InputError where a straight piece of the wheel lies on one of the rail."""
        gap = self.gap(shift, roll)[1]
        length = self.node_distance * (gap < gap.min(axis=1, keepdims=True) + LEVEL).sum(axis=1)
        if (length > LONGEST).any():
            raise InputError(
                f"profile '{self.wheel.name}' touches profile '{self.rail_name}' along a line of "
                f"{1e3 * length.max():.3g} mm: there is no contact point, and no rolling radius"
            )

    def touch(self, shift: Array, roll: Array, node: NDArray[np.intp]) -> tuple[Array, Array, Array, Array]:
        """Wheel arclength, outward coordinate, gap and slope at the minimum beside the nodes, by bisection."""
        c, s = np.cos(roll), np.sin(roll)
        low, high = (self.node_distance * (node + k) for k in (-1.0, 1.0))
        for _ in range(48):
            middle = 0.5 * (low + high)
            o, _z = self._at(middle, shift, roll)
            tu, tw = self.wheel.tangent(middle)
            falling = tu * s + tw * c < self.slope(o) * (tu * c - tw * s)
            low, high = np.where(falling, middle, low), np.where(falling, high, middle)
        arc = 0.5 * (low + high)
        o, z = self._at(arc, shift, roll)
        tu, tw = self.wheel.tangent(arc)
        return arc, o, z - self.rail(o), np.arctan2(tu * s + tw * c, tu * c - tw * s)

    def _at(self, arc: Array, shift: Array, roll: Array) -> tuple[Array, Array]:
        u, w = self.wheel.at(np.clip(arc, 0.0, self.wheel.length))
        return self.placed(self.half_spacing + u, w + self.drop, shift, roll)


def rigid_contact(
    wheels: tuple[Profile, Profile], radii: tuple[float, float], rails: tuple[Profile, Profile],
    profile_spacing: float, gauge: float, shift: Array, rolls: bool = True,
) -> RigidContact:  # fmt: skip
    """Contact points of a wheelset at the lateral shifts (n,) [m], rolled until both wheels touch or not rolled.

    wheels, rails: profiles of the left and the right side, rails already inclined; radii: at the tape circles [m];
    profile_spacing: distance of the wheel profiles' origins [m]; gauge: 14 mm below the rail tops [m].
    Raises InputError for a rail without a gauge point, wheels that never touch both rails or touch along a line.
    """
    shift = np.asarray(shift, dtype=float)
    mean = 0.5 * (radii[0] + radii[1])
    sides = [
        _Side(wheel, radius, rail, profile_spacing, gauge, mean)
        for wheel, radius, rail in zip(wheels, radii, rails, strict=True)
    ]
    roll = np.zeros_like(shift)
    for _ in range(ROLL_STEPS):
        left, left_rate, _ = sides[0].closest(shift, roll)
        right, right_rate, _ = sides[1].closest(-shift, -roll)
        if not rolls:
            break
        step = (left - right) / (left_rate + right_rate)
        roll = roll - np.where(np.isfinite(step), step, 0.0)
        if not np.nanmax(np.abs(left - right), initial=0.0) > ROLL_TOLERANCE:
            break
    off = ~np.isfinite(left - right)
    if off.all():
        raise InputError("the wheels do not rest on the rails at any lateral shift: gauge and flange-back do not fit")
    columns: list[tuple[Array, ...]] = []
    for side, sign in zip(sides, (1.0, -1.0), strict=True):
        node = side.closest(sign * shift, sign * roll)[2]
        side.check_point(sign * shift, sign * roll)
        arc, o, gap, angle = side.touch(sign * shift, sign * roll, node)
        u, w = side.wheel.at(np.clip(arc, 0.0, side.wheel.length))
        lost = off | (o <= side.rail.x[0] + 1e-6) | (o >= side.rail.x[-1] - 1e-6)
        quantities = (u, o - side.origin, sign * o, side.radius - w, angle, -gap)
        columns.append(tuple(np.where(lost, np.nan, a) for a in quantities))
    u_wheel, u_rail, lateral, radius, angle, lift = (np.column_stack(pair) for pair in zip(*columns, strict=True))
    roll = np.where(np.isnan(lift).any(axis=1), np.nan, roll)
    return RigidContact(
        shift, roll, lift.mean(axis=1), u_wheel, u_rail, lateral, radius, angle, shift - mean * np.sin(roll)
    )
