"""A scenario that starts from another (``base``): the tables merged, and where each key came from."""

import os
from dataclasses import dataclass, field, replace
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Annotated, Any

from wrsim.errors import InputError
from wrsim.inputs.checking import check_section, fault_line
from wrsim.inputs.lines import KeyPath, key_lines, line_of
from wrsim.inputs.lookup import Finder
from wrsim.inputs.section import Section
from wrsim.inputs.toml_files import parse_toml, toml_text, write_toml
from wrsim.inputs.us_units import metric_key
from wrsim.inputs.values import Day, Source, text
from wrsim.track.civil import ENDINGS

BASE = "base"
MOST_BASES = 20
"""Longest row of files that start from each other."""


@dataclass
class Merged:
    """Tables of a scenario file and of those it starts from, laid over each other.

    files: the file itself first, then its base, the base of that, ...; text: TOML of the whole, the file as
    written when it has no base, empty where it is made on use; owners: file of every key; texts: of the files.
    """

    data: dict[str, Any]
    text: str
    files: tuple[Path, ...]
    owners: dict[KeyPath, str] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)

    def locate(self, path: KeyPath) -> str:
        """Return file and line of a key: the file that set it last, or that has its table."""
        owners = (self.owners[path[:end]] for end in range(len(path), 0, -1) if path[:end] in self.owners)
        name = next(owners, str(self.files[0]) if self.files else "scenario")
        line = line_of(key_lines(self.texts.get(name, "")), path)
        return name if line is None else f"{name}:{line}"


def of_text(text: str, name: str, files: tuple[Path, ...]) -> Merged:
    """The tables of one text, all keys with the same owner: ``name``."""
    data = parse_toml(text, name)
    return Merged(data, text, files, _owned(data, name), {name: text})


def overlay(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """Return ``below`` with the keys of ``above``: tables merge, everything else is replaced, also in another unit."""
    written = {metric_key(key): key for key in above}
    merged = {key: value for key, value in below.items() if written.get(metric_key(key), key) == key}
    for key, value in above.items():
        if isinstance(value, dict) and isinstance(merged.get(key), dict):
            merged[key] = overlay(merged[key], value)
        else:
            merged[key] = value
    return merged


def read_merged(path: Path, children: tuple[Path, ...] = ()) -> Merged:
    """Read a scenario file and, if it has a ``base``, that one beneath it; children: files that start from this one.

    Tables merge key by key; everything else, lists included, is replaced. Raises InputError for files that
    cannot be read and for a base that leads back to itself.
    """
    top = of_text(toml_text(path, "scenario file"), str(path), (path,))
    if BASE not in top.data:
        return top
    base = top.data.pop(BASE)
    top.owners = _owned(top.data, str(path))

    def fault(message: str) -> InputError:
        return InputError(fault_line((BASE,), message, top.locate, base))

    if not isinstance(base, str) or not base.strip() or "\0" in base:
        raise fault('must be the name of a scenario file in quotes, such as "curve.toml"')
    below_path = path.parent / base
    family = (*children, path)
    if os.path.realpath(below_path) in map(os.path.realpath, family):
        raise fault(f"scenarios start from each other: {' -> '.join(map(str, (*family, below_path)))}")
    if len(family) > MOST_BASES:
        raise fault(f"follows {MOST_BASES} others: a scenario has no more than {MOST_BASES} base files")
    try:
        below = read_merged(below_path, family)
    except InputError as error:
        if os.path.isfile(below_path):
            raise
        raise fault(str(error)) from None
    return laid_over(below, top)


def laid_over(below: Merged, top: Merged) -> Merged:
    """Two trees of tables, ``top`` over ``below``, with the owner of every key; the files of ``top`` come first."""
    replaced = {path for path in top.owners if not isinstance(value_at(top.data, path), dict)}
    owners = {p: o for p, o in below.owners.items() if not any(p[:end] in replaced for end in range(1, len(p)))}
    data = overlay(below.data, top.data)
    files = (*top.files, *below.files)
    return Merged(data, write_toml(data), files, owners | top.owners, below.texts | top.texts)


def _owned(data: Any, name: str) -> dict[KeyPath, str]:
    """Every key of a tree, all with the same owner; plain lists count as one."""
    owners: dict[KeyPath, str] = {}
    trees: list[tuple[KeyPath, Any]] = [((), data)]
    while trees:
        path, tree = trees.pop()
        if isinstance(tree, list):
            tree = dict(enumerate(tree)) if any(isinstance(entry, dict) for entry in tree) else {}
        below = [((*path, key), value) for key, value in tree.items()]
        owners.update((inner, name) for inner, _ in below)
        trees += [(inner, value) for inner, value in below if isinstance(value, dict | list)]
    return owners


def value_at(data: Any, path: KeyPath) -> Any:
    """The value of a key in a tree of tables."""
    return reduce(getitem, path, data)


def holds_key(data: Any, path: KeyPath) -> bool:
    """Whether a tree of tables has a key."""
    try:
        value_at(data, path)
    except (LookupError, TypeError):
        return False
    return True


FILE = "file"
TRACK_FILE = f"track.{FILE}"
"""Key of [track] that names a track file."""
LAYING = ("segments", "table", "alignment")
OF_ONE_LINE = (*LAYING, "alignment_name", "grades", "irregularities", "rail_sections")
"""Keys of [track] that lay a line, one of which a track file has; what belongs to that line alone."""


class TrackFile(Section, header="a track file"):
    """Keys beside [track] in a track file."""

    foreign = ("track",)

    name: Annotated[str, text("the track's name")]
    """Name of the track."""
    source: Source
    """Where the data of the track come from."""
    date: Day
    """Day on which the file was written."""


def with_track_file(merged: Merged, finder: Finder) -> Merged:
    """The scenario with the track file that it names; unchanged when it names none.

    The file lies beneath what the same file, or one that starts from it, has in its own [track], and over the [track]
    of what that starts from (``base``; for ``--set`` the scenario), whose line goes when the track file lays another.
    Raises InputError at the key for a file that is not there, and in the file for what it must not hold.
    """
    track = merged.data.get("track")
    if not isinstance(track, dict):
        return merged
    name = track.get(FILE)
    if not isinstance(name, str) or not name.strip() or "\0" in name:
        return merged  # none, or one that the check of [track] refuses
    key = ("track", FILE)
    try:
        path = finder.find(name)
        civil = path.suffix.lower() in ENDINGS
        text = write_toml({"track": {"alignment": name}}) if civil else toml_text(path, "track file")
    except InputError as error:
        raise InputError(fault_line(key, str(error), merged.locate, name)) from None
    below = of_text(text, str(path), (path,))
    if civil:
        below.texts = {}  # which has no lines of keys
    else:
        check_section(TrackFile, {k: v for k, v in below.data.items() if k != "track"}, below.locate)
    inner = below.data.get("track")
    if not isinstance(inner, dict):
        raise InputError(f"{path}: track is missing: must be a table ([track] with [[track.segments]] or table)")
    if FILE in inner:
        raise InputError(fault_line(key, "a track file cannot name another one", below.locate, inner[FILE]))
    order = [str(file) for file in merged.files]

    def layer(entry: str) -> int:
        owner = merged.owners.get(("track", entry))
        return order.index(owner) if owner in order else -1

    gone = OF_ONE_LINE if any(entry in inner for entry in LAYING) else ()
    inherited = {entry for entry in track if layer(entry) > layer(FILE)}
    bottom = replace(_with_keys(merged, inherited - {*gone}), files=())
    middle = _with_keys(replace(below, data={"track": inner}), {*inner})
    return laid_over(laid_over(bottom, middle), _with_keys(merged, {*track} - inherited - {FILE}))


def _with_keys(merged: Merged, names: set[str]) -> Merged:
    """A scenario with these keys of its [track] alone, and with the owners of what it has; without any, [track] is
    another's."""
    data = {**merged.data, "track": {key: value for key, value in merged.data["track"].items() if key in names}}
    owned = data if names else {key: value for key, value in data.items() if key != "track"}
    owners = {path: owner for path, owner in merged.owners.items() if holds_key(owned, path)}
    return replace(merged, data=data, owners=owners)
