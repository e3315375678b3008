"""Tables [[wheelset.out_of_round]] of vehicle files and [[vehicle.out_of_round]] of scenarios, and the files they name:
measured radii over the angle, sections of a wheel at angles."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from wrsim.contact.profiles.models import load_profile
from wrsim.contact.profiles.profile import Profile
from wrsim.contact.surfaces.out_of_round import Flat, Harmonic, Part, RadiusTable, shape_tables
from wrsim.contact.surfaces.slices import read_slices
from wrsim.errors import InputError
from wrsim.inputs.csv_tables import check_rising, read_columns
from wrsim.inputs.lines import KeyPath
from wrsim.inputs.section import Choice, Fault
from wrsim.inputs.values import List, number, positive, text
from wrsim.vehicle.wheelset import Wheel

Find = Callable[[str], Path]
"""The file of a name. Raises InputError."""

_Angle = Annotated[float, number(-360, 720, "degrees")]
_Across = Annotated[float, number(-200, 200, "mm across the profile, positive towards the field side")]
COLUMNS = {
    "angle_deg": _Angle, "theta_rad": Annotated[float, number(-2 * np.pi, 4 * np.pi)], "across_mm": _Across,
    "y_mm": _Across, "deviation_mm": Annotated[float, number(-50, 50, "mm, positive where the radius is larger")],
    "deviation_um": Annotated[float, number(-5e4, 5e4)],
    "depth_mm": Annotated[float, number(-50, 50, "mm below the nominal radius")],
}  # fmt: skip
"""Columns of a table of the radius: one of the angles, perhaps one of the places, one of the deviations."""
SI = {"angle_deg": np.pi / 180.0, "across_mm": 1e-3, "y_mm": 1e-3, "deviation_mm": 1e-3, "deviation_um": 1e-6,
      "depth_mm": -1e-3, "theta_rad": 1.0}  # fmt: skip
SECTION_DISTANCE = 1e-3  # of the places at which sections are compared [m]


class OutOfRoundTable(Choice, header="[[out_of_round]]"):
    """How a wheel is out of round: tables of one wheel sum up."""

    kind: str
    """Form of the deviation."""
    wheel: Literal["left", "right", "both"] = "both"
    """Which of the wheels is out of round."""
    on: List[Annotated[str, text("the name of a wheelset")]] = ()
    """Wheelsets that are out of round, in a scenario; all of them where it is not given."""

    def part(self, profile: Profile, radius: float, find: Find) -> Part:
        """What it adds to a wheel of this profile and radius [m]. Raises InputError."""
        raise NotImplementedError


class HarmonicTable(OutOfRoundTable, kind="harmonic"):
    """A polygon: a wave of whole number around the wheel."""

    order: Annotated[int, number(1, 200, "waves around the wheel")]
    """Number of waves around the wheel; 1 is an eccentric wheel."""
    amplitude_mm: Annotated[float, number(0, 20, "mm, half of the largest difference of radii")]
    """Amplitude of the radius."""
    phase_deg: Annotated[float, number(-360, 360, "degrees of the wave")] = 0.0
    """Phase of the wave: the radius deviates by amplitude cos(order angle - phase)."""

    def part(self, profile: Profile, radius: float, find: Find) -> Harmonic:
        return Harmonic(self.order, self.amplitude_mm / 1e3, np.radians(self.phase_deg))


class FlatTable(OutOfRoundTable, kind="flat"):
    """A flat: fresh, a chord whose edges are short, or rounded, a wave of the cosine."""

    goes_with: ClassVar[dict[str, str]] = {"across_mm": "width_mm"}

    shape: Literal["fresh", "rounded"] = "fresh"
    """Fresh: a chord; rounded: depth/2 (1 + cos(2 pi x / length))."""
    length_mm: Annotated[float, positive(300, "mm along the circumference")] | None = None
    """Length along the circumference; of a fresh flat it gives the depth, length^2/(8 R)."""
    depth_mm: Annotated[float, positive(20, "mm at its middle")] | None = None
    """Depth at its middle; of a rounded flat beside the length, else as deep as is nowhere hollow, length^2/(2 pi^2 R).
    """
    at_deg: Annotated[float, number(-360, 360, "degrees")] = 0.0
    """Angle by which the wheel has rolled when the middle of the flat is lowest."""
    edge_mm: Annotated[float, positive(100, "mm")] = 2.0
    """Length over which each edge of a fresh flat is rounded."""
    width_mm: Annotated[float, positive(300, "mm")] | None = None
    """Width across the profile of a flat that a crown has cut; all across unless given."""
    across_mm: _Across = 0.0
    """Middle of the width, from the tape circle."""

    def consistency(self) -> Iterator[Fault]:
        if self.length_mm is None and self.depth_mm is None:
            yield Fault("length_mm", "must be a number above 0 and at most 300 (or give depth_mm)", missing=True)
        if self.shape == "fresh" and self.length_mm is not None:
            if self.depth_mm is not None:
                yield Fault("depth_mm", "cannot be given with length_mm: of a fresh flat one gives the other")
            elif self.edge_mm > 0.5 * self.length_mm:
                yield Fault("edge_mm", f"must be at most half of length_mm = {self.length_mm:g}")

    def part(self, profile: Profile, radius: float, find: Find) -> Flat:
        length, depth, width = (None if v is None else v / 1e3 for v in (self.length_mm, self.depth_mm, self.width_mm))
        place = {"angle": np.radians(self.at_deg), "width": width or 0.0, "centre": self.across_mm / 1e3}
        if self.shape == "fresh":
            return Flat.fresh(radius, length, depth, self.edge_mm / 1e3, **place)
        return Flat.rounded(radius, length, depth, **place)


class MeasuredTable(OutOfRoundTable):
    """Base of what is read from a file."""

    file: Annotated[str, text('a CSV file such as "wheel_3_left.csv"')]
    """CSV file, beside this one."""
    cutoff_mm: Annotated[float, number(0, 1000, "mm along the circumference")] = 10.0
    """Length of the waves that smoothing halves; a contact is some 10 mm long."""


class RadiusFileTable(MeasuredTable, kind="radius"):
    """Measured deviations of the radius over the angle, perhaps over the place across the profile as well."""

    def part(self, profile: Profile, radius: float, find: Find) -> RadiusTable:
        return read_radii(find(self.file), self.cutoff_mm / 1e3)


class SectionsTable(MeasuredTable, kind="sections"):
    """Sections of the wheel at angles: profile files, compared with the wheel's own profile."""

    def part(self, profile: Profile, radius: float, find: Find) -> RadiusTable:
        return read_wheel_sections(find(self.file), profile, self.cutoff_mm / 1e3)


AnyOutOfRoundTable = Annotated[HarmonicTable | FlatTable | RadiusFileTable | SectionsTable, Field(discriminator="kind")]


def parts_of(
    tables: Sequence[tuple[int, OutOfRoundTable]], side: str, wheel: Wheel, find: Find,
    fault: Callable[[KeyPath, str], InputError],
) -> tuple[Part, ...]:  # fmt: skip
    """What the tables, with their numbers, add to the wheel of a side. fault: the error of a key of theirs. Raises it,
    also where the wheel is too far from round."""
    parts: tuple[Part, ...] = wheel.out_of_round
    for i, table in tables:
        if table.wheel in (side, "both"):
            try:
                parts = (*parts, table.part(wheel.profile, wheel.radius, find))
                shape_tables(parts, wheel.profile, wheel.radius)
            except InputError as error:
                raise fault((i, "file") if isinstance(table, MeasuredTable) else (i,), str(error)) from None
    return parts


def read_radii(path: Path, shortest: float = 0.0) -> RadiusTable:
    """A table of the radius: columns angle_deg (or theta_rad), deviation_mm (deviation_um, depth_mm) and, of a surface,
    across_mm: of every angle the same places in rising order. Raises InputError with line, column and value."""
    table, lines = read_columns(path, COLUMNS, (), "angles")
    ways = ("angle_deg theta_rad", "deviation_mm deviation_um depth_mm", "across_mm y_mm")
    columns = []
    for way in ways:
        names = [name for name in way.split() if name in table]
        if len(names) > 1 or (not names and way != ways[2]):
            raise InputError(f"{path}: one of the columns {way.replace(' ', ', ')} is needed, not {len(names)}")
        columns.append((names[0], table[names[0]] * SI[names[0]]) if names else ("", np.zeros(lines.size)))
    (name, angle), (_, deviation), (place, across) = columns
    if not place:
        check_rising(path, name, table[name], lines)
        return _checked(path, angle, np.zeros(0), deviation[:, None], shortest)
    angles, first, counts = np.unique(angle, return_index=True, return_counts=True)
    begins, count = np.sort(first), counts[0]
    check_rising(path, name, table[name][begins], lines[begins])
    for i, n in zip(begins, counts, strict=True):
        if n != count or np.abs(across[i : i + n] - across[:n]).max() > 1e-9:
            message = f"{name} = {table[name][i]:g}: {place}: a surface has the same places at every angle"
            raise InputError(f"{path}:{lines[i]}: {message}")
    check_rising(path, place, table[place][:count], lines)
    return _checked(path, angles, across[:count], deviation.reshape(-1, count), shortest)


def read_wheel_sections(path: Path, profile: Profile, shortest: float = 0.0) -> RadiusTable:
    """Sections of a wheel: columns angle_deg and profile, the name of a profile file beside this one, or a list of
    profiles (.slcw). The deviation is how far a section lies below the profile of the wheel at each place. Raises
    InputError."""
    if path.suffix.lower() == ".slcw":
        slices = read_slices(path)
        degrees, lines, files = np.degrees(slices.places), np.array(slices.lines), slices.files
    else:
        table, lines = read_columns(path, {"angle_deg": _Angle, "profile": str}, ("angle_deg", "profile"), "sections")
        degrees, files = table["angle_deg"], tuple(path.parent / str(name) for name in table["profile"])
    check_rising(path, "angle_deg", degrees, lines)
    sections = []
    for name, line in zip(files, lines, strict=True):
        try:
            sections.append(load_profile(name, "wheel"))
        except InputError as error:
            raise InputError(f"{path}:{line}: profile = {name.name}: {error}") from None
    curves = [_heights(section) for section in (profile, *sections)]
    low, high = max(curve[0][0] for curve in curves), min(curve[0][-1] for curve in curves)
    across = np.linspace(low, high, max(int((high - low) / SECTION_DISTANCE), 4) + 1)
    reference, *rows = (np.interp(across, *curve) for curve in curves)
    angle = degrees * SI["angle_deg"]
    return _checked(path, angle, across, reference - np.array(rows), shortest)


def _heights(profile: Profile) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Places and heights of a profile where it goes outward."""
    u, w = profile.at(np.linspace(0.0, profile.length, 4001))
    rising = np.concatenate([[True], np.maximum.accumulate(u)[:-1] < u[1:]])
    return u[rising], w[rising]


def _checked(
    path: Path, angle: NDArray[np.float64], across: NDArray[np.float64], deviation: NDArray[np.float64], shortest: float
) -> RadiusTable:
    try:
        return RadiusTable(angle, across, deviation, shortest)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
