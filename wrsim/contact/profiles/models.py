"""Profile files: one TOML file a profile (``models/wheels``, ``models/rails``), or a file of points.

The TOML file names the body (wheel or rail), its source and the kind of its shape (`wrsim.contact.profiles.file_kinds`,
docs/user/profiles.md); the kinds that start from another profile or from points are here.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from wrsim.contact.profiles.file_kinds import MM, Coordinate, Pair, PointsKeys, ProfileFile, ShapeFile
from wrsim.contact.profiles.files import PROFILE_FILES, Reading, read_points, reading_as, stating_back, suffix_fault
from wrsim.contact.profiles.flange import with_back
from wrsim.contact.profiles.placing import check_tread
from wrsim.contact.profiles.profile import Kind, Profile
from wrsim.contact.profiles.wear import AnyRemoval, DepthTable, Direction, Removal, worn
from wrsim.errors import InputError, in_one_line
from wrsim.inputs.changes import changed, full_path, key_path
from wrsim.inputs.checking import Locate, check_section, opened, refuse_other_kind
from wrsim.inputs.csv_tables import check_rising, read_columns
from wrsim.inputs.lookup import Finder, model_file, shipped_models, user_folders
from wrsim.inputs.section import Fault, Section, kinds_in
from wrsim.inputs.values import List, number, text

SHORTEST = 5e-3  # arclength that a profile needs [m]: its tables have rows every 0.1 mm, contacts are some mm wide
MOST_BASES = 20  # longest row of worn profiles that start from each other


class BellOfWear(Section, header="[[removals]]"):
    """A bell of wear: depth cos^2 over a stretch of the profile."""

    direction: Direction
    """Which way the depth is measured, and with it what the bell is laid along: u, or the arclength."""
    depth_mm: Annotated[float, number(-20.0, 20.0, "negative: material that flowed there")]
    """Depth in the middle of the bell."""
    middle_mm: Coordinate
    """Middle of the bell: u for vertical, arclength from the origin for normal."""
    half_width_mm: Annotated[float, number(0.5, 500.0)]
    """From the middle of the bell to where it ends."""


PLACE, DEPTH = "place_mm", "depth_mm"  # columns of a table of depths


def read_depths(path: Path) -> DepthTable:
    """A table of depths: arclength from the origin and depth along the normal, in mm. Raises InputError."""
    columns = {PLACE: Coordinate, DEPTH: Annotated[float, number(-20.0, 20.0)]}
    table, lines = read_columns(path, columns, (PLACE, DEPTH), "places")
    if lines.size < 4:
        raise InputError(f"{path}: needs at least 4 places")
    check_rising(path, PLACE, table[PLACE], lines)
    return DepthTable(MM * table[PLACE], MM * table[DEPTH])


def write_depths(table: DepthTable) -> str:
    """The text of a table of depths, every number with all its digits."""
    pairs = zip((1e3 * table.places).tolist(), (1e3 * table.depths).tolist(), strict=True)
    return "\n".join((f"{PLACE},{DEPTH}", *(f"{place!r},{depth!r}" for place, depth in pairs))) + "\n"


class WornFile(ProfileFile, kind="worn"):
    """Another profile with bells of material taken off, or depths from a table."""

    base: Annotated[str, text('the file of the unworn profile, such as "S1002.toml",')]
    """The unworn profile, looked up beside this file and then among the models."""
    removals: List[BellOfWear] = ()
    """Bells of wear that are taken off."""
    depths: Annotated[str, text("a CSV file of depths, relative to this file,")] | None = None
    """Table of `place_mm` (arclength from the origin) and `depth_mm` (along the normal), with bells or without."""

    def consistency(self) -> Iterator[Fault]:
        if not self.removals and self.depths is None:
            yield Fault("removals", "must hold at least one [[removals]] table (or give depths)", missing=True)

    def build(self, path: Path) -> Profile:
        new = _named_by("base", self.base, path, self.body)
        removals: list[AnyRemoval] = [
            Removal(bell.direction, bell.depth_mm * MM, bell.middle_mm * MM, bell.half_width_mm * MM)
            for bell in self.removals
        ]
        if self.depths is not None:
            removals.append(read_depths(path.parent / self.depths))
        return replace(worn(new, removals, self.name, self.source), notes=new.notes, back=new.back)


def _named_by(key: str, name: str, path: Path, body: Kind) -> Profile:
    """The profile that a key of a profile file names, beside it or among the models. Raises InputError."""
    folders = (path.parent, *user_folders(), shipped_models(), shipped_models() / f"{body}s")
    try:
        file = Finder(folders).find(name)
    except InputError as error:
        raise InputError(f'{key} = "{name}": {error}') from None
    chain = (*_building.get(), path.resolve())
    if file.resolve() in chain:
        raise InputError(f'{key} = "{name}": the profile would start from itself')
    if len(chain) > MOST_BASES:
        raise InputError(f'{key} = "{name}": at most {MOST_BASES} profiles may follow each other by {key}')
    token = _building.set(chain)
    try:
        return load_profile(file, body)
    finally:
        _building.reset(token)


class PointsFile(PointsKeys, ProfileFile, kind="points"):
    """A file of points beside it."""

    file: Annotated[str, text("the name of a file of points, relative to this file,")]
    """The points: two columns, SIMPACK, MiniProf or VAMPIRE."""
    format: Literal[*PROFILE_FILES] | None = None  # type: ignore[valid-type]
    """How the file is to be read; left out, its suffix decides."""
    align: Annotated[str, text('the file of the unworn profile, such as "wheels/S1002.toml",')] | None = None
    """The unworn profile onto which the points are moved and turned by the parts that do not wear."""
    clip_mm: Pair | None = None
    """Only points between these two u are used, after turning."""
    turn_mrad: Annotated[float, number(-3200.0, 3200.0)] = 0.0
    """Turn about the origin, positive: top towards the track centre."""
    shift_mm: Pair = (0.0, 0.0)
    """Moves the profile outward and up, last of all."""
    flange_back_mm: Annotated[float, number(20.0, 150.0)] | None = None
    """Distance of the flange back from the tape circle, usually 70, for a wheel that is not measured so far: an arc
    leads there."""

    def consistency(self) -> Iterator[Fault]:
        if self.format is None and (fault := suffix_fault(Path(self.file))):
            yield Fault("file", f"{fault}, or name the format")
        if self.measured is False and self.cutoff_mm is not None:
            yield Fault("cutoff_mm", "is for measured profiles; must be left out with measured = false")
        if self.clip_mm is not None and not self.clip_mm[0] < self.clip_mm[1]:
            yield Fault("clip_mm", "must be two rising numbers: [from u, to u]")
        if self.body != "wheel" and self.flange_back_mm is not None:
            yield Fault("flange_back_mm", 'goes with body = "wheel"')

    def reading(self, path: Path) -> Reading:
        """The points and the profile through them."""
        reading = read_points(
            path.parent / self.file, self.body, format=self.format, name=self.name, source=self.source,
            align=None if self.align is None else _named_by("align", self.align, path, self.body),
            clip=None if self.clip_mm is None else (self.clip_mm[0] * MM, self.clip_mm[1] * MM),
            turn=1e-3 * self.turn_mrad, shift=(self.shift_mm[0] * MM, self.shift_mm[1] * MM), **self.options(),
        )  # fmt: skip
        if self.flange_back_mm is None:
            return reading
        return replace(reading, profile=with_back(reading.profile, self.flange_back_mm * MM))


_building: ContextVar[tuple[Path, ...]] = ContextVar("profile files that are being built", default=())

AnyProfileFile = Annotated[ShapeFile | WornFile | PointsFile, Field(discriminator="kind")]
FILE_KINDS: dict[str, type[ProfileFile]] = kinds_in(AnyProfileFile)


class _AnyFile(Section, header="a profile file"):
    """Only what decides which kind of file it is."""

    kind: Literal[*FILE_KINDS]  # type: ignore[valid-type]


def load_profile(
    path: str | Path, kind: Kind | None = None, back: float | None = None, changes: Mapping[str, Any] | None = None
) -> Profile:
    """Read a wheel or rail profile.

    Parameters
    ----------
    path : str or Path
        A TOML file of one of the kinds of docs/user/profiles.md, or a file of points
        (``.prw .prr .whl .ban .csv .txt .dat``), here or among the models: ``"rails/60E1.toml"``.
    kind : {"wheel", "rail"}, optional
        Only two columns without a header of wrsim need it; where a file has it, it must be the same.
    back : float, optional
        Distance of a wheel's flange back from its tape circle [m], where its file does not state it; 70 mm.
    changes : mapping, optional
        Values of a TOML file to be changed, by dotted keys: ``{"pieces[1].radius_mm": 14}``.

    Returns
    -------
    Profile
        A rail is upright: ``inclined(1 / 40)`` inclines it; ``notes`` has what was assumed of a file of points.

    Raises
    ------
    InputError
        With all faults of a TOML file at once: file, line, key, value, what is allowed.
    """
    with reading_as({"wheel": {"usual_back": back}}):
        return load_reading(path, kind, changes).profile


def load_reading(path: str | Path, kind: Kind | None = None, changes: Mapping[str, Any] | None = None) -> Reading:
    """Read a wheel or rail profile with the points that it is made from, if any. As `load_profile`."""
    path = model_file(path)
    if path.suffix.lower() != ".toml":
        if changes:
            raise InputError(f"{path}: is a file of points; changes are for keys of a profile file (TOML)")
        return read_points(path, kind)
    model = read_profile_file(path, kind, changes)
    if isinstance(model, PointsFile):
        return model.reading(path)  # names the file of points
    try:
        profile = model.build(path)
        check_tread(profile)
        if profile.length < SHORTEST:
            raise InputError(f"the profile is {1e3 * profile.length:g} mm long; needs at least {1e3 * SHORTEST:g} mm")
        return Reading(None, stating_back(profile))
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def readings_in(folder: Path, kind: Kind | None) -> tuple[dict[str, Reading], tuple[str, ...]]:
    """Profiles of a kind, or of both, in a folder by the names of their files without ending; faults of other files, a
    line for each reason.

    Profile files (TOML) and files of points; of files that share a name without ending the TOML file, which describes
    the points. Raises InputError where there are none.
    """
    endings = {ending: of for form in PROFILE_FILES.values() for ending, of in form.suffixes.items()}
    files = {f.stem: f for f in sorted(folder.iterdir()) if f.suffix.lower() in endings}
    files = {stem: f for stem, f in files.items() if kind is None or endings[f.suffix.lower()] in (None, kind)}
    files |= {f.stem: f for f in sorted(folder.glob("*.toml"))}
    readings, refused = {}, dict[str, list[str]]()
    for stem, file in sorted(files.items()):
        try:
            reading = load_reading(file, None if file.suffix == ".toml" else kind)
        except InputError as error:
            text = in_one_line(error)
            why = text.removeprefix(str(file)) if text.startswith(str(file)) else f": {text}"
            refused.setdefault(why, []).append(file.name)
            continue
        if kind in (None, reading.profile.kind):
            readings[stem] = reading
    more = {why: f" and {len(names) - 3} more" if len(names) > 3 else "" for why, names in refused.items()}
    faults = tuple(f"{folder / ', '.join(names[:3])}{more[why]}{why}" for why, names in refused.items())
    if not readings:
        head = f"{folder}: has no {kind or 'wheel or rail'} profiles"
        raise InputError("\n".join((f"{head} (files that end in .toml or {' '.join(sorted(endings))})", *faults)))
    return readings, faults


def readings_of(
    names: Sequence[str], kind: Kind | None, models: Sequence[str | Path] = ()
) -> tuple[dict[str, Reading], tuple[str, ...]]:
    """Profiles of files and of folders, by the names of their files without ending; faults of files of folders."""
    readings, faults = dict[str, Reading](), list[str]()
    for name in names:
        if (folder := Path(name)).is_dir():
            inside, bad = readings_in(folder, kind)
            faults += bad
        else:
            inside = {folder.stem: load_reading(model_file(name, models), kind)}
        readings |= {f"{name}: {stem}" if stem in readings else stem: reading for stem, reading in inside.items()}
    return readings, tuple(faults)


def changed_profile(path: Path, changes: Mapping[str, Any]) -> tuple[dict[str, Any], Locate]:
    """Tables of a profile file with some values changed, and what locates keys. Raises InputError."""
    data, locate = opened(path, "profile file")
    for key, value in changes.items():
        try:
            data = changed(data, full_path(data, key_path(key), by_name=False), value)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
    return data, locate


def read_profile_file(path: Path, kind: Kind | None, changes: Mapping[str, Any] | None = None) -> ProfileFile:
    """What a TOML file says of a profile, with some values changed. Raises InputError."""
    data, locate = changed_profile(path, changes or {})
    if "kind" not in data:
        refuse_other_kind(AnyProfileFile, data, locate)
    file_kind = check_section(_AnyFile, {k: v for k, v in data.items() if k == "kind"}, locate).kind
    model = check_section(FILE_KINDS[file_kind], data, locate)
    if kind is not None and model.body != kind:
        raise InputError(f'{locate(("body",))}: body = "{model.body}": a {kind} profile is needed here')
    return model
