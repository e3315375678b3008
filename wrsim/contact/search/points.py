"""Search for the main contact points of a wheel outline and a rail profile, by the steps of docs/theory/search.md.

The field of signed distances is negative inside the steel. Near the rail the slope of the distance along the outline is
t_w . n_r. A local minimum of the distance is a place where the connecting vector is parallel to both normals [S 13-15].
Distances are measured along normals throughout, so a vertical rail side is as good as the crown.
"""

from math import inf, sqrt
from typing import NamedTuple

from wrsim.contact.records import Field, PlacedWheel, Rail
from wrsim.contact.search.locus import LARGEST_SINE, Node, locus_node, locus_point
from wrsim.contact.surfaces.profile_table import node
from wrsim.contact.surfaces.rail import rail_chord, rail_length, rail_point
from wrsim.jit import Record, Records, inlined, kernel

FIELD_ERROR = 1e-5  # of the field's interpolation, generously [m]
NEAR = 5e-5  # estimated least distance below which contact is looked for exactly [m]
FAR = 5e-3  # distance beyond which the slope is not worth computing [m]
STRETCH = 1.2  # the outline is at most this much longer than the profile where abs(sine) < STEEP
STEEP = 0.1  # on steeper parts of a yawed wheel nothing is skipped
YAW_HOLLOWS = 0.03  # yaw that makes the hollow parts of the outline about twice as hollow as the profile [rad]
MARGIN = 5.5e-3  # the field reaches at least this far beyond the rail [m]
LARGEST_TURN, FARTHEST_FOOT = 0.02, 2e-3  # of the rail between a foot and where it is guessed: angle, arclength [m]
FALL = 0.02  # of the slope in a good step of Newton's
MINIMUM, MAXIMUM = 1.0, -1.0  # of the distance
DOUBTFUL = 0.02  # slope whose sign samples may give wrongly
DEEP = 1e-3  # overlap beyond which the nearest point of the rail may leap to another place [m]
CLOSE = 1e-11  # last step to a stationary point [m]
SAME = 1e-6  # distance of two stationary points that are one [m]
NO_CREST = -1e9  # arclength on the wheel that stands for no place [m]
EXACT, ROUGH, NONE = range(3)  # a stationary point to round-off; not so; no such point between both ends


class Foot(NamedTuple):
    """Foot of a perpendicular on the rail: arclength, distance along the rail normal, that normal, curvature."""

    arc: float
    distance: float
    no: float
    nb: float
    k: float


class Stationary(NamedTuple):
    """Stationary point of the distance: arclengths on wheel and rail, distance, relative curvature; status EXACT, ROUGH
    or NONE."""

    arc_wheel: float
    arc_rail: float
    distance: float
    curvature: float
    status: int


@inlined
def field_distance(field: Field, o: float, b: float) -> tuple[float, float]:
    """(signed distance, arclength of the nearest rail point) by bilinear interpolation of the field. Outside the grid a
    lower bound stands for the distance. The arclength is 0 there, and where the distance is of no interest."""
    values = field.values
    inverse = 1.0 / field.spacing
    x, y = (o - field.o) * inverse, (b - field.b) * inverse
    nx, ny = field.rows - 1, values.shape[1] - 1
    if x < 0.0 or y < 0.0 or x >= nx or y >= ny:
        outside = max(max(-x, x - nx), max(-y, y - ny))
        return outside * field.spacing + MARGIN, 0.0
    i, j = int(x), int(y)
    x, y = x - i, y - j
    i += field.first
    w00, w10, w01, w11 = (1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y
    distance = (
        w00 * values[i, j, 0] + w10 * values[i + 1, j, 0] + w01 * values[i, j + 1, 0] + w11 * values[i + 1, j + 1, 0]
    )
    if distance > FAR + field.slack:
        return distance, 0.0
    foot = w00 * values[i, j, 1] + w10 * values[i + 1, j, 1] + w01 * values[i, j + 1, 1] + w11 * values[i + 1, j + 1, 1]
    return distance, foot


@inlined
def project(rail: Rail, o: float, b: float, arc: float, steps: int) -> Foot:
    """Foot of the perpendicular from (o, b) on the rail by ``steps`` Newton steps from ``arc``."""
    for i in range(steps + 1):
        point = rail_point(rail, arc)
        no, nb = -point.tw, point.tu
        du, dw = o - point.u, b - point.w
        distance = du * no + dw * nb
        if i == steps:
            break
        arc += (du * point.tu + dw * point.tw) / max(1.0 - point.k * distance, 0.2)
    return Foot(arc, distance, no, nb, point.k)


@inlined
def _near(rail: Rail, o: float, b: float, foot: float, no: float, nb: float) -> tuple[float, float, float]:
    """Distance of (o, b) from a rail that changes along the track, arclength of its foot, and slope of the distance
    along a wheel outline with normal (no, nb); foot: about where it is. Right to second order in how far that is off,
    which the samples of a search want; else by Newton's method."""
    chord = rail_chord(rail, foot)
    du, dw = o - chord.u, b - chord.w
    distance = dw * chord.tu - du * chord.tw
    lean = 1.0 / max(1.0 - chord.k * distance, 0.2)
    off = (du * chord.tu + dw * chord.tw) * lean
    turn = chord.k * off
    if abs(turn) > LARGEST_TURN or abs(off) > FARTHEST_FOOT:
        on_rail = project(rail, o, b, foot, 2)
        return on_rail.distance, on_rail.arc, no * on_rail.nb - nb * on_rail.no
    # normal over the foot: (-tw - turn tu, tu - turn tw)
    slope = no * (chord.tu - turn * chord.tw) + nb * (chord.tw + turn * chord.tu)
    return distance - 0.5 * turn * off / lean, foot + off, slope


@kernel
def refine(wheel: PlacedWheel, rail: Rail, lo: float, hi: float, arc: float, foot: float, kind: float) -> Stationary:
    """A stationary point of the distance between two wheel arclengths: safeguarded Newton on its slope.

    Where curvatures jump, at joins of arcs, they give the rate of the slope wrongly: where a step has not brought it
    down by far the next one is the secant's. Samples give the slope of a nearly straight distance by chords, perhaps
    with a wrong sign: then there is no such point, and the search ends at one of the ends. It ends there, too, where
    the distance has a bend far inside the rail, which counts.

    arc, foot: first guess on wheel and rail; kind: MINIMUM (slope negative at ``lo``) or MAXIMUM.
    """
    distance, curvature, status = 0.0, 0.0, ROUGH
    ends = lo, hi
    projections = 3  # the first guess of the foot may be far off; later ones are predicted
    last = 1.0  # length of the last step
    before, slope_before = arc, inf
    for _ in range(60):
        point = locus_point(wheel, arc)
        on_rail = project(rail, point.o, point.b, foot, projections)
        foot, distance = on_rail.arc, on_rail.distance
        projections = 1
        slope = -point.nb * on_rail.no + point.no * on_rail.nb  # wheel tangent (-nb, no) times rail normal
        cosine = -(point.no * on_rail.no + point.nb * on_rail.nb)
        curvature = point.shrink * point.k - on_rail.k
        if kind * slope < 0.0:
            lo = arc
        else:
            hi = arc
        lean = max(1.0 - on_rail.k * distance, 0.2)
        rate = point.k * cosine - on_rail.k * cosine * cosine / (lean * point.shrink)
        if abs(slope) > FALL * abs(slope_before):
            secant = (slope - slope_before) / (arc - before)
            rate = secant if kind * secant > 0.0 else rate
        before, slope_before = arc, slope
        step = -slope / rate if kind * rate > 0.0 else 2.0 * (hi - lo)
        if abs(step) < CLOSE or hi - lo < CLOSE:
            on_rail = project(rail, point.o, point.b, foot, projections)
            foot, distance = on_rail.arc, on_rail.distance
            at_end = hi - lo < CLOSE and (lo == ends[0] or hi == ends[1])
            status = NONE if at_end and abs(slope) < DOUBTFUL and distance > -DEEP else EXACT
            break
        new = arc + step
        # else steps may swing to and fro
        if new <= lo or new >= hi or abs(step) > 0.5 * last:
            new = 0.5 * (lo + hi)
        last = abs(new - arc)
        foot += (new - arc) * cosine / (lean * point.shrink)
        arc = new
    return Stationary(arc, foot, distance, curvature, status)


@inlined
def _rail_slope(rail: Rail, foot: float, no: float, nb: float) -> float:
    """Slope of the distance along a wheel outline with normal (no, nb) over the point ``foot`` of a plain rail."""
    table = rail.table
    x = foot / rail.step
    i = min(max(int(x), 0), table.shape[0] - 2)
    r = x - i
    tu = table[i, 2] + r * (table[i + 1, 2] - table[i, 2])
    tw = table[i, 3] + r * (table[i + 1, 3] - table[i, 3])
    return nb * tw + no * tu  # wheel tangent (-nb, no) times rail normal (-tw, tu)


class Sample(NamedTuple):
    """A node of the outline near the rail: its point, distance of the rail, arclength of the foot on it (0: none), and
    slope of the distance along the outline."""

    node: int
    o: float
    b: float
    distance: float
    foot: float
    slope: float


@inlined
def _at_changing_rail(
    rail: Rail, slack: float, point: Node, last: Sample, adjacent: bool, distance: float, foot: float
) -> tuple[float, float, float]:
    """Distance of a point of the outline from a rail that changes along the track, arclength of its foot, and slope;
    distance, foot: by the field of a station nearby, which may be off by ``slack``; beside the field there is no
    foot."""
    if distance >= FAR + slack or foot <= 0.0:
        return distance - slack, foot, 0.0
    if adjacent and last.foot > 0.0:
        # nearer to the foot than the field, where curvatures change within a millimetre
        foot = last.foot + sqrt((point.o - last.o) ** 2 + (point.b - last.b) ** 2)
    return _near(rail, point.o, point.b, foot, point.no, point.nb)


@inlined
def _free_length(distance: float, slope: float, hollow: float) -> float:
    """Length of the outline over which a distance cannot vanish: it bends down by no more than both bodies are
    hollow."""
    return (slope + sqrt(slope * slope + 2.0 * hollow * distance)) / hollow


@inlined
def slope_changes_sign(last: Sample, sample: Sample) -> bool:
    """Whether the slope changes its sign between two samples, near the rail. Where the distance bends up between them
    it is nowhere below both tangents, which says whether a closer look is worth it: where the locus climbs around a
    yawed wheel, samples lie millimetres apart."""
    if (sample.slope < 0.0) == (last.slope < 0.0):
        return False
    between = sqrt((sample.o - last.o) ** 2 + (sample.b - last.b) ** 2)
    crossing = (last.distance - sample.distance + sample.slope * between) / (sample.slope - last.slope)
    return min(last.distance + last.slope * crossing, last.distance, sample.distance) < NEAR


@inlined
def skip_to(last: Sample, i: int) -> Sample:
    """The last sample, moved on to a node that is out of reach of the rail."""
    return Sample(i, last.o, last.b, last.distance, 0.0, last.slope)


@inlined
def _next_minimum(
    wheel: PlacedWheel, rail: Rail, last: Sample, sample: Sample, stride: int, guess: float, contacts: Records,
    count: int,
) -> Stationary:  # fmt: skip
    """The least distance between two samples; guess: about where on the wheel. Where both bodies are nearly parallel in
    the rail the slopes of samples are of no use, and it lies farther away. NONE where they were wrong, here or at the
    last change of sign, and the point is the last of ``count`` contacts."""
    step, nodes = wheel.profile.step, wheel.profile.table.shape[0]
    met = refine(wheel, rail, (last.node - stride) * step, (sample.node + stride) * step, guess, sample.foot, MINIMUM)
    reach = stride
    while met.status == NONE and sample.distance < 0.0 and reach < nodes:
        reach *= 2
        lo, hi = max(last.node - reach, 0) * step, min(sample.node + reach, nodes - 1) * step
        met = refine(wheel, rail, lo, hi, met.arc_wheel, met.arc_rail, MINIMUM)
    new = count == 0 or met.arc_wheel > contacts[count - 1].arc_wheel + SAME
    return met if new else Stationary(met.arc_wheel, met.arc_rail, met.distance, met.curvature, NONE)


@inlined
def _set_saddle(wheel: PlacedWheel, rail: Rail, before: Record, met: Stationary, crest: float) -> None:
    """The place between two contacts where the distance is largest, if it is in the rail; crest: about where on the
    wheel."""
    span = met.arc_wheel - before.arc_wheel
    if not before.arc_wheel < crest < met.arc_wheel:
        crest = before.arc_wheel + 0.5 * span
    foot = before.arc_rail + (met.arc_rail - before.arc_rail) * (crest - before.arc_wheel) / span
    saddle = refine(wheel, rail, before.arc_wheel, met.arc_wheel, crest, foot, MAXIMUM)
    if saddle.distance < 0.0:
        before.saddle = -saddle.distance
        before.saddle_arc = saddle.arc_rail


@inlined
def _add_contact(wheel: PlacedWheel, rail: Rail, contacts: Records, count: int, met: Stationary, crest: float) -> None:
    """Write a contact behind ``count`` others, and the saddle between it and the last one unless there is none."""
    if crest != NO_CREST:
        _set_saddle(wheel, rail, contacts[count - 1], met, crest)
    row = contacts[count]
    row.arc_wheel, row.arc_rail = met.arc_wheel, met.arc_rail
    row.depth, row.curvature, row.saddle = -met.distance, met.curvature, -1.0


@kernel
def find_contacts(
    wheel: PlacedWheel, rail: Rail, field: Field, stride: int, hollow: float, contacts: Records
) -> tuple[int, float, int]:
    """All local maxima of the interpenetration, in order along the wheel profile (docs/theory/search.md).

    stride: nodes between two samples near the rail; hollow: largest concave curvatures of both bodies together [1/m].
    contacts: (n,) MAIN_POINT records. Returns their number, the smallest distance met and a status: EXACT or ROUGH."""
    step, rail_end = wheel.profile.step, rail_length(rail)
    hollow *= 1.0 + (wheel.axle.x / YAW_HOLLOWS) ** 2
    per_node = 1.0 / (STRETCH * step)
    count, closest, status = 0, 1.0, 0
    last = Sample(-stride, 0.0, 0.0, 0.0, 0.0, 0.0)
    adjacent = same_overlap = False  # the last sample is one stride back; in the rail since the last contact
    from_afar = False  # one stride back it was far from the rail; where the outline climbs it may be in it by now
    crest = 0.0  # about where the distance was largest since then
    i = no_skip_before = 0
    while i < wheel.profile.table.shape[0]:
        point = locus_node(wheel, node(wheel.profile, i), LARGEST_SINE)
        if abs(point.sine) >= LARGEST_SINE:
            last, adjacent, same_overlap, from_afar = skip_to(last, i), False, False, False
            i += stride
            continue
        distance, foot = field_distance(field, point.o, point.b)
        slope = 0.0
        if field.slack > 0.0:
            distance, foot, slope = _at_changing_rail(rail, field.slack, point, last, adjacent, distance, foot)
        if distance < FIELD_ERROR and not adjacent and i - stride > last.node:
            # a skip has ended inside the rail: the outline was longer than thought; back, and step by step
            no_skip_before, i, adjacent = i, last.node + stride, True
            continue
        closest = min(closest, distance)
        may_skip = i >= no_skip_before and abs(point.sine) < STEEP
        clear = distance - FIELD_ERROR
        if distance > FAR or foot <= 0.0 or foot >= rail_end:
            # far away, or beside an end of the rail, where nothing bounds how the distance bends: its length alone
            last, adjacent, same_overlap, from_afar = skip_to(last, i), False, False, distance > FAR and not may_skip
            if from_afar:
                last = Sample(i, point.o, point.b, distance, 0.0, -1.0)
            i += max(int(clear * per_node), stride) if may_skip else stride
            continue
        slope = _rail_slope(rail, foot, point.no, point.nb) if field.slack == 0.0 else slope
        sample = Sample(i, point.o, point.b, distance, foot, slope)
        if (adjacent or from_afar) and slope_changes_sign(last, sample):
            guess = (i - stride * slope / (slope - last.slope)) * step
            if last.slope >= 0.0:
                crest = guess
            else:
                met = _next_minimum(wheel, rail, last, sample, stride, guess, contacts, count)
                if met.status != NONE:
                    closest = min(closest, met.distance)
                    if met.distance < 0.0 and 0.0 < met.arc_rail < rail_end and count < contacts.shape[0]:
                        _add_contact(wheel, rail, contacts, count, met, crest if same_overlap else NO_CREST)
                        status, count, same_overlap = status | met.status, count + 1, True
        last, adjacent, from_afar = sample, True, False
        if clear > 0.0:
            same_overlap = False
            skip = int(_free_length(clear, slope, hollow) * per_node)
            if may_skip and skip > stride:
                i, adjacent = i + skip, False
                continue
        i += stride
    return count, closest, status
