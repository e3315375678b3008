"""The plane curve of a wheel tread or a rail head, by arclength [S 5, 6, 10-12].

A profile is a curve (u, w)(L), not a function w(u): flanks may be vertical. u points outward (field side
positive, flange and gauge side negative), w up; L runs from the first node in the direction of increasing u.
The wheel's material lies above its curve, the rail's below. The wheel's radius is not in here: f = w - R.

Between two nodes it is the quintic that meets position, tangent and curvature at both. With nodes 0.1 mm apart on a 13
mm arc it leaves the arc by less than 1e-15 m: the parameter is true arclength. Curvature may jump at a node, so both of
its limits are given.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wrsim.contact.profiles.curves import Array
from wrsim.errors import InputError
from wrsim.inputs.notebook import card

Kind = Literal["wheel", "rail"]

KINDS: tuple[Kind, ...] = ("wheel", "rail")
CURVE = ("arclength", "u", "w", "angle", "curvature_before", "curvature_after")  # arrays of a profile
GAUGE_DEPTH = 0.014  # usual depth below the running surface at which the track gauge is measured [m], EN 13848-1


def plane_cross(a: Array, b: Array) -> Array:
    """The product a_u b_w - a_w b_u of plane vectors (..., 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def curvature_of(v: Array, a: Array) -> Array:
    """Signed curvature of a plane curve with the first two derivatives v, a (..., 2)."""
    return np.asarray(plane_cross(v, a) / np.hypot(v[..., 0], v[..., 1]) ** 3)


@dataclass(frozen=True, eq=False)
class Profile:
    """A wheel or rail profile: nodes in order of arclength, and the curve through them.

    name: for messages and figures; arclength (n,): of the nodes, strictly increasing from 0 [m]; u, w (n,): outward
    coordinate and height of the nodes [m]; angle (n,): tangent angle atan2(dw, du), continuous along the curve [rad];
    curvature_before, curvature_after (n,): d(angle)/dL just before and just after each node [1/m], positive when the
    curve turns upward: a rail head has negative, a flange fillet positive curvature; source: where the data come from;
    gauge_depth: of a rail's gauge point below its top [m]; head: arclength at which a rail's head begins, beside a
    check rail [m]; notes: what was assumed of the file of its points; back: distance of a wheel's flange back from the
    tape circle, where it is known [m].

    Arrays are read-only. Changes return a new profile.
    """

    name: str
    kind: Kind
    arclength: Array
    u: Array
    w: Array
    angle: Array
    curvature_before: Array
    curvature_after: Array
    source: str = ""
    gauge_depth: float = GAUGE_DEPTH
    head: float = 0.0
    notes: tuple[str, ...] = ()
    back: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise self._fault(f"kind is {self.kind!r}; allowed: 'wheel', 'rail'")
        for field in CURVE:
            array = np.array(getattr(self, field), dtype=float)
            if array.ndim != 1 or array.shape != np.shape(self.arclength) or array.size < 2:
                raise ValueError(f"profile '{self.name}': {field} must be (n,) like arclength, with n >= 2")
            if not np.isfinite(array).all():
                raise ValueError(f"profile '{self.name}': {field} has values that are not finite")
            array.flags.writeable = False
            object.__setattr__(self, field, array)
        if self.arclength[0] != 0.0 or not (np.diff(self.arclength) > 0.0).all():
            raise ValueError(f"profile '{self.name}': arclength must start at 0 and increase")

    def __repr__(self) -> str:
        return (
            f"Profile({self.name!r}, {self.kind}, u {1e3 * self.u.min():.2f} .. {1e3 * self.u.max():.2f} mm, "
            f"length {1e3 * self.length:.2f} mm, {self.u.size} nodes)"
        )

    def _repr_html_(self) -> str:
        u, w = 1e3 * self.u[:: max(self.u.size // 300, 1)], -1e3 * self.w[:: max(self.u.size // 300, 1)]
        low, high = (f(axis) for f, axis in ((np.min, u), (np.max, u)))
        box = f"{low - 1:.1f} {w.min() - 1:.1f} {high - low + 2:.1f} {np.ptp(w) + 2:.1f}"
        points = " ".join(f"{x:.2f},{y:.2f}" for x, y in zip(u, w, strict=True))
        line = f"<polyline points='{points}' fill='none' stroke='currentColor' stroke-width='0.6'/>"
        drawn = f"<svg viewBox='{box}' width='320' role='img' aria-label='profile'>{line}</svg>"
        rows = (
            ("kind", self.kind),
            ("u, outward", f"{1e3 * self.u.min():.2f} to {1e3 * self.u.max():.2f} mm"),
            ("length", f"{1e3 * self.length:.2f} mm, {self.u.size} nodes"),
            ("source", self.source or "none"),
        )
        return card(self.name, rows, drawn)

    def _fault(self, message: str) -> InputError:
        return InputError(f"profile '{self.name}': {message}")

    @property
    def length(self) -> float:
        """Arclength of the whole curve, m."""
        return float(self.arclength[-1])

    @cached_property
    def _coefficients(self) -> Array:
        """Quintic of every interval, (6, n-1, 2): powers of (L - L_i) rising, last axis u and w."""
        h = np.diff(self.arclength)[:, None]
        r = np.column_stack([self.u, self.w])
        t = np.column_stack([np.cos(self.angle), np.sin(self.angle)])
        n = np.column_stack([-t[:, 1], t[:, 0]])
        a0 = self.curvature_after[:-1, None] * n[:-1]
        a1 = self.curvature_before[1:, None] * n[1:]
        # What the quadratic start leaves to be met at the far end: position, velocity, acceleration.
        p = r[1:] - r[:-1] - t[:-1] * h - 0.5 * a0 * h**2
        v = (t[1:] - t[:-1] - a0 * h) * h
        a = (a1 - a0) * h**2
        cubic, quartic = (10.0 * p - 4.0 * v + 0.5 * a) / h**3, (-15.0 * p + 7.0 * v - a) / h**4
        return np.stack([r[:-1], t[:-1], 0.5 * a0, cubic, quartic, (6.0 * p - 3.0 * v + 0.5 * a) / h**5])

    def _locate(self, L: ArrayLike) -> tuple[Array, NDArray[np.intp]]:
        """Distance into its interval and the interval's index for every L. InputError outside the curve."""
        L = np.asarray(L, dtype=float)
        slack = 1e-9 * self.length
        outside = ~(np.abs(L - 0.5 * self.length) <= 0.5 * self.length + slack)
        if outside.any():
            bad = L.flat[int(np.argmax(outside))]
            allowed = f"allowed: 0 to {1e3 * self.length:.6g} mm"
            raise self._fault(f"arclength {1e3 * bad:.6g} mm is off the curve; {allowed}")
        index = np.clip(np.searchsorted(self.arclength, L, side="right") - 1, 0, self.u.size - 2)
        return L - self.arclength[index], index

    def _evaluate(self, L: ArrayLike, *orders: int) -> list[Array]:
        """Position (0), first (1) and second (2) derivative with respect to L, as asked for, each (..., 2)."""
        x, i = self._locate(L)
        c0, c1, c2, c3, c4, c5 = self._coefficients[:, i]
        x = x[..., None]
        terms = (
            lambda: c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5)))),
            lambda: c1 + x * (2.0 * c2 + x * (3.0 * c3 + x * (4.0 * c4 + x * 5.0 * c5))),
            lambda: 2.0 * c2 + x * (6.0 * c3 + x * (12.0 * c4 + x * 20.0 * c5)),
        )
        return [terms[order]() for order in orders]

    def at(self, L: ArrayLike) -> tuple[Array, Array]:
        """Coordinates u, w at arclength L, m. L of any shape, within 0 .. length; InputError outside."""
        (r,) = self._evaluate(L, 0)
        return r[..., 0], r[..., 1]

    def tangent(self, L: ArrayLike) -> tuple[Array, Array]:
        """Unit tangent (du/dL, dw/dL) at arclength L, in the direction of increasing L."""
        (v,) = self._evaluate(L, 1)
        v = v / np.hypot(v[..., 0], v[..., 1])[..., None]
        return v[..., 0], v[..., 1]

    def normal(self, L: ArrayLike) -> tuple[Array, Array]:
        """Unit normal out of the material at arclength L: up on a rail's crown, down on a wheel's tread."""
        tu, tw = self.tangent(L)
        return (-tw, tu) if self.kind == "rail" else (tw, -tu)

    def curvature(self, L: ArrayLike) -> Array:
        """Signed curvature d(angle)/dL at arclength L, 1/m; at a jump its value just after."""
        v, a = self._evaluate(L, 1, 2)
        return curvature_of(v, a)

    def slope_angle(self, L: ArrayLike) -> Array:
        """Tangent angle atan2(dw, du) at arclength L, rad, continuous along the curve."""
        tu, tw = self.tangent(L)
        near = self.angle[self._locate(L)[1]]
        return near + (np.arctan2(tw, tu) - near + np.pi) % (2.0 * np.pi) - np.pi

    def table(self, step: float) -> tuple[Array, float]:
        """Rows (n, 5) of u, w, du/dL, dw/dL, curvature at uniform arclength from 0 to length, for the kernels.

        step: wanted distance of the rows [m], 0.1 mm is typical. Returned with the rows is the distance actually used,
        length / (n - 1) <= the wanted one with n = ceil(length / step) + 1.
        """
        if not 0.0 < step <= self.length:
            raise self._fault(f"table step {1e3 * step:g} mm; allowed: above 0, up to {1e3 * self.length:g} mm")
        n = int(np.ceil(self.length / step * (1.0 - 1e-12))) + 1
        actual = self.length / (n - 1)
        L = np.minimum(actual * np.arange(n), self.length)
        return np.column_stack([*self.at(L), *self.tangent(L), self.curvature(L)]), actual

    def arclength_of(self, u: ArrayLike) -> Array:
        """Arclength of the running surface's point at outward coordinate u, m.

        Where the curve passes u more than once (a flank beyond the vertical, the back of a flange) the point
        met first when coming from the running surface counts: from the top of a rail, from u = 0 of a wheel.
        InputError where u lies beside the profile.
        """
        wanted = np.asarray(u, dtype=float)
        start = self.top_node if self.kind == "rail" else int(np.argmin(np.abs(self.u)))
        right = np.maximum.accumulate(self.u[start:])
        left = np.minimum.accumulate(self.u[start::-1])
        slack = 1e-12 + 1e-9 * (right[-1] - left[-1])
        outside = ~((wanted >= left[-1] - slack) & (wanted <= right[-1] + slack))
        if outside.any():
            bad = wanted.flat[int(np.argmax(outside))]
            allowed = f"allowed: {1e3 * left[-1]:.6g} to {1e3 * right[-1]:.6g} mm"
            raise self._fault(f"there is no point at u = {1e3 * bad:.6g} mm; {allowed}")
        k_right = np.clip(np.searchsorted(right, wanted, side="left"), 1, max(right.size - 1, 1))
        k_left = np.clip(np.searchsorted(-left, -wanted, side="left"), 1, max(left.size - 1, 1))
        i = np.where(wanted >= self.u[start], start + k_right - 1, start - k_left)
        i = np.clip(i, 0, self.u.size - 2)
        return self.root_in_interval(0, wanted, i)

    def root_in_interval(self, axis: int, wanted: Array, i: NDArray[np.intp]) -> Array:
        """Arclength in interval i where coordinate `axis` is `wanted`: bisection bracketing Newton's steps."""
        lo, hi = self.arclength[i].copy(), self.arclength[i + 1].copy()
        x = (self.u, self.w)[axis]
        rising = np.where(x[i + 1] >= x[i], 1.0, -1.0)
        L = 0.5 * (lo + hi)
        for _ in range(80):
            r, v = self._evaluate(L, 0, 1)
            error = (r[..., axis] - wanted) * rising
            lo, hi = np.where(error <= 0.0, L, lo), np.where(error >= 0.0, L, hi)
            speed = v[..., axis] * rising
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = L - error / speed
            good = np.isfinite(newton) & (newton >= lo) & (newton <= hi)
            new = np.where(good, newton, 0.5 * (lo + hi))
            if (np.abs(new - L) <= 1e-16).all():
                return new
            L = new
        return L

    @cached_property
    def top_node(self) -> int:
        """Node at the top of a rail's head."""
        return int(np.argmax(np.where(self.arclength >= self.head, self.w, -np.inf)))

    @cached_property
    def top_arclength(self) -> float:
        """Arclength of the highest point, of a rail that of its head, m."""
        i = self.top_node
        lo, hi = self.arclength[max(i - 1, 0)], self.arclength[min(i + 1, self.u.size - 1)]

        def climb(L: float) -> float:
            return float(self._evaluate(L, 1)[0][1])

        if not climb(lo) > 0.0 > climb(hi):
            return float(self.arclength[i])
        while lo < (middle := 0.5 * (lo + hi)) < hi:  # scipy takes longer to import
            lo, hi = (middle, hi) if climb(middle) > 0.0 else (lo, middle)
        return float(middle)

    @cached_property
    def top(self) -> tuple[float, float]:
        """Highest point (u, w), m."""
        return self._point(self.top_arclength)

    def _point(self, L: float | Array) -> tuple[float, float]:
        u, w = self.at(L)
        return float(u), float(w)

    def gauge_point(self, depth: float | None = None) -> tuple[float, float]:
        """Point (u, w) of a rail's gauge side, ``depth`` below its top (`gauge_depth` by default), m."""
        return self._point(self.gauge_arclength(depth))

    def gauge_arclength(self, depth: float | None = None) -> Array:
        """Arclength of the gauge point, m. Raises InputError where there is none."""
        depth = self.gauge_depth if depth is None else depth
        if self.kind != "rail":
            raise self._fault(f"is of a {self.kind}; only rails have a gauge point")
        level = self.top[1] - depth
        below = np.flatnonzero((self.w <= level) & (self.arclength < self.top_arclength))
        if not depth > 0.0 or not below.size:
            reach = self.top[1] - self.w[self.arclength <= self.top_arclength].min()
            deep = f"its gauge side (negative u) goes {1e3 * reach:.4g} mm deep"
            raise self._fault(f"no gauge point {1e3 * depth:g} mm below the top; {deep}")
        return self.root_in_interval(1, np.array(level), np.array(below[-1]))

    def shifted(self, du: float = 0.0, dw: float = 0.0) -> Profile:
        """Moved by du outward and dw up, m."""
        return replace(self, u=self.u + du, w=self.w + dw)

    def rotated(self, angle: float) -> Profile:
        """Turned about the origin by `angle` in rad, positive from u towards w (top towards negative u)."""
        c, s = np.cos(angle), np.sin(angle)
        return replace(self, u=c * self.u - s * self.w, w=s * self.u + c * self.w, angle=self.angle + angle)

    def inclined(self, slope: float) -> Profile:
        """Rail inclined towards the track centre (negative u) by atan(slope), slope e.g. 1/40. Raises InputError for
        more than 1."""
        if not abs(slope) <= 1.0:
            raise self._fault(f"slope = {slope:g}: must be from -1 to 1, such as 1 / 40")
        return self.rotated(float(np.arctan(slope)))

    def mirrored(self) -> Profile:
        """Mirrored about u = 0; L again runs towards increasing u."""
        return replace(
            self,
            head=0.0,
            arclength=self.length - self.arclength[::-1],
            u=-self.u[::-1],
            w=self.w[::-1],
            angle=-self.angle[::-1],
            curvature_before=self.curvature_after[::-1],
            curvature_after=self.curvature_before[::-1],
        )

    def clipped(self, first: float, last: float) -> Profile:
        """The piece between arclengths `first` and `last`, m; see `arclength_of` to cut at a given u."""
        if not -1e-12 <= first < last <= self.length + 1e-12:
            allowed = f"allowed: rising, within 0 to {1e3 * self.length:g} mm"
            raise self._fault(f"clip from {1e3 * first:g} to {1e3 * last:g} mm of arclength; {allowed}")
        ends = np.clip([first, last], 0.0, self.length)
        # An end within a nanometre of a node is that node: tiny intervals would spoil the quintics.
        inner = (self.arclength > ends[0] + 1e-9) & (self.arclength < ends[1] - 1e-9)
        bends = self.curvature(ends)
        if ends[1] >= self.length:
            bends[1] = self.curvature_before[-1]
        at_ends = zip(CURVE, (ends, *self.at(ends), self.slope_angle(ends), bends, bends), strict=True)
        arrays: dict[str, Any] = {f: np.concatenate([x[:1], getattr(self, f)[inner], x[1:]]) for f, x in at_ends}
        arrays["arclength"] = arrays["arclength"] - ends[0]
        return replace(self, **arrays, head=max(self.head - float(ends[0]), 0.0))

    def preceded(self, before: Profile) -> Profile:
        """With another curve before its first point, which ends there with the same tangent."""
        last = before.u.size - 1
        arrays: dict[str, Any] = {name: np.append(getattr(before, name)[:-1], getattr(self, name)) for name in CURVE}
        arrays["arclength"][last:] += before.length
        arrays["curvature_before"][last] = before.curvature_before[-1]
        return replace(self, **arrays, head=self.head + before.length)
