"""Wheels out of round: the surface rho(u) - depth(u, angle), and where around its axle it is touched.

With the surface of docs/theory/out_of_round.md a straight rail touches where (oor-locus)

    f = sin(theta) - P_theta/P cos(theta) - P_u e_t/q = 0.

A round wheel has one such theta. Else there are several, of which the one farthest out along the normal of the round
wheel counts. A scan over the rows of the table finds it on columns across the profile (``branches``) for each pose;
from there Newton's method finds f = 0 at any u.

The curvature along t is a mean over the length of contact (oor-mean). Where gaps ahead and behind differ the middle
moves to the vertex of the parabola.
"""

from math import asin, atan2, cos, floor, inf, pi, sin, sqrt
from typing import NamedTuple

from wrsim.contact.records import PlacedWheel, Shape
from wrsim.contact.surfaces.profile_table import ProfilePoint
from wrsim.contact.surfaces.rail import LARGEST_SINE, MEAN_GAP
from wrsim.jit import inlined, kernel
from wrsim.jit.curves import hermite
from wrsim.jit.root import Bracket, crossing, narrowed

STEEPEST = 20.0  # slope of rho over u that is followed
LEAST = 0.1  # of a round wheel's curvature along the rail: flatter places count as that
APART = 2.0  # rows of the table between two columns' places that are not one
LEVEL = 5e-6  # below the highest row, by which one beside a higher place may lie [m]
SHORTEST, LONGEST = 2e-4, 0.06  # half length over which the curvature is a mean [m]
U, W, SLOPE, SHIFT = range(4)
"""Columns of ``branches``: place across, height of the round profile [m], its slope dw/du; theta less that of a round
wheel [rad]."""


class Depth(NamedTuple):
    """Depth [m] and its derivatives by the angle (a) and across (u)."""

    d: float
    a: float
    u: float
    aa: float
    au: float
    uu: float


class Touch(NamedTuple):
    """Where a wheel is touched: theta with sine and cosine; P, P_theta / P, P_u; derivatives of P; f_theta."""

    theta: float
    sine: float
    cosine: float
    p: float
    turn: float
    p_u: float
    aa: float
    au: float
    uu: float
    rate: float


@inlined
def _row(shape: Shape, angle: float) -> tuple[int, int, float]:
    """Numbers of the rows before and behind an angle, and the part of the way between them."""
    n = shape.rows
    x = angle * (n / (2.0 * pi))
    x -= n * floor(x / n)
    i = int(x)
    r = x - i
    i = i if i < n else 0
    return i, i + 1 if i + 1 < n else 0, r


@inlined
def _column(shape: Shape, u: float) -> tuple[int, float]:
    """Number of the column before u and the part of the way to the next; held within the table."""
    last = shape.depth.shape[0] // shape.rows - 1
    x = min(max((u - shape.first) / shape.step, 0.0), float(last))
    j = min(int(x), last - 1)
    return j, x - j


@kernel
def depth_at(shape: Shape, u: float, angle: float) -> Depth:
    """Depth at a place across [m] and an angle of the wheel [rad]."""
    table, n = shape.depth, shape.rows
    i, k, r = _row(shape, angle)
    per = n / (2.0 * pi)
    if table.shape[0] == n:
        d, a, aa = hermite(table[i, 0], table[k, 0], table[i, 1], table[k, 1], r)
        return Depth(d, a * per, 0.0, aa * per * per, 0.0, 0.0)
    j, s = _column(shape, u)
    i, k, low, high = j * n + i, j * n + k, (j + 1) * n + i, (j + 1) * n + k
    d0, a0, aa0 = hermite(table[i, 0], table[k, 0], table[i, 1], table[k, 1], r)
    d1, a1, aa1 = hermite(table[low, 0], table[high, 0], table[low, 1], table[high, 1], r)
    u0, v0, w0 = hermite(table[i, 2], table[k, 2], table[i, 3], table[k, 3], r)
    u1, v1, w1 = hermite(table[low, 2], table[high, 2], table[low, 3], table[high, 3], r)
    d, u_, uu = hermite(d0, d1, u0, u1, s)
    a, au, _ = hermite(a0, a1, v0, v1, s)
    aa, _, _ = hermite(aa0, aa1, w0, w1, s)
    inverse = 1.0 / shape.step
    return Depth(d, a * per, u_ * inverse, aa * per * per, au * per * inverse, uu * inverse * inverse)


@inlined
def _node_depth(shape: Shape, j: int, s: float, i: int) -> float:
    """Depth at row i, at the part s of the way from column j to the next."""
    table, n = shape.depth, shape.rows
    if table.shape[0] == n:
        return float(table[i, 0])
    low, high = j * n + i, (j + 1) * n + i
    return hermite(table[low, 0], table[high, 0], table[low, 2], table[high, 2], s)[0]


@inlined
def round_angle(wheel: PlacedWheel, slope: float) -> float:
    """Theta at which a round wheel of this slope drho/du is touched."""
    return asin(min(max(slope * wheel.axle.x / wheel.q, -LARGEST_SINE), LARGEST_SINE))


@kernel
def _settle(wheel: PlacedWheel, u: float, rho: float, slope: float, guess: float) -> Touch:
    """The place f = 0 (oor-locus) near a guess of theta; slope: drho/du."""
    shape = wheel.shape
    lean = wheel.axle.x / wheel.q
    h = 2.0 * pi / shape.rows
    theta, low, high = guess, -inf, inf
    step = 0.0
    for i in range(16):
        at = depth_at(shape, u, theta + shape.angle)
        s, c = sin(theta), cos(theta)
        p = rho - at.d
        inverse = 1.0 / p
        turn, p_u = -at.a * inverse, slope - at.u
        f = s - turn * c - p_u * lean
        rate = c + (at.aa * inverse + turn * turn) * c + turn * s + at.au * lean
        if i == 15 or (i > 0 and abs(step) < 1e-9):
            break
        if f > 0.0:
            high = min(high, theta)
        else:
            low = max(low, theta)
        step = min(max(-f / rate, -h), h) if rate > 0.0 else (-h if f > 0.0 else h)
        if not low < theta + step < high and -inf < low and high < inf:
            step = 0.5 * (low + high) - theta
        theta += step
    return Touch(theta, s, c, p, turn, p_u, -at.aa, -at.au, -at.uu, max(rate, LEAST * c))


@kernel
def touch(wheel: PlacedWheel, u: float, w: float, slope: float) -> Touch:
    """Where a wheel is touched at a place across; w: height of its round profile there [m], slope: dw/du."""
    columns = wheel.shape.branches
    rho, slope = wheel.radius - w, -min(max(slope, -STEEPEST), STEEPEST)
    last = columns.shape[0] - 1
    x = min(max((u - columns[0, U]) / (columns[1, U] - columns[0, U]), 0.0), float(last))
    j = min(int(x), last - 1)
    x -= j
    one, other = columns[j, SHIFT], columns[j + 1, SHIFT]
    at_round = round_angle(wheel, slope)
    if abs(one - other) < APART * 2.0 * pi / wheel.shape.rows:
        return _settle(wheel, u, rho, slope, at_round + one + x * (other - one))
    before, behind = _settle(wheel, u, rho, slope, at_round + one), _settle(wheel, u, rho, slope, at_round + other)
    first = before.p * cos(before.theta - at_round) >= behind.p * cos(behind.theta - at_round)
    return before if first else behind


@kernel
def find_branches(wheel: PlacedWheel) -> None:
    """Find for each column where around the axle it reaches farthest out."""
    shape = wheel.shape
    n = shape.rows
    h = 2.0 * pi / n
    for c in range(shape.branches.shape[0]):
        branch = shape.branches[c]
        slope = -min(max(branch[SLOPE], -STEEPEST), STEEPEST)
        u, rho = branch[U], wheel.radius - branch[W]
        at_round = round_angle(wheel, slope)
        j, s = 0, 0.0
        if shape.depth.shape[0] > n:
            j, s = _column(shape, u)
        x = (at_round + shape.angle) / h
        middle = floor(x + 0.5)
        off = middle - x
        first = int(middle - n * floor(middle / n)) % n
        # beyond this the wheel's drop is more than the depth can make good
        here = _node_depth(shape, j, s, first)
        reach = int(sqrt(2.0 * max(here - shape.least, 0.0) / rho) / h + 1.0) + 1
        reach = min(reach, n // 4)
        best, place, level = -inf, 0.0, -inf
        count = 0
        # the highest row; rows beside which none is higher; of several the one that is the highest between rows
        for look in range(3):
            if look == 2 and count == 1:
                break
            before = here_is = -inf
            for i in range(-reach - 1, reach + 2):
                d = _node_depth(shape, j, s, (first + i + n) % n)
                angle = (i + off) * h
                # rho cos to the fourth power of the angle: no cosine is needed
                two = angle * angle
                height = -d * (1.0 - 0.5 * two) - rho * two * (0.5 - two * (1.0 / 24.0))
                if look == 0:
                    level = max(level, height)
                elif here_is > before and here_is >= height and here_is > level - LEVEL:
                    if look == 1:
                        count, place = count + 1, angle - h
                    else:
                        touching = _settle(wheel, u, rho, slope, at_round + angle - h)
                        reached = touching.p * cos(touching.theta - at_round)
                        if reached > best:
                            best, place = reached, touching.theta - at_round
                before, here_is = here_is, height
        branch[SHIFT] = place


class SecondForm(NamedTuple):
    """What a wheel is along t where it is touched: second form in the directions of u and theta, P_uu; size of the
    normal d - P_theta/P d' - P_u e."""

    uu: float
    ua: float
    aa: float
    size: float


@inlined
def slope_across(at: ProfilePoint) -> float:
    """dw/du of a profile."""
    return at.tw / max(at.tu, 1e-3)


@inlined
def _bend(at: ProfilePoint) -> float:
    """Second derivative of rho over u of a profile [1/m]."""
    tu = max(at.tu, 1.0 / STEEPEST)
    return -at.k / (tu * tu * tu)


@inlined
def second_form(at: ProfilePoint, on: Touch) -> SecondForm:
    """Second fundamental form, positive where the wheel is convex, times the size of the normal."""
    size = sqrt(1.0 + on.turn * on.turn + on.p_u * on.p_u)
    return SecondForm(
        -_bend(at) - on.uu, on.turn * on.p_u - on.au, on.p * (1.0 + 2.0 * on.turn * on.turn) - on.aa, size
    )


@inlined
def gap_along(wheel: PlacedWheel, at: ProfilePoint, on: Touch, x: float) -> float:
    """How far the point at x along t from where the wheel is touched is above its surface, radially [m]."""
    along = x * wheel.axle.x
    out, ahead = on.p * on.cosine, on.p * on.sine + x * wheel.q
    d = depth_at(wheel.shape, at.u + along, atan2(ahead, out) + wheel.shape.angle).d
    here = wheel.radius - at.w - on.p
    two = ahead * ahead
    # sqrt(out^2 + ahead^2) - out without loss of digits, less the same where it is touched
    drop = two / (sqrt(out * out + two) + out) - on.p * on.sine * on.sine / (1.0 + on.cosine)
    slope = -min(max(slope_across(at), -STEEPEST), STEEPEST)
    return drop - along * (slope + 0.5 * along * _bend(at)) + d - here


@kernel
def mean_curvature(wheel: PlacedWheel, at: ProfilePoint, on: Touch, size: float) -> tuple[float, float]:
    """Curvature along t over the length of contact (oor-mean) [1/m], and how far ahead the middle of that lies [m]."""
    a = wheel.shape.averaged
    ahead, behind = gap_along(wheel, at, on, a) / size, gap_along(wheel, at, on, -a) / size
    k = max((ahead + behind) / (a * a), LEAST / (on.p * size))
    return k, min(max((behind - ahead) / (2.0 * a * k), -a), a)


@kernel
def contact_length(wheel: PlacedWheel, at: ProfilePoint, depth: float) -> float:
    """Half length at which the gaps ahead and behind sum up to ``MEAN_GAP`` of a depth [m]."""
    on = touch(wheel, at.u, at.w, slope_across(at))
    wanted = MEAN_GAP * depth * sqrt(1.0 + on.turn * on.turn + on.p_u * on.p_u)
    low, at_low, a = 0.0, wanted, SHORTEST
    while True:
        left = wanted - gap_along(wheel, at, on, a) - gap_along(wheel, at, on, -a)
        if left <= 0.0 or a >= LONGEST:
            break
        low, at_low, a = a, left, 1.3 * a
    if low == 0.0 or left > 0.0:
        return a
    bracket = Bracket(low, at_low, a, left, 0)
    for _ in range(40):
        a = crossing(bracket)
        left = wanted - gap_along(wheel, at, on, a) - gap_along(wheel, at, on, -a)
        if abs(left) < 1e-9 * wanted or bracket.hi - bracket.lo < 1e-9:
            break
        bracket = narrowed(bracket, a, left)
    return a
