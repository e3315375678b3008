"""Files of profile points: from any format and orientation to a `Profile`.

Exact points (designs, exported splines) are interpolated, measured ones smoothed. Nothing is repaired that could change
the shape: steps back, zig-zags, gaps and crossings are refused with their line.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from wrsim.errors import InputError, suggest
from wrsim.geometry.profile import formats
from wrsim.geometry.profile.formats import METRES, Scan
from wrsim.geometry.profile.points import (
    CUTOFF,
    ProfilePoints,
    check_count,
    check_points,
    interpolated,
    smoothed,
    turns,
)
from wrsim.geometry.profile.profile import KINDS, Kind, Profile

HEIGHTS = ("up", "down")
SIDES = ("positive", "negative")  # sign that a file's lateral coordinate has on the field side
FARTHEST = 1e3  # largest coordinate of a point, m


class Format(NamedTuple):
    """A file format: its reader, and its suffixes with the body of each, if any."""

    parse: Callable[[list[str], str], Scan]
    suffixes: dict[str, Kind | None]


PROFILE_FILES = {  # by the name that files use in their key ``format``
    "columns": Format(formats.parse_columns, {".csv": None, ".txt": None, ".dat": None}),
    "simpack": Format(formats.parse_simpack, {".prr": "rail", ".prw": "wheel"}),
    "miniprof": Format(formats.parse_miniprof, {".ban": "rail", ".whl": "wheel"}),
}


@dataclass(frozen=True)
class Reading:
    """Points of a file, upright, in order and checked; measured: smoothed with the cut-off [m], not interpolated."""

    points: ProfilePoints
    kind: Kind
    name: str
    source: str
    measured: bool
    cutoff: float = CUTOFF

    def profile(self) -> Profile:
        """The profile through the points. Raises InputError where they are too far apart or scatter."""
        if not self.measured:
            return interpolated(self.points, self.name, self.kind, self.source)
        source = f"{self.source}; smoothed, cut-off {1e3 * self.cutoff:g} mm"
        return smoothed(self.points, self.name, self.kind, source, self.cutoff)


def read_points(
    path: str | Path,
    kind: Kind | None = None,
    *,
    format: str | None = None,
    name: str | None = None,
    source: str | None = None,
    measured: bool | None = None,
    cutoff: float | None = None,
    unit: str | None = None,
    heights: str | None = None,
    field_side: str | None = None,
    clip: tuple[float, float] | None = None,
    turn: float = 0.0,
    shift: tuple[float, float] = (0.0, 0.0),
) -> Reading:
    """Read a file of points.

    The options are the keys of a profile of kind ``points`` (docs/user/profiles.md) in SI units: cutoff, clip, shift
    [m], turn [rad]; those left out are taken from the file, its suffix or its shape. Raises InputError with file, line
    and what is allowed.
    """
    path = Path(path)
    if kind is not None and kind not in KINDS:
        raise InputError(f"{path}: kind = '{kind}'; allowed: {', '.join(KINDS)}{suggest(kind, KINDS)}")
    suffix = path.suffix.lower()
    if format is None and (fault := suffix_fault(path)):
        raise InputError(f"{path}: {fault}")
    layout = PROFILE_FILES[format or next(name for name, f in PROFILE_FILES.items() if suffix in f.suffixes)]
    scan = layout.parse(formats.read_lines(path), str(path))
    stated = scan.kind or layout.suffixes.get(suffix)
    body = kind or stated
    if body is None:
        raise InputError(f"{path}: unknown whether this is a wheel or a rail; give kind (--kind)")
    if stated not in (None, body):
        raise InputError(f"{path}: this is a {stated} profile; a {kind} is needed here")

    metres = METRES[unit] if unit else scan.unit or METRES["mm"]
    lateral, height = metres * np.array(scan.lateral), metres * np.array(scan.height)
    far = np.flatnonzero(np.maximum(np.abs(lateral), np.abs(height)) > FARTHEST)
    if far.size:
        i = far[0]
        far_off = f"{np.hypot(lateral[i], height[i]):.4g} m from the origin; allowed: {FARTHEST:g} m"
        raise InputError(f"{path}:{scan.line[i]}: this point lies {far_off}. Is the unit right?")
    points = ProfilePoints(str(path), lateral, height, np.array(scan.line, dtype=np.intp))
    points = points.without_duplicates(metres * scan.resolution, metres * scan.least_distance)
    check_count(points)
    points = _oriented(points, body, heights or scan.heights, field_side or scan.field_side).in_order()
    if turn:
        points = points.turned(turn)
    if clip is not None:
        points = points.clipped(*clip)
    check_points(points)

    return Reading(
        replace(points, u=points.u + shift[0], w=points.w + shift[1]),
        body,
        name or scan.name or path.stem,
        source or scan.source or path.name,
        measured=bool(scan.measured) if measured is None else measured,
        cutoff=CUTOFF if cutoff is None else cutoff,
    )


def suffix_fault(path: Path) -> str | None:
    """What is wrong with the suffix of a file of points, in words; None where it names a format."""
    known = [s for layout in PROFILE_FILES.values() for s in layout.suffixes]
    if path.suffix.lower() in known:
        return None
    return f"no profile format has the suffix '{path.suffix}'; allowed: {', '.join(known)}"


def _oriented(points: ProfilePoints, body: Kind, heights: str | None, field_side: str | None) -> ProfilePoints:
    """Turn u outward and w up, by what is stated or by the shape; InputError if both contradict."""
    sign_u = {"positive": 1.0, "negative": -1.0, None: 0.0}[field_side]
    sign_w = {"up": 1.0, "down": -1.0, None: 0.0}[heights]
    up, out = _shape(points, body)
    file = points.file
    if not sign_w:
        if not up:
            raise InputError(f"{file}: the direction of its heights is unknown; give heights: up or down")
        sign_w = up
    elif up and up != sign_w:
        part = "flange points" if body == "wheel" else "head is"
        raise InputError(f"{file}: the {part} the wrong way up with heights '{heights}'; is it the other one?")
    if not sign_u:
        sign_u = out or 1.0
    elif out and out != sign_u:
        raise InputError(f"{file}: the flange is on the field side with field_side '{field_side}'")
    return replace(points, u=sign_u * points.u, w=sign_w * points.w)


def _shape(points: ProfilePoints, body: Kind) -> tuple[float, float]:
    """Signs (of heights, of lateral) that put the shape upright; 0 where it is ambiguous."""
    if body == "rail":
        # From left to right over an upright rail head the tangent turns down by nearly half a turn.
        total = float(turns(points.in_order()).sum())
        return (-np.sign(total) if abs(total) > np.radians(30.0) else 0.0), 0.0
    # A flange is the far excursion from the tread, where most of the width is.
    w = points.w - np.median(points.w)
    i = int(np.argmax(np.abs(w)))
    if abs(w[i]) < 0.1 * np.ptp(points.u):
        return 0.0, 0.0
    return -np.sign(w[i]), -np.sign(points.u[i] - np.median(points.u))
