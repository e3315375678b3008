"""A fixed crossing from a few numbers: sections of nose and wing rail along the running rail that a wheel passes over.

The wing is the head of the plain rail. From the throat on it moves away from the gauge line by the crossing's angle, so
that the flangeway stays as wide as it is. The nose is planed from the same head: its flanks stay where they are, what
lies between its corners makes room for a crown of one radius, tangent to both sides, and its corners are the sharper
the narrower it is. Its top rises with its width until it is the plain rail. Shapes are arcs and lines that are tangent
to each other.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from wrsim.contact.profiles.file_kinds import MM, RailHeadFile
from wrsim.contact.profiles.models import read_profile_file
from wrsim.contact.profiles.profile import Array
from wrsim.contact.profiles.sections import Chain, head_arcs, profile_from_sections
from wrsim.contact.surfaces.rail_surface import DEEP, RailSection
from wrsim.errors import InputError
from wrsim.inputs.checking import check_section, opened
from wrsim.inputs.lookup import Finder, shipped_models, user_folders
from wrsim.inputs.section import Fault, Section
from wrsim.inputs.values import Day, Source, number, text

FLOOR = DEEP + 8e-3  # of the flangeway, below the top of the plain rail [m]
FOOT = 6e-3  # radius of the floor's corners [m]
PER_WIDTH, PER_WING = 2e-3, 3e-3  # growth of the nose's width between sections: while it is planed, and behind [m]
BEHIND = 0.1  # of the throat and of the crossing's end: where the rail is plain [m]
CLOSE = 1e-3  # distance of sections that are one [m]
SAME = 1e-12  # [m]
EASE = 0.2  # of the ramp of the nose's top: where it is not straight


class CrossingFile(Section, header="a crossing file"):
    """A fixed crossing of a straight track, as wheels of that track pass it."""

    name: Annotated[str, text("the crossing's name")]
    """Name of the crossing, for messages."""
    date: Day
    """Day on which the file was written."""
    source: Source
    """Where the numbers come from."""
    rail: Annotated[str, text('a rail profile of the kind "rail-head" such as "rails/60E1.toml"')]
    """Plain rail that wing and nose are made of."""
    one_in: Annotated[float, number(4, 40, "length over width of the nose")]
    """The crossing's angle: 9 for 1:9."""
    flangeway_mm: Annotated[float, number(30, 80)] = 44.0
    """Width of the gap between nose and wing."""
    nose_begins_mm: Annotated[float, number(5, 40, "mm of its width")] = 14.0
    """Width of the nose where it begins."""
    nose_corner_mm: Annotated[float, number(2, 20)] = 6.0
    """Radius of its corners there; it grows to that of the rail."""
    nose_lowered_mm: Annotated[float, number(0, 20)] = 3.5
    """How far its top lies lower there."""
    nose_full_mm: Annotated[float, number(10, 70, "mm of its width")] = 50.0
    """Width from which on its corners and its height are those of the rail."""
    crown_radius_mm: Annotated[float, number(13, 300)] = 40.0
    """Largest radius of the planed nose between its corners."""
    wing_raised_mm: Annotated[float, number(0, 10)] = 2.0
    """How far the wing is raised from where the nose begins; it rises from the throat on."""
    wing_ends_m: Annotated[float, number(0.2, 5, "m behind the point where the faces of the nose meet")] = 1.0
    """Where the wing ends."""
    flare_mm: Annotated[float, number(0, 60)] = 20.0
    """How far the wing is bent away at its end."""
    flare_length_m: Annotated[float, number(0.05, 2)] = 0.3
    """Length of this flare."""

    def consistency(self) -> Iterator[Fault]:
        if 2.0 * self.nose_corner_mm > self.nose_begins_mm:
            yield Fault("nose_corner_mm", f"must be at most {0.5 * self.nose_begins_mm:g}, half of nose_begins_mm")
        if self.nose_full_mm <= self.nose_begins_mm:
            yield Fault("nose_full_mm", f"must be above nose_begins_mm = {self.nose_begins_mm:g}")
        whole = MM * self.one_in * self.nose_full_mm
        if self.wing_ends_m < whole + self.flare_length_m:
            least = f"where the nose has its full height ({whole:.3g} m) and the flare's length behind"
            yield Fault("wing_ends_m", f"must reach to {whole + self.flare_length_m:.3g} m: {least}")


@dataclass(frozen=True)
class Head:
    """Half of a rail's head from the crown to its side. radii (n,) [m] and angles (n + 1,) of its arcs, from 0 to that
    of the side; reach (n + 1,): distance of their ends from the middle; low: their depths below the crown."""

    radii: Array
    angles: Array
    reach: Array
    low: Array
    depth: float

    @classmethod
    def of(cls, file: RailHeadFile) -> Head:
        """The head that a file describes."""
        radii_m, widths = [MM * r for r in file.radii_mm], [MM * b for b in file.half_widths_mm]
        arcs = head_arcs(file.name, radii_m, widths, file.side_slope)
        radii, angles = np.array([arc.radius for arc in arcs]), np.array([0.0, *(-arc.last for arc in arcs)])
        reach = np.array([0.0, *(arc.u + arc.radius * np.sin(-arc.last) for arc in arcs)])
        low = np.array([0.0, *(-arc.w - arc.radius * np.cos(arc.last) for arc in arcs)])
        return cls(radii, angles, reach, low, MM * file.depth_mm)

    def planed(self, half: float, crown: float, corner: float) -> tuple[Array, Array]:
        """Radii (m,) and angles (m + 1,) of a head whose sides lie at this distance [m] from its middle, from the crown
        on. crown: radius between the corners, at most [m]; corner: radius of these [m]."""
        radii, reach, side = np.append(self.radii[:-1], corner), self.reach.copy(), self.angles[-1]
        reach[-1] = reach[-2] + corner * (np.sin(side) - np.sin(self.angles[-2]))
        missing, crown = reach[-1] - half, min(crown, float(radii[:-1].min()))
        if missing <= 0.0:
            return radii, self.angles
        # the middle moves in by what a flatter head reaches more than the crown's arc, which grows with the angle
        gained = reach - crown * np.sin(self.angles)
        i = int(np.searchsorted(gained[:-1], missing))
        if i >= gained.size - 1:
            angle = self.angles[-2]
            return np.array([(reach[-2] - missing) / np.sin(angle), corner]), np.array([0.0, angle, side])
        before = self.angles[i - 1]
        angle = float(np.arcsin(np.sin(before) + (missing - gained[i - 1]) / (radii[i - 1] - crown)))
        return np.append(crown, radii[i - 1 :]), np.array([0.0, angle, *self.angles[i:]])

    def nose(self, width: float, top: float, crown: float, corner: float) -> tuple[float, float, Array, Array]:
        """A planed head with its flanks in the planes of this one's, so far apart [m] where the flanks of this one
        begin. top: its height [m]. Returns place and height of its corner's end on the first flank [m], radii and
        angles."""
        slope, rise = 1.0 / np.tan(self.angles[-1]), 0.0
        width = min(width, 2.0 * self.reach[-1])
        while True:  # a flank that goes on farther up leaves less between them: a twentieth of it
            radii, angles = self.planed(0.5 * width - slope * rise, crown, corner)
            last, rise = rise, top + self.low[-1] + float(radii @ np.diff(np.cos(angles)))
            if abs(rise - last) < SAME:
                return -self.reach[-1] + slope * rise, rise - self.low[-1], radii, angles


def _add_head(out: Chain, radii: Array, angles: Array) -> list[float]:
    """A head from one side over its crown to the other; arclengths of both corners' ends and the crown."""
    begin = out.length
    for radius, upper, lower in zip(radii[:0:-1], angles[-2:0:-1], angles[:1:-1], strict=True):
        out.arc(radius, lower, upper)
    out.arc(radii[0], angles[1], -angles[1])
    for radius, upper, lower in zip(radii[1:], angles[1:], angles[2:], strict=False):
        out.arc(radius, -upper, -lower)
    return [begin, 0.5 * (begin + out.length), out.length]


def read_crossing(path: Path, inclination: float = 0.0, trailing: bool = False) -> list[RailSection]:
    """Sections of the crossing that a file describes, at distances [m] from where the faces of its nose meet.

    inclination: of nose and wing, each about its own crown. trailing: passed from the nose onto the wing. Raises
    InputError.
    """
    file = check_section(CrossingFile, *opened(path, "crossing file"))
    folders = (path.parent, *user_folders(), shipped_models(), shipped_models() / "rails")
    try:
        rail = read_profile_file(Finder(folders).find(file.rail), "rail")
        if not isinstance(rail, RailHeadFile) or len(rail.radii_mm) < 2:
            raise InputError('must be of the kind "rail-head" with two or more radii')
        head = Head.of(rail)
    except InputError as error:
        raise InputError(f'{path}: rail = "{file.rail}": {error}') from None
    sections = [_section(file, head, s, inclination) for s in _places(file, head)]
    if not trailing:
        return sections
    return [RailSection(-section.distance, section.profile, section.features) for section in reversed(sections)]


def _places(file: CrossingFile, head: Head) -> Array:
    """Distances of the sections [m]."""
    begins, whole = MM * file.nose_begins_mm, MM * file.nose_full_mm
    throat, end = -file.one_in * MM * file.flangeway_mm, file.wing_ends_m
    last = max(2.0 * head.reach[-1] * file.one_in, end) + BEHIND
    widths = np.concatenate([
        np.arange(begins, whole, PER_WIDTH), np.arange(whole, 2.0 * head.reach[-1] + PER_WING, PER_WING),
    ])  # fmt: skip
    wing = np.linspace(end - file.flare_length_m, end, 4)
    before = np.linspace(throat, file.one_in * begins, 6)[:-1]
    s = np.sort(np.concatenate([[throat - BEHIND], before, file.one_in * widths, wing, [end + BEHIND / 10, last]]))
    return np.asarray(s[np.append(True, np.diff(s) > CLOSE)])


def _ramp(share: float) -> float:
    """From 0 to 1, straight but for a parabola at the beginning: a bend along the rail would strike a wheel."""
    return (share**2 / (2.0 * EASE) if share < EASE else share - 0.5 * EASE) / (1.0 - 0.5 * EASE)


def _section(file: CrossingFile, head: Head, s: float, inclination: float) -> RailSection:
    """The section at a distance. Features: ends of the corners and crown of the nose, middle of the flangeway's floor,
    the same three of the wing."""
    width, flangeway = s / file.one_in, MM * file.flangeway_mm
    begins, whole = MM * file.nose_begins_mm, MM * file.nose_full_mm
    nose, wing = width > begins - CLOSE, s < file.wing_ends_m + CLOSE
    into_flare = max(s - file.wing_ends_m + file.flare_length_m, 0.0) / file.flare_length_m
    away = max(width + flangeway, 0.0) + MM * file.flare_mm * into_flare**2
    raised = MM * file.wing_raised_mm * min(max((width + flangeway) / (begins + flangeway), 0.0), 1.0)
    level = raised - inclination * away  # nose and wing are inclined together, each should be about itself
    narrow = min(max((whole - width) / (whole - begins), 0.0), 1.0)
    corner = head.radii[-1] + narrow * (MM * file.nose_corner_mm - head.radii[-1])
    side, slope, edge = head.angles[-1], 1.0 / np.tan(head.angles[-1]), -head.reach[-1]
    under = head.depth - head.low[-1]  # of a flank
    on_nose: list[float] = []
    if nose:
        out = Chain(edge - slope * under, -head.depth)
        top = -MM * file.nose_lowered_mm * _ramp(narrow)
        *corners, radii, angles = head.nose(width, top, MM * file.crown_radius_mm, corner)
        out.line(*corners)
        on_nose = _add_head(out, radii, angles)
    else:
        out = Chain(away + edge - slope * under, level - head.depth)
    if nose and wing:
        foot = FOOT * (1.0 - np.cos(side)) - FLOOR
        out.line(out.u + slope * (out.w - foot), foot)
        out.arc(FOOT, -side, 0.0)
        end = away + edge - slope * (level - head.low[-1] - foot) - FOOT * np.sin(side)
        on_nose.append(out.length + 0.5 * (end - out.u))
        out.line(end, -FLOOR)
        out.arc(FOOT, 0.0, side)
    on_wing: list[float] = []
    if wing:
        out.line(away + edge, level - head.low[-1])
        on_wing = _add_head(out, head.radii, head.angles)
    last = level - head.depth if wing else -head.depth
    out.line(out.u + slope * (out.w - last), last)
    features = [*(on_nose or [0.0] * 3), *([] if on_nose[3:] else [out.length * nose]), *(on_wing or [out.length] * 3)]
    profile = profile_from_sections(f"{file.name}, {s:.3f} m", "rail", out.sections, file.source).inclined(inclination)
    return RailSection(s, profile, tuple(min(feature, profile.length) for feature in features))
