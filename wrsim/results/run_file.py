"""The file that a run in time writes while it lasts: whole records, appended one after the other.

A process may die at any byte. Every record carries its length and a checksum, so a reader takes the records that are
whole and sees nothing of a torn one; who continues the run cuts the torn one off. What a record means is for its
writer to say (``wrsim.simulation.recorder``).

Layout, little-endian: the signature; then for each record its kind (4 bytes), the length of its content (uint64), the
CRC-32 of kind and content (uint32), the content. The first record is the header, a JSON object.

Data reach the operating system at every record, which is what the death of a process asks for. They reach the disk
when the system sees fit: after a power failure the file ends earlier, at a whole record all the same.
"""

from __future__ import annotations

import contextlib
import json
import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from wrsim.errors import InputError
from wrsim.inputs.toml_files import open_plain
from wrsim.results.files import fcntl, from_json, lock, open_no_link, plain_disk_errors

SIGNATURE = b"wrsim run\r\n\x1a\x02\x00\x00\x00"
"""Last four bytes: version of the layout."""

_NAMED = 12
"""Bytes of the signature before the version."""

_CHUNK = 1 << 30
"""Bytes read at once; systems give at most 2 GiB."""

HEADER = b"HEAD"
_FRAME = struct.Struct("<4sQI")

_TEXTS = ("title", "analysis", "scenario_text", "numbers", "code", "integrator")
_TEXTS_BY_NAME = ("files", "inputs")
_LIMITS = {"size": (1, 10**6), "step_s": (1e-9, 1e3), "start_s": (-1e9, 1e9)}


class Header(dict[str, Any]):
    """What a run file says of its run. Asking for what it lacks raises ``InputError``."""

    def __init__(self, path: Path, content: bytes) -> None:
        """Raises ``InputError`` for what is none, or holds values of another kind than runs write."""
        self.path = path
        found = from_json(content)
        if found is None:
            raise InputError(f"{path}: its header is no JSON object; run the scenario again")
        super().__init__(found)
        for name, value in self.items():
            if wanted := _unlike(name, value):
                told = repr(value)[:40]
                raise InputError(f"{path}: {name} in its header is {told}; must be {wanted}; run the scenario again")

    def __missing__(self, name: str) -> Any:
        raise InputError(f"{self.path}: its header has no {name}; run the scenario again")


def _unlike(name: str, value: Any) -> str:
    """What a value of the header would have to be; empty if it is."""
    if name in _TEXTS or name.endswith("_version"):
        return "" if isinstance(value, str) else "a text"
    if name in _TEXTS_BY_NAME:
        fits = isinstance(value, dict) and all(isinstance(own, str) for own in value.values())
        return "" if fits else "texts by name"
    if name == "folders":
        texts = isinstance(value, list) and all(isinstance(own, str) and "\0" not in own for own in value)
        return "" if texts and value else "a list of folders"
    if name in _LIMITS:
        (low, high), kind = _LIMITS[name], int if name == "size" else int | float
        fits = isinstance(value, kind) and not isinstance(value, bool) and low <= value <= high
        return "" if fits else f"a{' whole' if kind is int else ''} number from {low:g} to {high:g}"
    return ""


@dataclass(frozen=True)
class Record:
    """Kind, content, and the place in the file behind it."""

    kind: bytes
    content: bytes
    end: int


class RunFile:
    """A run file open for appending, locked against a second run. Close it, or use it in a ``with``."""

    def __init__(self, path: Path, stream: IO[bytes]) -> None:
        self.path = path
        self._stream = stream

    @classmethod
    def create(cls, path: str | Path, header: dict[str, Any]) -> RunFile:
        """Start a file; an older one of that name is replaced, unless a run is writing to it (``InputError``)."""
        path = Path(path)
        with plain_disk_errors(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            file = cls(path, _locked(path))
            file.cut(0)
            file._write(SIGNATURE)
        file.append(HEADER, json.dumps(header, ensure_ascii=False).encode())
        return file

    @classmethod
    def opened(cls, path: str | Path) -> RunFile:
        """Open a file to go on with; ``cut`` says where. Nobody else can write to it from now on."""
        path = Path(path)
        with plain_disk_errors(path):
            return cls(path, _locked(path))

    def append(self, kind: bytes, *parts: bytes) -> None:
        """Write one record. Raises ``WrsimError`` when the disk is full; what was written before stays readable."""
        checksum = zlib.crc32(kind)
        for part in parts:
            checksum = zlib.crc32(part, checksum)
        size = sum(len(part) for part in parts)
        with plain_disk_errors(self.path, size):
            begin = self._stream.tell()
            try:
                self._write(b"".join((_FRAME.pack(kind, size, checksum), *parts)))
            except BaseException:  # Ctrl-C as well: later records must not stand behind a torn one
                with contextlib.suppress(OSError):
                    self.cut(begin)
                raise

    def _write(self, data: bytes) -> None:
        """Everything, or an error: a disk that fills up takes a part first."""
        rest = memoryview(data)
        while rest:
            rest = rest[self._stream.write(rest) :]

    def cut(self, end: int) -> None:
        """Throw away what stands behind ``end``."""
        self._stream.truncate(end)
        self._stream.seek(end)

    def read(self) -> tuple[dict[str, Any], Iterator[Record]]:
        """Header and records written so far, also when the file has lost its name (a folder that was deleted)."""
        return _header_and_records(self.path, self._stream.fileno())

    def close(self) -> None:
        """Close the file and let go of its lock."""
        self._stream.close()

    def __enter__(self) -> RunFile:
        return self

    def __exit__(self, *of: object) -> None:
        self.close()


def _locked(path: Path) -> IO[bytes]:
    """The file, unbuffered and locked; it is made where it does not exist. Raises ``InputError`` for any other file."""
    stream = open_no_link(path, os.O_RDWR | os.O_CREAT)
    if not lock(stream):
        stream.close()
        raise InputError(f"{path}: another run is writing to it; choose another directory with -o")
    begin = stream.read(len(SIGNATURE))
    if begin[:_NAMED] != SIGNATURE[: min(len(begin), _NAMED)]:
        stream.close()
        raise InputError(f"{path}: not the file of a run of wrsim; move it away, or choose another directory with -o")
    return stream


def is_running(path: str | Path) -> bool:
    """True while a run is writing to the file (as far as the system can tell)."""
    if fcntl is None:
        return False
    with contextlib.suppress(OSError), open(path, "rb") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
    return False


@contextlib.contextmanager
def opened_run_file(path: str | Path) -> Iterator[tuple[dict[str, Any], Iterator[Record]]]:
    """Header and whole records of a run file, in their order, read one by one; what is torn or damaged ends them.

    Raises ``InputError`` when the file is missing, is none of ours, or does not even hold a whole header.
    """
    path = Path(path)
    try:
        stream = open(open_plain(path, "file of a run"), "rb")  # noqa: SIM115 - a fault while the records are used is not one of opening
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file of a run") from None
    except OSError as problem:
        raise InputError(f"{path}: cannot be read: {(problem.strerror or str(problem)).lower()}") from problem
    with stream:
        yield _header_and_records(path, stream.fileno())


def _header_and_records(path: Path, file: int) -> tuple[dict[str, Any], Iterator[Record]]:
    """See `opened_run_file`; file: its descriptor."""
    begin = _read(file, len(SIGNATURE), 0)
    if begin[:_NAMED] != SIGNATURE[:_NAMED]:
        if SIGNATURE.startswith(begin):
            raise InputError(f"{path}: the run was cut off before its start; run the scenario again")
        raise InputError(f"{path}: not the file of a run of wrsim")
    if begin[_NAMED:] != SIGNATURE[_NAMED:]:
        raise InputError(f"{path}: written by another version of wrsim, in a layout that this one does not read")
    records = _whole_records(file)
    first = next(records, None)
    if first is None or first.kind != HEADER:
        raise InputError(f"{path}: the run was cut off before its start; run the scenario again")
    return Header(path, first.content), records


def _read(file: int, size: int, place: int) -> bytes:
    """So many bytes of a file from a place on, or what there is of them."""
    parts = []
    while size > 0 and (part := os.pread(file, min(size, _CHUNK), place)):
        parts.append(part)
        size, place = size - len(part), place + len(part)
    return b"".join(parts)


def _whole_records(file: int) -> Iterator[Record]:
    place, length = len(SIGNATURE), os.fstat(file).st_size
    while place + _FRAME.size <= length:
        kind, size, checksum = _FRAME.unpack(_read(file, _FRAME.size, place))
        start = place + _FRAME.size
        if size > length - start:
            break
        content = _read(file, size, start)
        if len(content) < size or zlib.crc32(content, zlib.crc32(kind)) != checksum:
            break
        place = start + size
        yield Record(kind, content, place)
