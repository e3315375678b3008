"""A track that many scenarios share: a file with the table [track], named by ``[track] file``.

The keys of the scenario's own [track] lie over those of the file, lists included: a scenario may take the line and
lay other rails on it.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from wrsim.errors import InputError
from wrsim.inputs.checking import check, fault_line
from wrsim.inputs.lookup import Finder
from wrsim.inputs.section import Section
from wrsim.inputs.toml_files import parse_toml, read_text
from wrsim.inputs.values import Day, Source, text
from wrsim.scenario.merging import Merged, laid_over, of_tables

FILE = "file"


class TrackFile(Section):
    """What stands beside [track] in a track file."""

    header: ClassVar[str] = "a track file"

    name: Annotated[str, text("the track's name")]
    """Name of the track."""
    source: Source
    """Where the data of the track come from."""
    date: Day
    """Day on which the file was written."""


def with_track_file(merged: Merged, finder: Finder) -> Merged:
    """The scenario with the track file that it names beneath its own [track]; unchanged when it names none.

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
        text = read_text(path, "track file")
    except InputError as error:
        raise InputError(fault_line(key, str(error), merged.locate, name)) from None
    data = parse_toml(text, str(path))
    below = of_tables(data, text, str(path), (path,))
    check(TrackFile, {k: v for k, v in data.items() if k != "track"}, below.locate)
    inner = data.get("track")
    if not isinstance(inner, dict):
        raise InputError(f"{path}: track is missing: must be a table ([track] with [[track.segments]] or table)")
    if FILE in inner:
        raise InputError(fault_line(key, "a track file cannot name another one", below.locate, inner[FILE]))
    below.data = {"track": inner}
    own: dict[str, Any] = {**merged.data, "track": {k: v for k, v in track.items() if k != FILE}}
    owners = {path: owner for path, owner in merged.owners.items() if path != key}
    return laid_over(below, Merged(own, merged.text, merged.files, owners, merged.lines))
