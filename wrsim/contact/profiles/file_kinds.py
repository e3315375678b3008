"""The TOML file of a profile, by its kind: shapes by formula.

Kinds that start from another profile or from points are in `wrsim.contact.profiles.models`, which reads all of them.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
import scipy
from pydantic import Field

from wrsim.contact.profiles import sections as shapes
from wrsim.contact.profiles.files import HEIGHTS, ORIGINS, SIDES
from wrsim.contact.profiles.flange import flange_dimensions
from wrsim.contact.profiles.formats import METRES
from wrsim.contact.profiles.profile import Kind, Profile
from wrsim.errors import InputError
from wrsim.inputs.section import Choice, Fault, Section
from wrsim.inputs.values import Day, List, Source, Two, number, positive, text

MM = 1e-3
REACH = 0.13  # length of the tread of a wheel of kind "flanged", more than a wheel's width [m]

Length = Annotated[float, number(1e-3, 1e4)]
Coordinate = Annotated[float, number(-1000.0, 1000.0)]

BackToTapeCircle = Annotated[float, number(20, 120, "mm, 70 in Europe")]
Pair = Annotated[Two[Annotated[float, number(-1e5, 1e5)]], Field(description="two numbers: [u, height]")]


class SectionTable(Choice, header="[[sections]]"):
    """A section of a profile."""

    tag: ClassVar[str] = "shape"

    shape: str
    """Shape of the section."""

    def piece(self, down: bool) -> shapes.ProfileSection:
        """The section in metres, up positive; down: heights of the file grow downward."""
        raise NotImplementedError


class SpanTable(SectionTable):
    """A section between two places."""

    from_mm: Coordinate
    """Where the section begins, outward from the origin."""
    to_mm: Coordinate
    """Where it ends; it may lie on either side of the beginning."""

    @property
    def span(self) -> tuple[float, float]:
        """Its ends from left to right [m]."""
        return min(self.from_mm, self.to_mm) * MM, max(self.from_mm, self.to_mm) * MM

    def consistency(self) -> Iterator[Fault]:
        if self.from_mm == self.to_mm:
            yield Fault("to_mm", "must differ from from_mm")


class PolynomialSection(SpanTable, kind="polynomial"):
    """height = c0 + c1 u + c2 u^2 + ..., in mm."""

    coefficients_mm: List[Annotated[float, number()]]
    """c0, c1, c2, ... of height = c0 + c1 u + c2 u^2 + ..., all in mm."""

    def piece(self, down: bool) -> shapes.ProfileSection:
        sign = -1.0 if down else 1.0
        c = tuple(sign * c * 1000.0 ** (k - 1) for k, c in enumerate(self.coefficients_mm))
        return shapes.ProfilePolynomial(c, *self.span)

    def consistency(self) -> Iterator[Fault]:
        yield from super().consistency()
        if not self.coefficients_mm:
            yield Fault("coefficients_mm", "must hold at least one number")


class ArcSection(SpanTable, kind="arc"):
    """Part of a circle, above or below its centre."""

    centre_mm: Pair
    """Centre of the circle; its height grows as `heights` of the file."""
    radius_mm: Length
    """Radius of the circle."""
    half: Literal["upper", "lower"]
    """Which half of the circle in space, whichever way the file's heights grow."""

    def piece(self, down: bool) -> shapes.ProfileSection:
        u, w = self.centre_mm[0], -self.centre_mm[1] if down else self.centre_mm[1]
        return shapes.arc_between(u * MM, w * MM, self.radius_mm * MM, self.half == "upper", *self.span)

    def consistency(self) -> Iterator[Fault]:
        yield from super().consistency()
        for key, end in (("from_mm", self.from_mm), ("to_mm", self.to_mm)):
            u, reach = self.centre_mm[0], self.radius_mm
            if abs(end - u) > reach * (1.0 + 1e-9):
                yield Fault(key, f"is beside the circle; must be a number from {u - reach:g} to {u + reach:g}")


class LineSection(SectionTable, kind="line"):
    """Straight between two points."""

    start_mm: Pair
    """One end of the line."""
    end_mm: Pair
    """The other end."""

    def piece(self, down: bool) -> shapes.ProfileSection:
        sign = -MM if down else MM
        (u0, w0), (u1, w1) = sorted((self.start_mm, self.end_mm))
        return shapes.ProfileLine(u0 * MM, sign * w0, u1 * MM, sign * w1)

    def consistency(self) -> Iterator[Fault]:
        if self.start_mm == self.end_mm:
            yield Fault("end_mm", "must differ from start_mm")


class PieceTable(Choice, header="[[pieces]]"):
    """A piece of a chain."""

    tag: ClassVar[str] = "shape"

    shape: str
    """Shape of the piece."""


class ChainLine(PieceTable, kind="line"):
    """Straight on for a length."""

    length_mm: Length
    """How long it is."""


class ChainArc(PieceTable, kind="arc"):
    """Turn with a radius until a tangent angle."""

    radius_mm: Length
    """Radius of the circle."""
    to_angle_deg: Annotated[float, number(-180.0, 180.0)]
    """Angle of the tangent at its end, positive where the curve rises outward; it decides which way the arc bends."""


class ProfileFile(Choice, header="a profile file"):
    """A profile file."""

    name: Annotated[str, text("the profile's name")]
    """Name of the profile, for pictures and messages."""
    body: Kind
    """Whose profile it is."""
    kind: str
    """How the shape is given; it decides which further keys the file takes."""
    date: Day
    """Day on which the file was written."""
    source: Source
    """Where the shape comes from."""

    def build(self, path: Path) -> Profile:
        """The profile; path: of the file, for names relative to it."""
        raise NotImplementedError


Shape = Annotated[PolynomialSection | ArcSection | LineSection, Field(discriminator="shape")]


class SectionsFile(ProfileFile, kind="sections"):
    """Lines, polynomials and arcs by centre."""

    heights: Literal[*HEIGHTS] = "up"  # type: ignore[valid-type]
    """Which way the file's heights grow."""
    sections: List[Shape]
    """The pieces, end to end, from either side."""

    def build(self, path: Path) -> Profile:
        pieces = [s.piece(self.heights == "down") for s in self.sections]
        if not pieces:
            raise InputError("sections is empty; at least one [[sections]] table is needed")
        pieces.sort(key=lambda s: float(s.evaluate(np.array([s.start]))[0][0, 0]))
        return shapes.profile_from_sections(self.name, self.body, pieces, self.source)


class ChainFile(ProfileFile, kind="chain"):
    """Tangent lines and arcs; heights are shifted so that the curve passes through the origin."""

    start_mm: Coordinate
    """Where the chain begins, outward from the origin."""
    start_angle_deg: Annotated[float, number(-180.0, 180.0)]
    """Angle of the tangent there, positive where the curve rises outward."""
    pieces: List[Annotated[ChainLine | ChainArc, Field(discriminator="shape")]]
    """Lines and arcs, each tangent to the one before, outward."""

    def build(self, path: Path) -> Profile:
        if not self.pieces:
            raise InputError("pieces is empty; at least one [[pieces]] table is needed")
        chain, angle = shapes.Chain(self.start_mm * MM, 0.0), np.radians(self.start_angle_deg)
        for i, piece in enumerate(self.pieces):
            if isinstance(piece, ChainLine):
                length = piece.length_mm * MM
                chain.line(chain.u + length * np.cos(angle), chain.w + length * np.sin(angle))
                continue
            last = np.radians(piece.to_angle_deg)
            if abs(last - angle) < 1e-9:
                key = f"pieces[{i}].to_angle_deg = {piece.to_angle_deg:g}"
                raise InputError(f"{key}: the curve has this angle already; must differ, or the piece be a line")
            chain.arc(piece.radius_mm * MM, angle, last)
            angle = last
        profile = shapes.profile_from_sections(self.name, self.body, chain.sections, self.source)
        return profile.shifted(dw=-float(profile.at(profile.arclength_of(0.0))[1]))


class FlangedFile(ProfileFile, kind="flanged"):
    """A wheel of given flange angle and length: round tip, straight flank, round root, conical tread."""

    flange_angle_deg: Annotated[float, number(45.0, 85.0)]
    """Angle of the flank against the axle."""
    flange_length_mm: Annotated[float, number(1.0, 60.0)]
    """Way along the flange from the begin of the flank to where the tip is as flat as 26.6 degrees (arctan 0.5)."""
    thickness_mm: Annotated[float, number(10.0, 60.0)] = 32.5
    """Thickness of the flange Sd: from the back, 70 mm inside of the tape circle, to the face 10 mm below it."""
    tip_radius_mm: Annotated[float, number(1.0, 50.0)] = 9.5
    """Radius of the tip."""
    root_radius_mm: Annotated[float, number(1.0, 100.0)] = 14.0
    """Radius of the root, between flank and tread."""
    conicity: Annotated[float, number(0.0, 0.2, "1:20 is 0.05")] = 0.05
    """Slope of the tread."""

    def consistency(self) -> Iterator[Fault]:
        if self.body != "wheel":
            yield Fault("body", 'must be "wheel" for this kind')
        if self.flank <= 0.0:
            least = self.flange_length_mm - self.flank / MM
            yield Fault("flange_length_mm", f"must be above {least:.4g}, the length of the tip's arc")

    @property
    def flank(self) -> float:
        """Length of the straight part [m]."""
        return MM * (self.flange_length_mm - self.tip_radius_mm * (np.radians(self.flange_angle_deg) - np.arctan(0.5)))

    def build(self, path: Path) -> Profile:
        angle, flat = np.radians(self.flange_angle_deg), float(np.arctan(self.conicity))
        chain = shapes.Chain(0.0, 0.0)
        chain.arc(self.tip_radius_mm * MM, -angle, angle)
        chain.line(chain.u + self.flank * np.cos(angle), chain.w + self.flank * np.sin(angle))
        chain.arc(self.root_radius_mm * MM, angle, flat)
        root = chain.u
        chain.line(root + REACH, chain.w + REACH * self.conicity)
        whole = shapes.profile_from_sections(self.name, self.body, chain.sections, self.source)

        def on_tape_circle(u: float) -> Profile:
            """The whole with its point at u in the origin."""
            return whole.shifted(-u, -float(whole.at(whole.arclength_of(u))[1]))

        def too_thick(u: float) -> float:
            return flange_dimensions(on_tape_circle(u)).thickness - self.thickness_mm * MM

        try:
            place = float(scipy.optimize.brentq(too_thick, root, root + REACH))
        except ValueError:
            raise InputError(f"thickness_mm = {self.thickness_mm:g}: root and tread do not fit beside it") from None
        return on_tape_circle(place)


class RailHeadFile(ProfileFile, kind="rail-head"):
    """Tangent arcs from the crown outward and straight sides."""

    radii_mm: List[Annotated[float, number(1e-3, 1e4)]]
    """Radii of the arcs from the crown outward."""
    half_widths_mm: List[Annotated[float, number(1e-3, 1e3)]]
    """Where each arc but the last ends, from the middle of the rail."""
    side_slope: Annotated[float, number(0.0, 1.0, "1:20 is 0.05")]
    """Slope of the sides from the vertical."""
    depth_mm: Length
    """How far the sides reach below the top."""

    def consistency(self) -> Iterator[Fault]:
        if not self.radii_mm:
            yield Fault("radii_mm", "must hold at least one radius, from the crown outward")
        elif len(self.half_widths_mm) != (count := len(self.radii_mm) - 1):
            yield Fault("half_widths_mm", f"must hold {count} numbers, where each arc of radii_mm but the last ends")
        if self.body != "rail":
            yield Fault("body", 'must be "rail" for this kind')

    def build(self, path: Path) -> Profile:
        radii, widths = [r * MM for r in self.radii_mm], [b * MM for b in self.half_widths_mm]
        return shapes.rail_head(self.name, radii, widths, self.side_slope, self.depth_mm * MM, self.source)


class ConeFile(ProfileFile, kind="cone"):
    """A straight line through the tape circle."""

    conicity: Annotated[float, number(-1.0, 1.0, "1:20 is 0.05")]
    """Slope of the line; positive: the radius grows towards the flange."""
    from_mm: Coordinate
    """Where the line begins, outward from the tape circle."""
    to_mm: Coordinate
    """Where it ends."""

    def consistency(self) -> Iterator[Fault]:
        if self.to_mm <= self.from_mm:
            yield Fault("to_mm", f"must be above from_mm = {self.from_mm:g}")

    def build(self, path: Path) -> Profile:
        return shapes.cone(self.name, self.body, self.conicity, self.from_mm * MM, self.to_mm * MM, self.source)


class CircleFile(ProfileFile, kind="circle"):
    """One arc, horizontal at the origin."""

    radius_mm: Annotated[float, number(-1e5, 1e5, "positive: convex upward, negative: hollow")]
    """Radius of the arc."""
    half_width_mm: Length
    """How far the arc reaches on either side of the origin."""

    def consistency(self) -> Iterator[Fault]:
        if not self.half_width_mm < abs(self.radius_mm):
            yield Fault("half_width_mm", f"must be a number below the radius, {abs(self.radius_mm):g}")

    def build(self, path: Path) -> Profile:
        return shapes.circle(self.name, self.body, self.radius_mm * MM, self.half_width_mm * MM, self.source)


class PointsKeys(Section):
    """How a file of points is read."""

    measured: bool | None = None
    """Whether points are measured, so smoothed, or exact, so interpolated; left out: MiniProf is measured."""
    cutoff_mm: Annotated[float, positive(100.0)] | None = None
    """Length of the waves that smoothing halves; left out: 5 mm."""
    unit: Literal[*METRES] | None = None  # type: ignore[valid-type]
    """Unit of the coordinates; left out: what the file names, or mm."""
    heights: Literal[*HEIGHTS] | None = None  # type: ignore[valid-type]
    """Which way the file's heights grow; left out: what the file names, or its shape."""
    field_side: Literal[*SIDES] | None = None  # type: ignore[valid-type]
    """Sign of the file's lateral coordinates on the field side; left out: by the flange; of rails by format, groove,
    inclination or wear."""
    origin: Literal[*ORIGINS] | None = None  # type: ignore[valid-type]
    """Where the lateral coordinate of a wheel is zero; left out: where its flange shows it."""
    back_to_tape_circle_mm: BackToTapeCircle | None = None
    """Distance of the tape circle from the flange back; left out: what the file or the wheelset names, or 70 mm."""

    def options(self) -> dict[str, object]:
        """Options of `read_points`."""
        lengths = {"cutoff": self.cutoff_mm, "back": self.back_to_tape_circle_mm}
        alike = {key: getattr(self, key) for key in ("unit", "heights", "field_side", "origin", "measured")}
        return alike | {key: None if mm is None else mm * MM for key, mm in lengths.items()}


ShapeFile = SectionsFile | ChainFile | FlangedFile | RailHeadFile | ConeFile | CircleFile
