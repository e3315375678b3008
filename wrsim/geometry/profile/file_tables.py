"""The tables inside profile files (`wrsim.geometry.profile.file_kinds`), and the table of depths beside a worn one."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from wrsim.errors import InputError
from wrsim.geometry.profile.sections import Line, Polynomial, arc_between
from wrsim.geometry.profile.sections import Section as Piece
from wrsim.geometry.profile.wear import DepthTable, Direction, Removal
from wrsim.inputs.csv_tables import check_rising, read_columns
from wrsim.inputs.section import Choice, Fault, Section
from wrsim.inputs.values import List, Two, number

MM = 1e-3

Length = Annotated[float, number(1e-3, 1e4)]
Coordinate = Annotated[float, number(-1000.0, 1000.0)]


Pair = Annotated[Two[Annotated[float, number(-1e5, 1e5)]], Field(description="two numbers: [u, height]")]


class SectionTable(Choice):
    """A section of a profile; `piece` gives it in metres, up positive."""

    tag: ClassVar[str] = "shape"
    header: ClassVar[str] = "[[sections]]"

    shape: str
    """Shape of the section."""

    def piece(self, down: bool) -> Piece:
        """The section in metres, up positive; down: its heights grow downward."""
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
        low, high = sorted((self.from_mm, self.to_mm))
        return low * MM, high * MM

    def consistency(self) -> Iterator[Fault]:
        """A section has an extent."""
        if self.from_mm == self.to_mm:
            yield Fault("to_mm", "must differ from from_mm")


class PolynomialSection(SpanTable, kind="polynomial"):
    """height = c0 + c1 u + c2 u^2 + ..., in mm."""

    coefficients_mm: List[Annotated[float, number()]]
    """c0, c1, c2, ... of height = c0 + c1 u + c2 u^2 + ..., all in mm."""

    def piece(self, down: bool) -> Piece:
        sign = -1.0 if down else 1.0
        c = tuple(sign * c * 1000.0 ** (k - 1) for k, c in enumerate(self.coefficients_mm))
        return Polynomial(c, *self.span)

    def consistency(self) -> Iterator[Fault]:
        """A section has an extent and at least one coefficient."""
        yield from super().consistency()
        if not self.coefficients_mm:
            yield Fault("coefficients_mm", "must hold at least one number")


class ArcSection(SpanTable, kind="arc"):
    """Part of a circle, above or below its centre."""

    centre_mm: Pair
    """Centre of the circle; its height grows as `heights` of the file says."""
    radius_mm: Length
    """Radius of the circle."""
    half: Literal["upper", "lower"]
    """Which half of the circle as it stands in space, up being up whatever `heights` says."""

    def piece(self, down: bool) -> Piece:
        u, w = self.centre_mm
        return arc_between(u * MM, (-w if down else w) * MM, self.radius_mm * MM, self.half == "upper", *self.span)

    def consistency(self) -> Iterator[Fault]:
        """The arc reaches as far as the section."""
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

    def piece(self, down: bool) -> Piece:
        sign = -MM if down else MM
        (u0, w0), (u1, w1) = sorted((self.start_mm, self.end_mm))
        return Line(u0 * MM, sign * w0, u1 * MM, sign * w1)

    def consistency(self) -> Iterator[Fault]:
        """Two points are two points."""
        if self.start_mm == self.end_mm:
            yield Fault("end_mm", "must differ from start_mm")


class PieceTable(Choice):
    """A piece of a chain."""

    tag: ClassVar[str] = "shape"
    header: ClassVar[str] = "[[pieces]]"

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
    """Angle of the tangent at its end, positive where the curve rises outward; it tells which way the arc bends."""


class BellOfWear(Section):
    """A bell of wear: depth cos^2 over a stretch of the profile."""

    header: ClassVar[str] = "[[removals]]"

    direction: Direction
    """Which way the depth is measured, and with it what the bell is laid along: u, or the arclength."""
    depth_mm: Annotated[float, number(-20.0, 20.0, "negative: material that flowed there")]
    """Depth in the middle of the bell."""
    middle_mm: Coordinate
    """Middle of the bell: u for vertical, arclength from the origin for normal."""
    half_width_mm: Annotated[float, number(0.5, 500.0)]
    """From the middle of the bell to where it ends."""

    def removal(self) -> Removal:
        """The same in metres."""
        return Removal(self.direction, self.depth_mm * MM, self.middle_mm * MM, self.half_width_mm * MM)


PLACE, DEPTH = "place_mm", "depth_mm"
"""Columns of a table of depths."""


def read_depths(path: Path) -> DepthTable:
    """A table of depths: arclength from the origin and depth along the normal, in mm. Raises InputError."""
    columns = {PLACE: Coordinate, DEPTH: Annotated[float, number(-20.0, 20.0)]}
    table, lines = read_columns(path, columns, (PLACE, DEPTH), "places")
    places = table[PLACE]
    if places.size < 4:
        raise InputError(f"{path}: needs at least 4 places")
    check_rising(path, PLACE, places, lines)
    return DepthTable(MM * places, MM * table[DEPTH])


def write_depths(table: DepthTable) -> str:
    """The text of a table of depths: read back it is the same to the bit, but for the millimetres."""
    rows = (
        f"{1e3 * place!r},{1e3 * depth!r}"
        for place, depth in zip(table.places.tolist(), table.depths.tolist(), strict=True)
    )
    return "\n".join((f"{PLACE},{DEPTH}", *rows)) + "\n"
