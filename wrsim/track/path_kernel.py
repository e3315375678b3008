"""A space curve with a frame on it: the centre line of a track, or one swept rail [S 7-9].

A ``CurveNodes`` has n >= 2 nodes at uniform arclength from s = 0.

Between nodes the curve is the quintic Hermite polynomial of position, tangent and curvature vector, so all
three are continuous; roll is the cubic Hermite polynomial, continuous with its slope. Before the first and
behind the last node the curve continues straight along the end tangent, with the roll of that end. A heading
is never computed, so the curve may turn by any angle and pass over itself.

On arcs and clothoids away from joints the quintic is exact to rounding. Where the curvature itself jumps (no
transition), it is blended over the one row distance that holds the joint, with 5 % overshoot.

Frame: t is the unit tangent; with h = (z x t)/|z x t|, the horizontal direction to the left, and v = t x h,
n = cos(roll) h + sin(roll) v and b = -sin(roll) h + cos(roll) v. The curve must not be vertical.

Not-a-number in s or in the point gives not-a-number out; no index is ever outside the table.
"""

import math
from typing import Any

from wrsim.jit import Array, inlined, kernel, record
from wrsim.jit.frames import VECTOR, CurveNodes, Frame, put_at
from wrsim.jit.linalg import Vec, add, cross, dot, mixed, norm, scale, shifted, sub

NODE = record(
    """
    position   [m]     position
    tangent    [1]     unit tangent dr/ds
    roll       [rad]   angle of the cross-section about the tangent, positive: left side up
    roll_slope [rad/m] droll/ds
    curvature  [1/m]   curvature vector d2r/ds2
    """,
    position=VECTOR,
    tangent=VECTOR,
    curvature=VECTOR,
)

LOCATE_OK = 0
LOCATE_NOT_CONVERGED = 1  # no convergence within MAX_ITERATIONS
LOCATE_NOT_FINITE = 2  # the point or the guess is not a number

MAX_ITERATIONS = 30
MAX_STRIDE = 5.0  # largest Newton step [m]
STRIDE_TOLERANCE = 1e-9  # [m]; convergence is quadratic: the next step would be below 1e-15 m
MIN_SLOPE = 0.1  # smallest 1 - (p - r).k used: points near the centre of curvature take shorter, safe steps


@inlined
def _cell(curve: CurveNodes, s: float) -> tuple[int, float, float]:
    """First node i, local coordinate xi in [0, 1] and the distance outside of the curve (0 inside, NaN for NaN)."""
    last = curve.nodes.shape[0] - 1
    end = last * curve.step
    inside = s
    if not inside > 0.0:
        inside = 0.0
    if inside > end:
        inside = end
    q = inside / curve.step
    i = min(int(q), last - 1)
    return i, q - i, s - inside


@inlined
def _quintic(xi: float) -> tuple[float, float, float, float, float]:
    """Quintic Hermite basis for p1 - p0, h t0, h t1, h^2 k0, h^2 k1."""
    x2 = xi * xi
    x3 = x2 * xi
    return (
        x3 * (10.0 + xi * (-15.0 + 6.0 * xi)),
        xi + x3 * (-6.0 + xi * (8.0 - 3.0 * xi)),
        x3 * (-4.0 + xi * (7.0 - 3.0 * xi)),
        0.5 * x2 + 0.5 * x3 * (-3.0 + xi * (3.0 - xi)),
        0.5 * x3 * (1.0 + xi * (-2.0 + xi)),
    )


@inlined
def _quintic_slope(xi: float) -> tuple[float, float, float, float, float]:
    """First derivative of `_quintic` with respect to xi."""
    x2 = xi * xi
    y = 1.0 - xi
    return (
        30.0 * x2 * y * y,
        1.0 + x2 * (-18.0 + xi * (32.0 - 15.0 * xi)),
        x2 * (-12.0 + xi * (28.0 - 15.0 * xi)),
        xi + 0.5 * x2 * (-9.0 + xi * (12.0 - 5.0 * xi)),
        0.5 * x2 * (3.0 + xi * (-8.0 + 5.0 * xi)),
    )


@inlined
def _quintic_bend(xi: float) -> tuple[float, float, float, float, float]:
    """Second derivative of `_quintic` with respect to xi."""
    return (
        xi * (60.0 + xi * (-180.0 + 120.0 * xi)),
        xi * (-36.0 + xi * (96.0 - 60.0 * xi)),
        xi * (-24.0 + xi * (84.0 - 60.0 * xi)),
        1.0 + xi * (-9.0 + xi * (18.0 - 10.0 * xi)),
        xi * (3.0 + xi * (-12.0 + 10.0 * xi)),
    )


@inlined
def _sum(curve: CurveNodes, i: int, basis: tuple[float, float, float, float, float]) -> Vec:
    """Sum of basis times data of cell i, a vector; the constant p0 is left out."""
    start, end, h = curve.nodes[i], curve.nodes[i + 1], curve.step
    a, b, c, d, e = basis
    chord = sub(end.position, start.position)
    leaning = mixed(b, start.tangent, c, end.tangent)
    bending = mixed(d, start.curvature, e, end.curvature)
    return add(shifted(scale(a, chord), h, leaning), scale(h * h, bending))


@inlined
def _roll(curve: CurveNodes, i: int, xi: float) -> float:
    """Roll in cell i: cubic Hermite [rad]."""
    start, end = curve.nodes[i], curve.nodes[i + 1]
    x2 = xi * xi
    y = 1.0 - xi
    slopes = xi * y * y * start.roll_slope - x2 * y * end.roll_slope
    return start.roll + x2 * (3.0 - 2.0 * xi) * (end.roll - start.roll) + curve.step * slopes


@inlined
def _roll_slope(curve: CurveNodes, i: int, xi: float) -> float:
    """d(roll)/ds in cell i [rad/m]."""
    start, end = curve.nodes[i], curve.nodes[i + 1]
    return (
        6.0 * xi * (1.0 - xi) * (end.roll - start.roll) / curve.step
        + (1.0 + xi * (-4.0 + 3.0 * xi)) * start.roll_slope
        + xi * (-2.0 + 3.0 * xi) * end.roll_slope
    )


@kernel
def frame_at(curve: CurveNodes, s: float) -> Frame:
    """Position and orthonormal frame of the curve at arclength s [S 7-9]: a ``Frame``."""
    i, xi, beyond = _cell(curve, s)
    along = _sum(curve, i, _quintic_slope(xi))
    horizontal = math.sqrt(along.x * along.x + along.y * along.y)
    t = scale(1.0 / norm(along), along)
    h = Vec(-along.y / horizontal, along.x / horizontal, 0.0)
    v = cross(t, h)
    roll = _roll(curve, i, xi)
    c = math.cos(roll)
    d = math.sin(roll)
    origin = add(curve.nodes[i].position, _sum(curve, i, _quintic(xi)))
    return Frame(shifted(origin, beyond, t), t, mixed(c, h, d, v), mixed(c, v, -d, h))


@kernel
def locate(curve: CurveNodes, p: Any, s_guess: float) -> tuple[float, int]:
    """Arclength of the cross-section that holds the point p: the root of (p - r(s)).t(s) = 0 near
    ``s_guess``.

    Newton's method with the exact derivative -t.t + (p - r).k of the interpolated curve. A guess within some
    metres is enough for points nearer to the curve than its radius of curvature; the root found is the one
    next to the guess, so a closed circle may be followed turn after turn.

    Returns (s, status): status 0 converged, 1 not converged, 2 not a number.
    """
    s = s_guess
    if not math.isfinite(p.x + p.y + p.z + s):
        return s, LOCATE_NOT_FINITE
    for _ in range(MAX_ITERATIONS):
        i, xi, beyond = _cell(curve, s)
        t = scale(1.0 / curve.step, _sum(curve, i, _quintic_slope(xi)))
        d = sub(sub(p, curve.nodes[i].position), shifted(_sum(curve, i, _quintic(xi)), beyond, t))
        slope = dot(t, t)
        if beyond == 0.0:
            slope -= dot(d, _sum(curve, i, _quintic_bend(xi))) / (curve.step * curve.step)
        stride = dot(d, t) / max(slope, MIN_SLOPE)
        stride = min(max(stride, -MAX_STRIDE), MAX_STRIDE)
        s += stride
        if abs(stride) <= STRIDE_TOLERANCE:
            return s, LOCATE_OK
    return s, LOCATE_NOT_CONVERGED


@kernel
def frame_rates(curve: CurveNodes, s: float) -> tuple[Vec, float]:
    """Rotation of the frame per metre: the vector w with dt/ds = w x t, dn/ds = w x n, db/ds = w x b. A frame that
    moves along the curve at speed V turns at V w. Returns (w, droll/ds), w in global axes [rad/m]: w = psi' z -
    (theta'/cos(theta)) h + roll' t with the heading psi and sin(theta) = t_z. Zero outside of the curve."""
    i, xi, beyond = _cell(curve, s)
    if beyond != 0.0:
        zero = 0.0 * beyond
        return Vec(zero, zero, zero), zero
    along = _sum(curve, i, _quintic_slope(xi))
    t = scale(1.0 / norm(along), along)
    k = scale(1.0 / (curve.step * curve.step), _sum(curve, i, _quintic_bend(xi)))
    across = k.z - dot(k, t) * t.z  # k.t is of the order of the interpolation error
    horizontal = t.x * t.x + t.y * t.y
    psi = (t.x * k.y - t.y * k.x) / horizontal
    pitch = across / horizontal  # theta' = k_z / cos(theta); h = (-t_y, t_x, 0) / cos(theta)
    droll = _roll_slope(curve, i, xi)
    return shifted(Vec(pitch * t.y, -pitch * t.x, psi), droll, t), droll


@kernel
def bends(curve: CurveNodes, s: float, frame: Frame) -> tuple[float, float, float]:
    """How the curve turns about itself at s, positive where its left side rises [rad/m], and how it bends to the left
    and up [1/m], all zero outside; frame: that there."""
    turning, _roll = frame_rates(curve, s)
    return dot(turning, frame.t), dot(turning, frame.b), -dot(turning, frame.n)


@kernel
def frame_many(curve: CurveNodes, s: Array, out: Array) -> None:
    """`frame_at` for an array s of shape (m,); origin, t, n, b go to ``out`` of shape (m, 12)."""
    for j in range(s.shape[0]):
        frame = frame_at(curve, s[j])
        put_at(out[j], 0, frame.origin)
        put_at(out[j], 3, frame.t)
        put_at(out[j], 6, frame.n)
        put_at(out[j], 9, frame.b)
