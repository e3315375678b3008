"""[track]: gauge, rails and the row of segments that the wheelset runs along."""

import math
import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from annotated_types import Predicate
from pydantic import BeforeValidator, Field

from wrsim.contact.profiles.profile import GAUGE_DEPTH
from wrsim.inputs.section import SIDES, Choice, Fault, Section, both_or_sides, on_side
from wrsim.inputs.values import List, number, number_limits, plain_number, positive, refuse, requirement, text, unpacked
from wrsim.scenario.sections.irregularities import GradeSection, IrregularitySection, grades_in_order
from wrsim.scenario.sections.structure import AnyStructure
from wrsim.track import segments
from wrsim.track.cant import Pivot, cant_base
from wrsim.track.forms import CantForm, Form

Length = Annotated[float, number(0.01, segments.LONGEST, "m")]
LENGTHS = number_limits(unpacked(Length).limits)[:2]
Cant = Annotated[float, number(-250, 250, "mm, positive leans to the inside of the curve")]
Widening = Annotated[float, number(-100, 100, "mm")]
CantBase = Annotated[float, number(400, 2200, "mm between the rail tops that cant is measured over, such as 1500")]
RailName = Annotated[str, text('a rail profile file such as "rails/60E1.toml"')]


def _slope(value: Any) -> Any:
    """The slope of a rail inclination as users write it: 1:40 is 0.025."""
    if value == "none":
        return 0.0
    ratio = re.fullmatch(r"\s*1\s*([:/])\s*(\d+(?:\.\d+)?)\s*", value) if isinstance(value, str) else None
    n = float(ratio[2]) if ratio else value
    if ratio and ratio[1] == ":" and n >= 5.0:
        return 1.0 / n
    if isinstance(n, float | int) and not 0.0 <= n <= 0.2:
        meant = f'; did you mean "1:{n:g}"?' if 5.0 <= n <= 100.0 else ""
        raise refuse(f"must be {requirement(Inclination)}{meant}")
    return value


Inclination = Annotated[
    float, BeforeValidator(_slope), Field(description='"1:40", "1:20", "none" or a slope from 0 to 0.2')
]
"""``"1:n"`` with n >= 5; the rail's top leans towards the track centre."""


Radius = Annotated[
    float,
    Predicate(lambda radius: 10.0 <= abs(radius) <= 1e6),
    Field(
        description="a number of size 10 to 1000000, of either sign (m, positive curves to the left, negative to the "
        "right)"
    ),
]


class SegmentTable(Choice, header="[[track.segments]]"):
    """A piece of the track."""

    geometry: ClassVar[Callable[..., segments.Segment]]

    kind: str
    """Kind of piece."""

    def to_geometry(self) -> segments.Segment:
        return self.to_si(self.geometry)


class StraightSegment(SegmentTable, kind="straight"):
    """A straight piece; cant and gauge may run from one value to another along it."""

    geometry = segments.Straight
    also_called = "tangent line"

    length_m: Length
    """Length of the centre line in plan."""
    cant_start_mm: Cant = 0.0
    """Cant where the piece begins."""
    cant_end_mm: Cant = 0.0
    """Cant where the piece ends."""
    gauge_widening_start_mm: Widening = 0.0
    """By how much the gauge is wider than gauge_mm where the piece begins."""
    gauge_widening_end_mm: Widening = 0.0
    """By how much the gauge is wider than gauge_mm where the piece ends."""


EndRadius = Annotated[
    float,
    Predicate(lambda radius: radius == 0.0 or 10.0 <= abs(radius) <= 1e6),
    Field(
        description="a number of size 10 to 1000000 (m, positive curves to the left, negative to the right), or 0 for "
        "straight track"
    ),
]


class TransitionSegment(SegmentTable, kind="transition"):
    """From the curvature and cant of the segment before to those of the segment after."""

    also_called = "spiral easement ramp"
    goes_with = {"cant_start_mm": "radius_start_m", "cant_end_mm": "radius_end_m"}

    length_m: Length
    """Length of the centre line in plan."""
    form: Form = "clothoid"
    """How curvature, cant and gauge lead over; cant and gauge of a cubic parabola linearly."""
    cant_form: CantForm | None = None
    """How cant and gauge lead over where they do not as the curvature."""
    radius_start_m: EndRadius | None = None
    """Radius where it begins, behind another transition; 0 is straight track."""
    radius_end_m: EndRadius | None = None
    """Radius where it ends, before another transition; 0 is straight track."""
    cant_start_mm: Cant = 0.0
    """Cant where it begins, with radius_start_m."""
    cant_end_mm: Cant = 0.0
    """Cant where it ends, with radius_end_m."""
    centre_of_gravity_height_m: Annotated[float, number(0, segments.HIGHEST, "m above the rail tops")] | None = None
    """Height of the point whose path a Viennese bend shapes; the centre line deviates by the cant."""

    def consistency(self) -> Iterator[Fault]:
        if self.centre_of_gravity_height_m is not None and self.form != "viennese":
            yield Fault("centre_of_gravity_height_m", f'goes with form = "viennese" (form is "{self.form}")')

    def to_geometry(self) -> segments.Transition:
        radii = {key: getattr(self, f"{key}_m") for key in ("radius_start", "radius_end")}
        return self.to_si(
            segments.Transition, **{key: math.inf if radius == 0.0 else radius for key, radius in radii.items()}
        )


class ArcSegment(SegmentTable, kind="arc"):
    """A circular arc: radius (positive: curves to the left), length or angle, cant, gauge widening."""

    also_called = "curve circle circular radius"
    one_of = ("length_m angle_deg",)

    radius_m: Radius
    """Radius of the centre line in plan; positive curves to the left."""
    length_m: Length | None = None
    """Length of the centre line in plan; or give angle_deg."""
    angle_deg: Annotated[float, positive(36_000, "degrees, always positive")] | None = None
    """Angle that the track turns by; or give length_m."""
    cant_mm: Cant = 0.0
    """Height of the outer rail above the inner one."""
    gauge_widening_mm: Widening = 0.0
    """By how much the gauge is wider than gauge_mm."""

    def consistency(self) -> Iterator[Fault]:
        if not LENGTHS[0] <= self.length <= LENGTHS[1]:
            yield Fault("angle_deg", f"makes an arc of {self.length:g} m; its length must be {requirement(Length)}")

    @property
    def length(self) -> float:
        if self.length_m is not None:
            return self.length_m
        return abs(self.radius_m) * math.radians(self.angle_deg or 0.0)

    def to_geometry(self) -> segments.Arc:
        return self.to_si(segments.Arc, length=self.length)


Segment = StraightSegment | TransitionSegment | ArcSegment


class CheckRailSection(Section, header="check_rail"):
    """A check rail beside a rail, which takes a wheel by the back of its flange; its working face leans by 6:1."""

    flangeway_mm: Annotated[float, number(20, 150, "mm, such as 41")]
    """Width between gauge face and working face, at the depth of the gauge point."""
    height_mm: Annotated[float, number(-25, 80, "mm")] = 0.0
    """How far its top lies above that of the running rail."""


class RailSectionSection(Section, header="[[track.rail_sections]]"):
    """A section of a rail whose profile changes along the track; in place of rail from the first section to the last.

    Before the first and behind the last one the rail stays as it is there. features_mm: arclengths from the first point
    of the profile of places that belong together in all sections, such as corners. A part between two of them that has
    no length in a section does not exist there. down_mm, outward_mm: the profile is moved. table, crossing: many
    sections from one file, in place of rail and features_mm.
    """

    one_of = ("rail table crossing",)
    at_most_one = ("table features_mm", "crossing features_mm", "check_rail features_mm")
    goes_with = {"measured": "table", "trailing": "crossing", "check_rail": "rail"}

    at_m: Annotated[float, number(0, 1e6, "m along the track")]
    """Where along the track the rail has this section; where the distances of a table begin to count, or where the
    faces of a crossing's nose meet."""
    rail: RailName | None = None
    """Profile of the rail there."""
    table: Annotated[str, text('a CSV file of sections such as "crossing.csv"')] | None = None
    """CSV file of the points of many sections: columns at_m, outward_mm, up_mm, feature."""
    measured: bool | None = None
    """The points of the table are smoothed (true) or interpolated (false, the default)."""
    crossing: Annotated[str, text('a crossing file such as "crossings/60E1_1in9.toml"')] | None = None
    """Fixed crossing of the track with another one, from a few numbers."""
    trailing: bool | None = None
    """The crossing is passed from its nose onto its wing (true), or the other way (false, the default)."""
    side: Literal["left", "right", "both"] = "both"
    """Which rail has it."""
    check_rail: CheckRailSection | None = None
    """A check rail beside it; all sections of a rail have one, or none has."""
    features_mm: List[Annotated[float, number(0, 1000)]] = ()
    """Arclengths from the first point of the profile of places that belong together in all sections."""
    down_mm: Annotated[float, number(-50, 50)] = 0.0
    """How far the profile lies lower than that of a plain rail."""
    outward_mm: Annotated[float, number(-100, 100)] = 0.0
    """How far the profile lies further away from the track centre than that of a plain rail."""


class RollersSection(Section, header="[track.rollers]"):
    """Rollers under all wheels in place of rails: a roller rig.

    Each wheelset has its middle over the tops of its two rollers. These turn with the vehicle's speed at the origins of
    their profiles, which are those of the rails.
    """

    radius_mm: Annotated[float, number(100, 1e12, "mm, such as 800")]
    """Radius of the rollers at the origins of their profiles."""


class TrackSection(Section, header="[track]"):
    """Gauge, rails, the way they are laid and what they rest on.

    gauge_between = "origins" (static poses only): gauge_mm is the distance of the two rail profiles' origins, which lie
    in the plane of the track. For bare pairs of curves that have no gauge point.
    """

    at_most_one = (
        "segments table", "segments alignment", "table alignment", "alignment grades", "rollers alignment",
        "check_rail check_rail_left", "check_rail check_rail_right", "rollers table",
        "rollers grades", "rollers irregularities", "rollers rail_sections", "rollers check_rail",
        "rollers check_rail_left", "rollers check_rail_right",
    )  # fmt: skip

    file: Annotated[str, text('a track file such as "tracks/mixed_line.toml"')] | None = None
    """File of a track that many scenarios share; keys given here lie over its own, keys of a base beneath."""

    gauge_mm: Annotated[float, number(400, 2000, "mm, gauge_depth_mm below the inclined rails' tops, such as 1435")]
    """Track gauge between the gauge points of the rails."""
    gauge_depth_mm: Annotated[float, number(5, 30, "mm below the top of the inclined rails")] = 1e3 * GAUGE_DEPTH
    """How far below the tops of the inclined rails the gauge points lie."""
    gauge_between: Literal["gauge points", "origins"] = "gauge points"
    """What gauge_mm counts between; the origins of the rail profiles are for poses of bare curves."""
    inclination: Inclination
    """How far the rails lean towards the track centre."""
    rail: RailName | None = None
    """Profile of both rails."""
    rail_left: RailName | None = None
    """Profile of the left rail."""
    rail_right: RailName | None = None
    """Profile of the right rail."""
    check_rail: CheckRailSection | None = None
    """Check rails beside both rails, along the whole track."""
    check_rail_left: CheckRailSection | None = None
    """Check rail beside the left rail alone."""
    check_rail_right: CheckRailSection | None = None
    """Check rail beside the right rail alone."""
    cant_base_mm: CantBase | None = None
    """Distance between the rail tops that cant is counted over; gauge + 65 mm unless given."""
    pivot: Pivot = "centre line"
    """What cant turns the track about, which stays at the height of the grade line."""
    segments: List[Annotated[Segment, Field(discriminator="kind")]] = ()
    """Straights, transitions and arcs, one after the other."""
    table: Annotated[str, text('a CSV file of measured track such as "line.csv"')] | None = None
    """Measured curvature, cant and gauge over the distance, in place of segments."""
    alignment: Annotated[str, text('an IFC, LandXML or railML file such as "line.ifc"')] | None = None
    """Line of a civil file in place of segments and grades: plan, profile and cant of each rail."""
    alignment_name: Annotated[str, text('the name of an alignment such as "track 1"')] | None = None
    """Which alignment of the file, where it has several."""
    grades: List[GradeSection] = ()
    """Where the line begins to climb or fall."""
    irregularities: List[Annotated[IrregularitySection, Field(discriminator="kind")]] = ()
    """Where the rails leave their designed place: spectra, measurements, single defects."""
    structure: AnyStructure | None = None
    """What the rails rest on; without it a run in time has a mass on springs under each wheel."""
    rail_sections: List[RailSectionSection] = ()
    """Profiles of rails that change along the track, such as worn stretches, welds, crossings."""
    rollers: RollersSection | None = None
    """Rollers in place of rails."""
    row_distance_m: Annotated[float, number(0.01, 1, "m between the rows of the rails' tables")] | None = None
    """Distance between two rows of the tables that irregular or changing rails are read from."""

    @classmethod
    def raw_faults(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        yield from both_or_sides(raw, "rail", needed=requirement(RailName))
        yield from grades_in_order(raw.get("grades"))
        row = raw.get("segments")
        tables = [s if isinstance(s, dict) else {} for s in row] if isinstance(row, list) else []
        for i, (before, table) in enumerate(pairwise(tables), 1):
            open_or_twice = ("radius_end_m" in before) == ("radius_start_m" in table)
            if before.get("kind") == table.get("kind") == "transition" and open_or_twice:
                message = "follows another transition: put an arc or a straight between them, or give one of "
                yield Fault(("segments", i), message + "radius_end_m of the first and radius_start_m of the second")

    def consistency(self) -> Iterator[Fault]:
        if not self.gauge_mm <= self.cant_base * 1000.0 <= self.gauge_mm + 500.0:
            allowed = f"{plain_number(self.gauge_mm)} to {plain_number(self.gauge_mm + 500.0)}"
            yield Fault("cant_base_mm", f"must be from the gauge to 500 mm more ({allowed})")
        level = StraightSegment(kind="straight", length_m=1.0)
        for i, segment in enumerate(self.segments if self.rollers else ()):
            if segment.model_copy(update={"length_m": 1.0}) != level:
                yield Fault(("segments", i), "must be straight, without cant and widening: [track.rollers] are level")
        for side in SIDES:
            sections = on_side(self.rail_sections, side)
            if len(sections) == 1 and sections[0][1].rail is not None:
                yield Fault(("rail_sections", sections[0][0]), "is the only one of its rail; at least 2 are needed")
            for (_, before), (i, section) in pairwise(sections):
                if section.at_m <= before.at_m:
                    message = f"must be more than {plain_number(before.at_m)}, where its rail has the section before"
                    yield Fault(("rail_sections", i, "at_m"), message)

    @property
    def cant_base(self) -> float:
        """Distance between the rail tops [m] that the cant is measured over: gauge + 65 mm unless given."""
        return cant_base(self.gauge_mm, self.cant_base_mm)
