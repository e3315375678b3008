"""One wheel on one rail: from a pose and a motion to forces, all stages in one call.

Everything is in rail axes (t, o, b): along the rail, outward, up; origin at the rail's profile origin beside the
wheel. On the right side these axes are left-handed; a mirrored angular velocity (sign changed once more) makes every
formula hold as it stands, so the kernel knows no side.
"""

from math import ceil, pi, sqrt

from wrsim.core.compiling import kernel
from wrsim.core.contact.layout import (
    AMPLITUDE,
    APPROACH,
    ARC_RAIL,
    ARC_WHEEL,
    AREA,
    B_MAIN,
    CLOSEST,
    CLOSING,
    COUNT,
    COUPLING,
    DAMPING,
    END,
    EPSILON,
    FIELD_B,
    FIELD_O,
    FIELD_SPACING,
    GROUP,
    HALF_LENGTH,
    HOLLOW,
    LENGTH,
    MODULUS,
    N_STRIPS,
    NB,
    NB_MAIN,
    NO,
    NO_MAIN,
    O_MAIN,
    P0,
    PARTNER,
    PATCHES,
    PROJECTED,
    RADIUS,
    RAIL_STEP,
    RECESS,
    START,
    STATUS_PROFILE_END,
    STATUS_TOO_DEEP,
    STRIDE,
    STRIP_MODEL,
    STRIP_WIDTH,
    STRIPS,
    TANGENTIAL,
    TOTAL,
    WHEEL_STEP,
    WIDTH,
    X_MAIN,
    B,
    N,
    O,
    S,
    X,
)  # fmt: skip
from wrsim.core.contact.normal.kik_piotrowski import far_influence, own_influence, set_pressures, solve_amplitudes
from wrsim.core.contact.patch import find_edge, lay_strips
from wrsim.core.contact.profile import profile_point
from wrsim.core.contact.resultants import add_lobe, set_creepages
from wrsim.core.contact.search.lobes import couple, select_deepest
from wrsim.core.contact.search.points import (
    DEPTH,
    RAIL_ARC,
    RELATIVE_CURVATURE,
    SADDLE_DEPTH,
    SADDLE_RAIL_ARC,
    WHEEL_ARC,
    find_contacts,
)
from wrsim.core.contact.strips.layout import FEWEST_FREE_STRIPS
from wrsim.core.contact.strips.pressure import press_strips
from wrsim.core.contact.tangential.creep_forces import creep_forces

DEEPEST = 3e-3  # approach beyond which the state is called an overlap, not a contact [m]
WIDEST = 0.08  # half width at which the search for an edge is given up [m]
FEWEST_STRIPS = 3
WITHIN = 0.2  # the strip model looks for contact where the penetration is more than this part of the lobe's


@kernel
def wheel_rail(
    wheel, rail, field, creep, shape, settings, pose, found, patches, strips, work, vectors, matrices, total
):
    """Contact of one wheel and one rail.

    wheel, rail: profile tables (see core.contact.profile), the rail's in (o, b) with its inclination; field: signed
    distances of the rail; creep: (20, 3) Kalker coefficients; shape: bound over the cells; settings: (SETTINGS,);
    pose: (POSE,); see core.contact.layout. found: (8, FOUND_COLUMNS), work: (12, >= strips, >= 8), vectors and
    matrices (core.contact.strips.model): scratch. Writes patches (lobes, PATCH_COLUMNS), strips (lobes, n,
    STRIP_COLUMNS) and total (TOTAL,). Forces act on the wheel; a lobe with N = 0 is none.
    Returns a status: 0, or a sum of the STATUS bits.
    """
    for i in range(TOTAL):
        total[i] = 0.0
    count, closest, status = find_contacts(
        wheel, settings[WHEEL_STEP], settings[RADIUS], rail, settings[RAIL_STEP], field, settings[FIELD_O],
        settings[FIELD_B], settings[FIELD_SPACING], pose[0], pose[1], pose[2], pose[3], pose[4], pose[5],
        int(settings[STRIDE]), settings[HOLLOW], found,
    )  # fmt: skip
    total[CLOSEST] = closest
    if count == 0:
        return status
    count = select_deepest(found, count, patches.shape[0])
    couple(found, count, settings[EPSILON], work[0], work[1])
    for i in range(count):
        patches[i, COUPLING] = work[0, i]
        patches[i, PARTNER] = work[1, i]
    for i in range(count):
        left, right = _saddles(found, i, count)
        status |= _bound_lobe(wheel, rail, settings, pose, found, i, left, right, patches[i])
    _group(found, settings[EPSILON], patches, count)
    for i in range(count):
        _lay_lobe(wheel, rail, settings, pose, patches, count, i, strips[i])
    if settings[STRIP_MODEL] > 0.5:
        status |= press_strips(settings, pose, patches, strips, count, vectors, matrices)
    else:
        _press(settings, pose, patches, strips, count, work)
    carry(creep, shape, settings, pose, patches, strips, count, work, total)
    return status


@kernel
def carry(creep, shape, settings, pose, patches, strips, count, work, total):
    """Creep forces of lobes whose pressures are known, and the sums over all of them; arguments as above."""
    for i in range(count):
        if settings[TANGENTIAL] > 0.5:
            creep_forces(creep, shape, settings, pose, patches, strips, count, i, work)
        add_lobe(pose, patches[i], strips[i], int(patches[i, N_STRIPS]), total)
    total[COUNT] = count
    loaded = -1.0
    for i in range(count):
        if patches[i, N] > 0.0 and patches[i, GROUP] != loaded:
            loaded = patches[i, GROUP]
            total[PATCHES] += 1.0


@kernel
def _saddles(found, i, count):
    """Distances from a lobe's main point to the saddles beside it, where its neighbours begin."""
    left = right = WIDEST
    if i > 0 and found[i - 1, SADDLE_DEPTH] >= 0.0:
        left = max(found[i, RAIL_ARC] - found[i - 1, SADDLE_RAIL_ARC], 1e-7)
    if i < count - 1 and found[i, SADDLE_DEPTH] >= 0.0:
        right = max(found[i, SADDLE_RAIL_ARC] - found[i, RAIL_ARC], 1e-7)
    return left, right


@kernel
def _bound_lobe(wheel, rail, settings, pose, found, i, left, right, lobe):
    """Main point, recess and edges of one lobe, at most ``left`` and ``right`` of the main point.

    Returns status bits; without contact the width is zero.
    """
    delta, wheel_arc, rail_arc = found[i, DEPTH], found[i, WHEEL_ARC], found[i, RAIL_ARC]
    status = STATUS_TOO_DEEP if delta > DEEPEST else 0
    level = delta
    partner = int(lobe[PARTNER])
    if partner >= 0 and found[partner, DEPTH] > delta:
        level += lobe[COUPLING] * (found[partner, DEPTH] - delta)
    # the strip model finds the contact within the whole penetration
    recess = WITHIN * delta if settings[STRIP_MODEL] > 0.5 else (1.0 - settings[EPSILON]) * level
    _u, _w, tu, tw, _k = profile_point(rail, settings[RAIL_STEP], rail_arc)
    n0o, n0b = -tw, tu
    lobe[APPROACH] = delta
    lobe[ARC_WHEEL] = wheel_arc
    lobe[ARC_RAIL] = rail_arc
    lobe[NO_MAIN] = n0o
    lobe[NB_MAIN] = n0b
    lobe[RECESS] = recess
    lobe[WIDTH] = 0.0
    if delta <= recess:
        return status
    # first step: half of the half width that the relative curvature at the main point promises
    first = 0.55 * sqrt(2.0 * (delta - recess) / max(found[i, RELATIVE_CURVATURE], 0.5))
    first = min(max(first, 2e-5), 4e-3)
    q = sqrt(1.0 - pose[3] * pose[3])
    projected = settings[PROJECTED] > 0.5
    lobe[END], state = find_edge(
        wheel, settings[WHEEL_STEP], settings[RADIUS], rail, settings[RAIL_STEP], pose[0], pose[1], pose[2], pose[3],
        pose[4], pose[5], q, wheel_arc, rail_arc, delta, n0o, n0b, recess, projected, first, 1, right,
    )  # fmt: skip
    if state:
        status |= STATUS_PROFILE_END
    lobe[START], state = find_edge(
        wheel, settings[WHEEL_STEP], settings[RADIUS], rail, settings[RAIL_STEP], pose[0], pose[1], pose[2], pose[3],
        pose[4], pose[5], q, wheel_arc, rail_arc, delta, n0o, n0b, recess, projected, first, -1, left,
    )  # fmt: skip
    if state:
        status |= STATUS_PROFILE_END
    lobe[WIDTH] = lobe[END] - lobe[START]
    return status


@kernel
def _group(found, eps, patches, count):
    """Number the patches: neighbours whose virtual penetrations overlap share one."""
    group = -1
    for i in range(count):
        joined = (
            i > 0
            and found[i - 1, SADDLE_DEPTH] >= 0.0
            and found[i - 1, SADDLE_DEPTH] > (1.0 - eps) * min(found[i - 1, DEPTH], found[i, DEPTH])
        )
        if not joined:
            group += 1
        patches[i, GROUP] = group


@kernel
def _lay_lobe(wheel, rail, settings, pose, patches, count, i, rows):
    """Strips of one lobe.

    The lobes of a patch share the number of strips by their widths; in the strip model every lobe has all of them,
    because its forces would jump, if slightly, with their number.
    """
    lobe = patches[i]
    lobe[N_STRIPS] = 0.0
    lobe[N] = 0.0
    lobe[P0] = 0.0
    lobe[AREA] = 0.0
    lobe[LENGTH] = 0.0
    if lobe[WIDTH] <= 0.0:
        return
    start, end = lobe[START], lobe[END]
    if settings[STRIP_WIDTH] > 0.0:
        n = int(ceil((end - start) / settings[STRIP_WIDTH]))  # noqa: RUF046 (a float in compiled code)
    elif settings[STRIP_MODEL] > 0.5:
        n = int(settings[STRIPS])
    else:
        width = 0.0
        for j in range(count):
            if patches[j, GROUP] == lobe[GROUP]:
                width += patches[j, WIDTH]
        n = int(ceil(settings[STRIPS] * (end - start) / width - 1e-9))  # noqa: RUF046
    fewest = FEWEST_FREE_STRIPS if settings[STRIP_MODEL] > 0.5 else FEWEST_STRIPS
    n = min(max(n, fewest), rows.shape[0])
    lobe[HALF_LENGTH] = lay_strips(
        wheel, settings[WHEEL_STEP], settings[RADIUS], rail, settings[RAIL_STEP], pose[0], pose[1], pose[2], pose[3],
        pose[4], pose[5], sqrt(1.0 - pose[3] * pose[3]), lobe[ARC_WHEEL], lobe[ARC_RAIL], lobe[APPROACH],
        lobe[NO_MAIN], lobe[NB_MAIN], lobe[RECESS], settings[PROJECTED] > 0.5, start, end, n, rows,
    )  # fmt: skip
    lobe[N_STRIPS] = n
    # the main point lies within its strip: its coordinates follow along the strip's tangent
    main = min(max(int(-start / ((end - start) / n)), 0), n - 1)
    row = rows[main]
    other = rows[main - 1] if main > 0 else rows[main + 1]
    lobe[X_MAIN] = row[X] - row[S] * (row[X] - other[X]) / (row[S] - other[S])
    lobe[O_MAIN] = row[O] - row[S] * row[NB]
    lobe[B_MAIN] = row[B] + row[S] * row[NO]


@kernel
def _press(settings, pose, patches, strips, count, work):
    """Pressures of all lobes from the displacements at their main points (`normal.kik_piotrowski`), with damping."""
    matrix = work[2:5]
    rows = work[5:8]
    amplitude = work[8]
    stiffness = pi * settings[MODULUS]
    for i in range(count):
        lobe = patches[i]
        n = int(lobe[N_STRIPS])
        amplitude[i] = 1.0 if n > 0 else 0.0
        for j in range(count + 1):
            matrix[i, j] = 0.0
        if n == 0:
            continue
        set_creepages(pose, settings, lobe, strips[i], n)
        own = own_influence(strips[i], n, lobe[HALF_LENGTH])
        if count == 1:
            amplitude[0] = stiffness * lobe[APPROACH] / own
            break
        share = lobe[COUPLING]
        for j in range(count):
            if j != i and patches[j, N_STRIPS] > 0.0:
                facing = lobe[NO_MAIN] * patches[j, NO_MAIN] + lobe[NB_MAIN] * patches[j, NB_MAIN]
                if facing > 0.0:
                    far = far_influence(strips[j], int(patches[j, N_STRIPS]), lobe[O_MAIN], lobe[B_MAIN])
                    matrix[i, j] = (1.0 - share) * facing * far
        matrix[i, i] = own
        matrix[i, count] = (1.0 - share) * stiffness * lobe[APPROACH]
        partner = int(lobe[PARTNER])
        if partner >= 0 and patches[partner, N_STRIPS] > 0.0:
            matrix[i, partner] -= share * own
    if count > 1:
        solve_amplitudes(matrix, count, rows, amplitude)
    for i in range(count):
        lobe = patches[i]
        factor = max(1.0 + settings[DAMPING] * lobe[CLOSING], 0.0)
        largest, normal, area, longest = set_pressures(strips[i], int(lobe[N_STRIPS]), amplitude[i], factor)
        lobe[AMPLITUDE] = amplitude[i] * factor
        lobe[P0] = max(largest, lobe[AMPLITUDE] * lobe[HALF_LENGTH])
        lobe[N] = normal
        if amplitude[i] == 0.0:
            lobe[N_STRIPS] = 0.0
        lobe[AREA] = area
        lobe[LENGTH] = 2.0 * longest
