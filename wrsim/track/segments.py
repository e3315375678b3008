"""The pieces a track is made of, and the laws of curvature, cant and gauge that follow from a row of them.

Cant of a segment is positive when it leans the vehicle to the inside, in curves of either hand. Inside the library cant
is signed like the curvature: positive when the right rail is the higher one. Beside a transition at an end of the row
lies level straight track at nominal gauge. Without a transition the curvature jumps, as in the branch of a turnout;
path tables spread the jump over one step. Lengths and radii count in plan, along the level.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from numbers import Real

import numpy as np

from wrsim.errors import InputError
from wrsim.track.cant import RAIL_HEAD_WIDTH, Pivot
from wrsim.track.forms import CANT_FORMS, FORMS, CantForm, Form, check_form, checked_shift, curvature_law, ramp_law
from wrsim.track.piecewise import NODES, Array, Piecewise, merged

LONGEST = 1e5  # longest segment [m]
MAX_CANT = 0.25  # largest cant [m]; railways use up to 0.18 m
MAX_WIDENING = 0.1  # largest change of the gauge [m]; railways use up to 0.03 m
LARGEST = {"cant": MAX_CANT, "gauge_widening": MAX_WIDENING}
ROUNDING = 1.0
"""Half length of the rounding of kinks in cant and gauge [m].

About the elastic length (4 E I / k)^(1/4) of a rail: 0.75 to 0.85 m for 60E1 (E I = 6.4 MN m2) on a support
of 50 to 80 MN/m2."""
SHORTEST = 1e-9  # shortest segment [m]
HIGHEST = 5.0  # largest height of a centre of gravity above the rail tops [m]; of vehicles it is up to 2.5 m


@dataclass(frozen=True)
class Straight:
    """Straight track. length in plan [m]; cant and gauge widening [m] at both ends, linear between.

    The cant of an end belongs to the nearest curve on that side of the segment (to the other side if there is
    none; to a left curve, right rail higher, on a track without curves).
    """

    length: float
    cant_start: float = 0.0
    cant_end: float = 0.0
    gauge_widening_start: float = 0.0
    gauge_widening_end: float = 0.0


@dataclass(frozen=True)
class Arc:
    """Circular track. length in plan [m] of the centre line, radius [m] positive to the left; cant and gauge
    widening [m] are held."""

    length: float
    radius: float
    cant: float = 0.0
    gauge_widening: float = 0.0


@dataclass(frozen=True)
class Transition:
    """Track whose curvature, cant and gauge run from those of the segment before to those of the segment
    behind.

    length [m]; form of the ramps, of `wrsim.track.forms`; cant_form: of cant and gauge where they differ from the
    curvature. radius_start, radius_end [m] and the cant [m] there are given where no arc or straight beside it says
    them; an infinite radius is straight track. centre_of_gravity_height [m] above the rail tops, of a Viennese bend:
    its curvature is that of the path of this point, and the centre line deviates by the cant.
    """

    length: float
    form: Form = "clothoid"
    cant_form: CantForm | None = None
    radius_start: float | None = None
    radius_end: float | None = None
    cant_start: float = 0.0
    cant_end: float = 0.0
    centre_of_gravity_height: float | None = None


Segment = Straight | Arc | Transition


@dataclass(frozen=True, eq=False)
class Laws:
    """Curvature [1/m], signed cant [m] and gauge widening [m] over the distance along the centre line, or in plan as
    long as they have no angle of slope [rad]; height of the centre line above the grade line [m], which the angle of
    slope contains, where the cant does not turn about the centre line."""

    curvature: Piecewise
    cant: Piecewise
    widening: Piecewise
    pitch: Piecewise | None = None
    lift: Piecewise | None = None


def kind_word(segment: Segment) -> str:
    """The word for a segment in files and messages: straight, arc, transition."""
    return type(segment).__name__.lower()


def check_segments(segments: Sequence[Segment], gauge: float) -> None:
    """Refuse segments that are no track, each with its number, key and value. Raises InputError."""
    if not segments:
        raise InputError("track.segments is empty; allowed: at least one straight, transition or arc")
    for number, segment in enumerate(segments, 1):
        if not isinstance(segment, Segment):
            raise InputError(f"segment {number} is a {type(segment).__name__}; allowed: Straight, Transition, Arc")
        where = f"segment {number} ({kind_word(segment)})"
        for key, value in vars(segment).items():
            if not key.endswith("form") and value is not None:
                _check_number(where, key, value)
        if not segment.length >= SHORTEST:
            raise InputError(f"{where}: length_m = {segment.length:g}; allowed: above 0, {SHORTEST:g} at least")
        if isinstance(segment, Transition):
            _check_transition(where, segment, segments[number - 2] if number > 1 else None)
        if isinstance(segment, Arc) and abs(segment.radius) <= gauge:
            hint = "the inner rail of a tighter curve does not exist, straight track is a straight"
            allowed = f"above the gauge ({gauge:g} m) in size, positive to the left; {hint}"
            raise InputError(f"{where}: radius_m = {segment.radius:g}; allowed: {allowed}")


def _check_transition(where: str, segment: Transition, before: Segment | None) -> None:
    """Refuse unknown forms and what a transition leaves open."""
    check_form(where, "form", segment.form, FORMS)
    check_form(where, "cant_form", segment.cant_form or "linear", CANT_FORMS)
    for key in ("radius_start", "radius_end"):
        if (radius := getattr(segment, key)) is None and getattr(segment, key.replace("radius", "cant")):
            cant = key.replace("radius", "cant")
            raise InputError(f"{where}: {cant}_mm goes with {key}_m; without it the segment beside says both")
        if radius is not None and abs(radius) < 1.0:
            raise InputError(f"{where}: {key}_m = {radius:g}; allowed: 1 m and more in size, of either sign")
    height = segment.centre_of_gravity_height
    if height is not None and (segment.form != "viennese" or not 0.0 <= height <= HIGHEST):
        limits = f'0 to {HIGHEST:g}, with form = "viennese" (now {segment.form!r})'
        raise InputError(f"{where}: centre_of_gravity_height_m = {height:g}; allowed: {limits}")
    if isinstance(before, Transition) and (before.radius_end is None) == (segment.radius_start is None):
        said = "and both say" if segment.radius_start is not None else "so the curvature between them is open; give"
        message = f"follows another transition, {said} it: radius_end_m of the first or radius_start_m of the second"
        raise InputError(f"{where} {message}; or put an arc or a straight between")


def laws(segments: Sequence[Segment], gauge: float, rounding: float, cant_base: float | None = None) -> Laws:
    """Curvature, cant and widening over distance for a row of segments.

    rounding: half length [m] over which kinks of cant and gauge are rounded (`Piecewise.rounded`): a rail is a beam and
    has no kinks. cant_base: as `wrsim.track.track.Track.from_laws` takes it, for Viennese bends. Raises InputError for
    wrong values, for jumps of cant or gauge, and where a transition contradicts its neighbour.
    """
    check_segments(segments, gauge)
    base = gauge + RAIL_HEAD_WIDTH if cant_base is None else cant_base
    edges = np.concatenate(([0.0], np.cumsum([float(s.length) for s in segments])))
    start, end = end_states(segments)
    forms = [s.form if isinstance(s, Transition) else "clothoid" for s in segments]
    shift = [
        checked_shift(f"segment {i + 1} (transition)", s.form, start[0, i], end[0, i], s.length,
                      (end[1, i] - start[1, i]) / base, s.centre_of_gravity_height)
        if isinstance(s, Transition) else 0.0
        for i, s in enumerate(segments)
    ]  # fmt: skip
    curvature = curvature_law(edges, start[0], end[0], forms, shift)
    cant_forms = [getattr(s, "cant_form", None) or form for s, form in zip(segments, forms, strict=True)]
    cant, widening = (ramp_law(edges, start[k], end[k], cant_forms) for k in (1, 2))
    for i in np.flatnonzero(np.abs(start[0, 1:] - end[0, :-1]) > 1e-12).tolist():
        for transition, key in ((segments[i], "radius_end"), (segments[i + 1], "radius_start")):
            if getattr(transition, key, None) is not None:
                raise InputError(
                    f"segment {i + 1} ({kind_word(segments[i])}) ends with a curvature of {1e3 * end[0, i]:g} per km, "
                    f"segment {i + 2} ({kind_word(segments[i + 1])}) begins with {1e3 * start[0, i + 1]:g}; allowed: "
                    f"{key}_m as the segment beside has it, or leave it out"
                )
    for law, key in ((cant, "cant"), (widening, "gauge_widening")):
        before, behind = law.joints()
        for i in np.flatnonzero(np.abs(behind - before) > 1e-9)[:1]:
            signs = " (positive: right rail higher)" if key == "cant" else ""
            raise InputError(
                f"{key}_mm jumps from {1e3 * before[i]:g} to {1e3 * behind[i]:g}{signs} between segment {i + 1} "
                f"({kind_word(segments[i])}) and segment {i + 2} ({kind_word(segments[i + 1])}); allowed: equal values "
                f"at a joint (put a transition between, or a straight with {key}_start_mm and {key}_end_mm)"
            )
    return Laws(curvature, cant.rounded(rounding), widening.rounded(rounding))


RADII = ("radius", "radius_start", "radius_end")


def end_states(segments: Sequence[Segment]) -> Array:
    """Curvature [1/m], signed cant and widening [m] where segments begin and end: (2, 3, n)."""
    hands = _hands(segments)
    return np.array([_ends(segments, hands, i) for i in range(len(segments))]).transpose(1, 2, 0)


State = tuple[float, float, float]
LEVEL: State = (0.0, 0.0, 0.0)


def _ends(segments: Sequence[Segment], hands: Sequence[tuple[float, float]], i: int) -> tuple[State, State]:
    """(curvature, signed cant, widening) at the two ends of a segment. hands: see `_hands`."""
    segment = segments[i]
    if isinstance(segment, Arc):
        state = (1.0 / segment.radius, math.copysign(1.0, segment.radius) * segment.cant, segment.gauge_widening)
        return state, state
    if isinstance(segment, Straight):
        start, end = hands[i]
        return (
            (0.0, start * segment.cant_start, segment.gauge_widening_start),
            (0.0, end * segment.cant_end, segment.gauge_widening_end),
        )
    before = _ends(segments, hands, i - 1)[1] if i and segment.radius_start is None else LEVEL
    behind = _ends(segments, hands, i + 1)[0] if i + 1 < len(segments) and segment.radius_end is None else LEVEL
    if segment.radius_start is not None:
        before = (1.0 / segment.radius_start, _hand(segment.radius_start, hands[i][0]) * segment.cant_start, 0.0)
    if segment.radius_end is not None:
        behind = (1.0 / segment.radius_end, _hand(segment.radius_end, hands[i][1]) * segment.cant_end, 0.0)
    return before, behind


def _hand(radius: float, straight: float) -> float:
    """Hand of a curve, +1 left, -1 right, and of a straight that of a curve beside it."""
    return math.copysign(1.0, radius) if math.isfinite(radius) else straight


def _hands(segments: Sequence[Segment]) -> list[tuple[float, float]]:
    """Hand (+1 left, -1 right) of the nearest curve before and behind each segment, or of the one on the other side."""

    def passed(row: Iterable[Segment]) -> list[float]:
        radii = ([r for r in (getattr(s, key, None) for key in RADII) if r and math.isfinite(r)] for s in row)
        return list(accumulate(radii, lambda last, r: math.copysign(1.0, r[0]) if r else last, initial=0.0))

    before, behind = passed(segments), passed(reversed(segments))[-2::-1]
    return [(b or f or 1.0, f or b or 1.0) for b, f in zip(before, behind, strict=False)]


def check_range(where: str, key: str, value: float, low: float, high: float, scale: float = 1.0) -> None:
    """Refuse a value outside of [low, high], or not a number; the message shows it times ``scale``."""
    if not low <= value <= high:
        raise InputError(f"{where}: {key} = {scale * value:g}; allowed: {scale * low:g} to {scale * high:g}")


def _check_number(where: str, key: str, value: object) -> None:
    """Refuse what is not a finite number [m], and cant and widening that are too large."""
    most = LARGEST.get(key.removesuffix("_start").removesuffix("_end"))
    key = f"{key}_mm" if most else f"{key}_m"
    if key[:-2] in RADII[1:] and isinstance(value, float) and math.isinf(value):
        return  # straight
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise InputError(f"{where}: {key} = {value!r}; allowed: a finite number")
    if most:
        check_range(where, key, float(value), -most, most, 1e3)


def lift_of(cant: Piecewise, pivot: Pivot) -> Piecewise | None:
    """Height of the centre line above the grade line [m]; None: 0.

    The pivot stays at the height of the grade line, and the centre line is half of the cant above or below it. Where
    the low rail becomes the high one, the kink of its height is rounded as those of cant.
    """
    if pivot == "centre line" or cant.is_zero:
        return None
    size = cant if pivot in ("left rail", "right rail") else cant.absolute().rounded(ROUNDING)
    return size.scaled(0.5 if pivot in ("left rail", "low rail") else -0.5)


def lifted(law: Laws, pivot: Pivot) -> Laws:
    """Laws that have the angle of slope of the grade line, with that of the centre line and its height."""
    lift = lift_of(law.cant, pivot)
    if lift is None or law.pitch is None:
        return law
    edges = merged(law.pitch.breaks, lift.breaks)
    s = edges[:-1, None] + np.diff(edges)[:, None] * NODES
    pitch = Piecewise.interpolated(edges, np.arcsin(np.sin(law.pitch(s)) + lift(s, 1)))
    return replace(law, pitch=pitch, lift=lift)


STEEPEST = 0.15  # largest grade: 150 per thousand; adhesion railways use up to 80
TIGHTEST = 200.0  # smallest vertical radius [m]; light rail goes down to 350 m, marshalling humps to 250 m


@dataclass(frozen=True)
class Grade:
    """From a distance in plan on [m] the track climbs by ``slope`` (rise over length along the level; 0.008 is 8 per
    thousand). radius: of the vertical curve whose tangents meet there [m]; without meaning at 0."""

    start: float
    slope: float
    radius: float = 10_000.0
