"""Where the samples of a run go: into memory, or into a file from which a run that died goes on.

The integrator hands over one row per sample. A ``Recorder`` writes them out whenever its block is full or
``FLUSH_INTERVAL`` has passed, together with a checkpoint: step number, state, and what the force law and the monitor
remember. Checkpoints lie between the segments of a run (``Integration``): a process that dies loses that much wall time
and one segment, and the memory that sampling needs does not grow with the run. What a run remembers when it stops
within a segment is kept as well, to be read; it goes on from the checkpoint before.

A run that goes on from a checkpoint computes the same numbers, to the bit, as one that was never interrupted: the
integrator's times are whole multiples of its step, it begins every segment anew (``BodySystem.solve``), its state is
complete, and whatever survives a call of the law or the monitor is kept (``Remembers``).
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from os import W_OK, access
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, TypeAdapter, ValidationError

from wrsim.errors import InputError
from wrsim.results.files import LARGE, plain_disk_errors
from wrsim.results.run_file import Header, Record, RunFile, records_of, run_header

Array = NDArray[np.float64]
Cause = Literal["", "monitor", "interrupt", "not-finite", "forces", "cut-off"]

FLUSH_INTERVAL = 0.5
"""Longest wall time between two flushes [s]."""

BLOCK = 256
"""Samples that wait in memory for the next flush, at most."""


@runtime_checkable
class Remembers(Protocol):
    """A force law or a monitor whose next answer depends on more than time and state."""

    def get_state(self) -> Array:
        """A copy of everything that it keeps from one call to the next, in one row."""

    def set_state(self, memory: Array) -> None:
        """Put it back."""


def states_of(things: Sequence[object]) -> Array:
    """What those that remember keep, one after the other, each behind its length."""
    rows = [thing.get_state() if isinstance(thing, Remembers) else np.zeros(0) for thing in things]
    return np.concatenate([part for row in rows for part in ([float(len(row))], row)])


def set_states(things: Sequence[object], memory: Array, name: str = "") -> None:
    """The opposite of ``states_of`` for the same things; name: of the file that it comes from, if any.

    Raises ``InputError`` for what these things cannot have remembered.
    """
    place = 0
    try:
        for thing in things:
            n = int(memory[place])
            if isinstance(thing, Remembers):
                thing.set_state(memory[place + 1 : place + 1 + n])
            place += 1 + n
    except (ValueError, IndexError, OverflowError):  # other lengths, and counts that are none
        why = "what it remembers does not fit its scenario; run the scenario again"
        raise InputError(f"{name or 'the checkpoint of the run'}: {why}") from None


@dataclass(frozen=True)
class Checkpoint:
    """All that a run needs to go on behind step ``step``: coordinates, rates, and memory (``states_of``)."""

    step: int
    q: Array
    q_t: Array
    memory: Array


@dataclass(frozen=True)
class Ending:
    """How a run ended: ``cause`` is empty when it reached its end."""

    cause: Cause
    reason: str


class Recorder:
    """Samples, rows (time, q, q_t), in memory; or in a file with checkpoints, see the module."""

    checkpoint: Checkpoint | None = None
    """Where to go on; None at the beginning of a run."""

    last: Checkpoint | None = None
    """What was remembered last, where the run goes on or not."""

    ending: Ending | None = None
    """Of a run that is over already."""

    def __init__(self, size: int, file: RunFile | None = None) -> None:
        """size: number of coordinates."""
        self.size, self.file = size, file
        self._block = np.zeros((BLOCK, 1 + 2 * size))
        self._used = 0
        self._kept: list[Array] = []
        self._flushed = time.perf_counter()

    @classmethod
    def create(cls, path: str | Path, header: dict[str, Any], size: int) -> Recorder:
        """Start the file of a new run; header: what the reader needs to know of it."""
        file = RunFile(path)
        file.begin(header | {"size": size})
        return cls(size, file)

    @classmethod
    def continued(cls, path: str | Path) -> Recorder:
        """Go on with a file: from its last checkpoint, or with nothing but its ``ending``.

        A run that the user has interrupted goes on. Raises ``InputError`` when there is nothing to go on from.
        """
        run_header(Path(path))  # a file that is not there, or none of a run's, is refused as for reading
        file = RunFile(path)
        try:  # read while nobody else can write
            recorded = RecordedRun.of(file.path, file.records())
            over = recorded.ending is not None and recorded.ending.cause != "interrupt"
            if recorded.checkpoint is None:
                raise InputError(f"{path}: the run was cut off before its start; run the scenario again")
            file.cut(recorded.end if over else recorded.checkpoint_end)
        except BaseException:
            file.close()
            raise
        recorder = cls(recorded.size, file)
        recorder.checkpoint, recorder.last = recorded.checkpoint, recorded.last
        recorder.ending = recorded.ending if over else None
        return recorder

    @property
    def name(self) -> str:
        """Of the file that holds it, if any."""
        return "" if self.file is None else str(self.file.path)

    def sample(self, t: float, q: Array, q_t: Array) -> None:
        """Keep one row."""
        if self._used == BLOCK:
            self.flush(None)
        row = self._block[self._used]
        row[0] = t
        row[1 : 1 + self.size] = q
        row[1 + self.size :] = q_t
        self._used += 1

    def due(self) -> bool:
        """True when the integrator should give a checkpoint to ``flush``."""
        full = self._used == BLOCK or time.perf_counter() - self._flushed >= FLUSH_INTERVAL
        return self.file is not None and full

    def flush(self, checkpoint: Checkpoint | None, goes_on: bool = True) -> None:
        """Put the waiting rows away, in a file with the checkpoint of the last step, if it is known, as one record.

        goes_on: whether a run may go on from it."""
        rows, self._flushed = self._block[: self._used], time.perf_counter()
        if self.file is None:
            self._kept.append(rows.copy())
        elif checkpoint is not None:
            about = {"rows": self._used, "step": checkpoint.step, "goes_on": goes_on}
            self.file.append(about, rows, checkpoint.q, checkpoint.q_t, checkpoint.memory)
        elif self._used:
            self.file.append({"rows": self._used}, rows)
        self._used = 0

    def end(self, ending: Ending) -> None:
        """The run is over."""
        self.flush(None)
        if self.file is not None:
            self.file.append(asdict(ending))

    def rows(self) -> Array:
        """All samples (n, 1 + 2 size)."""
        self.flush(None)
        if self.file is not None:
            return RecordedRun.of(self.file.path, self.file.records()).rows
        return np.concatenate(self._kept)

    def close(self) -> None:
        """Close the file; it stays."""
        if self.file is not None:
            self.file.close()


@dataclass(frozen=True)
class _Flush:
    """Head of a record of samples: how many rows it begins with, the step of the checkpoint behind them if there is
    one, and whether a run may go on from that."""

    rows: Annotated[int, Field(ge=0)]
    step: Annotated[int, Field(ge=0, lt=2**53)] | None = None
    goes_on: bool = False


_ABOUT: TypeAdapter[_Flush | Ending] = TypeAdapter(_Flush | Ending)


@dataclass(frozen=True)
class RecordedRun:
    """What a run file holds.

    rows (n, 1 + 2 size): samples; checkpoint: the last one from which the run may go on, its record ends at
    ``checkpoint_end``; last: the last one; ending: None when the process died first; end: of the last whole record.
    """

    header: dict[str, Any]
    size: int
    rows: Array
    checkpoint: Checkpoint | None
    checkpoint_end: int
    last: Checkpoint | None
    ending: Ending | None
    end: int

    @classmethod
    def read(cls, path: str | Path) -> RecordedRun:
        """Read a file as far as it is whole. Raises ``InputError`` when there is no such file, or none of a run."""
        with closing(records_of(path)) as records:
            return cls.of(Path(path), records)

    @classmethod
    def of(cls, path: Path, records: Iterator[Record]) -> RecordedRun:
        """From the records of a file. Many rows are mapped from a file without a name."""
        header = Header(path, next(records).about)
        size = header["size"]
        width = 1 + 2 * size
        checkpoint: Checkpoint | None = None
        last: Checkpoint | None = None
        ending: Ending | None = None
        checkpoint_end, end, time = 0, 0, -np.inf
        folder = str(path.parent) if access(path.parent, W_OK) else None
        with plain_disk_errors(path), tempfile.SpooledTemporaryFile(LARGE, dir=folder) as spool:
            for record in records:
                about, end = _about(path, record, width), record.end
                if isinstance(about, Ending):
                    ending = about
                    continue
                rows, state = np.split(record.numbers, [about.rows * width])
                times = np.append(time, rows[::width])
                finite = np.isfinite(rows).all() and np.isfinite(state[: 2 * size]).all()
                if not (finite and (np.diff(times) > 0.0).all()):
                    raise InputError(
                        f"{path}: holds samples that are not finite or do not follow each other in time; "
                        "run the scenario again"
                    )
                time = times[-1]
                spool.write(rows.tobytes())
                if about.step is not None:
                    last = Checkpoint(about.step, *(part.copy() for part in np.split(state, [size, 2 * size])))
                    if about.goes_on:
                        checkpoint, checkpoint_end = last, end
            all_rows = _array_of(spool).reshape(-1, width)
        return cls(header, size, all_rows, checkpoint, checkpoint_end, last, ending, end)


def _about(path: Path, record: Record, width: int) -> _Flush | Ending:
    """The head of a record, which fits the numbers that it holds."""
    count = record.numbers.size
    try:
        about = _ABOUT.validate_json(record.about, strict=True)
    except ValidationError:
        raise InputError(
            f"{path}: holds a record that no run writes ({record.about!r:.60}); run the scenario again"
        ) from None
    if isinstance(about, Ending):
        fits = count == 0
    else:
        beside = count - about.rows * width
        fits = beside == 0 if about.step is None else beside >= width - 1
    if not fits:
        raise InputError(f"{path}: a record of {count} numbers says {record.about!r:.60}; run the scenario again")
    return about


def _array_of(spool: tempfile.SpooledTemporaryFile[bytes]) -> Array:
    """All numbers of a file; many are mapped from it."""
    if spool.tell() > LARGE:
        spool.flush()
        return np.memmap(spool, np.float64, "c")  # type: ignore[call-overload]  # "c": kernels take arrays to write to
    spool.seek(0)
    return np.frombuffer(bytearray(spool.read()))
