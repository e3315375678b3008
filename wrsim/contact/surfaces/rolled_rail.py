"""The effective profile (surf-envelope) of a rail whose profile changes along the track, as a rolling wheel meets it.

The envelope has a point of every row of the surface. At a joint that is a step the wheel touches before and behind it.
A yawed wheel touches at x_l + x with the shift x_l of its own outline; then the effective section is that at s + x_l.

Stations along s have tables of the effective section, so close that cubics between them are good to TOLERANCE. The rows
of a piece have equal steps of arclength from its anchor, whose row is the same in all tables; beyond its ends, and
where it does not exist, its rows lie where no wheel comes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import sqrt

import numpy as np
import scipy

from wrsim.contact.profiles.profile import Array
from wrsim.contact.surfaces.distance_field import SPACING, DistanceField, field_of_points, grid_about
from wrsim.contact.surfaces.envelope_rows import ENVELOPE, WITHIN_REACH, Heading, envelope_rows, unfold
from wrsim.contact.surfaces.rail_surface import DEEP, Piece, RailSurface
from wrsim.errors import InputError

REACH = 0.2  # how far ahead of the axle and behind it a contact is looked for [m]
SHALLOW = 0.025  # what lies deeper below the highest point does not decide where stations are [m]
LEVEL = 0.6  # cosine of the slope across up to which a row must be touched within REACH
TOLERANCE = 1e-6  # of the cubics between stations, along the normal [m]
SLOPE_TOLERANCE = 3e-5  # of how they rise along the track, and of the slope in the tables
ROWS = 0.2e-3  # distance of the rows of a table [m]
CLOSEST = 1e-3  # least distance of stations [m]
FIELD_APART = 0.5e-3  # sections farther from each other have distance fields of their own [m]
ROUND_OFF = 1e-9  # of heights, at the most [m]
NOWHERE = 0.1  # how deep rows lie of a piece that does not exist [m]
COLUMNS = ("u", "w", "tu", "tw", "k", "ahead", "slope", "bend", "bend_deep", "lean")
"""Columns of a table, in the rail's own axes (`RailSurface.heading`): point [m], tangent, curvature [1/m]; how far
ahead of the axle the rail is touched there [m], its slope along them (normal to the section), and its
curvatures and lean, positive upwards, as in `rail.Envelope`."""


@dataclass(frozen=True, eq=False)
class RolledRail:
    """Effective sections at stations of a surface: places (n,) [m], tables (n, rows, len(COLUMNS)), step of the rows
    [m]; rates: derivative of the tables along s, of the same shape."""

    surface: RailSurface
    stations: Array
    tables: Array
    rates: Array
    step: float

    @property
    def hollow(self) -> float:
        """Largest concave curvature across, where a wheel comes [1/m]."""
        height = self.tables[..., 1]
        near = (height > height.max(axis=1, keepdims=True) - SHALLOW) & (self.tables[..., 2] > LEVEL)
        return max(float(self.tables[..., 4][near].max()), 0.0)

    def outline(self, s: float, points: int) -> Array:
        """The effective section at s for drawing, (points, 2) [m]; flat where no wheel comes, NaN without rail."""
        rows = self.section(s)[:, :2]
        lowest = rows[:, 1].max() - DEEP
        rows[rows[:, 1] < lowest - DEEP] = np.nan
        rows[:, 1] = np.maximum(rows[:, 1], lowest)
        return rows[np.linspace(0, len(rows) - 1, points).round().astype(int)]

    def section(self, s: float, rate: bool = False) -> Array:
        """The table at s by the cubics of the kernels, (rows, len(COLUMNS)), or its rate along s; constant outside."""
        s = float(np.clip(s, self.stations[0], self.stations[-1]))
        i = min(int(np.searchsorted(self.stations, s, side="right")) - 1, self.stations.size - 2)
        h = self.stations[i + 1] - self.stations[i]
        f = (s - self.stations[i]) / h
        a, b = self.tables[i : i + 2]
        c, d = self.rates[i : i + 2]
        if rate:
            return np.asarray(
                6.0 * f * (1.0 - f) / h * (b - a) + (1.0 - f) * (1.0 - 3.0 * f) * c + f * (3.0 * f - 2.0) * d
            )
        rise = f * f * (3.0 - 2.0 * f)
        return np.asarray(a + rise * (b - a) + h * f * (1.0 - f) * ((1.0 - f) * c - f * d))


@lru_cache(maxsize=8)
def rolled_rail(surface: RailSurface, radius: float) -> RolledRail:
    """The effective rail for wheels of this radius.

    Raises ``InputError`` where the rail is so steep that a wheel touches it more than REACH ahead of its axle.
    """
    ends = (surface.start - REACH, surface.end + REACH)
    s = np.unique(np.concatenate((ends, [section.distance for section in surface.sections])))
    s = s[np.append(True, np.diff(s) > CLOSEST)]
    effective = {float(x): effective_sections(surface, float(x), radius) for x in s}
    arcs = []
    for curves in zip(*effective.values(), strict=True):
        ends_of = [(arc[0], arc[-1]) for arc, _ in curves if arc.size]
        first, last = min(a for a, _ in ends_of), max(b for _, b in ends_of)
        numbers = np.arange(int(np.floor(first / ROWS)), int(np.ceil(last / ROWS)) + 1)
        arcs.append(np.asarray(ROWS * numbers, dtype=float))
    known = {x: _table(curves, arcs) for x, curves in effective.items()}
    unsure = list(pairwise(s.tolist()))
    while unsure:
        now = _joined(surface, known)
        again = []
        for low, high in unsure:
            if high - low < 2.0 * CLOSEST:
                continue
            middle = 0.5 * (low + high)
            table = _table(effective_sections(surface, middle, radius), arcs)
            if _is_good(now, middle, table):
                continue
            known[middle] = table
            again += [(low, middle), (middle, high)]
        unsure = again
    return _joined(surface, known)


def _joined(surface: RailSurface, known: dict[float, Array]) -> RolledRail:
    s = np.array(sorted(known))
    tables = np.stack([known[float(x)] for x in s])
    return RolledRail(surface, s, tables, _rates(s, tables, surface.heading(s)), ROWS)


def _is_good(rail: RolledRail, s: float, table: Array) -> bool:
    """Whether the cubics meet a table and its slope along the track, both along the normal, where a wheel can come."""
    near = (table[:, 1] > table[:, 1].max() - SHALLOW) & (table[:, 2] > LEVEL)
    exact, rate = rail.section(s)[near], rail.section(s, rate=True)[near]
    table = table[near]
    apart = (exact[:, 1] - table[:, 1]) * table[:, 2] - (exact[:, 0] - table[:, 0]) * table[:, 3]
    moved = rate[:, 1] * table[:, 2] - rate[:, 0] * table[:, 3]
    off = np.abs(np.stack((moved - _moves(table, rail.surface.heading(s)), exact[:, 6] - table[:, 6])))
    return bool(np.abs(apart).max(initial=0.0) < TOLERANCE and off.max(initial=0.0) < SLOPE_TOLERANCE)


def _moves(tables: Array, heading: Array) -> Array:
    """How fast effective sections move along their normals with s: with the slope of the rail where it is touched, and
    with their axes, which go along the track and turn."""
    (u, _w, _tu, tw, _k, ahead, slope, *_bends), (sine, rate) = np.moveaxis(tables, -1, 0), heading
    cosine = np.sqrt(1.0 - sine**2)
    return np.asarray(slope * (cosine - u * rate / cosine) - tw * (sine - ahead * rate / cosine))


def _rates(s: Array, tables: Array, headings: Array) -> Array:
    """Derivatives along s by parabolas through three stations; none at the ends, where nothing changes.

    Along the normal an effective section moves as ``_moves`` tells: that is exact.
    """
    gaps = np.diff(s)
    slopes = np.diff(tables, axis=0) / gaps[:, None, None]
    out = np.zeros_like(tables)
    share = (gaps[:-1] / (gaps[:-1] + gaps[1:]))[:, None, None]
    out[1:-1] = (1.0 - share) * slopes[:-1] + share * slopes[1:]
    normal = np.stack((-tables[..., 3], tables[..., 2]), axis=-1)
    off = _moves(tables, headings[..., None]) - (out[..., :2] * normal).sum(axis=-1)
    out[..., :2] += off[..., None] * normal
    return out


_Curve = tuple[Array, Array]
"""Effective section of a piece: arclengths from its anchor (n,), rows (n, WITHIN_REACH) of `envelope_rows` that are
neither too deep nor fold back; empty where the piece does not exist."""


def effective_sections(surface: RailSurface, s: float, radius: float) -> list[_Curve]:
    """The effective sections of all pieces at s."""
    sine = float(surface.heading(s)[0])
    heading = Heading(sine, sqrt(1.0 - sine**2))

    def envelope(piece: Piece, first: int, last: int) -> Array:
        rows = np.full((piece.spline.c.shape[2], len(ENVELOPE)), -np.inf)
        ends, between = np.array(piece.open_ends, dtype=float), np.array((first, last))
        envelope_rows(piece.spline.c, piece.spline.x, ends, s, radius, REACH, heading, between, rows)
        return rows

    section, starts = surface.rows(np.array([s]))
    top = int(section[0, :, 1].argmax())
    highest = int(np.searchsorted(starts, top, side="right")) - 1
    row = top - int(starts[highest])
    # no row of the envelope is above the tops of its cubics within reach, and the highest is not below any one
    floor = float(envelope(surface.pieces[highest], row, row + 1)[row, 1]) - DEEP - ROUND_OFF
    envelopes = []
    for piece in surface.pieces:
        before, behind = np.searchsorted(piece.spline.x[1:-1], (s - REACH, s + REACH))
        near = np.flatnonzero(piece.tops[before : behind + 1].max(axis=0) > floor)
        # `unfold` looks at the neighbours of what it keeps
        first, last = (near[0] - 1, near[-1] + 2) if near.size else (0, 0)
        envelopes.append(envelope(piece, max(first, 0), min(last, piece.tops.shape[1])))
    lowest = max(float(rows[:, 1].max()) for rows in envelopes) - DEEP
    if any(((rows[:, 1] > lowest) & (rows[:, 2] > LEVEL) & (rows[:, WITHIN_REACH] == 0.0)).any() for rows in envelopes):
        far = f"a wheel of radius {1e3 * radius:g} mm would touch it more than {1e3 * REACH:g} mm from its axle"
        raise InputError(f"rail '{surface.name}': near {s:.4g} m it is so steep along the track that {far}")
    return [_curve(piece, rows, lowest) for piece, rows in zip(surface.pieces, envelopes, strict=True)]


def _curve(piece: Piece, rows: Array, lowest: float) -> _Curve:
    """The effective section of a piece down to a height."""
    if rows[piece.anchor, 1] < lowest:
        return np.zeros(0), np.zeros((0, WITHIN_REACH))
    keep = np.zeros(len(rows), dtype=bool)
    unfold(rows, piece.anchor, lowest, keep)
    at = int(keep[: piece.anchor].sum())
    rows = rows[keep, :WITHIN_REACH]
    bent = np.arcsin(np.clip(rows[:-1, 2] * rows[1:, 3] - rows[:-1, 3] * rows[1:, 2], -1.0, 1.0))
    arc = np.append(0.0, np.cumsum(np.hypot(*np.diff(rows[:, :2], axis=0).T) * (1.0 + bent**2 / 24.0)))
    return arc - arc[at], rows


def _table(curves: Sequence[_Curve], arcs: Sequence[Array]) -> Array:
    """Rows of COLUMNS of all pieces, one behind the other."""
    return np.concatenate([_rows(curve, arc) for curve, arc in zip(curves, arcs, strict=True)])


def _rows(curve: _Curve, arc: Array) -> Array:
    """Rows of a piece at the arclengths ``arc``; beyond its ends it goes on straight."""
    at, rows = curve
    if at.size < 2:
        return np.column_stack(
            (arc, np.full(arc.size, -NOWHERE), np.ones(arc.size), *np.zeros((len(COLUMNS) - 3, arc.size)))
        )
    inside = np.clip(arc, at[0], at[-1])
    spline = scipy.interpolate.CubicHermiteSpline(at, rows[:, :2], rows[:, 2:4])
    point, tangent = spline(inside), spline(inside, 1)
    tangent /= np.hypot(tangent[:, 0], tangent[:, 1])[:, None]
    point = point + (arc - inside)[:, None] * tangent
    angle = np.unwrap(np.arctan2(rows[:, 3], rows[:, 2]))
    k = np.interp(arc, 0.5 * (at[1:] + at[:-1]), np.diff(angle) / np.diff(at), 0.0, 0.0)
    return np.column_stack((point, tangent, k, *(np.interp(arc, at, column) for column in rows[:, 4:].T)))


def station_fields(rail: RolledRail) -> tuple[DistanceField, int, Array, float]:
    """Distance fields of so many stations, one behind the other, that every section is within about FIELD_APART of that
    of its field; rows of each, the number of the field of every station, and the largest error [m]."""
    height = rail.tables[..., 1]
    near = height > height.max(axis=1, keepdims=True) - DEEP
    chosen, numbers, off = [0], [], 0.0
    for i in range(rail.stations.size):
        apart = _between(rail, chosen[-1], i, near)
        if apart > FIELD_APART:
            chosen.append(i)
            apart = 0.0
        off = max(off, apart)
        numbers.append(len(chosen) - 1)
    points = rail.tables[..., :2][near]
    low, counts = grid_about(points, SPACING)
    arc = np.asarray(rail.step * np.arange(rail.tables.shape[1]), dtype=float)
    values = [field_of_points(arc, rail.tables[i, :, :4], low, counts, SPACING) for i in chosen]
    # a yawed wheel touches places ahead of the axle and behind it
    field = DistanceField(np.concatenate(values), low, SPACING)
    return field, counts[0], np.array(numbers, dtype=float), off + FIELD_APART


def _between(rail: RolledRail, one: int, other: int, near: Array) -> float:
    """Largest distance of two stations' sections along the normal [m]."""
    both = near[one] & near[other]
    a, b = rail.tables[one, both], rail.tables[other, both]
    return float(np.abs((b[:, 1] - a[:, 1]) * a[:, 2] - (b[:, 0] - a[:, 0]) * a[:, 3]).max(initial=0.0))
