"""What wrsim may write over: nothing of the user's.

Every folder that a command writes into holds a manifest (``.wrsim``), one JSON object a line: names and digests of the
files that wrsim wrote there, when an analysis began and when all of its files were complete. A file that is not in the
manifest, or has changed since, belongs to the user; so does every file that the scenario reads. Lines are appended,
each before its file gets its name. While an analysis writes into a folder, it holds a lock on the manifest.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path
from typing import IO, Any

from wrsim.errors import InputError
from wrsim.results import files
from wrsim.results.files import from_json, lock, open_no_link, plain_disk_errors

MANIFEST = ".wrsim"
_KEPT = 32  # characters of a digest that are kept


def digest_of(content: bytes) -> str:
    """What the manifest keeps of a file, or of a scenario's text."""
    return hashlib.sha256(content).hexdigest()[:_KEPT]


def _is_entry(entry: dict[str, Any]) -> bool:
    """True for a line as `Manifest.note` writes them: its files lie in the folder of the manifest, or below it."""
    own, further = entry.get("file", "x"), entry.get("files", [])
    texts = [own, entry.get("sha256", ""), entry.get("begin", ""), *(further if isinstance(further, list) else [None])]
    if not all(isinstance(text, str) and "\0" not in text for text in texts) or own != Path(own).name:
        return False
    return not any(Path(name).is_absolute() or ".." in Path(name).parts for name in further)


@dataclass(frozen=True)
class Manifest:
    """The manifest of one folder; see the module."""

    folder: Path

    @property
    def path(self) -> Path:
        """Its file."""
        return self.folder / MANIFEST

    def entries(self) -> list[dict[str, Any]]:
        """All lines that are whole, oldest first; none where there is no manifest."""
        try:
            with open_no_link(self.path, os.O_RDONLY) as stream:
                lines = stream.read().split(b"\n")
        except OSError:
            return []
        found = (from_json(line) for line in lines)  # one is torn when its process was killed
        return [entry for entry in found if entry is not None and _is_entry(entry)]

    def _open(self) -> IO[bytes]:
        self.folder.mkdir(parents=True, exist_ok=True)
        return open_no_link(self.path, os.O_RDWR | os.O_APPEND | os.O_CREAT)

    def note(self, **entry: Any) -> None:
        """Append a line. Raises ``WrsimError`` when the folder cannot be written."""
        with plain_disk_errors(self.path), self._open() as stream:
            end = stream.seek(0, os.SEEK_END)
            torn = end > 0 and os.pread(stream.fileno(), 1, end - 1) != b"\n"
            stream.write(b"\n" * torn + json.dumps(entry, ensure_ascii=False).encode() + b"\n")

    def wrote(self, path: Path) -> bool:
        """True if the file is as wrsim wrote it."""
        known = {entry.get("sha256") for entry in self.entries() if entry.get("file") == path.name}
        if not known or path.is_symlink() or not path.is_file():
            return False
        with open(path, "rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()[:_KEPT] in known

    def is_done(self, scenario_text: str, pictures: bool) -> bool:
        """True if the last analysis that began here is that of this scenario, it ended, and all of its files exist.
        pictures: whether they have to be among them."""
        begun, done = "", dict[str, Any]()
        for entry in self.entries():
            begun, done = (entry["begin"], {}) if "begin" in entry else (begun, entry if "done" in entry else done)
        if not done or begun != digest_of(scenario_text.encode()) or pictures > bool(done.get("pictures")):
            return False
        return all((self.folder / name).exists() for name in done.get("files", ()))

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keep a second analysis out of the folder; raises ``InputError`` when there is one at work."""
        with plain_disk_errors(self.path):
            stream = self._open()
        with stream:
            if not lock(stream):
                raise InputError(f"{self.folder}: another run is writing into it; choose another directory with -o")
            yield


@dataclass(frozen=True)
class Keeper:
    """Decides on every file that a command writes. reads: files that it has read its input from; force: write over
    whatever is there; of: the folder of the result that it writes or reports on, whose files go when another one takes
    its place."""

    reads: tuple[Path, ...] = ()
    force: bool = False
    of: Path | None = None

    def note(self, path: Path, sha256: str) -> None:
        """Note a file before it takes its place; sha256: of its content."""
        inside = self.of is not None and self.of.absolute() in list(path.absolute().parents)[:2]
        Manifest(path.parent).note(file=path.name, sha256=sha256[:_KEPT], **({"of_result": True} if inside else {}))

    def check(self, path: Path) -> None:
        """Raises ``InputError`` when a file of the user's is there."""
        files.check_place(path)
        if self.force or not os.path.lexists(path):
            return
        if path.exists() and any(read.exists() and path.samefile(read) for read in self.reads):
            raise InputError(
                f"{path}: would be written over, but the input is read from it; "
                "choose another directory with -o, or write over it with --force"
            )
        if not Manifest(path.parent).wrote(path):
            raise InputError(
                f"{path}: would be written over, but wrsim did not write it, or it has changed since; "
                "move it away, choose another directory with -o, or write over it with --force"
            )

    def clear(self, kept: Iterable[Path]) -> list[Path]:
        """Remove what wrsim wrote of an earlier result of this folder, beside the files ``kept``; returns what went.
        Files that were changed since are the user's and stay."""
        if self.of is None:
            return []
        stay, gone = {path.absolute() for path in kept}, []
        for folder in (*sorted(self.of.glob("wheelset_*/")), self.of):
            manifest = Manifest(folder)
            names = dict.fromkeys(str(e["file"]) for e in manifest.entries() if e.get("of_result"))
            for path in (folder / name for name in names):
                if path.absolute() not in stay and manifest.wrote(path):
                    path.unlink()
                    gone.append(path)
            if folder != self.of and [path.name for path in folder.iterdir()] == [MANIFEST]:
                (folder / MANIFEST).unlink()
                folder.rmdir()
        return gone

    def check_folder(self, folder: Path, patterns: Iterable[str]) -> None:
        """The same for all files of a folder whose names match one of the patterns: before long work begins."""
        if folder.is_dir():
            for path in sorted(folder.iterdir()):
                if any(fnmatch(path.name, pattern) for pattern in patterns):
                    self.check(path)


@contextmanager
def keeping(keeper: Keeper) -> Iterator[None]:
    """While this lasts, every file that is written goes past the keeper."""
    before = files.KEEPER.set(keeper)
    try:
        yield
    finally:
        files.KEEPER.reset(before)
