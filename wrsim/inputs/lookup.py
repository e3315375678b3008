"""Where a named file is: model files are looked up in a row of folders, the first hit counts."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

from wrsim.errors import InputError
from wrsim.inputs.file_kinds import TERMS
from wrsim.inputs.toml_files import KEPT, Kept, out_of_reach, reading_within
from wrsim.inputs.values import nearest

VARIABLE = "WRSIM_MODELS"
"""Environment variable with further folders of models, separated as in PATH."""


@dataclass(frozen=True)
class Finder:
    """A row of folders in which names like ``rails/60E1.toml`` are looked up."""

    folders: tuple[Path, ...]
    closed: bool = False
    """True for names of another author: no file outside of the folders is opened."""
    kept: Kept | None = field(default=None, repr=False, compare=False)
    """Model files of a result (`wrsim.scenario.kept`)."""

    @classmethod
    def of(cls, folders: Sequence[Path], models: Sequence[str | Path] | None = (), closed: bool = False) -> Finder:
        """A finder in folders, then in those of the user (`user_folders`), then in the models that are shipped."""
        return cls(tuple(dict.fromkeys((*folders, *user_folders(tuple(models or ())), shipped_models()))), closed)

    def guard(self) -> AbstractContextManager[None]:
        """Within this block names inside of files are not opened outside of the folders either, if they are closed."""
        return reading_within(self.folders, self.kept) if self.closed else nullcontext()

    def find(self, name: str) -> Path:
        """The first file of that name; an absolute name is taken as it is.

        Raises InputError listing the places searched and the nearest name that exists there.
        """
        if eaten := [letter for escape, letter in ESCAPES.items() if escape in name]:
            slashed = "".join(f"/{ESCAPES[c]}" if c in ESCAPES else c for c in name).replace("\\", "/")
            raise InputError(f'"\\{eaten[0]}" in double quotes is one letter, not a folder: write "{slashed}"')
        if "\\" in name:
            raise InputError(f'folders are separated by /: write "{name.strip(chr(34)).replace(chr(92), "/")}"')
        file = Path(name)
        with self.guard():
            places = [folder / file for folder in self.folders]  # an absolute name: always itself
            if (kept := KEPT.get()) and (stored := [place for place in (*places, file) if str(place) in kept.contents]):
                return stored[0]
            refused = {place: out_of_reach(place) for place in places}
            for place in places:
                if not refused[place] and os.path.isfile(place):
                    return place
            if any(refused.values()):
                raise InputError(next(filter(None, refused.values())))
            if file.is_absolute():
                raise InputError("no such file" if not os.path.isdir(file) else "is a directory, a file is needed")
            near = self._nearest(file)
        searched = ", ".join(dict.fromkeys(str(folder.absolute()) for folder in self.folders))
        raise InputError(f"not found in {searched}" + (f'; did you mean "{near}"?' if near else ""))

    def beside(self, file: Path) -> Finder:
        """A finder that looks beside ``file`` first, for names inside of it."""
        return replace(self, folders=(file.parent, *(folder for folder in self.folders if folder != file.parent)))

    def _nearest(self, file: Path) -> str | None:
        known: list[str] = []
        for folder in self.folders:
            for place in {folder / file.parent, *(folder / kind for kind in KINDS)}:
                if os.path.isdir(place):
                    known += sorted(p.relative_to(folder).as_posix() for p in place.iterdir() if p.is_file())
        known = [k for k in known if Path(k).suffix in (file.suffix, ".toml")]
        plain = file.stem.lower().replace(" ", "").replace("_", "").replace("-", "")
        if ours := next((k for k in known if Path(k).stem == OTHER_NAMES.get(plain)), None):
            return ours
        if same_name := [k for k in known if file.name in (Path(k).name, Path(k).stem)]:
            return same_name[0]
        stems = {Path(k).stem: k for k in known}
        return nearest(file.as_posix(), known) or stems.get(nearest(file.stem, list(stems)) or "")


OTHER_NAMES: dict[str, str] = TERMS["profiles"]
"""Former and other names of profiles."""

ESCAPES = {"\t": "t", "\n": "n", "\r": "r", "\b": "b", "\f": "f", "\x1b": "e"}
"""Letters that a TOML text with a backslash makes of the first letter behind it."""

KINDS = ("wheels", "rails", "vehicles", "trains", "tracks")
"""Folders inside a folder of models."""


@cache
def shipped_models() -> Path:
    """The folder of the models that come with wrsim: in the package, or beside it in the source."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "models"
    return inside if inside.is_dir() else package.parent / "models"


def as_path(value: Any, label: str) -> Path:
    """What is given from Python, as a path. label: the file that it names. Raises InputError for what is no path."""
    if not isinstance(value, str | os.PathLike):
        raise InputError(f"{value!r:.60}: must be the name of {label}, a text or a Path")
    return Path(value)


def model_file(name: str | Path, extra: Sequence[str | Path] | None = ()) -> Path:
    """A file that is named from Python or on a command line: as it is, or among the models.

    Folders ``extra``, and those of the environment variable WRSIM_MODELS, come before the models that are shipped.
    Raises InputError for a relative name that is not found.
    """
    path = as_path(name, "a model file")
    if path.is_absolute() or os.path.exists(path):
        return path
    try:
        return usual_finder(extra).find(path.as_posix())
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def usual_finder(extra: Sequence[str | Path] | None = ()) -> Finder:
    """A finder for names from Python or from a command line."""
    return Finder.of((Path(),), extra)


def user_folders(extra: tuple[str | Path, ...] = ()) -> tuple[Path, ...]:
    """Folders of the user, by argument and then by the environment. Raises InputError for one that is no folder."""
    if kept := KEPT.get():
        return kept.user_folders
    named = [("models", str(folder)) for folder in extra]
    named += [(VARIABLE, text) for text in os.environ.get(VARIABLE, "").split(os.pathsep) if text]
    for key, text in named:
        if not os.path.isdir(text):
            raise InputError(f'{key} = "{text}": must be a folder with model files; there is none of that name')
    return tuple(Path(text) for _, text in named)
