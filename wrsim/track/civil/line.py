"""A line as civil data have it: rows of elements of plan, profile and cant over the distance in plan.

Lengths are in m, headings in rad from the east, counter-clockwise; curvature is positive to the left, cant is the
height of each rail above the profile. Joints that a file gives twice, by its points and by its elements, are compared.
"""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from wrsim.errors import InputError
from wrsim.track.alignment import JOINT, STEP, Cant, Plan, Profile, alignment_laws
from wrsim.track.cant import Pivot
from wrsim.track.forms import CantForm, Form
from wrsim.track.piecewise import Array
from wrsim.track.rail import CentreLine
from wrsim.track.segments import ROUNDING, TIGHTEST, Laws, Segment

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
TURN = 1e-4
"""Largest difference of directions at a joint [rad]: 1 mm of length in the tightest curve of 10 m."""


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
        """The laws of the track and its segments, as `alignment_laws` gives them. base: distance over which cant is
        counted [m]. Raises InputError with file and line for elements that are no track, and where joints contradict
        each other."""
        self.rotations(base)
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
        try:
            return alignment_laws(self.plan, cant, profile, base)
        except InputError as error:
            rows: dict[str, Sequence[Plan | Profile | Cant]] = {"plan": self.plan, "cant": cant, "profile": profile}
            if named := re.match(r"(plan|cant|profile)\[(\d+)\]:? *", str(error)):
                raise self.fault(rows[named[1]][int(named[2])], str(error)[named.end() :]) from None
            raise InputError(f"{self.source}: '{self.name}': {error}") from None

    def rotations(self, base: float) -> Array:
        """Angle by which the file has each element turned against the line from its origin on [rad]; without points
        none. Raises InputError where points or directions of the file differ from where its elements lead."""
        poses = [element.pose for element in self.plan if element.pose is not None]
        if not poses:
            return np.zeros(0)
        line, edges, end = self.level(base), self.edges, (math.nan, 0.0) if self.end is None else self.end
        chords = np.diff([complex(*pose[:2]) for pose in (*poses, end)])
        steps, told = np.diff(line.position(edges) @ [1.0, 1.0j, 0.0]), np.array([pose[2] for pose in poses])
        turned = np.where(np.isnan(told), np.angle(chords / steps), told - line.heading(edges[:-1]))
        away = np.abs(chords - steps * np.exp(1j * turned))
        loose = TURN + np.where(np.isnan(told), 1.5 * STEP / np.abs(chords), 0.0)  # points of a chord are rounded too
        turn = np.abs(np.angle(np.exp(1j * np.diff(turned, append=turned[-1]))))
        for i in np.flatnonzero((away > JOINT) | (turn > loose + np.append(loose[1:], 0.0)))[:1].tolist():
            by = f"{away[i]:.3g} m" if away[i] > JOINT else f"{turn[i]:.3g} rad"
            allowed = f"at most {JOINT:g} m and {TURN:g} rad"
            raise self.fault(self.plan[i], f"ends {by} away from the start of the next element; allowed: {allowed}")
        return turned

    def cant_rows(self) -> list[Cant]:
        """The elements of cant one behind the other, level ones where the file has none."""
        whole, level, place = list[Cant](), ((0.0, 0.0), (0.0, 0.0)), 0.0
        for element in self.cant:
            if element.start > place + JOINT:
                whole.append(Cant(place, element.start - place, *level))
            whole.append(element)
            place = element.end
        if place < self.length - JOINT:
            whole.append(Cant(place, self.length - place, *level))
        return whole

    def profile_rows(self) -> list[Profile]:
        """The elements of the profile one behind the other; beyond its ends the slope is held."""
        rows = list(self.profile) or [Profile(0.0, self.length)]
        first, last = rows[0], rows[-1]
        if first.start > JOINT:
            slope, height = first.slope_start, first.height - first.slope_start * first.start
            rows.insert(0, Profile(0.0, first.start, slope, slope, height=height, line=first.line))
        if last.end < self.length - JOINT:
            rest, slope = self.length - last.end, last.slope_end
            rows.append(Profile(last.end, rest, slope, slope, height=last.end_height, line=last.line))
        for before, row in pairwise(rows):
            if abs(row.height - before.end_height) > JOINT:
                heights = f"begins {row.height:.6g} m high, the one before ends {before.end_height:.6g} m high"
                raise self.fault(row, f"{heights}; allowed: at most {JOINT:g} m apart")
            most = ROUNDING / (0.75 * TIGHTEST)  # a rounded kink has the curvature 3/4 J/b in its middle
            if abs(jump := row.slope_start - before.slope_end) > most:
                allowed = f"up to {most:.2g}, which rounded has a radius of {TIGHTEST:g} m"
                raise self.fault(row, f"the slope jumps by {jump:g} without a vertical curve; allowed: {allowed}")
        for row in rows:
            if abs(row.bend) * TIGHTEST > row.length > 0.0:
                radius = row.length / abs(row.bend)
                raise self.fault(row, f"a vertical radius of {radius:g} m; allowed: {TIGHTEST:g} m and more")
        return rows


def ramp_of(form: Form) -> CantForm:
    """The form of the cant in a transition."""
    return "linear" if form == "clothoid" or form == "cubic parabola" else form
