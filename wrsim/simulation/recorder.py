"""Samples of a run, in memory or in a file from which a run that died continues.

A ``Recorder`` takes one row per sample and writes them whenever its block is full or ``FLUSH_INTERVAL`` has passed,
together with a checkpoint: step number, coordinates, and the states of force law and monitor. Checkpoints lie between
the segments of a run (``Integration``): a process that dies loses that much wall time and one segment. The states at a
stop within a segment are written as well, to be read; the run continues from the checkpoint before, with the same
numbers to the bit as one that was never interrupted, for all that lasts from call to call in law and monitor is in
their states (``HasState``).
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from os import W_OK, access
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol, runtime_checkable

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError

from wrsim.errors import InputError
from wrsim.results.files import LARGE, plain_disk_errors
from wrsim.results.run_file import Header, Record, RunFile, records_of, run_header
from wrsim.vehicle.elements import Array

Cause = Literal["", "monitor", "interrupt", "not-finite", "forces", "cut-off"]

FLUSH_INTERVAL = 0.5
"""Longest wall time between two flushes [s]."""

BLOCK = 256
"""Samples in memory between two flushes, at most."""


@runtime_checkable
class HasState(Protocol):
    """A force law or a monitor whose next result depends on more than time and coordinates."""

    def get_state(self) -> Array:
        """A copy of all that lasts from one call to the next, as one row."""

    def set_state(self, state: Array) -> None:
        """Restore it."""


def get_states(things: Sequence[object]) -> Array:
    """The states of all things that have one, one after the other, each behind its length."""
    rows = [thing.get_state() if isinstance(thing, HasState) else np.zeros(0) for thing in things]
    return np.concatenate([part for row in rows for part in ([float(len(row))], row)])


def set_states(things: Sequence[object], states: Array, name: str = "") -> None:
    """Restore what ``get_states`` gave for the same things; name: of its file, if any.

    Raises ``InputError`` for states that do not fit.
    """
    place = 0
    try:
        for thing in things:
            n = int(states[place])
            if isinstance(thing, HasState):
                thing.set_state(states[place + 1 : place + 1 + n])
            place += 1 + n
    except (ValueError, IndexError, OverflowError):  # other lengths, and counts that are none
        why = "its checkpoint does not fit its scenario; run the scenario again"
        raise InputError(f"{name or 'the run'}: {why}") from None


@dataclass(frozen=True)
class Checkpoint:
    """All that a run needs to continue after step ``step``: coordinates, rates, and states (``get_states``)."""

    step: int
    q: Array
    q_t: Array
    states: Array


@dataclass(frozen=True)
class Ending:
    """How a run ended: ``cause`` is empty when it reached its end."""

    cause: Cause
    reason: str


class Recorder:
    """Samples, rows (time, q, q_t), in memory; or in a file with checkpoints, see the module.

    checkpoint: where to continue, None at the beginning of a run; last: the last one, whether the run continues from it
    or not; ending: of a run that is over; listener: called with every sample.
    """

    checkpoint: Checkpoint | None = None
    last: Checkpoint | None = None
    ending: Ending | None = None
    listener: Callable[[float, Array, Array], None] | None = None

    def __init__(self, size: int, file: RunFile | None = None) -> None:
        """size: number of coordinates."""
        self.size, self.file = size, file
        self._block = np.zeros((BLOCK, 1 + 2 * size))
        self._used = 0
        self._flushed_rows: list[Array] = []
        self._flushed = time.perf_counter()

    @classmethod
    def create(cls, path: str | Path, header: dict[str, Any], size: int) -> Recorder:
        file = RunFile(path)
        file.begin(header | {"size": size})
        return cls(size, file)

    @classmethod
    def continued(cls, path: str | Path) -> Recorder:
        """Continue a file from its last checkpoint; of a run that is over, and was not interrupted, take its ending.

        Raises ``InputError`` without a checkpoint.
        """
        run_header(Path(path))  # a missing file, or one of another kind, is refused as for reading
        file = RunFile(path)
        try:  # read under its lock
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
        return "" if self.file is None else str(self.file.path)

    def sample(self, t: float, q: Array, q_t: Array) -> None:
        if self._used == BLOCK:
            self.flush(None)
        row = self._block[self._used]
        row[0] = t
        row[1 : 1 + self.size] = q
        row[1 + self.size :] = q_t
        self._used += 1
        if self.listener is not None:
            self.listener(t, q, q_t)

    def due(self) -> bool:
        """Whether it is time to ``flush`` with a checkpoint."""
        full = self._used == BLOCK or time.perf_counter() - self._flushed >= FLUSH_INTERVAL
        return self.file is not None and full

    def flush(self, checkpoint: Checkpoint | None, goes_on: bool = True) -> None:
        """Store the rows of the block, in a file as one record with a checkpoint; goes_on: whether a run may continue
        from it."""
        rows, self._flushed = self._block[: self._used], time.perf_counter()
        if self.file is None:
            self._flushed_rows.append(rows.copy())
        elif checkpoint is not None:
            about = {"rows": self._used, "step": checkpoint.step, "goes_on": goes_on}
            self.file.append(about, rows, checkpoint.q, checkpoint.q_t, checkpoint.states)
        elif self._used:
            self.file.append({"rows": self._used}, rows)
        self._used = 0

    def end(self, ending: Ending) -> None:
        self.flush(None)
        if self.file is not None:
            self.file.append(asdict(ending))

    def rows(self) -> Array:
        """All samples (n, 1 + 2 size)."""
        self.flush(None)
        if self.file is not None:
            return RecordedRun.of(self.file.path, self.file.records()).rows
        return np.concatenate(self._flushed_rows)

    def close(self) -> None:
        """Close the file; it stays."""
        if self.file is not None:
            self.file.close()


@dataclass(frozen=True)
class _Flush:
    """Head of a record of samples: number of rows, step of the checkpoint behind them, if any, and whether a run may
    continue from that."""

    rows: Annotated[int, Field(ge=0)]
    step: Annotated[int, Field(ge=0, lt=2**53)] | None = None
    goes_on: bool = False


_ABOUT: TypeAdapter[_Flush | Ending] = TypeAdapter(_Flush | Ending)


@dataclass(frozen=True)
class RecordedRun:
    """Contents of a run file.

    rows (n, 1 + 2 size): samples; checkpoint: the last one from which the run may continue, its record ends at
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
        """Read a file up to its last whole record. Raises ``InputError`` for a missing file, or one of another kind."""
        with closing(records_of(path)) as records:
            return cls.of(Path(path), records)

    @classmethod
    def of(cls, path: Path, records: Iterator[Record]) -> RecordedRun:
        """From the records of a file. Many rows are mapped from an unnamed file."""
        header = Header(path, next(records).about)
        size = header["size"]
        width = 1 + 2 * size
        checkpoint = last = ending = None
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
    """The head of a record. Raises InputError where it does not fit the numbers."""
    count = record.numbers.size
    try:
        about = _ABOUT.validate_json(record.about, strict=True)
    except ValidationError:
        why = f"holds a record that no run writes ({record.about!r:.60}); run the scenario again"
        raise InputError(f"{path}: {why}") from None
    if isinstance(about, Ending):
        fits = count == 0
    else:
        beside = count - about.rows * width
        fits = beside == 0 if about.step is None else beside >= width - 1
    if not fits:
        raise InputError(
            f"{path}: a record of {count} numbers has the head {record.about!r:.60}; run the scenario again"
        )
    return about


def _array_of(spool: tempfile.SpooledTemporaryFile[bytes]) -> Array:
    """All numbers of a file; many are mapped."""
    if spool.tell() > LARGE:
        spool.flush()
        return np.memmap(spool, np.float64, "c")  # type: ignore[call-overload]  # "c": kernels take arrays to write to
    spool.seek(0)
    return np.frombuffer(bytearray(spool.read()))
