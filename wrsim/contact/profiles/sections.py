"""Designed profiles: lines, polynomials and arcs laid end to end, with exact tangents and curvature.

Standards (EN 13715, EN 13674-1) round their numbers, so that neighbours disagree by up to 1e-7 m at their join. Half of
that, in position and direction, fades out over 2 mm of each; curvature keeps its jump.

A section is a smooth curve r(t), t from ``start`` to ``end`` in the direction of increasing arclength: ``evaluate(t)``
gives r, dr/dt, d2r/dt2 at t (n,), each (n, 2) with columns u, w.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.polynomial import polynomial

from wrsim.contact.profiles.curves import arclengths
from wrsim.contact.profiles.points import NODE_DISTANCE
from wrsim.contact.profiles.profile import Array, Kind, Profile, curvature_of, plane_cross
from wrsim.errors import InputError

NEAREST_NODE = 5e-6
"""Distance of the first node from a join [m]; from there nodes spread by a factor of three, so that a spline through
the bare points follows the jump of curvature to below 1e-9 m."""
FADE = 2e-3  # length over which a section gives in to its neighbour's rounded coefficients, m
LARGEST_GAP = 1e-6  # largest distance between the ends of two sections that is taken for rounding, m
MOST_SECTIONS = 500  # sections of one profile; a standard's has some ten
LARGEST_CORNER = 1e-4  # largest angle between two sections that is taken for rounding [rad]


@dataclass(frozen=True)
class ProfileLine:
    """Straight from (u0, w0) to (u1, w1), m."""

    u0: float
    w0: float
    u1: float
    w1: float
    start: float = 0.0
    end: float = 1.0

    def evaluate(self, t: Array) -> tuple[Array, Array, Array]:
        v = np.array([self.u1 - self.u0, self.w1 - self.w0])
        r = np.array([self.u0, self.w0]) + np.outer(t, v)
        return r, np.broadcast_to(v, r.shape), np.zeros_like(r)


@dataclass(frozen=True)
class ProfilePolynomial:
    """w = c0 + c1 u + c2 u^2 + ... between u = `start` and u = `end`, m."""

    coefficients: tuple[float, ...]
    start: float
    end: float

    def evaluate(self, t: Array) -> tuple[Array, Array, Array]:
        w = polynomial.Polynomial(self.coefficients)
        r, v = np.column_stack([t, w(t)]), np.column_stack([np.ones_like(t), w.deriv()(t)])
        return r, v, np.column_stack([np.zeros_like(t), w.deriv(2)(t)])


@dataclass(frozen=True)
class ProfileArc:
    """Circle about (u, w) of given radius from tangent angle `first` to tangent angle `last`, m and rad.

    The tangent angle is atan2(dw, du) along the curve: it falls on a convex arc (rail head), and rises on a concave one
    (flange fillet).
    """

    u: float
    w: float
    radius: float
    first: float
    last: float
    start: float = 0.0

    @property
    def end(self) -> float:
        """Length travelled, the parameter of the arc."""
        return self.radius * abs(self.last - self.first)

    def evaluate(self, t: Array) -> tuple[Array, Array, Array]:
        k = np.sign(self.last - self.first) / self.radius
        start = np.array([self.u, self.w]) - np.array([-np.sin(self.first), np.cos(self.first)]) / k
        angle, middle = self.first + k * t, self.first + 0.5 * k * t
        tangent = np.column_stack([np.cos(angle), np.sin(angle)])
        normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
        # Chords from the start, not radii from the centre: large radii would cost digits.
        chord = (np.sin(0.5 * k * t) / (0.5 * k))[:, None]
        return start + chord * np.column_stack([np.cos(middle), np.sin(middle)]), tangent, k * normal


ProfileSection = ProfileLine | ProfilePolynomial | ProfileArc


def arc_between(u: float, w: float, radius: float, upper: bool, start: float, end: float) -> ProfileArc:
    """Arc w(u) = w_centre +- sqrt(radius^2 - (u - u_centre)^2) from u = `start` to u = `end` > `start`, m.

    `upper` selects the half above the centre (+), which is convex upward. The ends lie within the circle.
    """
    # On the upper half the tangent angle falls with u, on the lower half it rises: sin(angle) = -+(u - u_c)/R
    first, last = np.arcsin(np.clip([(start - u) / radius, (end - u) / radius], -1.0, 1.0))
    return ProfileArc(u, w, radius, -first, -last) if upper else ProfileArc(u, w, radius, first, last)


def profile_from_sections(name: str, kind: Kind, sections: Sequence[ProfileSection], source: str = "") -> Profile:
    """Join sections, given in the order of increasing u, to a profile.

    The same sections give the same object: both wheels of an axle, and what is built again, share its tables.
    Raises InputError where sections do not meet (over 1 um apart) or meet in a corner (over 0.1 mrad).
    """
    if len(sections) > MOST_SECTIONS:
        raise InputError(f"sections: there are {len(sections)}; allowed: {MOST_SECTIONS} (more are points in a file)")
    return _joined(name, kind, tuple(sections), source)


@lru_cache(maxsize=64)
def _joined(name: str, kind: Kind, sections: tuple[ProfileSection, ...], source: str) -> Profile:
    ends = [s.evaluate(np.array([s.start, s.end])) for s in sections]
    speed = [np.hypot(v[:, 0], v[:, 1]) for _, v, _ in ends]
    # Half of each join's disagreement, to be added to both neighbours: position, and direction per length.
    shift = np.zeros((len(sections), 2, 2, 2))  # section, end, (position, direction), (u, w)
    for i in range(len(sections) - 1):
        gap = ends[i + 1][0][0] - ends[i][0][1]
        before, after = ends[i][1][1] / speed[i][1], ends[i + 1][1][0] / speed[i + 1][0]
        corner = float(np.arctan2(plane_cross(before, after), before @ after))
        where = f"profile '{name}': sections {i + 1} and {i + 2} (at u = {1e3 * ends[i][0][1][0]:.6g} mm)"
        if np.hypot(*gap) > LARGEST_GAP:
            raise InputError(f"{where} are {1e3 * np.hypot(*gap):.4g} mm apart; allowed: {1e3 * LARGEST_GAP:g} mm")
        if abs(corner) > LARGEST_CORNER:
            allowed = f"allowed: {1e3 * LARGEST_CORNER:g} mrad"
            raise InputError(f"{where} meet in a corner of {1e3 * corner:.4g} mrad; {allowed}")
        shift[i, 1] = 0.5 * np.array([gap, after - before])
        shift[i + 1, 0] = -shift[i, 1]

    parts = [_nodes(section, move) for section, move in zip(sections, shift, strict=True)]
    for before, part in pairwise(parts):
        part[:, 0] += before[-1, 0]
    L, u, w, angle, before = np.concatenate([parts[0][:1], *(part[1:] for part in parts)]).T
    after = np.concatenate([*(part[:-1, 4] for part in parts), parts[-1][-1:, 4]])
    return Profile(name, kind, L, u, w, np.unwrap(angle), before, after, source)


def _nodes(section: ProfileSection, shift: Array) -> Array:
    """Rows (own arclength, u, w, angle, curvature) of a section whose ends are moved by `shift` (2, 2, 2)."""
    fine = np.linspace(section.start, section.end, 2001)
    v = section.evaluate(fine)[1]
    travelled = np.concatenate([[0.0], np.cumsum(0.5 * (np.hypot(*v[1:].T) + np.hypot(*v[:-1].T)) * np.diff(fine))])
    total = travelled[-1]
    inner = np.linspace(0.0, total, max(int(np.ceil(total / NODE_DISTANCE)), 1) + 1)
    close = NEAREST_NODE * 3.0 ** np.arange(np.ceil(np.log(NODE_DISTANCE / NEAREST_NODE) / np.log(3.0)))
    close = close[close < min(0.7 * NODE_DISTANCE, 0.3 * total)]
    place = np.sort(np.concatenate([inner, close, total - close]))
    t = np.interp(place, travelled, fine)
    t[0], t[-1] = section.start, section.end

    fade = min(FADE, 0.5 * total)
    ends = np.array([section.start, section.end])
    rates = np.hypot(*section.evaluate(ends)[1].T)
    shifted = [e for e in (0, 1) if np.abs(shift[e]).max() > 0.0]

    def moved(t: Array, orders: Sequence[int] = (0, 1, 2)) -> list[Array]:
        moved_curve = [np.array(x) for x in section.evaluate(t)]
        for e in shifted:
            sign, rate = (1.0, -1.0)[e], rates[e]
            x = sign * (t - ends[e]) * rate / fade  # 0 at the join, 1 where it ends
            near = x < 1.0
            # (1 - x)^3 (p + (3p + q) x + (6p + 3q) x^2): value p, slope q, no curvature at 0; all zero at 1.
            p, q = shift[e, 0], sign * fade * shift[e, 1]
            for axis in (0, 1):
                start = [p[axis], 3.0 * p[axis] + q[axis], 6.0 * p[axis] + 3.0 * q[axis]]
                c = polynomial.polymul([1.0, -3.0, 3.0, -1.0], start)
                for k in orders:
                    bump = polynomial.polyval(x[near], polynomial.polyder(c, k))
                    moved_curve[k][near, axis] += bump * (sign * rate / fade) ** k
        return moved_curve

    r, v, a = moved(t)
    L = arclengths(lambda x: moved(x, (1,))[1], t)
    return np.column_stack([L, r, np.arctan2(v[:, 1], v[:, 0]), curvature_of(v, a)])


class Chain:
    """Lines and arcs that follow each other with growing u. u, w: where they have come to [m]; length so far [m]."""

    def __init__(self, u: float, w: float) -> None:
        self.u, self.w, self.length = u, w, 0.0
        self.sections: list[ProfileSection] = []

    def line(self, to_u: float, to_w: float) -> None:
        """Straight to a place [m]."""
        self.sections.append(ProfileLine(self.u, self.w, to_u, to_w))
        self.length += float(np.hypot(to_u - self.u, to_w - self.w))
        self.u, self.w = to_u, to_w

    def arc(self, radius: float, first: float, last: float) -> None:
        """Around a circle from one angle of the tangent to another one [rad], positive where it rises."""
        side = np.sign(last - first) * radius
        section = ProfileArc(self.u - side * np.sin(first), self.w + side * np.cos(first), radius, first, last)
        self.sections.append(section)
        self.length += section.end
        self.u, self.w = section.evaluate(np.array([section.end]))[0][0]


def head_arcs(name: str, radii: Sequence[float], half_widths: Sequence[float], side_slope: float) -> list[ProfileArc]:
    """Arcs of one half of a rail's head, from the crown in the origin outward; arguments as for `rail_head`."""
    centre, steepness = np.array([0.0, -radii[0]]), 0.0
    right: list[ProfileArc] = []
    for i, radius in enumerate(radii):
        if i:
            centre = centre + (radii[i - 1] - radius) * np.array([np.sin(steepness), np.cos(steepness)])
        if i < len(half_widths):
            reach = (half_widths[i] - centre[0]) / radius
            end = float(np.arcsin(reach)) if abs(reach) < 1.0 else -1.0
        else:
            end = 0.5 * np.pi - float(np.arctan(side_slope))
        if end <= steepness:
            slope = f"it starts at a slope of {np.degrees(steepness):.4g} degrees"
            message = f"the arc of radius {1e3 * radius:g} mm has no room: {slope}"
            raise InputError(f"profile '{name}': {message}; its half width or the radius before it does not fit")
        right.append(ProfileArc(centre[0], centre[1], radius, -steepness, -end))
        steepness = end
    return right


def rail_head(
    name: str, radii: Sequence[float], half_widths: Sequence[float], side_slope: float, depth: float, source: str = ""
) -> Profile:
    """Symmetric rail head of tangent arcs and straight sides, origin at the crown.

    radii: of the arcs from the crown outward [m], e.g. 0.3, 0.08, 0.013; half_widths: distance from the axis at which
    each arc but the last one ends [m], one fewer; side_slope: lean of the straight sides, e.g. 1/20,
    tangent to the last arc; depth: how far below the crown the sides are continued [m].
    """
    right = head_arcs(name, radii, half_widths, side_slope)
    steepness = -right[-1].last
    u, w = np.array([right[-1].u, right[-1].w]) + radii[-1] * np.array([np.sin(steepness), np.cos(steepness)])
    if w <= -depth:
        message = f"depth {1e3 * depth:g} mm ends before the straight sides begin"
        raise InputError(f"profile '{name}': {message}; allowed: above {-1e3 * w:.5g} mm")
    low = u + side_slope * (w + depth)
    left = [ProfileArc(-s.u, s.w, s.radius, -s.last, -s.first) for s in reversed(right[1:])]
    crown = replace(right[0], first=-right[0].last)
    middle = [*left, crown, *right[1:]]
    row: list[ProfileSection] = [ProfileLine(-low, -depth, -u, w), *middle, ProfileLine(u, w, low, -depth)]
    return profile_from_sections(name, "rail", row, source)


def cone(name: str, kind: Kind, conicity: float, first: float, last: float, source: str = "") -> Profile:
    """Straight w = conicity u between u = `first` and u = `last`, m: a conical wheel, or a flat rail."""
    line = ProfileLine(first, conicity * first, last, conicity * last)
    return profile_from_sections(name, kind, [line], source)


def circle(name: str, kind: Kind, radius: float, half_width: float, source: str = "") -> Profile:
    """Arc through the origin, horizontal there, m: convex upward for radius > 0, else hollow; half_width < |radius|."""
    end = float(np.copysign(np.arcsin(half_width / abs(radius)), radius))
    return profile_from_sections(name, kind, [ProfileArc(0.0, -radius, abs(radius), end, -end)], source)
