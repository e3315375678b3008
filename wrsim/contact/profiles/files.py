"""Files of profile points: from any format and orientation to a `Profile`.

Bytes, a `Scan` of what stands in the file, points in the axes used here with notes on what was assumed, repairs that
keep the shape where wheels and rails touch, a curve. Exact points (designs, exported splines) are interpolated,
measured ones smoothed. Steps back, zig-zags, gaps over which the curve turns and crossings are refused with their line.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, get_args

import numpy as np

from wrsim.contact.profiles import formats, program_formats
from wrsim.contact.profiles.formats import METRES, Scan, Side
from wrsim.contact.profiles.placing import WIDTHS, Heights, Origin, aligned, check_gauge_side, groove_of, placed
from wrsim.contact.profiles.points import (
    CUTOFF,
    LARGEST_GAP,
    LARGEST_TURN,
    ProfilePoints,
    check_count,
    check_points,
    curvature_scatter,
    cutoff_for,
    interpolated,
    scatter,
    smoothed,
    turns,
)
from wrsim.contact.profiles.profile import KINDS, Kind, Profile
from wrsim.contact.profiles.repair import filled, joined, rounded
from wrsim.errors import InputError, suggest

HEIGHTS, SIDES, ORIGINS = (get_args(choice) for choice in (Heights, Side, Origin))
FARTHEST = 1e3  # largest coordinate of a point, m
CLOSE = 1e-3  # cut-off of the curve of which a workshop's measures are taken [m]: it follows the points to a micrometre
HEAD = 30e-3  # a groove nearer to the field end of a rail is beside it on that side [m]: half of a head
LEVEL = 1e-6  # height of the tread at the tape circle from which it is told [m]
CLEAR_TURN = 10.0  # distance of points over their scatter at which noise turns the curve by 14 degrees, one deviation


class Format(NamedTuple):
    """A file format: its reader, and its suffixes with the body of each, if any."""

    parse: Callable[[list[str], str], Scan]
    suffixes: dict[str, Kind | None]


PROFILE_FILES = {  # by the name that files use in their key ``format``
    "columns": Format(
        formats.parse_columns, {".csv": None, ".txt": None, ".dat": None, ".wheel": "wheel", ".rail": "rail"}
    ),
    "simpack": Format(program_formats.parse_simpack, {".prr": "rail", ".prw": "wheel"}),
    "miniprof": Format(program_formats.parse_miniprof, {".ban": "rail", ".whl": "wheel"}),
    "vampire": Format(program_formats.parse_vampire, {".rai": "rail", ".whe": "wheel"}),
}
SLICES = {".slcs": "sections along the track: table of [[track.rail_sections]]",
          ".slcw": "sections over the angle: table of [[out_of_round]], kind sections"}  # fmt: skip
"""Suffixes of lists of profiles, and where they are used."""

_reading: ContextVar[Mapping[Kind, Mapping[str, Any]]] = ContextVar("how files of points are read")


@contextmanager
def reading_as(options: Mapping[Kind, Mapping[str, Any]]) -> Iterator[None]:
    """Within this block, files of points of a kind are read with these options of `read_points`; what a profile file
    or a caller says itself wins."""
    outer = _reading.get({})
    token = _reading.set({kind: {**outer.get(kind, {}), **_given(options.get(kind, {}))} for kind in KINDS})
    try:
        yield
    finally:
        _reading.reset(token)


def reading_options(
    unit: str | None = None, heights: str | None = None, field_side: str | None = None, origin: str | None = None,
    back_to_tape_circle_mm: float | None = None, measured: bool | None = None, cutoff: float | None = None,
    align: Profile | None = None,
) -> AbstractContextManager[None]:  # fmt: skip
    """`reading_as` with keys of a profile of kind ``points`` for wheels and rails alike; field_side is of rails, origin
    and back_to_tape_circle_mm of wheels; cutoff [mm]."""
    cutoff, back = (None if mm is None else 1e-3 * mm for mm in (cutoff, back_to_tape_circle_mm))
    common = {"unit": unit, "heights": heights, "measured": measured, "cutoff": cutoff, "align": align}
    return reading_as({"wheel": common | {"origin": origin, "back": back}, "rail": common | {"field_side": field_side}})


@dataclass(frozen=True)
class Reading:
    """Points of a file, placed and checked, and the curve through them.

    points: None of a shape by formula; measured: the curve is smoothed with the cut-off [m], not interpolated;
    instrument: measures that stand in the file [mm].
    """

    points: ProfilePoints | None
    profile: Profile
    measured: bool = False
    cutoff: float = CUTOFF
    instrument: Mapping[str, float] = field(default_factory=dict)

    def smoothed(self, cutoff: float) -> "Reading":
        """The same smoothed with another cut-off [m]. Raises InputError where the points are too far apart."""
        profile = self.profile
        if self.points is None:
            raise InputError(f"{profile.name}: is a shape by formula, with no points to smooth")
        curve = _curve(self.points, profile.kind, profile.name, self.points.file, True, cutoff)
        curve = replace(curve, notes=profile.notes, back=profile.back, head=profile.head)
        return replace(self, profile=curve, measured=True, cutoff=cutoff)

    @property
    def close(self) -> Profile:
        """The curve that follows the points, for what a workshop measures."""
        if not self.measured or self.points is None:
            return self.profile
        return self.smoothed(max(CLOSE, 2.01 * float(self.points.chords.max()))).profile


def stating_back(profile: Profile) -> Profile:
    """A wheel by formula with the distance of its flange back that `reading_as` states, if any."""
    back = _reading.get({}).get(profile.kind, {}).get("back")
    return profile if back is None or profile.back is not None else replace(profile, back=back)


def notes_of(profiles: Iterable[Profile]) -> tuple[str, ...]:
    """What was assumed of the files of some profiles, a line a file."""
    return tuple(dict.fromkeys(note for profile in profiles for note in profile.notes))


def noted(profiles: Iterable[Profile]) -> dict[str, str]:
    """The same as attribute of a result, where there is any."""
    notes = notes_of(profiles)
    return {"profile_notes": "\n".join(notes)} if notes else {}


def check_alignable(readings: Mapping[str, Reading], align: str, unworn: Profile) -> None:
    """Raise InputError where an unworn profile (`aligned`) is of another body than one of the readings, by names, or
    where one has no points."""
    for name, reading in readings.items():
        kind = reading.profile.kind
        if kind != unworn.kind:
            raise InputError(f"--align {align}: is a {unworn.kind}; {name} is a {kind}")
        if reading.points is None:
            raise InputError(f"--align {align}: {name} is a shape by formula, with no points to align")


def read_points(
    path: str | Path,
    kind: Kind | None = None,
    *,
    format: str | None = None,
    name: str | None = None,
    source: str | None = None,
    clip: tuple[float, float] | None = None,
    turn: float = 0.0,
    shift: tuple[float, float] = (0.0, 0.0),
    **stated: Any,
) -> Reading:
    """Read a file of points.

    The options are the keys of a profile of kind ``points`` (docs/user/profiles.md) in SI units: clip, shift [m], turn
    [rad]; further ones measured, unit, heights, field_side, origin, and cutoff, back [m]; usual_back [m]: where the
    file has none; align: the unworn profile, see `aligned`. Those left out are taken from `reading_as`, the file, its
    suffix or its shape. Raises InputError with file, line and what is allowed.
    """
    path = Path(path)
    scan, body = _scanned(path, kind, format)
    options = _checked(path, stated, _reading.get({}).get(body, {}))
    points, digit, notes = _metric(scan, options.get("unit"), body)
    measured, cutoff = options.get("measured", scan.measured), options.get("cutoff")
    points, joints = _cleaned(points, bool(measured))
    unworn: Profile | None = options.get("align")
    onto = unworn if unworn is not None and unworn.kind == body else None
    place = placed(points, body, scan, options, None if onto else shift[0])
    points = place.points.turned(turn) if turn else place.points
    if onto:
        points, alignment = aligned(points, onto)
        joints.append(alignment)
    if clip is not None:
        points = points.clipped(*clip)
    points = replace(points, u=points.u + shift[0])
    noisy = measured is None and (cutoff is not None or curvature_scatter(points, digit) > 0.0)
    smooth = bool(measured or noisy)
    if cutoff is None:
        cutoff = cutoff_for(points, digit) if noisy else CUTOFF
    points, corners = rounded(points, body, 0.5 * np.pi if smooth else LARGEST_TURN)
    points, gaps = filled(points, body, min(LARGEST_GAP * float(points.chords.sum()), 0.5 * cutoff))
    check_points(points)
    head = _head_of(points, bool(options.get("field_side") or scan.field_side)) if body == "rail" else 0
    notes += [*scan.notes, *joints, *place.notes, *corners, *gaps]
    if noisy:
        smoothing = f"smoothed with a cut-off of {1e3 * cutoff:.2g} mm (measured, cutoff_mm)"
        notes.append(f"the points scatter by {1e6 * scatter(points):.2g} um: {smoothing}")
    curve = _curve(points, body, name or scan.name or path.stem, source or scan.source or path.name, smooth, cutoff)
    tread = _tread_height(curve)
    if abs(tread) > LEVEL:
        notes.append(f"moved by {-1e3 * tread:.3f} mm to height 0 at the tape circle")
    line = (f"{path.name}: {'; '.join(notes)}",) if notes else ()
    begin = float(curve.arclength[np.argmin(np.hypot(curve.u - points.u[head], curve.w - points.w[head]))])
    up = shift[1] - tread
    curve = replace(curve, w=curve.w + up, notes=line, back=place.back, head=begin if head else 0.0)
    return Reading(replace(points, w=points.w + up), curve, smooth, cutoff, scan.instrument)


def _scanned(path: Path, kind: Kind | None, format: str | None) -> tuple[Scan, Kind]:
    """Content of a file, and whose profile it is. Raises InputError."""
    if kind is not None and kind not in KINDS:
        raise InputError(f"{path}: kind = '{kind}'; allowed: {', '.join(KINDS)}{suggest(kind, KINDS)}")
    suffix = path.suffix.lower()
    if format is None and (fault := suffix_fault(path)):
        raise InputError(f"{path}: {fault}")
    layout = PROFILE_FILES[format or next(name for name, f in PROFILE_FILES.items() if suffix in f.suffixes)]
    scan = layout.parse(formats.read_lines(path), str(path))
    by_file = scan.kind or layout.suffixes.get(suffix)
    body = kind or by_file
    if body is None:
        raise InputError(f"{path}: unknown whether this is a wheel or a rail; give kind (--kind)")
    if by_file not in (None, body):
        raise InputError(f"{path}: this is a {by_file} profile; a {kind} is needed here")
    return scan, body


def _head_of(rail: ProfilePoints, side_stated: bool) -> int:
    """Index of the point of a rail at which its head begins, beside a check rail. Raises InputError."""
    valley = groove_of(rail)
    head = 0 if valley is None or rail.u[valley] > rail.u[-1] - HEAD else valley
    if not side_stated:
        check_gauge_side(rail[head:])
    return head


def _tread_height(curve: Profile) -> float:
    """Height of a wheel's tread at the tape circle [m]; 0 where it is not on the curve."""
    within = curve.kind == "wheel" and curve.u.min() <= 0.0 <= curve.u.max()
    return float(curve.at(curve.arclength_of(0.0))[1]) if within else 0.0


def _given(options: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in options.items() if value is not None}


def _checked(path: Path, stated: Mapping[str, Any], defaults: Mapping[str, Any]) -> dict[str, Any]:
    """How a file is read, of what is not None. Raises InputError for a word that is none."""
    options = {**defaults, **_given(stated)}
    allowed = {"unit": (*METRES,), "heights": HEIGHTS, "field_side": SIDES, "origin": ORIGINS}
    for key, terms in allowed.items():
        if (word := options.get(key)) not in (None, *terms):
            raise InputError(f"{path}: {key} = '{word}'; allowed: {', '.join(terms)}{suggest(str(word), terms)}")
    return options


def _metric(scan: Scan, unit: str | None, body: Kind) -> tuple[ProfilePoints, float, list[str]]:
    """Points and their last digit in metres, and a note where their unit is assumed. Raises InputError for no wheel's
    or rail's width."""
    path, metres = scan.file, METRES[unit] if unit else scan.unit or METRES["mm"]
    lateral, height = metres * np.array(scan.lateral), metres * np.array(scan.height)
    far = np.flatnonzero(np.maximum(np.abs(lateral), np.abs(height)) > FARTHEST)
    if far.size:
        i = far[0]
        far_off = f"{np.hypot(lateral[i], height[i]):.4g} m from the origin; allowed: {FARTHEST:g} m"
        raise InputError(f"{path}:{scan.line[i]}: this point lies {far_off}. Is the unit right?")
    points = ProfilePoints(path, lateral, height, np.array(scan.line, dtype=np.intp))
    points = points.without_duplicates(metres * scan.resolution, metres * scan.least_distance)
    check_count(points)
    wide, (low, high) = float(np.ptp(np.quantile(points.u, (0.01, 0.99)))), WIDTHS[body]  # a point may be wrong
    if not low <= wide <= high:
        allowed = f"allowed: {1e3 * low:g} to {1e3 * high:g} mm. Is the unit right? Give unit"
        raise InputError(f"{path}: the {body} is {1e3 * wide:.4g} mm wide; {allowed}: {', '.join(METRES)}")
    return points, metres * scan.resolution, [] if unit or scan.unit else ["in mm by its width (unit)"]


def _cleaned(points: ProfilePoints, measured: bool) -> tuple[ProfilePoints, list[str]]:
    """Points thinned where their scatter turns the curve back; of a scan without what was scanned twice."""
    points, notes = joined(points) if measured else (points, [])
    if (np.abs(turns(points)) > 0.5 * np.pi).any():
        thin = points.without_duplicates(0.0, CLEAR_TURN * scatter(points))
        if len(thin) < len(points):
            return joined(thin) if measured else (thin, [])
    return points, notes


def _curve(points: ProfilePoints, kind: Kind, name: str, source: str, measured: bool, cutoff: float) -> Profile:
    """The profile through the points. Raises InputError where they are too far apart or scatter."""
    if not measured:
        return interpolated(points, name, kind, source)
    return smoothed(points, name, kind, f"{source}; smoothed, cut-off {1e3 * cutoff:.3g} mm", cutoff)


def suffix_fault(path: Path) -> str | None:
    """What is wrong with the suffix of a file of points, in words; None where it names a format."""
    known = [s for layout in PROFILE_FILES.values() for s in layout.suffixes]
    suffix = path.suffix.lower()
    if suffix in known:
        return None
    if suffix in SLICES:
        return f"is a list of {SLICES[suffix]}; a profile is needed here, such as one of those it names"
    return f"no profile format has the suffix '{path.suffix}'; allowed: {', '.join(known)}"
