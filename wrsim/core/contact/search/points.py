"""Search for the main contact points of a wheel outline and a rail profile.

The rail carries a field of signed distances (negative inside the steel) with the arclength of the nearest rail
point. The outline of the wheel is followed node by node; because a distance changes by no more than the way walked,
most of the outline is skipped. Near the rail the slope of the distance along the outline, t_w . n_r, tells how far the
next step may go. Each change of its sign from minus to plus is a local minimum of the distance, found to round-off by
Newton's method: a place where the connecting vector is parallel to both normals [S 13-15]. Distances are measured along
normals throughout, so a vertical rail side is as good as the crown.
"""

from math import sqrt

from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.profile import profile_point
from wrsim.core.contact.search.locus import LARGEST_SINE, locus_node, locus_point

FIELD_ERROR = 1e-5  # of the field's interpolation, generously [m]
NEAR = 5e-5  # estimated least distance below which contact is looked for exactly [m]
FAR = 5e-3  # distance beyond which the slope is not worth computing [m]
STRETCH = 1.2  # the outline is at most this much longer than the profile where abs(sine) < STEEP
STEEP = 0.1  # on steeper parts of a yawed wheel nothing is skipped
YAW_HOLLOWS = 0.03  # yaw that makes the hollow parts of the outline about twice as hollow as the profile [rad]
MARGIN = 5.5e-3  # the field reaches at least this far beyond the rail [m]


@inlined
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


@inlined
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


@kernel
def refine(wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q, lo, hi, arc, foot, sign):
    """A stationary point of the distance between two wheel arclengths: safeguarded Newton on its slope.

    arc, foot: first guess on wheel and rail; sign: +1 for a minimum (slope negative at ``lo``), -1 for a maximum.
    Returns (wheel arclength, rail arclength, distance, relative curvature, status): status 0 converged, 1 not.
    """
    distance = 0.0
    relative = 0.0
    status = 1
    projections = 3  # the first guess of the foot may be far off; later ones are foretold
    last = 1.0  # length of the last step
    for _ in range(60):
        _x, o, b, no, nb, shrink, _rt, k2 = locus_point(wheel, wheel_step, radius, ox, oo, ob, et, eo, eb, q, arc)
        foot, distance, ro, rb, k_rail = project(rail, rail_step, o, b, foot, projections)
        projections = 1
        slope = -nb * ro + no * rb  # wheel tangent (-nb, no) times rail normal
        cosine = -(no * ro + nb * rb)
        relative = shrink * k2 - k_rail
        if sign * slope < 0.0:
            lo = arc
        else:
            hi = arc
        lean = max(1.0 - k_rail * distance, 0.2)
        rate = k2 * cosine - k_rail * cosine * cosine / (lean * shrink)
        step = -slope / rate if sign * rate > 0.0 else 2.0 * (hi - lo)
        if abs(step) < 1e-11 or hi - lo < 1e-12:
            foot, distance, ro, rb, k_rail = project(rail, rail_step, o, b, foot, 1)
            status = 0
            break
        new = arc + step
        # beside a join of arcs the rate may be off by half and Newton's steps swing to and fro
        if new <= lo or new >= hi or abs(step) > 0.5 * last:
            new = 0.5 * (lo + hi)
        last = abs(new - arc)
        foot += (new - arc) * cosine / (lean * shrink)
        arc = new
    return arc, foot, distance, relative, status


# columns of a row of ``found``
WHEEL_ARC, RAIL_ARC, DEPTH, RELATIVE_CURVATURE, SADDLE_DEPTH, SADDLE_RAIL_ARC = range(6)
FOUND_COLUMNS = 6


@inlined
def _rail_slope(rail, rail_step, foot, no, nb):
    """Slope of the distance along a wheel outline with normal (no, nb) over the rail point ``foot``."""
    x = foot / rail_step
    i = min(max(int(x), 0), rail.shape[0] - 2)
    r = x - i
    tu = rail[i, 2] + r * (rail[i + 1, 2] - rail[i, 2])
    tw = rail[i, 3] + r * (rail[i + 1, 3] - rail[i, 3])
    return nb * tw + no * tu  # wheel tangent (-nb, no) times rail normal (-tw, tu)


@kernel
def find_contacts(
    wheel, wheel_step, radius, rail, rail_step, field, o0, b0, spacing, ox, oo, ob, et, eo, eb, stride, hollow, found
):
    """All local maxima of the interpenetration, in order along the wheel profile.

    stride: nodes between two samples near the rail; hollow: largest concave curvatures of both bodies together [1/m].
    found: (n, FOUND_COLUMNS) array that receives per contact the wheel and rail arclength, the penetration
    (positive), the relative curvature, and the least penetration between this contact and the next with its rail
    arclength (-1 where the profiles separate in between).
    Returns (number found, smallest distance met, status): status bit 1 says a point was not refined to round-off.
    """
    q = sqrt(1.0 - et * et)
    n = wheel.shape[0]
    count = 0
    closest = 1.0
    status = 0
    near = False  # whether the last sample was one stride ago
    linked = False  # whether the outline stayed in the rail since the last contact found
    last_node = -stride
    last_slope = 0.0
    last_distance = 0.0
    rail_end = (rail.shape[0] - 1) * rail_step
    per_node = 1.0 / (STRETCH * wheel_step)
    hollow *= 1.0 + (et / YAW_HOLLOWS) ** 2
    wary = 0  # no skips before this node
    node = 0
    while node < n:
        o, b, no, nb, sine = locus_node(wheel, node, radius, oo, ob, et, eo, eb, q)
        if abs(sine) >= LARGEST_SINE:
            near = False
            linked = False
            node += stride
            continue
        distance, foot = field_distance(field, o0, b0, spacing, o, b)
        if distance < FIELD_ERROR and not near and node - stride > last_node:
            # a skip has ended inside the rail: the outline was longer than thought; back, and step by step
            wary = node
            node = last_node + stride
            near = True
            continue
        closest = min(closest, distance)
        calm = node >= wary and abs(sine) < STEEP
        if distance > FAR or foot <= 0.0 or foot >= rail_end:
            # far away, or beside an end of the rail, where the distance bends as it likes: no more than the way
            near = False
            linked = False
            last_node = node
            skip = int((distance - FIELD_ERROR) * per_node)
            node += skip if calm and skip > stride else stride
            continue
        slope = _rail_slope(rail, rail_step, foot, no, nb)
        turns = near and (slope < 0.0) != (last_slope < 0.0)
        if turns:
            # the parabola's vertex between the two samples says whether a closer look is worth it
            length = stride * wheel_step
            turns = last_distance - 0.5 * length * last_slope * last_slope / (slope - last_slope) < NEAR
        if turns and last_slope < 0.0:
            arc, foot_at, depth, relative, state = refine(
                wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q,
                (last_node - stride) * wheel_step, (node + stride) * wheel_step,
                (node - stride * slope / (slope - last_slope)) * wheel_step, foot, 1.0,
            )  # fmt: skip
            closest = min(closest, depth)
            if depth < 0.0 and 0.0 < foot_at < rail_end and count < found.shape[0]:
                status |= state
                if count > 0 and not linked:
                    found[count - 1, SADDLE_DEPTH] = -1.0
                found[count, WHEEL_ARC] = arc
                found[count, RAIL_ARC] = foot_at
                found[count, DEPTH] = -depth
                found[count, RELATIVE_CURVATURE] = relative
                found[count, SADDLE_DEPTH] = -1.0
                count += 1
                linked = True
        elif turns and linked:
            _arc, foot_at, depth, _relative, state = refine(
                wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q,
                (last_node - stride) * wheel_step, (node + stride) * wheel_step,
                (node - stride * slope / (slope - last_slope)) * wheel_step, foot, -1.0,
            )  # fmt: skip
            if depth < 0.0:
                found[count - 1, SADDLE_DEPTH] = -depth
                found[count - 1, SADDLE_RAIL_ARC] = foot_at
            else:
                linked = False
        last_node = node
        last_slope = slope
        last_distance = distance
        near = True
        clear = distance - FIELD_ERROR
        if clear > 0.0:
            # the distance bends down by no more than both bodies are hollow: the first place where it can vanish
            linked = False
            skip = int((slope + sqrt(slope * slope + 2.0 * hollow * clear)) / hollow * per_node)
            if calm and skip > stride:
                near = False
                node += skip
                continue
        node += stride
    if count > 0:
        found[count - 1, SADDLE_DEPTH] = -1.0
    return count, closest, status
