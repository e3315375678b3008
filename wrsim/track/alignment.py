"""Tracks from the separate lists of civil engineering: plan, cant of each rail and vertical profile (track-alignment).

All lengths and distances of the lists are horizontal, along the plan of the centre line. The laws of a track go over
the length of the line in space, s' = sqrt(1 + z'^2).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from wrsim.contact.profiles.curves import gauss_integrals
from wrsim.errors import InputError
from wrsim.track.cant import CANT_BASE
from wrsim.track.forms import (
    CANT_FORMS,
    FORMS,
    CantForm,
    Form,
    check_form,
    checked_shift,
    curvature_law,
    distance_at,
    ramp_law,
)  # fmt: skip
from wrsim.track.piecewise import NODES, Array, Piecewise, interpolant, merged
from wrsim.track.segments import MAX_CANT, ROUNDING, STEEPEST, Arc, Laws, Segment, Straight, Transition, check_range

JOINT = 1e-3
"""Largest gap between elements, and largest step of cant or height at a joint [m]: the resolution of civil data."""


@dataclass(frozen=True)
class Horizontal:
    """An element of the plan: length [m], curvature at its start and end [1/m], positive to the left, and how it leads
    over. centre_of_gravity_height: of a Viennese bend, above the rail tops [m]."""

    length: float
    start: float = 0.0
    end: float = 0.0
    form: Form = "clothoid"
    centre_of_gravity_height: float | None = None


@dataclass(frozen=True)
class CantElement:
    """Height of the rails above the vertical profile, at the start and end of an element (left, right) [m]; distance of
    its start, length [m] and form."""

    start: float
    length: float
    rails_start: tuple[float, float]
    rails_end: tuple[float, float]
    form: CantForm = "linear"


@dataclass(frozen=True)
class Vertical:
    """An element of the vertical profile: distance of its start and length [m]; slope (rise over length) at its start
    and end; "circle": an arc of the radius length / (sin - sin) of the angles of slope, "parabola": the slope runs
    linearly."""

    start: float
    length: float
    slope_start: float = 0.0
    slope_end: float = 0.0
    form: Literal["circle", "parabola"] = "parabola"


def alignment_laws(
    plan: Sequence[Horizontal],
    cant: Sequence[CantElement] = (),
    profile: Sequence[Vertical] = (),
    cant_base: float = CANT_BASE,
    rounding: float = ROUNDING,
) -> tuple[Laws, tuple[Segment, ...]]:
    """Laws of a track, for `Track.from_laws`, from its plan, the cant of its rails and its vertical profile.

    Parameters
    ----------
    plan : sequence of Horizontal
        One behind the other from distance 0 on.
    cant : sequence of CantElement
        In order, without gaps, from 0 or before to the end of the plan or beyond; empty: level.
    profile : sequence of Vertical
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
        if not (np.isfinite((each.start, each.end)).all() and 1e-6 <= each.length <= 1e6):
            fault = f"length {each.length:g} m, curvature {each.start:g} to {each.end:g} per m"
            raise InputError(f"plan[{i}]: {fault}; allowed: 1e-6 to 1e6 m, finite curvature")
    edges = np.concatenate(([0.0], np.cumsum([each.length for each in plan])))
    cross, mean = _cant_laws(cant or [CantElement(0.0, edges[-1], (0.0, 0.0), (0.0, 0.0))], edges[-1], rounding)
    height = _height_law(profile or [Vertical(0.0, edges[-1])], edges[-1], rounding)

    leans = np.diff(cross(edges)) / cant_base
    shifts = [
        checked_shift(f"plan[{i}]", e.form, e.start, e.end, e.length, lean, e.centre_of_gravity_height)
        for i, (e, lean) in enumerate(zip(plan, leans.tolist(), strict=True))
    ]
    ends = np.array([(each.start, each.end) for each in plan]).T
    curvature = curvature_law(edges, ends[0], ends[1], [each.form for each in plan], shifts)

    def slope(x: Array) -> Array:
        return height(x, 1) + mean(x, 1)

    def stretch(x: Array) -> Array:
        return np.hypot(1.0, slope(x))

    laws = (curvature, cross, mean, height)
    places = merged(*(np.clip(law.breaks, 0.0, edges[-1]) for law in laws))
    lengths = gauss_integrals(stretch, places[:-1], places[1:], 16)
    begin, share = np.repeat(places[:-1], NODES.size), (lengths[:, None] * NODES).ravel()
    x = distance_at(stretch, begin, share)
    distances = np.concatenate(([0.0], np.cumsum(lengths)))

    def over_length(values: Array) -> Piecewise:
        return Piecewise.interpolated(distances, values.reshape(lengths.size, NODES.size))

    law = Laws(
        curvature=over_length(curvature(x) / stretch(x)),
        cant=over_length(cross(x)),
        widening=Piecewise.through(distances[[0, -1]], np.zeros(2)),
        pitch=over_length(np.arctan(slope(x))),
        lift=None if mean.is_zero else over_length(mean(x)),
    )
    spans = np.diff(np.interp(edges, places, distances)).tolist()
    return law, tuple(_segment(each, span) for each, span in zip(plan, spans, strict=True))


def _segment(element: Horizontal, length: float) -> Segment:
    """The segment that names an element of the plan."""
    if element.start == element.end == 0.0:
        return Straight(length)
    if element.start == element.end:
        return Arc(length, 1.0 / element.start)
    radii = (1.0 / k if k else np.inf for k in (element.start, element.end))
    return Transition(length, element.form, None, *radii)


def _edges(name: str, elements: Sequence[CantElement | Vertical], end: float) -> Array:
    """Distances of the starts of elements and of the end of the last [m]."""
    for i, each in enumerate(elements):
        if not (np.isfinite(each.start) and 1e-6 <= each.length <= 1e6):
            raise InputError(
                f"{name}[{i}]: start {each.start:g}, length {each.length:g} m; allowed: 1e-6 to 1e6 m long"
            )
    starts = np.array([each.start for each in elements])
    ends = starts + [each.length for each in elements]
    for i in np.flatnonzero(np.abs(starts[1:] - ends[:-1]) > JOINT).tolist():
        fault = f"begins at {starts[i + 1]:.9g} m, the one before ends at {ends[i]:.9g} m"
        raise InputError(f"{name}[{i + 1}]: {fault}; allowed: without gap or overlap")
    if starts[0] > JOINT or ends[-1] < end - JOINT:
        fault = f"goes from {starts[0]:.9g} to {ends[-1]:.9g} m"
        raise InputError(f"{name} {fault}; allowed: over the whole plan, 0 to {end:.9g} m")
    return np.append(starts, ends[-1])


def _cant_laws(elements: Sequence[CantElement], end: float, rounding: float) -> tuple[Piecewise, Piecewise]:
    """Height of the right rail above the left one, and mean height of both, over the plan [m]."""
    edges = _edges("cant", elements, end)
    for i, each in enumerate(elements):
        check_form(f"cant[{i}]", "form", each.form, CANT_FORMS)
        for rail in (*each.rails_start, *each.rails_end):
            check_range(f"cant[{i}]", "height of a rail [mm]", rail, -MAX_CANT, MAX_CANT, 1e3)
    start, after = (np.array([getattr(e, f"rails_{key}") for e in elements], dtype=float) for key in ("start", "end"))
    for i in np.flatnonzero(np.abs(start[1:] - after[:-1]).max(axis=1) > JOINT).tolist():
        fault = f"left and right rail begin at {1e3 * start[i + 1]} mm, the element before ends at {1e3 * after[i]} mm"
        raise InputError(f"cant[{i + 1}]: {fault}; allowed: equal heights within {1e3 * JOINT:g} mm")
    start[1:] = after[:-1]
    forms = [each.form for each in elements]
    cross, mean = (ramp_law(edges, start @ w, after @ w, forms).rounded(rounding) for w in _WEIGHTS)
    return cross, mean


_WEIGHTS = np.array([[-1.0, 1.0], [0.5, 0.5]])  # of the left and the right rail in cant and mean height


def _height_law(elements: Sequence[Vertical], end: float, rounding: float) -> Piecewise:
    """Height of the grade line above its first point, over the plan [m]; kinks are rounded."""
    edges, rows, height = _edges("profile", elements, end), np.zeros((len(elements), NODES.size)), 0.0
    for i, each in enumerate(elements):
        check_form(f"profile[{i}]", "form", each.form, ("circle", "parabola"))
        for slope in (each.slope_start, each.slope_end):
            check_range(f"profile[{i}]", "slope [permille]", slope, -STEEPEST, STEEPEST, 1e3)
        length = edges[i + 1] - edges[i]
        rows[i, :3] = height, length * each.slope_start, 0.5 * length * (each.slope_end - each.slope_start)
        if each.form == "circle":
            first, last = (np.sin(np.arctan(slope)) for slope in (each.slope_start, each.slope_end))
            sine = first + (last - first) * NODES
            rise = (first + sine) / (np.sqrt(1.0 - first**2) + np.sqrt(1.0 - sine**2))  # tangent of the mean angle
            rows[i] = interpolant(height + length * NODES * rise)
        height = float(rows[i].sum())
    return Piecewise.of_rows(edges, rows).rounded(rounding)
