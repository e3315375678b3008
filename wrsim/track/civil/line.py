"""A line as civil data have it: rows of elements of plan, profile and cant over the distance in plan.

Lengths are in m, headings in rad from the east, counter-clockwise; curvature is positive to the left, cant is the
height of each rail above the profile. Joints that a file gives twice, by its points and by its elements, are compared.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np

from wrsim.errors import InputError
from wrsim.track import alignment
from wrsim.track.cant import Pivot
from wrsim.track.forms import CantForm, Form
from wrsim.track.piecewise import Array
from wrsim.track.rail import CentreLine
from wrsim.track.segments import LONGEST, ROUNDING, TIGHTEST, Laws, Segment

RAILS: dict[Pivot, Callable[[float], tuple[float, float]]] = {
    "centre line": lambda cant: (-0.5 * cant, 0.5 * cant),
    "low rail": lambda cant: (max(-cant, 0.0), max(cant, 0.0)),
    "high rail": lambda cant: (min(-cant, 0.0), min(cant, 0.0)),
    "left rail": lambda cant: (0.0, cant),
    "right rail": lambda cant: (-cant, 0.0),
}
"""Heights of both rails above the profile for a cant, positive with the right rail high, about a pivot [m]."""
MOST = 100_000
"""Most elements of a row; a line of 1000 km has some thousand."""
JOINT = 5e-3
"""Largest distance of the end of an element from the next start [m].

Civil data are rounded to 1 mm and directions to 1e-6 rad: both points 0.7 mm, the length 0.5 mm, a radius of 300 m by
1 mm over 300 m another 0.5 mm, the direction over 1000 m 1 mm; in sum 3.4 mm."""
TURN = 1e-4
"""Largest difference of directions at a joint [rad]: 1 mm of length in the tightest curve of 10 m."""
SHORT = 1e-3
"""Shortest element [m]: civil data are rounded to it."""
SHARPEST = 0.5
"""Largest curvature [1/m]: a radius of 2 m, below any track."""


@dataclass(frozen=True)
class Plan(alignment.Horizontal):
    """An element in plan. pose: east, north [m] and heading [rad] of its start as the file tells them; line: of the
    file."""

    pose: tuple[float, float, float] | None = None
    line: int = 0


@dataclass(frozen=True)
class Profile(alignment.Vertical):
    """An element of the profile. height: of its start [m]; line: of the file."""

    height: float = 0.0
    line: int = 0

    @property
    def end(self) -> float:
        """Distance in plan of its end [m]."""
        return self.start + self.length

    @property
    def end_height(self) -> float:
        """Height of its end [m]."""
        if self.form == "circle":
            return self.height + self.length * math.tan(0.5 * (math.atan(self.slope_start) + math.atan(self.slope_end)))
        return self.height + self.length * 0.5 * (self.slope_start + self.slope_end)

    @property
    def bend(self) -> float:
        """Change of the sine of the slope: the length in plan over the radius of a circle."""
        sines = (slope / math.hypot(1.0, slope) for slope in (self.slope_end, self.slope_start))
        return next(sines) - next(sines)


@dataclass(frozen=True)
class Cant(alignment.CantElement):
    """An element of cant. line: of the file."""

    line: int = 0

    @property
    def end(self) -> float:
        """Distance in plan of its end [m]."""
        return self.start + self.length


E = TypeVar("E", Profile, Cant)


@dataclass(frozen=True)
class CivilLine:
    """A line of a civil file."""

    name: str
    source: str
    """File, for messages."""
    plan: tuple[Plan, ...]
    profile: tuple[Profile, ...] = ()
    cant: tuple[Cant, ...] = ()
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """East, north [m] and heading [rad] of the start."""
    cant_base: float | None = None
    """Distance between the rail tops that cant is counted over [m]."""
    gauge: float | None = None
    """Track gauge [m]."""
    station: float = 0.0
    """Station of the start [m]."""
    end: tuple[float, float] | None = None
    """East and north of the end [m], where the file tells them."""
    notes: tuple[str, ...] = ()
    """Conventions, and what is assumed."""

    def fault(self, element: Plan | Profile | Cant, message: str) -> InputError:
        """The error for an element, with file, line and kind."""
        line = f":{element.line}" if element.line else ""
        return InputError(f"{self.source}{line}: {type(element).__name__.lower()} of '{self.name}': {message}")

    @property
    def described(self) -> str:
        """Line, start and conventions, for people."""
        bearing = (90.0 - math.degrees(self.origin[2])) % 360.0
        height = f", height {self.profile[0].height:.8g}" if self.profile else ""
        start = f"from east {self.origin[0]:.10g}, north {self.origin[1]:.10g}{height} m, bearing {bearing:.6g} deg"
        turned = "" if self.cant_base is None else f"; cant over {self.cant_base:g} m"
        line = f"'{self.name}' of {Path(self.source).name}, {self.length:.8g} m in plan"
        return "; ".join((f"{line}, {start}", *self.notes)) + turned

    @property
    def edges(self) -> Array:
        """Distances in plan of the joints [m], (n + 1,)."""
        return np.concatenate([[0.0], np.cumsum([element.length for element in self.plan])])

    @property
    def length(self) -> float:
        """Length in plan [m]."""
        return float(self.edges[-1])

    def laws(self, base: float) -> tuple[Laws, tuple[Segment, ...]]:
        """The laws of the track and its segments, as `alignment.alignment_laws` gives them. base: distance over which
        cant is counted [m]. Raises InputError with file and line for elements that are no track, and where joints
        contradict each other."""
        self._check_joints(self.level(base))
        return self._laws(self.cant_rows(), self.profile_rows(), base)

    def level(self, base: float) -> CentreLine:
        """The line in plan, at a height of 0, over the distance in plan."""
        middle = RAILS["centre line"]
        ends = [(e, e.rails_start, e.rails_end) for e in self.cant_rows()]
        rows = [replace(e, rails_start=middle(a[1] - a[0]), rails_end=middle(b[1] - b[0])) for e, a, b in ends]
        law, _ = self._laws(rows, [], base)
        assert law.pitch is not None
        return CentreLine(law.curvature, law.pitch, (*self.origin[:2], 0.0), self.origin[2])

    def _laws(self, cant: Sequence[Cant], profile: Sequence[Profile], base: float) -> tuple[Laws, tuple[Segment, ...]]:
        for each in self.plan:
            if not (SHORT <= each.length <= LONGEST and max(abs(each.start), abs(each.end)) <= SHARPEST):
                what = f"length {each.length:g} m, curvature {each.start:g} to {each.end:g} per m"
                allowed = f"lengths from {SHORT:g} to {LONGEST:g} m, curvature up to {SHARPEST:g} in size"
                raise self.fault(each, f"{what}; allowed: {allowed}")
        try:
            return alignment.alignment_laws(self.plan, cant, profile, base)
        except InputError as error:
            rows: dict[str, Sequence[Plan | Profile | Cant]] = {"plan": self.plan, "cant": cant, "profile": profile}
            if named := re.match(r"(plan|cant|profile)\[(\d+)\]:? *", str(error)):
                raise self.fault(rows[named[1]][int(named[2])], str(error)[named.end() :]) from None
            raise InputError(f"{self.source}: '{self.name}': {error}") from None

    def _check_joints(self, line: CentreLine) -> None:
        """Refuse points and directions of a file that differ from where its elements lead."""
        points, headings = line.position(self.edges) @ [1.0, 1.0j, 0.0], line.heading(self.edges)
        poses = [element.pose for element in self.plan] + [None if self.end is None else (*self.end, math.nan)]
        for i, (pose, behind) in enumerate(pairwise(poses)):
            if pose is None or behind is None:
                continue
            chord = complex(behind[0] - pose[0], behind[1] - pose[1]) * cmath.rect(1.0, -pose[2])
            away = abs(chord - (points[i + 1] - points[i]) * cmath.rect(1.0, -headings[i]))
            turned = behind[2] - pose[2] - (headings[i + 1] - headings[i])
            turn = abs(math.remainder(turned, math.tau)) if math.isfinite(turned) else 0.0
            if not (away <= JOINT and turn <= TURN):
                by = f"{away:.3g} m" if away > JOINT else f"{turn:.3g} rad"
                allowed = f"at most {JOINT:g} m and {TURN:g} rad"
                raise self.fault(self.plan[i], f"ends {by} away from the start of the next element; allowed: {allowed}")

    def cant_rows(self) -> list[Cant]:
        """The elements of cant one behind the other, level ones where the file has none."""
        whole, level = list[Cant](), ((0.0, 0.0), (0.0, 0.0))
        for element in self.cant:
            place = whole[-1].end if whole else 0.0
            if element.start > place + JOINT:
                whole.append(Cant(place, element.start - place, *level))
            whole.append(element)
        place = whole[-1].end if whole else 0.0
        if place < self.length - JOINT:
            whole.append(Cant(place, self.length - place, *level))
        elif place < self.length:
            whole[-1] = replace(whole[-1], length=self.length - whole[-1].start)
        return self._joined(whole)

    def profile_rows(self) -> list[Profile]:
        """The elements of the profile one behind the other; beyond its ends the slope is held."""
        rows = list(self.profile) or [Profile(0.0, self.length)]
        first, last = rows[0], rows[-1]
        if first.start > SHORT:
            slope, height = first.slope_start, first.height - first.slope_start * first.start
            rows.insert(0, Profile(0.0, first.start, slope, slope, height=height, line=first.line))
        if last.end < self.length:
            rest, slope = max(self.length - last.end, SHORT), last.slope_end
            rows.append(Profile(last.end, rest, slope, slope, height=last.end_height, line=last.line))
        for before, row in pairwise(rows):
            if abs(row.height - before.end_height) > JOINT:
                heights = f"begins {row.height:.6g} m high, the one before ends {before.end_height:.6g} m high"
                raise self.fault(row, f"{heights}; allowed: at most {JOINT:g} m apart")
            most = ROUNDING / (0.75 * TIGHTEST)  # a rounded kink has the curvature 3/4 J/b in its middle
            if abs(jump := row.slope_start - before.slope_end) > most:
                allowed = f"up to {most:.2g}, which rounded has a radius of {TIGHTEST:g} m"
                raise self.fault(row, f"the slope jumps by {jump:g} without a vertical curve; allowed: {allowed}")
        rows = self._joined(rows)
        for row in rows:
            if abs(row.bend) * TIGHTEST > row.length:
                radius = row.length / abs(row.bend)
                raise self.fault(row, f"a vertical radius of {radius:g} m; allowed: {TIGHTEST:g} m and more")
        return rows

    def _joined(self, rows: Sequence[E]) -> list[E]:
        """The rows with each end at the next start, where these are near each other."""
        for row in rows:
            if not SHORT <= row.length <= LONGEST:
                raise self.fault(row, f"length {row.length:g} m; allowed: from {SHORT:g} to {LONGEST:g} m")
        ends: list[float] = [
            b.start if abs(a.end - b.start) <= JOINT and b.start > a.start else a.end for a, b in pairwise(rows)
        ]
        return [replace(row, length=end - row.start) for row, end in zip(rows, [*ends, rows[-1].end], strict=True)]


def ramp_of(form: Form) -> CantForm:
    """The form of the cant in a transition."""
    return "linear" if form == "clothoid" or form == "cubic parabola" else form
