"""Worn profiles: material taken off another profile, by bells or by tables of depths along its normals.

The worn curve is (surf-worn), a bell (surf-bell). A bell is laid along the outward coordinate u
(vertical) or the arclength from the profile's origin (normal, outward positive). Material taken off along the normal
leaves a corner wherever the curvature jumps while the depth changes: where two arcs of a rail head met. A quintic over
0.1 mm on either side bridges it, as a spline through points that far apart would. Depths may be negative: material that
flowed there. A table is a cubic spline through depths over the arclength from the origin, constant beyond its ends.

`depths_of` makes such a table of the areas lost in equal bins of arclength of the *unworn* profile, over the bin's
width [m]. So losses add up, and the profile is built and smoothed once however many steps of wear there were. The
smoothing Gaussian keeps the sum and puts no material back. A depth e takes off the area e (1 + c k e / 2); e follows
from the area with the curvature smoothed alike, and one factor near 1 makes the total area the one lost.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import sqrt
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from wrsim.contact.profiles.curves import arclengths
from wrsim.contact.profiles.points import ProfilePoints, first_crossing
from wrsim.contact.profiles.profile import Array, Profile, curvature_of, plane_cross
from wrsim.errors import InputError

Direction = Literal["vertical", "normal"]

OVERLAP = "the removed material makes the profile overlap itself"

BRIDGE = 1e-4  # reach of the quintic on either side of a corner, m
SMALLEST_CORNER = 1e-6  # turns at a node below this are rounding, rad
LARGEST_CORNER = 0.1  # largest corner that is bridged, rad
NEAREST_NODE = 5e-6  # least distance of the ends of a bell from the nodes of the unworn profile that stay, m
INSIDE = 1e-7
"""Distance from a node of the nearest of three points from which its angle and curvature are extrapolated, m."""


@dataclass(frozen=True)
class Removal:
    """One bell of removed material: depth, middle and half width [m] along u (vertical) or the arclength (normal)."""

    direction: Direction
    depth: float
    middle: float
    half_width: float

    @property
    def edges(self) -> tuple[float, float]:
        """Where it begins and ends [m]."""
        return self.middle - self.half_width, self.middle + self.half_width

    def at(self, place: Array) -> tuple[Array, Array]:
        """Removed depth [m] and its slope at places of any shape."""
        x = (place - self.middle) / self.half_width
        inside = np.abs(x) < 1.0
        d = np.where(inside, self.depth * np.cos(0.5 * np.pi * x) ** 2, 0.0)
        slope = np.where(inside, -0.5 * np.pi * self.depth / self.half_width * np.sin(np.pi * x), 0.0)
        return d, slope


@dataclass(frozen=True, eq=False)
class DepthTable:
    """Depths (n,) along the normal at rising places (n,), arclengths from the profile's origin [m]."""

    places: Array
    depths: Array
    direction: Direction = "normal"

    @property
    def edges(self) -> tuple[float, float]:
        """Where it begins and ends [m]."""
        return float(self.places[0]), float(self.places[-1])

    @cached_property
    def _spline(self) -> "scipy.interpolate.CubicSpline":
        return scipy.interpolate.CubicSpline(self.places, self.depths)

    def at(self, place: Array) -> tuple[Array, Array]:
        """Removed depth [m] and its slope at places of any shape; constant outside."""
        inside = np.clip(place, *self.edges)
        return self._spline(inside), np.where(inside == place, self._spline(inside, 1), 0.0)


AnyRemoval = Removal | DepthTable


def worn(new: Profile, removals: Sequence[AnyRemoval], name: str, source: str = "") -> Profile:
    """The profile that is left of ``new``.

    Raises InputError where the curve turns back, crosses itself or gets a corner of more than 0.1 rad, and for material
    that lies outside of the profile.
    """
    bells = _Bells(new, tuple(removals))
    for removal in removals:
        upright = removal.direction == "vertical"
        low, high = (new.u.min(), new.u.max()) if upright else (-bells.origin, new.length - bells.origin)
        if removal.edges[0] >= high or removal.edges[1] <= low:
            (begin, end), (low, high) = (1e3 * np.array(span) for span in (removal.edges, (low, high)))
            message = f"material between {begin:.6g} and {end:.6g} mm {'in u' if upright else 'along the profile'}"
            raise InputError(f"{message}: lies outside of the profile, which goes from {low:.6g} to {high:.6g} mm")
    corners = bells.corners()
    nodes = _nodes(new, bells, corners)
    first, last, span = nodes[:-1], nodes[1:], np.diff(nodes)
    h = np.minimum(INSIDE, span / 8.0)
    angle, after = bells.direction(first, h)
    final, before = bells.direction(last, -h)
    r = bells.curve(nodes)[0]
    lengths, angles = arclengths(lambda L: bells.curve(L)[1], nodes), np.unwrap(np.append(angle, final[-1]))
    curvatures = np.append(after[0], before), np.append(after, before[-1])
    profile = Profile(name, new.kind, lengths, r[:, 0], r[:, 1], angles, *curvatures, source)
    profile = _true_lengths(profile, np.searchsorted(nodes, corners) - 1)
    if crossing := first_crossing(ProfilePoints(name, profile.u, profile.w, np.arange(profile.u.size))):
        u = 1e3 * profile.u[crossing[0]]
        raise InputError(f"{OVERLAP}: it crosses itself at u = {u:.4g} mm; allowed: less depth, or a wider bell")
    return profile


@dataclass(frozen=True)
class _Bells:
    """The worn curve over the arclength of the unworn one."""

    new: Profile
    removals: tuple[AnyRemoval, ...]

    @property
    def origin(self) -> float:
        """Arclength of the profile's origin."""
        return float(self.new.arclength_of(0.0))

    def depths(self, L: Array) -> tuple[Array, Array, Array, Array]:
        """d, d' vertically, e, e' along the inward normal; all over the arclength L."""
        d, slope, e, e_slope = (np.zeros_like(L) for _ in range(4))
        for removal in self.removals:
            if removal.direction == "vertical":
                depth, s = removal.at(self.new.at(L)[0])
                d, slope = d + depth, slope + s * self.new.tangent(L)[0]
            else:
                depth, s = removal.at(L - self.origin)
                e, e_slope = e + depth, e_slope + s
        return d, slope, e, e_slope

    def curve(self, L: Array, curvature: Array | None = None) -> tuple[Array, Array]:
        """Position and derivative with respect to L, each (..., 2); curvature: of the unworn curve, if not its own."""
        rail = self.new.kind == "rail"
        up = -1.0 if rail else 1.0  # into the material
        r, v, a = self.new._evaluate(L, 0, 1, 2)
        k = curvature_of(v, a) if curvature is None else curvature
        d, slope, e, e_slope = self.depths(L)
        t = v / np.hypot(v[..., 0], v[..., 1])[..., None]
        inward = -up * np.stack((t[..., 1], -t[..., 0]), axis=-1)
        vertical = np.array([0.0, up])
        r = r + d[..., None] * vertical + e[..., None] * inward
        stretch = 1.0 + (k if rail else -k) * e
        if not (stretch > 0.0).all():
            u = 1e3 * float(self.new.at(L.flat[int(np.argmin(stretch))])[0])
            raise InputError(f"{OVERLAP}: it turns back at u = {u:.4g} mm; allowed: less depth")
        return r, stretch[..., None] * t + slope[..., None] * vertical + e_slope[..., None] * inward

    def corners(self) -> Array:
        """Arclengths at which the worn curve has a corner, (m,)."""
        inner = slice(1, -1)
        L = self.new.arclength[inner]
        jump = np.flatnonzero(np.abs((self.new.curvature_after - self.new.curvature_before)[inner]) > 1e-6)
        L, sides = L[jump], (self.new.curvature_before[inner][jump], self.new.curvature_after[inner][jump])
        before, after = (self.curve(L, k)[1] for k in sides)
        turn = np.arctan2(plane_cross(before, after), (before * after).sum(axis=1))
        if np.abs(turn).max(initial=0.0) > LARGEST_CORNER:
            i = int(np.argmax(np.abs(turn)))
            corner = f"a corner of {1e3 * turn[i]:.4g} mrad at u = {1e3 * float(self.new.at(L[i])[0]):.4g} mm"
            allowed = f"where the unworn curvature jumps; allowed: {1e3 * LARGEST_CORNER:g} mrad"
            raise InputError(f"the removed material leaves {corner}, {allowed}")
        return np.asarray(L[np.abs(turn) > SMALLEST_CORNER])

    def direction(self, L: Array, h: Array) -> tuple[Array, Array]:
        """Tangent angle and curvature at L (n,), from the side of L + h: extrapolated from three points there."""
        v = self.curve(L[:, None] + h[:, None] * np.array([1.0, 2.0, 3.0]))[1]
        a, b, c = np.unwrap(np.arctan2(v[..., 1], v[..., 0]), axis=1).T
        return 3.0 * a - 3.0 * b + c, (-2.5 * a + 4.0 * b - 1.5 * c) / (h * np.hypot(*v[:, 0].T))


def _nodes(new: Profile, bells: _Bells, corners: Array) -> Array:
    """Arclengths of the unworn curve at which the worn one has nodes: its nodes, ends of bells, edges of bridges."""
    extra = [corners - BRIDGE, corners + BRIDGE]
    for removal, edge in ((bell, edge) for bell in bells.removals for edge in bell.edges):
        if removal.direction == "normal":
            extra.append(np.array([edge + bells.origin]))
        else:  # everywhere that the curve passes this u
            i = np.flatnonzero(np.diff(new.u >= edge))
            extra.append(new.root_in_interval(0, np.full(i.size, edge), i))
    added = np.concatenate(extra)
    added = added[(added > NEAREST_NODE) & (added < new.length - NEAREST_NODE)]
    far = np.abs(new.arclength[1:-1, None] - added).min(axis=1, initial=np.inf) > NEAREST_NODE
    nodes = np.unique(np.concatenate([[0.0], new.arclength[1:-1][far], added, [new.length]]))
    if corners.size:
        nodes = nodes[np.abs(nodes[:, None] - corners).min(axis=1) > BRIDGE - 0.5 * NEAREST_NODE]
    return np.asarray(nodes[np.append(True, np.diff(nodes) > 1e-9)])


def _true_lengths(profile: Profile, bridges: NDArray[np.intp]) -> Profile:
    """The same with intervals as long as the quintics that bridge them."""
    for _ in range(8):
        span = np.diff(profile.arclength)
        for i in bridges:
            span[i] = arclengths(lambda L, p=profile: p._evaluate(L, 1)[0], profile.arclength[i : i + 2])[1]  # type: ignore[misc]
        profile = replace(profile, arclength=np.concatenate([[0.0], np.cumsum(span)]))
    return profile


HALVING = sqrt(0.5 * np.log(2.0)) / np.pi  # deviation of the Gaussian that halves a wave, over its wavelength
REACH = 6.0  # of the Gaussian, over its deviation
PARTS = 5  # Gauss points between two places, for areas


def bin_edges(profile: Profile, step: float) -> Array:
    """Edges (n + 1,) of equal bins of arclength, at most a step wide [m]."""
    return np.linspace(0.0, profile.length, int(np.ceil(profile.length / step)) + 1)


def smoothed_table(values: Array, width: float, cutoff: float) -> Array:
    """Values at places a width apart, smoothed; cutoff: wavelength that passes with half its amplitude [m]."""
    from scipy.ndimage import gaussian_filter1d  # only wear needs it

    return np.asarray(gaussian_filter1d(values, HALVING * cutoff / width, mode="reflect", truncate=REACH))


def depths_of(profile: Profile, areas: Array, cutoff: float) -> DepthTable:
    """The table of depths that takes areas (n,) over bin widths off an unworn profile, smoothed.

    Raises InputError where the normals meet within the depth.
    """
    width = profile.length / areas.size
    middles: Array = (np.arange(areas.size, dtype=np.float64) + 0.5) * width
    sign = 1.0 if profile.kind == "rail" else -1.0
    smooth = smoothed_table(areas, width, cutoff)
    bend = sign * smoothed_table(profile.curvature(middles), width, cutoff)
    root = 1.0 + 2.0 * bend * smooth
    if not (root > 0.0).all():
        u = 1e3 * float(profile.at(middles[int(np.argmin(root))])[0])
        raise InputError(f"{OVERLAP} at u = {u:.4g} mm; allowed: less depth")
    depth: Array = 2.0 * smooth / (1.0 + np.sqrt(root))
    table = DepthTable(middles - float(profile.arclength_of(0.0)), depth)
    plain, bent = area_off(profile, table)
    if not plain > 0.0:
        return table
    lost = float(areas.sum()) * width
    factor = 2.0 * lost / (plain + sqrt(max(plain**2 + 4.0 * bent * lost, 0.0)))
    return replace(table, depths=factor * table.depths)


def on_unworn(profile: Profile, table: DepthTable | None, length: float, lost: Array, count: int) -> Array:
    """Areas over bin widths (count,) of the unworn profile from those (n,) of the worn one, with the same sum [m].

    table: of the wear so far; length: of the worn profile [m].
    """
    edges = np.linspace(0.0, profile.length, count + 1)
    places = edges if table is None else arclengths(lambda u: _Bells(profile, (table,)).curve(u)[1], edges)
    places = places * (length / places[-1])
    bins = np.linspace(0.0, length, lost.size + 1)
    gone = np.concatenate([[0.0], np.cumsum(lost * (bins[1] - bins[0]))])
    return np.diff(np.interp(places, bins, gone)) / (edges[1] - edges[0])


def area_off(profile: Profile, table: DepthTable) -> tuple[float, float]:
    """Integrals of the depth and of c k e^2 / 2 over the arclength [m2]."""
    x, weight = np.polynomial.legendre.leggauss(PARTS)
    # the curvature jumps at nodes, the spline changes at places
    origin = float(profile.arclength_of(0.0))
    edges = np.unique(np.concatenate([profile.arclength, np.clip(table.places + origin, 0.0, profile.length)]))
    half = 0.5 * np.diff(edges)
    L = (0.5 * (edges[1:] + edges[:-1]) + np.multiply.outer(x, half)).ravel()
    weights = np.multiply.outer(weight, half).ravel()
    depth = table.at(L - origin)[0]
    sign = 1.0 if profile.kind == "rail" else -1.0
    return float((weights * depth).sum()), float((weights * 0.5 * sign * profile.curvature(L) * depth**2).sum())
