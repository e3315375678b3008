"""Profile files: one TOML file a profile (``models/wheels``, ``models/rails``), or a file of points.

The TOML file names the body (wheel or rail), its source and one of these kinds:

========== ==========================================================================================
sections   lines, polynomials and arcs by centre, as standards print them
chain      lines and arcs, each tangent to the one before: a start, lengths, radii and angles
rail-head  tangent arcs from the crown outward and straight sides, symmetric
cone       a straight line through the tape circle
circle     one arc, horizontal at the origin
worn       another profile with material taken off, by bells or a table, see `wrsim.geometry.profile.wear`
points     a file of points beside it, read by `wrsim.geometry.profile.files` (measured or exported)
========== ==========================================================================================
"""

from __future__ import annotations

from collections.abc import Iterator
from contextvars import ContextVar
from pathlib import Path
from typing import Annotated, ClassVar, Literal, get_args

import numpy as np
from pydantic import Field

from wrsim.errors import InputError
from wrsim.geometry.profile.file_tables import (
    MM,
    ArcSection,
    BellOfWear,
    ChainArc,
    ChainLine,
    Coordinate,
    Length,
    LineSection,
    Pair,
    PolynomialSection,
    read_depths,
)
from wrsim.geometry.profile.files import HEIGHTS, PROFILE_FILES, SIDES, Reading, read_points, read_profile, suffix_fault
from wrsim.geometry.profile.profile import Kind, Profile
from wrsim.geometry.profile.sections import Arc, Line, circle, cone, profile_from_sections, rail_head
from wrsim.geometry.profile.sections import Section as Piece
from wrsim.geometry.profile.wear import AnyRemoval, worn
from wrsim.inputs.checking import check, opened
from wrsim.inputs.lookup import Finder, model_file, shipped_models, user_folders
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import Day, List, Source, Switch, fields, number, positive, text

SHORTEST = 5e-3
"""Arclength that a profile needs [m]: tables of it stand at 0.1 mm, contacts are some millimetres wide."""


class ProfileFile(Section):
    """What every profile file says; `AnyProfileFile` lists the kinds."""

    header: ClassVar[str] = "a profile file"
    aliases: ClassVar[dict[str, str]] = {"kind": "type", "name": "title", "source": "reference"}

    name: Annotated[str, text("the profile's name")]
    """Name of the profile; it stands in pictures and messages."""
    body: Kind
    """Whose profile it is."""
    kind: str
    """How the shape is given; it decides which further keys the file takes."""
    date: Day
    """Day on which the file was written."""
    source: Source
    """Where the shape comes from."""

    def build(self, path: Path) -> Profile:
        """Make the profile; `path` is the file, for names relative to it."""
        raise NotImplementedError


# --- kind = "sections" --------------------------------------------------------------------------------


Shape = Annotated[PolynomialSection | ArcSection | LineSection, Field(discriminator="shape")]


class SectionsFile(ProfileFile):
    """Lines, polynomials and arcs by centre."""

    header: ClassVar[str] = 'a profile file with kind = "sections"'

    kind: Literal["sections"]
    """Lines, polynomials and arcs by centre."""
    heights: Literal[*HEIGHTS] = "up"  # type: ignore[valid-type]
    """Which way the file's heights grow."""
    sections: List[Shape]
    """The pieces, end to end, from either side."""

    def build(self, path: Path) -> Profile:
        """See `ProfileFile`. Sections may be listed from either end."""
        pieces = [s.piece(self.heights == "down") for s in self.sections]
        if not pieces:
            raise InputError("sections is empty; at least one [[sections]] table is needed")
        pieces.sort(key=lambda s: float(s.evaluate(np.array([s.start]))[0][0, 0]))
        return profile_from_sections(self.name, self.body, pieces, self.source)


# --- kind = "chain" -----------------------------------------------------------------------------------


class ChainFile(ProfileFile):
    """Tangent lines and arcs; heights are shifted so that the curve passes through the origin."""

    header: ClassVar[str] = 'a profile file with kind = "chain"'

    kind: Literal["chain"]
    """Tangent lines and arcs."""
    start_mm: Coordinate
    """Where the chain begins, outward from the origin."""
    start_angle_deg: Annotated[float, number(-180.0, 180.0)]
    """Angle of the tangent there, positive where the curve rises outward."""
    pieces: List[Annotated[ChainLine | ChainArc, Field(discriminator="shape")]]
    """Lines and arcs, each tangent to the one before, outward."""

    def build(self, path: Path) -> Profile:
        """See `ProfileFile`."""
        if not self.pieces:
            raise InputError("pieces is empty; at least one [[pieces]] table is needed")
        place, angle = np.array([self.start_mm * MM, 0.0]), np.radians(self.start_angle_deg)
        chain: list[Piece] = []
        for i, piece in enumerate(self.pieces):
            if isinstance(piece, ChainLine):
                end = place + piece.length_mm * MM * np.array([np.cos(angle), np.sin(angle)])
                chain.append(Line(place[0], place[1], end[0], end[1]))
            else:
                last = np.radians(piece.to_angle_deg)
                if abs(last - angle) < 1e-9:
                    raise InputError(
                        f"pieces[{i}].to_angle_deg = {piece.to_angle_deg:g}: the curve has this angle "
                        "already; must differ, or the piece be a line"
                    )
                radius = piece.radius_mm * MM
                side = np.sign(last - angle) * radius * np.array([-np.sin(angle), np.cos(angle)])
                chain.append(Arc(place[0] + side[0], place[1] + side[1], radius, angle, last))
                end, angle = chain[-1].evaluate(np.array([chain[-1].end]))[0][0], last
            place = end
        profile = profile_from_sections(self.name, self.body, chain, self.source)
        return profile.shifted(dw=-float(profile.at(profile.arclength_of(0.0))[1]))


# --- the simple kinds ---------------------------------------------------------------------------------


class RailHeadFile(ProfileFile):
    """Tangent arcs from the crown outward and straight sides."""

    header: ClassVar[str] = 'a profile file with kind = "rail-head"'

    kind: Literal["rail-head"]
    """A symmetric rail head."""
    radii_mm: List[Annotated[float, positive(1e4)]]
    """Radii of the arcs from the crown outward."""
    half_widths_mm: List[Annotated[float, positive(1e3)]]
    """Where each arc but the last ends, from the middle of the rail."""
    side_slope: Annotated[float, number(0.0, 1.0, "1:20 is 0.05")]
    """Slope of the sides from the vertical."""
    depth_mm: Length
    """How far the sides reach below the top."""

    def consistency(self) -> Iterator[Fault]:
        """One half width for every radius but the last."""
        if not self.radii_mm:
            yield Fault("radii_mm", "must hold at least one radius, from the crown outward")
        elif len(self.half_widths_mm) != len(self.radii_mm) - 1:
            yield Fault(
                "half_widths_mm",
                f"must hold {len(self.radii_mm) - 1} numbers, where each arc of radii_mm but the last ends",
            )
        if self.body != "rail":
            yield Fault("body", 'must be "rail" for this kind')

    def build(self, path: Path) -> Profile:
        """See `ProfileFile`."""
        radii = [r * MM for r in self.radii_mm]
        widths = [b * MM for b in self.half_widths_mm]
        return rail_head(self.name, radii, widths, self.side_slope, self.depth_mm * MM, self.source)


class ConeFile(ProfileFile):
    """A straight line through the tape circle."""

    header: ClassVar[str] = 'a profile file with kind = "cone"'

    kind: Literal["cone"]
    """A straight line."""
    conicity: Annotated[float, number(-1.0, 1.0, "1:20 is 0.05")]
    """Slope of the line; positive: the radius grows towards the flange."""
    from_mm: Coordinate
    """Where the line begins, outward from the tape circle."""
    to_mm: Coordinate
    """Where it ends."""

    def consistency(self) -> Iterator[Fault]:
        """From left to right."""
        if self.to_mm <= self.from_mm:
            yield Fault("to_mm", f"must be above from_mm = {self.from_mm:g}")

    def build(self, path: Path) -> Profile:
        """See `ProfileFile`."""
        return cone(self.name, self.body, self.conicity, self.from_mm * MM, self.to_mm * MM, self.source)


class CircleFile(ProfileFile):
    """One arc, horizontal at the origin."""

    header: ClassVar[str] = 'a profile file with kind = "circle"'

    kind: Literal["circle"]
    """One arc."""
    radius_mm: Annotated[float, number(-1e5, 1e5, "positive: convex upward, negative: hollow")]
    """Radius of the arc."""
    half_width_mm: Length
    """How far the arc reaches on either side of the origin."""

    def consistency(self) -> Iterator[Fault]:
        """Less than half a circle."""
        if not self.half_width_mm < abs(self.radius_mm):
            yield Fault("half_width_mm", f"must be a number below the radius, {abs(self.radius_mm):g}")

    def build(self, path: Path) -> Profile:
        """See `ProfileFile`."""
        return circle(self.name, self.body, self.radius_mm * MM, self.half_width_mm * MM, self.source)


# --- kind = "worn" ------------------------------------------------------------------------------------


class WornFile(ProfileFile):
    """Another profile with bells of material taken off, or depths from a table."""

    header: ClassVar[str] = 'a profile file with kind = "worn"'
    aliases: ClassVar[dict[str, str]] = ProfileFile.aliases | {"removals": "removal wear", "depths": "depth_table"}

    kind: Literal["worn"]
    """Another profile with material taken off."""
    base: Annotated[str, text('the file of the unworn profile, such as "S1002.toml",')]
    """The unworn profile, looked up beside this file and then among the models."""
    removals: List[BellOfWear] = ()
    """Bells of wear that are taken off."""
    depths: Annotated[str, text("a CSV file of depths, relative to this file,")] | None = None
    """Table of `place_mm` (arclength from the origin) and `depth_mm` (along the normal), with bells or without."""

    def consistency(self) -> Iterator[Fault]:
        """Something is taken off."""
        if not self.removals and self.depths is None:
            yield Fault("removals", "must hold at least one [[removals]] table (or give depths)", missing=True)

    def build(self, path: Path) -> Profile:
        """See `ProfileFile`. The base is looked up beside the file, then among the models."""
        folders = (path.parent, *user_folders(), shipped_models(), shipped_models() / f"{self.body}s")
        try:
            base = Finder(folders).find(self.base)
        except InputError as error:
            raise InputError(f'base = "{self.base}": {error}') from None
        chain = (*_building.get(), path.resolve())
        if base.resolve() in chain:
            raise InputError(f'base = "{self.base}": the profile would start from itself')
        token = _building.set(chain)
        try:
            new = load_profile(base, self.body)
        finally:
            _building.reset(token)
        removals: list[AnyRemoval] = [bell.removal() for bell in self.removals]
        if self.depths is not None:
            removals.append(read_depths(path.parent / self.depths))
        return worn(new, removals, self.name, self.source)


_building: ContextVar[tuple[Path, ...]] = ContextVar("profile files that are being built", default=())


# --- kind = "points" ----------------------------------------------------------------------------------


class PointsFile(ProfileFile):
    """A file of points beside it."""

    header: ClassVar[str] = 'a profile file with kind = "points"'

    kind: Literal["points"]
    """A file of points."""
    file: Annotated[str, text("the name of a file of points, relative to this file,")]
    """The points: two columns, SIMPACK or MiniProf."""
    format: Literal[*PROFILE_FILES] | None = None  # type: ignore[valid-type]
    """How the file is to be read; left out, its suffix tells."""
    measured: Switch | None = None
    """Whether points are measured, so smoothed, or exact, so interpolated; left out: MiniProf is measured."""
    cutoff_mm: Annotated[float, positive(100.0)] | None = None
    """Length of the waves that smoothing halves; left out: 5 mm."""
    unit: Literal["mm", "m", "in"] | None = None
    """Unit of the coordinates; left out: what the file says, or mm."""
    heights: Literal[*HEIGHTS] | None = None  # type: ignore[valid-type]
    """Which way the file's heights grow; left out: what the file says, or its shape."""
    field_side: Literal[*SIDES] | None = None  # type: ignore[valid-type]
    """Sign of the file's lateral coordinates on the field side; left out: by the flange, of rails positive."""
    clip_mm: Pair | None = None
    """Only points between these two u are kept, after turning."""
    turn_mrad: Annotated[float, number(-3200.0, 3200.0)] = 0.0
    """Turn about the origin, positive: top towards the track centre."""
    shift_mm: Pair = (0.0, 0.0)
    """Moves the profile outward and up, last of all."""

    def consistency(self) -> Iterator[Fault]:
        """Suffix or format tell what stands where; a cut-off is for measurements; a clip goes from left to right."""
        if self.format is None and (fault := suffix_fault(Path(self.file))):
            yield Fault("file", f"{fault}, or name the format")
        if self.measured is False and self.cutoff_mm is not None:
            yield Fault("cutoff_mm", "is for measured profiles; must be left out with measured = false")
        if self.clip_mm is not None and not self.clip_mm[0] < self.clip_mm[1]:
            yield Fault("clip_mm", "must be two rising numbers: [from u, to u]")

    def build(self, path: Path) -> Profile:
        """See `ProfileFile`."""
        return self.reading(path).profile()

    def reading(self, path: Path) -> Reading:
        """The points, not yet a profile."""
        return read_points(
            path.parent / self.file,
            self.body,
            format=self.format,
            name=self.name,
            source=self.source,
            measured=self.measured,
            cutoff=None if self.cutoff_mm is None else self.cutoff_mm * MM,
            unit=self.unit,
            heights=self.heights,
            field_side=self.field_side,
            clip=None if self.clip_mm is None else (self.clip_mm[0] * MM, self.clip_mm[1] * MM),
            turn=1e-3 * self.turn_mrad,
            shift=(self.shift_mm[0] * MM, self.shift_mm[1] * MM),
        )


AnyProfileFile = Annotated[
    SectionsFile | ChainFile | RailHeadFile | ConeFile | CircleFile | WornFile | PointsFile, Field(discriminator="kind")
]
FILE_KINDS: dict[str, type[ProfileFile]] = {
    get_args(fields(kind)["kind"])[0]: kind for kind in get_args(get_args(AnyProfileFile)[0])
}
"""What stands in files of each kind."""


class _AnyFile(Section):
    """Only what decides which kind of file it is."""

    header: ClassVar[str] = "a profile file"
    kind: Literal[*FILE_KINDS]  # type: ignore[valid-type]


def load_profile(path: str | Path, kind: Kind | None = None) -> Profile:
    """Read a wheel or rail profile.

    Parameters
    ----------
    path : str or Path
        A TOML file of one of the kinds of docs/profiles.md, or a file of points
        (``.prw .prr .whl .ban .csv .txt .dat``); a name that is not found as it stands is looked up among the models:
        ``"rails/60E1.toml"``.
    kind : {"wheel", "rail"}, optional
        A TOML file says it itself, most files of points by their suffix (any other answer is then an error); two
        columns need it unless wrsim wrote them.

    Returns
    -------
    Profile
        A rail stands upright: ``inclined(1 / 40)`` inclines it.

    Raises
    ------
    InputError
        With all faults of a TOML file at once: file, line, key, value, what is allowed.
    """
    path = model_file(path)
    if path.suffix.lower() != ".toml":
        return read_profile(path, kind)
    model = _read_toml(path, kind)
    try:
        profile = model.build(path)
        if profile.length < SHORTEST:
            raise InputError(
                f"the profile is {1e3 * profile.length:g} mm long; at least {1e3 * SHORTEST:g} mm are needed"
            )
        return profile
    except InputError as error:
        if isinstance(model, PointsFile):
            raise  # names the file of points
        raise InputError(f"{path}: {error}") from None


def load_points(path: str | Path, kind: Kind | None = None) -> Reading | None:
    """Read the points that a profile is made from; None for a shape that is given by formula.

    Parameters and errors as for `load_profile`.
    """
    path = model_file(path)
    if path.suffix.lower() != ".toml":
        return read_points(path, kind)
    model = _read_toml(path, kind)
    return model.reading(path) if isinstance(model, PointsFile) else None


def _read_toml(path: Path, kind: Kind | None) -> ProfileFile:
    """The checked content of a TOML profile file."""
    data, locate = opened(path, "profile file")
    file_kind = check(_AnyFile, {k: v for k, v in data.items() if k == "kind"}, locate).kind
    model = check(FILE_KINDS[file_kind], data, locate)
    if kind is not None and model.body != kind:
        raise InputError(f'{locate(("body",))}: body = "{model.body}": a {kind} profile is needed here')
    return model
