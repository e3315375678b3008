"""[track]: gauge, rails and the row of segments that the wheelset runs along."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from wrsim.geometry.track import segments
from wrsim.geometry.track.elasticity import RailElasticity
from wrsim.inputs.section import Fault, Section, both_or_sides
from wrsim.inputs.values import (
    Annotation,
    AwayFromZero,
    Choice,
    Quantity,
    TableList,
    Tables,
    Text,
    as_float,
    plain,
    refuse,
)
from wrsim.scenario.sections.irregularities import IRREGULARITIES, GradeSection, IrregularitySection, grades_in_order

Length = Quantity(0.01, 1e5, example="m")
Cant = Quantity(-250, 250, example="mm, positive leans to the inside of the curve")
Widening = Quantity(-100, 100, example="mm")
RailName = Text('a rail profile file such as "rails/60E1.toml"')


class Inclination(Annotation):
    """Rail inclination: ``"1:40"``, ``"1:20"`` (any ``"1:n"``, n >= 5), ``"none"`` or the slope as a number.

    The check returns the slope (1:40 is 0.025); the rail's top leans towards the track centre.
    """

    def words(self) -> str:
        return '"1:40", "1:20", "none" or a slope from 0 to 0.2'

    def check(self, value: Any) -> float:
        if value == "none":
            return 0.0
        ratio = re.fullmatch(r"\s*1\s*:\s*(\d+(?:\.\d+)?)\s*", value) if isinstance(value, str) else None
        slope = 1.0 / float(ratio[1]) if ratio and float(ratio[1]) > 0.0 else as_float(value)
        if slope is None or not 0.0 <= slope <= 0.2:
            hint = ""
            if slope is not None and 5.0 <= slope <= 100.0:
                hint = f'; did you mean "1:{slope:g}"?'
            elif isinstance(value, str) and re.fullmatch(r"\s*1\s*/\s*\d+\s*", value):
                hint = f'; did you mean "{value.strip().replace(" ", "").replace("/", ":")}"?'
            raise refuse(f"must be {self.words()}{hint}")
        return slope


class Straight(Section):
    """A straight piece; cant and gauge may run from one value to another along it."""

    header: ClassVar[str] = "[[track.segments]] with kind = straight"
    aliases: ClassVar[dict[str, str]] = {"l": "length_m", "L": "length_m"}

    kind: Annotated[Literal["straight"], Choice(("straight",))]
    length_m: Annotated[float, Length]
    cant_start_mm: Annotated[float, Cant] = 0.0
    cant_end_mm: Annotated[float, Cant] = 0.0
    gauge_widening_start_mm: Annotated[float, Widening] = 0.0
    gauge_widening_end_mm: Annotated[float, Widening] = 0.0

    def to_geometry(self) -> segments.Straight:
        """Return the segment in SI units."""
        return segments.Straight(
            self.length_m,
            self.cant_start_mm / 1000.0,
            self.cant_end_mm / 1000.0,
            self.gauge_widening_start_mm / 1000.0,
            self.gauge_widening_end_mm / 1000.0,
        )


class Transition(Section):
    """From the curvature and cant of the segment before to those of the segment after."""

    header: ClassVar[str] = "[[track.segments]] with kind = transition"
    aliases: ClassVar[dict[str, str]] = {"l": "length_m", "L": "length_m", "type": "form", "shape": "form"}

    kind: Annotated[Literal["transition"], Choice(("transition",))]
    length_m: Annotated[float, Length]
    form: Annotated[Literal["clothoid", "bloss"], Choice(("clothoid", "bloss"))] = "clothoid"

    def to_geometry(self) -> segments.Transition:
        """Return the segment in SI units."""
        return segments.Transition(self.length_m, self.form)


class Arc(Section):
    """A circular arc: radius (positive: curves to the left), length or angle, cant, gauge widening."""

    header: ClassVar[str] = "[[track.segments]] with kind = arc"
    aliases: ClassVar[dict[str, str]] = {
        "l": "length_m",
        "L": "length_m",
        "r": "radius_m",
        "R": "radius_m",
        "superelevation": "cant_mm",
        "superelevation_mm": "cant_mm",
        "widening": "gauge_widening_mm",
        "widening_mm": "gauge_widening_mm",
    }

    kind: Annotated[Literal["arc"], Choice(("arc",))]
    radius_m: Annotated[float, AwayFromZero(10, 1e6, "m, positive curves to the left, negative to the right")]
    length_m: Annotated[float, Length] | None = None
    angle_deg: Annotated[float, Quantity(above=0, high=36_000, example="degrees, always positive")] | None = None
    cant_mm: Annotated[float, Cant] = 0.0
    gauge_widening_mm: Annotated[float, Widening] = 0.0

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """Length or angle."""
        if "length_m" in raw and "angle_deg" in raw:
            yield Fault("angle_deg", "cannot stand next to length_m: give one of them")
        elif "length_m" not in raw and "angle_deg" not in raw:
            yield Fault((), "needs length_m or angle_deg")

    def consistency(self) -> Iterator[Fault]:
        """An angle may be right and its arc too short or too long."""
        if not Length.holds(self.length):
            yield Fault("angle_deg", f"makes an arc of {self.length:g} m; its length must be {Length.words()}")

    @property
    def length(self) -> float:
        """Length of the arc [m]."""
        if self.length_m is not None:
            return self.length_m
        assert self.angle_deg is not None
        return abs(self.radius_m) * math.radians(self.angle_deg)

    def to_geometry(self) -> segments.Arc:
        """Return the segment in SI units."""
        return segments.Arc(self.length, self.radius_m, self.cant_mm / 1000.0, self.gauge_widening_mm / 1000.0)


Segment = Straight | Transition | Arc
SEGMENTS: dict[str, type[Straight] | type[Transition] | type[Arc]] = {
    "straight": Straight,
    "transition": Transition,
    "arc": Arc,
}


class ElasticitySection(Section):
    """A mass on spring and damper under each wheel, moving along with it; laterally and vertically."""

    header: ClassVar[str] = "[track.elasticity]"
    aliases: ClassVar[dict[str, str]] = {"mass_kg": "vertical_mass_kg"}

    lateral_stiffness_MN_per_m: Annotated[float, Quantity(0.1, 1e5, example="20 to 50 for one rail under one wheel")]
    vertical_stiffness_MN_per_m: Annotated[float, Quantity(0.1, 1e5, example="30 to 100")]
    lateral_damping_kNs_per_m: Annotated[float, Quantity(0, 1e5)]
    vertical_damping_kNs_per_m: Annotated[float, Quantity(0, 1e5)]
    lateral_mass_kg: Annotated[float, Quantity(1, 1e5, example="of the rail and what moves with it")]
    vertical_mass_kg: Annotated[float, Quantity(1, 1e5, example="of the rail and what moves with it")]

    def to_geometry(self) -> RailElasticity:
        """The same in SI units."""
        return RailElasticity(
            stiffness=(1e6 * self.lateral_stiffness_MN_per_m, 1e6 * self.vertical_stiffness_MN_per_m),
            damping=(1e3 * self.lateral_damping_kNs_per_m, 1e3 * self.vertical_damping_kNs_per_m),
            mass=(self.lateral_mass_kg, self.vertical_mass_kg),
        )


class TrackSection(Section):
    """file, gauge_mm, rail (or rail_left, rail_right), inclination, cant_base_mm, segments or table, grades,
    irregularities, elasticity, row_distance_m.

    gauge_between = "origins" (static poses only): gauge_mm is the distance of the two rail profiles' origins, which lie
    in the plane of the track. For bare pairs of curves that have no gauge point.
    """

    header: ClassVar[str] = "[track]"
    aliases: ClassVar[dict[str, str]] = {
        "rail_cant": "inclination",
        "rail_inclination": "inclination",
        "profile": "rail",
        "rail_profile": "rail",
        "segment": "segments",
        "grade": "grades",
        "gradients": "grades",
        "irregularity": "irregularities",
        "defects": "irregularities",
        "csv": "table",
        "model": "file",
    }

    file: Annotated[str, Text('a track file such as "tracks/mixed_line.toml"')] | None = None

    gauge_mm: Annotated[
        float, Quantity(400, 2000, example="mm, 14 mm below the top of the inclined rails, such as 1435")
    ]
    gauge_between: Annotated[Literal["gauge points", "origins"], Choice(("gauge points", "origins"))] = "gauge points"
    inclination: Annotated[float, Inclination()]
    rail: Annotated[str, RailName] | None = None
    rail_left: Annotated[str, RailName] | None = None
    rail_right: Annotated[str, RailName] | None = None
    cant_base_mm: (
        Annotated[
            float,
            Quantity(400, 2200, example="mm between the rail tops that cant is measured over, such as 1500"),
        ]
        | None
    ) = None
    segments: Annotated[tuple[Segment, ...], TableList("kind", lambda: SEGMENTS, "[[track.segments]]")] = ()
    table: Annotated[str, Text('a CSV file of measured track such as "line.csv"')] | None = None
    grades: Annotated[tuple[GradeSection, ...], Tables(GradeSection, "[[track.grades]]")] = ()
    irregularities: Annotated[
        tuple[IrregularitySection, ...], TableList("kind", lambda: IRREGULARITIES, "[[track.irregularities]]")
    ] = ()
    elasticity: ElasticitySection | None = None
    row_distance_m: Annotated[float, Quantity(0.01, 1, example="m between the rows of the rails' tables")] | None = None

    @classmethod
    def rules(cls, raw: dict[str, Any]) -> Iterator[Fault]:
        """A rail for both sides or one for each; a transition lies between two arcs or straights."""
        yield from both_or_sides(raw, "rail", "rail_left", "rail_right", needed=RailName.words())
        if "table" in raw and "segments" in raw:
            yield Fault("table", "cannot stand next to segments: the geometry comes from one place")
        yield from grades_in_order(raw.get("grades"))
        row = raw.get("segments")
        kinds = [s.get("kind") if isinstance(s, dict) else None for s in row] if isinstance(row, list) else []
        for i in range(1, len(kinds)):
            if kinds[i - 1] == kinds[i] == "transition":
                message = "follows another transition: put an arc or a straight between them"
                yield Fault(("segments", i), message)

    def consistency(self) -> Iterator[Fault]:
        """Cant is measured between the rail tops, which lie outside of the gauge."""
        if not self.gauge_mm <= self.cant_base * 1000.0 <= self.gauge_mm + 500.0:
            allowed = f"{plain(self.gauge_mm)} to {plain(self.gauge_mm + 500.0)}"
            yield Fault("cant_base_mm", f"must be from the gauge to 500 mm more ({allowed})")

    @property
    def rails(self) -> tuple[str, str]:
        """Names of the left and right rail profile."""
        left, right = self.rail_left or self.rail, self.rail_right or self.rail
        assert left is not None and right is not None
        return left, right

    @property
    def cant_base(self) -> float:
        """Distance between the rail tops [m] that the cant is measured over: gauge + 65 mm unless given."""
        return (self.gauge_mm + 65.0 if self.cant_base_mm is None else self.cant_base_mm) / 1000.0
