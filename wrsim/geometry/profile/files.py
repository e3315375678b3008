"""Files of profile points: from any format and orientation to a `Profile`.

Exact points (designs, exported splines) are interpolated, measured ones smoothed. Nothing is repaired that
could change the shape: steps back, zig-zags, gaps and crossings are refused with the line they stand on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

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
SIDES = ("positive", "negative")
"""Sign that a file's lateral coordinate has on the field side."""
FARTHEST = 1e3
"""Largest coordinate of a point, m."""


@dataclass(frozen=True)
class Format:
    """A file format: its suffixes, each with the body that it stands for, if any, and its reader."""

    suffixes: dict[str, Kind | None]
    parse: Callable[[list[str], str], Scan]


PROFILE_FILES = {
    "columns": Format({".csv": None, ".txt": None, ".dat": None}, formats.parse_columns),
    "simpack": Format({".prr": "rail", ".prw": "wheel"}, formats.parse_simpack),
    "miniprof": Format({".ban": "rail", ".whl": "wheel"}, formats.parse_miniprof),
}
"""Formats by the name that files use in their key ``format``."""


@dataclass(frozen=True)
class Reading:
    """Points of a file, upright, in order and checked, and what is to become of them.

    measured: smoothed, not interpolated; cutoff: wavelength at which smoothing halves a wave [m].
    """

    points: ProfilePoints
    kind: Kind
    name: str
    source: str
    measured: bool
    cutoff: float = CUTOFF

    def profile(self) -> Profile:
        """The profile through the points, smoothed or interpolated. Raises InputError where that cannot be."""
        if not self.measured:
            return interpolated(self.points, self.name, self.kind, self.source)
        source = f"{self.source}; smoothed, cut-off {1e3 * self.cutoff:g} mm"
        return smoothed(self.points, self.name, self.kind, source, self.cutoff)


def read_profile(path: str | Path, kind: Kind | None = None, **options: Any) -> Profile:
    """Read a file of points as a profile; options and errors as for `read_points`."""
    return read_points(path, kind, **options).profile()


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

    kind: ``"wheel"`` or ``"rail"``; None: from the file or its suffix. format: a key of `PROFILE_FILES`; None: by
    the suffix. name, source: for messages and figures; None: from the file. measured: smooth the points (True) or
    interpolate them (False); None: smooth MiniProf measurements, interpolate the rest, which is refused where the
    points scatter. cutoff: wavelength at which smoothing halves a wave [m]; None: 5 mm. unit: ``"mm"``, ``"m"`` or
    ``"in"``; None: from the file, or mm. heights: whether the file's heights grow ``"up"`` or ``"down"``; None:
    from format or header, or by the shape (a flange points down, the sides of a rail head hang down).
    field_side: sign of the file's lateral coordinate on the field side, ``"positive"`` or ``"negative"``; None: for a
    wheel with a flange by the shape, otherwise positive. clip: keep only the points between these u [m], after all of
    the above. turn: of the profile about its origin [rad], positive: top towards the gauge side (u negative). shift:
    outward and up [m], last of all.

    Raises InputError with file, line and what is allowed.
    """
    path = Path(path)
    _one_of(path, "kind", kind, KINDS)
    _one_of(path, "unit", unit, tuple(METRES))
    _one_of(path, "heights", heights, HEIGHTS)
    _one_of(path, "field_side", field_side, SIDES)
    layout = _layout(path, format)
    scan = layout.parse(formats.read_lines(path), str(path))
    body = _body(path, kind, scan.kind or layout.suffixes.get(path.suffix.lower()))

    metres = METRES[unit] if unit else scan.unit or METRES["mm"]
    lateral, height = (metres * a for a in scan.arrays())
    far = np.flatnonzero(np.maximum(np.abs(lateral), np.abs(height)) > FARTHEST)
    if far.size:
        far_off = f"{np.hypot(lateral[far[0]], height[far[0]]):.4g} m from the origin; allowed: {FARTHEST:g} m"
        raise InputError(f"{path}:{scan.line[far[0]]}: this point lies {far_off}. Is the unit right?")
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


def _one_of(path: Path, key: str, value: str | None, allowed: Sequence[str]) -> None:
    if value is not None and value not in allowed:
        raise InputError(f"{path}: {key} = '{value}'; allowed: {', '.join(allowed)}{suggest(value, allowed)}")


def suffix_fault(path: Path) -> str | None:
    """What is wrong with the suffix of a file of points, in words; None where it names a format."""
    known = [s for layout in PROFILE_FILES.values() for s in layout.suffixes]
    if path.suffix.lower() in known:
        return None
    return f"no profile format has the suffix '{path.suffix}'; allowed: {', '.join(known)}"


def _layout(path: Path, format: str | None) -> Format:
    """The format by name or by suffix."""
    _one_of(path, "format", format, tuple(PROFILE_FILES))
    if format is not None:
        return PROFILE_FILES[format]
    if fault := suffix_fault(path):
        raise InputError(f"{path}: {fault}")
    return next(layout for layout in PROFILE_FILES.values() if path.suffix.lower() in layout.suffixes)


def _body(path: Path, wanted: Kind | None, stated: Kind | None) -> Kind:
    """Wheel or rail, by the caller and by the file, which must agree."""
    if wanted is None and stated is None:
        raise InputError(f"{path}: unknown whether this is a wheel or a rail; give kind")
    if wanted is not None and stated is not None and wanted != stated:
        raise InputError(f"{path}: this is a {stated} profile; a {wanted} is needed here")
    return wanted or stated  # type: ignore[return-value]


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
    return ProfilePoints(file, sign_u * points.u, sign_w * points.w, points.line)


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
