"""Search for the main contact points of a wheel outline and a rail profile.

The rail carries a field of signed distances (negative inside the steel) with the arclength of the nearest rail
point. The outline of the wheel is followed node by node; because a distance changes by no more than the way walked,
most of the outline is skipped. Near the rail the foot of the perpendicular is corrected exactly, and with it the
slope of the distance along the outline, t_w . n_r. Each change of sign from minus to plus is a local minimum of the
distance: a place where the connecting vector is parallel to both normals [S 13-15]. Distances are measured along
normals throughout, so a vertical rail side is as good as the crown.
"""

from math import sqrt

from numba import njit

from wrsim.core.locus import locus_node, locus_point
from wrsim.core.profile import profile_point

NEAR = 0.5e-3  # distance below which the foot point is computed exactly [m]
MARGIN = 1e-3  # the field reaches at least this far beyond the rail [m]


@njit(cache=True)
def field_distance(field, o0, b0, spacing, o, b):
    """(signed distance, arclength of the nearest rail point) by bilinear interpolation of the field.

    field: (n_o, n_b, 2) on a square grid from (o0, b0). Outside the grid a lower bound stands for the distance.
    """
    x = (o - o0) / spacing
    y = (b - b0) / spacing
    nx = field.shape[0] - 1
    ny = field.shape[1] - 1
    if x < 0.0 or y < 0.0 or x >= nx or y >= ny:
        outside = max(max(-x, x - nx), max(-y, y - ny))
        return outside * spacing + MARGIN, 0.0
    i = int(x)
    j = int(y)
    x -= i
    y -= j
    w00 = (1.0 - x) * (1.0 - y)
    w10 = x * (1.0 - y)
    w01 = (1.0 - x) * y
    w11 = x * y
    distance = w00 * field[i, j, 0] + w10 * field[i + 1, j, 0] + w01 * field[i, j + 1, 0] + w11 * field[i + 1, j + 1, 0]
    foot = w00 * field[i, j, 1] + w10 * field[i + 1, j, 1] + w01 * field[i, j + 1, 1] + w11 * field[i + 1, j + 1, 1]
    return distance, foot


@njit(cache=True)
def project(rail, rail_step, o, b, arc, steps):
    """Foot of the perpendicular from (o, b) on the rail by ``steps`` Newton steps from ``arc``.

    Returns (arc, distance along the rail normal, normal_o, normal_b, rail curvature).
    """
    distance = 0.0
    no = 0.0
    nb = 1.0
    k = 0.0
    for i in range(steps + 1):
        u, w, tu, tw, k = profile_point(rail, rail_step, arc)
        no = -tw
        nb = tu
        du = o - u
        dw = b - w
        distance = du * no + dw * nb
        if i == steps:
            break
        tangential = du * tu + dw * tw
        denominator = 1.0 - k * distance
        if denominator < 0.2:
            denominator = 0.2
        arc += tangential / denominator
    return arc, distance, no, nb, k


@njit(cache=True)
def refine(wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q, lo, hi, foot):
    """The minimum of the distance between two wheel arclengths: safeguarded Newton on its slope.

    Returns (wheel arclength, rail arclength, distance, relative curvature, status): status 0 converged, 1 not.
    """
    arc = 0.5 * (lo + hi)
    distance = 0.0
    relative = 0.0
    status = 1
    for _ in range(60):
        _x, o, b, no, nb, stretch, _kt, k_outline = locus_point(
            wheel, wheel_step, radius, ox, oo, ob, et, eo, eb, q, arc
        )
        foot, distance, ro, rb, k_rail = project(rail, rail_step, o, b, foot, 2)
        slope = -nb * ro + no * rb  # wheel tangent (-nb, no) times rail normal
        cosine = -(no * ro + nb * rb)
        relative = k_outline - k_rail
        if slope < 0.0:
            lo = arc
        else:
            hi = arc
        lean = 1.0 - k_rail * distance
        rate = stretch * (k_outline * cosine - k_rail * cosine * cosine / max(lean, 0.2))
        step = -slope / rate if rate > 0.0 else 2.0 * (hi - lo)
        new = arc + step
        if abs(step) < 1e-13:
            status = 0
            break
        if new <= lo or new >= hi:
            new = 0.5 * (lo + hi)
        if hi - lo < 1e-13:
            status = 0
            break
        arc = new
    return arc, foot, distance, relative, status


@njit(cache=True)
def find_contacts(
    wheel, wheel_step, radius, rail, rail_step, field, o0, b0, spacing, ox, oo, ob, et, eo, eb, stride, found
):
    """All local minima of the distance that interpenetrate, deepest first.

    stride: nodes between two samples near the rail. found: (n, 4) array that receives wheel arclength, rail
    arclength, penetration (positive) and relative curvature [m, m, m, 1/m].
    Returns (number found, smallest distance met, status): status bit 1 says a minimum was not refined to round-off.
    """
    q = sqrt(1.0 - et * et)
    n = wheel.shape[0]
    count = 0
    closest = 1.0
    status = 0
    previous = -1  # node of the last exact sample, if the one before this
    previous_slope = 0.0
    reach = stride * wheel_step
    rail_end = (rail.shape[0] - 1) * rail_step
    node = 0
    while node < n:
        o, b, no, nb, proper = locus_node(wheel, node, radius, oo, ob, et, eo, eb, q)
        if not proper:
            previous = -1
            node += stride
            continue
        distance, foot = field_distance(field, o0, b0, spacing, o, b)
        if distance > NEAR + reach:
            closest = min(closest, distance)
            previous = -1
            node += max(stride, int((distance - NEAR) / (1.2 * wheel_step)))
            continue
        foot, distance, ro, rb, _k = project(rail, rail_step, o, b, foot, 1)
        closest = min(closest, distance)
        slope = -nb * ro + no * rb
        if previous >= 0 and previous_slope < 0.0 and slope >= 0.0 and 0.0 < foot < rail_end:
            arc, foot_at, depth, relative, state = refine(
                wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q,
                previous * wheel_step, node * wheel_step, foot,
            )  # fmt: skip
            closest = min(closest, depth)
            if depth < 0.0 and 0.0 < foot_at < rail_end:
                status |= state
                # insertion sort by depth; the shallowest falls out when the list is full
                at = count
                if count < found.shape[0]:
                    count += 1
                elif found[count - 1, 2] >= -depth:
                    at = -1
                else:
                    at = count - 1
                if at >= 0:
                    while at > 0 and found[at - 1, 2] < -depth:
                        for c in range(4):
                            found[at, c] = found[at - 1, c]
                        at -= 1
                    found[at, 0] = arc
                    found[at, 1] = foot_at
                    found[at, 2] = -depth
                    found[at, 3] = relative
        previous = node
        previous_slope = slope
        node += stride
    return count, closest, status
