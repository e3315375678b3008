"""A profile as a table over its arclength.

Rows are at uniform arclength ``step`` from L = 0; columns: u (outward), w (height), du/dL, dw/dL, curvature
(rate of the tangent angle, positive where the curve bends upwards). Position and tangent are read by cubic Hermite
interpolation, the curvature linearly; an index costs a division, no search.
"""

from typing import Any, NamedTuple

from wrsim.contact.records import ProfileTable
from wrsim.jit import inlined


class ProfilePoint(NamedTuple):
    """Point of a profile (u, w) [m], its tangent (tu, tw), its curvature k [1/m]."""

    u: float
    w: float
    tu: float
    tw: float
    k: float


@inlined
def node(profile: Any, i: int) -> ProfilePoint:
    """Row i of the table."""
    table = profile.table
    return ProfilePoint(table[i, 0], table[i, 1], table[i, 2], table[i, 3], table[i, 4])


@inlined
def length(profile: ProfileTable) -> float:
    """Arclength of the last row [m]."""
    return (profile.table.shape[0] - 1) * profile.step


@inlined
def profile_point(profile: Any, arc: float) -> ProfilePoint:
    """Point of a profile at arclength ``arc`` [m]. The tangent's length differs from 1 by the fourth power of step
    times curvature (1e-10 for 0.1 mm on 13 mm). Beyond either end the profile goes on straight."""
    step = profile.step
    last = profile.table.shape[0] - 1
    x = arc * (1.0 / step)  # the compiler takes the inverse out of loops
    if x <= 0.0 or x >= last:
        i = 0 if x <= 0.0 else last
        end = node(profile, i)
        beyond = arc - i * step
        return ProfilePoint(end.u + beyond * end.tu, end.w + beyond * end.tw, end.tu, end.tw, 0.0)
    return inner_point(profile, arc)


@inlined
def inner_point(profile: Any, arc: float) -> ProfilePoint:
    """The same between its ends, where several are read side by side."""
    x = arc * (1.0 / profile.step)
    i = min(max(int(x), 0), profile.table.shape[0] - 2)
    return between(node(profile, i), node(profile, i + 1), x - i, profile.step)


@inlined
def between(p: ProfilePoint, q: ProfilePoint, r: float, step: float) -> ProfilePoint:
    """The point at the share r of the way between two rows: cubic Hermite, the curvature linear."""
    r2 = r * r
    r3 = r2 * r
    h01 = 3.0 * r2 - 2.0 * r3
    h10 = (r3 - 2.0 * r2 + r) * step
    h11 = (r3 - r2) * step
    d01 = 6.0 * (r - r2) * (1.0 / step)
    d10 = 3.0 * r2 - 4.0 * r + 1.0
    d11 = 3.0 * r2 - 2.0 * r
    return ProfilePoint(
        p.u + h01 * (q.u - p.u) + h10 * p.tu + h11 * q.tu,
        p.w + h01 * (q.w - p.w) + h10 * p.tw + h11 * q.tw,
        d01 * (q.u - p.u) + d10 * p.tu + d11 * q.tu,
        d01 * (q.w - p.w) + d10 * p.tw + d11 * q.tw,
        p.k + r * (q.k - p.k),
    )
