"""Writing files so that a reader never meets half of one and nothing of the user's is lost; tables, numbers as bytes.

Every folder that a command writes into holds a manifest (``.wrsim``), one JSON object a line: names and digests of the
files that wrsim wrote there, when an analysis began and when all of its files were complete. A file that is not in the
manifest, or has changed since, belongs to the user; so does every file that the scenario reads. Lines are appended,
each before its file gets its name. While an analysis writes into a folder, it holds a lock on the manifest.
"""

from __future__ import annotations

import contextlib
import csv
import errno
import hashlib
import io
import json
import os
import re
import secrets
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from fnmatch import fnmatch
from itertools import islice
from pathlib import Path, PureWindowsPath
from typing import IO, Any

from wrsim import system
from wrsim.errors import InputError, WrsimError
from wrsim.inputs.toml_files import open_plain, other_kind

KEEPER: ContextVar[Keeper | None] = ContextVar("KEEPER", default=None)
"""The `Keeper` that checks and notes every file before it is written; commands set one."""

_REASONS = dict.fromkeys((errno.EACCES, errno.EPERM, errno.EROFS), "this place may not be written to")
_REASONS |= dict.fromkeys((errno.ENOTDIR, errno.EEXIST), "a part of this path is a file, not a directory")
LARGE = 16_000_000
"""Bytes of samples and of channels that are in memory at most; more are in a file."""
_ROWS = 1000  # rows of a table that are in memory as text at once
_NEGATIVE = re.compile(r"-\d+(\.\d+)?(e[+-]\d+)?").fullmatch

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


@contextmanager
def plain_disk_errors(path: Path, size: int | None = None) -> Iterator[None]:
    """Turn an ``OSError`` of writing to ``path`` into one sentence (``WrsimError``); size: of the content [bytes]."""
    try:
        yield
    except OSError as problem:
        if problem.errno in _FULL:
            factor, unit = (1e3, "kB") if size is not None and size < 1e5 else (1e6, "MB")
            needed = "" if size is None else f" ({size / factor:.1f} {unit} needed)"
            why = f"the disk is full{needed}; free some space or choose another directory"
        else:
            why = system.remedy(problem, path) or _REASONS.get(
                problem.errno or 0, (problem.strerror or str(problem)).lower()
            )
        raise WrsimError(f"cannot write {path}: {why}") from problem


def check_place(path: Path) -> None:
    """Raises ``InputError`` where a device, a pipe or a directory is: a file would take its place."""
    with contextlib.suppress(OSError):
        if kind := other_kind(path.stat().st_mode):
            raise InputError(f"{path}: is {kind}; a file of that name is written: move it away, or choose another")


def write_atomically(path: str | Path, content: bytes | Iterable[bytes], size: int | None = None) -> Path:
    """Write ``content``, whole or in parts, to a neighbour of ``path``, bring it to the disk, then rename it.

    size: of what comes in parts [bytes], for messages. Directories are made; nothing half-written remains. Raises
    ``WrsimError`` when the disk is full or the place cannot be written; ``InputError`` for a path of no plain file
    (`check_place`), in a command also for a file of the user's (see `Keeper`).
    """
    path = Path(path)
    check_place(path)
    if (keeper := KEEPER.get()) is not None:
        keeper.check(path)
    digest = hashlib.sha256()
    temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    with plain_disk_errors(path, len(content) if isinstance(content, bytes) else size):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with open(temporary, "xb") as stream:
                for part in (content,) if isinstance(content, bytes) else content:
                    stream.write(part)
                    if keeper is not None:
                        digest.update(part)
                stream.flush()
                os.fsync(stream.fileno())
            if keeper is not None:
                keeper.note(path, digest.hexdigest())
            system.replace(temporary, path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
    return path


LEFT_OVER = re.compile(r"\..+\.(csv|json|nc|png|toml)\.[0-9a-z_]{8}\.part")
"""Names that `write_atomically` and `wrsim.results.netcdf` give to what they have not finished."""


def sweep(folder: Path) -> None:
    """Remove what processes that were killed while they wrote have left in a folder; the caller holds its lock."""
    for path in folder.glob(".*.part"):
        if LEFT_OVER.fullmatch(path.name) and path.is_file() and not path.is_symlink():
            with contextlib.suppress(PermissionError):  # in use, on Windows
                path.unlink(missing_ok=True)


def open_no_link(path: Path, flags: int) -> IO[bytes]:
    """Open a file of wrsim's own, unbuffered; a symbolic link in its place is refused (``InputError``)."""
    try:
        if not system.NO_LINK and path.is_symlink():
            raise OSError(errno.ELOOP, "is a symbolic link")
        handle = open_plain(path, "plain file", flags | system.NO_LINK)
    except OSError as problem:
        if problem.errno == errno.ELOOP:
            raise InputError(f"{path}: is a symbolic link; wrsim does not write through it: move it away") from None
        raise
    return open(handle, "rb" if flags == os.O_RDONLY else "r+b", buffering=0)


def lock(stream: IO[bytes]) -> bool:
    """Lock an open file against other processes until it is closed; False if one of them holds it."""
    try:
        system.lock(stream)
    except OSError as problem:
        return problem.errno not in (errno.EACCES, errno.EAGAIN)  # others: a file system without locks
    return True


def as_csv(rows: Iterable[Sequence[str]]) -> bytes:
    """Rows as comma-separated values (RFC 4180 quoting, line feeds, UTF-8); no cell is a formula, see `safe_cell`."""
    return b"".join(csv_parts(rows))


def csv_parts(rows: Iterable[Sequence[str]]) -> Iterator[bytes]:
    """The same, some rows at a time."""
    rest = iter(rows)
    while some := list(islice(rest, _ROWS)):
        cells = [[c if c[:1] in "0123456789" or _NEGATIVE(c) else safe_cell(c) for c in row] for row in some]
        text = "\n".join(map(",".join, cells)) + "\n"
        commas = sum(map(len, cells)) - len(cells)
        if '"' in text or "\r" in text or text.count(",") > commas or text.count("\n") > len(cells) or [""] in cells:
            stream = io.StringIO(newline="")
            csv.writer(stream, lineterminator="\n").writerows(cells)  # quotes what needs it, in four times the time
            text = stream.getvalue().replace("\r", " ")  # many readers begin a row after it
        yield text.encode()


def safe_cell(cell: str) -> str:
    """An apostrophe before what a spreadsheet would execute as a formula; numbers and all else as they are."""
    if not cell.lstrip().startswith(("=", "+", "-", "@")):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell


def from_json(content: bytes | str) -> dict[str, Any] | None:
    """The JSON object in a text; None for anything else, however torn or deep it is."""
    try:
        parsed = json.loads(content)
    except (ValueError, RecursionError):
        return None
    return parsed if isinstance(parsed, dict) else None


def as_json(content: Any, indent: int = 2) -> bytes:
    """Plain numbers and texts as JSON."""
    return (json.dumps(content, indent=indent, ensure_ascii=False, allow_nan=False) + "\n").encode()


STUDY, EVOLUTION = "study.nc", "wear.nc"
"""Files of the numbers of studies and of profile evolutions."""


def holds(path: Path, name: str) -> bool:
    """True for the file of numbers of that name, and for a folder that holds it."""
    return path.name == name or (path / name).is_file()


MANIFEST = ".wrsim"
_KEPT = 32  # characters of a digest that are stored


def digest_of(content: bytes) -> str:
    """What the manifest keeps of a file, or of a scenario's text."""
    return hashlib.sha256(content).hexdigest()[:_KEPT]


def _is_entry(entry: dict[str, Any]) -> bool:
    """True for a line as `Manifest.note` writes them: its files lie in the folder of the manifest, or below it."""
    file, further = entry.get("file", "x"), entry.get("files", [])
    texts = [file, entry.get("sha256", ""), entry.get("begin", ""), *(further if isinstance(further, list) else [None])]
    if not all(isinstance(text, str) and "\0" not in text for text in texts) or file != PureWindowsPath(file).name:
        return False
    return all(_is_inside(name) for name in further)


def _is_inside(name: str) -> bool:
    """True for a relative name without steps up, on every system."""
    path = PureWindowsPath(name)  # both / and \ separate its parts
    return not path.anchor and ".." not in path.parts


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
        parsed = (from_json(line) for line in lines)  # one is torn when its process was killed
        return [entry for entry in parsed if entry is not None and _is_entry(entry)]

    def _open(self) -> IO[bytes]:
        self.folder.mkdir(parents=True, exist_ok=True)
        return open_no_link(self.path, os.O_RDWR | os.O_APPEND | os.O_CREAT)

    def note(self, **entry: Any) -> None:
        """Append a line. Raises ``WrsimError`` when the folder cannot be written."""
        with plain_disk_errors(self.path), self._open() as stream:
            end = stream.seek(0, os.SEEK_END)
            torn = end > 0 and system.read_at(stream.fileno(), 1, end - 1) != b"\n"
            stream.write(b"\n" * torn + json.dumps(entry, ensure_ascii=False).encode() + b"\n")

    def wrote(self, path: Path) -> bool:
        """True if the file is as wrsim wrote it."""
        known = {entry.get("sha256") for entry in self.entries() if entry.get("file") == path.name}
        if not known or path.is_symlink() or not path.is_file():
            return False
        with open(path, "rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()[:_KEPT] in known

    def is_done(self, scenario_text: str, pictures: bool) -> bool:
        """True if the last analysis here is of this scenario and ended, and all its files, or pictures, too, exist."""
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
    """Decides on every file that a command writes. reads: files of its input; force: write over whatever is there; of:
    folder of the result that it writes or reports on, whose files go when another one takes its place."""

    reads: tuple[Path, ...] = ()
    force: bool = False
    of: Path | None = None

    def note(self, path: Path, sha256: str) -> None:
        """Note a file before it takes its place; sha256: of its content."""
        inside = self.of is not None and self.of.absolute() in list(path.absolute().parents)[:2]
        Manifest(path.parent).note(file=path.name, sha256=sha256[:_KEPT], **({"of_result": True} if inside else {}))

    def check(self, path: Path) -> None:
        """Raises ``InputError`` when a file of the user's is there."""
        check_place(path)
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

    def clear(self, current: Iterable[Path]) -> list[Path]:
        """Remove what wrsim wrote of an earlier result of this folder, beside the files ``current``; returns what went.
        Files that were changed since are the user's and stay."""
        if self.of is None:
            return []
        stay, gone = {path.absolute() for path in current}, []
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
    before = KEEPER.set(keeper)
    try:
        yield
    finally:
        KEEPER.reset(before)


def folder_of_result(result: Path) -> Path:
    """The folder of a result that is named by its file or by that folder."""
    return result if result.is_dir() else result.parent


def writing(force: bool, *reads: Path, of: Path | None = None) -> AbstractContextManager[None]:
    """While this lasts, no file of the user's is written over, ``reads`` least of all; of: the result reported on."""
    return keeping(Keeper(reads if of is None else (*reads, of), force, None if of is None else folder_of_result(of)))
