"""A track: segments -> centre line -> two swept rails.

Cross-section. The centre line lies at the height of the rail tops, half way between the gauge points. Cant turns the
cross-section about the centre line: of the two rails one rises and the other falls by half the cant. Where cant turns
about a rail, the centre line rises or falls by half the cant as well. Distance is counted along the centre line, also
where it climbs. Gauge widening moves each rail outward by half of it. The origin of each rail profile sits at the
outward distance gauge(s)/2 + o and the height b in the canted cross-section; (o, b) come from the inclined rail profile
(o = -u of its gauge point, b = -w of its highest point). Irregularities move the rails along the axes of the
cross-section, not the centre line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from wrsim.errors import InputError
from wrsim.inputs.notebook import card
from wrsim.track.alignment import Profile, height_law, in_space, vertical_profile
from wrsim.track.bridge import Bridge
from wrsim.track.cant import PIVOTS, RAIL_HEAD_WIDTH, STANDARD_GAUGE, Pivot
from wrsim.track.forms import LABEL, check_form
from wrsim.track.irregularities import SMOOTH, Disturbance, RailIrregularity
from wrsim.track.path import Path
from wrsim.track.piecewise import Array, Piecewise
from wrsim.track.rail import CentreLine, SweptCurve
from wrsim.track.segments import (
    ROUNDING,
    Arc,
    Grade,
    Laws,
    Segment,
    Transition,
    check_range,
    kind_word,
    laws,
    lift_of,
    lifted,
)  # fmt: skip
from wrsim.track.sleepers import SleeperTrack

if TYPE_CHECKING:
    from wrsim.track.civil.line import CivilLine


@dataclass(frozen=True)
class RailElasticity:
    """A mass on a spring and a damper under each wheel, that moves along with it; lateral, then vertical.

    stiffness [N/m], damping [N s/m], mass [kg] of the rail and its supports, as one wheel meets them. Wheels and rails
    are not coupled, and a rail springs back at once behind a wheel.
    """

    stiffness: tuple[float, float]
    damping: tuple[float, float]
    mass: tuple[float, float]


ROWS = 0.25  # distance of the rows of a path unless irregularities need less [m]
MAX_OFFSET = 0.5  # farthest gauge point and top of a rail profile from its origin [m]
MAX_ROWS = 4_000_000  # largest table of a path


@dataclass(frozen=True)
class Feature:
    """One segment as it lies on the track: kind and label, start and end distance [m]."""

    kind: str
    label: str
    start: float
    end: float


@dataclass(frozen=True, eq=False)
class Track:
    """Centre line and two rails, as laws over the distance s along the centre line and as tables (made on first use).

    Build it with `Track.build`. All functions of s take arrays; outside of [0, length] the track is continued straight
    with the cant and the gauge of its end.
    """

    segments: tuple[Segment, ...]
    """With their lengths along the centre line, and radii in plan."""
    nominal_gauge: float
    cant_base: float
    centre_line: CentreLine
    left_curve: SweptCurve
    right_curve: SweptCurve
    centre_rows: float
    rail_rows: float
    """Largest distances of the rows of path tables [m]."""
    structure: RailElasticity | SleeperTrack | Bridge | None = None
    """None: rigid rails."""
    reach: float = np.inf
    """Distance up to which tables of paths are made: beyond, they continue straight [m]."""
    lift: Piecewise | None = None
    """Height of the centre line above the grade line [m]; None: 0."""
    plan: tuple[Segment, ...] = ()
    profile: tuple[Profile, ...] = ()
    """Segments with their lengths in plan, and the vertical profile that they were laid with; empty: level."""
    pivot: Pivot = "centre line"
    """What the cant turns about, unless the alignment has the heights of both rails."""
    alignment: CivilLine | None = None
    """The civil file's line that it was laid from."""

    @classmethod
    def build(
        cls, segments: Sequence[Segment], gauge: float = STANDARD_GAUGE, *, rounding: float = ROUNDING, **options: Any
    ) -> Track:
        """Lay segments one behind the other.

        Parameters
        ----------
        segments : sequence of Straight, Arc or Transition
        gauge : float
            Nominal gauge [m].
        rounding : float
            Half length over which the kinks of cant and gauge at joints are rounded [m].
        **options
            As `from_laws` takes them: grades, irregularities, cant_base, ...

        Returns
        -------
        Track

        Raises
        ------
        InputError
            Naming segment, key, value and what is allowed.

        Examples
        --------
        >>> from wrsim import Arc, Straight, Track, Transition
        >>> track = Track.build([Straight(30.0), Transition(40.0), Arc(120.0, radius=300.0, cant=0.06)])
        >>> track.curvature([0.0, 100.0])
        """
        check_range("track", "gauge_mm", gauge, 0.3, 3.0, 1e3)
        check_range("track", "rounding_m", rounding, 1e-3, 20.0)
        segments = tuple(segments)
        law = laws(segments, gauge, rounding, options.get("cant_base"))
        return cls.from_laws(law, gauge, segments=segments, **options)

    @property
    def bridge(self) -> Bridge | None:
        """The bridge below stiff rails or below the ballast."""
        bridge = self.structure.bridge if isinstance(self.structure, SleeperTrack) else self.structure
        return bridge if isinstance(bridge, Bridge) else None

    @classmethod
    def from_laws(
        cls,
        law: Laws,
        gauge: float = STANDARD_GAUGE,
        *,
        segments: tuple[Segment, ...] = (),
        grades: Sequence[Grade] = (),
        irregularities: Sequence[Disturbance] = (),
        left_offset: tuple[float, float] = (0.0, 0.0),
        right_offset: tuple[float, float] = (0.0, 0.0),
        cant_base: float | None = None,
        step: float | None = None,
        start: tuple[float, float, float] = (0.0, 0.0, 0.0),
        heading: float = 0.0,
        structure: RailElasticity | SleeperTrack | Bridge | None = None,
        pivot: Pivot = "centre line",
        alignment: CivilLine | None = None,
    ) -> Track:
        """A track of given laws of curvature, cant and gauge.

        segments: of the laws; without them the track is one measured piece. grades: vertical profile, in place of
        that of the laws; with it, and where laws have none, laws and segments count in plan. irregularities: of the
        rails. left_offset, right_offset: (o, b) of the rail profile's origin [m], outward of the gauge point and above
        the rail tops. cant_base: distance over which cant is measured [m], default gauge + 0.065 m. step: largest
        distance of the tables' rows [m]; None: 0.25 m, and on the rails what their irregularities need. start, heading:
        point [m] and direction [rad] at s = 0. structure: what the rails rest on, None for rigid ones. pivot: what the
        cant turns about. alignment: the civil line of the laws.
        """
        check_range("track", "gauge_mm", gauge, 0.3, 3.0, 1e3)
        base = gauge + RAIL_HEAD_WIDTH if cant_base is None else cant_base
        check_range("track", "cant_base_mm", base, gauge, gauge + 0.5, 1e3)
        if step is not None:
            check_range("track", "step_m", step, 1e-3, 10.0)
        for key, offset in (("left_offset", left_offset), ("right_offset", right_offset)):
            for value in offset:
                check_range("track", f"{key} (o, b)", value, -MAX_OFFSET, MAX_OFFSET)
        if not np.isfinite((*start, heading)).all():
            raise InputError(f"start or heading of the track = {(*start, heading)}; allowed: finite numbers")

        uneven = {side: RailIrregularity.of(irregularities, side) for side in (1, -1)}
        finest = min(rail.resolution for rail in uneven.values())
        if step is not None and step > finest * (1.0 + 1e-9):
            needed = f"{finest:g} (a quarter of the shortest wavelength); allowed: a smaller one, or longer waves"
            raise InputError(f"row_distance_m = {step:g} is too coarse for the irregularities, which need {needed}")
        rows = min(ROWS, finest) if step is None else step
        length = law.curvature.end
        if length / rows > MAX_ROWS:
            far = f"track of {length:g} m with rows every {rows:g} m"
            raise InputError(f"{far}; allowed: {MAX_ROWS} rows (is length_m in metres?)")
        check_form("track", "pivot", pivot, PIVOTS)
        plan, profile = segments, list[Profile]()
        if law.lift is not None and (grades or pivot != PIVOTS[0]):
            named = f"pivot = {pivot!r}" if pivot != PIVOTS[0] else "grades"
            raise InputError(f"track: {named} cannot be given with an alignment, which has the heights of both rails")
        if law.pitch is None or grades:
            edges = np.cumsum([0.0, *((s.length for s in segments) if segments else (length,))])
            profile = vertical_profile(grades, length)
            law, spans = in_space(law, height_law(profile, length), lift_of(law.cant, pivot), edges)
            if law.pitch is not None and not law.pitch.is_zero:  # else as long as in plan, to the last digit
                segments = tuple(replace(s, length=span) for s, span in zip(segments, spans, strict=False))
        else:
            law = lifted(law, pivot)
        assert law.pitch is not None
        above = 0.0 if law.lift is None else float(law.lift(0.0))
        line = CentreLine(law.curvature, law.pitch, (start[0], start[1], start[2] + above), heading)
        swept = partial(SweptCurve, line, law.cant, law.widening, gauge, base)
        left, right = swept(1, *left_offset, uneven[1]), swept(-1, *right_offset, uneven[-1])
        steps = ROWS if step is None else step, rows
        more: dict[str, Any] = {"lift": law.lift, "pivot": pivot, "alignment": alignment}
        more |= {"plan": plan, "profile": tuple(profile) if grades else ()}
        return cls(segments, gauge, base, line, left, right, *steps, structure, **more)

    def __repr__(self) -> str:
        pieces = ", ".join(f"{f.label} {f.start:g}..{f.end:g} m" for f in self.features())
        uneven = ", with irregularities" if self.is_uneven else ""
        return f"Track({self.length:g} m, gauge {1e3 * self.nominal_gauge:g} mm: {pieces}{uneven})"

    def _repr_html_(self) -> str:
        pieces = [(f"{f.start:g} to {f.end:g} m", f.label) for f in self.features()]
        more = (("gauge", f"{1e3 * self.nominal_gauge:g} mm"), ("irregularities", "yes" if self.is_uneven else "none"))
        return card(f"Track of {self.length:g} m", (*pieces, *more))

    @cached_property
    def centre(self) -> Path:
        """The centre line as a table, with the roll of the track."""
        flat = replace(self.left_curve, side=0, outward=0.0, height=0.0, irregularity=SMOOTH)
        return flat.path(self.centre_rows, self.reach)

    @cached_property
    def left(self) -> Path:
        """The left rail as a table; made on first use, for a long track takes seconds."""
        return self.left_curve.path(self.rail_rows, self.reach)

    @cached_property
    def right(self) -> Path:
        return self.right_curve.path(self.rail_rows, self.reach)

    @property
    def length(self) -> float:
        """Length of the centre line [m]."""
        return self.centre_line.length

    def curvature(self, s: ArrayLike) -> Array:
        """Curvature of the centre line [1/m], positive to the left."""
        return self.centre_line.curvature(s)

    def heading(self, s: ArrayLike) -> Array:
        """Heading [rad], positive to the left, not wrapped."""
        return self.centre_line.heading(s)

    def cant(self, s: ArrayLike) -> Array:
        """Signed cant [m], positive when the right rail is higher."""
        return self.left_curve.cant(s)

    def rail_heights(self, s: ArrayLike) -> tuple[Array, Array]:
        """Designed heights of the tops of the left and the right rail above the grade line [m]."""
        lift = np.zeros(np.shape(s)) if self.lift is None else self.lift(s)
        return lift - 0.5 * self.cant(s), lift + 0.5 * self.cant(s)

    @property
    def assumptions(self) -> str:
        """What is assumed of the cant in one line; empty without cant."""
        if self.left_curve.cant.is_zero:
            return ""
        stays = "which stays" if self.pivot == "centre line" else "whose top stays"
        turns = f"turns about the {self.pivot}, {stays} at the height of the grade line"
        if self.lift is not None and self.pivot == "centre line":
            turns = "by the heights of both rails of the alignment"
        bends = {s.centre_of_gravity_height for s in self.segments if isinstance(s, Transition)} - {None}
        high = ", ".join(f"{height:g}" for height in sorted(filter(None, bends)))
        bend = f"; Viennese bends for a centre of gravity {high} m above the rail tops" if high else ""
        width, change = self.left_curve.cant.rounding
        kinks = f"; kinks rounded over {width:g} m to either side, by up to {1e3 * change:.2g} mm" if change else ""
        return f"over {1e3 * self.cant_base:g} mm, {turns}{kinks}{bend}"

    def grade(self, s: ArrayLike) -> Array:
        """Grade of the centre line: rise over level length, positive uphill."""
        return np.asarray(np.tan(self.centre_line.pitch_law(s)))

    def gauge(self, s: ArrayLike) -> Array:
        """Gauge with widening and irregularities [m]."""
        left, right = (curve.irregularity.lateral(s, 0)[0] for curve in (self.left_curve, self.right_curve))
        return np.asarray(self.nominal_gauge + self.left_curve.widening(s) + left - right)

    def irregularity(self, side: Literal["left", "right"], s: ArrayLike) -> tuple[Array, Array]:
        """How far a rail lies to the left of and above its designed place [m]."""
        uneven = self._curve(side).irregularity
        return uneven.lateral(s, 0)[0], uneven.vertical(s, 0)[0]

    def widening(self, s: ArrayLike) -> Array:
        """Designed gauge beyond the nominal one [m]."""
        return self.left_curve.widening(s)

    @property
    def is_uneven(self) -> bool:
        """True when a rail has irregularities."""
        return any(curve.irregularity != SMOOTH for curve in (self.left_curve, self.right_curve))

    def rail_distance(self, side: Literal["left", "right"], s: ArrayLike) -> Array:
        """Own arclength of a rail [m] in the cross-section at centre-line distance s."""
        return self._curve(side).arclength(s)

    @property
    def rail_origins(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Outward and up coordinates of the left and right rail profile's origin at nominal gauge [m]."""
        left, right = ((0.5 * self.nominal_gauge + c.outward, c.height) for c in (self.left_curve, self.right_curve))
        return left, right

    def faded(self, place: float, length: float) -> Track:
        """The track whose irregularities begin at a place and fade in over a length [m]."""
        left, right = (
            replace(curve, irregularity=replace(curve.irregularity, fade=(place, length)))
            for curve in (self.left_curve, self.right_curve)
        )
        return replace(self, left_curve=left, right_curve=right)

    def relaid(self, segments: Sequence[Segment]) -> Track:
        """Another track, of these segments, with the same rails, gauge and cant base."""
        left, right = ((curve.outward, curve.height) for curve in (self.left_curve, self.right_curve))
        rails: dict[str, Any] = {"left_offset": left, "right_offset": right, "structure": self.structure}
        return Track.build(segments, self.nominal_gauge, cant_base=self.cant_base, pivot=self.pivot, **rails)

    def features(self) -> tuple[Feature, ...]:
        """The segments in order, with labels and distances, for plots and reports."""
        if not self.segments:
            return (Feature("table", "measured", 0.0, self.length),)
        ends = pairwise(accumulate((float(s.length) for s in self.segments), initial=0.0))
        return tuple(Feature(kind_word(s), _label(s), *ends) for s, ends in zip(self.segments, ends, strict=True))

    def _curve(self, side: str) -> SweptCurve:
        if side not in ("left", "right"):
            raise InputError(f"side = {side!r}; allowed: 'left', 'right'")
        return self.left_curve if side == "left" else self.right_curve


def _label(segment: Segment) -> str:
    """Short text for a segment."""
    if isinstance(segment, Arc):
        return f"R {abs(segment.radius):g} m {'left' if segment.radius > 0.0 else 'right'}"
    return LABEL.get(segment.form, segment.form) if isinstance(segment, Transition) else "straight"
