"""A rail whose profile changes along the track: sections joined to a surface.

Regions between features, gaps and pieces are those of docs/user/changing_rails.md. Along s the points of a piece and
their tangents are joined by cubic splines, which part where sections show a step or a bend. Before the first and behind
the last section the rail is constant; a piece that begins or ends between sections falls off steeply.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from wrsim.contact.profiles.files import read_points
from wrsim.contact.profiles.points import ProfilePoints, check_points, interpolated, smoothed
from wrsim.contact.profiles.profile import CURVE, Array, Profile
from wrsim.contact.surfaces.slices import read_slices
from wrsim.errors import InputError
from wrsim.inputs.csv_tables import read_columns
from wrsim.inputs.toml_files import shown_value
from wrsim.inputs.values import number

STEP = 0.2e-3  # distance of the points of a section [m]
DEEP = 0.038  # no wheel comes deeper below the highest point [m]
END = 1e-3  # from the end of a profile within which a feature is that end [m]
SHORTEST = 1e-4  # A piece below this length [m] does not exist
FALLING = 0.5  # sine of the slope from which on a section that is cut off goes on straight
STEEPEST_OVER = 3.0  # largest slope over the smaller secant beside it, for cubics without overshoot
FLANK, BESIDE = 0.02, 0.01  # of the gauge side: how deep its flank goes, how far what lies beside it counts [m]
INNERMOST = -0.06  # where a flange can touch: beyond are check rails [m]
FOLLOWED = 0.03  # slope in plan up to which a flange follows a rail; at twice that it does not at all
EVEN = 0.05  # half of the way over which the direction is a mean [m]
AS_FAR = 0.5  # of the slope by neighbours: the slope of smooth cubics may differ so far from it


@dataclass(frozen=True, eq=False)
class RailSection:
    """A profile (of a rail, in rail axes) at a distance along the rail [m], and the arclengths of its features [m].

    features: rising, from 0 to the profile's length; two equal ones: a region that does not exist here.
    """

    distance: float
    profile: Profile
    features: tuple[float, ...] = ()

    @cached_property
    def edges(self) -> Array:
        """Arclengths of the edges of all regions, (regions + 1,)."""
        return np.array([0.0, *self.features, self.profile.length])


@dataclass(frozen=True, eq=False)
class RailSurface:
    """Sections (at least two), in order of their distances, with as many features each.

    pieces: the parts between gaps. Raises ``InputError`` where sections are not in order, features do not match, or a
    part is not there in sections that follow each other.
    """

    name: str
    sections: tuple[RailSection, ...]
    pieces: tuple[Piece, ...] = field(init=False)

    def __post_init__(self) -> None:
        if len(self.sections) < 2:
            raise InputError(f"rail '{self.name}': has {len(self.sections)} sections; at least 2 are needed")
        first = self.sections[0]
        for before, section in pairwise(self.sections):
            if section.distance <= before.distance:
                places = f"the section at {section.distance:g} m follows one at {before.distance:g} m"
                raise InputError(f"rail '{self.name}': {places}; distances must rise")
        for section in self.sections:
            place = f"rail '{self.name}', section at {section.distance:g} m"
            if len(section.features) != len(first.features):
                raise InputError(
                    f"{place}: has {len(section.features)} features; the first section has {len(first.features)}"
                )
            if not (np.diff(section.edges) >= -1e-9).all():
                listed = ", ".join(f"{1e3 * f:.6g}" for f in section.features)
                reach = f"from 0 to {1e3 * section.profile.length:.6g} mm of arclength"
                raise InputError(f"{place}: features must rise {reach}, not {listed}")
        count = self._lengths.shape[1]
        for feature in range(1, count):
            self._check_carried(feature)
        starts = [0, *(k for k in range(1, count) if self._is_gap(k)), count]
        parts = [part for part in pairwise(starts) if not self._is_floor(*part)]
        object.__setattr__(self, "pieces", tuple(self._piece(*part) for part in parts))

    def __eq__(self, other: object) -> bool:
        """Whether all sections are equal to the bit, so that tables serve several runs."""
        return isinstance(other, RailSurface) and self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    @cached_property
    def _content(self) -> bytes:
        """A digest of name and sections."""
        digest = sha256(self.name.encode())
        for section in self.sections:
            digest.update(np.array([section.distance, *section.edges]).tobytes())
            for part in CURVE:
                digest.update(getattr(section.profile, part).tobytes())
        return digest.digest()

    @property
    def start(self) -> float:
        """Distance of the first section [m]."""
        return self.sections[0].distance

    @property
    def end(self) -> float:
        """Distance of the last section [m]."""
        return self.sections[-1].distance

    @cached_property
    def constant(self) -> Profile | None:
        """The profile of all sections, if they are equal."""
        first, *others = (section.profile for section in self.sections)
        same = (np.array_equal(getattr(each, part), getattr(first, part)) for each in others for part in CURVE)
        return first if all(same) else None

    def heading(self, s: ArrayLike) -> Array:
        """Sine of the angle in plan of the rail's own axes at s, outward, a mean over some way, and its rate along s,
        (2, ...) [1, 1/m]."""
        before, behind = np.subtract(s, EVEN), np.add(s, EVEN)
        return np.stack([(f(behind) - f(before)) / (2.0 * EVEN) for f in (self._way_out, self._way_out.derivative())])

    @cached_property
    def _way_out(self) -> scipy.interpolate.PPoly:
        """Integral of the sine of the angle in plan by which the gauge side runs outward: of the ways outward and up,
        by least squares, as fast as its flank, the innermost one, moves along its normal. Where that is more than a
        flange follows there is none."""
        places, sines = [section.distance for section in self.sections], []
        for s in places:
            there = [p.spline for p in self.pieces if p.spline.x[0] <= s <= p.spline.x[-1]]
            rows = np.concatenate([np.column_stack((spline(s), spline(s, 1)[:, :2])) for spline in there])
            u, w, tu, tw, du, dw = rows[rows[:, 0] > INNERMOST].T
            length = np.maximum(np.hypot(tu, tw), 1e-12)
            no, nb, depth = -tw / length, tu / length, (w.max(initial=-1.0) - w) / FLANK
            weight = np.clip(1.0 - depth**2, 0.0, 1.0) * (no < 0.0)
            weight *= np.exp(np.minimum(u[weight > 0.0].min(initial=1.0) - u, 0.0) / BESIDE)
            moves = weight * np.stack((no, nb, no * du + nb * dw))
            outward = round(float(np.linalg.lstsq(moves[:2].T, moves[2])[0][0]), 8)
            followed = np.clip(2.0 - abs(outward) / FOLLOWED, 0.0, 1.0)
            sines.append(outward / np.hypot(1.0, outward) * followed**2 * (3.0 - 2.0 * followed))
        places = [places[0] - 1.0, places[0] - EVEN, *places, places[-1] + EVEN, places[-1] + 1.0]
        return scipy.interpolate.PchipInterpolator(places, [0.0, 0.0, *sines, 0.0, 0.0]).antiderivative()

    def rows(self, s: Array) -> tuple[Array, NDArray[np.int64]]:
        """Points and tangents, of any length, at distances (n,) [m]: rows of all pieces one behind the other
        (n, rows, 4); the first row of every piece, and their number."""
        from wrsim.contact.surfaces.envelope_rows import FALL  # with numba, which a look at a scenario does not need

        curves = []
        for piece in self.pieces:
            knots = piece.spline.x
            inside = np.clip(s, knots[0], knots[-1])
            curve = piece.spline(inside)
            loose = np.where(s < knots[0], piece.open_ends[0], piece.open_ends[1])
            curve[:, :, 1] -= (FALL * np.abs(s - inside) * loose)[:, None]
            curves.append(curve)
        starts = np.cumsum([0, *(curve.shape[1] for curve in curves)])
        return np.ascontiguousarray(np.concatenate(curves, axis=1)), starts

    @cached_property
    def _lengths(self) -> Array:
        """Length of every region of every section, (sections, regions) [m]."""
        return np.array([np.diff(section.edges) for section in self.sections])

    def _beside(self, feature: int) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """In which sections there is rail before a feature, 1 to regions - 1, and behind it."""
        before, behind = self._lengths[:, :feature].sum(axis=1), self._lengths[:, feature:].sum(axis=1)
        return before > SHORTEST, behind > SHORTEST

    def _check_carried(self, feature: int) -> None:
        """Refuse a part of the rail that ends before the next one begins: no rail would carry a wheel between them."""
        before, behind = self._beside(feature)
        if (before & behind).any() or not (before.any() and behind.any()):
            return
        alone = before.astype(int) - behind
        parted = next((i, k) for i, k in pairwise(np.flatnonzero(alone).tolist()) if alone[i] != alone[k])
        end, begin = (self.sections[i].distance for i in parted)
        gap = f"has a gap of {begin - end:.4g} m from {end:.6g} to {begin:.6g} m"
        between = f"where one side of feature {feature} has ended and the other has not begun"
        must = "nothing carries a wheel there; both sides must be there in one section or more"
        raise InputError(f"rail '{self.name}': {gap}, {between}: {must}")

    def _is_gap(self, feature: int) -> bool:
        """Whether a feature, 1 to regions - 1, lies deep wherever there is rail on both sides of it."""
        inner = np.logical_and(*self._beside(feature))
        both = [section for section, there in zip(self.sections, inner, strict=True) if there]
        depths = [section.profile.w.max() - section.profile.at(section.edges[feature])[1] for section in both]
        return bool(depths) and min(depths) > DEEP

    def _is_floor(self, first: int, last: int) -> bool:
        """Whether regions ``first`` to ``last`` - 1 exist and lie deep everywhere, as a floor does."""
        return self._lengths[:, first:last].sum(axis=1).min() > SHORTEST and all(
            section.profile.at(np.linspace(section.edges[first], section.edges[last], 100))[1].max()
            <= section.profile.w.max() - DEEP
            for section in self.sections
        )

    def _piece(self, first: int, last: int) -> Piece:
        """The piece of regions ``first`` to ``last`` - 1."""
        lengths = self._lengths[:, first:last]
        there = np.flatnonzero(lengths.sum(axis=1) > SHORTEST)
        if there.size < 2 or (np.diff(there) > 1).any():
            part = f"the part between features {first} and {last} is there in {there.size} sections"
            raise InputError(f"rail '{self.name}': {part}; it must be there in two or more that follow each other")
        counts = np.maximum(np.ceil(lengths.max(axis=0) / STEP).astype(int), 2)
        rows = np.array([_rows(self.sections[i], first, counts, lengths.max(axis=0)) for i in there])
        s = np.array([self.sections[i].distance for i in there])
        open_ends = (bool(there[0] > 0), bool(there[-1] < len(self.sections) - 1))
        spline = _joined(s, rows, open_ends)
        tops = np.array([self.sections[i].profile.w.max() for i in there])
        return Piece(spline, open_ends, _anchor(counts, (rows[:, :, 1] - tops[:, None]).min(axis=0)))


@dataclass(frozen=True, eq=False)
class Piece:
    """A piece of a surface: rows (n, 4) of u, w and their derivatives along the row's number over s between its first
    and last section; whether the piece ends there; the row with a fixed arclength along s."""

    spline: scipy.interpolate.PPoly
    open_ends: tuple[bool, bool]
    anchor: int

    @cached_property
    def tops(self) -> Array:
        """Height above which a row does not come between two sections, (sections - 1, n) [m]: the highest of the four
        control points of its cubic (Bernstein's form)."""
        c, h = self.spline.c[:, :, :, 1], np.diff(self.spline.x)[:, None]
        cubic, square, slope = c[0] * h**3, c[1] * h**2, c[2] * h
        inner = c[3] + slope / 3.0, c[3] + (2.0 * slope + square) / 3.0
        return np.asarray(np.max((c[3], *inner, c[3] + slope + square + cubic), axis=0))


def _anchor(counts: NDArray[np.int64], heights: Array) -> int:
    """The row with a fixed arclength along s: the highest inner feature (or the middle) if wheels come there, else the
    highest row; heights: least of every row, relative to the highest point of its section [m].

    The effective profile of an edge that falls off steeply may jump along the track, and with it the arclength of all
    rows beyond it.
    """
    inner = np.cumsum(counts)[:-1].tolist() or [int(counts.sum()) // 2]
    best = max(inner, key=lambda row: float(heights[row]))
    return best if heights[best] > -DEEP else int(np.argmax(heights))


def _rows(section: RailSection, first: int, counts: NDArray[np.int64], longest: Array) -> Array:
    """Rows of some regions of a section, (sum of counts + 1, 4); longest: largest length of each region [m].

    Ends of a piece are counted by length from their feature, for some profiles are recorded deeper than others. Where a
    section has less of an end it goes on straight, or down where it ends on its top.
    """
    edges = section.edges[first : first + counts.size + 1].copy()
    if counts.size > 1:
        edges[0], edges[-1] = edges[1] - longest[0], edges[-2] + longest[-1]
    share = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(edges, edges[1:], counts, strict=False)]
    arc = np.concatenate((*share, edges[-1:]))
    rate = np.gradient(arc)
    inside = np.clip(arc, *section.edges[[first, first + counts.size]])
    tangent = np.array(section.profile.tangent(inside))
    way = np.sign(arc - inside)
    tangent = np.where(way * tangent[1] > -FALLING * np.abs(way), np.array([[0.0], [-1.0]]) * way, tangent)
    return np.column_stack((*(np.array(section.profile.at(inside)) + (arc - inside) * tangent), *(rate * tangent)))


def _joined(s: Array, rows: Array, open_ends: tuple[bool, bool]) -> scipy.interpolate.PPoly:
    """Cubics through rows (sections, n, 4) at s; level at the ends where the rail is constant beyond.

    The rail's curvature along the track enters the contact, so cubics meet with the same second derivative, except at a
    section where that leads far off the slope by its neighbours, as where a planed stretch begins: it takes theirs. All
    rows have the same weights, so that the joined tangents are those of the joined points.
    """
    local, least = _local_slopes(s, rows, open_ends)
    most = AS_FAR * np.maximum(least, _size(local[1:-1]))
    broken = np.zeros(s.size, dtype=bool)
    broken[[0, -1]] = True
    while True:
        slopes = local.copy()
        for first, last in pairwise(np.flatnonzero(broken).tolist()):
            if last > first + 1:
                spline_rows = slice(first, last + 1)
                ends = ((1, local[first]), (1, local[last]))
                spline = scipy.interpolate.CubicSpline(s[spline_rows], rows[spline_rows], bc_type=ends)
                slopes[first + 1 : last] = spline(s[spline_rows][1:-1], 1)
        more = np.append(np.append(False, _size((slopes - local)[1:-1]) > most), False) & ~broken
        if not more.any():
            return scipy.interpolate.CubicHermiteSpline(s, rows, slopes)
        broken |= more


def _local_slopes(s: Array, rows: Array, open_ends: tuple[bool, bool]) -> tuple[Array, Array]:
    """Slope of every section by the two secants on either side, the more of the side that is straighter (H. Akima,
    Journal of the ACM 17, 1970, with the mean of neighbours added to each weight so that level stretches stay level),
    held back against overshoot (F. N. Fritsch and R. E. Carlson, SIAM Journal on Numerical Analysis 17, 1980); size of
    the smaller secant beside each inner section."""
    secants = np.diff(rows, axis=0) / np.diff(s)[:, None, None]
    ends = [secants[[end]] * float(loose) for end, loose in zip((0, -1), open_ends, strict=True)]
    beyond = np.concatenate((ends[0], ends[0], secants, ends[1], ends[1]))
    bent = _size(np.diff(beyond, axis=0)) + 0.5 * _size(beyond[1:] + beyond[:-1])
    behind, ahead = bent[:-2], bent[2:]
    total = behind + ahead
    share = np.where(total > 0.0, ahead / np.where(total > 0.0, total, 1.0), 0.5)[:, None, None]
    slopes = share * beyond[1:-2] + (1.0 - share) * beyond[2:-1]
    least = np.minimum(_size(beyond[1:-2]), _size(beyond[2:-1]))
    slopes *= np.minimum(STEEPEST_OVER * least / np.maximum(_size(slopes), 1e-30), 1.0)[:, None, None]
    return slopes, least[1:-1]


def _size(rates: Array) -> Array:
    """Root of the mean square of the points' rates, of every section."""
    return np.asarray(np.sqrt((rates[:, :, :2] ** 2).mean(axis=(1, 2))))


COLUMNS: dict[str, Any] = {
    "at_m": Annotated[float, number(-1e6, 1e6, "m along the track, from where the table is laid")],
    "outward_mm": Annotated[float, number(-1000, 1000, "mm away from the track centre")],
    "up_mm": Annotated[float, number(-1000, 1000, "mm")],
    "feature": str,
}
NEEDED = ("at_m", "outward_mm", "up_mm")


def read_sections(path: Path, measured: bool = False) -> list[RailSection]:
    """Sections in the order of the table.

    Consecutive rows with one ``at_m`` are the points of one section, from one of its ends to the other. measured:
    points are smoothed, not interpolated. Also a list of profiles (.slcs). Raises InputError with file and line.
    """
    if path.suffix.lower() == ".slcs":
        return _sections_of_slices(path)
    table, lines = read_columns(path, COLUMNS, NEEDED, "points")
    places = table["at_m"]
    starts = np.flatnonzero(np.append(True, np.diff(places) != 0.0))
    marks = table.get("feature", np.full(places.size, ""))
    sections: list[RailSection] = []
    for row in np.split(np.arange(places.size), starts[1:]):
        place = float(places[row[0]])
        if sections and place <= sections[-1].distance:
            more = f"must be more than {sections[-1].distance:g} of the section before, or its points together"
            raise InputError(f"{path}:{lines[row[0]]}: at_m = {place:g}: {more}")
        points = ProfilePoints(str(path), 1e-3 * table["outward_mm"][row], 1e-3 * table["up_mm"][row], lines[row])
        retained = points.without_duplicates().in_order()
        check_points(retained)
        profile = (smoothed if measured else interpolated)(retained, f"{path.stem}, {place:g} m", "rail", path.name)
        sections.append(RailSection(place, profile, _features(points, marks[row], profile)))
    return sections


def _sections_of_slices(path: Path) -> list[RailSection]:
    """The sections of a list of profiles, y to the field side. Raises InputError."""
    slices, sections = read_slices(path), []
    for place, file, line, features in zip(
        1e-3 * slices.places, slices.files, slices.lines, slices.features, strict=True
    ):
        try:
            profile = read_points(file, "rail", field_side="positive").profile
        except InputError as error:
            raise InputError(f"{path}:{line}: {error}") from None
        sections.append(RailSection(float(place), profile, tuple((1e-3 * features).tolist())))
    # the ends of the profiles are no features
    ends = np.array([section.profile.length for section in sections])
    marks = np.array([section.features for section in sections]).reshape(len(sections), -1)
    inner = ((marks > SHORTEST) & (marks < ends[:, None] - END)).any(axis=0)
    marks = np.minimum(marks[:, inner], ends[:, None])
    return [replace(section, features=tuple(row.tolist())) for section, row in zip(sections, marks, strict=True)]


def _features(points: ProfilePoints, marks: NDArray[Any], profile: Profile) -> tuple[float, ...]:
    """Arclengths of the numbered features of a section [m]."""
    places: dict[int, float] = {}
    for i in np.flatnonzero(np.char.strip(marks.astype(str)) != ""):
        where = f"{points.file}:{points.line[i]}: feature = {shown_value(str(marks[i]))}"
        for word in str(marks[i]).split():
            if not word.isdecimal() or int(word) < 1:
                raise InputError(f"{where}: must be numbers of features, 1, 2, ..., apart from each other by blanks")
            if int(word) in places:
                raise InputError(f"{where}: duplicate feature {int(word)} in this section")
            # the node of the point, or the nearest one where points are smoothed
            node = np.argmin(np.hypot(profile.u - points.u[i], profile.w - points.w[i]))
            places[int(word)] = float(profile.arclength[node])
    missing = sorted(set(range(1, len(places) + 1)) - places.keys())
    if missing:
        where = f"{points.file}:{points.line[0]}: feature {missing[0]} is missing in the section that begins here"
        raise InputError(f"{where}; a part that does not exist in a section has its features on one point")
    return tuple(places[k] for k in sorted(places))
