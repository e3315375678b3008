"""The file that a run in time writes while it lasts: whole records, appended one after the other.

A process may die at any byte. Every record carries its length and a checksum: a reader takes the whole records, who
continues the run cuts a torn one off. ``wrsim.simulation.recorder`` defines what records mean.

Layout, little-endian: the signature; for each record the length of its content (uint64), the CRC-32 of the content
(uint32), the content: a JSON object on one line, then numbers (float64). The first record is the header. Data reach the
operating system at every record, the disk when the system writes them: after a power failure the file ends earlier, at
a whole record all the same.
"""

import contextlib
import json
import os
import struct
import zlib
from collections.abc import Generator
from pathlib import Path
from typing import IO, Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from wrsim import system
from wrsim.errors import InputError
from wrsim.inputs.toml_files import open_plain
from wrsim.results.files import lock, open_no_link, plain_disk_errors

SIGNATURE = b"wrsim run\r\n\x1a\x04\x00\x00\x00"  # last four bytes: version of the layout
_NAMED = 12  # bytes of the signature before the version
FRAME = struct.Struct("<QI")


class _Known(BaseModel):
    """Entries of a header that are more than compared, and what they may be."""

    model_config = ConfigDict(strict=True, extra="allow", allow_inf_nan=False)

    scenario_text: str = ""
    files: dict[str, str] = {}
    inputs: dict[str, str] = {}
    integrator: str = ""
    size: Annotated[int, Field(ge=1, le=10**6)] = 1
    step_s: Annotated[float, Field(ge=1e-9, le=1e3)] = 1.0
    start_s: Annotated[float, Field(ge=-1e9, le=1e9)] = 0.0


class Header(dict[str, Any]):
    """What a run file states of its run. Asking for what it lacks raises ``InputError``, as does a wrong value."""

    def __init__(self, path: Path, about: bytes) -> None:
        self.path = path
        try:
            super().__init__(_Known.model_validate_json(about).model_dump(exclude_unset=True))
        except ValidationError as problem:
            first = problem.errors()[0]
            place = f"{first['loc'][0]!s:.40} in its header is {first['input']!r:.40}" if first["loc"] else "its header"
            raise InputError(f"{path}: {place}: {first['msg'].lower():.100}; run the scenario again") from None

    def __missing__(self, name: str) -> Any:
        raise InputError(f"{self.path}: its header has no {name}; run the scenario again")


class Record(NamedTuple):
    """What a record states (JSON) and holds, and the place in the file behind it."""

    about: bytes
    numbers: NDArray[np.float64]
    end: int


class RunFile:
    """A run file open for appending, locked against a second run."""

    def __init__(self, path: str | Path) -> None:
        """Open a file to go on with (see ``cut``), or a new one. Raises ``InputError``: none of a run, or in use."""
        self.path = path = Path(path)
        with plain_disk_errors(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            self._stream: IO[bytes] = open_no_link(path, os.O_RDWR | os.O_CREAT)
        fault = ""
        if not lock(self._stream):
            fault = "another run is writing to it; choose another directory with -o"
        elif not SIGNATURE.startswith(self._stream.read(len(SIGNATURE))[:_NAMED]):
            fault = "not the file of a run of wrsim; move it away, or choose another directory with -o"
        if fault:
            self.close()
            raise InputError(f"{path}: {fault}")

    def begin(self, header: dict[str, Any]) -> None:
        """Start anew; whatever the file held is gone."""
        self.cut(0)
        with plain_disk_errors(self.path):
            self._write(SIGNATURE)
        self.append(header)

    def append(self, about: dict[str, Any], *numbers: NDArray[np.float64]) -> None:
        """Write one record. Raises ``WrsimError`` when the disk is full; earlier records stay readable."""
        head = json.dumps(about, ensure_ascii=False).encode() + b"\n"
        content = b"".join((head, *(np.asarray(part, dtype="<f8").tobytes() for part in numbers)))
        with plain_disk_errors(self.path, len(content)):
            begin = self._stream.tell()
            try:
                self._write(FRAME.pack(len(content), zlib.crc32(content)) + content)
            except BaseException:  # Ctrl-C as well: later records must not follow a torn one
                with contextlib.suppress(OSError):
                    self.cut(begin)
                raise

    def _write(self, data: bytes) -> None:
        """Everything, or an error: a disk that fills up takes a part first."""
        rest = memoryview(data)
        while rest:
            rest = rest[self._stream.write(rest) :]

    def cut(self, end: int) -> None:
        """Throw away what is behind ``end``."""
        self._stream.truncate(end)
        self._stream.seek(end)

    def records(self) -> Generator[Record]:
        """Records written so far, also when the file has lost its name (a folder that was deleted)."""
        return _records(self.path, self._stream.fileno())

    def close(self) -> None:
        """Close the file and release its lock."""
        self._stream.close()


def is_running(path: str | Path) -> bool:
    """True while a run is writing to the file (as far as the system knows)."""
    with contextlib.suppress(OSError), open(path, "rb") as stream:
        try:
            system.lock(stream, shared=True)
        except BlockingIOError:
            return True
    return False


def records_of(path: str | Path) -> Generator[Record]:
    """Whole records of a run file, the header first, read one by one; what is torn or damaged ends them. Raises
    ``InputError`` when the file is missing, is none of ours, or does not even hold a whole header."""
    path = Path(path)
    try:
        file = open_plain(path, "file of a run")
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file of a run") from None
    except OSError as problem:
        raise InputError(f"{path}: cannot be read: {(problem.strerror or str(problem)).lower()}") from problem
    try:
        yield from _records(path, file)
    finally:
        os.close(file)


def run_header(path: Path) -> Header:
    """What a run file states of its run. Raises ``InputError`` as ``records_of`` does."""
    with contextlib.closing(records_of(path)) as records:
        return Header(path, next(records).about)


def _records(path: Path, file: int) -> Generator[Record]:
    begin = system.read_at(file, len(SIGNATURE), 0)
    cut_off = f"{path}: the run was cut off before its start; run the scenario again"
    if begin != SIGNATURE:
        if begin[:_NAMED] == SIGNATURE[:_NAMED] and len(begin) == len(SIGNATURE):
            raise InputError(f"{path}: written by another version of wrsim, in a layout that this one does not read")
        raise InputError(cut_off if SIGNATURE.startswith(begin) else f"{path}: not the file of a run of wrsim")
    place, length = len(SIGNATURE), os.fstat(file).st_size
    while len(frame := system.read_at(file, FRAME.size, place)) == FRAME.size:
        size, checksum = FRAME.unpack(frame)
        content = system.read_at(file, size, place + FRAME.size) if size <= length - place else b""
        if not content or len(content) < size or zlib.crc32(content) != checksum:
            break
        place += FRAME.size + size
        about, _, numbers = content.partition(b"\n")
        if len(numbers) % 8:
            raise InputError(f"{path}: holds a record that no run writes ({about!r:.40}); run the scenario again")
        yield Record(about, np.frombuffer(numbers, dtype="<f8"), place)
    if place == len(SIGNATURE):
        raise InputError(cut_off)
