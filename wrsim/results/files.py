"""Writing files so that a reader never meets half of one; tables and numbers as bytes."""

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
from contextlib import contextmanager
from contextvars import ContextVar
from itertools import islice
from pathlib import Path
from typing import IO, Any

from wrsim.errors import InputError, WrsimError
from wrsim.inputs.toml_files import open_plain, other_kind

try:
    import fcntl
except ImportError:  # no such locks on this system: two runs into one folder go unnoticed
    fcntl = None  # type: ignore[assignment]


KEEPER: ContextVar[Any] = ContextVar("KEEPER", default=None)
"""The ``wrsim.results.manifest.Keeper`` that checks and notes every file before it is written; commands set one."""

_REASONS = dict.fromkeys((errno.EACCES, errno.EPERM, errno.EROFS), "this place may not be written to")
_REASONS |= dict.fromkeys((errno.ENOTDIR, errno.EEXIST), "a part of this path is a file, not a directory")
LARGE = 16_000_000
"""Bytes of samples and of channels that are kept in memory at most; more are in a file."""
_ROWS = 1000  # rows of a table that are in memory as text at once

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
            why = _REASONS.get(problem.errno or 0, (problem.strerror or str(problem)).lower())
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
    (`check_place`), in a command also for a file of the user's (``wrsim.results.manifest``).
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
                    digest.update(part)
                stream.flush()
                os.fsync(stream.fileno())
            if keeper is not None:
                keeper.note(path, digest.hexdigest())
            os.replace(temporary, path)
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
            path.unlink(missing_ok=True)


def open_no_link(path: Path, flags: int) -> IO[bytes]:
    """Open a file of wrsim's own, unbuffered; a symbolic link in its place is refused (``InputError``)."""
    try:
        handle = open_plain(path, "plain file", flags | getattr(os, "O_NOFOLLOW", 0))
    except OSError as problem:
        if problem.errno == errno.ELOOP:
            raise InputError(f"{path}: is a symbolic link; wrsim does not write through it: move it away") from None
        raise
    return open(handle, "rb" if flags == os.O_RDONLY else "r+b", buffering=0)


def lock(stream: IO[bytes]) -> bool:
    """Lock an open file against other processes until it is closed; False if one of them holds it."""
    if fcntl is None:
        return True
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
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
        stream = io.StringIO(newline="")
        csv.writer(stream, lineterminator="\n").writerows([safe_cell(cell) for cell in row] for row in some)
        yield stream.getvalue().replace("\r", " ").encode()  # many readers begin a row after it


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
        found = json.loads(content)
    except (ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def as_json(content: Any, indent: int = 2) -> bytes:
    """Plain numbers and texts as JSON."""
    return (json.dumps(content, indent=indent, ensure_ascii=False, allow_nan=False) + "\n").encode()
