"""One wheel on one rail: from a pose and a motion to forces, all stages in one call.

Everything is in rail axes (t, o, b): along the rail, outward, up; origin at the rail's profile origin beside the
wheel. On the right side these axes are left-handed; a mirrored angular velocity (sign changed once more) makes every
formula hold as it stands, so the kernel knows no side.
"""

from math import atan2, ceil, sqrt

from numba import njit

from wrsim.core.fastsim import fastsim, flexibilities
from wrsim.core.kik_piotrowski import kik_piotrowski
from wrsim.core.patch import DS, ETA, FORCE, FX, FY, MZ, NB, NO, PHI, XI, A, B, O, S, X, find_edge, lay_strips
from wrsim.core.search import find_contacts

# settings[...]
(
    MODULUS, SHEAR_MODULUS, EPSILON, PROJECTED, DAMPING, FRICTION, PARABOLIC, STRIPS, STRIP_WIDTH, TANGENTIAL,
    LEAST_SPEED, MAX_PATCHES, WHEEL_STEP, RADIUS, RAIL_STEP, FIELD_O, FIELD_B, FIELD_SPACING, STRIDE,
) = range(19)  # fmt: skip
SETTINGS = 19

# pose[...]: profile origin on the axle, axle outward, velocity of the origin, angular velocity
POSE = 12

# columns of a patch's row
(
    N, FX_SUM, FY_SUM, SPIN_MOMENT, P0, AREA, APPROACH, ANGLE, ANGLE_MIN, ANGLE_MAX, ANGLE_MEAN, N_STRIPS, LENGTH,
    WIDTH, XI_MAIN, ETA_MAIN, PHI_MAIN, ARC_WHEEL, ARC_RAIL, X_MAIN, O_MAIN, B_MAIN, NO_MAIN, NB_MAIN, DISSIPATION,
    EDGE_STATUS,
) = range(26)  # fmt: skip
PATCH_COLUMNS = 26

# total[...]: force and moment about the profile origin on the wheel, number of patches, wear number, closest distance
FORCE_T, FORCE_O, FORCE_B, MOMENT_T, MOMENT_O, MOMENT_B, COUNT, WEAR, CLOSEST = range(9)
TOTAL = 9

STATUS_NOT_REFINED = 1
STATUS_PROFILE_END = 2
STATUS_TOO_DEEP = 4

DEEPEST = 3e-3  # approach beyond which the state is called an overlap, not a contact [m]
WIDEST = 0.08  # half width at which the search for an edge is given up [m]


@njit(cache=True)
def wheel_rail(wheel, rail, field, creep, shape, settings, pose, found, patches, strips, work, total):
    """Contact of one wheel and one rail.

    wheel, rail: profile tables (see core.profile), the rail's in (o, b) with its inclination; field: signed distances
    of the rail; creep: (20, 3) Kalker coefficients; shape: bound over the cells; settings: (SETTINGS,); pose: (POSE,).
    found: (>= 4, 4) and work: (9, >= strips) scratch. Writes patches (max_patches, PATCH_COLUMNS), strips
    (max_patches, n, STRIP_COLUMNS) and total (TOTAL,). Forces act on the wheel.
    Returns a status: 0, or a sum of the STATUS bits.
    """
    ox, oo, ob = pose[0], pose[1], pose[2]
    et, eo, eb = pose[3], pose[4], pose[5]
    vt, vo, vb = pose[6], pose[7], pose[8]
    wt, wo, wb = pose[9], pose[10], pose[11]
    wheel_step, radius, rail_step = settings[WHEEL_STEP], settings[RADIUS], settings[RAIL_STEP]
    eps = settings[EPSILON]
    projected = settings[PROJECTED] > 0.5
    for i in range(TOTAL):
        total[i] = 0.0
    q = sqrt(1.0 - et * et)
    count, closest, status = find_contacts(
        wheel, wheel_step, radius, rail, rail_step, field, settings[FIELD_O], settings[FIELD_B],
        settings[FIELD_SPACING], ox, oo, ob, et, eo, eb, int(settings[STRIDE]), found,
    )  # fmt: skip
    total[CLOSEST] = closest
    rolling = sqrt(vt * vt + settings[LEAST_SPEED] * settings[LEAST_SPEED])
    most = int(settings[MAX_PATCHES])
    made = 0
    for c in range(count):
        if made == most:
            break
        wheel_arc, rail_arc, delta, relative = found[c, 0], found[c, 1], found[c, 2], found[c, 3]
        # a shallower minimum that lies on a patch already made belongs to it: the virtual penetrations overlap
        merged = False
        for p in range(made):
            first = patches[p, ARC_RAIL] + strips[p, 0, S] - 0.5 * strips[p, 0, DS]
            last_strip = int(patches[p, N_STRIPS]) - 1
            last = patches[p, ARC_RAIL] + strips[p, last_strip, S] + 0.5 * strips[p, last_strip, DS]
            if first <= rail_arc <= last:
                merged = True
        if merged:
            continue
        patch = patches[made]
        rows = strips[made]
        n, state = _one_patch(
            wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q, wheel_arc, rail_arc, delta,
            relative, eps, projected, settings, patch, rows,
        )  # fmt: skip
        status |= state
        if n == 0:
            continue
        _load_patch(
            n, delta, eps, creep, shape, settings, vt, vo, vb, wt, wo, wb, ox, oo, ob, rolling, patch, rows, work, total
        )
        made += 1
    total[COUNT] = made
    return status


@njit(cache=True)
def _one_patch(
    wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q, wheel_arc, rail_arc, delta, relative, eps,
    projected, settings, patch, rows,
):  # fmt: skip
    """Geometry of one patch: edges and strips. Returns (number of strips, status bits)."""
    status = STATUS_TOO_DEEP if delta > DEEPEST else 0
    n0o, n0b = _rail_normal(rail, rail_step, rail_arc)
    # first step: a third of the half width that the relative curvature at the main point promises
    first = 0.35 * sqrt(2.0 * eps * delta / max(relative, 0.5))
    first = min(max(first, 2e-5), 4e-3)
    end, state = find_edge(
        wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q,
        wheel_arc, rail_arc, delta, n0o, n0b, eps, projected, first, 1, WIDEST,
    )  # fmt: skip
    if state:
        status |= STATUS_PROFILE_END
    start, state = find_edge(
        wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q,
        wheel_arc, rail_arc, delta, n0o, n0b, eps, projected, first, -1, WIDEST,
    )  # fmt: skip
    if state:
        status |= STATUS_PROFILE_END
    n = int(settings[STRIPS])
    if settings[STRIP_WIDTH] > 0.0:
        n = int(ceil((end - start) / settings[STRIP_WIDTH]))
    n = min(max(n, 3), rows.shape[0])
    half_length, k_t = lay_strips(
        wheel, wheel_step, radius, rail, rail_step, ox, oo, ob, et, eo, eb, q,
        wheel_arc, rail_arc, delta, n0o, n0b, eps, projected, start, end, n, rows,
    )  # fmt: skip
    patch[APPROACH] = delta
    patch[N_STRIPS] = n
    patch[WIDTH] = end - start
    patch[ARC_WHEEL] = wheel_arc
    patch[ARC_RAIL] = rail_arc
    patch[NO_MAIN] = n0o
    patch[NB_MAIN] = n0b
    patch[LENGTH] = 2.0 * half_length
    patch[EDGE_STATUS] = status
    main = min(max(int(-start / ((end - start) / n)), 0), n - 1)
    # the main point lies within its strip: its coordinates follow along the strip's tangent
    row = rows[main]
    lag = row[S]
    patch[X_MAIN] = row[X]
    if n > 1:
        other = rows[main - 1] if main > 0 else rows[main + 1]
        patch[X_MAIN] = row[X] - lag * (row[X] - other[X]) / (row[S] - other[S])
    patch[O_MAIN] = row[O] - lag * row[NB]
    patch[B_MAIN] = row[B] + lag * row[NO]
    return n, status


@njit(cache=True)
def _rail_normal(rail, rail_step, arc):
    from_table = arc / rail_step
    i = min(max(int(from_table), 0), rail.shape[0] - 2)
    r = from_table - i
    tu = rail[i, 2] + r * (rail[i + 1, 2] - rail[i, 2])
    tw = rail[i, 3] + r * (rail[i + 1, 3] - rail[i, 3])
    inverse = 1.0 / sqrt(tu * tu + tw * tw)
    return -tw * inverse, tu * inverse


@njit(cache=True)
def _load_patch(
    n, delta, eps, creep, shape, settings, vt, vo, vb, wt, wo, wb, ox, oo, ob, rolling, patch, rows, work, total
):
    """Pressure, creep forces and resultants of one patch whose strips are laid."""
    n0o, n0b = patch[NO_MAIN], patch[NB_MAIN]
    mx, mo, mb = patch[X_MAIN] - ox, patch[O_MAIN] - oo, patch[B_MAIN] - ob
    # velocity of the wheel's material at the main point; the rail rests
    ut = vt + wo * mb - wb * mo
    uo = vo + wb * mx - wt * mb
    ub = vb + wt * mo - wo * mx
    closing = -(uo * n0o + ub * n0b)
    factor = max(1.0 + settings[DAMPING] * closing, 0.0)
    p0, normal, area = kik_piotrowski(rows, n, delta, 0.5 * patch[LENGTH], settings[MODULUS], factor)
    patch[P0] = p0
    patch[N] = normal
    patch[AREA] = area
    patch[XI_MAIN] = ut / rolling
    patch[ETA_MAIN] = (uo * n0b - ub * n0o) / rolling
    patch[PHI_MAIN] = (wo * n0o + wb * n0b) / rolling
    longest = 0.0
    for i in range(n):
        row = rows[i]
        rx, ro, rb = row[X] - ox, row[O] - oo, row[B] - ob
        row[XI] = (vt + wo * rb - wb * ro) / rolling
        row[ETA] = ((vo + wb * rx - wt * rb) * row[NB] - (vb + wt * ro - wo * rx) * row[NO]) / rolling
        row[PHI] = (wo * row[NO] + wb * row[NB]) / rolling
        longest = max(longest, row[A])
        row[FX] = 0.0
        row[FY] = 0.0
        row[MZ] = 0.0
    patch[LENGTH] = 2.0 * longest
    if settings[TANGENTIAL] > 0.5:
        l1, l2, l3 = flexibilities(creep, 2.0 * longest / patch[WIDTH], area, settings[SHEAR_MODULUS])
        fastsim(rows, n, settings[FRICTION], settings[PARABOLIC] > 0.5, l1, l2, l3,
                1.0 if vt >= 0.0 else -1.0, shape, work)
    _sum_patch(n, ox, oo, ob, patch, rows, total)


@njit(cache=True)
def _sum_patch(n, ox, oo, ob, patch, rows, total):
    """Add the strips' forces to the wheel's total, at the strip centres, and to the patch's own figures."""
    ft = fo = fb = mt = mo = mb = 0.0
    sum_x = sum_y = wear = angle_mean = 0.0
    least = 4.0
    most = -4.0
    normal_sum = 0.0
    for i in range(n):
        row = rows[i]
        f, fx, fy, mz = row[FORCE], row[FX], row[FY], row[MZ]
        no, nb = row[NO], row[NB]
        so = f * no + fy * nb
        sb = f * nb - fy * no
        rx, ro, rb = row[X] - ox, row[O] - oo, row[B] - ob
        ft += fx
        fo += so
        fb += sb
        mt += ro * sb - rb * so
        mo += rb * fx - rx * sb + mz * no
        mb += rx * so - ro * fx + mz * nb
        sum_x += fx
        sum_y += fy
        wear -= fx * row[XI] + fy * row[ETA] + mz * row[PHI]
        angle = atan2(-no, nb)
        least = min(least, angle)
        most = max(most, angle)
        angle_mean += f * angle
        normal_sum += f
    patch[FX_SUM] = sum_x
    patch[FY_SUM] = sum_y
    patch[ANGLE] = atan2(-patch[NO_MAIN], patch[NB_MAIN])
    patch[ANGLE_MIN] = least
    patch[ANGLE_MAX] = most
    patch[ANGLE_MEAN] = angle_mean / normal_sum if normal_sum > 0.0 else patch[ANGLE]
    patch[DISSIPATION] = wear
    # moment of the creep forces about the normal at the main point
    n0o, n0b = patch[NO_MAIN], patch[NB_MAIN]
    spin = 0.0
    for i in range(n):
        row = rows[i]
        fx, fy, mz = row[FX], row[FY], row[MZ]
        rx, ro, rb = row[X] - patch[X_MAIN], row[O] - patch[O_MAIN], row[B] - patch[B_MAIN]
        so = fy * row[NB]
        sb = -fy * row[NO]
        spin += (rb * fx - rx * sb + mz * row[NO]) * n0o + (rx * so - ro * fx + mz * row[NB]) * n0b
    patch[SPIN_MOMENT] = spin
    total[FORCE_T] += ft
    total[FORCE_O] += fo
    total[FORCE_B] += fb
    total[MOMENT_T] += mt
    total[MOMENT_O] += mo
    total[MOMENT_B] += mb
    total[WEAR] += wear
