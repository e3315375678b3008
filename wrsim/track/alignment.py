"""Tracks from the separate lists of civil engineering: plan, cant of each rail and vertical profile (track-alignment).

All lengths and distances of the lists are horizontal, along the plan of the centre line. The laws of a track go over
the length of the line in space, s' = sqrt(1 + z'^2).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from wrsim.contact.profiles.curves import gauss_integrals
from wrsim.errors import InputError
from wrsim.track import forms, segments
from wrsim.track.cant import CANT_BASE
from wrsim.track.forms import CANT_FORMS, FORMS, CantForm, Form, check_form
from wrsim.track.piecewise import NODES, Array, Piecewise, interpolant, merged
from wrsim.track.segments import LONGEST, ROUNDING, Arc, Grade, Laws, Segment, Straight, Transition, check_range

JOINT = 5e-3
"""Largest distance of the end of an element from the next start, and largest step of height there [m].

Civil data are rounded to 1 mm and directions to 1e-6 rad: both points 0.7 mm, the length 0.5 mm, a radius of 300 m by
1 mm over 300 m another 0.5 mm, the direction over 1000 m 1 mm; in sum 3.4 mm."""
STEP = 1e-3
"""Largest step of a rail's cant at a joint, and shortest element [m]: civil data are rounded to it."""
SHARPEST = 0.5
"""Largest curvature [1/m]: a radius of 2 m, below any track."""


@dataclass(frozen=True)
class Plan:
    """An element of the plan: length [m], curvature at its start and end [1/m], positive to the left, and how it leads
    over. centre_of_gravity_height: of a Viennese bend, above the rail tops [m]. pose: east, north [m] and heading [rad]
    of its start as a file tells them, nan where its points say the heading; line: of the file."""

    length: float
    start: float = 0.0
    end: float = 0.0
    form: Form = "clothoid"
    centre_of_gravity_height: float | None = None
    pose: tuple[float, float, float] | None = None
    line: int = 0


@dataclass(frozen=True)
class Cant:
    """Height of the rails above the vertical profile, at the start and end of an element (left, right) [m]; distance of
    its start, length [m] and form; line: of the file."""

    start: float
    length: float
    rails_start: tuple[float, float]
    rails_end: tuple[float, float]
    form: CantForm = "linear"
    line: int = 0

    @property
    def end(self) -> float:
        """Distance in plan of its end [m]."""
        return self.start + self.length


@dataclass(frozen=True)
class Profile:
    """An element of the vertical profile: distance of its start and length [m]; slope (rise over length) at its start
    and end; "circle": an arc of the radius length / (sin - sin) of the angles of slope, "parabola": the slope runs
    linearly. height: of its start [m]; line: of the file."""

    start: float
    length: float
    slope_start: float = 0.0
    slope_end: float = 0.0
    form: Literal["circle", "parabola"] = "parabola"
    height: float = 0.0
    line: int = 0

    @property
    def end(self) -> float:
        """Distance in plan of its end [m]."""
        return self.start + self.length

    @property
    def end_height(self) -> float:
        """Height of its end [m]."""
        slopes = self.slope_start, self.slope_end
        mean = math.tan(0.5 * sum(map(math.atan, slopes))) if self.form == "circle" else 0.5 * sum(slopes)
        return self.height + self.length * mean

    @property
    def bend(self) -> float:
        """Change of the sine of the slope: the length in plan over the radius of a circle."""
        return self.slope_end / math.hypot(1.0, self.slope_end) - self.slope_start / math.hypot(1.0, self.slope_start)


def alignment_laws(
    plan: Sequence[Plan],
    cant: Sequence[Cant] = (),
    profile: Sequence[Profile] = (),
    cant_base: float = CANT_BASE,
    rounding: float = ROUNDING,
) -> tuple[Laws, tuple[Segment, ...]]:
    """Laws of a track, for `Track.from_laws`, from its plan, the cant of its rails and its vertical profile.

    Parameters
    ----------
    plan : sequence of Plan
        One behind the other from distance 0 on.
    cant : sequence of Cant
        In order, without gaps, from 0 or before to the end of the plan or beyond; empty: level.
    profile : sequence of Profile
        The same, of the grade line; empty: level.
    cant_base : float
        Distance over which cant is measured [m], for Viennese bends.
    rounding : float
        Half length over which kinks of cant and height are rounded [m].

    Returns
    -------
    Laws, tuple of Segment
        The centre line lies half way between the rail tops: above the grade line by the mean height of both rails
        (`Laws.lift`). The segments name the pieces of the plan, with their length in space; they
        have no cant. They go to ``from_laws(..., segments=...)``.

    Raises
    ------
    InputError
        Naming the list, the number of the element and what is allowed.
    """
    if not plan:
        raise InputError("plan of the alignment is empty; allowed: one element at least")
    for i, each in enumerate(plan):
        check_form(f"plan[{i}]", "form", each.form, FORMS)
        if not (STEP <= each.length <= LONGEST and all(abs(k) <= SHARPEST for k in (each.start, each.end))):
            fault = f"length {each.length:g} m, curvature {each.start:g} to {each.end:g} per m"
            raise InputError(
                f"plan[{i}]: {fault}; allowed: {STEP:g} to {LONGEST:g} m, up to {SHARPEST:g} per m in size"
            )
    edges = np.concatenate(([0.0], np.cumsum([each.length for each in plan])))
    cross, mean = _cant_laws(cant or [Cant(0.0, edges[-1], (0.0, 0.0), (0.0, 0.0))], edges[-1], rounding)
    height = height_law(profile or [Profile(0.0, edges[-1])], edges[-1], rounding)

    leans = np.diff(cross(edges)) / cant_base
    shifts = [
        forms.checked_shift(f"plan[{i}]", e.form, e.start, e.end, e.length, lean, e.centre_of_gravity_height)
        for i, (e, lean) in enumerate(zip(plan, leans.tolist(), strict=True))
    ]
    ends = np.array([(each.start, each.end) for each in plan]).T
    curvature = forms.curvature_law(edges, ends[0], ends[1], [each.form for each in plan], shifts)

    law, spans = in_space(Laws(curvature, cross, Piecewise.through(edges[[0, -1]], np.zeros(2))), height, mean, edges)
    return law, tuple(_segment(each, span) for each, span in zip(plan, spans, strict=True))


def in_space(law: Laws, height: Piecewise, mean: Piecewise | None, edges: Array) -> tuple[Laws, list[float]]:
    """Laws over the distance in plan as laws over the length in space.

    Parameters
    ----------
    law : Laws
        Over the distance in plan; without slope.
    height, mean : Piecewise
        Height of the grade line, and of the centre line above it, None where it is 0 [m].
    edges : (n + 1,) array
        Distances in plan of the joints of elements [m].

    Returns
    -------
    Laws, list of float
        With angle of slope and height; the lengths of the elements in space [m]. The same laws where all is level.
    """
    parts = (height,) if mean is None or mean.is_zero else (height, mean)

    def slope(x: Array) -> Array:
        return np.asarray(sum(part(x, 1) for part in parts))

    def stretch(x: Array) -> Array:
        return np.hypot(1.0, slope(x))

    if len(parts) == 1 and not height(height.breaks, 1).any():
        level = Piecewise.through(edges[[0, -1]], np.zeros(2))
        return replace(law, pitch=level), np.diff(edges).tolist()
    laws = (law.curvature, law.cant, law.widening, *parts)
    places = merged(*(np.clip(each.breaks, 0.0, edges[-1]) for each in laws))
    lengths = gauss_integrals(stretch, places[:-1], places[1:], 16)
    begin, share = np.repeat(places[:-1], NODES.size), (lengths[:, None] * NODES).ravel()
    x = forms.distance_at(stretch, begin, share)
    rise = slope(x)
    distances = np.concatenate(([0.0], np.cumsum(lengths)))

    def over_length(values: Array) -> Piecewise:
        return Piecewise.interpolated(distances, values.reshape(lengths.size, NODES.size))

    laid = Laws(
        curvature=over_length(law.curvature(x) / np.hypot(1.0, rise)),
        cant=replace(over_length(law.cant(x)), rounding=law.cant.rounding),
        widening=over_length(law.widening(x)),
        pitch=over_length(np.arctan(rise)),
        lift=over_length(parts[1](x)) if len(parts) == 2 else None,
    )
    return laid, np.diff(np.interp(edges, places, distances)).tolist()


def _segment(element: Plan, length: float) -> Segment:
    """The segment that names an element of the plan."""
    if element.start == element.end == 0.0:
        return Straight(length)
    if element.start == element.end:
        return Arc(length, 1.0 / element.start)
    radii = (1.0 / k if k else np.inf for k in (element.start, element.end))
    return Transition(length, element.form, None, *radii)


def _edges(name: str, elements: Sequence[Cant | Profile], end: float) -> Array:
    """Distances of the starts of elements and of the end of the last [m]."""
    for i, each in enumerate(elements):
        if not (np.isfinite(each.start) and STEP <= each.length <= LONGEST):
            fault = f"start {each.start:g} m, length {each.length:g} m"
            raise InputError(f"{name}[{i}]: {fault}; allowed: {STEP:g} to {LONGEST:g} m long")
    starts = np.array([each.start for each in elements])
    ends = starts + [each.length for each in elements]
    for i in np.flatnonzero(np.abs(starts[1:] - ends[:-1]) > JOINT).tolist():
        fault = f"begins at {starts[i + 1]:.9g} m, the one before ends at {ends[i]:.9g} m"
        raise InputError(f"{name}[{i + 1}]: {fault}; allowed: without gap or overlap")
    if starts[0] > JOINT or ends[-1] < end - JOINT:
        fault = f"goes from {starts[0]:.9g} to {ends[-1]:.9g} m"
        raise InputError(f"{name} {fault}; allowed: over the whole plan, 0 to {end:.9g} m")
    return np.append(starts, ends[-1])


def _cant_laws(elements: Sequence[Cant], end: float, rounding: float) -> tuple[Piecewise, Piecewise]:
    """Height of the right rail above the left one, and mean height of both, over the plan [m]."""
    edges = _edges("cant", elements, end)
    for i, each in enumerate(elements):
        check_form(f"cant[{i}]", "form", each.form, CANT_FORMS)
        for rail in (*each.rails_start, *each.rails_end):
            check_range(f"cant[{i}]", "height of a rail [mm]", rail, -segments.MAX_CANT, segments.MAX_CANT, 1e3)
    start, after = (np.array([getattr(e, f"rails_{key}") for e in elements], dtype=float) for key in ("start", "end"))
    for i in np.flatnonzero(np.abs(start[1:] - after[:-1]).max(axis=1) > STEP).tolist():
        fault = f"left and right rail begin at {1e3 * start[i + 1]} mm, the element before ends at {1e3 * after[i]} mm"
        raise InputError(f"cant[{i + 1}]: {fault}; allowed: equal heights within {1e3 * STEP:g} mm")
    start[1:] = after[:-1]
    kinds = [each.form for each in elements]
    cross, mean = (forms.ramp_law(edges, start @ w, after @ w, kinds).rounded(rounding) for w in _WEIGHTS)
    return cross, mean


_WEIGHTS = np.array([[-1.0, 1.0], [0.5, 0.5]])  # of the left and the right rail in cant and mean height


def height_law(elements: Sequence[Profile], end: float, rounding: float = ROUNDING) -> Piecewise:
    """Height of the grade line above its first point, over a plan of this length [m]; kinks are rounded over that half
    length. Raises InputError."""
    edges, rows, height = _edges("profile", elements, end), np.zeros((len(elements), NODES.size)), 0.0
    for i, each in enumerate(elements):
        check_form(f"profile[{i}]", "form", each.form, ("circle", "parabola"))
        for slope in (each.slope_start, each.slope_end):
            check_range(f"profile[{i}]", "slope [permille]", slope, -segments.STEEPEST, segments.STEEPEST, 1e3)
        length = edges[i + 1] - edges[i]
        rows[i, :3] = height, length * each.slope_start, 0.5 * length * (each.slope_end - each.slope_start)
        if each.form == "circle":
            first, last = (np.sin(np.arctan(slope)) for slope in (each.slope_start, each.slope_end))
            sine = first + (last - first) * NODES
            rise = (first + sine) / (np.sqrt(1.0 - first**2) + np.sqrt(1.0 - sine**2))  # tangent of the mean angle
            rows[i] = interpolant(height + length * NODES * rise)
        height = float(rows[i].sum())
    return Piecewise.of_rows(edges, rows).rounded(rounding)


def vertical_profile(grades: Sequence[Grade], length: float) -> list[Profile]:
    """The vertical profile of grades over a track of that length in plan [m]: constant grades and circles between.

    Level where there are no grades, and before the first. Raises InputError, with the grade's number, for wrong
    values and for vertical curves that overlap or reach beyond the track.
    """
    rows, slope, free, last = list[Profile](), 0.0, 0.0, -1.0

    def add(end: float, end_slope: float, form: Literal["circle", "parabola"]) -> None:
        height = rows[-1].end_height if rows else 0.0
        rows.append(Profile(free, end - free, slope, end_slope, form, height))

    for number, grade in enumerate(grades):
        where = f"grades[{number}]"
        if not (max(last + 1e-9, 0.0) <= grade.start < length):
            after = f"above {last:g} (the grade before)" if number else "0"
            fault = f"from_m = {grade.start:g}; allowed: {after} to {length:g}, on the track and rising"
            raise InputError(f"{where}: {fault}")
        check_range(where, "grade_permille", grade.slope, -segments.STEEPEST, segments.STEEPEST, 1e3)
        check_range(where, "vertical_radius_m", grade.radius, segments.TIGHTEST, 1e7)
        last = grade.start
        if grade.start == 0.0:
            slope = grade.slope
        if grade.slope == slope:
            continue
        before, behind = math.atan(slope), math.atan(grade.slope)
        tangent = grade.radius * math.tan(0.5 * abs(behind - before))
        begin, end = grade.start - tangent * math.cos(before), grade.start + tangent * math.cos(behind)
        if begin < free - 1e-9 or end > length + 1e-9:
            meets = "the end of the track" if end > length else "the one before, or the start of the track"
            allowed = f"a smaller vertical_radius_m (now {grade.radius:g}), or grades further apart"
            curve = f"its vertical curve runs from {begin:g} to {end:g} m"
            raise InputError(f"{where}: {curve} and meets {meets}; allowed: {allowed}")
        if begin - free >= STEP:
            add(begin, slope, "parabola")
        free = begin
        if min(end, length) - free >= STEP:
            add(min(end, length), grade.slope, "circle")
        free = min(end, length)
        slope = grade.slope
    if length - free >= STEP or not rows:
        add(length, slope, "parabola")
    return rows
