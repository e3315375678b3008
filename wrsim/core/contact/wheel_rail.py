"""One wheel on one rail: from a pose and a motion to forces, all stages in one call.

On the right side the rail's axes (t, o, b) are left-handed; a mirrored angular velocity (sign changed once more) makes
every formula hold as it stands, so the kernel knows no side.
"""

from math import ceil
from typing import Any, NamedTuple

from wrsim.core.arena import block, matrix, record_rows, records, vector
from wrsim.core.compiling import inlined, kernel
from wrsim.core.contact.normal.kik_piotrowski import press
from wrsim.core.contact.patch import find_edge, first_step, lay_strips
from wrsim.core.contact.profile import profile_point
from wrsim.core.contact.records import (
    FOUND,
    FREE_STRIPS,
    LOBE,
    NO_CREEP_FORCES,
    SETTINGS,
    STATUS_PROFILE_END,
    STATUS_TOO_DEEP,
    STRIP,
    TOTAL,
    Field,
    Profile,
    read_pose,
)
from wrsim.core.contact.resultants import add_lobe
from wrsim.core.contact.search.lobes import couple, room_beside, select_deepest
from wrsim.core.contact.search.locus import placed
from wrsim.core.contact.search.points import find_contacts
from wrsim.core.contact.strips.model import press_strips
from wrsim.core.contact.strips.records import GRID, MEMO, PLACE, ROW
from wrsim.core.contact.tangential.creep_forces import creep_forces

DEEPEST = 3e-3  # approach beyond which the state is called an overlap, not a contact [m]


class Arrays(NamedTuple):
    """Arrays of one wheel on one rail, in the order of the arena.

    wheel, rail: profile tables, the rail's in (o, b) with its inclination; field: signed distances of the rail; creep:
    (20, 3) Kalker coefficients; shape: (cells,) bound over the cells; settings: (1,) SETTINGS; pose: (POSE,).
    found: (8,) FOUND, work: (12, >= strips, >= 8): scratch; influence to memo: of the strip model
    (core.contact.strips.records). Results: patches: (lobes,) LOBE; strips: (lobes, n) STRIP; total: (1,) TOTAL.
    """

    wheel: Any
    rail: Any
    field: Any
    creep: Any
    shape: Any
    settings: Any
    pose: Any
    found: Any
    patches: Any
    strips: Any
    work: Any
    influence: Any
    rows: Any
    places: Any
    grids: Any
    vectors: Any
    matrix: Any
    memo: Any
    total: Any


ARRAYS = len(Arrays._fields)


@kernel
def arrays(buffer, index):
    """The arrays in an arena of one wheel."""
    first = index.shape[0] - ARRAYS  # 0; written as a literal, every helper would be compiled anew for each number
    return Arrays(
        matrix(buffer, index, first),
        matrix(buffer, index, first + 1),
        block(buffer, index, first + 2),
        matrix(buffer, index, first + 3),
        vector(buffer, index, first + 4),
        records(buffer, index, first + 5, SETTINGS),
        vector(buffer, index, first + 6),
        records(buffer, index, first + 7, FOUND),
        records(buffer, index, first + 8, LOBE),
        record_rows(buffer, index, first + 9, STRIP),
        matrix(buffer, index, first + 10),
        matrix(buffer, index, first + 11),
        record_rows(buffer, index, first + 12, ROW),
        records(buffer, index, first + 13, PLACE),
        records(buffer, index, first + 14, GRID),
        matrix(buffer, index, first + 15),
        matrix(buffer, index, first + 16),
        records(buffer, index, first + 17, MEMO),
        records(buffer, index, first + 18, TOTAL),
    )


@inlined
def results(buffer, index):
    """The TOTAL record in an arena of one wheel, as an array (1,)."""
    return records(buffer, index, index.shape[0] - 1, TOTAL)


@kernel
def wheel_rail(buffer, index):
    """Contact of one wheel and one rail, the pose being set in the arena; see `Arrays`.

    Forces act on the wheel; a lobe with N = 0 is none. Returns a status, which stands in ``total``, too: 0, or a sum of
    the STATUS bits.
    """
    a = arrays(buffer, index)
    settings, lobes = a.settings[0], a.patches
    pose = read_pose(a.pose)
    wheel = placed(Profile(a.wheel, settings.wheel_step), settings.radius, pose)
    rail = Profile(a.rail, settings.rail_step)
    count, status = _search(a, wheel, rail)
    if count == 0:
        return status
    count = select_deepest(a.found, count, lobes.shape[0])
    couple(a.found, count, settings.eps, lobes)
    for i in range(count):
        status |= _start_lobe(rail, a.found[i], lobes[i])
    _group(a.found, settings.eps, lobes, count)
    if settings.normal == FREE_STRIPS:
        status |= press_strips(a, wheel, rail, pose, count)
    else:
        for i in range(count):
            left, right = room_beside(a.found, i, count)
            status |= _bound_lobe(wheel, rail, settings, a.found, i, left, right, lobes)
        for i in range(count):
            _lay_lobe(wheel, rail, settings, lobes, count, i, a.strips[i])
        press(settings, pose, lobes, a.strips, count, a.work)
    _sum_up(a, pose, count)
    a.total[0].status = status
    return status


@kernel
def search(buffer, index):
    """Contacts at the pose set in the arena, before any force, written to ``found``.

    Returns their number and a status; the closest distance stands in ``total``.
    """
    a = arrays(buffer, index)
    settings = a.settings[0]
    wheel = placed(Profile(a.wheel, settings.wheel_step), settings.radius, read_pose(a.pose))
    return _search(a, wheel, Profile(a.rail, settings.rail_step))


@kernel
def carry(buffer, index, count):
    """Creep forces of ``count`` lobes whose pressures are known, and the sums over all of them."""
    a = arrays(buffer, index)
    _sum_up(a, read_pose(a.pose), count)


@kernel
def _search(a, wheel, rail):
    """Clears the totals; returns the number of contacts found and a status."""
    settings, total = a.settings[0], a.total[0]
    total.Ft = total.Fo = total.Fb = 0.0
    total.Mt = total.Mo = total.Mb = 0.0
    total.wear = 0.0
    total.lobes = total.patches = 0
    field = Field(a.field, settings.field_o, settings.field_b, settings.field_spacing)
    count, closest, status = find_contacts(wheel, rail, field, settings.stride, settings.hollow, a.found)
    total.closest = closest
    total.status = status
    return count, status


@kernel
def _sum_up(a, pose, count):
    """Creep forces, and the sums over all lobes."""
    settings, lobes, total = a.settings[0], a.patches, a.total[0]
    for i in range(count):
        if settings.tangential != NO_CREEP_FORCES:
            creep_forces(a.creep, a.shape, settings, pose.velocity.x, lobes, a.strips, count, i, a.work)
        add_lobe(pose, lobes[i], a.strips[i], lobes[i].n_strips, total)
    total.lobes = count
    loaded = -1
    for i in range(count):
        if lobes[i].N > 0.0 and lobes[i].group != loaded:
            loaded = lobes[i].group
            total.patches += 1


@kernel
def _start_lobe(rail, own, lobe):
    """Main point of a lobe that the search has found, so far without pressure. Returns status bits."""
    at = profile_point(rail, own.arc_rail)
    lobe.approach = own.depth
    lobe.arc_wheel = own.arc_wheel
    lobe.arc_rail = own.arc_rail
    lobe.no = -at.tw
    lobe.nb = at.tu
    lobe.n_strips = 0
    lobe.N = lobe.p0 = lobe.area = lobe.length = lobe.width = lobe.recess = 0.0
    return STATUS_TOO_DEEP if own.depth > DEEPEST else 0


@kernel
def _bound_lobe(wheel, rail, settings, found, i, left, right, lobes):
    """Recess and edges of lobe i, at most ``left`` and ``right`` of the main point.

    Returns status bits; without contact the width is zero.
    """
    lobe, own = lobes[i], found[i]
    delta = level = own.depth
    if settings.joint and lobe.partner >= 0 and found[lobe.partner].depth > delta:
        level += lobe.coupling * (found[lobe.partner].depth - delta)
    lobe.recess = settings.recess * level
    if delta <= lobe.recess:
        return 0
    first = first_step(delta - lobe.recess, own.curvature)
    lobe.end, beyond = find_edge(wheel, rail, lobe, settings.projected, first, 1.0, right)
    lobe.start, before = find_edge(wheel, rail, lobe, settings.projected, first, -1.0, left)
    lobe.width = lobe.end - lobe.start
    return STATUS_PROFILE_END if beyond or before else 0


@kernel
def _group(found, eps, lobes, count):
    """Number the patches: neighbours whose virtual penetrations overlap share one."""
    group = -1
    for i in range(count):
        joined = (
            i > 0
            and found[i - 1].saddle >= 0.0
            and found[i - 1].saddle > (1.0 - eps) * min(found[i - 1].depth, found[i].depth)
        )
        if not joined:
            group += 1
        lobes[i].group = group


@kernel
def _lay_lobe(wheel, rail, settings, lobes, count, i, strips):
    """Strips of one lobe: by their width, or by their number.

    Where the model's patches are joint the lobes of a patch share the number by their widths; else every lobe has all
    of them, because its forces would jump, if slightly, with their number.
    """
    lobe = lobes[i]
    if lobe.width <= 0.0:
        return
    if settings.strip_width > 0.0:
        n = int(ceil(lobe.width / settings.strip_width))  # noqa: RUF046 (a float in compiled code)
    elif settings.joint:
        width = 0.0
        for j in range(count):
            if lobes[j].group == lobe.group:
                width += lobes[j].width
        n = int(ceil(settings.strips * lobe.width / width - 1e-9))  # noqa: RUF046
    else:
        n = settings.strips
    n = min(max(n, settings.fewest), strips.shape[0])
    lobe.half_length = lay_strips(wheel, rail, lobe, settings.projected, n, strips)
    lobe.n_strips = n
    # the main point lies within its strip: its coordinates follow along the strip's tangent
    main = min(max(int(-lobe.start / (lobe.width / n)), 0), n - 1)
    strip = strips[main]
    other = strips[main - 1] if main > 0 else strips[main + 1]
    lobe.x = strip.x - strip.s * (strip.x - other.x) / (strip.s - other.s)
    lobe.o = strip.o - strip.s * strip.nb
    lobe.b = strip.b + strip.s * strip.no
